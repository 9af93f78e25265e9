"""What a case of the validation is, and what came out of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
import math
import re
from typing import Any, Literal
import zlib

import numpy as np

# What a case measures, by name: a number, or a list of them.
Numbers = Mapping[str, Any]

Verdict = Literal["passes", "fails", "not applicable"]
VERDICTS: tuple[Verdict, ...] = ("passes", "fails", "not applicable")


@dataclass(frozen=True)
class Setting:
    """What a case is measured with.

    Attributes:
        model: The name of a registered motion model.
        seed: What places and speeds are drawn by.
        quick: Whether to take fewer people, or less time.
    """

    model: str
    seed: int = 0
    quick: bool = False

    def generator(self, purpose: str) -> np.random.Generator:
        """Returns a source of draws that follows from the seed and a name."""
        return np.random.default_rng([self.seed, zlib.crc32(purpose.encode())])


@dataclass(frozen=True)
class Case:
    """A question to a motion model, and what counts as a good answer.

    Attributes:
        name: Of lower-case letters and "_", unlike any other.
        standards: Where the case is from, such as "RiMEA 1"; or nothing.
        question: What it asks.
        expected: The rule of acceptance, in words.
        measure: Simulates, and returns what it measures; None for a case that
            cannot be asked.
        accepts: Whether the numbers are as expected.
        shown: How numbers are told: a template of `str.format`, in which the
            items of a sequence are joined by slashes.
        reason: Why the case is not applicable, if so.
    """

    name: str
    standards: str
    question: str
    expected: str
    measure: Callable[[Setting], Numbers] | None = None
    accepts: Callable[[Numbers], bool] = field(default=bool)
    shown: str = ""
    reason: str = ""


def case(
    standards: str,
    *,
    question: str,
    expected: str,
    accepts: Callable[[Numbers], bool],
    shown: str,
) -> Callable[[Callable[[Setting], Numbers]], Case]:
    """Returns a decorator that makes a function a case of its name.

    Args:
        standards: See `Case`.
        question: See `Case`.
        expected: See `Case`.
        accepts: See `Case`.
        shown: See `Case`.
    """

    def make(measure: Callable[[Setting], Numbers]) -> Case:
        return Case(
            measure.__name__,
            standards,
            question,
            expected,
            measure,
            accepts,
            shown,
        )

    return make


@dataclass(frozen=True)
class Outcome:
    """What a case gave for a model.

    Attributes:
        case: The name of the case.
        model: The name of the model.
        verdict: Whether the numbers are as expected.
        measured: The numbers, as text.
        reason: Why the case is not applicable, or what went wrong.
        numbers: The numbers.
        seconds: How long it took; not compared, since no two runs agree.
    """

    case: str
    model: str
    verdict: Verdict
    measured: str = ""
    reason: str = ""
    numbers: Numbers = field(default_factory=dict)
    seconds: float = field(default=0.0, compare=False)


def judge(case: Case, setting: Setting) -> Outcome:
    """Measures a case, and returns what came out.

    A model that raises an error fails; the error is the reason.
    """
    if case.measure is None:
        return Outcome(
            case.name, setting.model, "not applicable", reason=case.reason
        )
    try:
        numbers = case.measure(setting)
    except Exception as error:
        # On one line, as a cell of a table.
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return Outcome(case.name, setting.model, "fails", reason=reason)
    return Outcome(
        case.name,
        setting.model,
        "passes" if case.accepts(numbers) else "fails",
        measured=describe(case.shown, numbers),
        numbers=numbers,
    )


def describe(template: str, numbers: Numbers) -> str:
    """Returns numbers as a text.

    Args:
        template: A template of `str.format`, with the names of the numbers;
            the format of a sequence is that of its items.
        numbers: The numbers; what is infinite is told as "never".
    """
    text = template.format(**{k: _Shown(v) for k, v in numbers.items()})
    # That has no unit.
    return re.sub(r"\bnever s\b", "never", text)


class _Shown:
    """A number, or several, that format themselves."""

    def __init__(self, value: float | Sequence[float]) -> None:
        self._items = list(np.atleast_1d(np.asarray(value, dtype=float)))

    def __format__(self, spec: str) -> str:
        return " / ".join(
            "never" if math.isinf(item) else format(item, spec)
            for item in self._items
        )
