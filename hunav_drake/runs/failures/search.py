"""Searches a space of scenes for failures of a planner."""

from collections.abc import Callable, Generator
import contextlib
import copy
import functools
import json
import math
from pathlib import Path
from typing import Any, Literal, NamedTuple, Unpack, cast

import numpy as np

from hunav_drake.runs.failures.found import (
    Failures,
    Scene,
    kind_of_failure,
    write_failures,
)
from hunav_drake.runs.failures.minimal import Shrinking, shrink
from hunav_drake.runs.failures.scene_runs import (
    RunOptions,
    SceneRuns,
    built_scene,
    failing_of,
    scene_cell,
)
from hunav_drake.runs.failures.space import (
    SearchSpace,
    override_texts,
    read_space,
)
from hunav_drake.runs.suite import PlannerChoice, planner_overrides
from hunav_drake.scenario import LoadScenario, Scenario, ScenarioError
from hunav_drake.scenario.building import Places, build_scenario
from hunav_drake.scenario.checks import ALL_CHECKS, check_begins_alone
from hunav_drake.scenario.error import Fault, Finding, Loc
from hunav_drake.scenario.overrides import apply_overrides
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_choice, check_count
from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    stream,
)
from hunav_drake.systems.evaluation.robustness import NO_FAILURE, Failing

Method = Literal["cma", "random"]

METHODS: tuple[Method, ...] = ("cma", "random")

# Of CMA-ES: the points of a generation, the first deviation in the unit cube,
# and the runs after which it begins anew.
_GENERATION, _SIGMA, _RESTART = 10, 0.3, 150

# Of a descent: the difference that its gradient is taken of, and the first and
# the last step, in the unit cube.
_DIFFERENCE, _STEP, _LAST_STEP = 0.01, 0.1, 0.01

# The largest number of scenes that are made minimal, the worst of each kind.
_KEPT = 20


# Yields points of the unit cube, and is sent their robustness.
_Search = Generator[list[Array], list[float], None]


class _Tried(NamedTuple):
    """A point that was tried, and what became of it."""

    values: dict[str, Any]
    fault: str
    failing: Failing


def Falsify(
    space: SearchSpace | str | Path,
    planner: PlannerChoice | None = None,
    *,
    method: Method = "cma",
    budget: int = 300,
    polish: int = 0,
    seed: int = 0,
    **options: Unpack[RunOptions],
) -> Failures:
    """Searches for scenes in which a planner fails, and makes them minimal.

    Scenes that cannot be simulated, or begin nearer than `require.start_gap`,
    count as far from failing, and are not run. Of the failures, the worst of
    each kind is made minimal: without people, behaviors and digits that it does
    not need. A kind is the direction of the person from the robot, and the
    speed at which they approach each other.

    "cma" descends on the robustness by CMA-ES (Hansen 2016), with 10 scenes in
    a generation; it begins anew after 150 runs, or once a whole generation
    fails. "random" draws each scene by the seed and its number.

    Args:
        space: The scenes, or a file: see `LoadSearchSpace`.
        planner: The planner, as in a suite: a name, or a mapping with its
            parameters; by default that of the scenario.
        method: The method.
        budget: The number of scenes to try.
        polish: The number of further scenes, which descend from the worst one
            along the gradient of the robustness, by differences; ranges of
            numbers change, all else stays.
        seed: The seed of the search, in [0, 2^63).
        options: Where scenes are run; with `out`, a folder gets the results,
            and a search that was interrupted goes on: see `RunOptions`.

    Returns:
        The failures. They do not depend on the number of workers.

    Raises:
        ScenarioError: If the scenario or the space is invalid.
        TypeError: If a count is no whole number.
        ValueError: If an argument is out of its range, or if the folder has the
            runs of another search.
        ImportError: If "cma" is not installed: see the extra `falsify`.
        OSError: If the folder cannot be written, or is in use.
    """
    check_choice("method", method, METHODS)
    budget = check_count("budget", budget, least=1)
    polish = check_count("polish", polish)
    seed = check_seed(seed)
    places = Places()
    if not isinstance(space, SearchSpace):
        space, places = read_space(space)
    ranges = [
        i for i, it in enumerate(space.space.values()) if isinstance(it, list)
    ]
    if polish and not 0 < len(ranges) <= polish:
        raise ValueError(
            f"polish={polish} has no effect: a gradient needs ranges of numbers"
            f" [low, high], here {len(ranges)}, and at least as many scenes;"
            " change it, or leave it out"
        )
    label, keys = planner_overrides(planner) if planner else ("", {})
    base = _base(space, keys, places)
    about = {
        "space": plain(space),
        "planner": [label, dict(keys)],
        "method": method,
        "seed": seed,
    }
    with SceneRuns(about, **options) as runs:
        tried: list[_Tried] = []
        total = budget + polish
        try_all = functools.partial(_try, runs, space, base, tried, total)
        search = _SEARCHES[method](len(space.space), seed, budget)
        points, values = _run_search(search, try_all)
        worst = int(np.argmin(values))
        if polish and math.isfinite(values[worst]):
            descent = _descend(points[worst], values[worst], ranges, polish)
            _run_search(descent, try_all)
        scenes = _minimal(runs, space, base, tried, total)
    failures = Failures(
        robustness=space.robustness,
        scenes=scenes,
        runs=[(it.values, it.failing) for it in tried],
        refused=sum(bool(it.fault) for it in tried),
        fault=next((it.fault for it in tried if it.fault), ""),
    )
    if out := options.get("out"):
        write_failures(failures, Path(out))
    return failures


