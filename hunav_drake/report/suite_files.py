"""Writes the results of a suite: CSV, LaTeX, JSON and an HTML report."""

from collections.abc import Mapping, Sequence
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.report.runs_page import ManyRuns, WriteRunsPage
from hunav_drake.runs.comparison.latex import PACKAGES, to_latex
from hunav_drake.runs.comparison.paper import printed_values
from hunav_drake.runs.comparison.relations import Judgement, judge
from hunav_drake.runs.comparison.tables import behavior_tables, scenario_tables
from hunav_drake.runs.run_folders import (
    RUNS,
    find_pages,
    recording_path,
    replay_path,
)
from hunav_drake.runs.run_row import row_to_json
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.metric_facts import facts_of
from hunav_drake.trial.provenance import MakeProvenance

_FILES = (
    *("runs.csv", "runs_by_behavior.csv", "summary.csv", "costs.csv"),
    *("outcomes.csv", "relations.csv", "tables.tex", "report.html"),
)


def WriteSuite(
    result: SuiteResult,
    folder: str | Path,
    judgements: Sequence[Judgement] | None = None,
) -> Path:
    """Writes the files of a suite, each atomically.

    They are `runs.csv`, `runs_by_behavior.csv`, `summary.csv`, `costs.csv`,
    `outcomes.csv`, `relations.csv`, `tables.tex`, `report.html`, and at the
    end `suite.json`. Nothing is written if the files exist for the same suite
    with the same runs and replays.

    Args:
        result: The result of the suite.
        folder: The folder of the files.
        judgements: Its tested relations; by default they are tested here.

    Returns:
        The path of the report.

    Raises:
        OSError: If a file cannot be written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    judgements = judge(result) if judgements is None else judgements
    report, last = folder / "report.html", folder / "suite.json"
    made_from = _sha256(result, judgements, folder)
    if _is_written(folder, last, made_from):
        return report
    last.unlink(missing_ok=True)
    summary = result.summary().reset_index()
    relations = pd.DataFrame([vars(it) for it in judgements])
    for name, table in (
        ("runs", result.runs()),
        ("runs_by_behavior", result.runs(by_behavior=True)),
        ("summary", summary),
        ("costs", result.costs()),
        ("outcomes", result.outcomes()),
        ("relations", relations),
    ):
        _write(folder / f"{name}.csv", table.to_csv(index=False))
    tables = (*scenario_tables(result), *behavior_tables(result))
    preamble = (
        f"% Suite {result.suite.name}, version {result.suite.version},"
        f" {len(result.rows)} runs; the hashes of its cells are in suite.json."
        f"\n% In the preamble: \\usepackage{{{','.join(PACKAGES)}}}\n\n"
    )
    _write(folder / "tables.tex", preamble + "\n".join(map(to_latex, tables)))
    WriteRunsPage(
        suite_runs(result, judgements), report, f"Benchmark {result.suite.name}"
    )
    _write(last, suite_json(result, judgements, made_from) + "\n")
    return report


def suite_runs(
    result: SuiteResult, judgements: Sequence[Judgement]
) -> ManyRuns:
    """Returns the content of the page of a suite."""
    return _many_runs(
        _about(result),
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
        return _many_runs(
            about,
            folder,
            runs=_read_table(folder / "runs.csv"),
            by_behavior=_read_table(folder / "runs_by_behavior.csv"),
            costs=_read_table(folder / "costs.csv"),
            judgements=judgements,
        )
    except (KeyError, TypeError) as error:
        raise ValueError(
            f"{path}: is damaged: {error!r}; start the suite again to write"
            " it again"
        ) from error


def _read_table(path: Path) -> pd.DataFrame:
    if not path.read_bytes().strip():
        return pd.DataFrame()
    table = ReadRuns(path)
    table.attrs |= facts_of(name for name in table if name in METRICS)
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
        return Recording.load(path) if path and path.is_file() else None

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
        about=[f"version {about['version']}", f"{len(cells)} cells"]
        if about
        else ["unfinished"],
        description=about.get("description", ""),
        printed=lambda scenario, behavior: printed_values(
            about.get("suite", ""), scenario, behavior
        ),
        **tables,
    )


def _sha256(
    result: SuiteResult, judgements: Sequence[Judgement], folder: Path
) -> str:
    """Returns a hash of the content of all files."""
    replays = sorted(path.name for path in folder.glob("replays/*"))
    about = (result.suite, result.cells, list(judgements), replays)
    found = hashlib.sha256(repr(about).encode())
    for row in result.rows:
        found.update(row_to_json(row).encode())
    return found.hexdigest()


def _is_written(folder: Path, last: Path, made_from: str) -> bool:
    """Returns whether all files exist and have this hash."""
    paths = [*(folder / name for name in _FILES), last]
    if not all(path.is_file() for path in paths):
        return False
    return f'"made_from": "{made_from}"' in last.read_text(errors="replace")


def suite_json(
    result: SuiteResult, judgements: Sequence[Judgement], made_from: str = ""
) -> str:
    """Returns suite, cells, statistics and relations as JSON.

    Args:
        result: The result of the suite.
        judgements: Its tested relations.
        made_from: A hash of all of it.
    """
    summary = result.summary().reset_index()
    data = {
        **_about(result),
        "made_from": made_from,
        "outcomes": result.outcomes().to_dict("records"),
        "summary": summary.to_dict("records"),
        "relations": [vars(it) for it in judgements],
        "failures": [
            {"cell": row.cell, "seed": row.seed, "reason": row.end_message}
            for row in result.failures
        ],
    }
    return json.dumps(_finite(data), indent=1, ensure_ascii=False)


def _about(result: SuiteResult) -> dict[str, Any]:
    """Returns the data about a suite and its cells."""
    provenance: dict[str, Any] = {**MakeProvenance(result.suite.name, seed=0)}
    for key in ("seed", "planner", "scenario_sha256"):
        provenance.pop(key, None)
    return {
        "suite": result.suite.name,
        "version": result.suite.version,
        "description": result.suite.description,
        "code_sha256": result.code_sha256,
        "cells": [
            {"name": cell.name, "sha256": cell.sha256, "drawn": cell.drawn}
            for cell in result.cells
        ],
        "provenance": provenance,
    }


def _finite(value: Any) -> Any:
    """Returns data with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _write(path: Path, text: str) -> None:
    with atomic_write(path) as file:
        file.write(text.encode())
