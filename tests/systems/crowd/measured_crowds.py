"""Crowds of which figures are known, and how they are measured."""

import dataclasses
import math

import numpy as np

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.crowd.walls.keep_out import keep_out_of_walls, wall_margins
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import Box, World

RADIUS = 0.2
SPEED = 1.34
TIME_STEP = 0.05
WEIGHTS = dataclasses.astuple(SocialForceParameters())


def weidmann(density):
    """Returns the speeds of Weidmann 1993 at densities, in m/s."""
    return 1.34 * (1 - np.exp(-1.913 * (1 / np.asarray(density) - 1 / 5.4)))


def commands(goals, speed=SPEED):
    goals = np.reshape(goals, (-1, 2))
    command = np.zeros((len(goals), COMMAND_SIZE))
    command[:, :2] = goals
    command[:, Command.GOAL_RADIUS] = 0.3
    command[:, Command.HAS_GOAL] = 1
    command[:, Command.DESIRED_SPEED] = speed
    command[:, Command.MAX_SPEED] = np.maximum(speed, 1.0) * 1.3
    command[:, Command.GROUP_ID] = -1
    return command


def places(n, x0, y0, x1, y1, seed=0):
    """Returns n places (n, 2) in a rectangle, on a grid with some disorder."""
    rng = np.random.default_rng(seed)
    columns = max(1, round(math.sqrt(n * (x1 - x0) / (y1 - y0))))
    rows = math.ceil(n / columns)
    dx = (x1 - x0) / columns
    dy = (y1 - y0) / rows
    cell = rng.permutation(columns * rows)[:n]
    grid = np.stack([cell % columns, cell // columns], axis=1) + 0.5
    free = np.maximum(np.array([dx, dy]) - 2 * RADIUS, 0) / 2
    jitter = rng.uniform(-1, 1, (n, 2)) * np.minimum(free, 0.3)
    return [x0, y0] + grid * [dx, dy] + jitter


LENGTH, WIDTH = 15.0, 5.0
SEEN = 5.0


def ring_speed(model, density, *, seed=0, warm=20.0, time=30.0, trace=None):
    """Returns the mean speed along a corridor that closes on itself."""
    n = round(density * LENGTH * WIDTH)
    wall = [[[-9e3, y], [9e3, y]] for y in (0.0, WIDTH)]
    obstacles = Obstacles.from_shapes(wall, solid=[False, False])
    states = np.zeros((n, 6))
    states[:, :2] = places(n, 0, 0.2, LENGTH, WIDTH - 0.2, seed)
    states[:, 3] = weidmann(density)
    margins = None
    total = 0.0
    for step in range(round((warm + time) / TIME_STEP)):
        left = states[states[:, 0] > LENGTH - SEEN] - [LENGTH, 0, 0, 0, 0, 0]
        right = states[states[:, 0] < SEEN] + [LENGTH, 0, 0, 0, 0, 0]
        rows = np.concatenate([states, left, right])
        m = len(rows)
        snapshot = Snapshot(
            states=rows,
            radii=np.full(m, RADIUS),
            command=commands(rows[:, :2] + [100.0, 0.0]),
            parameters=np.tile(WEIGHTS, (m, 1)),
            robots=np.zeros((0, 7)),
            obstacles=obstacles,
            obstacle_range=5.0,
            max_obstacles=0,
            time_step=TIME_STEP,
        )
        after = model.advance(snapshot, model.forces(snapshot))
        after = keep_out_of_walls(
            rows, after, wall_margins(snapshot.radii), obstacles.table
        )[:n]
        if step * TIME_STEP >= warm:
            total += np.mean(after[:, 0] - states[:, 0])
        if trace is not None:
            trace.append(after.copy())
        states = after
        states[:, 0] %= LENGTH
    return total / time


def walk(model, humans_xy, goals, walls, *, duration, until, speed=SPEED,
         radius=RADIUS, yaw=None):
    """Yields states (n, 6) after each step."""
    n = len(humans_xy)
    humans = [
        HumanConfig(pose=(x, y, 0.0), radius=radius) for x, y in humans_xy
    ]
    step = CrowdStep(
        humans,
        obstacles=World(walls=list(walls)).obstacles(),
        config=CrowdConfig(model=model),
        time_step=TIME_STEP,
    )
    states = np.zeros((n, 6))
    states[:, :2] = humans_xy
    aim = np.asarray(goals) - states[:, :2]
    states[:, 2] = np.arctan2(aim[:, 1], aim[:, 0])
    command = commands(goals, speed)
    weights = np.tile(WEIGHTS, (n, 1))
    robots = np.zeros((0, 7))
    history = [states]
    for _ in range(round(duration / TIME_STEP)):
        states.setflags(write=False)
        snapshot = step.look(states, command, robots, weights)
        states = np.array(step.advance(snapshot, step.forces(snapshot)))
        history.append(states)
        if until(states):
            break
    return np.array(history)


def wall(x0, y0, x1, y1):
    return Box(
        center=((x0 + x1) / 2, (y0 + y1) / 2),
        size=(abs(x1 - x0), abs(y1 - y0)),
    )


def door(width, half=5.0):
    return [
        wall(-0.1, width / 2, 0.1, half + 0.2),
        wall(-0.1, -half - 0.2, 0.1, -width / 2),
        wall(-10, half, 0.1, half + 0.2),
        wall(-10, -half - 0.2, 0.1, -half),
    ]


def door_flow(model, width, *, n=120, seed=0, duration=200.0, full=False):
    """Returns the flow per meter of a door, and how many stay behind."""
    start = places(n, -7.0, -4.0, -0.6, 4.0, seed)
    goals = np.column_stack([np.full(n, 30.0), 0.3 * start[:, 1]])
    h = walk(
        model, start, goals, door(width), duration=duration,
        until=lambda s: (s[:, 0] > 0).all(),
    )
    out = (h[:, :, 0] > 0).any(axis=0)
    times = np.sort(np.argmax(h[:, :, 0] > 0, axis=0)[out]) * TIME_STEP
    lo, hi = 20, min(len(times), n - 20) - 1
    flow = (hi - lo) / (times[hi] - times[lo]) / width if hi > lo else 0.0
    if full:
        return flow, n - len(times), h
    return flow, n - len(times)


def head_on(model, width, *, offset=0.0, duration=40.0, radius=RADIUS):
    """Returns the time in which two change sides, and the least distance."""
    walls = [
        wall(-9, width / 2, 9, width / 2 + 0.2),
        wall(-9, -width / 2 - 0.2, 9, -width / 2),
    ]
    start = np.array([[-6.0, 0.0], [6.0, offset]])
    goals = np.array([[7.0, 0.0], [-7.0, 0.0]])
    h = walk(
        model, start, goals, walls, duration=duration, radius=radius,
        until=lambda s: s[0, 0] > 6 and s[1, 0] < -6,
    )
    apart = np.linalg.norm(h[:, 0, :2] - h[:, 1, :2], axis=1).min()
    done = h[-1, 0, 0] > 6 and h[-1, 1, 0] < -6
    return (len(h) - 1) * TIME_STEP if done else math.inf, apart, h


def counterflow(model, n, m, *, duration=300.0, seed=0):
    """NIST 2.8: two rooms of 10 x 10 m joined by a corridor of 10 x 2 m."""
    walls = [
        wall(-5, 1, 5, 1.2), wall(-5, -1.2, 5, -1),
        wall(-5.2, 1, -5, 5), wall(-5.2, -5, -5, -1),
        wall(5, 1, 5.2, 5), wall(5, -5, 5.2, -1),
        wall(-15, 5, -5, 5.2), wall(-15, -5.2, -5, -5),
        wall(5, 5, 15, 5.2), wall(5, -5.2, 15, -5),
        wall(-15.2, -5.2, -15, 5.2), wall(15, -5.2, 15.2, 5.2),
    ]
    a = places(n, -14.5, -4.5, -6.0, 4.5, seed)
    b = -places(m, -14.5, -4.5, -6.0, 4.5, seed + 1) if m else np.zeros((0, 2))
    start = np.concatenate([a, b])
    # The far end of the other room, each at a height of their own.
    goals = np.column_stack([-np.sign(start[:, 0]) * 14.0, 0.95 * start[:, 1]])
    side = np.sign(goals[:, 0])
    h = walk(
        model, start, goals, walls, duration=duration,
        until=lambda s: (s[:, 0] * side > 5.5).all(),
    )
    done = h[-1][:, 0] * side > 5.5
    return (len(h) - 1) * TIME_STEP if done.all() else math.inf, int((~done).sum()), h
