"""The collision-free speed model: the gap ahead decides how fast people walk.

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

# The exponent that repulsion grows to at most, and that below which it is left
# out: 1e-6 of the strength.
MOST, LEAST = 3.0, -14.0


@jit
def repulsion(rows, strength, length, epsilon):
    """Returns the sum of the directions away from others, by their strength.

    Args:
        rows: What a person sees: see `look_around`.
        strength: That of somebody who is touched (a).
        length: The distance in which it falls to 1/e (D), in meters.
        epsilon: How far to the left of where they are others are seen, rad.
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


@jit_as(
    float64[:, ::1],
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, WALLS),
    *(REAL, REAL, VECTOR),
)
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
        model: Shape (10,): the fields of CollisionFreeSpeedModel.

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
    """Others turn people away, and the gap ahead says how fast they walk.

    Tordeux, Chraibi & Seyfried 2016. With e0 the direction wanted and e_j that
    from person j at distance s_j, people walk in the direction of

        e0 + sum_j a exp((l - s_j) / D) e_j

    at the speed min(v0, max(0, (s - l) / T)), s the least distance of those
    whom they would touch if they went on straight. In one direction, a crowd
    walks as fast, and passes doors as fast, as measured, with the parameters
    of the paper. Streams in opposite directions jam where they meet: there,
    see `AnticipationVelocityModel`.

    Robots count as people do, but with the whole radii; one in the role of an
    obstacle does, too. Walls take from the velocity what leads into them.

    What is added to the paper: people hesitate, start, stop and turn as
    `SpeedModel` says, and do not stand for ever before one who stands exactly
    in front of them.
    """

    repulsion_strength: Share = 5.0
    """How strongly somebody who is touched turns people away (a)."""

    repulsion_range: Annotated[StrictFloat, within(1e-3, 10, "m")] = 0.1
    """The distance in which that falls to 1/e (D), in meters."""

    epsilon: Annotated[StrictFloat, within(-1, 1, "rad")] = 0.05
    """How far to the left of where they are people see others, in radians: it
    breaks ties to the right; a negative one, to the left. 0 is the paper's."""

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the accelerations, as totals: see `MotionModel.forces`."""
        return chosen_accelerations(collision_free_speeds, snapshot, self)


_model_in = reads(CollisionFreeSpeedModel)
