"""What every metric promises, whatever it is given."""

import dataclasses
import math
import warnings

import numpy as np
import pytest

from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.obstacles import Obstacles

WALLS = Obstacles.from_shapes(
    [[[1, -1], [2, -1], [2, 1], [1, 1]], [[0, 3], [4, 3]]], solid=[True, False]
)


def random_recording(samples=4, n=2, **kwargs):
    rng = np.random.default_rng(1)
    states = rng.normal(size=(samples, n + 1, 7))
    states[..., 6] = 0.3
    settings = {
        "times": np.arange(samples) * 0.1,
        "robot": states[:, 0],
        "humans": states[:, 1:],
        "goal": (1.0, 0.0, 0.0),
        "obstacles": WALLS,
        "reference_path": np.array([[0.0, 0, 0], [1, 2, 0]]),
    }
    return Recording(**(settings | kwargs))


def missing(where):
    humans = random_recording().humans.copy()
    humans[where] = np.nan
    return random_recording(humans=humans)


RECORDINGS = {
    "all is there": random_recording(),
    "nobody": random_recording(n=0),
    "one sample": random_recording(samples=1),
    "one sample of nobody": random_recording(samples=1, n=0),
    "two samples": random_recording(samples=2),
    "someone comes": missing(np.s_[:2, 0]),
    "someone comes and goes": missing(np.s_[1:3, 1]),
    "everybody is away at times": missing(np.s_[1:3]),
    "nobody ever is there": missing(np.s_[:]),
    "no goal": random_recording(goal=None),
    "no walls": random_recording(obstacles=Obstacles.from_points([])),
    "no reference": random_recording(reference_path=None),
    "reference of one row": random_recording(reference_path=[[0, 1, 1]]),
    "contacts without forces": random_recording(contacts=np.ones((4, 2, 8))),
    "contacts with forces": random_recording(
        contacts=np.arange(64.0).reshape(4, 2, 8), contact_forces_known=True
    ),
    "contacts with nobody": random_recording(
        n=0, contacts=np.ones((4, 0, 8)), contact_forces_known=True
    ),
    "everyone on one spot": random_recording(
        robot=np.zeros((4, 7)), humans=np.zeros((4, 2, 7))
    ),
    "everyone on one spot in a wall": random_recording(
        robot=np.full((4, 7), 1.5), humans=np.full((4, 2, 7), 1.5)
    ),
    "walls around the start": random_recording(
        obstacles=Obstacles.from_shapes(
            [[[-9, -9], [9, -9], [9, 9], [-9, 9], [-9, -9]]], solid=[False]
        ),
        goal=(20.0, 0.0, 0.0),
    ),
    "near walls without walls": random_recording(
        obstacles=Obstacles.from_points([]),
        nearest_walls=np.full((4, 3, 0, 2), np.nan),
    ),
    "walls that are not known": random_recording(
        obstacles=Obstacles.from_points([]), walls_known=False
    ),
    "near walls alone": random_recording(
        obstacles=Obstacles.from_points([]),
        walls_known=False,
        nearest_walls=np.ones((4, 3, 1, 2)),
    ),
    "a repeated stamp": random_recording(
        times=np.array([0, 0.1, 0.1 + 1e-9, 0.2])
    ),
    "alike in every group": random_recording(group_ids=(3, 3)),
}


def compute(recording):
    return {name: METRICS[name].compute(recording) for name in METRICS}


@pytest.mark.parametrize("case", RECORDINGS.values(), ids=RECORDINGS)
def test_values_are_finite_or_there_are_none(case):
    with warnings.catch_warnings(), np.errstate(all="raise", under="ignore"):
        warnings.simplefilter("error")
        found = compute(dataclasses.replace(case))
    infinite = [n for n, (value, _) in found.items() if math.isinf(value)]
    assert infinite == []
    for name, (_, series) in found.items():
        if series is not None:
            assert series.shape == case.times.shape, name
            assert not np.isinf(series).any(), name


@pytest.mark.parametrize("case", RECORDINGS.values(), ids=RECORDINGS)
def test_shares_lie_between_0_and_100_percent(case):
    shares = {
        name: value
        for name, (value, _) in compute(case).items()
        if METRICS[name].unit == "%"
    }
    assert len(shares) == 8
    for name, value in shares.items():
        assert math.isnan(value) or 0 <= value <= 100, name


def test_computing_changes_nothing_and_each_metric_stands_alone():
    recording = random_recording()
    together = compute(recording)
    assert recording == random_recording()
    for name, values in together.items():
        alone = METRICS[name].compute(random_recording())
        for one, other in zip(values, alone, strict=True):
            assert (one is None) == (other is None), name
            if one is not None:
                assert np.array_equal(one, other, equal_nan=True), name


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_numbers_that_are_none_are_refused_with_their_place(value):
    robot = random_recording().robot.copy()
    robot[2, 3] = value
    with pytest.raises(ValueError, match="sample 2"):
        random_recording(robot=robot)
    humans = random_recording().humans.copy()
    humans[2, 1, 0] = value
    with pytest.raises(ValueError, match="person 1 at sample 2"):
        random_recording(humans=humans)


def test_an_empty_recording_is_refused():
    with pytest.raises(ValueError, match="at least one sample"):
        random_recording(samples=0)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (np.zeros((0, 3)), "must have rows"),
        ([[0.0, math.nan, 0]], "finite"),
        ([[0.0, 1, 0], [0.0, 2, 0]], "reference_path: its times: must incr"),
        ([[0.0, 1]], "must have the shape"),
    ],
)
def test_a_wrong_reference_is_refused(path, message):
    with pytest.raises(ValueError, match=message):
        random_recording(reference_path=path)
