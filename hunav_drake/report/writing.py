"""Writes a report on one or many trials as a single HTML file."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from hunav_drake.report.environment import address_of, write_page
from hunav_drake.report.runs_page import ManyRuns, WriteRunsPage
from hunav_drake.report.trial_page import trial_content
from hunav_drake.runs.independent_runs import drop_duplicate_runs
from hunav_drake.runs.run_folders import find_pages
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.trial.result import TrialResult

# At most this many different values of an entry are listed.
_MOST_VALUES = 4


def WriteReport(
    results: TrialResult | Iterable[TrialResult],
    filename: str | Path,
    *,
    replay: str | Path | None = None,
    title: str | None = None,
    pages: str | Path | None = None,
    left_out: Mapping[str, str] = MappingProxyType({}),
) -> Path:
    """Writes a report as one HTML file.

    A report on one trial shows how it ended, plots, all metrics and the
    provenance. A report on several compares scenarios, planners and their
    settings, with confidence intervals and in pairs of equal seeds, and lists
    the runs; duplicate runs count once (`drop_duplicate_runs`). The file has
    all plots inside, and needs no network and no scripts. It is written
    atomically.

    It links to the report and the replay of each run, if they exist;
    `hunav run` writes them.

    Args:
        results: A trial, or several.
        filename: The file to write; an existing one is replaced.
        replay: The replay file of a single trial.
        title: The heading; by default the name of the scenario.
        pages: The folder of results with the pages of the runs; by default
            the folder of `filename`.
        left_out: Runs that are missing from the report: the reason, by tag.

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
    trials, repeats = drop_duplicate_runs(trials)
    if title is None:
        names = dict.fromkeys(t.scenario_name or "trial" for t in trials)
        title = ", ".join(names)
    folder = filename.parent if pages is None else Path(pages)
    pages_of = [find_pages(folder, trial.tag) for trial in trials]
    told = [
        f"{again.tag} duplicates {first.tag}" if again.tag else ""
        for again, first in repeats
    ]
    if len(trials) > 1:
        many = ManyRuns(
            runs=tabulate_runs(trials),
            by_behavior=tabulate_runs(trials, by_behavior=True),
            recording=lambda i: trials[i].recording,
            provenance=_common_provenance(trials),
            pages=dict(enumerate(pages_of)),
        )
        return WriteRunsPage(
            many, filename, title, left_out=left_out, duplicates=told
        )
    watch = pages_of[0].get("replay") if replay is None else replay
    return write_page(
        filename,
        "trial.html",
        title=title,
        replay=None if watch is None else address_of(watch, filename),
        left_out=left_out,
        duplicates=told,
        **trial_content(trials[0]),
    )


def _common_provenance(trials: Sequence[TrialResult]) -> dict[str, Any]:
    """Returns the different values of each entry of the trials' provenance."""
    result = {}
    for key in dict.fromkeys(
        key for trial in trials for key in trial.provenance
    ):
        told = (t.provenance[key] for t in trials if key in t.provenance)
        values = list(dict.fromkeys(map(str, told)))
        more = len(values) - _MOST_VALUES
        end = [f"and {more} more"] if more > 0 else []
        result[key] = ", ".join(values[:_MOST_VALUES] + end)
    return result
