"""The tables of the page of a suite."""

from collections.abc import Sequence
import math
import re
from typing import Any, get_args

import pandas as pd

from hunav_drake.report.batch_tables import paired_tables
from hunav_drake.report.tables import Cell, Marked, Table, metric_cell, number
from hunav_drake.runs.comparison.relations import Judgement, tally
from hunav_drake.runs.comparison.tables import Table as SuiteTable
from hunav_drake.runs.suite import Strength
from hunav_drake.runs.suite_result import KEYS, SuiteResult
from hunav_drake.trial.quantity_text import superscript

# The heading of the columns with values that the paper printed.
_PRINTED = "paper"

# Of more runs, what each has cost is not shown, but in a file.
_MOST_RUNS = 300

# What is compared at first sight.
_COMPARED = ("completed", "time_to_reach_goal", "min_dist_to_people")

# The colors of verdicts.
_KINDS = {
    "holds": "passes",
    "mean only": "partly",
    "fails": "fails",
    "not tested": "inapplicable",
}

# How formulas are written by people.
_SIGNS = {
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    "<=": "\N{LESS-THAN OR EQUAL TO}",
    "==": "=",
    " * ": " ",
    " & ": " and ",
    " | ": " or ",
    " - ": " \N{MINUS SIGN} ",
}

_COSTS = {
    "wall": "run (ms)",
    "cpu": "CPU of it (ms)",
    "cycle_median": "planner cycle, median (ms)",
    "cycle_p95": "planner cycle, 95 % (ms)",
}


def page_table(table: SuiteTable) -> Table:
    """Returns a table of metrics by planner for a page."""
    last = len(table.header) - 1
    known = pd.Series(dtype=float)
    rows: list[list[Cell]] = []
    for name, *texts in table.rows:
        values: list[Cell] = [
            Marked(_raised(text), "printed") if head == _PRINTED else text
            for head, text in zip(
                table.header[1:], map(_raised, texts), strict=True
            )
        ]
        rows.append([metric_cell(known, name), *values])
    return Table(
        ["metric", *table.header[1:]], {"": rows}, numbers=range(1, last)
    )


def relation_table(judgements: Sequence[Judgement]) -> Table | None:
    """Returns what became of the relations; None if there are none."""
    if not judgements:
        return None
    places = {"all": "all scenarios", "both": "passing and crossing, each"}

    def place(name: str) -> str:
        first, bracket, rest = name.partition(" (")
        return places.get(first, first) + bracket + rest

    rows: dict[str, list[list[Cell]]] = {}
    for it in judgements:
        share = "" if math.isnan(it.share) else f"{100 * it.share:.0f} %"
        text = it.text
        for sign, shown in _SIGNS.items():
            text = text.replace(sign, shown)
        rows.setdefault(place(it.scenarios), []).append(
            [
                str(it.number),
                Marked(it.verdict, _KINDS[it.verdict]),
                text,
                it.strength,
                share,
                it.numbers,
            ]
        )
    head = ["", "verdict", "relation", "strength", "resamples", "numbers"]
    return Table(head, rows, kind="relations")


def tallies(judgements: Sequence[Judgement]) -> list[dict[str, Any]]:
    """Returns how many relations of each strength hold."""
    found = {it: tally(judgements, it) for it in get_args(Strength)}
    return [
        {
            "strength": strength,
            **counts._asdict(),
            "percent": f"{100 * counts.shares[0]:.0f} %",
        }
        for strength, counts in found.items()
        if counts.tested
    ]


def pair_tables(result: SuiteResult, scenario: str) -> list[dict[str, Any]]:
    """Returns how planners differ on equal seeds in a scenario."""
    runs = result.runs()
    if runs.empty:
        return []
    part = runs[runs.scenario == scenario]
    names = part.planner + part.setting.map(lambda s: f", {s}" if s else "")
    part = part.assign(contender=names)
    part.attrs = runs.attrs
    if part["contender"].nunique() < 2:
        return []
    return paired_tables(part, _COMPARED)


def cost_table(costs: pd.DataFrame) -> Table | None:
    """Returns what the runs of each cell have cost: medians."""
    names = [name for name in _COSTS if name in costs]
    if costs.empty or not names:
        return None
    rows = []
    for place, part in costs.groupby(list(KEYS), sort=False):
        rate = float((part.end_time / part.wall).median())
        medians = [_milliseconds(part[name].median()) for name in names]
        rows.append([_place(place), str(len(part)), *medians, f"{rate:.0f}"])
    head = ["cell", "runs", *(_COSTS[n] for n in names), "times real time"]
    return Table(head, {"": rows}, numbers=range(1, len(head)))


def each_cost_table(costs: pd.DataFrame) -> Table | None:
    """Returns what each run has cost; None if they are too many to show."""
    names = [name for name in _COSTS if name in costs]
    if not 0 < len(costs) <= _MOST_RUNS or not names:
        return None
    rows: dict[str, list[list[str]]] = {}
    for place, part in costs.groupby(list(KEYS), sort=False):
        rows[_place(place)] = [
            [
                str(row["seed"]),
                number(row["end_time"], "s"),
                *(_milliseconds(row[name]) for name in names),
            ]
            for row in part.to_dict("records")
        ]
    head = ["seed", "simulated (s)", *(_COSTS[name] for name in names)]
    return Table(head, rows, numbers=range(1, len(head)))


def total_cost(costs: pd.DataFrame) -> str:
    """Returns what all runs have cost, as a sentence."""
    if costs.empty or "cpu" not in costs:
        return ""
    simulated, wall, cpu = (
        float(costs[name].sum()) for name in ("end_time", "wall", "cpu")
    )
    return (
        f"{len(costs)} runs of {_duration(simulated)} in all took workers"
        f" {_duration(wall)}, of which the processor worked {_duration(cpu)}."
    )


def _place(place: Sequence[str]) -> str:
    return "/".join(word for word in place if word)


def _duration(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def _milliseconds(seconds: float) -> str:
    return number(1e3 * float(seconds), "ms")


def _raised(text: str) -> str:
    """Returns numbers with powers of ten as people write them."""
    return re.sub(
        r"(?<=\d)e([+-]\d+)",
        lambda match: (
            "\N{MULTIPLICATION SIGN}10" + superscript(str(int(match[1])))
        ),
        text,
    )
