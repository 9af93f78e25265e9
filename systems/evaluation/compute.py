"""Metrics and people of a recording as pandas tables."""

from collections.abc import Iterable, Mapping, Sequence
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import FLEET_FAMILY, base_name
from hunav_drake.systems.evaluation.metrics import (
    METRICS,
    Metric,
    select_metrics,
)
from hunav_drake.systems.evaluation.recording import Recording

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    # A trial whose tables nobody asks for need not load it.
    pd = lazy_loader.load("pandas")


class Evaluation(NamedTuple):
    """The metrics of a recording.

    Attributes:
        times: The times of the samples, in seconds.
        values: The values by name.
        series: By name, a number per sample, of the metrics that have one.
        units: The units by name.
    """

    times: Array
    values: dict[str, float]
    series: dict[str, Array]
    units: dict[str, str]

    def table(self) -> "pd.Series":
        """Returns the values; their units are in `attrs["units"]`."""
        table = pd.Series(self.values, dtype=float, name="value")
        table.index.name = "metric"
        # (A user may have added values without units.)
        table.attrs["units"] = {
            name: self.units.get(name, "") for name in self.values
        }
        return table

    def steps(self) -> "pd.DataFrame":
        """Returns the series, as `compute_steps` does."""
        data = (
            np.column_stack(list(self.series.values())) if self.series else None
        )
        frame = pd.DataFrame(
            data,
            index=pd.Index(self.times, name="time"),
            columns=list(self.series),
            dtype=float,
        )
        frame.attrs["units"] = {name: self.units[name] for name in self.series}
        return frame


def compute_metrics(
    recording: Recording, names: Iterable[str] = ("all",)
) -> "pd.Series":
    """Returns the values of metrics.

    Args:
        recording: The recorded trial.
        names: Names of metrics, their aliases, families, "paper" or "all".

    Returns:
        The values by name; their units by name are in `attrs["units"]`.

    Raises:
        ValueError: If a name is unknown.
    """
    return evaluate(recording, names).table()


def compute_steps(
    recording: Recording, names: Iterable[str] = ("all",)
) -> "pd.DataFrame":
    """Returns the series of the metrics that have one.

    Takes and raises the same as `compute_metrics`.

    Returns:
        A row per sample, indexed by the time in seconds, and a column per
        metric; the units by name are in `attrs["units"]`.
    """
    return evaluate(recording, names).steps()


def compute_by_behavior(
    recording: Recording, names: Iterable[str] = ("all",)
) -> "pd.DataFrame":
    """Returns the metrics by behavior, from the people of that behavior alone.

    Takes and raises the same as `compute_metrics`.

    Returns:
        A row per behavior present, in the order of its first person, and a
        column per metric; the units are in `attrs["units"]`.
    """
    names = list(names)
    columns = metric_columns(recording, names)
    table = behavior_table(evaluate_by_behavior(recording, names), columns)
    table.attrs["units"] = {it: METRICS[base_name(it)].unit for it in columns}
    return table


def evaluate(
    recording: Recording, names: Iterable[str] = ("all",)
) -> Evaluation:
    """Computes metrics. Takes and raises the same as `compute_metrics`.

    With several robots, those of each one until its end have its name and a dot
    before theirs. Metrics of robots with each other follow.
    """
    metrics = select_metrics(names, recording)
    if recording.others:
        mutual = [m for m in metrics if m.family == FLEET_FAMILY]
        own = [m.name for m in metrics if m.family != FLEET_FAMILY]
        found = [
            _named(evaluate(it.until_end(), own), it, len(recording))
            for it in recording.robots
        ]
        return _joined(recording, [*found, _evaluate(recording, mutual)])
    return _evaluate(recording, metrics)


def metric_columns(
    recording: Recording, names: Iterable[str] = ("all",)
) -> list[str]:
    """Returns the names of values that `evaluate` gives."""
    metrics = select_metrics(names, recording)
    if not recording.others:
        return [m.name for m in metrics]
    own = [m.name for m in metrics if m.family != FLEET_FAMILY]
    named = [f"{it.robot_name}.{n}" for it in recording.robots for n in own]
    return named + [m.name for m in metrics if m.family == FLEET_FAMILY]


def _named(found: Evaluation, robot: Recording, size: int) -> Evaluation:
    """Returns the metrics of a robot with its name; series end with NaN."""
    prefix = f"{robot.robot_name}."
    rest = np.full(size - len(found.times), np.nan)
    return Evaluation(
        found.times,
        {prefix + name: it for name, it in found.values.items()},
        {prefix + it: np.append(s, rest) for it, s in found.series.items()},
        {prefix + name: it for name, it in found.units.items()},
    )


def _joined(recording: Recording, found: Iterable[Evaluation]) -> Evaluation:
    """Returns all metrics as one."""
    result = Evaluation(recording.times, {}, {}, {})
    for it in found:
        result.values.update(it.values)
        result.series.update(it.series)
        result.units.update(it.units)
    return result


def _evaluate(recording: Recording, metrics: Iterable[Metric]) -> Evaluation:
    results = {m.name: m.compute(recording) for m in metrics}
    return Evaluation(
        recording.times,
        {name: float(value) for name, (value, _) in results.items()},
        {name: s for name, (_, s) in results.items() if s is not None},
        {m.name: m.unit for m in metrics},
    )


def evaluate_by_behavior(
    recording: Recording, names: Iterable[str] = ("all",)
) -> dict[str, Evaluation]:
    """Computes metrics by behavior, as `compute_by_behavior` does.

    There is another series: `behavior_active` is 1 while any person of that
    behavior reacts to the robot.
    """
    names = [metric.name for metric in select_metrics(names, recording)]
    found = {}
    for behavior in dict.fromkeys(recording.behaviors):
        part = recording.only(behavior)
        own = evaluate(part, names)
        active = np.asarray(part.behavior_status) != 0
        own.series["behavior_active"] = active.any(axis=1).astype(float)
        own.units["behavior_active"] = "-"
        found[behavior] = own
    return found


def behavior_table(
    found: Mapping[str, Evaluation], names: Sequence[str]
) -> "pd.DataFrame":
    """Returns the values by behavior, NaN for metrics that have none."""
    return pd.DataFrame(
        [
            [it.values.get(name, math.nan) for name in names]
            for it in found.values()
        ],
        index=pd.Index(list(found), name="behavior", dtype=object),
        columns=list(names),
        dtype=float,
    )


def count_people(recording: Recording) -> "pd.DataFrame":
    """Counts the people of a recording over time.

    Arrivals and departures between two samples count at the later one. A person
    who leaves and returns between them is not counted; `OpenCrowd` keeps people
    outside for a second, so sample periods up to that count everybody.

    Returns:
        A row per sample, indexed by the time, in seconds, with the columns
        "present", the number of people, and "arrivals" and "departures", their
        numbers since the first sample. So present = present at the first sample
        + arrivals - departures.
    """
    present = recording.features.present
    change = np.diff(present.astype(int), axis=0, prepend=present[:1])
    return pd.DataFrame(
        {
            "present": present.sum(axis=1),
            "arrivals": (change > 0).sum(axis=1).cumsum(),
            "departures": (change < 0).sum(axis=1).cumsum(),
        },
        index=pd.Index(recording.times, name="time"),
    )
