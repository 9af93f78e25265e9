"""The result of a trial, and its table for a terminal."""

from collections.abc import Callable, Iterable, Mapping
import csv
import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
import io
import math
import os
import textwrap
from typing import TYPE_CHECKING, Literal
import warnings

from hunav_drake.systems.evaluation.compute import (
    Evaluation,
    behavior_table,
    evaluate,
    evaluate_by_behavior,
    metric_columns,
)
from hunav_drake.systems.evaluation.metric import DERIVED_FAMILIES, base_name
from hunav_drake.systems.evaluation.metrics import select_metrics
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.metric_facts import (
    FACTS,
    facts_of,
    family_of,
    headline_of,
    unit_of,
)
from hunav_drake.trial.provenance import Provenance
from hunav_drake.trial.quantity_text import number_text, unit_text

if TYPE_CHECKING:
    import pandas as pd

# "end" is for recordings of other programs, which do not give a reason, and for
# one of several robots that has no goal;
# "planner_failed" for a trial with a failing planner.
EndReason = Literal[
    "goal", "timeout", "stuck", "planner_failed", "end", "running"
]

# The format of numbers in tables: without rounding errors.
CSV_NUMBERS = "%.12g"

# The widest line of a table in the terminal.
_WIDTH = 80


class MetricTables:
    """The metrics of a trial, as tables that are made when first asked for.

    They are made once, so that changes of a table count from then on.

    Attributes:
        evaluation: The metrics; NaN where one could not be computed.
        evaluations_by_behavior: The metrics of each behavior, as if only its
            people were present.
    """

    def __init__(
        self,
        evaluation: Evaluation,
        evaluations_by_behavior: dict[str, Evaluation],
        attrs: Mapping[str, dict[str, str]],
    ) -> None:
        """Constructs MetricTables: see the attributes."""
        self.evaluation = evaluation
        self.evaluations_by_behavior = evaluations_by_behavior
        self._attrs = attrs

    @property
    def attrs(self) -> Mapping[str, dict[str, str]]:
        """By name of a metric, its "units", "families" and "directions"."""
        if "metrics" not in vars(self):
            return self._attrs
        attrs: Mapping[str, dict[str, str]] = self.metrics.attrs
        return attrs

    @property
    def values(self) -> dict[str, float]:
        """The values by name: those of `metrics`."""
        if "metrics" not in vars(self):
            return self.evaluation.values
        return {str(k): float(v) for k, v in self.metrics.items()}

    @property
    def values_by_behavior(self) -> dict[str, dict[str, float]]:
        """The values by behavior and name: those of `by_behavior`."""
        if "by_behavior" not in vars(self):
            return {
                behavior: {
                    name: it.values.get(name, math.nan)
                    for name in self._names_by_behavior
                }
                for behavior, it in self.evaluations_by_behavior.items()
            }
        return {
            str(behavior): {str(k): float(v) for k, v in row.items()}
            for behavior, row in self.by_behavior.iterrows()
        }

    @property
    def step_texts(self) -> dict[str | None, str]:
        """The series as texts of CSV: of all people, None, and by behavior."""
        if vars(self).keys() & {"steps", "steps_by_behavior"}:
            return {
                it: frame.to_csv(float_format=CSV_NUMBERS)
                for it, frame in (
                    (None, self.steps),
                    *self.steps_by_behavior.items(),
                )
            }
        parts = (None, self.evaluation), *self.evaluations_by_behavior.items()
        return {it: _steps_text(found) for it, found in parts}

    @property
    def _names_by_behavior(self) -> list[str]:
        families = self._attrs[FACTS["family"]]
        return [
            it
            for it in self.evaluation.values
            if families.get(it) not in DERIVED_FAMILIES
        ]

    @cached_property
    def metrics(self) -> "pd.Series":
        """See `TrialResult.metrics`."""
        table = self.evaluation.table()
        table.attrs |= self._attrs
        return table

    @cached_property
    def steps(self) -> "pd.DataFrame":
        """See `TrialResult.steps`."""
        return self.evaluation.steps()

    @cached_property
    def by_behavior(self) -> "pd.DataFrame":
        """See `TrialResult.by_behavior`."""
        names = self._names_by_behavior
        table = behavior_table(self.evaluations_by_behavior, names)
        table.attrs |= self._attrs
        return table

    @cached_property
    def steps_by_behavior(self) -> "dict[str, pd.DataFrame]":
        """See `TrialResult.steps_by_behavior`."""
        found = self.evaluations_by_behavior
        return {behavior: it.steps() for behavior, it in found.items()}


