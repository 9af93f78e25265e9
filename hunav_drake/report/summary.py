"""What a report on several runs tells, in three sentences."""

from collections.abc import Mapping, Sequence
from itertools import combinations
import math

import numpy as np
import pandas as pd

from hunav_drake.report.tables import number, signed
from hunav_drake.runs.independent_runs import (
    comparable,
    draws_nothing,
    once_per_seed,
)
from hunav_drake.runs.outcomes import GOAL
from hunav_drake.runs.run_row import FAILED
from hunav_drake.runs.statistics import (
    LEAST_PAIRS,
    TIMES,
    arrival_rates,
    arrivals,
    compare,
    summarize,
)
from hunav_drake.systems.common.suggest import listed
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.trial.branches.run import Branches, growth_text
from hunav_drake.trial.metric_facts import unit_of
from hunav_drake.trial.quantity_text import unit_text

# The metrics of people, of which the first that has values is told.
_PEOPLE = ("min_dist_to_people", "personal_space_intrusions")

_WORDS = {
    "time_to_reach_goal": "time to the goal",
    "makespan": "time until all robots arrive",
    "min_dist_to_people": "least distance to people",
    "personal_space_intrusions": "time in personal spaces",
}

# A shorter delay is none, in seconds.
_LEAST_DELAY = 0.005

# More planners than these are told by the first and the last.
_MOST_PLANNERS = 8


def main_metrics(runs: pd.DataFrame) -> list[str]:
    """Returns the metrics that the summary tells of: of time and of people."""
    chosen = (_first_of(runs, it) for it in (TIMES, _PEOPLE))
    return [it for it in chosen if it]


def runs_summary(runs: pd.DataFrame) -> list[str]:
    """Returns three sentences on runs: arrivals, times, and people.

    A planner is called better only if it is better than every other by
    `compare`, on equal seeds. Scenarios are never averaged.

    Args:
        runs: The runs, with the column `contender`; at least one.
    """
    sentences = [_arrivals(runs)]
    for bases, missing in (
        (TIMES, "No run has a time to the goal."),
        (_PEOPLE, "No run has a distance to people."),
    ):
        parts = {}
        for scenario, part in runs.groupby("scenario", sort=False):
            part.attrs = runs.attrs
            # Elsewhere none is defined, as for scenes without people.
            if metric := _first_of(part, bases):
                parts[str(scenario)] = part, metric
        several = runs["contender"].nunique() > 1
        sentences.append(_about(parts, several) if parts else missing)
    return sentences


def branches_summary(branches: Branches) -> list[str]:
    """Returns sentences on branches: delays, whose, and the robot."""
    names = [it for it in branches.futures if it != branches.reference]
    table = branches.people
    late = table[(table["quantity"] == "time") & table["difference"].notna()]
    late = late[late["branch"].isin(names)]
    robots = {
        it: branches[it]
        for it, future in branches.futures.items()
        if future.robots
    }
    arrive = [
        f"after {it.end_time:.2f} s in {name}"
        for name, it in robots.items()
        if it.end_reason == GOAL
    ]
    others = [it for it, end in robots.items() if end.end_reason != GOAL]
    third = ""
    if arrive:
        third = f"The robot reaches its goal {listed(arrive)}"
        third += f", and not in {listed(others)}." if others else "."
    elif others:
        third = "The robot reaches its goal in no branch."
    third = " ".join(filter(None, [third, growth_text(branches.growth)]))
    if late.empty:
        first = (
            "Nobody arrives both in a branch and in the one that it is compared"
            " with, so no delay is known."
        )
        return [
            first if branches.human_names else "There are no people.",
            third,
        ]
    sums = late.groupby("branch", sort=False)["difference"].agg(["sum", "size"])
    sums = sums.reindex(names).dropna().round(3)
    parts = [
        f"{signed(row['sum'], 's')} s in {name} ({row['size']:.0f} arrive in"
        " both)"
        for name, row in sums.iterrows()
    ]
    worst = late.loc[late["difference"].idxmax()]
    most = signed(round(worst["difference"], 3), "s")
    second = "Nobody arrives later in any branch."
    if worst["difference"] > _LEAST_DELAY:
        second = (
            f"The largest delay is that of {worst['person']} in"
            f" {worst['branch']}: {most} s."
        )
    return [
        f"Compared with {branches.reference}, the extra time of all people"
        f" together is {listed(parts)}.",
        second,
        third,
    ]


