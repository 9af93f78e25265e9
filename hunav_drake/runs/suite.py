"""The schema of a suite: scenarios, planners, settings and seeds."""

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
from hunav_drake.scenario.generate.kind import KINDS, ScenarioKind
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
        "must be the number of seeds, from 1 to {most}, or a list of different"
        " seeds, from 0 on, got {value}",
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


# A planner: its name, or a mapping of its `type` and parameters; `label` is its
# name in tables.
PlannerChoice = (
    StrictStr | Annotated[dict[str, Any], AfterValidator(_check_label)]
)


ScenarioChoice = Annotated[
    StrictStr | Annotated[ScenarioKind, KINDS],
    Field(union_mode="left_to_right"),
]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Until:
    """Stopping rule: a cell has enough runs once a mean is precise enough."""

    metric: Name
    """The metric whose mean counts."""

    half_width: Annotated[StrictFloat, within(0, low_open=True)]
    """The largest half width of its 95 % interval, in the metric's unit."""

    least: Annotated[Integer, Field(ge=3, le=MAX_SEEDS)] = 6
    """The smallest number of seeds: intervals of fewer are unreliable."""


def _check_formula(value: str) -> str:
    try:
        check_formula(value)
    except ValueError as error:
        raise PydanticCustomError(
            "rule", "{rule}, got {value}", {"rule": error, "value": repr(value)}
        ) from None
    return value


# The certainty that a relation should hold.
Strength = Literal["strong", "medium", "weak"]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Relation:
    """An expected relation between the means of planners."""

    number: Annotated[Integer, Field(ge=0)] = 0
    """The number of the relation in lists."""

    scenarios: Annotated[list[Name], Field(min_length=1)]
    """The scenarios. With several scenarios, names in the formula consist of
    planner and scenario, as in dwb_passing."""

    metric: Name
    """The metric."""

    by: Literal["planner", "behavior", "both"] = "planner"
    """The names in the formula: `planner`; `behavior`, and the formula must
    hold for every planner in each scenario; or `both`, as in dwb_curious, in
    each scenario."""

    holds: Annotated[StrictStr, AfterValidator(_check_formula)]
    """A comparison of names and numbers, or several of them with `and`, `or`
    and `not`: sfw >= 1.15 * dwb and scl < sfw."""

    strength: Strength = "medium"
    """The certainty that the relation should hold."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Suite:
    """Trials to compare planners: each scenario with each planner.

    A cell is a scenario, a planner and a setting; it is run with each seed.
    """

    name: Annotated[FileName, Field(min_length=1)] = "suite"
    """Name of the suite and of its folder of results."""

    description: StrictStr = ""
    """Purpose of the suite, in one line."""

    version: Name = "1"
    """Version of the suite, which is part of the results."""

    scenarios: Annotated[list[ScenarioChoice], Field(min_length=1)]
    """Shipped scenarios by name, or files, relative to the suite's file; or
    kinds of generated scenarios, as {type: rooms, people: 6}: each seed has a
    world of its own."""

    planners: list[PlannerChoice] = field(default_factory=list)
    """Planners: names, or mappings as in a scenario, {type: dwb, ...}, perhaps
    with a `label`; by default the planner of each scenario."""

    settings: dict[Name, list[StrictStr]] = field(default_factory=dict)
    """Settings by name, each with a list of changes as for --set; by default
    one setting without changes."""

    overrides: list[StrictStr] = field(default_factory=list)
    """Changes for all runs, as for --set."""

    seeds: Seeds = 10
    """The seeds, or their number: n means 0 to n - 1. With `until`, the
    maximum. If seeds draw nothing, a cell is run only with the first one."""

    seeds_of: dict[Name, Seeds] = field(default_factory=dict)
    """Seeds of single scenarios, by name, instead of `seeds`."""

    repetitions: Annotated[Integer, Field(ge=1, le=1000)] = 1
    """Number of runs for each seed; more than one only shows whether a user's
    planner is deterministic. The mean over repetitions counts once. If seeds
    draw nothing, planners of the package are run once."""

    until: Until | None = None
    """Stopping rule for a cell; by default it is run with all seeds."""

    relations: list[Relation] = field(default_factory=list)
    """Expected relations between means."""

    relative: StrictBool = False
    """Whether each run is compared with the same trial without the people, and
    without the robot, as by `hunav run --relative`."""

    identities: StrictBool = False
    """Whether to test identities that hold in the paper's experiment."""

    def seed_list(self, scenario: str) -> list[int]:
        """Returns the seeds of a scenario."""
        seeds = self.seeds_of.get(scenario)
        if seeds is None:
            seeds = self.seeds
        return list(range(seeds)) if isinstance(seeds, int) else list(seeds)


def planner_overrides(choice: PlannerChoice) -> tuple[str, Mapping[str, Any]]:
    """Returns the label of a planner, and its keys for a scenario."""
    if isinstance(choice, str):
        return choice, {TAG: choice}
    keys = dict(with_tag("planner", choice))
    label = keys.pop("label", None)
    if label is None:
        name = str(keys.get(TAG, ""))
        rest = (f"{k}={v}" for k, v in keys.items() if k != TAG)
        label = " ".join([name, *rest])
    return str(label), keys
