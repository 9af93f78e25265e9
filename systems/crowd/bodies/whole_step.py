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
    rows_of,
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
from hunav_drake.systems.crowd.placed import (
    any_placed,
    finish_others,
    keep_placed,
)
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
        passing: The least speed behind people who stand, in m/s.
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
    passing: float
    time_step: float
    iterations: float


numbers_in = reads(Numbers)


class Begun(NamedTuple):
    """What people see at the begin of a step, as in a `Snapshot`.

    Attributes:
        states: Shape (n, 6).
        command: Shape (n, COMMAND_SIZE), as given.
        wanted: The same, adapted.
        parameters: Shape (n, 13).
        robots: Shape (m, 7).
        radii: Shape (n,), in meters.
        felt: Shape (n, 2): `Snapshot.at_walls`.
        pairs: Shape (p, 2): all pairs of people who are near each other.
        known: How near, in meters: see `follow`.
        holds: Whether no number is so large that `limited` would change it.
    """

    states: np.ndarray
    command: np.ndarray
    wanted: np.ndarray
    parameters: np.ndarray
    robots: np.ndarray
    radii: np.ndarray
    felt: np.ndarray
    pairs: np.ndarray
    known: float
    holds: bool


@jit
def begin(states_of_all, commands, robot_states, weights, eased, sizes, p):
    """Returns what people see at the begin of a step, a `Begun`.

    The arguments are those of `whole_step`, and its `Numbers`.
    """
    n = len(sizes)
    states = rows_of(states_of_all, MOTION_SIZE)
    command = rows_of(commands, COMMAND_SIZE)
    robots = rows_of(robot_states, STATE_SIZE)
    parameters = rows_of(weights, NUM_PARAMETERS)
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
    holds = is_within(states) and is_within(command) and is_within(robots)
    if holds and len(eased) == 0 and p.parts != 0 and is_grouped(command):
        groups = walking_groups(states, command, command)
        for i in range(n):
            wanted[i, Command.GROUP_ID] = groups[i]
    if holds and p.time_gap > 0:
        wanted, felt, pairs, known = follow(
            *(states, bodies, wanted, parameters, felt),
            *(p.time_gap, p.matching, p.passing),
        )
    keep_placed(wanted.ravel(), commands)
    return Begun(
        *(states, command, wanted, parameters, robots, radii, felt),
        *(pairs, known, holds),
    )


@jit
def end(begun, forces, after, stances, sizes, table, p):
    """Returns the result of `whole_step`, given the forces and what they do."""
    total = 0.0
    for i in range(len(after)):
        for c in range(forces.shape[1]):
            total += forces[i, c]
        for c in range(after.shape[1]):
            total += after[i, c]
    if not math.isfinite(total):
        return np.empty(0)
    stance = rows_of(stances, STANCE_SIZE).copy()
    options = Options(
        *(p.standing, p.keep_apart), *(p.acceleration, p.turn_rate, p.walled)
    )
    if any_placed(begun.wanted.ravel()):
        after, touches = finish_others(
            *(begun.states, after, forces, begun.wanted, stance),
            *(begun.robots, sizes, table, options),
            *(p.time_step, int(p.iterations)),
        )
    else:
        after, touches = finish(
            *(begun.states, after, forces, begun.wanted, stance),
            *(begun.robots, sizes, table, options),
            *(p.time_step, int(p.iterations), begun.pairs, begun.known),
        )
    result = np.empty(after.size + stance.size + touches.size)
    at = 0
    for rows in (after, stance, touches):
        for i in range(rows.shape[0]):
            for c in range(rows.shape[1]):
                result[at] = rows[i, c]
                at += 1
    return result


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, WALLS, VECTOR),
)
def whole_step(
    states, commands, stances, robots, weights, eased, sizes, table, numbers
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
    p = numbers_in(numbers)
    seen = begin(states, commands, robots, weights, eased, sizes, p)
    if not seen.holds:
        return np.empty(0)
    forces = fast_social_forces(
        *(seen.states, seen.radii, seen.wanted, seen.parameters, seen.robots),
        *(seen.felt, table, p.reach, int(p.most), p.error),
    )
    after = advance(seen.states, forces, seen.wanted, p.time_step)
    return end(seen, forces, after, stances, sizes, table, p)
