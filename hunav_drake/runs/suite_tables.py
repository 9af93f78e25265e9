"""The tables of a suite in its folder: CSV, LaTeX and JSON."""

from collections.abc import Sequence
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.runs.comparison.latex import PACKAGES, to_latex
from hunav_drake.runs.comparison.relations import Judgement, judge
from hunav_drake.runs.comparison.tables import behavior_tables, scenario_tables
from hunav_drake.runs.run_row import row_to_json
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.trial.provenance import MakeProvenance

# The page of a suite.
REPORT = "report.html"

_FILES = (
    *("runs.csv", "runs_by_behavior.csv", "summary.csv", "costs.csv"),
    *("outcomes.csv", "relations.csv", "tables.tex"),
)


def WriteSuiteTables(
    result: SuiteResult,
    folder: str | Path,
    judgements: Sequence[Judgement] | None = None,
) -> None:
    """Writes the tables of a suite, each atomically.

    They are `runs.csv`, `runs_by_behavior.csv`, `summary.csv`, `costs.csv`,
    `outcomes.csv`, `relations.csv`, `tables.tex`, and at the end `suite.json`.
    Nothing is written if the files exist for the same suite with the same runs
    and replays. Otherwise a page of other runs, `report.html`, is removed.

    Args:
        result: The result of the suite.
        folder: The folder of the files; it is created if necessary.
        judgements: Its tested relations; by default they are tested here.

    Raises:
        OSError: If a file cannot be written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    judgements = judge(result) if judgements is None else judgements
    last = folder / "suite.json"
    made_from = _sha256(result, judgements, folder)
    if _is_written(folder, last, made_from):
        return
    for path in (last, folder / REPORT):
        path.unlink(missing_ok=True)
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
    _write(last, suite_json(result, judgements, made_from) + "\n")


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
        **about_suite(result),
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


def about_suite(result: SuiteResult) -> dict[str, Any]:
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
        "facts": result.rows.facts,
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
