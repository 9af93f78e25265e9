"""How likely a rare failure is, by splitting the trials that come near it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
import math
from numbers import Integral
from pathlib import Path
from typing import Any, NamedTuple, Unpack

import numpy as np

from hunav_drake.runs.failures.found import (
    Failures,
    Scene,
    kind_of_failure,
    write_failures,
)
from hunav_drake.runs.failures.risk import check_draws
from hunav_drake.runs.failures.scene_runs import (
    RunOptions,
    SceneCell,
    SceneRuns,
    failing_of,
    scene_cell,
)
from hunav_drake.runs.run_row import RunRow
from hunav_drake.scenario import CheckScenario, Fault, Scenario, ScenarioError
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    stream,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.robustness import Failing, robustness_of

# The part of the paths that ends in each round.
_SHARE = 0.1

# How far a gap is predicted, in steps of how long, in seconds; and how much
# larger the later ones count, in m/s.
_AHEAD, _EVERY, _GROWS = 6.0, 0.25, 0.2

# The level of a trial that has come near to nothing.
_FAR = 1e9

_LEVEL = "level_"

# The times from which on decisions are redrawn, each with a number.
_Redraws = tuple[tuple[float, int], ...]


def split[P](
    paths: Sequence[P],
    levels_of: Callable[[P], Array],
    fails: Callable[[P], bool],
    fork: Callable[[list[tuple[P, int]]], list[P]],
    draws: np.random.Generator,
) -> float:
    """Estimates the probability that a random path fails.

    Adaptive multilevel splitting: in each round, the tenth of the paths that is
    farthest from a failure ends, and others, which came nearer than all of
    these, are forked in their place. (Cerou and Guyader 2007; unbiased, also
    with ties: Brehier et al. 2016.)

    Args:
        paths: Independent paths, N of them.
        levels_of: Returns how near a path has come to a failure up to each of
            its instants, a sequence that never rises, and at its end: at most 0
            for each path that fails.
        fails: Returns whether a path fails.
        fork: Returns, for each of several paths with an instant, one that is
            the same up to this instant, and from there on drawn anew.
        draws: Draws which paths are forked.

    Returns:
        The probability; 0 if all paths came equally near.
    """
    paths = list(paths)
    probability = 1.0
    while True:
        ends = np.array([levels_of(it)[-1] for it in paths])
        limit = np.sort(ends)[-max(1, int(_SHARE * len(paths)))]
        if limit <= 0:
            break
        alive = np.flatnonzero(ends < limit)
        ended = np.flatnonzero(ends >= limit)
        if not len(alive):
            return 0.0
        probability *= len(alive) / len(paths)
        chosen = [paths[i] for i in draws.choice(alive, len(ended))]
        asked = [(it, int(np.argmax(levels_of(it) < limit))) for it in chosen]
        for i, path in zip(ended, fork(asked), strict=True):
            paths[i] = path
    return probability * sum(map(fails, paths)) / len(paths)


@dataclass(frozen=True)
class SplitEstimate:
    """The probability of a failure that splitting found.

    Attributes:
        robustness: The kind of failure.
        particles: The number of paths that are kept at a time.
        estimates: The estimate of each repeat.
        runs: The number of runs in all.
        failures: All runs, and the worst failing one of each kind.
        complete: Whether all repeats were finished within the budget.
    """

    robustness: str
    particles: int
    estimates: list[float]
    runs: int
    failures: Failures
    complete: bool

    @property
    def probability(self) -> float:
        """The mean of the estimates; NaN if no repeat was finished."""
        return float(np.mean(self.estimates)) if self.estimates else math.nan

    @property
    def error(self) -> float:
        """The standard error of the mean; NaN for less than two repeats."""
        count = len(self.estimates)
        if count < 2:
            return math.nan
        return float(np.std(self.estimates, ddof=1) / math.sqrt(count))

    def __str__(self) -> str:
        count = len(self.estimates)
        found, error = "no estimate", ""
        if count:
            found = f"probability {self.probability:.3g}"
        if count > 1:
            error = f"standard error {self.error:.2g}, "
        return (
            f"{self.robustness}: {found} ({error}{count} x {self.particles}"
            f" paths, {self.runs} runs)"
        )


def SplitFailureProbability(
    scenario: Scenario,
    robustness: str = "collision",
    *,
    particles: int = 400,
    repeats: int = 10,
    budget: int = 20_000,
    seed: int = 0,
    **options: Unpack[RunOptions],
) -> SplitEstimate:
    """Estimates how likely a trial fails, by splitting at people's decisions.

    A search: trials that come near to a failure are forked there, and people
    decide anew in each fork (`crowd.decisions`, `redraws`). How near a trial is
    at an instant is the least margin so far and, where margins are those of
    people, the least gap that constant velocities predict for the next 6 s, in
    which each second counts as 0.2 m. The estimate is unbiased, but its error
    is that of few repeats, and can be larger than that of as many runs of
    `EstimateFailureProbability`.

    Args:
        scenario: The scenario, with the planner and random decisions.
        robustness: The kind of failure: see `ROBUSTNESS`.
        particles: The number of paths that are kept at a time, from 2 on.
        repeats: The number of independent estimates.
        budget: The largest number of runs; a repeat that needs more is left
            out.
        seed: The seed of the search, in [0, 2^63): which paths are forked.
        options: Where trials are run; with `out`, a folder gets all failing
            runs as those of `Falsify`, and an interrupted search goes on.

    Returns:
        The estimate. It does not depend on the number of workers.

    Raises:
        ScenarioError: If the scenario is invalid, or nobody decides at random.
        ValueError: If an argument is out of its range, the folder has other
            runs, or the robustness is known only at the end of a trial.
        RuntimeError: If a run has an error.
        OSError: If the folder cannot be written, or is in use.
    """
    robustness_of(robustness)
    numbers = particles, repeats, budget
    whole = all(isinstance(it, Integral) for it in numbers)
    if not whole or particles < 2 or repeats < 1 or budget < 1:
        raise ValueError(
            "particles, repeats and budget must be whole numbers, particles at"
            f" least 2 and the others positive, got {numbers}"
        )
    particles, repeats, budget = map(int, numbers)  # (NumPy's are no JSON.)
    check_seed(seed)
    scenario = CheckScenario(scenario)
    decisions = scenario.crowd.decisions
    if decisions is None or not decisions.sigma_heading or decisions.redraws:
        message = (
            "needs random decisions of people, which splitting redraws; add"
            " --set crowd.decisions={}, without redraws"
        )
        fault = Fault(scenario.name or "scenario", 0, "crowd", message)
        raise ScenarioError(scenario.name or "scenario", [fault])
    cell = scene_cell(scenario, robustness)
    check_draws(scenario, cell)
    about = {
        "splitting": cell.text,
        "robustness": robustness,
        "particles": particles,
        "seed": seed,
    }
    estimates: list[float] = []
    with SceneRuns(about, **options) as runs:
        trials = _Trials(
            runs, scenario, robustness, budget, particles * repeats
        )
        try:
            for repeat in range(repeats):
                probability = split(
                    trials.start(
                        range(particles * repeat, particles * (repeat + 1))
                    ),
                    lambda it: it.levels,
                    lambda it: it.failing.robustness < 0,
                    trials.fork,
                    stream(seed, repeat, Purpose.SEARCH),
                )
                estimates.append(probability)
        except _SpentError:
            pass
    failures = trials.failures()
    if out := options.get("out"):
        write_failures(failures, Path(out))
    return SplitEstimate(
        robustness=robustness,
        particles=particles,
        estimates=estimates,
        runs=len(trials.tried),
        failures=failures,
        complete=len(estimates) == repeats,
    )


class _SpentError(Exception):
    """The budget does not suffice."""


class _Path(NamedTuple):
    """A trial of which decisions were redrawn."""

    seed: int
    redraws: _Redraws
    levels: Array
    failing: Failing


@dataclass(frozen=True, kw_only=True)
class _SplitCell(SceneCell):
    """A scene whose rows tell how near it is at each decision, too."""

    period: float

    def numbers(self, recording: Recording, seed: int) -> dict[str, float]:
        kind = robustness_of(self.robustness)
        end = float(recording.times[-1])
        each = [
            levels_at(it, kind.margins(it, self.duration), self.period, end)
            for it in (robot.until_end() for robot in recording.robots)
        ]
        levels = np.array(each).min(axis=0)
        named = {f"{_LEVEL}{k}": it for k, it in enumerate(levels.tolist())}
        return super().numbers(recording, seed) | named


def levels_at(
    recording: Recording, margins: Array, period: float, end: float
) -> Array:
    """Returns how near a trial has come to a failure up to each decision.

    Args:
        recording: The recording of N + 1 samples.
        margins: Shape (N + 1,) or (N + 1, n) for n people.
        period: The time between two decisions, in seconds, from time 0 on.
        end: The end of the last decision, in seconds.

    Returns:
        A value for each decision up to that time, and one for the whole trial.
    """
    nearest = margins.reshape(len(margins), -1)
    if margins.ndim == 2:
        nearest = np.hstack([nearest, predicted_gaps(recording)])
    nearest = nearest.min(axis=1, initial=_FAR)
    so_far = np.minimum.accumulate(nearest)
    decisions = np.arange(math.floor(end / period + 1e-6) + 1) * period
    last = np.searchsorted(recording.times, decisions + 1e-9) - 1
    levels: Array = np.where(last < 0, _FAR, so_far[np.maximum(last, 0)])
    return np.append(levels, so_far[-1])


def predicted_gaps(recording: Recording) -> Array:
    """Returns the least gaps that constant velocities predict: (N + 1, n).

    Each second of the 6 s that are looked ahead counts as 0.2 m. A person who
    is not there is infinitely far away.
    """
    offset = recording.humans - recording.robot[:, None]
    reach = recording.humans[..., RADIUS] + recording.robot[:, None, RADIUS]
    found = np.full(reach.shape, np.inf)
    for u in np.arange(0.0, _AHEAD + 1e-9, _EVERY).tolist():
        ahead = offset[..., [X, Y]] + u * offset[..., [VX, VY]]
        gap = np.hypot(ahead[..., 0], ahead[..., 1]) - reach + _GROWS * u
        found = np.fmin(found, gap)
    return found


class _Trials:
    """Runs the paths of a search, and keeps them all."""

    def __init__(
        self,
        runs: SceneRuns,
        scenario: Scenario,
        robustness: str,
        budget: int,
        total: int,
    ) -> None:
        assert scenario.crowd.decisions is not None
        self._runs = runs
        self._scenario = scenario
        self._robustness = robustness
        self._period = scenario.crowd.decisions.period
        self._budget, self._total = budget, total
        self.tried: list[_Path] = []

    def start(self, seeds: range) -> list[_Path]:
        """Returns paths that are the trial with some seeds."""
        (rows,) = self._run([(self._cell(self._scenario), [*seeds])])
        paths = self._paths([(seed, ()) for seed in seeds], rows)
        # (Of a single decision, the levels are those of the start and the end.)
        known = np.concatenate([it.levels[:-2] for it in paths])
        if len(known) and (known == _FAR).all():
            raise ValueError(
                f"robustness {self._robustness!r} is known only at the end of a"
                " trial, so there is nothing to split; estimate it by plain"
                " Monte Carlo"
            )
        return paths

    def fork(self, asked: list[tuple[_Path, int]]) -> list[_Path]:
        """Returns paths that decide anew from a decision on."""
        forks: list[tuple[int, _Redraws]] = []
        for k, (path, instant) in enumerate(asked):
            # (Each fork of the search has a number of its own.)
            number = len(self.tried) + k + 1
            time = instant * self._period
            kept = [it for it in path.redraws if it[0] < time]
            forks.append((path.seed, (*kept, (time, number))))
        cells = [(self._cell(self.scene(*fork)), [fork[0]]) for fork in forks]
        rows = self._run(cells)
        return self._paths(forks, [row for (row,) in rows])

    def scene(self, seed: int, redraws: _Redraws) -> Scenario:
        """Returns the scenario of a path."""
        base = self._scenario
        assert base.crowd.decisions is not None
        decisions = replace(base.crowd.decisions, redraws=[*redraws])
        return replace(
            base,
            crowd=replace(base.crowd, decisions=decisions),
            simulation=replace(base.simulation, seed=seed),
        )

    def failures(self) -> Failures:
        """Returns all runs, and the worst failing one of each kind."""
        kinds: dict[str, list[tuple[int, _Path]]] = {}
        order = sorted(
            enumerate(self.tried), key=lambda it: it[1].failing.robustness
        )
        for k, path in order:
            if path.failing.robustness < 0:
                kind = kind_of_failure(path.failing)
                kinds.setdefault(kind, []).append((k, path))
        return Failures(
            robustness=self._robustness,
            scenes=[
                Scene(
                    self.scene(path.seed, path.redraws),
                    path.failing,
                    kind,
                    k,
                    len(own),
                )
                for kind, own in kinds.items()
                for k, path in own[:1]
            ],
            runs=[
                ({"seed": it.seed, "redraws": list(it.redraws)}, it.failing)
                for it in self.tried
            ],
            refused=0,
        )

    def _cell(self, scenario: Scenario) -> SceneCell:
        cell = scene_cell(scenario, self._robustness)
        given: Any = {it.name: getattr(cell, it.name) for it in fields(cell)}
        return _SplitCell(**given, period=self._period)

    def _run(
        self, runs: list[tuple[SceneCell, list[int]]]
    ) -> list[list[RunRow]]:
        count = sum(len(seeds) for _, seeds in runs)
        if len(self.tried) + count > self._budget:
            raise _SpentError
        return self._runs.run(runs, max(self._total, len(self.tried) + count))

    def _paths(
        self, given: list[tuple[int, _Redraws]], rows: Sequence[RunRow]
    ) -> list[_Path]:
        paths = []
        for (seed, redraws), row in zip(given, rows, strict=True):
            if "robustness" not in row.metrics:
                raise RuntimeError(
                    f"seed {seed} has no result: {row.end_message}"
                )
            count = sum(it.startswith(_LEVEL) for it in row.metrics)
            levels = [row.metrics[f"{_LEVEL}{k}"] for k in range(count)]
            paths.append(
                _Path(seed, redraws, np.array(levels), failing_of(row))
            )
        self.tried += paths
        return paths
