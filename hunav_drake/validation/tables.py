"""Outcomes as text: for the terminal, as CSV and as JSON."""

from collections.abc import Iterable, Sequence
import csv
import io
import json
import math
import textwrap
from typing import Any

import numpy as np

from hunav_drake.validation.case import VERDICTS, Outcome
from hunav_drake.validation.cases import CASES, by_topic

_WIDTH = 80


def models_of(outcomes: Iterable[Outcome]) -> list[str]:
    """Returns the models of outcomes, in order."""
    return list(dict.fromkeys(outcome.model for outcome in outcomes))


def told(outcome: Outcome) -> str:
    """Returns the quantities or the reason of an outcome, as text."""
    return outcome.measured or outcome.reason


def format_table(outcomes: Sequence[Outcome]) -> str:
    """Returns a table for a terminal, 80 columns wide, with a summary."""
    lines = []
    width = max(map(len, models_of(outcomes)), default=0)
    for topic, cases in by_topic(outcome.case for outcome in outcomes).items():
        lines += [topic.upper(), ""]
        for case in cases:
            source = f" ({case.standards})" if case.standards else ""
            lines.append(f"{case.name}{source}")
            lines += _wrapped(f"expected: {case.expected}", "  ", "    ")
            own = [o for o in outcomes if o.case == case.name]
            if case.measure is None:
                lines += _wrapped(
                    f"not applicable: {case.reason}", "  ", "    "
                )
            else:
                for outcome in own:
                    start = f"  {outcome.model:{width}}  {outcome.verdict:6}  "
                    lines += _wrapped(told(outcome), start, " " * len(start))
            lines.append("")
    lines += [_summary(outcomes, model, width) for model in models_of(outcomes)]
    return "\n".join(lines)


def _wrapped(text: str, first: str, rest: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH, initial_indent=first, subsequent_indent=rest
    )


def counts(outcomes: Iterable[Outcome], model: str) -> dict[str, int]:
    """Returns the number of outcomes of a model by verdict."""
    own = [outcome.verdict for outcome in outcomes if outcome.model == model]
    return {verdict: own.count(verdict) for verdict in VERDICTS}


def _summary(outcomes: Sequence[Outcome], model: str, width: int) -> str:
    found = counts(outcomes, model)
    parts = ", ".join(f"{found[verdict]} {verdict}" for verdict in VERDICTS)
    return f"{model:{width}}  {parts}"


def outcomes_csv(outcomes: Iterable[Outcome]) -> str:
    """Returns a table with a row for each case and model."""
    of_case = ["standards", "question", "expected"]
    of_outcome = ["model", "verdict", "measured", "reason"]
    rows = [["case", *of_case, *of_outcome]]
    for it in outcomes:
        case = CASES[it.case]
        cells = [getattr(case, key) for key in of_case]
        rows.append([it.case, *cells, *(getattr(it, k) for k in of_outcome)])
    return _csv(rows)


def numbers_csv(outcomes: Iterable[Outcome]) -> str:
    """Returns a table with a row for each measured number."""
    rows: list[list[Any]] = [["case", "model", "quantity", "index", "value"]]
    for outcome in outcomes:
        for name, values in outcome.numbers.items():
            rows += [
                [outcome.case, outcome.model, name, k, repr(float(value))]
                for k, value in enumerate(np.atleast_1d(values))
            ]
    return _csv(rows)


def _csv(rows: Iterable[Iterable[Any]]) -> str:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def outcomes_json(outcomes: Iterable[Outcome]) -> str:
    """Returns outcomes as JSON, with null for infinite numbers."""
    rows = [
        {
            "case": outcome.case,
            "standards": CASES[outcome.case].standards,
            "expected": CASES[outcome.case].expected,
            "model": outcome.model,
            "verdict": outcome.verdict,
            "measured": outcome.measured,
            "reason": outcome.reason,
            "numbers": {k: _finite(v) for k, v in outcome.numbers.items()},
        }
        for outcome in outcomes
    ]
    return json.dumps(rows, indent=2, ensure_ascii=False, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value if math.isfinite(value) else None
