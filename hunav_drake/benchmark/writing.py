"""Writes what a suite has given: CSV, LaTeX, JSON and an HTML report."""

from collections.abc import Sequence
import json
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.benchmark.comparison.latex import PACKAGES, to_latex
from hunav_drake.benchmark.comparison.relations import Judgement, judge
from hunav_drake.benchmark.comparison.tables import (
    behavior_tables,
    scenario_tables,
)
from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.report.suite_page import suite_page
from hunav_drake.systems.common.files import atomic_write

# What is written; the last tells that all the others are there.
_FILES = (
    *("runs.csv", "runs_by_behavior.csv", "summary.csv", "costs.csv"),
    *("outcomes.csv", "relations.csv", "tables.tex", "report.html"),
)
_LAST = "suite.json"


def WriteSuite(
    result: SuiteResult,
    folder: str | Path,
    judgements: Sequence[Judgement] | None = None,
) -> Path:
    """Writes the files of a suite, each in one piece.

    Args:
        result: What the suite has given.
        folder: Where the files go.
        judgements: What became of its relations; by default they are tested.

    They are `runs.csv`, `runs_by_behavior.csv`, `summary.csv`, `costs.csv`,
    `outcomes.csv`, `relations.csv`, `tables.tex`, `report.html`, and, when all
    others are there, `suite.json`. Nothing is written where these say the same
    already.

    Returns:
        The path of the report.

    Raises:
        OSError: If a file cannot be written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    judgements = judge(result) if judgements is None else judgements
    report = folder / "report.html"
    about = suite_json(result, judgements) + "\n"
    if _is_written(folder, about):
        return report
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
    _write(report, suite_page(result, judgements))
    _write(folder / _LAST, about)
    return report


def _is_written(folder: Path, about: str) -> bool:
    """Returns whether all files are there, made from what they would be."""
    paths = [folder / name for name in (*_FILES, _LAST)]
    if not all(path.is_file() for path in paths):
        return False
    # The runs, whose times are in it, and the replays that the report links to.
    sources = [*folder.glob("runs.jsonl"), *folder.glob("replays/*")]
    last = paths[-1].stat().st_mtime
    if any(path.stat().st_mtime > last for path in sources):
        return False
    return paths[-1].read_text(encoding="utf-8") == about


def suite_json(result: SuiteResult, judgements: Sequence[Judgement]) -> str:
    """Returns suite, cells, statistics and relations as JSON."""
    summary = result.summary().reset_index()
    data = {
        "suite": result.suite.name,
        "version": result.suite.version,
        "code_sha256": result.code_sha256,
        "cells": [
            {"name": cell.name, "sha256": cell.sha256, "drawn": cell.drawn}
            for cell in result.cells
        ],
        "outcomes": result.outcomes().to_dict("records"),
        "summary": summary.to_dict("records"),
        "relations": [vars(it) for it in judgements],
        "failures": [
            {"cell": row.cell, "seed": row.seed, "reason": row.end_message}
            for row in result.failures
        ],
    }
    return json.dumps(_finite(data), indent=1, ensure_ascii=False)


def _finite(value: Any) -> Any:
    """Returns data in which numbers that JSON does not have are null."""
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
