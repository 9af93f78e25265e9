"""How a person looks: what its figure is like."""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, within

Hair = Literal["short", "long", "bun", "none"]
Held = Literal["nothing", "cup", "telephone"]
Luggage = Literal["nothing", "backpack", "bag", "basket"]

# The height of an adult figure and of its neck, in meters. Heads differ less
# than bodies, and the width of children less than their height: they are these
# powers of the size of the body.
ADULT, NECK = 1.7, 1.48
HEAD_POWER, WIDTH_POWER = 0.4, 0.7

# The columns of a row of a figure: the size of its body and its width, in those
# of an adult, and 1 in a wheelchair.
TALL, WIDE, WHEELED = range(3)
BODY_SIZE = 3

# Ages, in years, and the median heights of children, in meters: the growth
# curves of the WHO (2006, 2007), the mean of girls and boys, to about 5 mm.
_AGES = (3.0, 5.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0)
_HEIGHTS = (0.955, 1.096, 1.272, 1.382, 1.503, 1.616, 1.675, 1.70)

# The mean heights of men and women, in meters, and the deviation, as a part of
# them (Fryar et al., Vital Health Stat. 3(46), 2021: 1.753 and 1.612 m).
_MEN, _WOMEN, _DEVIATION = 1.753, 1.612, 0.043

# The youngest age, in years, and the limits of heights, in meters, and builds.
YOUNGEST = 3.0
HEIGHTS, BUILDS = (0.8, 2.2), (0.7, 1.5)

# The ages of adults, and from which on hair is gray, in years.
ADULT_AGE, GRAY = 18.0, 60.0


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class FigureConfig:
    """How a person looks. For the crowd it stays a disc of its radius."""

    age: Annotated[StrictFloat, within(YOUNGEST, 100, "years")] = 30.0
    """Age, in years: children are smaller, and from 60 on hair is gray."""

    height: Annotated[StrictFloat, within(*HEIGHTS, "m")] | None = None
    """Height, in meters; by default that of the age, 1.7 m from 18 years on."""

    build: Annotated[StrictFloat, within(*BUILDS)] = 1.0
    """Width, in that of an adult with the same radius."""

    hair: Hair | None = None
    """Hair; by default people have different hair, in their order."""

    holds: Held | None = None
    """What the person holds in the right hand; by default nothing, or, with the
    behavior "distracted", a telephone."""

    carries: Luggage = "nothing"
    """What the person carries: a backpack, a bag over the shoulder, or a
    shopping basket in the left hand."""

    wheelchair: StrictBool = False
    """Whether the person is in a wheelchair."""

    @property
    def tall(self) -> float:
        """The size of the body, in that of an adult figure.

        With its head, which differs less, the figure has its height.
        """
        height = self.height
        if height is None:
            height = float(height_of_age(self.age))
        tall = height / ADULT
        # Newton's method; it converges for all heights.
        for _ in range(4):
            head = (ADULT - NECK) * tall**HEAD_POWER
            missing = height - NECK * tall - head
            tall += missing / (NECK + HEAD_POWER * head / tall)
        return tall

    @property
    def wide(self) -> float:
        """The width, in that of an adult; children are slim."""
        return float(self.build * min(self.tall, 1.0) ** WIDTH_POWER)


class Figures(NamedTuple):
    """The figures of n people.

    Attributes:
        rows: Shape (n, 3): see `figure_rows`.
        lively: Whether they sit as they show it.
        ids: The numbers of the people, which tell their steps apart; None for
            1, 2, ...
    """

    rows: Array
    lively: bool = False
    ids: Sequence[int] | None = None

    def numbers(self) -> Sequence[int]:
        """Returns the numbers of the people."""
        return range(1, len(self.rows) + 1) if self.ids is None else self.ids


def height_of_age(age: ArrayLike) -> Array:
    """Returns the median height of people of an age, in meters."""
    return np.asarray(np.interp(np.asarray(age, float), _AGES, _HEIGHTS))


def height_distribution(
    age: ArrayLike, is_woman: ArrayLike
) -> tuple[Array, Array]:
    """Returns the mean and the deviation of heights, in meters.

    Until 10 years of age, girls and boys are equally tall.
    """
    years = np.asarray(age, dtype=float)
    sex = np.where(is_woman, _WOMEN, _MEN) / ADULT
    mean = height_of_age(years) * sex ** np.clip((years - 10.0) / 8.0, 0.0, 1.0)
    return mean, _DEVIATION * mean


def adult_figures(n: int) -> Array:
    """Returns the rows of n adults, shape (n, 3)."""
    return np.tile([1.0, 1.0, 0.0], (n, 1))


def figure_rows(figures: Sequence[FigureConfig]) -> Array:
    """Returns the rows of figures, shape (n, 3): see `TALL`."""
    rows = [[it.tall, it.wide, it.wheelchair] for it in figures]
    return np.array(rows, dtype=float).reshape(-1, BODY_SIZE)
