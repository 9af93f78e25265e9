"""Every shipped scenario gives the results it has always given, bit for bit.

`python -m tests.test_golden` writes `data/golden.json` anew, but for trials
with the profile of an earlier version, which stay. A commit that must do so
says why. A scenario that had the same results for all seeds is run
once: see `test_randomness.py`.
"""

import functools
import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from hunav_drake import ListScenarios, LoadScenario, RunTrial
from hunav_drake.trial.machine import machine_traits
from hunav_drake.trial.provenance import program_versions

GOLDEN = Path(__file__).parent / "data" / "golden.json"
SEEDS = (0, 1, 2)
LONG = (
    *("elevator_lobby", "fleet", "hospital", "lecture_hall_exit"),
    *("museum", "supermarket"),
)


def machine() -> dict[str, str | int]:
    """What the last bits depend on, but for this package."""
    told = {**program_versions(), **machine_traits()}
    del told["hunav_drake"]
    return told


def facts(
    scenario: str, seed: int, profile: str | None = None
) -> dict[str, object]:
    changes = [] if profile is None else [f"crowd.profile={profile}"]
    loaded = LoadScenario(filename=scenario, overrides=changes)
    result = RunTrial(loaded, seed=seed)
    recording = result.recording
    ends = result.robot_ends or {"": result.end_reason}
    for robot in recording.robots:
        away = robot.until_end().robot[-1, :2] - robot.goal[:2]
        assert (ends[robot.robot_name] == "goal") == (
            np.hypot(*away) <= robot.goal_tolerance
        )
    assert np.isfinite(recording.humans[recording.features.present]).all()
    if seed == 0:
        assert result.end_reason == "goal"
        assert not any(
            value
            for name, value in result.metrics.items()
            if name.endswith("robot_on_person_collisions")
        )
    digest = hashlib.sha256()
    for name in ("times", "robot", "humans", "behavior_status"):
        array = np.ascontiguousarray(getattr(recording, name))
        digest.update(f"{name}{array.dtype.str}{array.shape}".encode())
        digest.update(array.tobytes())
    for other in recording.others:
        digest.update(np.ascontiguousarray(other.robot).tobytes())
    about = (
        recording.human_names,
        recording.human_ids,
        recording.behaviors,
        recording.group_ids,
        recording.goal,
    )
    digest.update(repr(about).encode())
    digest.update(recording.obstacles.segments.tobytes())
    metrics = {k: repr(float(v)) for k, v in result.metrics.items()}
    return {
        "recording": digest.hexdigest(),
        "metrics": hashlib.sha256(
            json.dumps(metrics, sort_keys=True).encode()
        ).hexdigest(),
        "end": [result.end_reason, result.end_time],
        "robot": recording.robot[-1].round(9).tolist(),
        "humans": recording.humans[-1].round(9).tolist(),
    }


def cases() -> list[tuple[str, int]]:
    return [(name, seed) for name in ListScenarios() for seed in SEEDS]


@functools.cache
def golden():
    return json.loads(GOLDEN.read_text())


def different_cases() -> list[object]:
    """Returns the first seed, and as slow ones those with other results.

    Long trials are slow ones, too.
    """
    trials = golden()["trials"]
    first, *others = SEEDS
    slow = pytest.mark.slow
    return [
        *(
            pytest.param(name, first, marks=[slow] * (name in LONG))
            for name in ListScenarios()
        ),
        *(
            pytest.param(name, seed, marks=slow)
            for name, seed in cases()
            if seed in others
            and trials.get(f"{name} {seed}") != trials.get(f"{name} {first}")
        ),
    ]


def test_every_scenario_has_golden_trials():
    assert golden()["trials"].keys() == {f"{n} {seed}" for n, seed in cases()}


@pytest.mark.parametrize(("scenario", "seed"), different_cases())
def test_a_trial_is_as_ever(scenario, seed):
    check(facts(scenario, seed), golden()["trials"][f"{scenario} {seed}"])


@pytest.mark.parametrize(
    ("profile", "scenario"),
    [
        pytest.param(
            *(p, name), marks=[pytest.mark.slow] * (name.split()[0] in LONG)
        )
        for p in golden()["profiles"]
        for name in golden()["profiles"][p]
    ],
)
def test_the_profile_of_an_earlier_version_gives_its_results(profile, scenario):
    expected = golden()["profiles"][profile][scenario]
    name, seed = scenario.split()
    assert expected != golden()["trials"][scenario]
    check(facts(name, int(seed), profile), expected)


def check(got, expected):
    assert got["end"] == expected["end"]
    # On another machine the last bits differ, and grow with the time.
    assert got["robot"] == pytest.approx(expected["robot"], abs=1e-4)
    assert np.array(got["humans"]) == pytest.approx(
        np.array(expected["humans"]), abs=1e-4, nan_ok=True
    )
    if machine() == golden()["machine"]:
        assert got["recording"] == expected["recording"]
        assert got["metrics"] == expected["metrics"]


if __name__ == "__main__":
    trials = {f"{name} {seed}": facts(name, seed) for name, seed in cases()}
    kept = golden()["profiles"]
    GOLDEN.write_text(
        json.dumps(
            {"machine": machine(), "trials": trials, "profiles": kept}, indent=1
        )
        + "\n"
    )
