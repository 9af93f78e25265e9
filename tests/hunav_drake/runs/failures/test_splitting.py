"""Splitting: a random walk with a known answer, and trials."""

import json
import math

import numpy as np
import pytest

from hunav_drake import (
    LoadScenario,
    RunTrial,
    ScenarioError,
    SplitFailureProbability,
)
from hunav_drake.runs.failures.splitting import levels_at, predicted_gaps, split
from hunav_drake.systems.evaluation import Recording
from hunav_drake.systems.evaluation.robustness import robustness_of
from tests.hunav_drake.runs.failures.scenes import SCENE
from tests.hunav_drake.runs.failures.test_risk import DRAWS, scene

STEPS, TARGET = 100, 35.0


def reaching_probability():
    """Returns how likely a walk of normal steps reaches the target.

    The density below the target is carried from step to step on a grid.
    """
    width = 0.05
    x = np.arange(-80.0, TARGET, width) + width / 2
    kernel = np.exp(-0.5 * np.arange(-8.0, 8.0 + width, width) ** 2)
    density = np.zeros(len(x))
    density[np.argmin(np.abs(x))] = 1.0
    for _ in range(STEPS):
        density = np.convolve(density, kernel / kernel.sum(), "same")
    return 1.0 - density.sum()


def split_walks(count, seed):
    draws = np.random.default_rng(seed)

    def levels(walk):
        return TARGET - np.maximum.accumulate(walk)

    def fork(asked):
        walks = []
        for walk, instant in asked:
            new = walk.copy()
            steps = draws.standard_normal(STEPS - instant)
            new[instant + 1 :] = walk[instant] + np.cumsum(steps)
            walks.append(new)
        return walks

    steps = draws.standard_normal((count, STEPS))
    walks = np.hstack([np.zeros((count, 1)), np.cumsum(steps, axis=1)])
    return split(
        list(walks), levels, lambda it: it.max() >= TARGET, fork, draws
    )


def test_rare_walks_are_as_likely_as_they_are():
    """Spec: 3.75e-4 by Monte Carlo, 4.2e-4 +- 0.4e-4 by splitting."""
    known = reaching_probability()
    assert known == pytest.approx(3.75e-4, rel=0.1)
    found = [split_walks(400, seed) for seed in range(20)]
    error = np.std(found, ddof=1) / math.sqrt(20)
    assert error < 0.12 * known
    assert abs(np.mean(found) - known) < 3.5 * error


def test_paths_that_fail_anyway_are_not_split():
    paths = [np.array([1.0, it]) for it in (-1.0, -2.0, 0.0, 0.0)]
    found = split(paths, lambda it: it, lambda it: it[-1] < 0, None, None)
    assert found == 0.5


def test_nothing_is_found_where_all_paths_come_equally_near():
    paths = [np.array([2.0, 1.0])] * 5
    draws = np.random.default_rng(0)
    assert split(paths, lambda it: it, lambda it: False, None, draws) == 0


def test_gaps_are_predicted_by_constant_velocities():
    robot = np.array([[0.0, 0, 0, 1, 0, 0, 0.3]])
    humans = [
        # Ahead, coming nearer at 2 m/s: they meet after 2 s.
        [4.6, 0, 0, -1, 0, 0, 0.3],
        # Beside it, at the same velocity.
        [0, 2, 0, 1, 0, 0, 0.3],
        # Not there.
        [np.nan] * 7,
    ]
    recording = Recording(times=[0.0], robot=robot, humans=np.array([humans]))
    ((meets, beside, absent),) = predicted_gaps(recording)
    # (It is in the person after 2.25 s, with 0.2 m for each second.)
    assert meets == pytest.approx(0.1 - 0.6 + 0.45)
    assert beside == pytest.approx(1.4)
    assert absent == math.inf


def test_levels_never_rise_and_end_with_the_whole_trial():
    run = RunTrial(scene(DRAWS)).recording
    kind = robustness_of("collision")
    levels = levels_at(run, kind.margins(run, 12.0), 0.25, run.times[-1])
    assert len(levels) == math.floor(run.times[-1] / 0.25 + 1e-6) + 2
    assert (np.diff(levels) <= 0).all()
    failing = kind.failing(run, 12.0)
    assert levels[-1] <= failing.robustness
    # A failure shows up at the first decision after it.
    if failing.robustness < 0:
        k = math.ceil(failing.time / 0.25)
        assert levels[k] <= failing.robustness < levels[0]


def test_levels_of_a_number_are_those_of_the_end():
    robot = np.zeros((5, 7))
    recording = Recording(
        times=0.5 * np.arange(5), robot=robot, humans=np.zeros((5, 0, 7))
    )
    margins = np.array([np.inf] * 4 + [-2.0])
    levels = levels_at(recording, margins, 1.0, 2.0)
    assert levels.tolist() == [1e9, 1e9, -2.0, -2.0]


