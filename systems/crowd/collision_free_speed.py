"""The collision-free speed model: the gap ahead limits the walking speed.

Tordeux, Chraibi & Seyfried 2016, "Collision-free speed model for pedestrian
dynamics", Traffic and Granular Flow '15.
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
from hunav_drake.systems.crowd.motion_model import (
    Array,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.orca.neighbors import make_cells
from hunav_drake.systems.crowd.speed_models import Share, SpeedModel, walk_on
from hunav_drake.systems.crowd.surroundings import (
    AT_X,
    AT_Y,
    TINY,
    TOUCH,
    look_around,
    wishes,
)
from hunav_drake.systems.world.walls import opened

# The largest exponent of repulsion, and the one below which it is neglected:
# 1e-6 of the strength.
MOST, LEAST = 3.0, -14.0


@jit
def repulsion(rows, strength, length, epsilon):
    """Returns the sum of the directions away from others, by their strength.

    `rows` are the surroundings of a person: see `look_around`. The strength is
    that at touching distance (a), and decays to 1/e over the length (D), in
    meters. Others seem displaced by `epsilon` to the left, in radians.
    """
    c = math.cos(epsilon)
    s = math.sin(epsilon)
    ux = 0.0
    uy = 0.0
    for a in range(len(rows)):
        dx = rows[a, AT_X]
        dy = rows[a, AT_Y]
        distance = math.hypot(dx, dy)
        exponent = (rows[a, TOUCH] - distance) / length
        if distance < TINY or exponent < LEAST:
            continue
        push = strength * math.exp(min(exponent, MOST)) / distance
        ux -= push * (c * dx - s * dy)
        uy -= push * (s * dx + c * dy)
    return ux, uy


@jit_as(float64[:, ::1], *SNAPSHOT, REAL, VECTOR)
def collision_free_speeds(
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
    `sight` have no effect; `model` (10,) has the fields of
    CollisionFreeSpeedModel.
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
    for i in range(n):
        vx = states[i, VX]
        vy = states[i, VY]
        if command[i, Command.HOLD] != 0:
            forces[i, TOTAL_FORCE] = -vx / step
            forces[i, TOTAL_FORCE + 1] = -vy / step
            continue
        wish = math.hypot(wanted[i, 0], wanted[i, 1])
        speed = max(wish, math.hypot(vx, vy))
        reach = 2 * body + max(p.time_gap * speed, -LEAST * p.repulsion_range)
        seen = look_around(
            *(i, states, radii, command, robots, wanted, cells, body, reach),
            rows,
        )
        ux = 0.0
        uy = 0.0
        if wish > 0:
            ux, uy = repulsion(
                rows[:seen], p.repulsion_strength, p.repulsion_range, p.epsilon
            )
            ux += wanted[i, 0] / wish
            uy += wanted[i, 1] / wish
        walk_on(
            *(states[i], command[i], wish, ux, uy, rows[:seen]),
            *(min(at_walls[i, 0], body), walls, sight, step, p, forces[i]),
        )
    return forces


@register_motion_model("collision_free_speed")
@dataclass(kw_only=True, config=CONFIG)
class CollisionFreeSpeedModel(SpeedModel):
    """Others change the direction of people, the gap ahead their speed.

    Tordeux, Chraibi & Seyfried 2016. With the desired direction e0 and the
    direction e_j from person j at distance s_j, people walk in the direction

        e0 + sum_j a exp((l - s_j) / D) e_j

    at the speed min(v0, max(0, (s - l) / T)), with the least distance s of the
    people whom they would touch straight on. With the parameters of the paper,
    a crowd in one direction walks and passes doors as fast as measured.
    Opposite streams jam where they meet: for these, see
    `AnticipationVelocityModel`.

    Robots count like people, but with their whole radii, also in the role of
    an obstacle. Walls remove the part of the velocity that leads into them.

    In addition to the paper, people hesitate, start, stop and turn as in
    `SpeedModel`, and do not stand for ever before a person who stands exactly
    in front of them.
    """

    repulsion_strength: Share = 5.0
    """Strength of turning away at touching distance (a)."""

    repulsion_range: Annotated[StrictFloat, within(1e-3, 10, "m")] = 0.1
    """Distance over which it decays to 1/e (D), in meters."""

    epsilon: Annotated[StrictFloat, within(-1, 1, "rad")] = 0.05
    """Angle by which people see others displaced to the left, in radians. It
    breaks ties to the right; if negative, to the left. 0 is the paper's."""

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the accelerations, as totals: see `MotionModel.forces`."""
        return chosen_accelerations(collision_free_speeds, snapshot, self)


_model_in = reads(CollisionFreeSpeedModel)
