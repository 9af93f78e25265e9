"""Cases of counterflow."""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.world.shapes import Box
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.measures import lane_order
from hunav_drake.validation.places import THICK, Area, corridor, spread, wall
from hunav_drake.validation.walkers import Walkers

# The least number of people of each direction in a counterflow.
_BOTH = 5


def _two_rooms() -> list[Box]:
    """Returns two rooms of 10 x 10 m with a corridor of 10 x 2 m between."""
    return [
        *corridor(-10.2, 0.2, 10),
        *corridor(9.8, 20.2, 10),
        wall(-10.2, 0, -10, 10),
        wall(20, 0, 20.2, 10),
        *(
            wall(x, low, x + THICK, low + 4)
            for x in (0.0, 9.8)
            for low in (0.0, 6.0)
        ),
        wall(0.2, 3.8, 9.8, 4),
        wall(0.2, 6, 9.8, 6.2),
    ]


def _crossing_time(setting: Setting, people: int, against: int) -> float:
    """Returns when the last person has crossed to the other room.

    All walk through the corridor to the back wall of the other room, and leave
    there.
    """
    generator = setting.generator("counterflow")
    left = spread(people, Area(-9.7, 0.3, -0.3, 9.7), generator)
    right = spread(against, Area(10.3, 0.3, 19.7, 9.7), generator)
    to_right = np.arange(people + against) < people
    starts = np.concatenate([left, right])
    goals = np.stack([np.where(to_right, 19.5, -9.5), starts[:, 1]], axis=1)
    walkers = Walkers(setting, starts, goals, walls=_two_rooms())

    def leave(rows: Array) -> Mask:
        x = rows[:, 0]
        return np.where(to_right, x > 18.5, x < -8.5)

    walk = walkers.walk(180.0, leave=leave, patience=40.0)
    crossed = np.where(to_right, walk.x > 10, walk.x < 0)
    return float(walk.first_time(crossed).max())


@case(
    "NIST 2.8, ISO 6",
    question="Do 100 people take longer to cross a corridor of 10 x 2 m with"
    " more oncoming people: 0, 10, 50 or 100? And do all cross?",
    expected="times increase, and all cross",
    accepts=lambda it: bool(
        max(it["time"]) < np.inf and np.all(np.diff(it["time"]) > 0)
    ),
    shown="{time:.1f} s with {against:.0f}",
)
def counterflow(setting: Setting) -> Numbers:
    """Measures when the last person has crossed, for several crowds."""
    people = 20 if setting.quick else 100
    against = [0, 10] if setting.quick else [0, 10, 50, 100]
    times = [_crossing_time(setting, people, n) for n in against]
    return {"against": against, "time": times}


@case(
    "NIST 2.8, ISO 6",
    question="Do 100 people and 100 oncoming people pass each other in a"
    " corridor of 10 x 2 m, within 3 minutes?",
    expected="all cross",
    accepts=lambda it: it["time"] < np.inf,
    shown="last to cross: {time:.1f} s",
)
def dense_counterflow(setting: Setting) -> Numbers:
    """Measures when the last of 100 against 100 people has crossed."""
    people = 20 if setting.quick else 100
    return {"time": _crossing_time(setting, people, people)}


@case(
    "Feliciani & Nishinari 2016",
    question="Do 27 people and 27 oncoming people form lanes in the middle 10 m"
    " of a corridor of 3 x 38 m, after the first of both have crossed it?",
    expected="mean order parameter of at least 0.8, where 1 is perfect, and all"
    " pass",
    accepts=lambda it: it["order"] >= 0.8 and it["passed"] == it["people"],
    shown="{order:.2f} (by chance {chance:.2f}), {passed:.0f} of {people:.0f}"
    " get past",
)
def lanes(setting: Setting) -> Numbers:
    """Measures the order of two crowds that pass each other."""
    generator = setting.generator("lanes")
    half = 12 if setting.quick else 27
    to_right = np.arange(2 * half) < half
    # One person per square meter, from the ends of the corridor on.
    starts = spread(2 * half, Area(0, 0.3, 2 * half / 3, 2.7), generator)
    starts[~to_right, 0] += 38 - 2 * half / 3
    goals = np.stack([np.where(to_right, 80.0, -42.0), starts[:, 1]], axis=1)
    walk = Walkers(setting, starts, goals, walls=corridor(-8, 46, 3)).walk(
        60.0,
        leave=lambda rows: (rows[:, 0] < -4) | (rows[:, 0] > 42),
        patience=30.0,
    )
    middle = (abs(walk.x - 19) < 5) & walk.present
    met = min(
        walk.first_time(walk.x > 24)[to_right].min(),
        walk.first_time(walk.x < 14)[~to_right].min(),
    )
    both = (
        (middle[:, to_right].sum(axis=1) >= _BOTH)
        & (middle[:, ~to_right].sum(axis=1) >= _BOTH)
        & (walk.times >= met)
    )
    orders = [
        [lane_order(rows[here], side) for side in (own, mixed)]
        for rows, here in zip(walk.states[both], middle[both], strict=True)
        for own in [to_right[here]]
        for mixed in [generator.permutation(own)]
    ]
    order, chance = np.mean(orders, axis=0) if orders else (0.0, 0.0)
    passed = np.where(to_right, walk.x > 26, walk.x < 12)
    seen = np.flatnonzero(both)
    rows = walk.states[seen[len(seen) // 2] if len(seen) else -1]
    return {
        "order": float(order),
        "chance": float(chance),
        "passed": float(np.isfinite(walk.first_time(passed)).sum()),
        "people": 2 * half,
        "x": rows[:, 0].tolist(),
        "y": rows[:, 1].tolist(),
    }


CASES = (counterflow, dense_counterflow, lanes)