def _base(space: SearchSpace, planner: Any, places: Places) -> dict[str, Any]:
    """Returns the scenario as plain data, with the space checked on it.

    Raises:
        ScenarioError: If it is invalid, or a path or a range of the space.
    """
    given = [f"planner={json.dumps(planner)}"] if planner else []
    scenario = LoadScenario(
        filename=space.scenario, overrides=[*given, *space.overrides]
    )
    check_begins_alone(scenario)
    data = cast(dict[str, Any], plain(scenario, whole=False))
    faults: dict[Fault, None] = {}
    taken: dict[Loc, str] = {}
    for path, ends in space.ends():
        own: dict[Loc, str] = {}
        for value in ends:
            trial = copy.deepcopy(data)
            texts = override_texts({path: value})
            locs, found = apply_overrides(trial, texts)
            own |= dict.fromkeys(locs, path)
            messages = [it.message for it in found]
            for loc, other in taken.items():
                if any(loc[: len(it)] == it for it in locs):
                    messages.append(f"replaces what {other} sets before")
            if not messages:
                # Only what no scene could have; walls and the like come later.
                checks = ALL_CHECKS if isinstance(value, str) else ()
                _, findings = build_scenario(trial, checks)
                messages = [it.message for it in findings]
            for it in messages:
                finding = Finding(("space", path), it)
                faults[places.fault(finding, None)] = None
        taken |= own
    if faults:
        raise ScenarioError(next(iter(faults)).source, faults)
    return data


def _with_values(
    space: SearchSpace, base: dict[str, Any], values: dict[str, Any]
) -> tuple[dict[str, Any], dict[Loc, list[float]]]:
    """Returns the data of a scene, and the ranges of its numbers by place."""
    data = copy.deepcopy(base)
    ranges: dict[Loc, list[float]] = {}
    for path, value in values.items():
        locs, _ = apply_overrides(data, override_texts({path: value}))
        if isinstance(space.space[path], list):
            ranges |= dict.fromkeys(locs, space.space[path])
    return data, ranges


def _try(
    runs: SceneRuns,
    space: SearchSpace,
    base: dict[str, Any],
    tried: list[_Tried],
    budget: int,
    points: list[Array],
) -> list[float]:
    """Runs scenes, adds them to those tried, and returns their robustness."""
    values = [space.values(point) for point in points]
    scenarios = [
        built_scene(_with_values(space, base, it)[0], space.require.start_gap)
        for it in values
    ]
    outcomes = _run_scenes(runs, scenarios, space.robustness, budget)
    tried += [
        _Tried(it, *end) for it, end in zip(values, outcomes, strict=True)
    ]
    # (Without a trial there is no time, and the robustness is no number that
    # was found.)
    return [
        math.inf if math.isnan(it.time) else it.robustness for _, it in outcomes
    ]


def _run_scenes(
    runs: SceneRuns,
    scenarios: list[Scenario | str],
    robustness: str,
    total: int,
) -> list[tuple[str, Failing]]:
    """Returns how near scenes are to a failure, and before that their faults.

    What has a fault, or a run without a result, is as far as can be.
    """
    valid = [it for it in scenarios if not isinstance(it, str)]
    rows = iter(
        runs.run(
            [
                (scene_cell(it, robustness), [it.simulation.seed])
                for it in valid
            ],
            max(total, runs.done + len(valid)),
        )
    )
    outcomes = []
    for it in scenarios:
        row = None if isinstance(it, str) else next(rows)[0]
        fault = it if isinstance(it, str) else ""
        if row is not None and "robustness" not in row.metrics:
            fault = row.end_message
        outcomes.append((fault, failing_of(row)))
    return outcomes


def _run_search(
    search: _Search, try_all: Callable[[list[Array]], list[float]]
) -> tuple[list[Array], list[float]]:
    """Returns the points that a search has tried, and their robustness."""
    points: list[Array] = []
    values: list[float] = []
    with contextlib.suppress(StopIteration):
        asked = next(search)
        while True:
            found = try_all(asked)
            points += asked
            values += found
            asked = search.send(found)
    return points, values


def _random(size: int, seed: int, budget: int) -> _Search:
    """Yields all points at once, each drawn by the seed and its number."""
    yield [
        stream(seed, run, Purpose.SEARCH).random(size) for run in range(budget)
    ]


