"""Metrics and people of a recording as pandas tables."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from hunav_drake.systems.evaluation.metrics import Metric, select_metrics
from hunav_drake.systems.evaluation.recording import Recording


def compute_metrics(
    recording: Recording, names: Iterable[str] = ("all",)
) -> pd.Series:
    """Returns the values of metrics.

    Args:
        recording: The recorded trial.
        names: Names of metrics, their aliases, families, "paper" or "all".

    Returns:
        The values by name; their units by name are in `attrs["units"]`.

    Raises:
        ValueError: If a name is unknown.
    """
    return evaluate(recording, names)[0]


def compute_steps(
    recording: Recording, names: Iterable[str] = ("all",)
) -> pd.DataFrame:
    """Returns the series of the metrics that have one.

    Takes and raises the same as `compute_metrics`.

    Returns:
        A row per sample, indexed by the time in seconds, and a column per
        metric; the units by name are in `attrs["units"]`.
    """
    return evaluate(recording, names)[1]


def compute_by_behavior(
    recording: Recording, names: Iterable[str] = ("all",)
) -> pd.DataFrame:
    """Returns the metrics by behavior, from the people of that behavior alone.

    Takes and raises the same as `compute_metrics`.

    Returns:
        A row per behavior present, in the order of its first person, and a
        column per metric; the units are in `attrs["units"]`.
    """
    return evaluate_by_behavior(recording, names)[0]


def evaluate(
    recording: Recording, names: Iterable[str] = ("all",)
) -> tuple[pd.Series, pd.DataFrame]:
    """Returns the values of metrics and their series."""
    metrics = select_metrics(names)
    results = {m.name: m.compute(recording) for m in metrics}
    values = {name: value for name, (value, _) in results.items()}
    series = {name: s for name, (_, s) in results.items() if s is not None}
    table = pd.Series(values, dtype=float, name="value")
    table.index.name = "metric"
    table.attrs["units"] = _units(metrics)
    data = np.column_stack(list(series.values())) if series else None
    frame = pd.DataFrame(
        data,
        index=pd.Index(recording.times, name="time"),
        columns=list(series),
        dtype=float,
    )
    frame.attrs["units"] = {m.name: m.unit for m in metrics if m.name in series}
    return table, frame


def evaluate_by_behavior(
    recording: Recording, names: Iterable[str] = ("all",)
) -> tuple[pd.DataFrame, dict[str, pd.DataFrame]]:
    """Returns the values of metrics by behavior and their series.

    The frames of series have another column: `behavior_active` is 1 while any
    person of that behavior reacts to the robot.
    """
    metrics = select_metrics(names)
    rows = {}
    frames = {}
    for behavior in dict.fromkeys(recording.behaviors):
        part = recording.only(behavior)
        values, steps = evaluate(part, [m.name for m in metrics])
        rows[behavior] = values.to_numpy()
        active = np.asarray(part.behavior_status) != 0
        steps["behavior_active"] = active.any(axis=1).astype(float)
        steps.attrs["units"] |= {"behavior_active": "-"}
        frames[behavior] = steps
    table = pd.DataFrame(
        list(rows.values()),
        index=pd.Index(list(rows), name="behavior", dtype=object),
        columns=[m.name for m in metrics],
        dtype=float,
    )
    table.attrs["units"] = _units(metrics)
    return table, frames


def _units(metrics: list[Metric]) -> dict[str, str]:
    return {m.name: m.unit for m in metrics}


def count_people(recording: Recording) -> pd.DataFrame:
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
