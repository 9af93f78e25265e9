"""The row of one run, in the log of its folder and in all tables."""

from collections.abc import Iterable, Mapping
import json
import math
from types import SimpleNamespace
from typing import (
    TYPE_CHECKING,
    Any,
    Literal,
    NamedTuple,
    NotRequired,
    TypedDict,
)

from pydantic import TypeAdapter, ValidationError

from hunav_drake.systems.common.plain_errors import message_of
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.trial.metric_facts import (
    FACTS,
    Facts,
    Table,
    direction_of,
    facts_of,
    family_of,
    is_built_in,
    unit_of,
)
from hunav_drake.trial.provenance import Provenance
from hunav_drake.trial.result import EndReason, TrialResult

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.recording import Recording

# The end reason of a run that raised an error.
ERROR: Literal["error"] = "error"

# The end reason of a run whose worker died: the next start repeats it.
LOST: Literal["worker_died"] = "worker_died"

# The end reasons of runs without metrics.
NO_RESULT = (ERROR, LOST)

# The end reasons of failures, which do not count as results of a planner.
FAILED = (*NO_RESULT, "planner_failed")

_NOTHING: dict[str, Any] = {}

# Numbers that JSON does not have.
_NOT_FINITE = {None: math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


class MetricFacts(TypedDict):
    """Facts about a metric."""

    unit: str
    family: str
    direction: Literal["lower", "higher", "none"]


class RunRow(NamedTuple):
    """The data of a run, from any command.

    Attributes:
        scenario: The name of the scenario.
        planner: The name of the planner; in a suite, its label.
        setting: A name that distinguishes it from runs of the same planner in
            the same scenario, apart from the seed; may be empty.
        seed: Its seed; None for a recording of another program.
        end_reason: As in `TrialResult`, or "error", or "worker_died".
        end_message: The same in words.
        end_time: In seconds of simulated time; NaN without a result.
        metrics: The values by name.
        by_behavior: The values by behavior, then by name.
        repetition: The index among the runs of that seed, from 0.
        drawn: What the seed draws: see `ReadRuns`.
        facts: Facts about metrics that are not part of this package.
        tag: The name of the folder of its files, if it has one.
        provenance: As in `TrialResult`, for a run with a folder.
        sha256: The hash of its cell, for a run of a suite.
        code_sha256: The hash of the code that ran it: see `hash_of_all`.
        cost: Durations in seconds by name: "wall" and "cpu" of the whole run,
            and "cycle_median" and "cycle_p95" of the planner's cycles, if
            known. Only these differ between equal runs.
        extras: Further numbers by name: see `extra_values`.
        robot_ends: Why each of several robots ended, by its name.
        recording: The recording, if requested; it is not written to the log.
    """

    scenario: str
    planner: str
    setting: str
    seed: int | None
    end_reason: Literal[EndReason, "error", "worker_died"]
    end_message: str
    end_time: float
    metrics: dict[str, float]
    by_behavior: dict[str, dict[str, float]]
    repetition: int = 0
    drawn: str = ""
    facts: dict[str, MetricFacts] = _NOTHING
    tag: str = ""
    provenance: Provenance = _NOTHING
    sha256: str = ""
    code_sha256: str = ""
    cost: dict[str, float] = _NOTHING
    extras: dict[str, float] = _NOTHING
    robot_ends: dict[str, str] = _NOTHING
    recording: "Recording | None" = None

    @property
    def cell(self) -> str:
        """The name of its cell in messages."""
        return cell_name(self.scenario, self.planner, self.setting)

    @property
    def key(self) -> tuple[str, int | None, int]:
        """The identity of a run in a suite."""
        return self.sha256, self.seed, self.repetition

    @property
    def attrs(self) -> dict[str, Facts]:
        """The facts about its metrics, as the `attrs` of a table."""
        return table_facts(self.metrics, self.facts)


# The types of its fields, to check the rows of files. (mypy accepts only
# literal names.)
_FIELDS: TypeAdapter[Any] = TypeAdapter(
    TypedDict(  # type: ignore[operator]
        "_Fields",
        {
            name: NotRequired[kind] if name in RunRow._field_defaults else kind
            for name, kind in RunRow.__annotations__.items()
            if name != "recording"
        },
    )
)


def cell_name(scenario: str, planner: str, setting: str) -> str:
    """Returns the name of a cell: "crossing/dwb"."""
    return "/".join(part for part in (scenario, planner, setting) if part)


def make_row(result: TrialResult, tag: str = "") -> RunRow:
    """Returns the row of a finished trial."""
    metrics = dict(result.tables.values)
    about = result.provenance
    seed = about.get("seed")
    return RunRow(
        scenario=result.scenario_name,
        planner=str(about.get("planner", "")),
        setting=result.setting,
        seed=None if seed is None else int(seed),
        end_reason=result.end_reason,
        end_message=result.end_message,
        end_time=result.end_time,
        metrics=metrics,
        by_behavior=result.tables.values_by_behavior,
        drawn=str(about.get("drawn", "")),
        facts={
            name: _facts(result.tables, name)
            for name in metrics
            if not is_built_in(name)
        },
        tag=tag or result.tag,
        provenance=about,
        robot_ends=dict(result.robot_ends),
    )


def table_facts(
    names: Iterable[str], own: Mapping[str, MetricFacts]
) -> dict[str, Facts]:
    """Returns the `attrs` of a table with some metrics.

    Args:
        names: The metrics.
        own: Facts about the metrics that are not part of this package.
    """
    attrs = facts_of(name for name in names if base_name(name) in METRICS)
    for name, facts in own.items():
        for fact, key in FACTS.items():
            # (mypy accepts only literal names.)
            attrs[key][name] = facts[fact]  # type: ignore[literal-required]
    return attrs


def row_to_json(row: RunRow) -> str:
    """Returns a row as one line of JSON, without its recording.

    Numbers are exact to the last bit. NaN is null, and infinity is the text
    "Infinity" or "-Infinity".
    """
    return json.dumps(_plain(row), allow_nan=False)


def result_to_json(row: RunRow) -> str:
    """Returns a row as readable JSON, with the facts about each metric."""
    data = _plain(row)
    data.pop("facts", None)
    table = SimpleNamespace(attrs=row.attrs)
    data["metrics"] = {
        name: {"value": value, **_facts(table, name)}
        for name, value in data["metrics"].items()
    }
    return json.dumps(data, indent=2, allow_nan=False)


def row_from_json(text: str | bytes) -> RunRow:
    """Returns the row of a line of a log, or of a file `result.json`.

    Raises:
        ValueError: If it is not a row; the message has field, rule and value.
    """
    try:
        data: Any = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"the file: Invalid JSON: {error}") from error
    if isinstance(data, dict):
        _complete(data)
    try:
        row = RunRow(**_FIELDS.validate_python(data, strict=True))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        place = ".".join(map(str, fault["loc"])) or "the file"
        text = message_of(fault["type"], fault)
        raise ValueError(f"{place}: {text}") from error
    if unknown := sorted(data.keys() - row._asdict()):
        raise ValueError(f"there is no field {shown(unknown[0])}")
    if row.end_reason not in NO_RESULT and not math.isfinite(row.end_time):
        raise ValueError("end_time: must be a finite number, got NaN")
    return row


