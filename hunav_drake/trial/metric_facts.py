"""The unit, family and direction of a metric.

A metric of somebody's own may not be registered where its results are read.
So tables keep these facts in their `attrs`, and files of results have them
too. Of the metrics of this package the registry knows best.
"""

from collections.abc import Iterable
import functools
import math
from typing import Any

import pandas as pd

from hunav_drake.systems.evaluation import metrics as built_in
from hunav_drake.systems.evaluation.metrics import METRICS

# The facts, and what they are called in the `attrs` of a table.
FACTS = {"unit": "units", "family": "families", "direction": "directions"}

# What is shown at first sight, where there are many metrics: success, time,
# path, nearness, intrusions and contacts.
HEADLINE = (
    "completed",
    "time_to_reach_goal",
    "path_length",
    "min_dist_to_people",
    "avg_dist_to_closest_person",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "contacts_by_robot",
    "contacts_by_person",
    "time_not_moving",
    "social_work",
)

# Up to so many metrics, all are shown at first sight.
_FEW = 11


# The metrics that can be negative, and those in [0, 1].
_SIGNED = ("avg_robot_linear_speed",)
_FRACTIONS = (
    "completed",
    "path_efficiency",
    "success_weighted_path_length",
    "success_weighted_time_length",
)


def headline_of(table: pd.Series | pd.DataFrame) -> list[str]:
    """Returns the metrics of a table that are shown at first sight.

    Those of users are always among them.
    """
    names = list(table.attrs.get(FACTS["unit"], {}))
    if len(names) <= _FEW:
        return names
    first = [name for name in HEADLINE if name in names]
    return first + [name for name in names if not is_built_in(name)]


def facts_of(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Returns the `attrs` of a table with some registered metrics."""
    names = list(names)
    return {
        key: {name: str(getattr(METRICS[name], fact)) for name in names}
        for fact, key in FACTS.items()
    }


def is_built_in(name: str) -> bool:
    """Tells whether a metric is one of this package."""
    if name not in METRICS:
        return False
    function: Any = METRICS[name].function
    while isinstance(function, functools.partial):
        function = function.func
    module = str(getattr(function, "__module__", ""))
    return module.startswith(f"{built_in.__name__}.")


def unit_of(table: pd.Series | pd.DataFrame, name: str) -> str:
    """Returns the unit of a metric in a table; nothing if it is not known."""
    return _fact(table, name, "unit", "")


def family_of(table: pd.Series | pd.DataFrame, name: str) -> str:
    """Returns the family of a metric; "other" if it is not known."""
    return _fact(table, name, "family", "other")


def direction_of(table: pd.Series | pd.DataFrame, name: str) -> str:
    """Returns whether "lower" or "higher" is better of a metric, or "none"."""
    return _fact(table, name, "direction", "none")


def bounds_of(name: str) -> tuple[float, float]:
    """Returns the least and the largest value that a metric can have.

    Of metrics of users nothing is known: they are without bounds.
    """
    if not is_built_in(name) or name in _SIGNED:
        return -math.inf, math.inf
    if METRICS[name].unit == "%":
        return 0.0, 100.0
    return 0.0, 1.0 if name in _FRACTIONS else math.inf


def _fact(
    table: pd.Series | pd.DataFrame, name: str, fact: str, unknown: str
) -> str:
    told = table.attrs.get(FACTS[fact], {})
    # Its owner may have changed it since the table was made.
    if name in METRICS and (is_built_in(name) or name not in told):
        return str(getattr(METRICS[name], fact))
    return str(told.get(name, unknown))
