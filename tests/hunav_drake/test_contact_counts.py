"""Contacts of whole trials: how bodies are kept apart does not tell on them."""

import json

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.common.layout import Contact

STEP = 0.05
# Whose bodies are as near as this may have been kept apart, in meters.
NEAR = 0.01


def among_distracted(seed, *, keep_apart, period=STEP):
    """Returns the trial of a robot among three people who do not look."""
    rng = np.random.default_rng([seed, 5])
    humans = []
    for _ in range(3):
        side = rng.choice([-1.0, 1.0])
        x, y = rng.uniform(2, 6), side * rng.uniform(1.5, 4)
        humans.append(
            {
                "pose": [x, y, -side * np.pi / 2],
                "goals": [[x + rng.uniform(-1, 1), -y], [x, y]],
                "behavior": "distracted",
                "desired_speed": rng.uniform(0.6, 1.3),
                "cyclic": True,
            }
        )
    data = {
        "robot": {"goal": [8, 0, 0]},
        "planner": "dwb",
        "humans": humans,
        # (Among people of the default's weights, few meet the robot first.)
        "crowd": {"keep_apart": keep_apart, "profile": "hunav_drake_0.1"},
        "evaluator": {"period": period},
        "simulation": {"seed": seed, "duration": 20.0},
    }
    return RunTrial(LoadScenario(data=json.dumps(data)))


def check(seed):
    """Checks a trial; returns if there was a contact that is compared.

    Once people have met each other, these are different trials.
    """
    begun, pairs = [], []
    for keep_apart in (True, False):
        recording = among_distracted(seed, keep_apart=keep_apart).recording
        contacts = recording.contacts
        counts = contacts[..., Contact.BY_ROBOT :].sum(axis=2)
        # Who came so near has touched, and every contact is charged.
        offsets = recording.humans[..., :2] - recording.robot[:, None, :2]
        gaps = np.hypot(*offsets.T).T - recording.robot[:, 6:] - 0.25
        assert (counts[-1] > 0)[(gaps < 0).any(axis=0)].all()
        lasts = contacts[..., Contact.LASTS] > 0
        assert (counts[lasts] > 0).all()
        assert (gaps.min(axis=0)[counts[-1] > 0] < 0.01).all()
        # Who touches first, when, and who is charged.
        k = int(np.argmax(lasts.any(axis=1)))
        places = recording.humans[: k + 1, :, :2]
        between = places[:, [0, 0, 1]] - places[:, [1, 2, 2]]
        pairs.append(np.hypot(*between.T).min())
        whose = contacts[k, :, Contact.BY_ROBOT :]
        begun.append((recording.times[k], whose))
    if min(pairs) < 0.5 + NEAR:
        return False
    (one, whose), (other, others) = begun
    assert abs(one - other) <= STEP + 1e-9
    np.testing.assert_array_equal(whose, others)
    return one > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 22])
def test_first_contacts_are_the_same_with_bodies_kept_apart(seed):
    check(seed)


@pytest.mark.slow
def test_first_contacts_of_many_trials_are_the_same():
    met = [check(seed) for seed in range(25)]
    assert np.count_nonzero(met) >= 10


@pytest.mark.slow
def test_counts_do_not_depend_on_when_samples_are_taken():
    names = ["contacts_by_robot", "contacts_by_person"]
    results = [
        among_distracted(11, keep_apart=True, period=period).metrics[names]
        for period in (0.05, 0.7, 5.0)
    ]
    assert results[0].sum() > 0
    for other in results[1:]:
        assert other.equals(results[0])