@dataclass(frozen=True, kw_only=True)
class TrialResult:
    """The result of a trial that has ended.

    Attributes:
        scenario_name: The name of the scenario.
        tables: The metrics.
        recording: The recording of the trial.
        provenance: The origin of the result: see `MakeProvenance`.
        end_reason: Why the trial ended.
        end_message: The same in words.
        end_time: The simulated time of the end, in seconds; of a file that is
            evaluated, its length.
        robot_ends: Why each of several robots ended, by its name.
        setting: Difference from other runs of the same planner in the same
            scenario, apart from the seed; empty if there is none. Statistics
            treat settings separately.
        tag: Identifier among the results in the folder that it was read from:
            see `LoadResults`.
    """

    scenario_name: str
    tables: MetricTables
    recording: Recording
    provenance: Provenance
    end_reason: EndReason
    end_message: str
    end_time: float
    robot_ends: Mapping[str, EndReason] = field(default_factory=dict)
    setting: str = ""
    tag: str = ""

    def __repr__(self) -> str:
        about = self.provenance
        seed = f"seed {about['seed']}" if "seed" in about else ""
        planner = str(about.get("planner", ""))
        told = [self.scenario_name, planner, self.setting, seed]
        return (
            f"<TrialResult of {', '.join(filter(None, told)) or 'a trial'}:"
            f" {self.end_reason} after {self.end_time:.12g} s>"
        )

    @property
    def metrics(self) -> "pd.Series":
        """The values by name.

        By name, its `attrs` have their "units", "families" and "directions".
        """
        return self.tables.metrics

    @property
    def steps(self) -> "pd.DataFrame":
        """The series of the metrics that have one: see `compute_steps`."""
        return self.tables.steps

    @property
    def by_behavior(self) -> "pd.DataFrame":
        """The metrics of each behavior, as if only its people were present."""
        return self.tables.by_behavior

    @property
    def steps_by_behavior(self) -> "dict[str, pd.DataFrame]":
        """The series by behavior, with a column `behavior_active` (1 or 0)."""
        return self.tables.steps_by_behavior


def MakeTrialResult(
    recording: Recording,
    *,
    scenario_name: str = "",
    metric_names: str | Iterable[str] = "all",
    provenance: Provenance,
    end_reason: EndReason,
    end_message: str = "",
    end_time: float | None = None,
    robot_ends: Mapping[str, EndReason] | None = None,
) -> TrialResult:
    """Computes the metrics of a recording.

    A metric that raises an error is NaN, with a warning; all others are kept.

    Args:
        recording: The recording of the trial.
        scenario_name: The name of the scenario.
        metric_names: Names of metrics, their aliases, families, "paper" or
            "all"; or one of these.
        provenance: The origin of the recording.
        end_reason: Why the trial ended.
        end_message: The same in words.
        end_time: The time of the end, in seconds; by default, that of the last
            sample.
        robot_ends: Why each of several robots ended, by its name.

    Raises:
        ValueError: If a name is unknown.
    """
    metrics = select_metrics(metric_names, recording)
    chosen = [metric.name for metric in metrics]
    found = _without_failures(lambda some: evaluate(recording, some), chosen)
    # Metrics that failed for all people are not tried again.
    by_behavior = _without_failures(
        lambda some: evaluate_by_behavior(recording, some),
        list(dict.fromkeys(base_name(name) for name in found.values)),
        " by behavior",
    )
    names = metric_columns(recording, chosen)
    values = {name: found.values.get(name, math.nan) for name in names}
    attrs = facts_of(names)
    return TrialResult(
        scenario_name=scenario_name,
        tables=MetricTables(
            found._replace(values=values, units=attrs[FACTS["unit"]]),
            by_behavior,
            attrs,
        ),
        recording=recording,
        provenance=dict(provenance),
        end_reason=end_reason,
        end_message=end_message,
        end_time=float(recording.times[-1] if end_time is None else end_time),
        robot_ends=robot_ends or {},
    )


