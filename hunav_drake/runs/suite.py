"""What a suite is: scenarios, planners, settings and seeds."""

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    Field,
    StrictBool,
    StrictFloat,
    StrictStr,
    TypeAdapter,
)
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.runs.formula import check_formula
from hunav_drake.systems.common.old_words import TAG, with_tag
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    FileName,
    Integer,
    Name,
    within,
)
from hunav_drake.systems.common.suggest import shown

MAX_SEEDS = 10**6


def _check_seeds(value: Any) -> int | list[int]:
    seeds = [value] if isinstance(value, int) else value
    if isinstance(seeds, list) and all(type(s) is int for s in seeds):
        if isinstance(value, int) and 1 <= value <= MAX_SEEDS:
            return value
        if (
            isinstance(value, list)
            and 1 <= len(set(value)) == len(value) <= MAX_SEEDS
            and all(0 <= seed < 2**63 for seed in value)
        ):
            return value
    raise PydanticCustomError(
        "rule",
        "must be how many seeds there are, from 1 to {most}, or a list of"
        " different seeds, from 0 on, got {value}",
        {"most": MAX_SEEDS, "value": shown(value)},
    )


Seeds = Annotated[Any, AfterValidator(_check_seeds)]

_LABEL: TypeAdapter[str] = TypeAdapter(
    Annotated[Name, Field(min_length=1)], config=CONFIG
)


def _check_label(value: dict[str, Any]) -> dict[str, Any]:
    if "label" in value:
        _LABEL.validate_python(value["label"])
    return value


# A planner: its name, or a mapping of its `type` and parameters; `label` names
# it in tables.
PlannerChoice = (
    StrictStr | Annotated[dict[str, Any], AfterValidator(_check_label)]
)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Until:
    """When a cell has runs enough: once a mean is known well enough."""

    metric: Name
    """The metric whose mean is to be known."""

    half_width: Annotated[StrictFloat, within(0, low_open=True)]
    """Half the width of its interval of 95 %, in the unit of the metric."""

    least: Annotated[Integer, Field(ge=3, le=MAX_SEEDS)] = 6
    """How many seeds there are at least: an interval of few says little."""


def _check_formula(value: str) -> str:
    try:
        check_formula(value)
    except ValueError as error:
        raise PydanticCustomError(
            "rule", "{rule}, got {value}", {"rule": error, "value": repr(value)}
        ) from None
    return value


# How sure it is that a relation should hold.
Strength = Literal["strong", "medium", "weak"]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Relation:
    """What the means of planners should be, one against the other."""

    number: Annotated[Integer, Field(ge=0)] = 0
    """What it is called in lists."""

    scenarios: Annotated[list[Name], Field(min_length=1)]
    """Where it applies. With several scenarios, names of planners in the
    formula are those of planner and scenario, as in dwb_passing."""

    metric: Name
    """The metric."""

    by: Literal["planner", "behavior", "both"] = "planner"
    """What the names in the formula are: planners; behaviors, for which it is
    to hold with every planner in each scenario; or both, as in dwb_curious, in
    each scenario."""

    holds: Annotated[StrictStr, AfterValidator(_check_formula)]
    """A comparison of names and numbers, or several of them with `and`, `or`
    and `not`: sfw >= 1.15 * dwb and scl < sfw."""

    strength: Strength = "medium"
    """How sure it is that the relation should hold."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Suite:
    """Trials to compare planners by: each scenario with each planner.

    A cell is a scenario, a planner and a setting; it is run with each seed.
    """

    name: Annotated[FileName, Field(min_length=1)] = "suite"
    """What the suite is called; its folder of results is called so, too."""

    description: StrictStr = ""
    """One line on what the suite compares."""

    version: Name = "1"
    """Which of several suites of that name this is. Results tell it."""

    scenarios: Annotated[list[StrictStr], Field(min_length=1)]
    """Names of shipped scenarios, or files. Paths start at the suite's file."""

    planners: list[PlannerChoice] = field(default_factory=list)
    """Planners: names, or mappings as in a scenario, {type: dwb, ...}, to which
    a `label` may be added; by default that of each scenario."""

    settings: dict[Name, list[StrictStr]] = field(default_factory=dict)
    """Settings by name, each a list of changes, as those of --set; by default
    one without changes."""

    overrides: list[StrictStr] = field(default_factory=list)
    """Changes for all runs, as those of --set."""

    seeds: Seeds = 10
    """The seeds, or how many: n means 0 to n - 1. With `until`, the most. Where
    they draw nothing, a cell is run with the first one alone."""

    seeds_of: dict[Name, Seeds] = field(default_factory=dict)
    """The same for single scenarios, by name, instead of the above."""

    repetitions: Annotated[Integer, Field(ge=1, le=1000)] = 1
    """How often each seed is run: more than once only shows whether a planner
    of one's own repeats itself. The mean of a seed counts once. Where seeds
    draw nothing, planners of the package are run once."""

    until: Until | None = None
    """When a cell has enough runs; by default it has all seeds."""

    relations: list[Relation] = field(default_factory=list)
    """What the means should be, one against the other."""

    identities: StrictBool = False
    """Whether to test what holds in every run of the paper's experiment."""

    def seed_list(self, scenario: str) -> list[int]:
        """Returns the seeds of a scenario one by one."""
        seeds = self.seeds_of.get(scenario)
        if seeds is None:
            seeds = self.seeds
        return list(range(seeds)) if isinstance(seeds, int) else list(seeds)


def planner_overrides(choice: PlannerChoice) -> tuple[str, Mapping[str, Any]]:
    """Returns the label of a planner, and its keys as in a scenario."""
    if isinstance(choice, str):
        return choice, {TAG: choice}
    keys = dict(with_tag("planner", choice))
    label = keys.pop("label", None)
    if label is None:
        name = str(keys.get(TAG, ""))
        rest = (f"{k}={v}" for k, v in keys.items() if k != TAG)
        label = " ".join([name, *rest])
    return str(label), keys
