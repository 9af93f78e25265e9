"""A case of the validation, and its outcome."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
import math
import re
from typing import Any, Literal
import zlib

import numpy as np

# The measured quantities of a case by name: numbers, or lists of numbers.
Numbers = Mapping[str, Any]

Verdict = Literal["passes", "fails", "not applicable"]
VERDICTS: tuple[Verdict, ...] = ("passes", "fails", "not applicable")


@dataclass(frozen=True)
class Setting:
    """The model and the options of a measurement.

    Attributes:
        model: The name of a registered motion model.
        seed: The seed of places and speeds.
        quick: Whether to use fewer people or less time.
    """

    model: str
    seed: int = 0
    quick: bool = False

    def generator(self, purpose: str) -> np.random.Generator:
        """Returns a random generator for the seed and a purpose."""
        return np.random.default_rng([self.seed, zlib.crc32(purpose.encode())])


@dataclass(frozen=True)
class Case:
    """A question to a motion model, and its rule of acceptance.

    Attributes:
        name: A unique name of lower-case letters and "_".
        standards: The source of the case, such as "RiMEA 1"; may be empty.
        question: The question.
        expected: The rule of acceptance, in words.
        measure: Simulates, and returns the measured quantities; None for a case
            that is not applicable.
        accepts: Returns whether the quantities pass.
        shown: The template of the quantities, for `describe`.
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
    """Returns a decorator that makes a function a `Case` of its name."""

    def make(measure: Callable[[Setting], Numbers]) -> Case:
        name = measure.__name__
        return Case(
            *(name, standards, question, expected, measure, accepts, shown)
        )

    return make


@dataclass(frozen=True)
class Outcome:
    """The outcome of a case for a model.

    Attributes:
        case: The name of the case.
        model: The name of the model.
        verdict: Whether the model passes.
        measured: The quantities as text.
        reason: Why the case is not applicable, or the error.
        numbers: The quantities.
        seconds: The real time of the measurement, in seconds; not compared.
    """

    case: str
    model: str
    verdict: Verdict
    measured: str = ""
    reason: str = ""
    numbers: Numbers = field(default_factory=dict)
    seconds: float = field(default=0.0, compare=False)


def judge(case: Case, setting: Setting) -> Outcome:
    """Measures a case, and returns its outcome.

    A model that raises an error fails; the error is the reason.
    """
    if case.measure is None:
        return Outcome(
            case.name, setting.model, "not applicable", reason=case.reason
        )
    try:
        numbers = case.measure(setting)
    except Exception as error:
        # In one line, for a cell of a table.
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
    """Returns quantities as text by a template of `str.format`.

    Items of a sequence are joined by slashes; infinite values are "never".
    """
    text = template.format(**{k: _Shown(v) for k, v in numbers.items()})
    # "never" has no unit.
    return re.sub(r"\bnever s\b", "never", text)


class _Shown:
    """One or several numbers with a format for `str.format`."""

    def __init__(self, value: float | Sequence[float]) -> None:
        self._items = list(np.atleast_1d(np.asarray(value, dtype=float)))

    def __format__(self, spec: str) -> str:
        return " / ".join(
            "never" if math.isinf(item) else format(item, spec)
            for item in self._items
        )
