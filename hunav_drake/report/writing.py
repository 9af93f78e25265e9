"""Writes a report on one or more trials as a single HTML file."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from hunav_drake.report.environment import address_of, write_page
from hunav_drake.report.trial_page import trial_content
from hunav_drake.runs.run_folders import find_pages
from hunav_drake.trial.result import TrialResult

# The maximum number of different values of an entry that are listed.
_MOST_VALUES = 4

# Columns in which duplicate runs may differ.
_NOT_COMPARED = ("tag", "end_message", "end_time", "drawn")

# What determines a run, besides planner and seed; versions do not matter if all
# metrics are equal.
_HASHED = ("scenario", "behavior", "files", "source")


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
    provenance. A report on several trials compares scenarios, planners and
    their settings, with confidence intervals and in pairs of equal seeds, and
    lists the runs. Duplicate runs, which were made from the same files and
    have equal metrics, count once. The file contains all plots, and needs no
    network and no scripts. It is written atomically.

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
    told: list[str] = []
    if len(trials) > 1:
        trials, told = without_duplicates(trials)
    if title is None:
        names = dict.fromkeys(t.scenario_name or "trial" for t in trials)
        title = ", ".join(names)
    folder = filename.parent if pages is None else Path(pages)
    pages_of = [find_pages(folder, trial.tag) for trial in trials]
    if len(trials) > 1:
        # Imported here: the page of one run needs none of it.
        from hunav_drake.report.runs_page import ManyRuns, WriteRunsPage
        from hunav_drake.runs.run_table import tabulate_runs

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


def without_duplicates(
    trials: Sequence[TrialResult],
) -> tuple[list[TrialResult], list[str]]:
    """Returns trials without duplicate runs, and a text on each of these.

    Duplicates were made from the same files, and have equal metrics.
    """
    from hunav_drake.runs.independent_runs import first_equal
    from hunav_drake.runs.run_table import tabulate_runs

    runs = tabulate_runs(trials)
    first = first_equal(
        runs.assign(made_from=[_made_from(trial) for trial in trials]),
        [*(name for name in runs if name not in _NOT_COMPARED), "made_from"],
    )
    repeats = {i: k for i, k in enumerate(first) if i != k}
    told = [
        f"{trials[i].tag} duplicates {trials[k].tag}" if trials[i].tag else ""
        for i, k in repeats.items()
    ]
    return [it for i, it in enumerate(trials) if i not in repeats], told


def _made_from(trial: TrialResult) -> Any:
    """Returns the hashes of what was run; unique if they are unknown."""
    about = trial.provenance
    if not about.keys() & {"scenario_sha256", "source_sha256"}:
        return object()
    return tuple(about.get(f"{it}_sha256") for it in _HASHED)


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
