"""The files of results: a folder holds those of one run or of many."""

import dataclasses
import errno
import hashlib
import itertools
import json
import math
from pathlib import Path
import re
import time
from typing import Any, Literal

import pandas as pd

from hunav_drake.results.metric_facts import (
    FACTS,
    direction_of,
    family_of,
    unit_of,
)
from hunav_drake.results.run_table import ReadRuns, run_row
from hunav_drake.results.text_table import append_row, locked, read_rows
from hunav_drake.results.trial_result import MakeTrialResult, TrialResult
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording

Format = Literal["csv", "hunav"]

# The longest part of the name of a file that is made of other names.
_LONGEST = 80

# A draft of a file that is older than this has lost its writer, in seconds.
_STALE = 600.0


def WriteResult(
    result: TrialResult,
    directory: str | Path,
    *,
    tag: str | None = None,
    label: str | None = None,
    format: Format = "csv",
) -> list[Path]:
    """Writes the files of a result into a folder, beside those of others.

    `recording_<tag>.npz`, `result_<tag>.json` (provenance, end, and metrics
    with what is known of them), `steps_<tag>.csv`,
    `steps_<tag>_beh_<behavior>.csv`; and, last of all, a row for this run in
    `metrics_beh_<behavior>.csv` and `metrics.csv`: a run in the table is
    complete. Numbers in tables have all their digits, so that they are the
    same again when read. Each file appears in one piece. Many processes may
    write into one folder at a time.

    A behavior whose name is not fit for that of a file is told apart by a hash
    after what is left of it; the column `behavior` has its name. JSON knows no
    numbers that are not finite: NaN is null, and infinity is the text
    "Infinity" or "-Infinity".

    Args:
        result: What to write.
        directory: The folder; it is made if need be.
        tag: What tells this run from the others in the folder. By default
            scenario, planner and seed, and a number if that is taken. Files
            with this tag of a run that is not in the table, since it was
            killed, are written over.
        label: The setting, instead of the result's own: what tells this run
            from those of the same planner in the same scenario that differ by
            more than the seed. Statistics keep settings apart.
        format: With "hunav", the four kinds of text files of HuNavSim are
            written besides: see `write_hunav_files`.

    Returns:
        The files that were written or added to; `GetTag` tells the tag.

    Raises:
        OSError: If something cannot be written, or if the tag is taken.
        ValueError: If the tag is not fit for the name of a file, or if a
            table in the folder is damaged. The recording is kept then.
    """
    directory = Path(directory)
    if label is not None:
        result = dataclasses.replace(result, setting=label)
    if tag is not None and (not tag or _safe(tag) != tag):
        raise ValueError(
            f"the tag must be of letters, digits and . _ + - only, got {tag!r}"
        )
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with locked(directory):
            _remove_stale_drafts(directory)
            tag = _free_tag(result, directory, tag)
            paths = _write_files(result, directory, tag)
            # None gets a row unless all can.
            CheckTables(directory)
            more = []
            if format == "hunav":
                # That module knows this package.
                from hunav_drake.hunavsim.result_files import write_hunav_files

                more = write_hunav_files(
                    directory,
                    tag,
                    metrics=result.metrics,
                    steps=result.steps,
                    by_behavior=result.by_behavior,
                    steps_by_behavior=result.steps_by_behavior,
                )
            return paths + more + _write_rows(result, directory, tag)
    except OSError as error:
        raise OSError(
            error.errno,
            f"cannot write the results: {error.strerror or error}",
            str(error.filename or directory),
        ) from error


def GetTag(paths: list[Path]) -> str:
    """Returns the tag of the run whose files `WriteResult` has written."""
    recording = next(p for p in paths if p.name.startswith("recording_"))
    return recording.stem.removeprefix("recording_")


def CheckTables(directory: str | Path) -> None:
    """Finds out whether the tables of a folder can take another run.

    Args:
        directory: The folder; it need not exist.

    Raises:
        OSError: If a table cannot be read.
        ValueError: If one is damaged.
    """
    directory = Path(directory)
    for pattern, delimiter in (("metrics*.csv", ","), ("metrics*.txt", "\t")):
        for path in sorted(directory.glob(pattern)):
            if "_steps_" not in path.name:
                read_rows(path, delimiter)


def LoadResults(directory: str | Path) -> list[TrialResult]:
    """Reads the results that `WriteResult` has written into a folder.

    A run counts when it is in the table of runs. See `LoadResult`.

    Args:
        directory: The folder.

    Returns:
        The results, in the order of the table.

    Raises:
        OSError: If a file is missing or cannot be read.
        ValueError: If a file is damaged.
    """
    return [LoadResult(directory, tag) for tag in ListTags(directory)]


def ListTags(directory: str | Path) -> list[str]:
    """Returns the tags of the runs in a folder, in the order of its table.

    Raises:
        OSError: If there is no table, or it cannot be read.
        ValueError: If it is damaged.
    """
    path = Path(directory) / "metrics.csv"
    runs = ReadRuns(path)
    if "tag" not in runs:
        raise ValueError(
            f"{path}: is not a table of runs: it has no column 'tag'"
        )
    return list(runs["tag"])


