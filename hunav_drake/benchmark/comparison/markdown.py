"""The results of a suite as a page of Markdown, to be kept with others."""

import math

import pandas as pd

from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.results.metric_facts import unit_of
from hunav_drake.results.provenance import program_versions
from hunav_drake.results.quantity_text import number_text, unit_text
from hunav_drake.results.statistics import RATES, summarize

# What most want to know first: whether the robot arrives, how fast, and what
# people have to bear.
METRICS = (
    "completed",
    "time_to_reach_goal",
    "path_length",
    "min_dist_to_people",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "robot_on_person_collisions",
    "social_work",
)

# So many digits of a hash tell cells apart.
_DIGITS = 12


def to_markdown(result: SuiteResult, command: str) -> str:
    """Returns a page with a table for each scenario and setting.

    A row is a planner; its numbers are means over runs, with half the width of
    the 95 % interval. The same suite gives the same page, whatever it cost.

    Args:
        result: What the suite has given.
        command: What makes the page.
    """
    suite = result.suite
    runs = result.runs()
    versions = ", ".join(f"{k} {v}" for k, v in program_versions().items())
    counts = [len(suite.seed_list(name)) for name in suite.scenarios]
    seeds = "-".join(str(n) for n in sorted({min(counts), max(counts)}))
    lines = [
        f"# Results of the suite {suite.name}, version {suite.version}",
        "",
        f"{suite.description} Made by",
        "",
        f"    {command}",
        "",
        f"with {seeds} seeds for each cell ({versions})."
        " Numbers are means over runs \N{PLUS-MINUS SIGN} half of their 95 %"
        " confidence interval; where there is none, all runs are equal."
        " Distances are between surfaces. The last column begins the hash of"
        " the cell, which is in `suite.json`.",
    ]
    keys = dict.fromkeys((c.scenario, c.setting) for c in result.cells)
    for scenario, setting in keys if len(runs) else ():
        part = runs[(runs.scenario == scenario) & (runs.setting == setting)]
        part.attrs = runs.attrs
        if part.empty:
            continue
        title = ", ".join(word for word in (scenario, setting) if word)
        lines += ["", f"## {title}", "", *_table(result, part)]
    return "\n".join(lines) + "\n"


def _table(result: SuiteResult, runs: pd.DataFrame) -> list[str]:
    names = [name for name in METRICS if name in runs]
    scenario, setting = runs.scenario.iloc[0], runs.setting.iloc[0]
    statistics = summarize(runs, "planner", metrics=names) if names else None
    heads = []
    for name in names:
        unit = "%" if name in RATES else unit_text(unit_of(runs, name))
        heads.append(f"{name} ({unit})" if unit else name)
    lines = [
        _row(["planner", *heads, "cell"]),
        _row(["---", *["---:"] * len(heads), "---"]),
    ]
    for cell in result.cells:
        if (cell.scenario, cell.setting) != (scenario, setting):
            continue
        if statistics is None or cell.planner not in statistics.index:
            continue
        values = []
        for name in names:
            unit = "%" if name in RATES else unit_of(runs, name)
            described = statistics.loc[(cell.planner, name)]
            values.append(_value(described, unit, name in RATES))
        lines.append(
            _row([cell.planner, *values, f"`{cell.sha256[:_DIGITS]}`"])
        )
    return lines


def _value(described: pd.Series, unit: str, is_rate: bool) -> str:
    factor = 100.0 if is_rate else 1.0
    mean, low, high = (
        factor * float(described[key]) for key in ("mean", "low", "high")
    )
    text = number_text(mean, unit)
    half = (high - low) / 2
    if is_rate or not math.isfinite(half) or half <= 0:
        return text
    reach = number_text(half, unit, scale=abs(mean))
    return f"{text} \N{PLUS-MINUS SIGN} {reach}"


def _row(cells: list[str]) -> str:
    escaped = (cell.replace("|", r"\|") for cell in cells)
    return f"| {' | '.join(escaped)} |"
