"""One step of the social force model in plain NumPy, for floats or AutoDiff.

It gives the numbers of `kernel.py`, to rounding, over all pairs at once.
Arrays over pairs have a column for each person on whom a force acts, and a row
for each of its sources, so that sums run in the order of the rows.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.social_force.constants import (
    REPULSION_FLOOR,
    YAW_SPEED,
)
from hunav_drake.systems.crowd.social_force.numpy_forces import (
    Array,
    choose,
    direction,
    goal_force,
    obstacle_force,
    pair_force,
    values,
    wrap,
)
from hunav_drake.systems.people.parameters import PARAMETERS

# The number of pairs that are computed at once. Larger arrays would be fresh
# memory from the system each time, which costs more than the computation.
_PAIRS = 2**13


def social_forces(snapshot: Snapshot) -> Array:
    """Returns the forces (n, FORCES_SIZE) on n people, in m/s^2.

    The states, commands and robots of the snapshot are floats, or all three
    scalars with derivatives.
    """
    n = len(snapshot.states)
    width = n + len(snapshot.robots) + len(snapshot.obstacles.segments)
    step = max(_PAIRS // max(width, 1), 1)
    groups = _groups(snapshot)
    chunks = [
        _forces_on(slice(lo, lo + step), snapshot, groups)
        for lo in range(0, n, step)
    ]
    return np.concatenate(chunks) if chunks else np.zeros((0, FORCES_SIZE))


def advance(snapshot: Snapshot, forces: Array) -> Array:
    """Returns the states of n people one step later: see `kernel.advance`."""
    states, command = snapshot.states, snapshot.command
    time_step = snapshot.time_step
    moving = values(command[:, Command.HOLD]) == 0
    vx = choose(moving, states[:, VX] + forces[:, TOTAL_FORCE] * time_step, 0.0)
    vy = choose(
        moving, states[:, VY] + forces[:, TOTAL_FORCE + 1] * time_step, 0.0
    )
    speed, nx, ny = direction(vx, vy)
    cap = command[:, Command.MAX_SPEED]
    fast = speed > cap
    vx = np.where(fast, nx * cap, vx)
    vy = np.where(fast, ny * cap, vy)
    speed = np.where(fast, cap, speed)

    yaw = states[:, YAW]
    walks = speed >= YAW_SPEED
    heading = np.arctan2(choose(walks, vy, 0.0), choose(walks, vx, 1.0))
    turn = wrap(command[:, Command.YAW_TARGET] - yaw)
    most = command[:, Command.TURN_RATE] * time_step
    turned = wrap(yaw + np.minimum(np.maximum(turn, -most), most))
    next_yaw = np.where(
        values(command[:, Command.TURN_RATE]) > 0,
        turned,
        np.where(walks, heading, yaw),
    )
    return np.stack(
        [
            states[:, X] + vx * time_step,
            states[:, Y] + vy * time_step,
            next_yaw,
            vx,
            vy,
            wrap(next_yaw - yaw) / time_step,
        ],
        axis=-1,
    )


def _forces_on(who: slice, snapshot: Snapshot, groups: Array) -> Array:
    """Returns the forces on some of the people."""
    me = _Person(who, snapshot)
    command = me.command
    walks = values(command[:, Command.HAS_GOAL]) != 0
    goal, (ex, ey) = goal_force(
        command[:, Command.GOAL_X] - me.x,
        command[:, Command.GOAL_Y] - me.y,
        (me.vx, me.vy),
        command[:, Command.DESIRED_SPEED],
        np.where(walks, values(command[:, Command.GOAL_RADIUS]), np.inf),
        me.k,
    )
    wall = _walls(me, snapshot)
    social = _people(me, snapshot)
    if len(snapshot.robots):
        obstacle, push = _robots(me, snapshot.robots)
        wall = wall[0] + obstacle[0], wall[1] + obstacle[1]
    else:
        push = (me.x * 0.0, me.y * 0.0)
    gaze, coherence, repulsion = _group(
        me, ex, ey, snapshot, groups[:, who], who
    )
    total = [
        goal[c]
        + social[c]
        + wall[c]
        + (gaze[c] + coherence[c] + repulsion[c])
        + push[c]
        for c in range(2)
    ]
    parts = [goal, wall, social, gaze, coherence, repulsion, push, total]
    return np.stack([part[c] for part in parts for c in range(2)], axis=-1)


class _Person:
    """The people on whom the forces act, each quantity of shape (k,)."""

    def __init__(self, who: slice, snapshot: Snapshot) -> None:
        states = snapshot.states[who]
        self.x, self.y = states[:, X], states[:, Y]
        self.vx, self.vy = states[:, VX], states[:, VY]
        self.radius = snapshot.radii[who]
        self.at_walls = snapshot.at_walls[who]
        self.command = snapshot.command[who]
        self.k = SimpleNamespace(
            **dict(zip(PARAMETERS, snapshot.parameters[who].T, strict=True))
        )


def _people(me: _Person, snapshot: Snapshot) -> tuple[Array, Array]:
    """Returns the sum over people and robots that count as people."""
    others = snapshot.states[:, [X, Y, VX, VY]]
    strength = np.broadcast_to(me.k.social_factor, (len(others), len(me.x)))
    if len(snapshot.robots):
        others = np.concatenate([others, snapshot.robots[:, [X, Y, VX, VY]]])
        role = values(me.command[:, Command.ROBOT_ROLE])
        seen = np.where(role == RobotRole.PEDESTRIAN, me.k.social_factor, 0.0)
        strength = np.concatenate(
            [strength, np.tile(seen, (len(snapshot.robots), 1))]
        )
    x, y, vx, vy = others.T[:, :, None]
    # The distance to oneself is zero, and so is that force.
    fx, fy = pair_force(
        x - me.x,
        y - me.y,
        me.vx - vx,
        me.vy - vy,
        SimpleNamespace(**{**vars(me.k), "social_factor": strength}),
    )
    return fx.sum(axis=0), fy.sum(axis=0)


def _walls(me: _Person, snapshot: Snapshot) -> tuple[Array, Array]:
    segments, first = snapshot.obstacles.segments, snapshot.obstacles.first
    shapes = first[:-1][first[1:] > first[:-1]]
    if not len(shapes):
        return me.x * 0.0, me.y * 0.0
    # The near segments are found with plain numbers; then only the distances to
    # those are computed, with their derivatives.
    d2 = _offsets(values(me.x), values(me.y), segments[:, None, :])[2]
    nearest = np.minimum.reduceat(d2, shapes)
    rows = np.arange(len(segments))[:, None]
    sizes = np.diff([*shapes, len(segments)])
    at_nearest = d2 == np.repeat(nearest, sizes, axis=0)
    index = np.minimum.reduceat(
        np.where(at_nearest, rows, len(segments)), shapes
    )
    if snapshot.max_obstacles:
        order = np.argsort(nearest, axis=0, kind="stable")
        order = order[: snapshot.max_obstacles]
        nearest = np.take_along_axis(nearest, order, axis=0)
        index = np.take_along_axis(index, order, axis=0)
    felt = nearest <= snapshot.obstacle_range * snapshot.obstacle_range
    somebody = felt.any(axis=1)
    dx, dy, _ = _offsets(me.x, me.y, segments[index[somebody]])
    radius, factor = me.at_walls.T
    fx, fy = obstacle_force(
        *(dx, dy, radius),
        SimpleNamespace(**{**vars(me.k), "obstacle_factor": factor}),
    )
    felt = felt[somebody]
    return (
        me.x * 0.0 + choose(felt, fx, 0.0).sum(axis=0),
        me.y * 0.0 + choose(felt, fy, 0.0).sum(axis=0),
    )


def _offsets(x: Array, y: Array, segments: Array) -> tuple[Array, Array, Array]:
    """Returns the offsets of points from segments, and the squared distance."""
    sx, sy = segments[..., 0], segments[..., 1]
    ax, ay = segments[..., 2] - sx, segments[..., 3] - sy
    length2 = ax * ax + ay * ay
    t = ((x - sx) * ax + (y - sy) * ay) / np.where(length2 > 0, length2, 1.0)
    t = np.minimum(np.maximum(t, 0.0), 1.0)
    dx, dy = x - (sx + t * ax), y - (sy + t * ay)
    return dx, dy, dx * dx + dy * dy


def _robots(me: _Person, robots: Array) -> tuple[Any, Any]:
    """Returns the forces of robots that are obstacles, and the extra push."""
    x, y = robots.T[[X, Y], :, None]
    distance, nx, ny = direction(me.x - x, me.y - y)
    role = values(me.command[:, Command.ROBOT_ROLE])
    is_obstacle = np.where(role == RobotRole.OBSTACLE, 1.0, 0.0)
    force = obstacle_force(me.x - x, me.y - y, me.radius, me.k)
    obstacle = [(f * is_obstacle).sum(axis=0) for f in force]

    # People on the very center of a robot are not pushed.
    known = values(distance)
    index = np.argmin(np.where(known > 0, known, np.inf), axis=0)
    column = np.arange(len(me.x))
    gap = distance[index, column] - me.radius
    gain = me.command[:, Command.ROBOT_REPULSION]
    push = gain / choose(gap >= REPULSION_FLOOR, gap, REPULSION_FLOOR)
    return obstacle, [push * nx[index, column], push * ny[index, column]]


def _groups(snapshot: Snapshot) -> Array:
    """Returns the size and the center (x, y) of each group, shape (3, n)."""
    group = values(snapshot.command[:, Command.GROUP_ID])
    # Everyone who walks alone has a number below those of the groups.
    alone = -1.0 - np.arange(len(group))
    _, index, sizes = np.unique(
        np.where(group < 0, alone, group),
        return_inverse=True,
        return_counts=True,
    )
    center = np.zeros((len(sizes), 2), dtype=snapshot.states.dtype)
    np.add.at(center, index, snapshot.states[:, :2])
    size = sizes[index]
    return np.stack([size, *(center[index] / size[:, None]).T])


def _group(
    me: _Person,
    ex: Array,
    ey: Array,
    snapshot: Snapshot,
    groups: Array,
    who: slice,
) -> tuple[Any, Any, Any]:
    """Returns the forces of gaze, coherence and repulsion in groups."""
    size = groups[0].astype(float)
    cx, cy = groups[1], groups[2]
    together = np.where(size > 1, 1.0, 0.0)
    others = 1.0 / np.maximum(size - 1.0, 1.0)
    dx = others * (size * cx - me.x) - me.x
    dy = others * (size * cy - me.y) - me.y
    along = ex * dx + ey * dy
    square = ex * ex + ey * ey
    behind = along < 0
    back = choose(behind, along, 0.0) / choose(behind, square, 1.0)
    factor = me.k.group_gaze_factor * together
    gaze = [back * ex * factor, back * ey * factor]

    dx, dy = cx - me.x, cy - me.y
    distance, _, _ = direction(dx, dy)
    softened = np.tanh(distance - (size - 1.0) / 2) + 1.0
    factor = me.k.group_coherence_factor * together * softened / 2
    coherence = [dx * factor, dy * factor]

    group = values(snapshot.command[:, Command.GROUP_ID])
    near = (group[:, None] == group[who]) & (size > 1)
    x, y = snapshot.states[:, X, None], snapshot.states[:, Y, None]
    dx, dy = me.x - x, me.y - y
    reach = me.radius + snapshot.radii[:, None]
    near &= np.sqrt(values(dx) ** 2 + values(dy) ** 2) < reach
    repulsion = [
        choose(near, d, 0.0).sum(axis=0) * me.k.group_repulsion_factor
        for d in (dx, dy)
    ]
    return gaze, coherence, repulsion
