"""Checks of arguments that systems share.

On some values that are not finite, Drake ends the process without an error that
Python could catch; so such values must not reach it.
"""

from collections.abc import Collection
import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.suggest import suggestion


def check_kind(
    name: str, value: Any, kind: type[Any] | tuple[type[Any], ...], words: str
) -> None:
    """Checks the type of an argument; a boolean is never a number.

    Raises:
        TypeError: If it is of another kind: "`name` must be `words`, got ...".
    """
    if not isinstance(value, kind) or isinstance(value, bool):
        raise TypeError(
            f"{name} must be {words}, got {type(value).__name__} {value!r:.80}"
        )


def check_choice(name: str, value: Any, choices: Collection[str]) -> None:
    """Checks that an argument is one of some texts.

    Raises:
        ValueError: If it is none; the message has its name, and what is near.
    """
    if not isinstance(value, str) or value not in choices:
        word = value if isinstance(value, str) else ""
        raise ValueError(
            f"{name}: there is no {value!r:.60}; "
            + suggestion(word, [*choices])
        )


def check_number(
    name: str,
    value: float,
    unit: str = "",
    *,
    low: float = 0.0,
    low_open: bool = False,
) -> float:
    """Returns a number, checked to be finite and at least, or above, `low`.

    Raises:
        ValueError: If it is not; the message has its name and unit.
        TypeError: If it is not a number.
    """
    try:
        known = math.isfinite(value)
    except TypeError as error:
        raise TypeError(
            f"{name} must be a number, got {value!r:.80}"
        ) from error
    if known and (value > low if low_open else value >= low):
        return value
    if low == 0.0:
        rule = "positive" if low_open else "at least 0"
    else:
        rule = f"{'above' if low_open else 'at least'} {low:g}"
    raise ValueError(f"{name} must be {rule}, got {value} {unit}".rstrip())


def check_numbers(what: str, values: ArrayLike, words: str, size: int) -> Array:
    """Returns `size` numbers, checked to be finite.

    Raises:
        ValueError: If they are not: "`what` must be `words`, got ...".
    """
    found = np.asarray(values)
    if found.shape == (size,) and found.dtype.kind in "iuf":
        numbers = found.astype(float)
        if np.isfinite(numbers).all():
            return numbers
    raise ValueError(f"{what} must be {words}, got {values!r:.80}")


def check_command(command: ArrayLike) -> Array:
    """Returns (v, omega) in m/s and rad/s, checked to be finite."""
    words = "two finite numbers (v, omega), in m/s and rad/s"
    return check_numbers("the command", command, words, 2)


def check_time_step(value: float) -> float:
    """Returns a time step in seconds, checked to be positive and finite."""
    return check_number("time_step", value, "s", low_open=True)


def check_count(name: str, value: int, least: int = 0) -> int:
    """Returns a count, also one of NumPy, checked not to be too small.

    Raises:
        ValueError: If it is.
        TypeError: If it is not a whole number.
    """
    try:
        value = operator.index(value)
    except TypeError as error:
        raise TypeError(
            f"{name} must be a whole number, got {value!r:.80}"
        ) from error
    if value < least:
        raise ValueError(f"{name} must be at least {least}, got {value}")
    return value


def is_multiple(period: float, time_step: float) -> bool:
    """Returns whether a period is a multiple of a step, both in seconds."""
    ratio = period / time_step
    if not math.isfinite(ratio):
        return False
    count = max(1, round(ratio))
    return abs(period - count * time_step) <= 1e-9 * period


def nearest_multiples(period: float, time_step: float) -> str:
    """Returns the nearest valid periods, for a message."""
    ratio = period / time_step
    if not math.isfinite(ratio):
        return "fewer steps"
    below = max(1, math.floor(ratio)) * time_step
    above = max(1, math.ceil(ratio)) * time_step
    return " or ".join(dict.fromkeys((f"{below:.9g}", f"{above:.9g}")))


def count_steps(period: float, time_step: float, name: str = "period") -> int:
    """Returns the number of steps of a period, both in seconds.

    `name` is that of the period in messages.

    Raises:
        ValueError: If one is not positive, or the period not a multiple of
            the step.
    """
    check_time_step(time_step)
    check_number(name, period, "s", low_open=True)
    if not is_multiple(period, time_step):
        raise ValueError(
            f"{name} must be a multiple of time_step ({time_step} s), got"
            f" {period} s; nearest: {nearest_multiples(period, time_step)}"
        )
    return round(period / time_step)
