"""The anticipation velocity model: people avoid predicted positions.

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
    REAL,
    SNAPSHOT,
    VECTOR,
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
    """Returns the sidestep of a person for others: right, or negative left.

    `rows` are the surroundings of the person (see `look_around`), (wx, wy) is
    the desired direction, a unit vector, `wish` the desired speed, in m/s, and
    `p` has the fields of AnticipationVelocityModel. The result is the sum over
    the others, in lengths of the desired direction.
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
        # A person who is held up looks ahead as at the desired speed.
        closing = wish * (wx * nx + wy * ny)
        closing -= row[THEIR_VX] * nx + row[THEIR_VY] * ny
        held = max(gap - p.anticipation_time * closing, 0.0)
        # 0 for others with the same desired direction, 1 for the opposite.
        along = wx * row[WISH_X] + wy * row[WISH_Y]
        against = min(max(0.5 - 0.5 * along / wish, 0.0), 1.0)
        against = max(against - p.same_way, 0.0) / (1 - p.same_way)
        # 1 for others with a much lower desired speed on a similar way.
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


@jit_as(float64[:, ::1], *SNAPSHOT, REAL, VECTOR)
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

    The arguments are those of a kernel of `chosen_accelerations`; walls beyond
    `sight` have no effect; `model` (17,) has the fields of
    AnticipationVelocityModel.
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
    """People avoid predicted positions; the gap ahead limits their speed.

    Xu, Chraibi & Seyfried 2021. To the desired direction e0, a unit vector,
    each person j ahead adds a vector to the right, or to the left if j will be
    on the right after the anticipation time t_a. Its length is

        alpha (1 + (1 - e0 . e_j) / 2) exp(-d / D),

    with the gap d to j that is left after t_a at the present velocities, and
    the direction e_j of j. The speed is that of `CollisionFreeSpeedModel`.

    As published, people in a dense crowd swing from side to side, clog doors
    and jam where two streams meet. The differences here, each with the value
    that gives the published form:

    - the predicted lateral offset of j counts, not only its side
      (`side_width` 0, `side_reach` 0);
    - oncoming people are passed on the right (`keep_right` 0);
    - people do not step aside for others who walk in their direction
      (`following` 1, `same_way` 0), but turn away from those very near
      (`repulsion_strength` 0), as in the collision-free speed model;
    - instead of e_j, the desired velocity of j counts, relative to the desired
      speed, so that a person who stands in a queue is not oncoming;
    - people with a lower desired speed are overtaken: those behind look ahead
      as at their own desired speed, which they do not have there (`overtaking`
      0, with which only `following` makes people overtake);
    - the reaction time is shorter (`reaction_time` 0.3, `hesitation` 0).

    Robots count like people, but with their whole radii; a robot in the role
    of an obstacle counts as standing. Walls remove the part of the velocity
    that leads into them.
    """

    reaction_time: Time = 0.05
    """Time constant with which a walking person turns to a new direction (tau),
    in seconds; published: 0.3."""

    avoidance_strength: Share = 8.0
    """Strength of stepping aside for a person at touching distance (alpha);
    published for JuPedSim 1.4."""

    avoidance_range: Annotated[StrictFloat, within(1e-3, 10, "m")] = 0.1
    """Distance over which it decays to 1/e (D), in meters."""

    anticipation_time: Time = 1.0
    """Time horizon of the anticipation (t_a), in seconds."""

    following: Share = 0.0
    """Share of it for people who walk in the same direction; published: 1."""

    repulsion_strength: Share = 5.0
    """Strength of turning away at touching distance; published: 0."""

    keep_right: Annotated[StrictFloat, within(-10, 10, "m")] = 0.3
    """Distance by which oncoming people count as farther to the left, in
    meters; if negative, to the right. Published: 0."""

    side_width: Annotated[StrictFloat, within(0, 10, "m")] = 0.2
    """Predicted lateral offset below which others are avoided less, in meters;
    published: 0."""

    side_reach: Share = 1.0
    """Predicted lateral offset beyond which others are avoided less, in
    distances at which bodies touch; 0 is no limit, as published."""

    same_way: Annotated[StrictFloat, within(0, 0.9)] = 0.15
    """Others walk in the same direction if (1 - e0 . e_j) / 2 is less than
    this: 0.15 corresponds to 45 degrees. Published: 0."""

    overtaking: Share = 5.0
    """Strength of overtaking: the share of stepping aside for a slower person
    on the same way, per fraction of the own desired speed by which that person
    is slower, and at most 1. Published: 0."""

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the accelerations, as totals: see `MotionModel.forces`."""
        return chosen_accelerations(anticipated_velocities, snapshot, self)


_model_in = reads(AnticipationVelocityModel)
