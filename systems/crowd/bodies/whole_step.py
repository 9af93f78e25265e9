"""A whole step of the social force model in one call of compiled code.

It does what `CrowdStep` does part by part for any model, with the same bits.
With few people, most of the time of a call of compiled code is that of passing
its arrays.
"""

import math
from typing import NamedTuple

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    VECTOR,
    WALLS,
    jit_as,
    reads,
)
from hunav_drake.systems.crowd.bodies.finish import Options, finish
from hunav_drake.systems.crowd.bodies.time_gap import follow
from hunav_drake.systems.crowd.limits import is_within
from hunav_drake.systems.crowd.social_force.kernel import (
    advance,
    fast_social_forces,
)
from hunav_drake.systems.people.parameters import K_OBSTACLE


class Numbers(NamedTuple):
    """The constants of a trial, after the fields of `Options`.

    Attributes:
        reach: Walls farther than this exert no force, in meters.
        most: The largest number of walls that exert forces; 0 for all.
        error: See `fast_social_forces`.
        time_gap: That between people, in seconds; 0 for none.
        matching: The share of others' speed that is added.
        time_step: In seconds.
        iterations: Those of `keep_apart`.
    """

    standing: float
    keep_apart: float
    acceleration: float
    turn_rate: float
    walled: float
    reach: float
    most: float
    error: float
    time_gap: float
    matching: float
    time_step: float
    iterations: float


_numbers_in = reads(Numbers)


@jit_as(
    numba.types.Tuple(
        (float64[:, ::1], float64[:, ::1], float64[:, ::1], numba.boolean)
    ),
    *(MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, WALLS, VECTOR),
)
def whole_step(
    states, command, stances, robots, parameters, eased, sizes, table, numbers
):
    """Returns the states and stances of n people at the end of a step.

    After them come the touches of the step as of `robot_touches`, and whether
    all these are valid: not if a number is so large that `limited` would change
    it, or a force is not finite. `eased` is `Snapshot.at_walls`, or of shape
    (0, 2) if people have their own radii and weights at walls. `sizes` (n, 3)
    are those of `finish`, and the radius of each person, in meters. `numbers`
    are `Numbers`.
    """
    p = _numbers_in(numbers)
    n = len(states)
    stance = stances.copy()
    touches = np.zeros((n * len(robots), 2))
    if not (is_within(states) and is_within(command) and is_within(robots)):
        return states.copy(), stance, touches, False
    bodies = np.empty(n)
    radii = np.empty(n)
    felt = np.empty((n, 2))
    for i in range(n):
        bodies[i] = sizes[i, 0]
        radii[i] = sizes[i, 2]
        if len(eased) > 0:
            felt[i, 0] = eased[i, 0]
            felt[i, 1] = eased[i, 1]
        else:
            felt[i, 0] = sizes[i, 2]
            felt[i, 1] = parameters[i, K_OBSTACLE]
    pairs = np.empty((0, 2), np.int64)
    known = -1.0
    wanted = command.copy()
    if p.time_gap > 0:
        wanted, felt, pairs, known = follow(
            *(states, bodies, command, parameters, felt),
            *(p.time_gap, p.matching),
        )
    forces = fast_social_forces(
        *(states, radii, wanted, parameters, robots, felt, table),
        *(p.reach, int(p.most), p.error),
    )
    total = 0.0
    for i in range(n):
        for c in range(forces.shape[1]):
            total += forces[i, c]
    after = advance(states, forces, wanted, p.time_step)
    for i in range(n):
        for c in range(after.shape[1]):
            total += after[i, c]
    if not math.isfinite(total):
        return after, stance, touches, False
    after, touches = finish(
        *(states, after, forces, wanted, stance, robots, sizes, table),
        Options(
            *(p.standing, p.keep_apart),
            *(p.acceleration, p.turn_rate, p.walled),
        ),
        *(p.time_step, int(p.iterations)),
        *(pairs, known),
    )
    return after, stance, touches, True
