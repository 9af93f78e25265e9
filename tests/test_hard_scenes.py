"""Each scene of the suite "hard" fails as it has always failed, bit for bit.

`python -m tests.test_hard_scenes` writes `data/hard_scenes.json` anew. A commit
that must do so says why: a planner that no longer fails is good news.
"""

import json
from pathlib import Path

import pytest

from hunav_drake import LoadScenario, LoadSuite, RunTrial
from hunav_drake.runs.failures.scene_runs import recording_sha256
from hunav_drake.scenarios import hard_names
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation.robustness import ROBUSTNESS
from tests.test_golden import machine

RECORDED = Path(__file__).parent / "data" / "hard_scenes.json"


def recorded():
    return json.loads(RECORDED.read_text())


def facts(name):
    """Returns how a scene fails: in the first kind of failure that it has."""
    scenario = LoadScenario(name)
    recording = RunTrial(scenario).recording
    duration = scenario.simulation.duration
    failings = {
        kind: it.failing(recording, duration) for kind, it in ROBUSTNESS.items()
    }
    kind = next(kind for kind, it in failings.items() if it.robustness < 0)
    found = failings[kind]
    return {
        "kind": kind,
        "sha256": recording_sha256(recording),
        "robustness": found.robustness,
        "time": found.time,
        "person": recording.human_names[found.person],
    }


def test_the_suite_has_all_scenes():
    suite = LoadSuite(filename="hard")
    assert len(suite.scenarios) >= 12
    assert sorted(suite.scenarios) == hard_names() == [*recorded()["scenes"]]


@pytest.mark.slow
@pytest.mark.parametrize("name", hard_names())
def test_a_scene_fails_as_ever(name):
    got, expected = facts(name), recorded()["scenes"][name]
    assert got["kind"] == expected["kind"]
    assert got["time"] == pytest.approx(expected["time"], abs=1e-6)
    assert got["person"] == expected["person"]
    assert got["robustness"] == pytest.approx(expected["robustness"], abs=1e-3)
    if machine() == recorded()["machine"]:
        assert got["sha256"] == expected["sha256"]


@pytest.mark.parametrize("name", hard_names())
def test_a_scene_says_what_happens(name):
    scenario = LoadScenario(name)
    planner = name.removeprefix("hard/").split("_")[0]
    assert name_of(scenario.planner) == planner
    text = scenario.description
    assert text.startswith(f"With {planner}, the robot ")
    assert any(it.name in text for it in scenario.humans)


if __name__ == "__main__":
    scenes = {name: facts(name) for name in hard_names()}
    RECORDED.write_text(
        json.dumps({"machine": machine(), "scenes": scenes}, indent=1) + "\n"
    )
