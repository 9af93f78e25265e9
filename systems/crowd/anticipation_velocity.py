"""The anticipation velocity model: people avoid where others will be.

Xu, Chraibi & Seyfried 2021, "Anticipation in a velocity-based model for
pedestrian dynamics", Transportation Research Part C 133.
"""

import math
from typing import Annotated

from numba import float64
import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
    reads,
)
from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    TOTAL_FORCE,
    VX,
    VY,
    Command,
    X,
    Y,
)
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.crowd.advance import chosen_accelerations
from hunav_drake.systems.crowd.collision_free_speed import LEAST, repulsion
from hunav_drake.systems.crowd.motion_model import (
    Array,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.orca.neighbors import make_cells
from hunav_drake.systems.crowd.speed_models import (
    Share,
    SpeedModel,
    Time,
    direction_of,
    walk_on,
)
from hunav_drake.systems.crowd.surroundings import (
    AT_X,
    AT_Y,
    THEIR_VX,
    THEIR_VY,
    TINY,
    TOUCH,
    WISH_X,
    WISH_Y,
    look_around,
    wishes,
)
from hunav_drake.systems.world.walls import opened


@jit
def _aside(rows, state, wx, wy, wish, p):
    """Returns how far people step to the right for others, or the left.

    Args:
        rows: What a person sees: see `look_around`.
        state: That of the person.
        wx: The x of the direction wanted, of length one.
        wy: Its y.
        wish: The speed wanted, in m/s.
        p: The fields of AnticipationVelocityModel.

    Returns:
        The sum over the others, in lengths of the direction wanted.
    """
    total = 0.0
    ex, ey = direction_of(state, wx, wy)
    for a in range(len(rows)):
        row = rows[a]
        distance = math.hypot(row[AT_X], row[AT_Y])
        if distance < TINY:
            continue
        nx = row[AT_X] / distance
        ny = row[AT_Y] / distance
        if wx * nx + wy * ny < 0 and ex * nx + ey * ny < 0:
            continue
        closing = (state[VX] - row[THEIR_VX]) * nx
        closing += (state[VY] - row[THEIR_VY]) * ny
        gap = distance - row[TOUCH]
        left = max(gap - p.anticipation_time * closing, 0.0)
        # Who is held up looks ahead as at the speed wanted.
        closing = wish * (wx * nx + wy * ny)
        closing -= row[THEIR_VX] * nx + row[THEIR_VY] * ny
        held = max(gap - p.anticipation_time * closing, 0.0)
        # 0 for who wants to go the same way, 1 for who wants the opposite.
        along = wx * row[WISH_X] + wy * row[WISH_Y]
        against = min(max(0.5 - 0.5 * along / wish, 0.0), 1.0)
        against = max(against - p.same_way, 0.0) / (1 - p.same_way)
        # 1 for who wants to be much slower, on much the same way.
        slower = 1 - math.hypot(row[WISH_X], row[WISH_Y]) / wish
        slower = min(p.overtaking * max(slower, 0.0), 1.0) * (1 - against)
        beside = 0.0
        qx = row[AT_X] + p.anticipation_time * row[THEIR_VX]
        qy = row[AT_Y] + p.anticipation_time * row[THEIR_VY]
        side = wx * qy - wy * qx
        if p.side_reach > 0:
            beside = max(abs(side) - p.side_reach * row[TOUCH], 0.0)
        side += against * p.keep_right
        if p.side_width > 0:
            side = min(max(side / p.side_width, -1.0), 1.0)
        else:
            side = -1.0 if side < -TINY else 1.0
        weight = (p.following + against) * math.exp(-left / p.avoidance_range)
        weight += slower * math.exp(-held / p.avoidance_range)
        total += side * weight * math.exp(-beside / p.avoidance_range)
    return p.avoidance_strength * total


@jit_as(
    float64[:, ::1],
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, WALLS),
    *(REAL, REAL, VECTOR),
)
def anticipated_velocities(
    states,
    radii,
    command,
    parameters,
    robots,
    at_walls,
    table,
    sight,
    step,
    model,
):
    """Returns the accelerations to the velocities that n people choose.

    Args:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega.
        radii: Shape (n,), in meters.
        command: Shape (n, COMMAND_SIZE).
        parameters: Shape (n, 13): the fields of SocialForceParameters.
        robots: Shape (m, 7): rows of `robot_states`.
        at_walls: Shape (n, 2): see `Snapshot`; the radii count.
        table: `Obstacles.table`.
        sight: Walls farther than this do not count, in meters.
        step: The time step, in seconds.
        model: Shape (17,): the fields of AnticipationVelocityModel.

    Returns:
        Shape (n, FORCES_SIZE), in m/s^2: the total, and zeros.
    """
    p = _model_in(model)
    walls = opened(table)
    n = len(states)
    forces = np.zeros((n, FORCES_SIZE))
    if n == 0:
        return forces
    wanted = wishes(states, radii, command, parameters, robots, step)
    cells = make_cells(states[:, X].copy(), states[:, Y].copy())
    rows = np.empty((n + len(robots), 7))
    body = p.body_radius
    fastest = 0.0
    for i in range(n):
        fastest = max(fastest, math.hypot(states[i, VX], states[i, VY]))
    for i in range(n):
        vx = states[i, VX]
        vy = states[i, VY]
        if command[i, Command.HOLD] != 0:
            forces[i, TOTAL_FORCE] = -vx / step
            forces[i, TOTAL_FORCE + 1] = -vy / step
            continue
        wish = math.hypot(wanted[i, 0], wanted[i, 1])
        speed = math.hypot(vx, vy)
        ahead = (
            p.anticipation_time * (max(speed, wish) + fastest)
            - LEAST * p.avoidance_range
        )
        reach = 2 * body + max(p.time_gap * max(wish, speed), ahead)
        seen = look_around(
            *(i, states, radii, command, robots, wanted, cells, body, reach),
            rows,
        )
        ux = 0.0
        uy = 0.0
        if wish > 0:
            wx = wanted[i, 0] / wish
            wy = wanted[i, 1] / wish
            right = _aside(rows[:seen], states[i], wx, wy, wish, p)
            ux, uy = repulsion(
                rows[:seen], p.repulsion_strength, p.avoidance_range, 0.0
            )
            ux += wx + right * wy
            uy += wy - right * wx
        walk_on(
            *(states[i], command[i], wish, ux, uy, rows[:seen]),
            *(min(at_walls[i, 0], body), walls, sight, step, p, forces[i]),
        )
    return forces


