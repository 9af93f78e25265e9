"""The class of metrics and their registry.

A user's metric is one decorated function of a recording::

    @register_metric(unit="m/s", family="speeds", source="myself")
    def final_speed(recording: Recording) -> float:
        \"\"\"The speed at the end.\"\"\"
        return float(recording.features.forward_speed[-1])
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import functools
import inspect
import re
from typing import Any, Literal, get_args

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.suggest import did_you_mean, shown
from hunav_drake.systems.evaluation.recording import Recording

# Table I of Perez-Higueras et al., "HuNavSim", 2023, in its order.
TABLE_I = (
    "time_to_reach_goal",
    "path_length",
    "cumulative_heading_changes",
    "avg_dist_to_closest_person",
    "min_dist_to_people",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "social+_space_intrusions",
    "group_intimate_space_intrusions",
    "group_personal_space_intrusions",
    "group_social+_space_intrusions",
    "completed",
    "min_dist_to_target",
    "final_dist_to_target",
    "robot_on_person_collisions",
    "person_on_robot_collisions",
    "time_not_moving",
    "avg_robot_linear_speed",
    "avg_robot_angular_speed",
    "avg_robot_acceleration",
    "avg_robot_jerk",
    "avg_pedestrian_velocity",
    "avg_closest_pedestrian_velocity",
    "social_force_on_agents",
    "social_force_on_robot",
    "obstacle_force_on_agents",
    "obstacle_force_on_robot",
    "social_work",
)

# A column of the steps of one behavior: whether anyone shows it then.
BEHAVIOR_ACTIVE = "behavior_active"

# The columns of run tables that are not metrics. Only tables by behavior have
# the last one.
ABOUT_RUNS = (
    "tag",
    "scenario",
    "planner",
    "setting",
    "seed",
    "repetition",
    "drawn",
    "end_reason",
    "end_message",
    "end_time",
    "behavior",
)

# Names that metrics cannot have: they are names of columns or rows, too.
RESERVED = (*ABOUT_RUNS, BEHAVIOR_ACTIVE, "time", "metric")
Direction = Literal["lower", "higher", "none"]

# A value; a value with its series over the samples; or the series alone, which
# the metric's `reduce` turns into the value.
Result = float | tuple[float, Array] | Array
MetricFunction = Callable[[Recording], Result]

# The family of metrics of recorded people.
REPLAY_FAMILY = "replay"

# The family of metrics of several robots with each other.
FLEET_FAMILY = "fleet"

# The family of values on the samples of a situation, `path_length[passing]`.
SITUATIONS_FAMILY = "situations"

# The families of values of encounters, and of those of a trial with and without
# robot and people.
ENCOUNTERS_FAMILY = "encounters"
RELATIVE_FAMILY = "relative"

# The families of values that are no registered metrics: they have no values by
# behavior.
DERIVED_FAMILIES = (SITUATIONS_FAMILY, ENCOUNTERS_FAMILY, RELATIVE_FAMILY)
LEAST_GAP = "min_gap_exact"
# (Those of one's own, which compare two futures, join when registered.)
PAIRED_NAMES: set[str] = set()
_DERIVED = re.compile(
    rf"(time_in|entries)_\w+|first_contact_time|{LEAST_GAP}"
    r"|crossings_in_front|groups_cut|contacts_charged"
    r"|(crowd_)?(relative_|(time|path|jerk)\w*_difference)\w*|aggregated_time"
)

# The kinds of NumPy types that are real numbers.
_REAL = "buif"


@dataclass(frozen=True, kw_only=True)
class Metric:
    """A metric: its function, unit, source and definition.

    Attributes:
        name: Its name in tables and files.
        unit: Its unit; "-" for counts.
        family: Its subject.
        direction: Whether lower or higher values are better, or neither.
        source: The origin of its definition.
        definition: Its description, with the formula.
        aliases: Its other names.
        function: The function that computes it.
        reduce: The function from the series that `function` returns to the
            value.
    """

    name: str
    unit: str
    family: str
    direction: Direction
    source: str
    definition: str
    aliases: tuple[str, ...]
    function: MetricFunction
    reduce: Callable[[Array], float] | None

    def compute(self, recording: Recording) -> tuple[float, Array | None]:
        """Returns the value, and its series (N + 1,) if it has one.

        Raises:
            ValueError: If the function raises an error or returns anything
                else. The message names the metric.
        """
        try:
            result: Any = self.function(recording)
            if self.reduce is not None:
                series = _series(result, len(recording))
                return _value(self.reduce(series)), series
            if not isinstance(result, tuple):
                return _value(result), None
            if len(result) != 2:
                raise ValueError(
                    "it must return a number, or the pair of a number and a"
                    f" series, got {len(result)} things"
                )
            value, series = result
            return _value(value), _series(series, len(recording))
        except Exception as error:
            kind = "" if type(error) is ValueError else type(error).__name__
            raise ValueError(
                f"metric {self.name!r}: {kind}{kind and ': '}{error}"
            ) from error


def _value(value: Any) -> float:
    array = np.asarray(value)
    if array.shape == () and array.dtype.kind in _REAL:
        return float(array)
    raise ValueError(
        "its value must be a number; with a series, it must return the pair of"
        f" both, or be registered with `reduce`; got {value!r:.60}"
    )


def _series(series: Any, samples: int) -> Array:
    array = np.asarray(series)
    if array.shape != (samples,):
        raise ValueError(
            f"its series must have one number for each of {samples} samples,"
            f" got the shape {array.shape}"
        )
    if array.dtype.kind not in _REAL:
        raise ValueError(f"its series must be of numbers, got {array.dtype}")
    return array.astype(float, copy=False)


# Names are used as table columns and command words.
_NAME = re.compile(r"[^\s,;\"']+")

# All metrics by name, in the order of their registration.
METRICS: dict[str, Metric] = {}


def register_metric[F: Callable[[Recording], Any]](
    *,
    unit: str,
    family: str,
    source: str,
    name: str | None = None,
    direction: Direction = "none",
    aliases: Iterable[str] = (),
    definition: str | None = None,
    reduce: Callable[[Array], float] | None = None,
) -> Callable[[F], F]:
    """Registers a function of a recording as a metric.

    The function returns the value, or the pair of the value and its series over
    the samples, or, if `reduce` is given, the series alone. NaN means no value.
    A function replaces one that was defined in the same place, as when a
    notebook cell is run again.

    Args:
        unit: Its unit; "-" for counts.
        family: Its subject: "path", "goal", "proxemics", ...
        source: The origin of its definition.
        name: Its name in tables and files; by default, the function's name.
        direction: Whether "lower" or "higher" is better.
        aliases: Its other names.
        definition: Its description; the function's docstring by default. Lists
            show its first line.
        reduce: The function from the series to the value.

    Returns:
        A decorator that returns the function unchanged.

    Raises:
        ValueError: If the name or an alias is taken or not valid as a table
            column, if a text is missing, if the direction is unknown, or if
            `reduce` is no function.
    """
    aliases = (aliases,) if isinstance(aliases, str) else tuple(aliases)

    def register(function: F) -> F:
        own: Any = getattr(function, "__name__", None) if name is None else name
        if not callable(function) or own is None:
            raise ValueError(
                "a metric is a function of a recording; a function without a"
                f" name needs name=..., got {function!r:.80}"
            )
        check_takes(function, f"metric {own!r}", "recording")
        _check_facts(own, unit, family, source, direction)
        if reduce is not None and not callable(reduce):
            raise ValueError(
                f"metric {own!r}: reduce must be a function of a series, as"
                f" np.nanmean, got {reduce!r:.80}"
            )
        for candidate in (own, *aliases):
            _check_name(own, candidate, function)
        text = inspect.cleandoc(definition or function.__doc__ or "")
        METRICS[own] = Metric(
            name=own,
            unit=unit,
            family=family,
            direction=direction,
            source=source,
            definition=text or "(no description)",
            aliases=aliases,
            function=function,
            reduce=reduce,
        )
        return function

    return register


def check_takes(function: Any, what: str, *names: str) -> None:
    """Raises ValueError if a function cannot take arguments of these names."""
    try:
        inspect.signature(function).bind(*names)
    except TypeError:
        raise ValueError(
            f"{what}: the function must take ({', '.join(names)}), got"
            f" {inspect.signature(function)}"
        ) from None


def _check_facts(
    name: str, unit: str, family: str, source: str, direction: str
) -> None:
    """Raises ValueError if the description of a metric is wrong."""
    for text in (unit, family, source):
        if not isinstance(text, str) or not text:
            raise ValueError(
                f"metric {name!r}: unit, family and source must be texts, not"
                f" empty, got {text!r}"
            )
    if direction not in get_args(Direction):
        raise ValueError(
            f"metric {name!r}: direction must be one of {get_args(Direction)},"
            f" got {direction!r}"
            f"{did_you_mean(str(direction), get_args(Direction))}"
        )
    if family in ("paper", "all", name, *METRICS):
        raise ValueError(
            f"metric {name!r}: family must not be the name of something else,"
            f" got {family!r}"
        )


def _check_name(
    name: str, candidate: str, function: Callable[[Recording], Any]
) -> None:
    """Raises ValueError if a metric cannot have a name or alias."""
    if not isinstance(candidate, str) or not _NAME.fullmatch(candidate):
        raise ValueError(
            f"metric {name!r}: a name must be a text without blanks, commas,"
            f" semicolons and quotes, got {candidate!r}"
        )
    if candidate in RESERVED:
        raise ValueError(
            f"metric {name!r}: tables of results have a column {candidate!r}"
            " already; choose another name"
        )
    owner = METRICS.get(candidate) or _by_alias(candidate)
    if owner is None and candidate not in _selections():
        return
    if (
        owner is None
        or owner.name != name
        or origin_of(owner.function) != origin_of(function)
    ):
        what = "a family" if owner is None else f"metric {owner.name!r}"
        raise ValueError(
            f"metric {name!r}: the name {candidate!r} is taken, by {what};"
            " choose another name"
        )


def origin_of(function: Any) -> tuple[object, object]:
    """Returns the place where a function was defined."""
    while isinstance(function, functools.partial):
        function = function.func
    return (
        getattr(function, "__module__", None),
        getattr(function, "__qualname__", function),
    )


def select_metrics(
    names: Iterable[str], recording: Recording | None = None
) -> list[Metric]:
    """Returns the metrics of some names.

    Args:
        names: Names of metrics, their aliases, families, "paper" for the 28
            of HuNavSim's Table I, or "all".
        recording: The recording that they are for: without recorded people,
            those of the family "replay" are left out, and without several
            robots those of "fleet", unless they are named.

    Returns:
        Each metric once, in the order of the names.

    Raises:
        ValueError: If a name is unknown.
    """
    if isinstance(names, str):
        names = [names]
    selections = _selections()
    chosen: dict[str, Metric] = {}
    for name in names:
        metric = METRICS.get(name) or _by_alias(name)
        if metric is not None:
            chosen[metric.name] = metric
        elif name in selections:
            chosen |= {
                m.name: m
                for m in selections[name]
                if recording is None or _applies(m, recording)
            }
        else:
            raise ValueError(_unknown(name))
    return list(chosen.values())


def _applies(metric: Metric, recording: Recording) -> bool:
    if metric.family == REPLAY_FAMILY:
        return recording.replay is not None
    return metric.family != FLEET_FAMILY or bool(recording.others)


def base_name(name: str) -> str:
    """Returns the name of a metric without that of one of several robots.

    In a table, the path length of robot anna is "anna.path_length", and that
    while somebody passes it "anna.path_length[passing]".
    """
    _, point, rest = name.partition(".")
    known = rest in METRICS or rest in PAIRED_NAMES or rest.endswith("]")
    known = known or _DERIVED.fullmatch(rest) is not None
    return rest if point and name not in METRICS and known else name


def _selections() -> dict[str, list[Metric]]:
    """Returns the names of selections, with their metrics."""
    paper = [METRICS[name] for name in TABLE_I if name in METRICS]
    others = [m for m in METRICS.values() if m.name not in TABLE_I]
    families: dict[str, list[Metric]] = {}
    for metric in paper + others:
        families.setdefault(metric.family, []).append(metric)
    return families | {"paper": paper, "all": paper + others}


def _by_alias(name: str) -> Metric | None:
    return next((m for m in METRICS.values() if name in m.aliases), None)


def _unknown(name: object) -> str:
    known = [*METRICS, *_selections()]
    known += [alias for m in METRICS.values() for alias in m.aliases]
    families = f"; families: {', '.join(_selections())}"
    return (
        f"there is no metric or family {shown(name)}"
        f"{did_you_mean(str(name), known) or families}"
    )
