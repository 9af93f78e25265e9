"""What a metric is, and the registry of all of them.

A metric of your own is one decorated function of a recording::

    @register_metric(
        name="final_speed", unit="m/s", family="speeds", source="myself"
    )
    def final_speed(recording: Recording) -> float:
        \"\"\"The speed at the end.\"\"\"
        return float(recording.derived.forward_speed[-1])
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import inspect
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.evaluation.names import TABLE_I
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.suggest import nearest

Array = NDArray[np.float64]
Direction = Literal["lower", "higher", "none"]

# A value; a value with its series over the samples; or the series alone, from
# which the metric's `reduce` makes the value.
Result = float | tuple[float, Array] | Array
MetricFunction = Callable[[Recording], Result]


@dataclass(frozen=True, kw_only=True)
class Metric:
    """One metric, with all that is to be known about it.

    Attributes:
        name: What it is called in tables and files.
        unit: Its unit; "-" for numbers of things.
        family: What it is about.
        direction: Whether less of it is better, or more, or neither.
        source: Who defined it.
        definition: What it is, with its formula.
        aliases: Other names that it is known by.
        function: What computes it.
        reduce: Makes the value of the series that `function` returns.
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
            ValueError: If the function returns anything else.
        """
        result: Any = self.function(recording)
        series: Any = None
        if self.reduce is not None:
            series = result
        elif isinstance(result, tuple):
            result, series = result
        if series is not None and np.shape(series) != (len(recording),):
            raise ValueError(
                f"metric {self.name!r}: its series must have one number for"
                f" each of {len(recording)} samples, got the shape"
                f" {np.shape(series)}"
            )
        if self.reduce is not None:
            result = self.reduce(series)
        return float(result), series


# All metrics by name, in the order of their registration.
METRICS: dict[str, Metric] = {}


def register_metric[F: Callable[[Recording], Any]](
    *,
    name: str,
    unit: str,
    family: str,
    source: str,
    direction: Direction = "none",
    aliases: Iterable[str] = (),
    definition: str | None = None,
    reduce: Callable[[Array], float] | None = None,
) -> Callable[[F], F]:
    """Registers a function of a recording as a metric.

    The function returns the value, or the pair of the value and its series
    over the samples, or, if `reduce` is given, the series alone. What has no
    value is NaN.

    Args:
        name: What it is called in tables and files.
        unit: Its unit; "-" for numbers of things.
        family: What it is about: "path", "goal", "proxemics", ...
        source: Who defined it.
        direction: Whether "lower" or "higher" is better.
        aliases: Other names that it is known by.
        definition: What it is; the function's docstring by default.
        reduce: Makes the value of the series.

    Returns:
        A decorator that returns the function unchanged.

    Raises:
        ValueError: If the name or an alias is taken.
    """

    def register(function: F) -> F:
        for candidate in (name, *aliases):
            owner = METRICS.get(candidate) or _by_alias(candidate)
            if owner is not None or candidate in _selections():
                raise ValueError(
                    f"metric {name!r}: the name {candidate!r} is taken"
                )
        METRICS[name] = Metric(
            name=name,
            unit=unit,
            family=family,
            direction=direction,
            source=source,
            definition=inspect.cleandoc(definition or function.__doc__ or ""),
            aliases=tuple(aliases),
            function=function,
            reduce=reduce,
        )
        return function

    return register


def select_metrics(names: Iterable[str]) -> list[Metric]:
    """Returns the metrics of that name.

    Args:
        names: Names of metrics, their aliases, families, "paper" for the 28
            of HuNavSim's Table I, or "all".

    Returns:
        Each metric once, in the order in which the names bring it up.

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
            chosen |= {m.name: m for m in selections[name]}
        else:
            raise ValueError(_unknown(name))
    return list(chosen.values())


def _selections() -> dict[str, list[Metric]]:
    """Returns the names that stand for several metrics."""
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
    near = nearest(str(name), known)
    return (
        f"there is no metric or family {name!r}; "
        + (f"did you mean {near!r}? " if near else "")
        + f"Families: {', '.join(_selections())}"
    )