@register_motion_model("anticipation_velocity")
@dataclass(kw_only=True, config=CONFIG)
class AnticipationVelocityModel(SpeedModel):
    """People step aside for where others will be, and walk as the gap allows.

    Xu, Chraibi & Seyfried 2021. To the direction wanted e0, of length one,
    each person j who is ahead adds a vector to the right, or to the left if j
    will be on the right, after the time t_a of anticipation. Its length is

        alpha (1 + (1 - e0 . e_j) / 2) exp(-d / D),

    d what is left of the gap to j after t_a at the present velocities, and e_j
    the direction of j. The speed is that of `CollisionFreeSpeedModel`.

    As published, people in a dense crowd swing from side to side, clog doors
    and jam where two streams meet. What differs here, each with the value
    that gives the published form:

    - how far sideways j will be counts, not only on which side
      (`side_width` 0, `side_reach` 0);
    - who comes the other way is passed on the right (`keep_right` 0);
    - people do not step aside for those who walk as they do (`following` 1,
      `same_way` 0), but turn away from those very near (`repulsion_strength`
      0), as in the collision-free speed model;
    - instead of e_j, the velocity that j would like to have counts, by the
      speed wanted, so that who stands in a queue is none who comes the other
      way;
    - who wants to be slower is overtaken, by people who look ahead as at the
      speed that they want: behind that one, they have no other (`overtaking`
      0, with which only `following` makes people overtake);
    - the reaction time is shorter (`reaction_time` 0.3, `hesitation` 0).

    Robots count as people do, but with the whole radii; one in the role of an
    obstacle is taken for standing. Walls take from the velocity what leads
    into them.
    """

    reaction_time: Time = 0.05
    """The time in which somebody who walks turns to a new direction (tau), in
    seconds; published: 0.3."""

    avoidance_strength: Share = 8.0
    """How strongly people step aside for somebody whom they would touch
    (alpha); published for JuPedSim 1.4."""

    avoidance_range: Annotated[StrictFloat, within(1e-3, 10, "m")] = 0.1
    """The distance in which that falls to 1/e (D), in meters."""

    anticipation_time: Time = 1.0
    """How far people look ahead (t_a), in seconds."""

    following: Share = 0.0
    """The share of it for those who walk the same way; published: 1."""

    repulsion_strength: Share = 5.0
    """How strongly somebody who is touched turns people away; published: 0."""

    keep_right: Annotated[StrictFloat, within(-10, 10, "m")] = 0.3
    """Others who come the other way are taken to be this much farther to the
    left, in meters; with a negative one, to the right. Published: 0."""

    side_width: Annotated[StrictFloat, within(0, 10, "m")] = 0.2
    """Who will be less to the side than this is avoided less, in meters;
    published: 0."""

    side_reach: Share = 1.0
    """Who will be farther to the side than this, in distances at which bodies
    touch, is avoided less; 0 is no limit, and published."""

    same_way: Annotated[StrictFloat, within(0, 0.9)] = 0.15
    """Others walk the same way if (1 - e0 . e_j) / 2 is less than this: 0.15 is
    for 45 degrees. Published: 0."""

    overtaking: Share = 5.0
    """How readily people overtake: the share of stepping aside for somebody on
    the same way who wants to be slower, by the part of the own speed by which
    that one is slower, and at most 1. Published: 0."""

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the accelerations, as totals: see `MotionModel.forces`."""
        return chosen_accelerations(anticipated_velocities, snapshot, self)


_model_in = reads(AnticipationVelocityModel)
