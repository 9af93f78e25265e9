"""A whole step of the social force model in one call of compiled code.

It does what `CrowdStep` does part by part for any model, with the same bits.
With few people, most of the time of a call of compiled code is that of passing
its arrays: therefore they are the vectors of a Context as they are, and one
that holds all results.
"""

import math
from typing import NamedTuple

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    VECTOR,
    WALLS,
    jit,
    jit_as,
    reads,
    unowned,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    MOTION_SIZE,
    STATE_SIZE,
    Command,
)
from hunav_drake.systems.crowd.bodies.finish import Options, finish
from hunav_drake.systems.crowd.bodies.standing import STANCE_SIZE
from hunav_drake.systems.crowd.bodies.time_gap import follow
from hunav_drake.systems.crowd.limits import is_within
from hunav_drake.systems.crowd.social_force.kernel import (
    advance,
    fast_social_forces,
)
from hunav_drake.systems.crowd.walls.parted_groups import (
    is_grouped,
    walking_groups,
)
from hunav_drake.systems.people.parameters import K_OBSTACLE, NUM_PARAMETERS


class Numbers(NamedTuple):
    """The constants of a trial, after the fields of `Options`.

    Attributes:
        parts: Whether groups part: 1 or 0.
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
    parts: float
    reach: float
    most: float
    error: float
    time_gap: float
    matching: float
    time_step: float
    iterations: float


_numbers_in = reads(Numbers)


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, WALLS, VECTOR),
)
def whole_step(
    states_of_all,
    commands,
    stances_of_all,
    robot_states,
    weights,
    eased,
    sizes,
    table,
    numbers,
):
    """Returns the result of a step of n people: one vector.

    It holds the states (n, 6) and stances (n, 3) at the end of the step and its
    touches (mn, 2) as of `robot_touches`. It is empty if a number is so large
    that `limited` would change it, or a force is not finite.

    The first arguments are vectors: rows of states, commands, stances,
    `robot_states`, and weights (n, 13). `eased` is `Snapshot.at_walls` of
    commands that are adapted: see `Adaptation`; or of shape (0, 2) where there
    is nothing but groups to adapt to. `sizes` (n, 3) are those of `finish`, and
    the radius of each person, in meters. `numbers` are `Numbers`.
    """
    p = _numbers_in(numbers)
    n = len(sizes)
    states = unowned(states_of_all).reshape((n, MOTION_SIZE))
    command = unowned(commands).reshape((n, COMMAND_SIZE))
    parameters = unowned(weights).reshape((n, NUM_PARAMETERS))
    m = len(robot_states) // STATE_SIZE
    robots = unowned(robot_states).reshape((m, STATE_SIZE))
    nothing = np.empty(0)
    if not (is_within(states) and is_within(command) and is_within(robots)):
        return nothing
    stance = np.empty((n, STANCE_SIZE))
    bodies = np.empty(n)
    radii = np.empty(n)
    felt = np.empty((n, 2))
    for i in range(n):
        for c in range(STANCE_SIZE):
            stance[i, c] = stances_of_all[STANCE_SIZE * i + c]
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
    if len(eased) == 0 and p.parts != 0 and is_grouped(command):
        groups = walking_groups(states, command, command)
        wanted[:, Command.GROUP_ID] = groups
    if p.time_gap > 0:
        wanted, felt, pairs, known = follow(
            *(states, bodies, wanted, parameters, felt),
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
        return nothing
    after, touches = finish(
        *(states, after, forces, wanted, stance, robots, sizes, table),
        Options(
            *(p.standing, p.keep_apart),
            *(p.acceleration, p.turn_rate, p.walled),
        ),
        *(p.time_step, int(p.iterations)),
        *(pairs, known),
    )
    return joined(after, stance, touches)


@jit
def joined(states, stances, touches):
    """Returns the numbers of three arrays as one vector."""
    result = np.empty(states.size + stances.size + touches.size)
    at = 0
    for rows in (states, stances, touches):
        for i in range(rows.shape[0]):
            for c in range(rows.shape[1]):
                result[at] = rows[i, c]
                at += 1
    return result
