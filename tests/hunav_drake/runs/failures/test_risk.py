"""How likely a failure is: intervals, when to stop, and what is refused."""

import json
import math

import numpy as np
import pytest
from scipy.stats import binomtest

from hunav_drake import EstimateFailureProbability, LoadScenario, ScenarioError
from hunav_drake.runs.intervals import exact_interval
from tests.hunav_drake.runs.failures.scenes import SCENE

DRAWS = "crowd.decisions={}"
# The robot meets ana or passes her, by what she decides.
MEETING = ["humans.ana.pose=[-0.9, 2.9, -1.57]", "humans.luis.radius=0.2"]


def scene(*overrides):
    return LoadScenario(data=SCENE, overrides=[*MEETING, *overrides])


@pytest.mark.parametrize(
    ("k", "n", "confidence"),
    [(0, 10, 0.95), (10, 10, 0.95), (3, 50, 0.9), (1, 1000, 0.99)],
)
def test_intervals_are_those_of_clopper_and_pearson(k, n, confidence):
    known = binomtest(k, n).proportion_ci(confidence, method="exact")
    found = exact_interval(k, n, confidence)
    assert found == pytest.approx((known.low, known.high), abs=1e-12)


@pytest.mark.slow
def test_the_estimate_is_the_share_of_seeds_that_fail(tmp_path):
    scenario = scene(DRAWS)
    done = []
    found = EstimateFailureProbability(
        scenario,
        budget=30,
        relative_half_width=0.01,
        out=tmp_path,
        progress=lambda *numbers: done.append(numbers),
    )
    assert (found.runs, found.different, found.precise) == (30, 30, False)
    failed = sum(it.robustness < 0 for it in found.failings)
    assert 0 < failed == found.failures < 30
    assert found.probability == failed / 30
    assert found.interval == exact_interval(failed, 30)
    assert f"{failed} of 30 runs" in str(found)
    assert done[-1] == (30, 30)
    kept = (tmp_path / "runs.jsonl").read_text()
    again = EstimateFailureProbability(
        scenario, budget=30, relative_half_width=0.01, out=tmp_path
    )
    assert again.failings == found.failings
    assert (tmp_path / "runs.jsonl").read_text() == kept


@pytest.mark.slow
def test_it_stops_once_the_interval_is_narrow():
    found = EstimateFailureProbability(
        scene(DRAWS), relative_half_width=5.0, budget=200
    )
    assert found.precise
    assert found.runs == 50


def test_seeds_that_draw_nothing_are_refused():
    with pytest.raises(ScenarioError, match=r"same trial.*crowd\.decisions"):
        EstimateFailureProbability(scene())


def test_seeds_that_give_equal_trials_are_refused():
    """Weights are drawn, but nobody is near enough to feel them."""
    alone = scene(
        "humans.ana.forces_mode=random_normal",
        "humans.luis.pose=[90, 90, 0]",
        "humans.luis.goals=[]",
        "humans.ana.pose=[-90, 90, 0]",
        "humans.ana.goals=[]",
        "simulation.duration=2.0",
    )
    with pytest.raises(ValueError, match="all 4 seeds gave the same trial"):
        EstimateFailureProbability(alone, budget=np.int64(4))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"robustness": "colision"}, "collision"),
        ({"budget": 0}, "budget"),
        ({"budget": 1e3}, "budget must be a positive whole number, got 1000.0"),
        ({"confidence": 1.0}, "confidence"),
        ({"relative_half_width": math.nan}, "relative_half_width"),
    ],
)
def test_bad_arguments_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        EstimateFailureProbability(scene(DRAWS), **arguments)


@pytest.mark.slow
def test_the_command_tells_the_estimate(hunav, tmp_path):
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    words = ["risk", file, "--budget", 4, "--workers", 1, "--set"]
    code, _, err = hunav(*words, "robot.radius=0.3")
    assert code == 2
    assert "same trial" in err
    code, out, _ = hunav(*words, DRAWS, "--json", "--quiet")
    assert code == 0
    told = json.loads(out)
    assert told["runs"] == told["different"] == 4
    assert 0 <= told["interval"][0] <= told["probability"]