@pytest.mark.slow
def test_it_agrees_with_monte_carlo_and_repeats_itself(tmp_path, hunav):
    """About a third of these trials fail; others are forked and found."""
    given = scene(DRAWS, "simulation.duration=8.0")
    found = SplitFailureProbability(
        given, particles=10, repeats=3, out=tmp_path / "one"
    )
    plain = sum(
        it.robustness < 0 for it in by_seed(found.failures.runs, range(30))
    )
    assert 0 < plain < 30
    spread = math.hypot(found.error, math.sqrt(plain * (30 - plain) / 30**3))
    assert abs(found.probability - plain / 30) < 3.5 * spread
    assert found.complete
    assert found.runs == len(found.failures.runs) > 30
    kept = (tmp_path / "one" / "runs.jsonl").read_text()
    for options in ({"out": tmp_path / "one"}, {"workers": 2}):
        again = SplitFailureProbability(
            given, particles=10, repeats=3, **options
        )
        assert again.estimates == found.estimates
        assert repr(again.failures.runs) == repr(found.failures.runs)
    assert (tmp_path / "one" / "runs.jsonl").read_text() == kept
    # Failing paths repeat from their files.
    first = found.failures.scenes[0]
    file = tmp_path / "one" / "001.yaml"
    run = RunTrial(LoadScenario(file)).recording
    kind = robustness_of("collision")
    assert kind.failing(run, 8.0) == first.failing


def by_seed(runs, seeds):
    """Returns the trials of the first round."""
    return [it for values, it in runs if not values["redraws"]][: len(seeds)]


@pytest.mark.slow
def test_a_budget_leaves_unfinished_repeats_out(tmp_path):
    found = SplitFailureProbability(
        scene(DRAWS, "simulation.duration=3.0"),
        particles=np.int64(4),
        repeats=np.int64(3),
        budget=np.int64(5),
        out=tmp_path,
    )
    assert not found.complete
    assert found.runs <= 5
    assert math.isnan(found.error)
    assert "nan" not in str(found)


@pytest.mark.slow
def test_failures_of_an_unfinished_repeat_are_kept(tmp_path):
    """The second repeat is not finished: the estimate leaves it out."""
    found = SplitFailureProbability(
        scene(DRAWS, "simulation.duration=8.0"),
        particles=10,
        repeats=2,
        budget=20,
        out=tmp_path,
    )
    assert len(found.estimates) <= 1
    failed = [it for _, it in found.failures.runs if it.robustness < 0]
    assert failed
    assert sum(it.found for it in found.failures.scenes) == len(failed)
    assert (tmp_path / "001.yaml").is_file()


@pytest.mark.slow
def test_what_is_known_at_the_end_only_cannot_be_split():
    with pytest.raises(ValueError, match="known only at the end"):
        SplitFailureProbability(
            scene(DRAWS, "simulation.duration=3.0"), "timeout", particles=2
        )


@pytest.mark.parametrize(
    "overrides", [(), ("crowd.decisions={sigma_heading: 0}",)]
)
def test_without_random_decisions_there_is_nothing_to_split(overrides):
    with pytest.raises(ScenarioError, match=r"--set crowd\.decisions"):
        SplitFailureProbability(scene(*overrides))


def test_without_people_nothing_is_drawn():
    empty = LoadScenario(
        data="robot: {start: [0, 0, 0], goal: [2, 0, 0]}", overrides=[DRAWS]
    )
    with pytest.raises(ScenarioError, match="nothing is drawn"):
        SplitFailureProbability(empty)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"robustness": "colision"}, "collision"),
        ({"particles": 1}, "particles"),
        ({"repeats": 0}, "repeats"),
        ({"particles": 40.0}, "whole numbers"),
        ({"seed": -1}, "seed"),
    ],
)
def test_bad_arguments_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        SplitFailureProbability(scene(DRAWS), **arguments)


@pytest.mark.slow
def test_the_command_says_that_it_is_a_search(hunav, tmp_path):
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    words = ["risk", file, "--workers", 1, "--quiet", "--set", DRAWS]
    code, _, err = hunav(*words, "--splitting", 4, "--confidence", 0.9)
    assert code == 2
    assert "--confidence: is for plain Monte Carlo" in err
    code, _, err = hunav(*words, "--repeats", 4)
    assert code == 2
    assert "--repeats: is for --splitting" in err
    words += ["--splitting", 4, "--repeats", 1]
    code, text, _ = hunav(*words)
    assert code == 0
    code, out, _ = hunav(*words, "--json")
    told = json.loads(out)
    assert code == 0
    is_found = told["probability"] > 0
    assert ("check it by plain Monte Carlo" in text) == is_found
    assert ("No failure was found" in text) != is_found
    assert told["particles"] == 4
    assert told["error"] is None