def plain_number(value: float) -> float | str | None:
    """Returns a number for JSON: see `row_to_json`."""
    if math.isfinite(value):
        return float(value)
    return None if math.isnan(value) else f"{'-' * (value < 0)}Infinity"


def _plain(row: RunRow) -> dict[str, Any]:
    """Returns a row as plain data, without default values."""
    defaults = RunRow._field_defaults

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(item) for key, item in value.items()}
        return plain_number(value) if isinstance(value, float) else value

    return {
        name: plain(value)
        for name, value in row._asdict().items()
        if name != "recording"
        and (name not in defaults or value != defaults[name])
    }


def _complete(data: dict[str, Any]) -> None:
    """Converts the data of a file to the fields of a row, in place."""
    if "cell" in data:
        # A log of an older version.
        names = [*str(data.pop("cell")).split("/", 2), "", ""]
        data |= zip(RunRow._fields[:3], names[:3], strict=True)
    about = data.get("provenance")
    if isinstance(about, dict):
        # A `result.json` of an older version.
        for name, missing in (("planner", ""), ("seed", None), ("drawn", "")):
            data.setdefault(name, about.get(name, missing))
    data.setdefault("setting", "")
    metrics, own = data.get("metrics"), {}
    if isinstance(metrics, dict):
        for name, it in metrics.items():
            if isinstance(it, dict):
                metrics[name] = it.pop("value", it)
                if not is_built_in(name):
                    own[name] = it
        if own:
            data["facts"] = own
    parts = data.get("by_behavior")
    parts = list(parts.values()) if isinstance(parts, dict) else []
    for values in (metrics, data.get("cost"), data.get("extras"), *parts):
        if isinstance(values, dict):
            for name, it in values.items():
                if it is None or isinstance(it, str):
                    values[name] = _NOT_FINITE.get(it, it)
    if data.get("end_time", 0) is None:
        data["end_time"] = math.nan


def _facts(table: Table, name: str) -> MetricFacts:
    told: Any = {
        "unit": unit_of(table, name),
        "family": family_of(table, name),
        "direction": direction_of(table, name),
    }
    facts: MetricFacts = told
    return facts
