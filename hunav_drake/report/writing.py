"""A report on a trial, or on many: one HTML file that needs nothing else."""

from collections.abc import Iterable, Mapping
import os
from pathlib import Path
from types import MappingProxyType
from urllib.parse import quote

from hunav_drake.report.batch_page import batch_parts
from hunav_drake.report.batch_tables import listed
from hunav_drake.report.html import escape, page
from hunav_drake.report.trial_page import trial_parts
from hunav_drake.results.duplicate_runs import drop_duplicate_runs
from hunav_drake.results.run_folders import find_pages
from hunav_drake.results.trial_result import TrialResult
from hunav_drake.systems.files import atomic_write


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

    Of one trial it tells how it ended, all metrics, what happened in plots,
    and where it comes from. Of several it compares scenarios, planners and
    their settings, with intervals and run by run on equal seeds, and lists the
    runs; duplicate runs count once (`drop_duplicate_runs`). The file has all
    pictures inside, and needs neither a network nor scripts. It appears in one
    piece.

    It links to the report and the replay of each run, where they are.

    Args:
        results: A trial, or several.
        filename: The file to write; what is there already is replaced.
        replay: The file of the replay of a single trial.
        title: The heading; by default the name of the scenario.
        pages: The folder of results with the pages of the runs; by default
            the folder of the file.
        left_out: Why runs that belong here are not told of, by their tags.

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
    if len(trials) == 1:
        parts = trial_parts(trials[0])
        address = links[0].get("replay")
    else:
        parts = batch_parts(trials, links)
        address = None
    if replay is not None:
        address = _link(replay, filename)
    head = [f"<h1>{escape(title)}</h1>", *parts.about]
    if address is not None:
        head.append(f'<p><a href="{address}">Watch the replay</a></p>')
    for tag, reason in left_out.items():
        head.append(
            f'<p class="ended stuck"><strong>Left out: {escape(tag)}.</strong>'
            f" {escape(reason)}</p>"
        )
    if repeats:
        head.append(_repeats_note(repeats))
    text = page(title, [*head, *parts.sections])
    with atomic_write(filename) as file:
        file.write(text.encode())
    return filename


def _repeats_note(repeats: list[tuple[TrialResult, TrialResult]]) -> str:
    which = [
        f"{again.tag} is {first.tag} again"
        for again, first in repeats
        if again.tag
    ]
    told = f" {listed(which)}." if which else ""
    return (
        f"<p><strong>{len(repeats)} of the runs"
        f" {'is' if len(repeats) == 1 else 'are'} left out, being the same as"
        f" others in everything.</strong>{told}</p>"
    )


def _link(target: str | Path, page: Path) -> str:
    """Returns the address of a file, as seen from a page."""
    path = os.path.relpath(target, page.parent)
    return escape(quote(Path(path).as_posix()))