def _first_of(runs: pd.DataFrame, bases: Sequence[str]) -> str:
    """Returns the first metric that has a value; "" if none has."""
    names = [
        *(it for it in bases if it in runs),
        *(it for base in bases for it in runs if base_name(it) == base),
    ]
    known = (it for it in names if np.isfinite(runs[it].astype(float)).any())
    return next(known, "")


def _arrivals(runs: pd.DataFrame) -> str:
    """Returns how many runs reach the goal, and of which planner."""
    names = list(dict.fromkeys(runs["contender"]))
    goals = runs
    if arrival_rates(runs):
        # Without a goal, nobody can arrive.
        has_goal = ~np.isnan(arrivals(runs))
        goals = runs[has_goal | runs["end_reason"].isin(FAILED)]
    failed = int(runs["end_reason"].isin(FAILED).sum())
    total = f"{len(goals)} run{'s' * (len(goals) != 1)}"
    done = goals["end_reason"] == GOAL
    if goals.empty:
        text = f"{len(runs)} runs had no goal to reach"
        text = "The run had no goal to reach" if len(runs) == 1 else text
    elif len(names) == 1:
        text = f"{int(done.sum())} of {total} reached the goal"
    else:
        own = done.groupby(goals["contender"], sort=False).agg(["sum", "size"])
        shares = {
            str(name): (it["sum"] / it["size"], it["sum"], it["size"])
            for name, it in own.iterrows()
        }
        order = sorted(shares, key=lambda it: -shares[it][0])
        parts = [f"{it} {shares[it][1]} of {shares[it][2]}" for it in order]
        if len(parts) > _MOST_PLANNERS:
            parts = [parts[0], "...", parts[-1]]
        text = (
            f"{int(done.sum())} of {total} reached the goal: {', '.join(parts)}"
        )
    if failed:
        text += f"; {failed} failed"
    seeds = runs["seed"].replace("", pd.NA)
    keys = ["scenario", "contender"]
    once = once_per_seed(runs, keys, [])
    if draws_nothing(runs).all():
        text += "; all seeds are alike, so no mean has an interval"
    elif seeds.notna().all() and once.groupby(keys).size().max() == 1:
        only = "each has" if seeds.nunique() > 1 else "there is"
        text += f"; {only} one seed only, so only rates have an interval"
    return f"{text}."


def _about(parts: Mapping[str, tuple[pd.DataFrame, str]], several: bool) -> str:
    """Returns which planner is better by a metric, if one is.

    Args:
        parts: The runs of each scenario, and its metric: that of scenarios
            with several robots has another name.
        several: Whether planners are compared.
    """
    means = {
        it: summarize(
            part, "contender", metrics=metric, bounded=True
        ).droplevel("metric")
        for it, (part, metric) in parts.items()
    }
    what = " or ".join(dict.fromkeys(_words(it) for _, it in parts.values()))
    unit = unit_of(*next(iter(parts.values())))
    if not several:
        return _alone(means, what, unit)
    verdicts = {it: _best(*found) for it, found in parts.items()}
    if len(parts) > 1:
        wins: dict[str, list[str]] = {}
        for scenario, (best, _) in verdicts.items():
            wins.setdefault(best, []).append(str(scenario))
        rest = wins.pop("", [])
        told = [f"{it} in {listed(places, 4)}" for it, places in wins.items()]
        if not wins:
            return (
                f"By the {what}, no planner is better than every other in any"
                f" of {len(verdicts)} scenarios."
            )
        return (
            f"By the {what}, one planner is better than every other in"
            f" {len(verdicts) - len(rest)} of {len(verdicts)}"
            f" scenario{'s' * (len(verdicts) != 1)}: {'; '.join(told)}"
            f"{'; none in the rest' * bool(rest)}."
        )
    ((best, reason),) = verdicts.values()
    (table,) = means.values()
    table = table[table["n"] > 0]
    if best:
        every = "every other planner" if len(table) > 2 else "the other planner"
        return f"{best} has a better {what} than {every}{reason}."
    ends = [
        f"{_amount(mean, unit)} ({name})"
        for name, mean in table["mean"].sort_values(kind="stable").items()
    ]
    span = f"The mean {what} is {ends[0]}"
    if len(ends) > 1:
        span = f"The mean {what} is from {ends[0]} to {ends[-1]}"
    return f"{span}, but {reason}."


