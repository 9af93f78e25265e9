"""Cases of the speed of crowds at different densities: fundamental diagrams.

The corridors are endless (periodic). Each person has an image, one length of
the corridor ahead or behind, whichever is nearer to its middle. Images are
people of the same crowd, placed again before each step, so that with any model
all people see half a length ahead and behind.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import norm

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import X
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.measures import weidmann
from hunav_drake.validation.places import Area, corridor, spread
from hunav_drake.validation.walkers import SPEED, TIME_STEP, Walkers

# The distance of a goal in the same direction for all, in meters.
_FAR = 1e4

# The tolerance of the speed at each density, in m/s.
TOLERANCE = 0.15

# The standard deviation of desired speeds (Weidmann 1993), in m/s.
_DEVIATION = 0.26

# The densities of the fundamental diagram, in persons/m^2.
_DENSITIES = (0.5, 1.0, 1.5, 2.0, 3.0)


class EndlessCorridor:
    """People in a periodic corridor."""

    def __init__(
        self,
        setting: Setting,
        starts: Array,
        length: float,
        width: float,
        speeds: ArrayLike = SPEED,
    ) -> None:
        """Constructs a corridor with people who walk along x.

        Args:
            setting: The model and the options.
            starts: Shape (n, 2), x from 0 to the length, y from 0 to the width,
                in meters.
            length: The period along x, in meters.
            width: The width of the corridor, in meters.
            speeds: The desired speed of each person, in m/s.
        """
        self._length = length
        self._n = len(starts)
        self._walkers = Walkers(
            setting,
            np.concatenate([starts, self._images(starts)]),
            [_FAR, width / 2],
            walls=corridor(-length, 2 * length, width),
            speeds=np.tile(np.broadcast_to(speeds, self._n), 2),
        )

    def _images(self, rows: Array) -> Array:
        images = rows.copy()
        ahead = rows[:, X] < self._length / 2
        images[:, X] += np.where(ahead, self._length, -self._length)
        return images

    def step(self) -> Array:
        """Moves all people by one step; returns their motion, (n, 2) in m."""
        before = self._walkers.states[: self._n]
        self._walkers.step()
        after = self._walkers.states[: self._n]
        moved: Array = after[:, :2] - before[:, :2]
        after[:, X] %= self._length
        self._walkers.set_states(np.concatenate([after, self._images(after)]))
        return moved

    def mean_speed(self, settling: float, seconds: float) -> float:
        """Returns the mean speed along x over some time, in m/s.

        The measurement begins after a time of settling. Times are in seconds.
        """
        for _ in range(round(settling / TIME_STEP)):
            self.step()
        steps = round(seconds / TIME_STEP)
        total = sum(float(self.step()[:, 0].mean()) for _ in range(steps))
        return total / (steps * TIME_STEP)


def _preferred_speeds(n: int) -> Array:
    """Returns the desired speeds of n people, in ascending order, in m/s.

    They have Weidmann's distribution. With equal speeds, people would never
    approach each other, and some models would not slow down at any density.
    """
    middle = (np.arange(n) + 0.5) / n
    speeds: Array = SPEED + _DEVIATION * norm.ppf(middle)
    return speeds


def _speeds(setting: Setting) -> tuple[list[float], list[float]]:
    length, width = (10.0, 4.0) if setting.quick else (12.0, 10.0)
    seconds = 4.0 if setting.quick else 20.0
    densities = list(_DENSITIES[1::2] if setting.quick else _DENSITIES)
    speeds = []
    for density in densities:
        n = round(density * length * width)
        generator = setting.generator(f"density {density}")
        area = Area(0, 0.1, length, width - 0.1)
        starts = spread(n, area, generator)
        preferred = generator.permutation(_preferred_speeds(n))
        endless = EndlessCorridor(setting, starts, length, width, preferred)
        speeds.append(endless.mean_speed(seconds / 2, seconds))
    return densities, speeds


@case(
    "RiMEA 4",
    question="How fast are people with desired speeds of N(1.34, 0.26) m/s in"
    " an endless corridor 10 m wide (with a period of 12 m), at densities of"
    " 0.5 to 3 persons/m²?",
    expected="at each density within 0.15 m/s of Weidmann's speed, 1.30 / 1.06"
    " / 0.81 / 0.61 / 0.33 m/s",
    accepts=lambda it: bool(np.all(np.abs(it["difference"]) <= TOLERANCE)),
    shown="{speed:.2f} m/s ({difference:+.3f}) at {density:g}/m²",
)
def fundamental_diagram(setting: Setting) -> Numbers:
    """Measures the mean speed at several densities, and its difference."""
    densities, speeds = _speeds(setting)
    expected = weidmann(densities)
    return {
        "density": densities,
        "speed": speeds,
        "weidmann": expected.tolist(),
        "difference": (speeds - expected).tolist(),
    }


@case(
    "ISO 13",
    question="Do people with a desired speed of 1.0 m/s never walk faster, at"
    " any density in a corridor?",
    expected="a mean speed of at most 1.05 m/s at 0.5, 1 and 2 persons/m²",
    accepts=lambda it: max(it["speed"]) <= 1.05,
    shown="{speed:.2f} m/s at {density:g}/m²",
)
def never_faster(setting: Setting) -> Numbers:
    """Measures the mean speed at a desired speed of 1 m/s."""
    # 60, 120 and 240 people on 12 x 10 m.
    length, width = (10.0, 4.0) if setting.quick else (12.0, 10.0)
    densities = [0.5, 1.0, 2.0]
    speeds = []
    for density in densities:
        starts = spread(
            round(density * length * width),
            Area(0, 0.1, length, width - 0.1),
            setting.generator(f"slow {density}"),
        )
        endless = EndlessCorridor(setting, starts, length, width, speeds=1.0)
        seconds = 2.0 if setting.quick else 8.0
        speeds.append(endless.mean_speed(2.0, seconds))
    return {"density": densities, "speed": speeds}


@case(
    "RiMEA 16",
    question="Are people in single file, in an endless passage 0.6 m wide,"
    " slower at higher densities?",
    expected="speeds at 0.5, 1.0, 1.5 and 2.0 persons/m do not rise, and fall"
    " below half of the free speed",
    accepts=lambda it: bool(
        np.all(np.diff(it["speed"]) < 0.02) and it["speed"][-1] < SPEED / 2
    ),
    shown="{speed:.2f} m/s at {density:g}/m",
)
def single_file(setting: Setting) -> Numbers:
    """Measures the mean speed in single file, at several densities."""
    length, width = 20.0, 0.6
    seconds = 10.0 if setting.quick else 40.0
    densities = [0.5, 1.0, 1.5, 2.0]
    speeds = []
    for density in densities:
        n = round(density * length)
        generator = setting.generator(f"file {density}")
        x = (np.arange(n) + generator.uniform(-0.1, 0.1, n) + 0.5) / density
        y = width / 2 + generator.uniform(-0.02, 0.02, n)
        starts = np.stack([x, y], axis=1)
        endless = EndlessCorridor(setting, starts, length, width)
        speeds.append(endless.mean_speed(seconds / 2, seconds))
    return {"density": densities, "speed": speeds}


CASES = (fundamental_diagram, single_file, never_faster)
