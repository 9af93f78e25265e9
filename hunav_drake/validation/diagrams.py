"""Cases of the speed of crowds at different densities: fundamental diagrams.

The corridors have no ends. Each person has an image, one length of the corridor
ahead or behind, whichever is nearer to the middle of it. Images are people of
the same crowd, put anew before each step: so everybody sees half a length
ahead and behind, by whatever model.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm

from hunav_drake.systems.common.layout import X
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.measures import weidmann
from hunav_drake.validation.places import Area, corridor, spread
from hunav_drake.validation.walkers import SPEED, TIME_STEP, Walkers

Array = NDArray[np.float64]

# A goal so far ahead that the way to it is straight for all, in meters.
_FAR = 1e4

# How far the speed at each density may be from Weidmann's, in m/s.
TOLERANCE = 0.15

# The standard deviation of the speeds that people prefer (Weidmann 1993), m/s.
_DEVIATION = 0.26

# The densities that speeds are measured at, in persons/m^2.
_DENSITIES = (0.5, 1.0, 1.5, 2.0, 3.0)


class EndlessCorridor:
    """People in a corridor that leads back to its begin."""

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
            setting: The model, and more.
            starts: Shape (n, 2), x from 0 to the length, y from 0 to the width,
                in meters.
            length: After so much x, it is the begin again.
            width: That of the corridor.
            speeds: The speed that each prefers, in m/s.
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
        """Lets everybody move for one time step.

        Returns:
            Shape (n, 2): how far, in meters.
        """
        before = self._walkers.states[: self._n]
        self._walkers.step()
        after = self._walkers.states[: self._n]
        moved: Array = after[:, :2] - before[:, :2]
        after[:, X] %= self._length
        self._walkers.set_states(np.concatenate([after, self._images(after)]))
        return moved

    def mean_speed(self, seconds: float) -> float:
        """Returns how fast people move along x for some time, in m/s."""
        steps = round(seconds / TIME_STEP)
        total = sum(float(self.step()[:, 0].mean()) for _ in range(steps))
        return total / (steps * TIME_STEP)


def _preferred_speeds(n: int) -> Array:
    """Returns the speeds that n people prefer, in order, in m/s.

    They are spread as those of Weidmann's people. People who all prefer the
    same would never meet: at no density would some models slow them down.
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
        endless.mean_speed(seconds / 2)
        speeds.append(endless.mean_speed(seconds))
    return densities, speeds


@case(
    "RiMEA 4",
    question="How fast are people who prefer N(1.34, 0.26) m/s in a corridor"
    " 10 m wide, at densities of 0.5 to 3 persons/m²? It has no ends: 12 m come"
    " again and again.",
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
    question="Do people who prefer 1.0 m/s never walk faster, however many are"
    " in a corridor?",
    expected="a mean speed of at most 1.05 m/s at 0.5, 1 and 2 persons/m²",
    accepts=lambda it: max(it["speed"]) <= 1.05,
    shown="{speed:.2f} m/s at {density:g}/m²",
)
def never_faster(setting: Setting) -> Numbers:
    """Measures the mean speed of people who prefer 1 m/s."""
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
        endless.mean_speed(2.0)
        speeds.append(endless.mean_speed(2.0 if setting.quick else 8.0))
    return {"density": densities, "speed": speeds}


@case(
    "RiMEA 16",
    question="Are people in single file, in a passage 0.6 m wide without ends,"
    " slower the more there are?",
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
        endless.mean_speed(seconds / 2)
        speeds.append(endless.mean_speed(seconds))
    return {"density": densities, "speed": speeds}


CASES = (fundamental_diagram, single_file, never_faster)
