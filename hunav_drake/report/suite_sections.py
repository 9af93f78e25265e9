"""The sections of a page about relations and costs of a suite."""

from collections.abc import Sequence
import math
from typing import Any, get_args

import pandas as pd

from hunav_drake.report.tables import Cell, Marked, Table, number
from hunav_drake.runs.comparison.relations import Judgement, tally
from hunav_drake.runs.suite import Strength

# The colors of verdicts.
_KINDS = {
    "holds": "passes",
    "mean only": "partly",
    "fails": "fails",
    "not tested": "inapplicable",
}

# Replacements to show formulas.
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
    "cpu": "CPU time (ms)",
    "cycle_median": "planner cycle, median (ms)",
    "cycle_p95": "planner cycle, 95 % (ms)",
}


def relation_table(judgements: Sequence[Judgement]) -> Table | None:
    """Returns the table of tested relations; None if there are none."""
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
    head = ["no.", "verdict", "relation", "strength", "resamples", "numbers"]
    return Table(head, rows, kind="relations")


def tallies(judgements: Sequence[Judgement]) -> list[dict[str, Any]]:
    """Returns the numbers of relations of each strength."""
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


def cost_table(runs: pd.DataFrame, costs: pd.DataFrame) -> Table | None:
    """Returns the median computing times of each contender.

    Args:
        runs: A row per run, with the column `contender`.
        costs: The computing times in seconds, with the same rows.
    """
    names = cost_heads(costs)
    if runs.empty or not names:
        return None
    rows: dict[str, list[list[Cell]]] = {}
    places = runs.groupby(["scenario", "contender"], sort=False).indices
    for (scenario, contender), own in places.items():
        part = costs.iloc[own]
        rate = float((runs["end_time"].iloc[own] / part["wall"]).median())
        medians = [cost_text(part[name].median()) for name in names]
        row: list[Cell] = [contender, str(len(part)), *medians, f"{rate:.0f}"]
        rows.setdefault(scenario, []).append(row)
    head = ["planner", "runs", *names.values(), "times real time"]
    return Table(head, rows, numbers=range(1, len(head)))


def cost_heads(costs: pd.DataFrame) -> dict[str, str]:
    """Returns the headings of the columns of costs."""
    return {name: head for name, head in _COSTS.items() if name in costs}


def cost_text(seconds: float) -> str:
    """Returns the text of a computing time, in milliseconds."""
    return number(1e3 * float(seconds), "ms")


def total_cost(runs: pd.DataFrame, costs: pd.DataFrame) -> str:
    """Returns the computing time of all runs, as a sentence."""
    if "cpu" not in costs:
        return ""
    simulated = _duration(float(runs["end_time"].sum()))
    wall, cpu = (
        _duration(float(costs[name].sum())) for name in ("wall", "cpu")
    )
    return (
        f"{len(costs)} runs, {simulated} of simulated time in total, took the"
        f" workers {wall}, with {cpu} of CPU time."
    )


def _duration(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"
