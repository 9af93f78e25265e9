"""Whether relations between planners hold, as tables of a paper show them.

A relation holds if it does so for the means over runs, and in nine of ten
samples that the bootstrap draws from the seeds; in fewer of them, it holds for
these means only, and more runs may decide otherwise; so it does on one seed
that draws something. Of NaN nothing holds.
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
    """What became of a relation.

    Attributes:
        number: What it is called.
        scenarios: Where it applies.
        text: What it says.
        strength: How sure it is that it should hold.
        verdict: Whether it holds, or does so for the means only.
        share: In how many of the samples it holds, from 0 to 1; NaN if it was
            not tested, or on a single seed, which tells no share.
        numbers: What was compared, or why it was not.
    """

    number: int
    scenarios: str
    text: str
    strength: Strength
    verdict: Verdict
    share: float
    numbers: str


class Tally(NamedTuple):
    """How many relations hold.

    Attributes:
        tested: How many were tested.
        held: How many of these hold for the means.
        surely: How many of these do so also in nine of ten resamples.
    """

    tested: int
    held: int
    surely: int

    @property
    def shares(self) -> tuple[float, float]:
        """The parts of `held` and `surely`, from 0 to 1; NaN of none."""
        if not self.tested:
            return math.nan, math.nan
        return self.held / self.tested, self.surely / self.tested


def judge(result: SuiteResult) -> list[Judgement]:
    """Tests the relations of a suite on its runs, in each of its settings."""
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
    """Returns how many of the relations of a strength hold."""
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
    """Returns means, over how many seeds they are, and over which."""
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
    """Returns the places by what formulas call them.

    It is to hold for each of them.
    """
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
