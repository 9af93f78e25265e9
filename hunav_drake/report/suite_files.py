"""The page of a suite: from its result, or from its folder."""

from collections.abc import Mapping, Sequence
import json
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.report.runs_page import ManyRuns, WriteRunsPage
from hunav_drake.runs.comparison.captions import made_by_text
from hunav_drake.runs.comparison.paper import printed_values
from hunav_drake.runs.comparison.relations import Judgement, judge
from hunav_drake.runs.run_folders import (
    RUNS,
    find_pages,
    recording_path,
    replay_path,
)
from hunav_drake.runs.run_row import table_facts
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.runs.suite_tables import REPORT, WriteSuiteTables, about_suite
from hunav_drake.systems.common.suggest import counted
from hunav_drake.systems.evaluation.recording import Recording

# The columns of `ReadRuns` beside the metrics.
_ABOUT = (
    *("tag", "scenario", "planner", "setting", "seed", "repetition", "drawn"),
    *("end_reason", "end_message", "end_time"),
)


def WriteSuite(
    result: SuiteResult,
    folder: str | Path,
    judgements: Sequence[Judgement] | None = None,
) -> Path:
    """Writes the files of a suite, each atomically: tables and `report.html`.

    Nothing is written if the files exist for the same suite with the same runs
    and replays.

    Args:
        result: The result of the suite.
        folder: The folder of the files: see `WriteSuiteTables`.
        judgements: Its tested relations; by default they are tested here.

    Returns:
        The path of the report.

    Raises:
        OSError: If a file cannot be written.
    """
    judgements = judge(result) if judgements is None else judgements
    folder = Path(folder)
    WriteSuiteTables(result, folder, judgements)
    report = folder / REPORT
    if not report.is_file():
        WriteRunsPage(
            suite_runs(result, judgements),
            report,
            f"Benchmark {result.suite.name}",
        )
    return report


def suite_runs(
    result: SuiteResult, judgements: Sequence[Judgement]
) -> ManyRuns:
    """Returns the content of the page of a suite."""
    return _many_runs(
        about_suite(result),
        result.folder,
        runs=result.runs(),
        by_behavior=result.runs(by_behavior=True),
        costs=result.costs(),
        judgements=judgements,
    )


def read_suite(folder: Path) -> ManyRuns:
    """Returns the content of the page of a suite from its folder.

    An unfinished suite, without the files of `WriteSuite`, has neither
    relations nor costs.

    Raises:
        OSError: If a file cannot be read.
        ValueError: If a file is damaged.
    """
    path = folder / "suite.json"
    if not path.is_file():
        return _many_runs(
            {},
            folder,
            runs=ReadRuns(folder),
            by_behavior=ReadRuns(folder, by_behavior=True),
        )
    try:
        about = json.loads(path.read_bytes())
        judgements = [
            Judgement(**{**it, "share": math.nan})
            if it["share"] is None
            else Judgement(**it)
            for it in about["relations"]
        ]
        runs, by_behavior, costs = (
            _read_table(folder / f"{name}.csv", about)
            for name in ("runs", "runs_by_behavior", "costs")
        )
        known = costs.columns.intersection(_ABOUT)
        if not runs[known].equals(costs[known]):
            raise ValueError("costs.csv and runs.csv are of different runs")
        return _many_runs(
            about,
            folder,
            runs=runs,
            by_behavior=by_behavior,
            costs=costs,
            judgements=judgements,
        )
    except (
        AttributeError,
        FileNotFoundError,
        KeyError,
        TypeError,
        ValueError,
    ) as error:
        told = f"lacks {error}" if isinstance(error, KeyError) else error
        raise ValueError(
            f"{path}: is damaged, or the tables beside it are: {told};"
            " delete it and start the suite again, which writes them again"
        ) from error


def _read_table(path: Path, about: Mapping[str, Any]) -> pd.DataFrame:
    if not path.read_bytes().strip():
        return pd.DataFrame()
    table = ReadRuns(path)
    # (Files of older versions lack those of metrics of one's own.)
    own = {k: it for k, it in about.get("facts", {}).items() if k in table}
    table.attrs |= table_facts(table, own)
    return table


def _many_runs(
    about: Mapping[str, Any], folder: Path | None, **tables: Any
) -> ManyRuns:
    """Returns the content of a page from tables.

    Args:
        about: The data of `suite.json` about the suite and its cells.
        folder: The folder of the suite, with recordings and replays.
        tables: `runs`, `by_behavior`, `costs` and `judgements`.
    """
    kept: dict[int, Path] = {}
    pages: dict[int, dict[str, Path]] = {}
    for run in tables["runs"].itertuples():
        if folder is None:
            continue
        if tag := getattr(run, "tag", ""):
            kept[run.Index] = folder / RUNS / tag / "recording.npz"
            pages[run.Index] = find_pages(folder, tag)
        elif not run.repetition:
            # Each cell has one.
            names = run.scenario, run.planner, run.setting
            cell = "/".join(filter(None, names))
            kept[run.Index] = recording_path(folder, cell, run.seed)
            replay = replay_path(folder, cell, run.seed)
            pages[run.Index] = {"replay": replay} if replay.is_file() else {}

    def recording(index: int) -> Recording | None:
        path = kept.get(index)
        try:
            return Recording.load(path) if path and path.is_file() else None
        except ValueError as error:
            raise ValueError(
                f"{error}; delete it, and the report has no plot of this run"
            ) from error

    cells = about.get("cells", [])
    provenance = dict(about.get("provenance", {}))
    if cells:
        provenance["code_sha256"] = about["code_sha256"]
    for cell in cells:
        provenance[f"{cell['name']} (SHA-256)"] = cell["sha256"]
    return ManyRuns(
        recording=recording,
        provenance=provenance,
        pages=pages,
        about=[f"version {about['version']}", counted(len(cells), "cell")]
        if about
        else ["unfinished"],
        description=about.get("description", ""),
        made_by=made_by_text(
            about.get("suite", ""),
            about.get("version", ""),
            provenance.get("hunav_drake", ""),
        ),
        printed=lambda scenario, behavior: printed_values(
            about.get("suite", ""), scenario, behavior
        ),
        **tables,
    )
