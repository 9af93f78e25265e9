"""A report on a trial, or on many: one HTML file that needs nothing else."""

from collections.abc import Iterable
import dataclasses
import json
import math
import os
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pandas as pd

from hunav_drake.batch_report import batch_parts
from hunav_drake.report_html import escape, page
from hunav_drake.results import MakeTrialResult, TrialResult
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.files import atomic_write
from hunav_drake.trial_report import trial_parts


def WriteReport(
    results: TrialResult | Iterable[TrialResult],
    filename: str | Path,
    *,
    replay: str | Path | None = None,
    title: str | None = None,
) -> Path:
    """Writes a report as one HTML file.

    Of one trial it tells how it ended, all metrics, what happened in plots,
    and where it comes from. Of several it compares scenarios and planners,
    with intervals, and lists the runs. The file has all pictures inside, and
    needs neither a network nor scripts. It appears in one piece.

    Args:
        results: A trial, or several.
        filename: The file to write; what is there already is replaced.
        replay: The file of the replay, to which the report links.
        title: The heading; by default the name of the scenario.

    Returns:
        The path of the file.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If there are no results.
    """
    filename = Path(filename)
    trials = [results] if isinstance(results, TrialResult) else list(results)
    if not trials:
        raise ValueError("a report needs at least one result, got none")
    if title is None:
        names = dict.fromkeys(t.scenario_name or "trial" for t in trials)
        title = ", ".join(names)
    parts = trial_parts(trials[0]) if len(trials) == 1 else batch_parts(trials)
    head = [f"<h1>{escape(title)}</h1>", *parts.about]
    if replay is not None:
        head.append(
            f'<p><a href="{_link(replay, filename)}">Watch the replay</a></p>'
        )
    text = page(title, [*head, *parts.sections])
    with atomic_write(filename) as file:
        file.write(text.encode())
    return filename


def LoadResults(directory: str | Path) -> list[TrialResult]:
    """Reads the results that `WriteResult` has written into a folder.

    Metrics have the values that were written; what a file does not hold, the
    series and the tables by behavior, is computed again of the recording. A
    run counts when it is in the table of runs.

    Args:
        directory: The folder.

    Returns:
        The results, in the order of the table.

    Raises:
        OSError: If a file is missing or cannot be read.
        ValueError: If a file is damaged.
    """
    directory = Path(directory)
    path = directory / "metrics.csv"
    try:
        # As texts, so that a tag of digits stays as it is.
        runs = pd.read_csv(path, dtype=str, keep_default_na=False)
        tags = runs["tag"].tolist()
    except KeyError as error:
        raise ValueError(
            f"{path}: is not a table of runs: it has no column 'tag'"
        ) from error
    except ValueError as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error
    return [_load(directory, tag) for tag in tags]


def _load(directory: Path, tag: str) -> TrialResult:
    path = directory / f"result_{tag}.json"
    recording = Recording.load(directory / f"recording_{tag}.npz")
    try:
        summary: dict[str, Any] = json.loads(path.read_bytes())
        values = {
            name: math.nan if entry["value"] is None else entry["value"]
            for name, entry in summary["metrics"].items()
        }
        metrics = pd.Series(values, dtype=float, name="value")
        metrics.index.name = "metric"
        metrics.attrs["units"] = {
            name: entry["unit"] for name, entry in summary["metrics"].items()
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
    return dataclasses.replace(result, metrics=metrics)


def _link(target: str | Path, page: Path) -> str:
    """Returns the address of a file, as seen from a page."""
    path = os.path.relpath(target, page.parent)
    return escape(quote(Path(path).as_posix()))
