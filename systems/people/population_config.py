"""A population: people who are drawn, not listed one by one."""

from dataclasses import field
from typing import Annotated, Self

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    StrictBool,
    StrictFloat,
    StrictStr,
    model_validator,
)
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadii,
    BodyRadius,
    Integer,
    Length,
    Name,
    Point,
    Points,
    PositiveLength,
    PositiveSpeed,
    Rectangle,
    Speed,
    within,
)
from hunav_drake.systems.people.human_config import ForcesMode
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.walking_speeds import AGES, MAX_DEVIATIONS

Weight = Annotated[StrictFloat, within(0, 1e6)]
Share = Annotated[StrictFloat, within(0, 1)]
Age = Annotated[StrictFloat, within(AGES[0], AGES[-1], "years")]


def _fault(rule: str) -> PydanticCustomError:
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


def _check_weights[T: (dict[str, float], list[float])](weights: T) -> T:
    values = weights.values() if isinstance(weights, dict) else weights
    if not sum(values) > 0:
        raise _fault("must have a weight above 0")
    return weights


@dataclass(kw_only=True, slots=True, config=CONFIG)
class Area:
    """A part of the floor, or a point of it: exactly one of the keys."""

    # The sides (x_min, y_min, x_max, y_max) of a rectangle, in meters.
    rectangle: Rectangle | None = None

    # The corners of a simple polygon, in either direction, in meters; the
    # last joins the first.
    polygon: Annotated[Points, Field(min_length=3, max_length=1000)] | None = (
        None
    )

    # A point (x, y), in meters.
    point: Point | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        given = [self.rectangle, self.polygon, self.point]
        if sum(part is not None for part in given) != 1:
            raise _fault("must have one of rectangle, polygon and point")
        if self.rectangle is not None:
            x_min, y_min, x_max, y_max = self.rectangle
            if not (x_min < x_max and y_min < y_max):
                raise _fault(
                    "rectangle must be (x_min, y_min, x_max, y_max) with"
                    " x_min < x_max and y_min < y_max"
                )
        if self.polygon is not None:
            shape = shapely.Polygon(self.polygon)
            if not (shape.is_valid and shape.area > 0):
                raise _fault(
                    "polygon must enclose an area, and not cross itself"
                )
        return self

    def vertices(self) -> Array:
        """Returns the corners in W, shape (k, 2), in meters; 1 of a point."""
        if self.rectangle is not None:
            x_min, y_min, x_max, y_max = self.rectangle
            return np.array(
                [[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]]
            )
        corners = self.polygon if self.polygon is not None else [self.point]
        return np.array(corners, dtype=float)


@dataclass(kw_only=True, slots=True, config=CONFIG)
class AgeBand:
    """A share of people, of ages that are drawn evenly."""

    # The ages of the band, in years.
    low: Age
    high: Age

    # How many they are, in proportion to the other bands.
    weight: Weight = 1.0

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.high < self.low:
            raise _fault(
                f"high must be at least low ({self.low:g} years), got"
                f" {self.high:g}"
            )
        return self


def _check_bands(bands: list[AgeBand]) -> list[AgeBand]:
    _check_weights([band.weight for band in bands])
    return bands


def _check_start(area: Area) -> Area:
    if area.point is not None:
        raise _fault(
            "must be a rectangle or a polygon, got a point; list a person of a"
            " known place under humans"
        )
    return area


def _check_radii(radii: tuple[float, float]) -> tuple[float, float]:
    low, high = radii
    if high < low:
        raise _fault(
            f"must be a least and a largest radius, got {low:g} and {high:g} m"
        )
    return radii


@dataclass(kw_only=True, slots=True, config=CONFIG)
class SpeedDistribution:
    """Speeds that are normally distributed, whatever age and sex."""

    # The mean speed, in m/s.
    mean: PositiveSpeed

    # The deviation, in m/s. Nobody is farther than three from the mean.
    deviation: Speed = 0.0

    @model_validator(mode="after")
    def _check(self) -> Self:
        reach = MAX_DEVIATIONS * self.deviation
        if not 0 < self.mean - reach <= self.mean + reach <= 10:
            raise _fault(
                f"mean -+ {MAX_DEVIATIONS:g} deviations must be in (0, 10] m/s,"
                f" got {self.mean - reach:g} to {self.mean + reach:g}; choose a"
                " smaller deviation"
            )
        return self