def _alone(means: Mapping[str, pd.DataFrame], what: str, unit: str) -> str:
    """Returns the mean of a single planner, or the range over scenarios."""
    rows = {it: table.iloc[0] for it, table in means.items()}
    if len(rows) > 1:
        least, *_, most = sorted(rows, key=lambda it: float(rows[it]["mean"]))
        return (
            f"The mean {what} is from {_amount(rows[least]['mean'], unit)}"
            f" ({least}) to {_amount(rows[most]['mean'], unit)} ({most})."
        )
    (row,) = rows.values()
    text = f"The mean {what} is {_amount(row['mean'], unit)}"
    n = int(row["n"])
    runs = f"{n} run{'s' * (n > 1)} with a value"
    if math.isnan(row["low"]):
        return f"{text}, over {runs}, so without an interval."
    low, high = (_amount(row[it], unit) for it in ("low", "high"))
    return f"{text}, with a 95 % interval of {low} to {high}, over {runs}."


def _best(runs: pd.DataFrame, metric: str) -> tuple[str, str]:
    """Returns the planner that is better than every other, and by what.

    Without one, the name is empty, and the text is the reason.
    """
    pairs = comparable(runs, "contender")
    values = runs[np.isfinite(runs[metric])]
    names = [str(it) for it in dict.fromkeys(values["contender"])]
    others = dict.fromkeys(runs["contender"])
    without = [str(it) for it in others if it not in names]
    unit = unit_of(runs, metric)
    if len(names) < 2:
        return "", "no other planner has a value"
    rows: dict[tuple[str, str], pd.Series | None] = {}

    def better(one: str, other: str) -> str | None:
        first, second = sorted((one, other), key=names.index)
        key = first, second
        if key not in rows:
            try:
                table = compare(pairs, *key, on="contender", metrics=metric)
                rows[key] = table.iloc[0]
            except ValueError:
                rows[key] = None
        row = rows[key]
        return None if row is None else row["better"]

    # If one is better than every other, no other one can win against it.
    best = names[0]
    for name in names[1:]:
        best = name if better(best, name) == name else best
    if all(better(best, it) == best for it in names if it != best):
        rest = f" (without a value: {listed(without)})" if without else ""
        text = f" on equal seeds{rest}"
        row = rows.get((names[0], names[1])) if len(names) == 2 else None
        if row is not None:
            sides = ("a", "b") if best == names[0] else ("b", "a")
            means = (_amount(row[it], unit) for it in sides)
            text += f": {' against '.join(means)}"
        return best, text
    for one, other in combinations(names, 2):
        better(one, other)
    found = [row for row in rows.values() if row is not None]
    most = max((int(row["n"]) for row in found), default=0)
    if most < LEAST_PAIRS:
        return "", (
            f"none can be called better: this needs {LEAST_PAIRS} equal seeds"
            f" in which both have a value, and there are {most or 'none'}"
        )
    if all(row["difference"] == row["sd"] == 0 for row in found):
        return "", "it is the same on all equal seeds"
    if len(names) == 2:
        low, high = (_amount(found[0][it], unit) for it in ("low", "high"))
        return "", (
            "neither can be called better: the 95 % interval of the difference"
            f" on equal seeds, {low} to {high}, contains 0"
        )
    return "", "none can be called better than every other on equal seeds"


def _words(metric: str) -> str:
    base = base_name(metric)
    words = _WORDS.get(base, base.replace("_", " "))
    robot = metric.removesuffix(base).rstrip(".")
    return f"{words} of {robot}" if robot else words


def _amount(value: float, unit: str) -> str:
    return " ".join(filter(None, [number(float(value), unit), unit_text(unit)]))
