"""Recordings that repeat their last sample, as HuNavSim's evaluator does."""

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.common.layout import CONTACT_SIZE, Contact
from hunav_drake.systems.evaluation import compute_metrics
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.evaluation.recording import Recording


def test_the_last_sample_is_repeated():
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


@pytest.mark.parametrize("first", [0, 2])
def test_stale_samples_change_no_count_and_no_sum_of_contacts(first):
    contacts = np.zeros((4, 1, CONTACT_SIZE))
    contacts[:, 0, Contact.LASTS] = [0, 1, 0, 1]
    contacts[:, 0, Contact.FORCE_X] = [0, 30, 0, 40]
    contacts[:, 0, Contact.PEAK_FORCE] = [0, 60, 60, 60]
    contacts[:, 0, Contact.IMPULSE] = [0, 300, 350, 389.6]
    contacts[:, 0, Contact.BY_ROBOT] = [0, 1, 2, 3]
    contacts[:, 0, Contact.BY_PERSON] = [0, 0, 1, 1]
    recording = Recording(
        times=np.arange(4.0)[first:],
        robot=np.zeros((4, 7))[first:],
        humans=np.ones((4, 1, 7))[first:],
        contacts=contacts[first:],
        contact_forces_known=True,
    )
    longer = recording.with_stale_samples(3, 1.0)
    values = compute_metrics(longer, ["contacts"])
    assert values.equals(compute_metrics(recording, ["contacts"]))
    assert values["contacts_by_robot"] == 3 - first
    assert values["max_contact_force"] == 60.0
    assert values["contact_impulse"] == pytest.approx(389.6 - 350 * (first > 0))
    assert not longer.contacts[-3:, :, Contact.FORCE_X].any()
    assert (longer.contacts[-3:, 0, Contact.BY_ROBOT] == 3).all()


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