def _cma(size: int, seed: int, budget: int) -> _Search:
    """Yields generations of CMA-ES, and is sent their robustness."""
    try:
        import cma
    except ImportError as error:
        raise ImportError(
            "the method 'cma' needs cma: pip install 'hunav_drake[falsify]', or"
            " take the method 'random'"
        ) from error
    left, restart, farthest = budget, 0, NO_FAILURE
    while left:
        draws = stream(seed, restart, Purpose.SEARCH)
        # (It does not search in one dimension: a second one has no effect.)
        start = np.full(max(size, 2), 0.5)
        if restart:
            start = draws.random(len(start))
        strategy = cma.CMAEvolutionStrategy(
            start,
            _SIGMA,
            {
                "bounds": [0.0, 1.0],
                "popsize": _GENERATION,
                # Draws of its own would be global.
                "seed": math.nan,
                "randn": lambda *shape, own=draws: own.standard_normal(shape),
                "verbose": -9,
            },
        )
        restart += 1
        for _ in range(_RESTART // _GENERATION):
            points = [np.asarray(it) for it in strategy.ask()]
            values = yield [point[:size] for point in points[:left]]
            left -= len(values)
            if not left:
                return
            # What is no trial is as far from a failure as the farthest one.
            known = [it for it in values if math.isfinite(it)]
            farthest = max([farthest, *known])
            values = [it if math.isfinite(it) else farthest for it in values]
            strategy.tell(points, values)
            if strategy.stop() or max(values) < 0:
                break


def _descend(
    point: Array, value: float, ranges: list[int], budget: int
) -> _Search:
    """Yields points down the gradient from one, along some coordinates.

    A step that does not lead down is halved.
    """
    left, step = budget, _STEP
    while step > _LAST_STEP and left >= max(len(ranges), 1):
        # (Into the cube.)
        differences = np.where(point[ranges] > 0.5, -1, 1) * _DIFFERENCE
        around = [point.copy() for _ in ranges]
        for near, i, difference in zip(
            around, ranges, differences, strict=True
        ):
            near[i] += difference
        values = np.array((yield around))
        left -= len(values)
        slope = np.zeros(len(point))
        # (Where nothing could fail, it is no number that was found, either.)
        valid = np.isfinite(values) & (values != NO_FAILURE)
        change = np.where(valid, values - value, 0.0)
        slope[ranges] = change / differences
        length = math.hypot(*slope)
        if not length:
            return
        while left and step > _LAST_STEP:
            lower = np.clip(point - step / length * slope, 0.0, 1.0)
            (found,) = yield [lower]
            left -= 1
            if found < value:
                point, value = lower, found
                break
            step /= 2


_SEARCHES: dict[Method, Callable[[int, int, int], _Search]] = {
    "cma": _cma,
    "random": _random,
}


def _minimal(
    runs: SceneRuns,
    space: SearchSpace,
    base: dict[str, Any],
    tried: list[_Tried],
    total: int,
) -> list[Scene]:
    """Returns the worst scene of each kind, made minimal; the worst first."""
    kinds: dict[str, list[int]] = {}
    order = sorted(range(len(tried)), key=lambda i: tried[i].failing.robustness)
    for i in order:
        if tried[i].failing.robustness < 0:
            kinds.setdefault(kind_of_failure(tried[i].failing), []).append(i)
    worst = [members[0] for members in kinds.values()][:_KEPT]
    chains = [
        shrink(
            Shrinking(
                *_with_values(space, base, tried[i].values), tried[i].failing
            )
        )
        for i in worst
    ]
    ends: dict[int, Shrinking] = {}
    answers: dict[int, Failing] = {}
    # All chains go on side by side, to keep the workers busy.
    while len(ends) < len(chains):
        asked = {}
        for k, chain in enumerate(chains):
            if k not in ends:
                try:
                    asked[k] = (
                        chain.send(answers[k]) if answers else next(chain)
                    )
                except StopIteration as stop:
                    ends[k] = stop.value
        scenes = [
            built_scene(it, space.require.start_gap) for it in asked.values()
        ]
        outcomes = _run_scenes(runs, scenes, space.robustness, total)
        failings = [failing for _, failing in outcomes]
        answers = dict(zip(asked, failings, strict=True))
    found: dict[str, Scene] = {}
    # What is minimal may be of another kind.
    for k in sorted(ends, key=lambda k: ends[k].failing.robustness):
        failing = ends[k].failing
        scenario = built_scene(ends[k].data, space.require.start_gap)
        assert isinstance(scenario, Scenario)
        count = len(kinds[kind_of_failure(tried[worst[k]].failing)])
        kind = kind_of_failure(failing)
        scene = Scene(scenario, failing, kind, worst[k], count)
        if kind in found:
            scene = found[kind]._replace(found=found[kind].found + count)
        found[kind] = scene
    return [*found.values()]