def LoadResult(directory: str | Path, tag: str) -> TrialResult:
    """Reads one of the results in a folder.

    Metrics have the values that were written; what a file does not hold, the
    series and the tables by behavior, is computed again of the recording.

    Args:
        directory: The folder.
        tag: That of the run.

    Raises:
        OSError: If a file is missing or cannot be read.
        ValueError: If a file is damaged.
    """
    path = Path(directory) / f"result_{tag}.json"
    recording = Recording.load(Path(directory) / f"recording_{tag}.npz")
    try:
        summary: dict[str, Any] = json.loads(path.read_bytes())
        values = {
            name: math.nan if entry["value"] is None else float(entry["value"])
            for name, entry in summary["metrics"].items()
        }
        metrics = pd.Series(values, dtype=float, name="value")
        metrics.index.name = "metric"
        for fact, key in FACTS.items():
            # Older files have no more than units.
            metrics.attrs[key] = {
                name: entry[fact]
                for name, entry in summary["metrics"].items()
                if fact == "unit" or fact in entry
            }
        result = MakeTrialResult(
            recording,
            scenario_name=summary["scenario"],
            # A metric of somebody's own may not be registered here.
            metric_names=[name for name in values if name in METRICS],
            provenance=summary["provenance"],
            end_reason=summary["end_reason"],
            end_message=summary["end_message"],
            end_time=summary["end_time"],
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{path}: is not a result: {error!r}") from error
    setting = str(summary.get("setting", ""))
    return dataclasses.replace(
        result, metrics=metrics, setting=setting, tag=tag
    )


def _write_files(result: TrialResult, directory: Path, tag: str) -> list[Path]:
    """Writes the files that are of this run only."""
    paths = [directory / f"recording_{tag}.npz"]
    result.recording.save(paths[0])
    summary = json.dumps(_summary(result, tag), indent=2, allow_nan=False)
    texts = {
        f"result_{tag}.json": summary,
        f"steps_{tag}.csv": result.steps.to_csv(),
    }
    for behavior, steps in result.steps_by_behavior.items():
        texts[f"steps_{tag}_beh_{_unique(behavior)}.csv"] = steps.to_csv()
    for name, text in texts.items():
        paths.append(directory / name)
        with atomic_write(paths[-1]) as file:
            file.write(text.encode())
    return paths


def _write_rows(result: TrialResult, directory: Path, tag: str) -> list[Path]:
    """Adds the run to the tables that it shares with others."""
    rows = {
        f"metrics_beh_{_unique(behavior)}.csv": run_row(result, tag, behavior)
        for behavior in map(str, result.by_behavior.index)
    }
    rows["metrics.csv"] = run_row(result, tag)
    for name, row in rows.items():
        append_row(directory / name, row)
    return [directory / name for name in rows]


def _summary(result: TrialResult, tag: str) -> dict[str, Any]:
    metrics = result.metrics
    return {
        "tag": tag,
        "scenario": result.scenario_name,
        "setting": result.setting,
        "end_reason": result.end_reason,
        "end_message": result.end_message,
        "end_time": result.end_time,
        "provenance": result.provenance,
        "metrics": {
            name: {
                "value": _json_number(float(metrics[name])),
                "unit": unit_of(metrics, name),
                "family": family_of(metrics, name),
                "direction": direction_of(metrics, name),
            }
            for name in metrics.index
        },
    }


def _json_number(value: float) -> float | str | None:
    if math.isfinite(value):
        return value
    if math.isnan(value):
        return None
    return "Infinity" if value > 0 else "-Infinity"


def _free_tag(result: TrialResult, directory: Path, tag: str | None) -> str:
    """Returns the tag, or one that no run in the folder has."""

    def exists(candidate: str) -> bool:
        names = ("recording_{}.npz", "result_{}.json", "steps_{}.csv")
        return any((directory / n.format(candidate)).exists() for n in names)

    try:
        columns, rows = read_rows(directory / "metrics.csv")
    except ValueError:
        # The recording is kept all the same, beside all that there is.
        taken, damaged = set(), True
    else:
        at = columns.index("tag") if "tag" in columns else None
        taken, damaged = {row[at] for row in rows if at is not None}, False
    if tag is not None:
        if tag in taken or (damaged and exists(tag)):
            raise FileExistsError(
                errno.EEXIST,
                f"the tag {tag!r} is taken",
                str(directory / f"recording_{tag}.npz"),
            )
        return tag
    parts = [
        result.scenario_name or "trial",
        result.provenance.get("planner"),
        result.provenance.get("seed"),
    ]
    told = "_".join(str(p) for p in parts if p not in (None, ""))
    base = _safe(result.tag or told)[:_LONGEST]
    return next(
        candidate
        for candidate in (
            base if i == 1 else f"{base}_{i}" for i in itertools.count(1)
        )
        # Somebody may have removed the table, but wants to keep the files.
        if candidate not in taken and not exists(candidate)
    )


def _remove_stale_drafts(directory: Path) -> None:
    """Removes what killed writers have left of files that they began."""
    for path in directory.glob(".*.tmp"):
        if re.search(r"\.[0-9a-f]{16}\.tmp$", path.name):
            try:
                if time.time() - path.stat().st_mtime > _STALE:
                    path.unlink()
            except FileNotFoundError:
                continue


def _safe(text: str) -> str:
    """Returns a text that may be part of the name of a file."""
    return re.sub(r"[^A-Za-z0-9._+-]+", "_", text)


def _unique(text: str) -> str:
    """Returns a text that may be part of the name of a file, and no other's."""
    safe = _safe(text)[:_LONGEST]
    if safe == text:
        return text
    return f"{safe}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
