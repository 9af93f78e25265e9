"""How likely a failure is, over the seeds of a scenario."""

from dataclasses import dataclass
from numbers import Integral
from typing import Unpack

from hunav_drake.runs.failures.scene_runs import (
    RunOptions,
    SceneCell,
    SceneRuns,
    failing_of,
    scene_cell,
)
from hunav_drake.runs.intervals import exact_interval
from hunav_drake.scenario import CheckScenario, Fault, Scenario, ScenarioError
from hunav_drake.scenario.checks import check_begins_alone
from hunav_drake.scenario.randomness import how_to_draw
from hunav_drake.systems.evaluation.robustness import Failing, robustness_of
from hunav_drake.trial.provenance import NOTHING_DRAWN

# The rule to stop is tried after so many runs, and then whenever there are half
# as many again: trying it after each run would end at lucky moments.
_FIRST, _GROWTH = 50, 1.5


@dataclass(frozen=True)
class FailureProbability:
    """The estimated probability of a failure.

    Attributes:
        robustness: The kind of failure.
        runs: The number of runs, with the seeds 0, 1, ...
        failures: How many of them failed.
        interval: The exact confidence interval (Clopper and Pearson 1934).
        confidence: Of the interval.
        different: The number of different runs among them.
        failings: How near each run was to the failure, by seed.
        precise: Whether the interval is as narrow as was asked for.
    """

    robustness: str
    runs: int
    failures: int
    interval: tuple[float, float]
    confidence: float
    different: int
    failings: list[Failing]
    precise: bool

    @property
    def probability(self) -> float:
        """The share of the runs that failed."""
        return self.failures / self.runs

    def __str__(self) -> str:
        low, high = self.interval
        return (
            f"{self.robustness}: {self.failures} of {self.runs} runs,"
            f" probability {self.probability:.3g}, {100 * self.confidence:g} %"
            f" interval {low:.2g} to {high:.2g}"
        )


def EstimateFailureProbability(
    scenario: Scenario,
    robustness: str = "collision",
    *,
    relative_half_width: float = 0.5,
    budget: int = 1000,
    confidence: float = 0.95,
    **options: Unpack[RunOptions],
) -> FailureProbability:
    """Estimates how likely a trial fails, by plain Monte Carlo over seeds.

    It runs the seeds 0, 1, ... until half of the width of the interval is less
    than a part of the estimate, or the budget is spent. The rule is tried after
    50 runs, and whenever there are half as many again.

    Args:
        scenario: The scenario, with the planner. Its seeds must draw something,
            as the decisions of people do: `crowd.decisions`.
        robustness: The kind of failure: see `ROBUSTNESS`.
        relative_half_width: That part, positive.
        budget: The largest number of runs.
        confidence: The confidence of the interval, in (0, 1).
        options: Where trials are run; with `out`, finished runs are kept, and
            an estimate that was interrupted goes on: see `RunOptions`.

    Returns:
        The estimate. It does not depend on the number of workers.

    Raises:
        ScenarioError: If the scenario is invalid, or its seeds draw nothing.
        ValueError: If an argument is out of its range, the first runs are all
            equal although something is drawn, or the folder has other runs.
        RuntimeError: If a run has an error.
        OSError: If the folder cannot be written, or is in use.
    """
    robustness_of(robustness)
    if not relative_half_width > 0 or not 0 < confidence < 1:
        raise ValueError(
            "relative_half_width must be positive, and confidence in (0, 1),"
            f" got {relative_half_width}, {confidence}"
        )
    if not isinstance(budget, Integral) or budget < 1:
        raise ValueError(
            f"budget must be a positive whole number, got {budget!r}"
        )
    budget = int(budget)  # (NumPy's are no JSON.)
    cell = scene_cell(CheckScenario(scenario), robustness, setting="risk")
    check_draws(scenario, cell)
    about = {"risk": cell.text, "robustness": robustness}
    failings: list[Failing] = []
    prints: set[float] = set()
    failures, interval, precise = 0, (0.0, 1.0), False
    goal = 0
    with SceneRuns(about, **options) as runs:
        while not precise and goal < budget:
            goal = min(budget, max(_FIRST, int(_GROWTH * goal)))
            seeds = range(len(failings), goal)
            (rows,) = runs.run([(cell, seeds)], budget)
            for row in rows:
                if "robustness" not in row.metrics:
                    raise RuntimeError(
                        f"seed {row.seed} has no result: {row.end_message}"
                    )
                failings.append(failing_of(row))
                prints.add(row.metrics["fingerprint"])
            if len(prints) == 1 and goal > 1:
                raise ValueError(
                    f"all {goal} seeds gave the same trial, although"
                    f" {cell.drawn} should differ: they say nothing about a"
                    f" probability; {how_to_draw(scenario)}"
                )
            failures = sum(it.robustness < 0 for it in failings)
            interval = exact_interval(failures, goal, confidence)
            half = (interval[1] - interval[0]) / 2
            precise = half <= relative_half_width * failures / goal
    return FailureProbability(
        robustness=robustness,
        runs=goal,
        failures=failures,
        interval=interval,
        confidence=confidence,
        different=len(prints),
        failings=failings,
        precise=precise,
    )


def check_draws(scenario: Scenario, cell: SceneCell) -> None:
    """Raises an error unless seeds give different trials of the same people."""
    check_begins_alone(scenario)
    if cell.drawn == NOTHING_DRAWN:
        message = (
            "nothing is drawn at random, so all seeds give the same trial, and"
            f" no probability follows from them; {how_to_draw(scenario)}"
        )
        fault = Fault(scenario.name or "scenario", 0, "", message)
        raise ScenarioError(scenario.name or "scenario", [fault])
