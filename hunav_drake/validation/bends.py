"""Cases of corridors with bends, rooms, and choices of ways."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.shapes import Box
from hunav_drake.validation.case import Case, Numbers, Setting, case
from hunav_drake.validation.places import (
    Area,
    corridor,
    samples_in_walls,
    spread,
    wall,
)
from hunav_drake.validation.walkers import Walkers


def _corner(
    begin: float, before: float, width: float, after: float
) -> list[Box]:
    """Returns the walls of a corridor along x that turns left, along y.

    It starts at x = `begin`, closed so that there is no way around its walls.
    The corner is at x = `before`. The second part has the length `after`, both
    have the same width. All are in meters.
    """
    end = before + width
    return [
        wall(begin - 0.2, -0.2, begin, width + 0.2),
        wall(begin, -0.2, end + 0.2, 0),
        wall(end, 0, end + 0.2, width + after),
        wall(begin, width, before, width + 0.2),
        wall(before - 0.2, width + 0.2, before, width + after),
    ]


@case(
    "RiMEA 6, NIST 2.3, ISO 4",
    question="Do 20 people walk around a corner of a corridor 2 m wide, without"
    " walking through walls?",
    expected="all arrive, no sample is in a wall or beyond it",
    accepts=lambda it: it["arrived"] == 20 and it["outside"] == 0,
    shown="{arrived:.0f} of 20 arrive, {outside:.0f} samples outside",
)
def corner(setting: Setting) -> Numbers:
    """Counts people who pass a corner, and samples beyond its walls."""
    walls = _corner(-1, 10, 2, 14)
    starts = spread(20, Area(0.3, 0.3, 6, 1.7), setting.generator("corner"))
    walk = Walkers(setting, starts, [11, 40], walls=walls).walk(
        90.0, leave=lambda rows: rows[:, 1] > 14, patience=40.0
    )
    x, y = walk.x, walk.y
    held = (x < 12) & (y > 0) & ((y < 2) | (x > 10))
    beyond = (~held & walk.present).sum()
    in_walls = samples_in_walls(walls, walk.states[walk.present][:, :2])
    arrived = np.isfinite(walk.first_time(y > 12)).sum()
    return {"arrived": float(arrived), "outside": float(beyond + in_walls)}


def _time_of_crowd(
    setting: Setting, walls: list[Box], goal: Array, end: float, axis: int
) -> float:
    """Returns when the last of 60 people leaves a corridor 4 m wide."""
    people = 20 if setting.quick else 60
    starts = spread(
        people, Area(-10, 0.4, -0.5, 3.6), setting.generator("bend")
    )
    walk = Walkers(setting, starts, goal, walls=walls).walk(
        120.0, leave=lambda rows: rows[:, axis] > end + 1, patience=60.0
    )
    return float(walk.first_time(walk.states[..., axis] > end).max())


@case(
    "RiMEA 15 (a fifth of the width, 60 people)",
    question="Does a crowd take the longest time for a straight corridor as"
    " long as the outer side of a bend, less for the bend, and the least for"
    " one as long as its inner side?",
    expected="times in that order",
    accepts=lambda it: it["short"] < it["bend"] < it["long"] < np.inf,
    shown="{long:.1f} s for 42.3 m, {bend:.1f} s by the bend, {short:.1f} s for"
    " 36 m",
)
def bend(setting: Setting) -> Numbers:
    """Measures the time of the last person in three corridors."""
    inner = 36.0
    outer = inner + math.pi / 2 * 4
    turned = _corner(-11, 12, 4, 28)
    straight = corridor(-11, outer + 4, 4)
    ahead = np.array([outer + 40, 2.0])
    up = np.array([14.0, 70.0])
    return {
        "long": _time_of_crowd(setting, straight, ahead, outer, 0),
        "bend": _time_of_crowd(setting, turned, up, 4 + inner - 12, 1),
        "short": _time_of_crowd(setting, straight, ahead, inner, 0),
    }


@case(
    "",
    question="Do 60 people slow down at the inner corner of a corridor 3 m"
    " wide, and are they as fast as before from 3 m behind it?",
    expected="slower by 5 % or more within 1.5 m of the corner; behind it at"
    " least 95 % of the speed before it",
    accepts=lambda it: (
        it["at"] <= 0.95 * it["before"] and it["behind"] >= 0.95 * it["before"]
    ),
    shown="{before:.2f} m/s before, {at:.2f} at, {behind:.2f} behind",
)
def corner_effect(setting: Setting) -> Numbers:
    """Measures speeds before, at and behind a corner."""
    people = 20 if setting.quick else 60
    starts = spread(
        people, Area(-12, 0.3, -0.5, 2.7), setting.generator("corner effect")
    )
    walls = _corner(-13, 10, 3, 17)
    walk = Walkers(setting, starts, [11.5, 50], walls=walls).walk(
        60.0, leave=lambda rows: rows[:, 1] > 17
    )
    speeds = np.hypot(*np.moveaxis(walk.velocities(), -1, 0))
    x, y = walk.x[:-1], walk.y[:-1]
    here = walk.present[:-1] & walk.present[1:]
    before = (x > 4) & (x < 7) & (y < 3) & here
    at = (np.hypot(x - 10, y - 3) < 1.5) & here
    behind = (y > 6) & (y < 9) & here
    return {
        name: float(speeds[where].mean()) if where.any() else 0.0
        for name, where in (("before", before), ("at", at), ("behind", behind))
    }


@case(
    "RiMEA 10, NIST 3.1, ISO 8",
    question="Do 23 people in 12 rooms along a corridor leave by their assigned"
    " exits?",
    expected="all of them",
    accepts=lambda it: it["obeyed"] == 23,
    shown="{obeyed:.0f} of 23",
)
def assigned_exits(setting: Setting) -> Numbers:
    """Counts people who leave by their assigned exits."""
    walls, rooms = _rooms_along_corridor(6)
    starts = np.concatenate(
        [
            spread(2 if k else 1, area, setting.generator(f"room {k}"))
            for k, area in enumerate(rooms)
        ]
    )
    # The four rooms at the right use the other exit, as in the guideline.
    to_right = starts[:, 0] > 16
    goals = np.where(to_right[:, None], [[50.0, 6]], [[-26.0, 6]])
    walk = Walkers(setting, starts, goals, walls=walls).walk(
        90.0, leave=lambda rows: abs(rows[:, 0] - 12) > 15, patience=60.0
    )
    right = walk.first_time(walk.x > 24.5)
    left = walk.first_time(walk.x < -0.5)
    own, other = np.where(to_right, (right, left), (left, right))
    return {"obeyed": float((np.isfinite(own) & np.isinf(other)).sum())}


def _rooms_along_corridor(pairs: int) -> tuple[list[Box], list[Area]]:
    """Returns rooms of 4 x 5 m on both sides of a corridor 2 m wide.

    The corridor, from y = 5 to 7, is open at both ends; doors are 0.9 m wide.
    """
    end = 4.0 * pairs
    walls = [wall(-0.2, -0.2, end, 0), wall(-0.2, 12, end, 12.2)]
    areas = []
    for k in range(pairs + 1):
        walls.append(wall(4 * k - 0.2, 0, 4 * k, 5))
        walls.append(wall(4 * k - 0.2, 7, 4 * k, 12))
    for k in range(pairs):
        for low, y in ((0.0, 4.8), (7.2, 7.0)):
            walls.append(wall(4 * k, y, 4 * k + 1.45, y + 0.2))
            walls.append(wall(4 * k + 2.35, y, 4 * k + 3.8, y + 0.2))
            areas.append(Area(4 * k + 0.6, low + 0.8, 4 * k + 3.2, low + 4))
    return walls, areas


@case(
    "RiMEA 8 (in a plane)",
    question="Does a storey of 12 rooms with 48 people, who leave by one end of"
    " its corridor, empty sooner if people are faster? The guideline varies"
    " parameters of a building of three storeys; this case varies the speed,"
    " 0.5, 0.75, 1.0 and 1.34 m/s, on one storey.",
    expected="at a higher speed, the time of the last person is at most 5 %"
    " longer, and at the highest speed at most 3/4 of that at the lowest; all"
    " leave",
    accepts=lambda it: bool(
        max(it["time"]) < np.inf
        and np.all(np.diff(it["time"]) <= 0.05 * np.array(it["time"][:-1]))
        and it["time"][-1] <= 0.75 * it["time"][0]
    ),
    shown="{time:.1f} s at {speed:g} m/s",
)
def storey_sweep(setting: Setting) -> Numbers:
    """Measures when the last person leaves a storey, for several speeds."""
    walls, rooms = _rooms_along_corridor(3 if setting.quick else 6)
    starts = np.concatenate(
        [
            spread(4, area, setting.generator(f"storey {k}"))
            for k, area in enumerate(rooms)
        ]
    )
    speeds = [0.5, 0.75, 1.0, 1.34]
    times = []
    for speed in speeds:
        walkers = Walkers(setting, starts, [-26, 6], walls=walls, speeds=speed)
        walk = walkers.walk(
            240.0, leave=lambda rows: rows[:, 0] < -3, patience=60.0
        )
        times.append(float(walk.first_time(walk.x < -0.5).max()))
    return {"speed": speeds, "time": times}


@case(
    "RiMEA 14, ISO 17",
    question="Do 20 people take the shorter of two ways around a block, of 16"
    " and 28 m?",
    expected="more than half of them do, and all arrive",
    accepts=lambda it: it["shorter"] > 10 and it["arrived"] == 20,
    shown="{shorter:.0f} of 20 take it, {arrived:.0f} arrive",
)
def shorter_way(setting: Setting) -> Numbers:
    """Counts people who take the shorter of two ways."""
    walls = [
        *corridor(-5, 17, 12),
        wall(-5.2, -0.2, -5, 12.2),
        wall(17, -0.2, 17.2, 12.2),
        # The block.
        wall(2, 2, 10, 10),
    ]
    starts = spread(20, Area(-4.5, 1, 0, 7), setting.generator("two ways"))
    walk = Walkers(setting, starts, [15, 4], walls=walls).walk(
        60.0, leave=lambda rows: rows[:, 0] > 13
    )
    block = (walk.x > 2) & (walk.x < 10)
    below = np.isfinite(walk.first_time(block & (walk.y < 2)))
    arrived = np.isfinite(walk.first_time(walk.x > 11)).sum()
    return {"shorter": float(below.sum()), "arrived": float(arrived)}


_NO_CHOICE = (
    "people walk to their given goals; no motion model chooses among exits"
)

CASES = (
    corner,
    bend,
    corner_effect,
    storey_sweep,
    assigned_exits,
    shorter_way,
    Case(
        "choice_of_exit",
        "RiMEA 11, NIST 3.3 and 4.1, ISO 9, 15 and 16",
        question="Do people choose among exits by distance, by the choices of"
        " others, and if one is closed?",
        expected="most choose the nearer exit, some the other; none a closed"
        " one",
        reason=_NO_CHOICE,
    ),
)
