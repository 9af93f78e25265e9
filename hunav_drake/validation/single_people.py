"""Cases of single people."""

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import Command
from hunav_drake.validation.case import Case, Numbers, Setting, case
from hunav_drake.validation.places import Area, corridor, room, spread
from hunav_drake.validation.walkers import SPEED, Walkers

# The distance from which a person has set out, in meters.
_OUT = 0.5

# The walking speeds of adults, in m/s: under 30 years, 30 to 50, above 50, and
# with difficulties in walking.
_BANDS = ((0.58, 1.61), (1.41, 1.54), (0.68, 1.41), (0.46, 0.76))

_STAIRS = "the world is a plane: there are no stairs"


def _hold_back(walkers: Walkers, own_times: ArrayLike) -> None:
    """Keeps people standing until their own times, (n,) in seconds."""
    walkers.command[:, Command.HAS_GOAL] = walkers.time >= np.asarray(own_times)


@case(
    "RiMEA 1",
    question="Does one person, with a reaction time of 1 s and a desired speed"
    " of 1.33 m/s, take the right time for 40 m of a corridor 2 m wide?",
    expected="26 to 34 s",
    accepts=lambda it: 26 <= it["time"] <= 34,
    shown="{time:.1f} s",
)
def corridor_time(setting: Setting) -> Numbers:
    """Measures the time of one person for 40 m."""
    walkers = Walkers(
        setting, [[0, 1]], [60, 1], walls=corridor(-2, 62, 2), speeds=1.33
    )
    walk = walkers.walk(60.0, each=lambda it: _hold_back(it, [1.0]))
    return {"time": float(walk.first_time(walk.x >= 40)[0])}


@case(
    "NIST 2.1, ISO 2",
    question="Does one person keep a speed of 1 m/s for 40 m?",
    expected="mean speed 0.95 to 1.05 m/s",
    accepts=lambda it: abs(it["speed"] - 1) <= 0.05,
    shown="{speed:.3f} m/s",
)
def kept_speed(setting: Setting) -> Numbers:
    """Measures the speed of one person over 40 m."""
    walkers = Walkers(
        setting, [[-3, 1]], [60, 1], walls=corridor(-5, 62, 2), speeds=1.0
    )
    walk = walkers.walk(120.0, leave=lambda rows: rows[:, 0] > 42)
    (taken,) = walk.time_between(walk.x >= 0, walk.x >= 40)
    return {"speed": 40 / float(taken)}


@case(
    "RiMEA 5, NIST 1.1, ISO 1",
    question="Do 10 people in a room of 8 x 5 m set out at their own times,"
    " drawn from 10 to 100 s, and does nobody move before?",
    expected="all within 1 s of their times, and all leave",
    accepts=lambda it: it["error"] <= 1 and it["left"] == 10,
    shown="at most {error:.2f} s off, {left:.0f} of 10 leave",
)
def own_times(setting: Setting) -> Numbers:
    """Measures when people with different waiting times set out."""
    generator = setting.generator("own times")
    latest = 20.0 if setting.quick else 100.0
    own = generator.uniform(latest / 10, latest, 10)
    starts = spread(10, Area(0.5, 0.5, 7.5, 4.5), generator)
    walkers = Walkers(setting, starts, [20, 2.5], walls=room(8, 5, 1.0))
    walk = walkers.walk(
        latest + 40,
        each=lambda it: _hold_back(it, own),
        leave=lambda rows: rows[:, 0] > 10,
    )
    moved = walk.states[..., :2] - starts
    out = walk.first_time(np.hypot(moved[..., 0], moved[..., 1]) > _OUT)
    # Minus the time for the distance; acceleration takes about 0.1 s more.
    error = abs(out - own - _OUT / SPEED).max()
    left = np.isfinite(walk.first_time(walk.x > 8.2)).sum()
    return {"error": float(error), "left": float(left)}


def _side_by_side(setting: Setting, speeds: Array) -> Array:
    """Returns the speeds of people in a hall, 1 m from each other."""
    starts = np.stack([np.zeros(len(speeds)), np.arange(len(speeds))], axis=1)
    length = 20.0 if setting.quick else 80.0
    walkers = Walkers(
        setting, starts, starts + np.array([200.0, 0.0]), speeds=speeds
    )
    walk = walkers.walk((length + 10) / speeds.min())
    taken = walk.time_between(walk.x >= 5, walk.x >= 5 + length)
    return length / taken


@case(
    "NIST 2.4, ISO 5",
    question="Do 100 people in a hall of 100 m, whose speeds are drawn from"
    " N(1.2, 0.2) m/s, walk at speeds of that distribution?",
    expected="mean 1.15 to 1.25, standard deviation 0.15 to 0.25 m/s",
    accepts=lambda it: (
        abs(it["mean"] - 1.2) <= 0.05 and abs(it["deviation"] - 0.2) <= 0.05
    ),
    shown="mean {mean:.3f}, deviation {deviation:.3f} m/s",
)
def population_speeds(setting: Setting) -> Numbers:
    """Measures the distribution of speeds."""
    drawn = setting.generator("population").normal(1.2, 0.2, 100)
    # A normal distribution has speeds near zero and below: without these.
    speeds = _side_by_side(setting, np.clip(drawn, 0.3, None))
    return {"mean": float(speeds.mean()), "deviation": float(speeds.std())}


@case(
    "RiMEA 7",
    question="Do 50 adults of four kinds, under 30 years, 30 to 50, above 50,"
    " and with walking difficulties, keep the speeds of their kind?",
    expected="nobody is beyond the range of the kind by over 0.05 m/s",
    accepts=lambda it: it["beyond"] <= 0.05,
    shown="at most {beyond:.3f} m/s beyond",
)
def speeds_by_age(setting: Setting) -> Numbers:
    """Measures how far speeds are outside of the ranges of their ages."""
    low, high = np.array(_BANDS)[np.arange(50) % len(_BANDS)].T
    drawn = setting.generator("ages").uniform(low, high)
    speeds = _side_by_side(setting, drawn)
    beyond = np.maximum(low - speeds, speeds - high).max()
    return {"beyond": float(max(beyond, 0.0))}


CASES = (
    corridor_time,
    kept_speed,
    Case(
        "stairs",
        "RiMEA 2, 3 and 13, NIST 2.2, ISO 3 and 12",
        question="Do people walk slower on stairs, and more people at once on"
        " wide ones?",
        expected="the speed of the stairs, within 0.05 m/s",
        reason=_STAIRS,
    ),
    own_times,
    speeds_by_age,
    population_speeds,
    Case(
        "smoke",
        "NIST 2.5, ISO 18",
        question="Do people walk slower in smoke?",
        expected="speed falls with the extinction coefficient",
        reason="there is no smoke in the world",
    ),
)
