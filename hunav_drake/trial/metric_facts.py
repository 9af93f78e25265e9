"""The unit, family and direction of a metric.

A user-defined metric may not be registered where its results are read.
Therefore tables keep these facts in their `attrs`, and files of results contain
them. For metrics of this package, the registry takes precedence.
"""

from collections.abc import Iterable
import functools
import math
from typing import Any, Protocol

from hunav_drake.systems.evaluation import metrics as built_in
from hunav_drake.systems.evaluation.metric import DERIVED_FAMILIES, base_name
from hunav_drake.systems.evaluation.metrics import METRICS

# The facts, and their keys in the `attrs` of a table.
FACTS = {"unit": "units", "family": "families", "direction": "directions"}

# The headline metrics, shown first if there are many: success, time, path,
# distances, intrusions and contacts.
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
    "makespan",
    "min_dist_between_robots",
    "contacts_between_robots",
    "deadlock_time",
)

# Up to this number of metrics, all are headline metrics.
_FEW = 11


# The metrics that can be negative, and those in [0, 1].
_SIGNED = ("avg_robot_linear_speed", "min_dist_between_robots")
_FRACTIONS = (
    "completed",
    "path_efficiency",
    "success_weighted_path_length",
    "success_weighted_time_length",
    "reactive_share",
)


class Facts(dict[str, str]):
    """A fact of each metric: texts, which need no deep copy.

    (pandas copies the `attrs` of a table at each step, and for each row.)
    """

    def __deepcopy__(self, memo: Any) -> "Facts":
        """Returns a shallow copy."""
        return Facts(self)


class Table(Protocol):
    """A pandas table, or a `TrialResult`, with facts about its metrics."""

    @property
    def attrs(self) -> Any:
        """By the name of a metric, its "units", "families" ...: see FACTS."""


def headline_of(table: Table) -> list[str]:
    """Returns the headline metrics of a table, with all user-defined ones."""
    names = list(table.attrs.get(FACTS["unit"], {}))
    if len(names) <= _FEW:
        return names
    first = [it for h in HEADLINE for it in names if base_name(it) == h]
    return first + [
        it
        for it in names
        if not is_built_in(it) and family_of(table, it) not in DERIVED_FAMILIES
    ]


def facts_of(names: Iterable[str]) -> dict[str, Facts]:
    """Returns the `attrs` of a table with some registered metrics."""
    names = list(names)
    return {
        key: Facts(
            {it: str(getattr(METRICS[base_name(it)], fact)) for it in names}
        )
        for fact, key in FACTS.items()
    }


def is_built_in(name: str) -> bool:
    """Returns whether a metric is one of this package."""
    name = base_name(name)
    if name not in METRICS:
        return False
    function: Any = METRICS[name].function
    while isinstance(function, functools.partial):
        function = function.func
    module = str(getattr(function, "__module__", ""))
    return module.startswith(f"{built_in.__name__}.")


def unit_of(table: Table, name: str) -> str:
    """Returns the unit of a metric in a table; "" if it is unknown."""
    return _fact(table, name, "unit", "")


def family_of(table: Table, name: str) -> str:
    """Returns the family of a metric; "other" if it is unknown."""
    return _fact(table, name, "family", "other")


def direction_of(table: Table, name: str) -> str:
    """Returns the better direction of a metric: "lower", "higher" or "none"."""
    return _fact(table, name, "direction", "none")


def bounds_of(name: str) -> tuple[float, float]:
    """Returns the bounds of a metric; user-defined ones have none."""
    name = base_name(name)
    if not is_built_in(name) or name in _SIGNED:
        return -math.inf, math.inf
    if METRICS[name].unit == "%":
        return 0.0, 100.0
    return 0.0, 1.0 if name in _FRACTIONS else math.inf


def _fact(table: Table, name: str, fact: str, unknown: str) -> str:
    told = table.attrs.get(FACTS[fact], {})
    metric = METRICS.get(base_name(name))
    # A user-defined metric may have changed since the table was made.
    if metric is not None and (is_built_in(name) or name not in told):
        return str(getattr(metric, fact))
    return str(told.get(name, unknown))
