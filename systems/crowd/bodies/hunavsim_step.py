"""A whole step by the rules of HuNavSim in one call of compiled code.

It does what `CrowdStep` does part by part, with the same bits.
"""

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
)
from hunav_drake.systems.common.layout import VX, VY, Command, Hold
from hunav_drake.systems.crowd.bodies.whole_step import begin, end, numbers_in
from hunav_drake.systems.crowd.social_force.hunavsim import (
    add_pushes,
    advance,
    social_forces,
)


class Rules(NamedTuple):
    """The constants of these rules, after `Numbers` and before the turns.

    Attributes:
        pushing: The radius of robots that push as walls do, in meters; 0 for
            none.
        measured: Whether people who stop have no velocity: 1 or 0.
    """

    pushing: float
    measured: float


_rules_in = reads(Rules)


@jit
def _in_turn(rows, turns):
    """Returns the rows of an array (n, m) in the order of people's turns."""
    ordered = np.empty_like(rows)
    for k in range(len(turns)):
        for c in range(rows.shape[1]):
            ordered[k, c] = rows[int(turns[k]), c]
    return ordered


@jit
def _in_order(rows, turns):
    """Returns the rows that `_in_turn` has ordered, as they were."""
    result = np.empty_like(rows)
    for k in range(len(turns)):
        for c in range(rows.shape[1]):
            result[int(turns[k]), c] = rows[k, c]
    return result


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, WALLS, VECTOR),
)
def hunavsim_step(
    states, commands, stances, robots, weights, eased, sizes, table, numbers
):
    """Returns the result of a step of n people: see `whole_step`.

    The arguments are those there, but after `Numbers` come `Rules`, and the
    rows of people in their turn (n,): see `Snapshot.turns`.
    """
    n = len(sizes)
    p = numbers_in(numbers)
    turns = numbers[len(numbers) - n :]
    rules = _rules_in(numbers[len(p) : len(p) + 2])
    seen = begin(states, commands, robots, weights, eased, sizes, p)
    if not seen.holds:
        return np.empty(0)
    ordered = _in_turn(seen.states.copy(), turns)
    radii = np.empty(n)
    for k in range(n):
        radii[k] = seen.radii[int(turns[k])]
    command = _in_turn(seen.wanted, turns)
    parameters = _in_turn(seen.parameters.copy(), turns)
    felt = _in_turn(seen.felt, turns)
    in_turn = social_forces(
        *(ordered, radii, command, parameters, seen.robots, felt, table),
        *(p.reach, int(p.most)),
    )
    forces = _in_order(in_turn, turns)
    if rules.pushing > 0:
        add_pushes(
            *(forces, seen.states, seen.radii, seen.parameters, seen.robots),
            rules.pushing,
        )
    moved = advance(
        *(ordered, radii, command, parameters, seen.robots, felt, table),
        *(p.reach, int(p.most), _in_turn(forces, turns), p.time_step),
    )
    after = _in_order(moved, turns)
    for i in range(n):
        if (
            rules.measured != 0
            and int(seen.wanted[i, Command.HOLD]) == Hold.STAY
        ):
            after[i, VX] = 0.0
            after[i, VY] = 0.0
    return end(seen, forces, after, stances, sizes, table, p)
