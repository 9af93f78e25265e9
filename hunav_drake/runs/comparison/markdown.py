"""The results of a suite as a page of Markdown."""

import math
import re

import pandas as pd

from hunav_drake.runs.comparison.tables import (
    ENDS,
    by_place,
    fleet_metrics,
    mean_text,
    scores,
    shown_unit,
)
from hunav_drake.runs.outcomes import count_outcomes, outcome_text, why_not_goal
from hunav_drake.runs.statistics import summarize
from hunav_drake.runs.suite_result import KEYS, SuiteResult
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation.metric import LEAST_GAP, base_name
from hunav_drake.trial.provenance import program_versions
from hunav_drake.trial.quantity_text import unit_text

# The main metrics: whether the robot arrives, how fast, and the effects on
# people.
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

# Those of generated scenarios, besides: how close the time is to the least, and
# whether the robot ran into walls.
OF_KINDS = ("success_weighted_time_length", "contacts_with_walls")

_NOTE = (
    "In brackets: the number of seeds with a value, if not all have one. * Not"
    " all of these runs arrive, so the mean includes paths that end early."
)

# The number of digits of a hash that are shown.
_DIGITS = 12


def to_markdown(result: SuiteResult, command: str) -> str:
    """Returns a page with a table for each scenario and setting.

    A row is a planner. The page does not depend on computing times.

    Args:
        result: The result of a suite.
        command: The command that makes the page.
    """
    suite = result.suite
    runs = result.runs()
    versions = ", ".join(f"{k} {v}" for k, v in program_versions().items())
    lines = [
        f"# Results of the suite {suite.name}",
        "",
        f"{suite.description} Made by".strip(),
        "",
        f"    {command}",
        "",
        f"with {_counts(runs, suite.repetitions)} (suite version"
        f" {suite.version}, {versions})."
        f"{_worlds(result, runs)}"
        " Numbers are means \N{PLUS-MINUS SIGN} half of the 95 % confidence"
        " interval. Rates have the interval in square brackets. There is no"
        " interval for a single seed, or if all values are equal."
        f" {_NOTE} Distances are between surfaces. The last column has the"
        " first digits of the cell's hash, which is in `suite.json`.",
    ]
    lines += _responsibility(runs)
    for scenario, setting, part in by_place(runs):
        title = ", ".join(word for word in (scenario, setting) if word)
        lines += ["", f"## {title}", "", *_table(result, part)]
        ends = count_outcomes(part, ["planner"])
        for planner, own in ends.groupby("planner", sort=False):
            if why := why_not_goal(own):
                lines += ["", f"{planner}: {'. '.join(why)}."]
    if same := result.same_seeds():
        lines += ["", *(f"{line}." for line in same)]
    return "\n".join(lines) + "\n"


def _responsibility(runs: pd.DataFrame) -> list[str]:
    """Returns what planners cost people, and their worst encounters.

    They are there of suites with `relative` and `evaluator.encounters`.
    """
    times, contacts, gaps = (
        [it for it in runs if base_name(str(it)) == name]
        for name in ("aggregated_time", "contacts_charged", LEAST_GAP)
    )
    planners = list(dict.fromkeys(runs["planner"]))
    lines = []
    if times:
        lines += [
            "The aggregated time is by how much later people within 3.6 m of"
            " the robot arrive than without it, in seconds, summed over people"
            " (and robots, of several); means over seeds.",
            "",
            _row(["aggregated time (s)", *planners]),
            _row(["---", *["---:"] * len(planners)]),
        ]
        for scenario, setting, part in by_place(runs):
            own = part[times].sum(axis=1, min_count=1).groupby(part["planner"])
            means = own.mean().reindex(planners)
            title = ", ".join(word for word in (scenario, setting) if word)
            lines.append(_row([title, *map(_seconds, means)]))
    if gaps and contacts:
        lines += [
            "",
            "A contact is charged to the robot if it approaches at least as"
            " fast as the person. The worst encounter is that with the smallest"
            " gap from surface to surface, negative for overlaps.",
            "",
            _row(["planner", "contacts charged, in all", "worst encounter"]),
            _row(["---", "---:", "---"]),
        ]
        for planner in planners:
            part = runs[runs["planner"] == planner]
            least = part[gaps].min(axis=1)
            if least.isna().all():
                continue
            at = part.loc[least.idxmin()]
            place = [it for it in (at["scenario"], at["setting"]) if it]
            where = ", ".join([*place, f"seed {at['seed']}"])
            count = f"{part[contacts].sum().sum():.0f}"
            lines.append(
                _row([planner, count, f"{least.min():.3f} m in {where}"])
            )
    return ["", "## Responsibility", "", *lines] if lines else []


