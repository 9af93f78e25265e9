"""Recordings that repeat their last sample, as HuNavSim's evaluator does."""

import numpy as np

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig


def test_the_last_sample_is_repeated_and_meets_nobody():
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=3.0"]
    )
    recording = RunTrial(scenario).recording
    longer = recording.with_stale_samples(3, 0.5)
    assert recording.with_stale_samples(0, 0.5) is recording
    n = len(recording)
    assert len(longer) == n + 3
    end = recording.times[-1]
    later = [end + 0.5, end + 1.0, end + 1.5]
    np.testing.assert_allclose(longer.times[n:], later)
    for name in ("robot", "humans", "behavior_status"):
        rows = getattr(longer, name)
        np.testing.assert_array_equal(rows[:n], getattr(recording, name))
        np.testing.assert_array_equal(rows[n:], rows[[n - 1] * 3])
    assert recording.contacts is not None
    assert not longer.contacts[n:].any()


def test_the_profile_of_the_paper():
    config = EvaluatorConfig(profile="paper")
    assert config == EvaluatorConfig(
        profile="paper", period=1.0, stale_samples=3
    )
    assert EvaluatorConfig(profile="paper", period=0.5).period == 0.5
    scenario = LoadScenario(
        filename="passing", overrides=["evaluator.profile=paper"]
    )
    result = RunTrial(scenario)
    # A sample a second, the end, and three stale ones.
    assert len(result.recording) == int(result.end_time) + 1 + 1 + 3
    # The trial is no longer for it.
    assert result.end_time == RunTrial(scenario).end_time < 26
    # Means are of more samples than were taken.
    plain = LoadScenario(filename="passing", overrides=["evaluator.period=1.0"])
    metrics = RunTrial(plain).metrics
    for name in ("time_to_reach_goal", "path_length", "min_dist_to_people"):
        assert result.metrics[name] == metrics[name]
