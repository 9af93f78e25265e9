"""Cases of groups and mixed crowds."""

from statistics import linear_regression

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.places import Area, corridor, room, spread
from hunav_drake.validation.walkers import SPEED, Walk, Walkers


@case(
    "Moussaïd et al. 2010",
    question="Do two people of a group walk side by side, and are larger groups"
    " of 2 to 5 people slower?",
    expected="a pair is 0.6 to 0.9 m apart, at 70 to 90 degrees to its"
    " direction; 0.01 to 0.08 m/s slower for each further member",
    accepts=lambda it: (
        0.6 <= it["distance"] <= 0.9
        and it["angle"] >= 70
        and 0.01 <= it["slower"] <= 0.08
    ),
    shown="{distance:.2f} m, {angle:.0f}°, {slower:.3f} m/s slower",
)
def walking_groups(setting: Setting) -> Numbers:
    """Measures the formation of a pair, and the speeds of groups."""
    sizes = [1, 2, 4] if setting.quick else [1, 2, 3, 4, 5]
    walks = [_walk_together(setting, size) for size in sizes]
    apart = walks[1].states[:, 0, :2] - walks[1].states[:, 1, :2]
    angles = np.degrees(np.arctan2(abs(apart[:, 1]), abs(apart[:, 0])))
    speeds = [float(walk.velocities()[..., 0].mean()) for walk in walks]
    return {
        "distance": float(np.hypot(apart[:, 0], apart[:, 1]).mean()),
        "angle": float(angles.mean()),
        "slower": -linear_regression(sizes, speeds).slope,
        "size": sizes,
        "speed": speeds,
    }


def _walk_together(setting: Setting, size: int) -> Walk:
    """Returns the second half of a group's walk, in formation."""
    row = np.arange(size)
    starts = np.stack([-0.2 * (row % 2), 0.7 * row], axis=1)
    group = 1 if size > 1 else -1
    walkers = Walkers(
        setting, starts, starts + np.array([200.0, 0.0]), groups=group
    )
    walk = walkers.walk(20.0 if setting.quick else 60.0)
    half = len(walk.times) // 2
    return Walk(walk.times[half:], walk.states[half:], walk.present[half:])


def _arrival_spread(
    setting: Setting, speeds: list[float], ahead: float
) -> Numbers:
    """Measures the time from the first to the last arrival of a group.

    `speeds` are those of its five members, `ahead` is that of another group of
    ten, whom it overtakes.
    """
    group = spread(5, Area(-3, 0.5, 0, 3.5), setting.generator("group"))
    others = spread(10, Area(8, 0.5, 12, 3.5), setting.generator("ahead"))
    starts = np.concatenate([group, others])
    own = np.arange(15) < 5
    goals = np.stack([np.full(len(starts), 120.0), starts[:, 1]], axis=1)
    # The length over which the members walk together.
    end = 20.0 if setting.quick else 40.0

    def arrived(rows: Array) -> Mask:
        # The others are removed with the last member.
        over: bool = (rows[own, 0] > end).all()
        return (rows[:, 0] > end + 10) | (~own & over)

    walk = Walkers(
        *(setting, starts, goals),
        walls=corridor(-12, 122, 4),
        speeds=[*speeds, *[ahead] * 10],
        groups=np.where(own, 1, 2),
    ).walk(300.0, leave=arrived)
    times = walk.first_time(walk.x > end)[own]
    last = times.max()
    return {"spread": float(last - times.min() if last < np.inf else np.inf)}


@case(
    "NIST 2.9",
    question="Does a group of four people with a desired speed of 1.25 m/s and"
    " one with 0.5 m/s stay together over 40 m, past ten people ahead at 0.2"
    " m/s?",
    expected="all five arrive within 10 s",
    accepts=lambda it: it["spread"] <= 10,
    shown="within {spread:.1f} s",
)
def slow_member(setting: Setting) -> Numbers:
    """Measures the spread of arrivals of a group with a slow member."""
    return _arrival_spread(setting, [1.25, 1.25, 1.25, 1.25, 0.5], 0.2)


@case(
    "ISO 14",
    question="Do five people with a desired speed of 1.25 m/s stay together"
    " over 40 m, past ten people ahead at 0.5 m/s?",
    expected="all five arrive within 10 s",
    accepts=lambda it: it["spread"] <= 10,
    shown="within {spread:.1f} s",
)
def fast_group(setting: Setting) -> Numbers:
    """Measures the spread of arrivals of a group that overtakes another."""
    return _arrival_spread(setting, [1.25] * 5, 0.5)


@case(
    "NIST 2.10, ISO 7",
    question="Do 25 people take longer to leave a room of 8 x 5 m by a door of"
    " 1 m if the person nearest to it is slower (0.5 m/s) and larger (0.35 m)?",
    expected="the last person leaves later than if all are alike, and all"
    " leave",
    accepts=lambda it: it["alike"] < it["together"] < np.inf,
    shown="{alike:.1f} s if all are alike, {together:.1f} s with a slow one",
)
def slow_person(setting: Setting) -> Numbers:
    """Measures when 25 people have left, without and with a slow person."""
    starts = spread(24, Area(0.3, 0.3, 6, 4.7), setting.generator("slow one"))
    starts = np.concatenate([starts, [[7.0, 2.5]]])
    normal = np.arange(25) < 24
    result = {}
    for name, speed, radius in (("alike", SPEED, 0.2), ("together", 0.5, 0.35)):
        walk = Walkers(
            setting,
            starts,
            [40, 2.5],
            walls=room(8, 5, 1.0),
            speeds=np.where(normal, SPEED, speed),
            radii=np.where(normal, 0.2, radius),
        ).walk(90.0, leave=lambda rows: rows[:, 0] > 12, patience=40.0)
        result[name] = float(walk.first_time(walk.x > 8.2).max())
    return result


CASES = (walking_groups, slow_member, fast_group, slow_person)