@dataclass(kw_only=True, slots=True, config=CONFIG)
class CohortConfig:
    """People of one kind, drawn from the same distributions."""

    # What they are called: "guest" are guest_1, guest_2, ...; by default they
    # are named as people without a name. What is drawn of a cohort hangs on
    # its name, or, if it has none, on its place in the list.
    name: Annotated[Name, Field(max_length=50)] = ""

    # How many they are.
    number: Annotated[Integer, Field(ge=0, le=5000)]

    # Where they start: evenly in all of these areas (no points), their discs
    # of `radius` clear of walls, of the listed people's and of the robot's.
    start: Annotated[
        list[Annotated[Area, AfterValidator(_check_start)]], Field(min_length=1)
    ]

    # The space between two bodies at the start, at least, in meters. With 0.1
    # about 2 people find room on a square meter, with 0 about 3.
    spacing: Length = 0.1

    # Where they go: in each of these areas, in this order, each person or
    # group has a place of its own, clear of walls; a point is the same for
    # all. With none they stand.
    goals: Annotated[list[Area], Field(max_length=1000)] = field(
        default_factory=list
    )

    # Whether each person or group has an order of its own instead.
    shuffle_goals: StrictBool = False

    # Whether the first goal follows the last; by default as of listed people.
    cyclic: StrictBool | None = None

    # The distance at which a goal counts as reached, in meters.
    goal_radius: PositiveLength = 0.3

    # The radius of the disc that others keep off, in meters.
    radius: BodyRadius = 0.35

    # The weights of the forces.
    forces: SocialForceParameters = field(default_factory=SocialForceParameters)

    # Whether factors of the forces are as in `forces` ("custom"), HuNavSim's
    # ("default"), or drawn for each person.
    forces_mode: ForcesMode = "custom"

    # The radii of bodies, drawn evenly between two, in meters.
    body_radius: Annotated[BodyRadii, AfterValidator(_check_radii)] = (
        0.2,
        0.25,
    )

    # The behaviors, by name or by the path of an XML file, with weights in
    # proportion to which they are drawn.
    behaviors: Annotated[
        dict[StrictStr, Weight], AfterValidator(_check_weights)
    ] = field(default_factory=lambda: {"regular": 1.0})

    # The sizes of groups: the weights of being alone, two, three, ... People
    # of a group start together, have the same goals and walk as fast as the
    # slowest.
    group_sizes: Annotated[
        list[Weight],
        Field(min_length=1, max_length=20),
        AfterValidator(_check_weights),
    ] = field(default_factory=lambda: [1.0])

    # The ages, from which, with the sexes, the speeds follow: see
    # `hunav_drake.systems.people.walking_speeds`.
    ages: Annotated[
        list[AgeBand], Field(min_length=1), AfterValidator(_check_bands)
    ] = field(default_factory=lambda: [AgeBand(low=18.0, high=80.0)])

    # How many of them are women; the others are men.
    share_of_women: Share = 0.5

    # Speeds that do not follow from age and sex.
    speed: SpeedDistribution | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        largest = self.body_radius[1]
        if largest > self.radius:
            raise _fault(
                f"radius must be at least that of the largest body"
                f" ({largest:g} m), got {self.radius:g}; raise it, or lower"
                " body_radius"
            )
        return self


@dataclass(kw_only=True, slots=True, config=CONFIG)
class PopulationConfig:
    """People who are drawn, besides those who are listed."""

    # All that is drawn of the people follows from this number. The seed of
    # the simulation is another: it draws what changes from trial to trial of
    # the same people.
    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] = 0

    # The kinds of people.
    cohorts: list[CohortConfig] = field(default_factory=list)

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [cohort.name for cohort in self.cohorts if cohort.name]
        for name in names:
            if names.count(name) > 1:
                raise _fault(f"two cohorts have the name {name!r}; rename one")
        return self

    @property
    def number(self) -> int:
        """How many people are drawn."""
        return sum(cohort.number for cohort in self.cohorts)
