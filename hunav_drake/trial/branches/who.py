"""Tells who delayed whom, by leaving people and robots out."""

from collections.abc import Callable, Sequence
import itertools
import math
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.trial.branches.kinds import Without
from hunav_drake.trial.branches.run import Fork
from hunav_drake.trial.leaving import ONLY_ROBOT

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

# Up to this many people, all subsets are run.
MOST_EXACT = 6

# The permutations by default, for more people.
PERMUTATIONS = 40

Method = Literal["leave_one_out", "shapley"]

# The arrivals (n,) of people when some players are there: the people, by their
# rows, and then the robots.
_Game = Callable[[frozenset[int]], Array]


def WhoDelayedWhom(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    until: float,
    method: Method = "leave_one_out",
    permutations: int | None = None,
    seed: int = 0,
    goal: int = 0,
) -> "pd.DataFrame":
    """Tells how much each person and robot delays each person.

    "leave_one_out": by how much a person arrives later than without the other.
    Effects overlap, so that a column does not add up to the person's delay.
    "shapley": the mean of that over all orders in which the others come to be
    there (Shapley 1953); a column adds up to the arrival with all minus the one
    of the person alone. It is exact up to `MOST_EXACT` people: all subsets are
    run, 2^m for m people and robots. With more, orders are drawn.

    Args:
        scenario: The scenario of the trial.
        diagram: Its diagram, from `MakeTrialDiagram`.
        context: Its Context at the instant from which on others are not there;
            it is not changed.
        until: The time until which trials run, in seconds.
        method: See above.
        permutations: The number of orders; by default all up to `MOST_EXACT`
            people, and `PERMUTATIONS` with more.
        seed: The seed of the orders.
        goal: See `RunBranches`.

    Returns:
        A row per cause, the people and then the robots, and a column per
        person: the delay in seconds. NaN on the diagonal, and where a person
        does not arrive by `until`.

    Raises:
        PlannerError: If a planner fails.
        ValueError: If nobody can be left out (see `LeaveOut`), or an argument
            is out of its range.
    """
    check_choice("method", method, get_args(Method))
    if permutations is not None and permutations < 1:
        raise ValueError(f"permutations must be at least 1, got {permutations}")
    if permutations is not None and method != "shapley":
        raise ValueError(
            f"permutations={permutations} has no effect without"
            " method='shapley'; add it, or leave permutations out"
        )
    fork = Fork(scenario, diagram, context, until=until, goal=goal)
    robots = [name or ONLY_ROBOT for name in fork.robots]
    people = list(fork.names)
    fork.Prepare(Without(people=tuple(people), robots=tuple(robots)))
    known: dict[frozenset[int], Array] = {}
    players, n = [*people, *robots], len(people)

    def arrivals(there: frozenset[int]) -> Array:
        if there not in known:
            gone = [i for i in range(len(players)) if i not in there]
            branch = Without(
                people=tuple(players[i] for i in gone if i < n),
                robots=tuple(players[i] for i in gone if i >= n),
            )
            known[there] = fork.Run(branch, whole=False).arrivals
        return known[there]

    if method == "leave_one_out":
        table = _without_one(arrivals, len(players), n)
    elif permutations is None and n <= MOST_EXACT:
        table = _exact(arrivals, len(players), n)
    else:
        orders = _orders(len(players), permutations or PERMUTATIONS, seed)
        table = _drawn(arrivals, n, orders)
    return pd.DataFrame(
        table, index=pd.Index(players, name="cause"), columns=people
    )


def _without_one(game: _Game, size: int, n: int) -> Array:
    everybody = frozenset(range(size))
    table = np.array(
        [game(everybody) - game(everybody - {j}) for j in range(size)]
    ).reshape(size, n)
    table[range(n), range(n)] = np.nan
    return table


def _exact(game: _Game, size: int, n: int) -> Array:
    """Returns the mean of each effect over all orders of the others."""
    table = np.full((size, n), np.nan)
    for i, j in itertools.product(range(n), range(size)):
        if i == j:
            continue
        others = [k for k in range(size) if k not in (i, j)]
        total = 0.0
        for count in range(len(others) + 1):
            # The share of the orders in which just these come before.
            share = 1 / ((len(others) + 1) * math.comb(len(others), count))
            for before in itertools.combinations(others, count):
                there = frozenset({*before, i})
                gap = game(there | {j})[i] - game(there)[i]
                total += share * float(gap)
        table[j, i] = total
    return table


def _drawn(game: _Game, n: int, orders: Sequence[Sequence[int]]) -> Array:
    """Returns the mean of each effect over some orders."""
    table = np.zeros((len(orders[0]), n))
    for order in orders:
        for i in range(n):
            there = frozenset({i})
            for j in order:
                if j != i:
                    after = there | {j}
                    table[j, i] += game(after)[i] - game(there)[i]
                    there = after
    table /= len(orders)
    table[range(n), range(n)] = np.nan
    return table


def _orders(size: int, number: int, seed: int) -> list[Sequence[int]]:
    generator = np.random.Generator(np.random.Philox(seed))
    return [generator.permutation(size).tolist() for _ in range(number)]
