"""Time averages of metrics that are sums over samples."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.recording import Recording

Array = NDArray[np.float64]


def register_sum_and_rate(
    function: Callable[[Recording], Array],
    *,
    name: str,
    unit: str,
    family: str,
    source: str,
    definition: str | None = None,
) -> None:
    """Registers the sum of a series, and its time average: the rate.

    Less of it is better.

    Args:
        function: Makes the series, shape (N + 1,).
        name: What the sum is called; the rate is called `<name>_rate`.
        unit: The unit of both.
        family: What it is about.
        source: Who defined the sum.
        definition: What the sum is; the function's docstring by default.
    """
    register_metric(
        name=name,
        unit=unit,
        family=family,
        direction="lower",
        source=source,
        definition=definition,
        reduce=reduce.total,
    )(function)
    register_metric(
        name=f"{name}_rate",
        unit=unit,
        family=family,
        direction="lower",
        source="hunav_drake",
        definition=f"""
            The time average of what {name} sums up.

            integral s dt / integral dt, where the series s goes straight from
            sample to sample: other than the sum, it does not grow with the
            number of samples, and samples that are close in time count less.
            Intervals at one end of which there is no value are left out.
            """,
    )(partial(_rate, series=function))


def _rate(
    recording: Recording, *, series: Callable[[Recording], Array]
) -> float:
    return reduce.time_average(series(recording), recording.times)
