"""A population: people who are drawn, not listed one by one."""

from collections.abc import Iterator
from dataclasses import field
from typing import Annotated, Self

from pydantic import (
    AfterValidator,
    Field,
    StrictBool,
    StrictFloat,
    StrictStr,
    model_validator,
)
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadii,
    BodyRadius,
    Integer,
    Length,
    Name,
    PositiveLength,
    PositiveSpeed,
    Speed,
    fault,
    within,
)
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.human_config import ForcesMode
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.walking_speeds import AGES, MAX_DEVIATIONS

Weight = Annotated[StrictFloat, within(0, 1e6)]
Share = Annotated[StrictFloat, within(0, 1)]
Age = Annotated[StrictFloat, within(AGES[0], AGES[-1], "years")]


def _check_weights[T: (dict[str, float], list[float])](weights: T) -> T:
    values = weights.values() if isinstance(weights, dict) else weights
    if not sum(values) > 0:
        raise fault("must have a weight above 0")
    return weights


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class AgeBand:
    """A share of people, of ages that are drawn evenly."""

    low: Age
    """The lowest age of the band, in years."""

    high: Age
    """The highest age of the band, in years."""

    weight: Weight = 1.0
    """How many they are, in proportion to the other bands."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.high < self.low:
            raise fault(
                f"high must be at least low ({self.low:g} years), got"
                f" {self.high:g}"
            )
        return self


def _check_bands(bands: list[AgeBand]) -> list[AgeBand]:
    _check_weights([band.weight for band in bands])
    return bands


def _check_start(area: Area) -> Area:
    if area.point is not None:
        raise fault(
            "must be a rectangle or a polygon, got a point; list a person of a"
            " known place under humans"
        )
    return area


def _check_radii(radii: tuple[float, float]) -> tuple[float, float]:
    low, high = radii
    if high < low:
        raise fault(
            f"must be a least and a largest radius, got {low:g} and {high:g} m"
        )
    return radii


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SpeedDistribution:
    """Speeds that are normally distributed, whatever age and sex."""

    mean: PositiveSpeed
    """The mean speed, in m/s."""

    deviation: Speed = 0.0
    """The deviation, in m/s. Nobody is farther than three from the mean."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        reach = MAX_DEVIATIONS * self.deviation
        if not 0 < self.mean - reach <= self.mean + reach <= 10:
            raise fault(
                f"mean -+ {MAX_DEVIATIONS:g} deviations must be in (0, 10] m/s,"
                f" got {self.mean - reach:g} to {self.mean + reach:g}; choose a"
                " smaller deviation"
            )
        return self


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class MembersConfig:
    """What people of one kind have in common: how each of them is drawn."""

    name: Annotated[Name, Field(max_length=50)] = ""
    """What they are called: "guest" are guest_1, guest_2, ...; by default they
    are named as people without a name. What is drawn of a cohort hangs on its
    name, or, if it has none, on its place in the list."""

    spacing: Length = 0.1
    """The space between two bodies at the start, at least, in meters. With 0.1
    about 2 people find room on a square meter, with 0 about 3."""

    goals: Annotated[list[Area], Field(max_length=1000)] = field(
        default_factory=list
    )
    """Where they go: in each of these areas, in this order, each person or
    group has a place of its own, clear of walls; a point is the same for all.
    With none they stand."""

    shuffle_goals: StrictBool = False
    """Whether each person or group has an order of its own instead."""

    sinks: dict[StrictStr, Weight] = field(default_factory=dict)
    """The sinks at which they leave, after their goals, with weights in
    proportion to which one of them is drawn for each person or group."""

    goal_radius: PositiveLength = 0.3
    """The distance at which a goal counts as reached, in meters."""

    radius: BodyRadius = 0.35
    """The radius of the disc that others keep off, in meters."""

    forces: SocialForceParameters = field(default_factory=SocialForceParameters)
    """The weights of the forces."""

    forces_mode: ForcesMode = "custom"
    """Whether factors of the forces are as in `forces` ("custom"), HuNavSim's
    ("default"), or drawn for each person."""

    body_radius: Annotated[BodyRadii, AfterValidator(_check_radii)] = (
        0.2,
        0.25,
    )
    """The radii of bodies, drawn evenly between two, in meters."""

    behaviors: Annotated[
        dict[StrictStr, Weight], AfterValidator(_check_weights)
    ] = field(default_factory=lambda: {"regular": 1.0})
    """The behaviors, by name or by the path of an XML file, with weights in
    proportion to which they are drawn."""

    group_sizes: Annotated[
        list[Weight],
        Field(min_length=1, max_length=20),
        AfterValidator(_check_weights),
    ] = field(default_factory=lambda: [1.0])
    """The sizes of groups: the weights of being alone, two, three, ... People
    of a group start together, have the same goals and walk as fast as the
    slowest."""

    ages: Annotated[
        list[AgeBand], Field(min_length=1), AfterValidator(_check_bands)
    ] = field(default_factory=lambda: [AgeBand(low=18.0, high=80.0)])
    """The ages, from which, with the sexes, the speeds follow: see
    `hunav_drake.systems.people.walking_speeds`."""

    share_of_women: Share = 0.5
    """How many of them are women; the others are men."""

    speed: SpeedDistribution | None = None
    """Speeds that do not follow from age and sex."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        largest = self.body_radius[1]
        if largest > self.radius:
            raise fault(
                f"radius must be at least that of the largest body"
                f" ({largest:g} m), got {self.radius:g}; raise it, or lower"
                " body_radius"
            )
        if self.sinks:
            _check_weights(self.sinks)
        return self


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class CohortConfig(MembersConfig):
    """People of one kind, who are here from the start."""

    number: Annotated[Integer, Field(ge=0, le=5000)]
    """How many they are."""

    start: Annotated[
        list[Annotated[Area, AfterValidator(_check_start)]], Field(min_length=1)
    ]
    """Where they start: evenly in all of these areas (no points), their discs
    of `radius` clear of walls, of the listed people's and of the robot's."""

    cyclic: StrictBool | None = None
    """Whether the first goal follows the last; by default as of listed people,
    and not for those who leave at sinks."""

    @model_validator(mode="after")
    def _check_end(self) -> Self:
        if self.sinks and self.cyclic:
            raise fault(
                "cyclic must be false for people who leave at sinks; remove"
                " one of them"
            )
        return self


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SourceConfig(MembersConfig):
    """A place where people come in, one after the other, and go to sinks."""

    name: Annotated[Name, Field(min_length=1, max_length=50)]
    """How it is called. The people who come are north_1, north_2, ..."""

    start: Annotated[list[Area], Field(min_length=1)]
    """Where they come in: evenly in all of these areas, or at a point, their
    discs of `radius` clear of walls. Who finds no place waits outside."""

    rate: Annotated[StrictFloat, within(0, 100, "people/s")]
    """How many people come per second on average. They come independently of
    one another (a Poisson process, drawn by the seed of the trial); those of a
    group come together."""

    max_present: Annotated[Integer, Field(ge=1, le=5000)]
    """How many people of it are here at the same time, at most: while they are,
    others wait outside. They are the same people again and again: who has left
    comes back in turn."""

    sinks: Annotated[dict[StrictStr, Weight], AfterValidator(_check_weights)]
    """The sinks at which they leave, after their goals, one at least, with
    weights in proportion to which one of them is drawn for each person or
    group."""

    @property
    def number(self) -> int:
        """How many people are drawn."""
        return self.max_present

    @property
    def cyclic(self) -> bool:
        """Whether the first goal follows the last: it never does."""
        return False


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SinkConfig:
    """A place where people leave whose last goal it is."""

    name: Annotated[Name, Field(min_length=1, max_length=50)]
    """How sources and cohorts name it."""

    area: Area
    """Where it is. Each person or group walks to a place of its own in it."""

    radius: Length = 0.3
    """Who is as near as this to the area is gone, in meters; so is who is as
    near as their own `goal_radius`."""

    rate: Annotated[StrictFloat, within(0.01, 100, "people/s")] | None = None
    """How many people leave per second, at most, as through a turnstile, the
    nearest first; the others wait for it. By default, any number."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class PopulationConfig:
    """People who are drawn, besides those who are listed."""

    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] | None = None
    """All that is drawn of the people follows from this number: with one, all
    trials are of the same people. By default it is the seed of the trial, so
    that each trial is of other people; without a trial, 0."""

    cohorts: list[CohortConfig] = field(default_factory=list)
    """The kinds of people."""

    sources: list[SourceConfig] = field(default_factory=list)
    """Where people come in while the trial runs."""

    sinks: list[SinkConfig] = field(default_factory=list)
    """Where people leave."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [it.name for it in self.cohorts if it.name]
        for name in names:
            if names.count(name) > 1:
                raise fault(f"two cohorts have the name {name!r}; rename one")
        names += [it.name for it in self.sources]
        for i, source in enumerate(self.sources):
            if names.count(source.name) > 1:
                raise fault(
                    f"sources[{i}].name must be unique among sources and"
                    f" cohorts, got {source.name!r}; rename one"
                )
        sinks = [it.name for it in self.sinks]
        for i, sink in enumerate(sinks):
            if sinks.count(sink) > 1:
                raise fault(
                    f"sinks[{i}].name must be unique, got {sink!r}; rename one"
                )
        for place, members in self.members():
            for name in members.sinks:
                if name not in sinks:
                    raise fault(
                        f"{place}.sinks: there is no sink {name!r}"
                        f"{did_you_mean(name, sinks)}; the sinks are"
                        f" {', '.join(sinks) or 'none'}"
                    )
        return self

    def members(self) -> Iterator[tuple[str, "CohortConfig | SourceConfig"]]:
        """Yields cohorts, then sources, each with its place, "cohorts[0]"."""
        for i, cohort in enumerate(self.cohorts):
            yield f"cohorts[{i}]", cohort
        for i, source in enumerate(self.sources):
            yield f"sources[{i}]", source

    @property
    def number(self) -> int:
        """How many people are drawn."""
        return sum(members.number for _, members in self.members())