def _seconds(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.2f}".replace("-0.00", "0.00")


def _counts(runs: pd.DataFrame, repetitions: int) -> str:
    """Returns the number of seeds of the cells, as a phrase."""
    if runs.empty:
        return "no run"
    cells = runs.groupby(list(KEYS), sort=False).seed.nunique()
    most = int(cells.max())
    words = _number_of_seeds(runs) or f"{int(cells.min())} to {most}"
    text = f"{words} seed{'s' * (most > 1)} for each cell"
    if repetitions > 1:
        text += f", each {repetitions} times"
    return text


def _number_of_seeds(runs: pd.DataFrame) -> int | None:
    """Returns the number of seeds, if it is the same in all cells."""
    cells = runs.groupby(list(KEYS), sort=False).seed.nunique()
    return int(cells.iloc[0]) if cells.nunique() == 1 else None


def _worlds(result: SuiteResult, runs: pd.DataFrame) -> str:
    """Returns the number of generated worlds, as a sentence, if there are."""
    if runs.empty or all(isinstance(it, str) for it in result.suite.scenarios):
        return ""
    kinds = [it for it in result.suite.scenarios if not isinstance(it, str)]
    drawn = runs[runs.scenario.isin([it.name or name_of(it) for it in kinds])]
    count = int(drawn.groupby("scenario").seed.nunique().sum())
    return f" Each seed has a world of its own: these are {count} worlds."


def _table(result: SuiteResult, runs: pd.DataFrame) -> list[str]:
    wanted: tuple[str, ...] = METRICS
    if any(not isinstance(it, str) for it in result.suite.scenarios):
        wanted = (*METRICS, *OF_KINDS, *scores(runs))
    names = fleet_metrics(runs) or [name for name in wanted if name in runs]
    scenario, setting = runs.scenario.iloc[0], runs.setting.iloc[0]
    statistics = summarize(runs, "planner", metrics=names) if names else None
    heads = []
    for name in names:
        unit = unit_text(shown_unit(runs, name))
        head = name.replace("_", " ")
        heads.append(f"{head} ({unit})" if unit else head)
    ends = count_outcomes(runs, ["planner"])
    usual = _number_of_seeds(result.runs())
    lines = [
        _row(["planner", *heads, ENDS, "cell"]),
        _row(["---", *["---:"] * len(heads), "---", "---"]),
    ]
    for cell in result.cells:
        if (cell.scenario, cell.setting) != (scenario, setting):
            continue
        if statistics is None or cell.planner not in statistics.index:
            continue
        values = []
        for name in names:
            described = statistics.loc[(cell.planner, name)]
            text = mean_text(described, name, shown_unit(runs, name))
            # The number of seeds is told above the tables.
            values.append(text.replace(f" ({usual})", "") if usual else text)
        values.append(outcome_text(ends[ends.planner == cell.planner]))
        lines.append(
            _row([cell.planner, *values, f"`{cell.sha256[:_DIGITS]}`"])
        )
    return lines


def _row(cells: list[str]) -> str:
    escaped = (re.sub(r"([|*])", r"\\\1", cell) for cell in cells)
    return f"| {' | '.join(escaped)} |"
