"""The result of a trial: tables, recording, and how it came about."""

from collections.abc import Iterable
from dataclasses import dataclass
import errno
import hashlib
from importlib import metadata
import itertools
import json
import math
from pathlib import Path
import platform
import re
from typing import Any, Literal

import pandas as pd

from hunav_drake.hunav_files import write_hunav_files
from hunav_drake.run_table import append_row, locked
from hunav_drake.systems.evaluation.compute import (
    evaluate,
    evaluate_by_behavior,
)
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.files import atomic_write

# "end" is that of a recording from elsewhere, which does not tell.
EndReason = Literal["goal", "timeout", "stuck", "end"]
Format = Literal["csv", "hunav"]
Provenance = dict[str, str | int]

# The widest line of a table in the terminal.
_WIDTH = 80


@dataclass(frozen=True, kw_only=True)
class TrialResult:
    """All that is known of a trial that has ended.

    Attributes:
        scenario_name: The name of the scenario.
        metrics: The values by name; units in `attrs["units"]`.
        steps: A row per sample, indexed by time in seconds, and a column per
            metric that has a series.
        by_behavior: A row per behavior, with the metrics as if only the
            people of that behavior were there.
        steps_by_behavior: The steps for each behavior, and in the column
            `behavior_active` whether it is 1 or 0.
        recording: What happened.
        provenance: Where it comes from: see `MakeProvenance`.
        end_reason: Why the trial ended.
        end_message: The same in words.
        end_time: When it ended, in seconds of simulated time.
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


def MakeTrialResult(
    recording: Recording,
    *,
    scenario_name: str = "",
    metric_names: Iterable[str] = ("all",),
    provenance: Provenance,
    end_reason: EndReason,
    end_message: str = "",
    end_time: float | None = None,
) -> TrialResult:
    """Computes the metrics of a recording.

    Args:
        recording: What happened.
        scenario_name: The name of the scenario.
        metric_names: Names of metrics, their aliases, families, "paper" or
            "all".
        provenance: Where it comes from.
        end_reason: Why the trial ended.
        end_message: The same in words.
        end_time: When it ended, in seconds; by default with the recording.

    Returns:
        The result.

    Raises:
        ValueError: If a name is unknown.
    """
    names = list(metric_names)
    metrics, steps = evaluate(recording, names)
    by_behavior, steps_by_behavior = evaluate_by_behavior(recording, names)
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


def MakeProvenance(
    scenario_text: str, seed: int, *, planner: str = ""
) -> Provenance:
    """Returns what must be equal for a trial to repeat bit for bit.

    Args:
        scenario_text: The scenario, as `SaveScenario` writes it.
        seed: The seed of everything random.
        planner: The name of the planner that drove the robot.

    Returns:
        The versions of this package, Drake, NumPy, Numba and Python, the type
        of machine, the SHA-256 hash of the scenario, the seed, the planner.
    """
    return {
        **_versions(),
        "scenario_sha256": hashlib.sha256(scenario_text.encode()).hexdigest(),
        "seed": seed,
        "planner": planner,
    }


def MakeSourceProvenance(filename: str | Path) -> Provenance:
    """Returns what must be equal for a recording's metrics to be the same.

    Args:
        filename: The file of the recording.

    Returns:
        The versions and the type of machine as `MakeProvenance` gives them,
        the name of the file, and the SHA-256 hash of its content.

    Raises:
        OSError: If the file cannot be read.
    """
    path = Path(filename)
    return {
        **_versions(),
        "source": path.name,
        "source_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
    }


def _versions() -> Provenance:
    versions = {
        name: metadata.version(name)
        for name in ("hunav_drake", "drake", "numpy", "numba")
    }
    return {
        **versions,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }


def FormatMetricsTable(result: TrialResult) -> str:
    """Returns the metrics as a table for the terminal.

    One line per metric, by family: name, value, unit; "-" for no value. No
    line is longer than 80 characters.
    """
    families: dict[str, list[str]] = {}
    for name in result.metrics.index:
        families.setdefault(METRICS[name].family, []).append(name)
    lines = _heading(result)
    for family, names in families.items():
        lines += ["", family]
        for name in names:
            unit = METRICS[name].unit
            value = _format(float(result.metrics[name]), unit)
            lines.append(f"  {name:<36} {value:>12} {_unit(unit)}".rstrip())
    return "\n".join(_shorten(line) for line in lines)


def _heading(result: TrialResult) -> list[str]:
    planner = result.provenance.get("planner")
    parts = [
        result.scenario_name or "trial",
        f"planner {planner}" if planner else "",
        f"seed {result.provenance['seed']}"
        if "seed" in result.provenance
        else "",
    ]
    ended = f"ended after {result.end_time:.2f} s: {result.end_reason}"
    if result.end_message and result.end_message != result.end_reason:
        ended += f" ({result.end_message})"
    return [", ".join(part for part in parts if part), ended]


def _format(value: float, unit: str) -> str:
    if math.isnan(value):
        return "-"
    if unit == "-" and value.is_integer():
        return f"{value:.0f}    "
    if unit == "%":
        return f"{value:.1f}  "
    if value != 0 and not 5e-4 <= abs(value) < 1e6:
        return f"{value:.3e}"
    return f"{value:.3f}"


def _unit(unit: str) -> str:
    return "" if unit == "-" else unit


def _shorten(line: str) -> str:
    return line if len(line) <= _WIDTH else line[: _WIDTH - 3] + "..."


def WriteResult(
    result: TrialResult,
    directory: str | Path,
    *,
    tag: str | None = None,
    format: Format = "csv",
) -> list[Path]:
    """Writes the files of a result into a folder, beside those of others.

    `recording_<tag>.npz`, `result_<tag>.json` (provenance, end and metrics
    with units), `steps_<tag>.csv`, `steps_<tag>_beh_<behavior>.csv`; and, last
    of all, a row for this run in `metrics_beh_<behavior>.csv` and
    `metrics.csv`: a run in the table is complete. Each file appears in one
    piece. Many processes may write into one folder at a time.

    Args:
        result: What to write.
        directory: The folder; it is made if need be.
        tag: What tells this run from the others in the folder. By default
            scenario, planner and seed, and a number if that is taken.
        format: With "hunav", the four kinds of text files of HuNavSim are
            written besides: see `write_hunav_files`.

    Returns:
        The files that were written or added to.

    Raises:
        OSError: If something cannot be written, or if the tag is taken.
        ValueError: If the tag is not fit for the name of a file, or if a
            table in the folder is damaged.
    """
    directory = Path(directory)
    if tag is not None and (not tag or _safe(tag) != tag):
        raise ValueError(
            f"the tag must be of letters, digits and . _ + - only, got {tag!r}"
        )
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with locked(directory):
            tag = _free_tag(result, directory, tag)
            more = []
            if format == "hunav":
                more = write_hunav_files(
                    directory,
                    tag,
                    metrics=result.metrics,
                    steps=result.steps,
                    by_behavior=result.by_behavior,
                    steps_by_behavior=result.steps_by_behavior,
                )
            return more + _write(result, directory, tag)
    except OSError as error:
        raise OSError(
            error.errno,
            f"cannot write the results: {error.strerror or error}",
            str(error.filename or directory),
        ) from error


def _write(result: TrialResult, directory: Path, tag: str) -> list[Path]:
    paths = [directory / f"recording_{tag}.npz"]
    result.recording.save(paths[0])
    texts = {
        f"result_{tag}.json": json.dumps(_summary(result, tag), indent=2),
        f"steps_{tag}.csv": result.steps.to_csv(),
    }
    for behavior, steps in result.steps_by_behavior.items():
        texts[f"steps_{tag}_beh_{_safe(behavior)}.csv"] = steps.to_csv()
    for name, text in texts.items():
        paths.append(directory / name)
        with atomic_write(paths[-1]) as file:
            file.write(text.encode())
    about = {
        "tag": tag,
        "scenario": result.scenario_name,
        "planner": result.provenance.get("planner", ""),
        "seed": result.provenance.get("seed", ""),
        "end_reason": result.end_reason,
        "end_time": result.end_time,
    }
    rows = {
        f"metrics_beh_{_safe(str(behavior))}.csv": values.to_dict()
        for behavior, values in result.by_behavior.iterrows()
    }
    rows["metrics.csv"] = result.metrics.to_dict()
    for name, values in rows.items():
        paths.append(directory / name)
        append_row(paths[-1], about | values)
    return paths


def _summary(result: TrialResult, tag: str) -> dict[str, Any]:
    units = result.metrics.attrs["units"]
    return {
        "tag": tag,
        "scenario": result.scenario_name,
        "end_reason": result.end_reason,
        "end_message": result.end_message,
        "end_time": result.end_time,
        "provenance": result.provenance,
        "metrics": {
            name: {
                "value": None if math.isnan(value) else value,
                "unit": units[name],
            }
            for name, value in result.metrics.items()
        },
    }


def _free_tag(result: TrialResult, directory: Path, tag: str | None) -> str:
    """Returns the tag, or one that no run in the folder has."""

    def taken(candidate: str) -> Path | None:
        names = ("recording_{}.npz", "result_{}.json", "steps_{}.csv")
        paths = [directory / name.format(candidate) for name in names]
        return next((path for path in paths if path.exists()), None)

    if tag is not None:
        path = taken(tag)
        if path is not None:
            raise FileExistsError(
                errno.EEXIST, f"the tag {tag!r} is taken", str(path)
            )
        return tag
    parts = [
        result.scenario_name or "trial",
        result.provenance.get("planner"),
        result.provenance.get("seed"),
    ]
    base = _safe("_".join(str(p) for p in parts if p not in (None, "")))
    return next(
        candidate
        for candidate in (
            base if i == 1 else f"{base}_{i}" for i in itertools.count(1)
        )
        if taken(candidate) is None
    )


def _safe(text: str) -> str:
    """Returns a text that may be part of the name of a file."""
    return re.sub(r"[^A-Za-z0-9._+-]+", "_", text)
