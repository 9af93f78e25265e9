"""A detector with errors, against the distributions that it draws from."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from scipy.stats import binom, kstest, poisson

from hunav_drake.systems.common.layout import OUTSIDE, is_outside
from hunav_drake.systems.sensing import (
    PeopleDetector,
    PeopleDetectorConfig,
    VisiblePeople,
)
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.sensing.scans import NOWHERE, rows

# Without errors.
EXACT = dict.fromkeys(
    (
        *("missed", "missed_per_meter", "noise", "noise_per_meter"),
        *("velocity_noise", "false_rate"),
    ),
    0.0,
)
WALL = Obstacles.from_shapes([[(2, -9), (2, 9)]], solid=[False])


def make(people=(), *, obstacles=NOWHERE, time_step=0.1, seed=0, **config):
    number = config.pop("number", 0)
    return PeopleDetector(
        PeopleDetectorConfig(**EXACT | config),
        obstacles=obstacles,
        num_humans=len(people),
        time_step=time_step,
        seed=seed,
        number=number,
    )


def fix(dut, context, people, robot):
    dut.GetInputPort("robot_state").FixValue(context, rows(robot)[0])
    dut.GetInputPort("human_states").FixValue(context, np.ravel(people))


def detections(dut, people, times, *, context=None, robot=(0, 0, 0)):
    """The rows at each time, shape (k, n, 7), and the simulator."""
    simulator = Simulator(dut, context or dut.CreateDefaultContext())
    own = simulator.get_mutable_context()
    fix(dut, own, people, robot)
    result = []
    for time in times:
        simulator.AdvanceTo(time)
        seen = dut.GetOutputPort("visible_people").Eval(own).reshape(-1, 7)
        visible = dut.GetOutputPort("visible").Eval(own)
        np.testing.assert_array_equal(visible, ~is_outside(seen))
        result.append(seen.copy())
    return np.array(result), simulator


def walkers(*places):
    people = rows(*places)
    people[:, 2:6] = [0.3, 0.8, -0.4, 0.1]
    return people


CROWD = walkers((4, 0), (-3, 2), (7.5, 1), (20, 0), (0, -6))


def test_without_errors_it_detects_as_visible_people():
    dut = make(CROWD, obstacles=WALL, field_of_view=4.0)
    exact = VisiblePeople(
        PeopleDetectorConfig(field_of_view=4.0), obstacles=WALL, num_humans=5
    )
    context = exact.CreateDefaultContext()
    fix(exact, context, CROWD, (0, 0, 2.0))
    expected = exact.GetOutputPort("visible_people").Eval(context)
    assert 0 < is_outside(expected.reshape(-1, 7)).sum() < 5
    found, _ = detections(dut, CROWD, [0, 0.1, 0.35], robot=(0, 0, 2.0))
    for one in found:
        np.testing.assert_array_equal(one.ravel(), expected)


def test_a_mirrored_world_without_errors_is_detected_mirrored():
    sign = np.array([1, -1, -1, 1, -1, -1, 1])
    dut = make(CROWD, field_of_view=2.0, range_max=7.0)
    found, _ = detections(dut, CROWD, [0.0], robot=(0.5, 0.25, 0.2))
    other, _ = detections(dut, CROWD * sign, [0.0], robot=(0.5, -0.25, -0.2))
    here = ~is_outside(found)
    assert 0 < here.sum() < 5
    np.testing.assert_array_equal(here, ~is_outside(other))
    np.testing.assert_array_equal(other[here], found[here] * sign)


def assert_binomial(hits, trials, p):
    low, high = binom.interval(1 - 1e-6, trials, p)
    assert low <= hits <= high, (hits, trials, p)


@pytest.mark.parametrize("time_step", [0.02, 0.05, 0.1])
def test_people_are_missed_as_often_as_is_said_whatever_the_step(time_step):
    dut = make(CROWD, missed=0.1, missed_per_meter=0.08, time_step=time_step)
    n = 400
    found, _ = detections(dut, CROWD, np.arange(n) * 0.1)
    missed = is_outside(found).sum(axis=0)
    away = np.hypot(*CROWD[:, :2].T)
    for i in (0, 1, 2, 4):
        assert_binomial(missed[i], n, 0.1 + 0.08 * away[i])
    assert missed[3] == n
    # Each frame anew, and nobody with another.
    echo = np.corrcoef(is_outside(found)[:, [0, 1, 2, 4]].T)
    assert abs(echo - np.eye(4)).max() < 5 / math.sqrt(n)


def test_places_and_velocities_have_normal_errors_by_distance():
    dut = make(CROWD, noise=0.02, noise_per_meter=0.03, velocity_noise=0.2)
    found, _ = detections(dut, CROWD, np.arange(600) * 0.1)
    for i in (0, 1, 2, 4):
        deviation = 0.02 + 0.03 * np.hypot(*CROWD[i, :2])
        errors = found[:, i] - CROWD[i]
        for k, scale in ((0, deviation), (1, deviation), (3, 0.2), (4, 0.2)):
            assert kstest(errors[:, k] / scale, "norm").pvalue > 1e-4
        np.testing.assert_array_equal(errors[:, [2, 5, 6]], 0)
    np.testing.assert_array_equal(
        found[:, 3], [[OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0]] * 600
    )


@pytest.mark.parametrize("time_step", [0.05, 0.1])
def test_false_detections_begin_at_their_rate_and_last_their_time(time_step):
    dut = make(false_rate=0.8, false_duration=1.5, time_step=time_step)
    found, _ = detections(dut, (), np.arange(2000) * 0.1)
    present = ~is_outside(found)
    places = np.where(present, found[:, :, 0], np.nan)
    stays = places[1:] == places[:-1]
    begun = (present[1:] & ~stays).sum()
    low, high = poisson.interval(1 - 1e-6, 0.8 * 200)
    assert low <= begun <= high
    # Each frame, one lasts with the same probability.
    assert_binomial(stays.sum(), present[:-1].sum(), math.exp(-0.1 / 1.5))


def test_false_detections_are_anywhere_in_view():
    view = {"field_of_view": 2.0, "range_max": 6.0}
    dut = make(false_rate=8, false_duration=0.2, max_false=9, **view)
    robot = (1, 2, 0.7)
    found, _ = detections(dut, (), np.arange(500) * 0.1, robot=robot)
    seen = found[~is_outside(found)]
    # (One that lasts counts once.)
    seen = seen[np.unique(seen[:, 0], return_index=True)[1]]
    assert len(seen) > 300
    x, y = (seen[:, :2] - robot[:2]).T
    angles = np.arctan2(y, x) - 0.7
    away = np.hypot(x, y)
    low = 0.3 + 0.3
    assert kstest(angles / 2 + 0.5, "uniform").pvalue > 1e-4
    area = (away**2 - low**2) / (6**2 - low**2)
    assert kstest(area, "uniform").pvalue > 1e-4
    np.testing.assert_array_equal(seen[:, 3:6], 0)
    np.testing.assert_array_equal(seen[:, 6], 0.3)
    # None is behind a wall.
    dut = make(obstacles=WALL, false_rate=8, max_false=9, **view)
    found, _ = detections(dut, (), np.arange(100) * 0.1)
    seen = found[~is_outside(found)]
    assert len(seen) > 100
    assert seen[:, 0].max() <= 2 + 1e-9


def test_false_detections_need_rows_and_are_no_more_than_those():
    assert make(CROWD, max_false=3).GetOutputPort("visible").size() == 5
    dut = make(CROWD, false_rate=50, false_duration=9, max_false=3)
    found, _ = detections(dut, CROWD, np.arange(20) * 0.1)
    assert found.shape == (20, 8, 7)
    assert (~is_outside(found[1:, 5:])).mean() > 0.95


def test_a_false_detection_ends_when_it_is_out_of_view():
    dut = make(false_rate=50, false_duration=900, range_max=3.0)
    _, simulator = detections(dut, (), [1.0])
    first, _ = detections(dut, (), [1.1], context=simulator.get_context())
    assert not is_outside(first).any()
    far = simulator.get_context().Clone()
    gone, _ = detections(dut, (), [1.2], context=far, robot=(90, 0, 0))
    assert not np.isin(gone[..., 0], first[..., 0]).any()


ALL = {"missed": 0.2, "noise": 0.1, "velocity_noise": 0.1, "false_rate": 1.0}


def test_errors_follow_from_seed_and_number_and_row():
    times = np.arange(60) * 0.1
    first, _ = detections(make(CROWD, seed=3, **ALL), CROWD, times)
    again, _ = detections(make(CROWD, seed=3, **ALL), CROWD, times)
    np.testing.assert_array_equal(first, again)
    for other in ({"seed": 4}, {"seed": 3, "number": 1}):
        changed, _ = detections(make(CROWD, **other, **ALL), CROWD, times)
        assert (changed[:, :3] != first[:, :3]).any(axis=(1, 2)).mean() > 0.9
    # One person more changes nothing for the others.
    more = np.vstack([CROWD, walkers((1, 1))])
    some, _ = detections(make(more, seed=3, **ALL), more, times)
    np.testing.assert_array_equal(some[:, :5], first[:, :5])
    dut = make(CROWD, **ALL)
    context = dut.CreateDefaultContext()
    dut.SetSeed(context, 3)
    reseeded, _ = detections(dut, CROWD, times, context=context)
    np.testing.assert_array_equal(reseeded, first)


def test_a_clone_of_a_detector_has_the_same_future():
    dut = make(CROWD, **ALL, time_step=0.05)
    times = np.arange(60) * 0.1
    expected, _ = detections(dut, CROWD, times)
    _, forked = detections(dut, CROWD, times[:31])
    detections(dut, CROWD, times[:40])
    clone = forked.get_context().Clone()
    rest, _ = detections(dut, CROWD, times[31:], context=clone)
    np.testing.assert_array_equal(rest, expected[31:])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"missed": 1.1}, r"must be in \[0, 1\], got 1.1"),
        ({"noise_per_meter": -0.1}, r"must be in \[0, 1\] m/m"),
        ({"false_duration": 0.0}, r"must be in \(0, 1000\] s"),
        ({"max_false": 0}, "at least 1"),
        ({"time_step": 0.03}, "period must be a multiple of time_step"),
    ],
)
def test_a_detector_that_cannot_be_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        make(CROWD, **options)