def with_situations(result: TrialResult) -> TrialResult:
    """Returns a result that also has metrics by social situation.

    They are those of `situation_values`.
    """
    from hunav_drake.systems.evaluation.situation_values import situation_values

    evaluation = result.tables.evaluation
    return with_values(result, situation_values(result.recording, evaluation))


def with_encounters(result: TrialResult, recording: Recording) -> TrialResult:
    """Returns a result that also has a recording's `encounter_values`."""
    from hunav_drake.systems.evaluation.encounters import encounter_values

    return with_values(result, encounter_values(recording))


def with_values(
    result: TrialResult, more: Mapping[str, tuple[float, dict[str, str]]]
) -> TrialResult:
    """Returns a result with more values.

    By name, each has its "units", "families" and "directions".
    """
    tables = result.tables
    attrs = {
        key: {**tables.attrs.get(key, {})}
        | {name: facts[key] for name, (_, facts) in more.items()}
        for key in FACTS.values()
    }
    evaluation = tables.evaluation._replace(
        values=tables.values | {name: it for name, (it, _) in more.items()},
        units=attrs[FACTS["unit"]],
    )
    tables = MetricTables(evaluation, tables.evaluations_by_behavior, attrs)
    return dataclasses.replace(result, tables=tables)


def _without_failures[Found](
    compute: Callable[[list[str]], Found], names: list[str], how: str = ""
) -> Found:
    """Returns the metrics that can be computed, and warns of the others."""
    try:
        return compute(names)
    except Exception:
        # Find the faulty ones, which takes longer.
        sound = []
        for name in names:
            try:
                compute([name])
            except Exception as error:
                warnings.warn(
                    f"no value{how}: {error}", RuntimeWarning, stacklevel=3
                )
            else:
                sound.append(name)
        return compute(sound)


def FormatMetricsTable(
    result: TrialResult, *, headline_only: bool = False
) -> str:
    """Returns the metrics as a table for the terminal.

    One line per metric, by family: name, value, unit; "-" for no value. No
    line is longer than 80 characters. With `headline_only`, the table has the
    headline metrics only, without families.
    """
    values = result.tables.values
    families: dict[str, list[str]] = {}
    if headline_only:
        families[""] = headline_of(result.tables)
    else:
        for name in values:
            family = family_of(result.tables, name)
            families.setdefault(family, []).append(name)
    lines = _heading(result)
    for family, members in families.items():
        lines += ["", family] if family else [""]
        for name in members:
            unit = unit_of(result.tables, name)
            value = _align(number_text(values[name], unit))
            line = f"  {name:<36} {value} {unit_text(unit)}".rstrip()
            lines.append(_shorten(line))
    return "\n".join(lines)


def _steps_text(found: Evaluation) -> str:
    """Returns what pandas writes of `found.steps()`, without loading it."""
    columns = [found.times, *found.series.values()]
    texts = [
        ["" if math.isnan(it) else CSV_NUMBERS % it for it in column.tolist()]
        for column in columns
    ]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator=os.linesep)
    writer.writerow(["time", *found.series])
    writer.writerows(zip(*texts, strict=True))
    return text.getvalue()


def run_facts(result: TrialResult) -> list[str]:
    """Returns planner, setting and seed of a run, as far as known."""
    told = {
        "planner": result.provenance.get("planner", ""),
        "setting": result.setting,
        "seed": result.provenance.get("seed", ""),
    }
    return [f"{key} {value}" for key, value in told.items() if value != ""]


def how_it_ended(result: TrialResult) -> str:
    """Returns when and why a trial ended, in one line."""
    ended = f"ended after {result.end_time:.2f} s: {result.end_reason}"
    if result.end_message and result.end_message != result.end_reason:
        ended += f" ({result.end_message})"
    return ended


def _heading(result: TrialResult) -> list[str]:
    name = result.scenario_name or "trial"
    about = _shorten(", ".join([name, *run_facts(result)]))
    ended = textwrap.wrap(how_it_ended(result), _WIDTH, subsequent_indent="  ")
    return [about, *ended]


def _align(number: str) -> str:
    """Returns a number aligned at its decimal point."""
    whole, point, decimals = number.partition(".")
    return f"{whole:>8}{point + decimals:<8}"


def _shorten(line: str) -> str:
    return line if len(line) <= _WIDTH else line[: _WIDTH - 3] + "..."
