"""The result of a trial, and its table for a terminal."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import textwrap
from typing import Literal
import warnings

import pandas as pd

from hunav_drake.systems.evaluation.compute import (
    evaluate,
    evaluate_by_behavior,
)
from hunav_drake.systems.evaluation.metrics import select_metrics
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.metric_facts import (
    facts_of,
    family_of,
    headline_of,
    unit_of,
)
from hunav_drake.trial.provenance import Provenance
from hunav_drake.trial.quantity_text import number_text, unit_text

# "end" is for recordings of other programs, which do not give a reason;
# "planner_failed" for a trial with a failing planner.
EndReason = Literal[
    "goal", "timeout", "stuck", "planner_failed", "end", "running"
]

# The widest line of a table in the terminal.
_WIDTH = 80


@dataclass(frozen=True, kw_only=True)
class TrialResult:
    """The result of a trial that has ended.

    Attributes:
        scenario_name: The name of the scenario.
        metrics: The values by name; in `attrs`, by name, their "units",
            "families" and "directions".
        steps: A row per sample, indexed by time in seconds, and a column per
            metric with a time series.
        by_behavior: A row per behavior, with the metrics as if only the
            people of that behavior were present.
        steps_by_behavior: The steps for each behavior, with a column
            `behavior_active`, which is 1 or 0.
        recording: The recording of the trial.
        provenance: The origin of the result: see `MakeProvenance`.
        end_reason: Why the trial ended.
        end_message: The same in words.
        end_time: The simulated time of the end, in seconds.
        setting: Difference from other runs of the same planner in the same
            scenario, apart from the seed; empty if there is none. Statistics
            treat settings separately.
        tag: Identifier among the results in the folder that it was read from:
            see `LoadResults`.
    """

    scenario_name: str
    metrics: pd.Series
    steps: pd.DataFrame
    by_behavior: pd.DataFrame
    steps_by_behavior: dict[str, pd.DataFrame]
    recording: Recording
    provenance: Provenance
    end_reason: EndReason
    end_message: str
    end_time: float
    setting: str = ""
    tag: str = ""


def MakeTrialResult(
    recording: Recording,
    *,
    scenario_name: str = "",
    metric_names: str | Iterable[str] = "all",
    provenance: Provenance,
    end_reason: EndReason,
    end_message: str = "",
    end_time: float | None = None,
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

    Raises:
        ValueError: If a name is unknown.
    """
    names = [metric.name for metric in select_metrics(metric_names)]
    metrics, steps = _without_failures(
        lambda some: evaluate(recording, some), names
    )
    # Metrics that failed for all people are not tried again.
    by_behavior, steps_by_behavior = _without_failures(
        lambda some: evaluate_by_behavior(recording, some),
        list(metrics.index),
        " by behavior",
    )
    metrics = metrics.reindex(names)
    by_behavior = by_behavior.reindex(columns=names)
    metrics.attrs |= facts_of(names)
    by_behavior.attrs |= facts_of(names)
    return TrialResult(
        scenario_name=scenario_name,
        metrics=metrics,
        steps=steps,
        by_behavior=by_behavior,
        steps_by_behavior=steps_by_behavior,
        recording=recording,
        provenance=dict(provenance),
        end_reason=end_reason,
        end_message=end_message,
        end_time=float(recording.times[-1] if end_time is None else end_time),
    )


def _without_failures[Tables](
    compute: Callable[[list[str]], Tables], names: list[str], how: str = ""
) -> Tables:
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
    names = [str(name) for name in result.metrics.index]
    families: dict[str, list[str]] = {}
    if headline_only:
        families[""] = headline_of(result.metrics)
    else:
        for name in names:
            family = family_of(result.metrics, name)
            families.setdefault(family, []).append(name)
    lines = _heading(result)
    for family, members in families.items():
        lines += ["", family] if family else [""]
        for name in members:
            unit = unit_of(result.metrics, name)
            value = _align(number_text(float(result.metrics[name]), unit))
            line = f"  {name:<36} {value} {unit_text(unit)}".rstrip()
            lines.append(_shorten(line))
    return "\n".join(lines)


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
