"""A population: people who are drawn or recorded, not listed one by one."""

from collections.abc import Iterator
from dataclasses import field
from typing import Annotated, Literal, Self

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
from hunav_drake.systems.people.human_config import ForcesMode, Level, NeedRate
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.track_config import TracksConfig
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
    """A share of people with uniformly distributed ages."""

    low: Age
    """Lowest age of the band, in years."""

    high: Age
    """Highest age of the band, in years."""

    weight: Weight = 1.0
    """Share of people in the band, in proportion to the other bands."""

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


def _range_of(what: str, unit: str = "") -> AfterValidator:
    """Returns the check of a range: a least and a largest value."""

    def check(ends: tuple[float, float]) -> tuple[float, float]:
        low, high = ends
        if high < low:
            raise fault(
                f"must be a least and a largest {what}, got {low:g} and"
                f" {high:g}{unit}"
            )
        return ends

    return AfterValidator(check)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SpeedDistribution:
    """Normally distributed speeds, independent of age and sex."""

    mean: PositiveSpeed
    """Mean speed, in m/s."""

    deviation: Speed = 0.0
    """Standard deviation, in m/s. All speeds are within three of the mean."""

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
class MemberNeedConfig:
    """A need of people who are drawn: see `NeedConfig`."""

    initial: Annotated[tuple[Level, Level], _range_of("level")] = (0.0, 100.0)
    """Range of the levels at the start, which are drawn uniformly."""

    rate: NeedRate = 1.0
    """Loss of level per second, in 1/s."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class MembersConfig:
    """The common options of people of one kind: how each of them is drawn."""

    name: Annotated[Name, Field(max_length=50)] = ""
    """Name of these people: with "guest" they are guest_1, guest_2, ...; by
    default they are named like people without a name. The draws of a cohort
    depend on its name or, without one, on its index in the list."""

    spacing: Length = 0.1
    """Least gap between two bodies at the start, in meters. With 0.1 about 2
    people fit on a square meter, with 0 about 3."""

    goals: Annotated[list[Area], Field(max_length=1000)] = field(
        default_factory=list
    )
    """Areas of the goals: each person or group has a place of its own in each
    of them, in this order, clear of walls; a point is the same for all. Without
    goals, people stand."""

    shuffle_goals: StrictBool = False
    """Whether each person or group has an order of its own instead."""

    sinks: dict[StrictStr, Weight] = field(default_factory=dict)
    """Sinks at which people leave after their goals, by name, with weights: one
    is drawn for each person or group in proportion to these."""

    goal_radius: PositiveLength = 0.3
    """Distance at which a goal counts as reached, in meters."""

    radius: BodyRadius = 0.35
    """Radius of the disc that others keep clear of, in meters."""

    forces: SocialForceParameters | None = None
    """Weights of the forces, as of a person; by default, those of the crowd's
    profile."""

    forces_mode: ForcesMode = "custom"
    """Source of the factors of the forces: as in `forces` ("custom"), as in
    HuNavSim ("default"), or drawn for each person."""

    body_radius: Annotated[BodyRadii, _range_of("radius", " m")] = (0.2, 0.25)
    """Range of the radii of bodies, which are drawn uniformly, in meters."""

    behaviors: Annotated[
        dict[StrictStr, Weight], AfterValidator(_check_weights)
    ] = field(default_factory=lambda: {"regular": 1.0})
    """Behaviors, by name or by the path of an XML file, with weights in
    proportion to which they are drawn."""

    group_sizes: Annotated[
        list[Weight],
        Field(min_length=1, max_length=20),
        AfterValidator(_check_weights),
    ] = field(default_factory=lambda: [1.0])
    """Sizes of groups: the weights of one person alone, two, three, ... People
    of a group start together, have the same goals and walk as fast as the
    slowest."""

    ages: Annotated[
        list[AgeBand], Field(min_length=1), AfterValidator(_check_bands)
    ] = field(default_factory=lambda: [AgeBand(low=18.0, high=80.0)])
    """Ages, from which, with the sexes, the speeds follow: see
    `hunav_drake.systems.people.walking_speeds`."""

    share_of_women: Share = 0.5
    """Share of women among them; the others are men."""

    figures: Literal["alike", "varied"] = "alike"
    """How they look: "alike" adults, or "varied" by age and sex, of different
    height, some with a backpack or a bag."""

    needs: dict[Name, MemberNeedConfig] = field(default_factory=dict)
    """Needs by name, as of a person."""

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
    """People of one kind who are present from the start."""

    number: Annotated[Integer, Field(ge=0, le=5000)]
    """Number of people."""

    start: Annotated[
        list[Annotated[Area, AfterValidator(_check_start)]], Field(min_length=1)
    ]
    """Areas in which people start, uniformly distributed (no points), with
    their discs of `radius` clear of walls, of the listed people's and of the
    robot's."""

    cyclic: StrictBool | None = None
    """Whether the first goal follows the last; by default as for listed people,
    and not for people who leave at sinks."""

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
    """Name of the source. With "north", its people are north_1, north_2, ..."""

    start: Annotated[list[Area], Field(min_length=1)]
    """Areas in which people come in, uniformly distributed, or a point, with
    their discs of `radius` clear of walls. People without a place wait
    outside."""

    rate: Annotated[StrictFloat, within(0, 100, "people/s")]
    """Mean number of people who come per second. They come independently of
    one another (a Poisson process, drawn by the seed of the trial); those of a
    group come together."""

    max_present: Annotated[Integer, Field(ge=1, le=5000)]
    """Largest number of people of the source who are here at the same time;
    others wait outside. They are the same people again and again: people who
    have left come back in turn."""

    sinks: Annotated[dict[StrictStr, Weight], AfterValidator(_check_weights)]
    """Sinks at which people leave after their goals, at least one, by name,
    with weights: one is drawn for each person or group in proportion to
    these."""

    @property
    def number(self) -> int:
        """The number of people who are drawn."""
        return self.max_present

    @property
    def cyclic(self) -> bool:
        """Whether the first goal follows the last: it never does."""
        return False


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SinkConfig:
    """A place where people leave, as their last goal."""

    name: Annotated[Name, Field(min_length=1, max_length=50)]
    """Name of the sink in sources and cohorts."""

    area: Area
    """Area of the sink. Each person or group walks to its own place in it."""

    radius: Length = 0.3
    """Distance from the area at which people are gone, in meters; so are people
    within their own `goal_radius` of it."""

    rate: Annotated[StrictFloat, within(0.01, 100, "people/s")] | None = None
    """Largest number of people who leave per second, as through a turnstile,
    nearest first; the others wait. By default there is no limit."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class PopulationConfig:
    """People who are drawn or recorded, in addition to those who are listed."""

    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] | None = None
    """Seed from which all draws of the people follow: if given, all trials have
    the same people. By default it is the seed of the trial, so that each trial
    has other people; without a trial, 0."""

    cohorts: list[CohortConfig] = field(default_factory=list)
    """Kinds of people."""

    sources: list[SourceConfig] = field(default_factory=list)
    """Places where people come in while the trial runs."""

    sinks: list[SinkConfig] = field(default_factory=list)
    """Places where people leave."""

    tracks: TracksConfig | None = None
    """Recorded people: all of a file, replayed from the start of the trial on.
    People who walk together there are groups. By default, there are none."""

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
        """The number of people who are drawn."""
        return sum(members.number for _, members in self.members())
