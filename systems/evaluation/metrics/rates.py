"""Time averages of metrics that are sums over samples."""

from collections.abc import Callable
from functools import partial

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.recording import Recording

Series = Callable[[Recording], Array]

_RATE = """
    The time average of the series of {}.

    integral s dt / integral dt, where the series s is linear between samples.
    Unlike the sum, it does not grow with the number of samples, and samples
    that are close in time count less. Intervals without a value at one end are
    left out. NaN if there are no others, as for a single sample.
    """


def register_sum_and_rate(
    *, unit: str, family: str, source: str
) -> Callable[[Series], Series]:
    """Registers the sum of a series and its time average, the rate.

    Lower is better, and both have the same unit. The sum has the name and the
    docstring of the function that returns the series, shape (N + 1,); the rate
    is called `<name>_rate`.
    """
    register = partial(
        register_metric, unit=unit, family=family, direction="lower"
    )

    def decorate(function: Series) -> Series:
        name = function.__name__
        register(source=source, reduce=reduce.total)(function)
        register(
            name=f"{name}_rate",
            source="hunav_drake",
            definition=_RATE.format(name),
        )(partial(_rate, series=function))
        return function

    return decorate


def _rate(recording: Recording, *, series: Series) -> float:
    return reduce.time_average(series(recording), recording.times)
