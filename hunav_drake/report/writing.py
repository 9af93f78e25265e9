"""Writes a report on one or many trials as a single HTML file."""

from collections.abc import Iterable, Mapping
import os
from pathlib import Path
from types import MappingProxyType
from urllib.parse import quote

from hunav_drake.report.batch_page import batch_content
from hunav_drake.report.environment import template_environment
from hunav_drake.report.trial_page import trial_content
from hunav_drake.runs.independent_runs import drop_duplicate_runs
from hunav_drake.runs.run_folders import find_pages
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.trial.result import TrialResult


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
    links = [
        {k: _link(p, filename) for k, p in find_pages(folder, t.tag).items()}
        for t in trials
    ]
    address = None
    if len(trials) == 1:
        template, content = "trial.html", trial_content(trials[0])
        address = links[0].get("replay")
    else:
        template, content = "batch.html", batch_content(trials, links)
    if replay is not None:
        address = _link(replay, filename)
    text = (
        template_environment()
        .get_template(template)
        .render(
            title=title,
            replay=address,
            left_out=left_out,
            duplicates=[
                f"{again.tag} duplicates {first.tag}" if again.tag else ""
                for again, first in repeats
            ],
            **content,
        )
    )
    with atomic_write(filename) as file:
        file.write(text.encode())
    return filename


def _link(target: str | Path, page: Path) -> str:
    """Returns the address of a file, relative to a page."""
    path = os.path.relpath(target, page.parent)
    return quote(Path(path).as_posix())
