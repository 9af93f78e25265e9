"""End reasons of runs: how often each occurs, and its message."""

from collections import Counter
from collections.abc import Iterable
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

# Messages that differ only in numbers count as equal.
_NUMBER = re.compile(r"\d+(\.\d+)?")

GOAL = "goal"


def count_outcomes(runs: "pd.DataFrame", by: Iterable[str]) -> "pd.DataFrame":
    """Counts the end reasons of runs.

    Args:
        runs: A row per run, with `end_reason` and perhaps `end_message`.
        by: The columns that distinguish kinds of runs.

    Returns:
        A row for each kind and reason, "goal" first, with the columns of `by`,
        `end_reason`, `count`, `runs` (the number of runs of the kind) and
        `message`: the most frequent one, with its count if there are others.
    """
    # (The page of a single run needs none.)
    import pandas as pd

    by = list(by)
    rows = []
    for kind, own in runs.groupby(by, sort=False, dropna=False):
        reasons = Counter(own["end_reason"])
        for reason in sorted(reasons, key=lambda it: it != GOAL):
            part = own[own["end_reason"] == reason]
            told = part.get("end_message", [])
            rows.append(
                (*kind, reason, len(part), len(own), _most_told(list(told)))
            )
    names = [*by, "end_reason", "count", "runs", "message"]
    return pd.DataFrame(rows, columns=names)


def outcome_text(outcomes: "pd.DataFrame") -> str:
    """Returns reasons with their counts, "goal 7, stuck 3"."""
    counts = outcomes.groupby("end_reason", sort=False)["count"].sum()
    return ", ".join(f"{reason} {count}" for reason, count in counts.items())


def why_not_goal(outcomes: "pd.DataFrame") -> list[str]:
    """Returns the reasons and messages of runs that did not reach the goal."""
    return [
        f"{row.end_reason}: {row.message}"
        for row in outcomes.itertuples()
        if row.end_reason != GOAL and row.message
    ]


def _most_told(messages: list[str]) -> str:
    told = [it for it in messages if isinstance(it, str) and it]
    if not told:
        return ""
    kinds = [_NUMBER.sub("#", it) for it in told]
    kind, count = Counter(kinds).most_common(1)[0]
    first = told[kinds.index(kind)]
    if count == len(messages):
        return first
    return f"{first} ({count} of {len(messages)} say so)"
