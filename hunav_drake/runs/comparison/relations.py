"""Tests of expected relations between planners.

A relation holds if it holds for the means over runs, and in nine of ten
bootstrap samples of the seeds. If it holds in fewer samples, the verdict is
"mean only", and more runs may change it; so it is for a single seed that draws
something. No relation holds for NaN.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import Literal, NamedTuple

import numpy as np

from hunav_drake.runs.comparison.identities import IDENTITIES
from hunav_drake.runs.comparison.means import Means, Place, Sample
from hunav_drake.runs.formula import formula_name, holds, names_in
from hunav_drake.runs.suite import Relation, Strength
from hunav_drake.runs.suite_result import SuiteResult

Verdict = Literal["holds", "mean only", "fails", "not tested"]

_SHARE = 0.9


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """The result of testing a relation.

    Attributes:
        number: The number of the relation.
        scenarios: The scenarios.
        text: The relation as text.
        strength: The certainty that it should hold.
        verdict: Whether it holds, or only for the means.
        share: The share of samples in which it holds, from 0 to 1; NaN if it
            was not tested, or on a single seed.
        numbers: The compared numbers, or why there are none.
    """

    number: int
    scenarios: str
    text: str
    strength: Strength
    verdict: Verdict
    share: float
    numbers: str


class Tally(NamedTuple):
    """Numbers of relations.

    Attributes:
        tested: The number of tested relations.
        held: How many of these hold for the means.
        surely: How many of these also hold in nine of ten resamples.
    """

    tested: int
    held: int
    surely: int

    @property
    def shares(self) -> tuple[float, float]:
        """The shares of `held` and `surely`, from 0 to 1; NaN for none."""
        if not self.tested:
            return math.nan, math.nan
        return self.held / self.tested, self.surely / self.tested


def judge(result: SuiteResult) -> list[Judgement]:
    """Tests the relations of a suite on its runs, in each setting."""
    settings = dict.fromkeys(cell.setting for cell in result.cells)
    judgements = []
    for setting in settings:
        found = _judge(result, Means(result, setting))
        if setting:
            found = [
                replace(it, scenarios=f"{it.scenarios} ({setting})")
                for it in found
            ]
        judgements += found
    return judgements


def _judge(result: SuiteResult, means: Means) -> list[Judgement]:
    judgements = []
    if result.suite.identities:
        for number, scenarios, text, test in IDENTITIES:
            try:
                holds, numbers = test(means)
                verdict: Verdict = "holds" if holds else "fails"
                share = float(holds)
            except KeyError as error:
                verdict, share, numbers = _untested(error)
            judgements.append(
                Judgement(
                    number=number,
                    scenarios=scenarios,
                    text=text,
                    strength="strong",
                    verdict=verdict,
                    share=share,
                    numbers=numbers,
                )
            )
    for relation in result.suite.relations:
        try:
            verdict, share, numbers = _test(relation, means)
        except KeyError as error:
            verdict, share, numbers = _untested(error)
        judgements.append(
            Judgement(
                number=relation.number,
                scenarios=", ".join(relation.scenarios),
                text=f"{relation.metric}: {relation.holds}",
                strength=relation.strength,
                verdict=verdict,
                share=share,
                numbers=numbers,
            )
        )
    return judgements


def tally(
    judgements: Sequence[Judgement], strength: Strength = "strong"
) -> Tally:
    """Returns the numbers of relations of a strength."""
    verdicts = [it.verdict for it in judgements if it.strength == strength]
    tested = [it for it in verdicts if it != "not tested"]
    surely = tested.count("holds")
    return Tally(len(tested), surely + tested.count("mean only"), surely)


def _untested(error: KeyError) -> tuple[Verdict, float, str]:
    missing = error.args[0]
    if isinstance(missing, tuple):
        missing = "/".join(reversed(missing[:2]))
    return "not tested", math.nan, f"there are no runs with {missing}"


def _test(relation: Relation, means: Means) -> tuple[Verdict, float, str]:
    held, told, sure = [], [], True
    used = names_in(relation.holds)
    for places in _place_sets(relation, means):
        if missing := sorted(set(used) - set(places)):
            raise KeyError(", ".join(missing))
        sample = means.sample({it: places[it] for it in used}, relation.metric)
        size = len(sample.means[used[0]])
        held.append(holds(relation.holds, sample.means, size))
        told.append(_told(sample))
        sure &= sample.is_sure
    both = np.all(held, axis=0)
    share = float(both[1:].mean()) if sure else math.nan
    verdict: Verdict = "holds" if share >= _SHARE else "mean only"
    if not both[0]:
        verdict = "fails"
    return verdict, share, "; ".join(told)


def _told(sample: Sample) -> str:
    """Returns the means as text, with the number and kind of their seeds."""
    counts = sample.counts
    alike = len(set(counts.values())) == 1
    words = [
        f"{name} {values[0]:.3g}" + ("" if alike else f" (n = {counts[name]})")
        for name, values in sample.means.items()
    ]
    text = ", ".join(words)
    if alike:
        text += f" (n = {next(iter(counts.values()))})"
    return f"{text}, {sample.note}" if sample.note else text


def _place_sets(relation: Relation, means: Means) -> list[dict[str, Place]]:
    """Returns sets of places by name; a formula must hold in each set."""
    scenarios, planners = relation.scenarios, means.planners
    if relation.by == "planner":
        several = len(scenarios) > 1
        return [
            {
                formula_name(f"{p}_{s}" if several else p): (p, s)
                for p in planners
                for s in scenarios
            }
        ]
    if relation.by == "both":
        return [
            {
                formula_name(f"{p}_{b}"): (p, s, b)
                for p in planners
                for b in means.behaviors(s)
            }
            for s in scenarios
        ]
    return [
        {formula_name(b): (p, s, b) for b in means.behaviors(s)}
        for s in scenarios
        for p in planners
    ]
