"""Estimated poses, against the models of their errors."""

import itertools
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from scipy.stats import chi2

from hunav_drake.systems.common.layout import OUTSIDE
from hunav_drake.systems.sensing import LOCALIZATIONS, Localization, SensingTask
from hunav_drake.systems.sensing.localization_config import (
    GaussMarkov,
    Odometry,
)
from hunav_drake.systems.world.shapes import World
from tests.systems.sensing.scans import moved, outputs, rows

NO_ERRORS = dict.fromkeys(("alpha1", "alpha2", "alpha3", "alpha4"), 0.0)


def robot_row(time, *, v=0.8, omega=0.0, pose=(1, -2, 0.5)):
    """A robot that drives on an arc at constant speeds, exactly."""
    x, y, yaw = pose
    half = 0.5 * omega * time
    way = v * time * (math.sin(half) / half if half else 1)
    (row,) = rows(
        (
            x + way * math.cos(yaw + half),
            y + way * math.sin(yaw + half),
            yaw + 2 * half,
        )
    )
    row[3:6] = v * math.cos(row[2]), v * math.sin(row[2]), omega
    return row


def make(model, *, seed=0, time_step=0.05, **motion):
    """A diagram of a robot that drives, and of its localization."""
    return moved(
        Localization(model, seed=seed, time_step=time_step),
        robot_state=lambda time: robot_row(time, **motion),
    )


def errors_of(diagram, times, *, context=None):
    """The errors at some times, shape (k, 3), and the simulator."""
    simulator = Simulator(diagram, context or diagram.CreateDefaultContext())
    return outputs(simulator, "localization", times)[:, :3], simulator


def propagate(model, seconds, time_step, count, *, v, omega):
    """The errors of many robots after a drive, shape (count, 3)."""
    rng = np.random.default_rng(5)
    poses = [
        robot_row(k * time_step, v=v, omega=omega)[:3]
        for k in range(round(seconds / time_step) + 1)
    ]
    result = []
    for _ in range(count):
        error = None
        for motion in itertools.pairwise(poses):
            if error is None:
                error = model.next_error(None, motion, time_step, np.ones(3))
            normal = rng.standard_normal(3)
            error = model.next_error(error, motion, time_step, normal)
        result.append(error)
    return np.array(result)


def assert_variance(values, variance):
    low, high = chi2.interval(1 - 1e-5, len(values) - 1)
    ratio = values.var(ddof=1) / variance * (len(values) - 1)
    assert low <= ratio <= high, (values.var(), variance)


@pytest.mark.parametrize(
    ("seconds", "time_step"), [(1.0, 0.02), (1.0, 0.1), (3.0, 0.1)]
)
def test_odometry_drifts_as_the_model_says_whatever_the_step(
    seconds, time_step
):
    """Along the way and in heading, in proportion to the time."""
    model = Odometry(alpha1=0.02, alpha2=0.001, alpha3=0.004, alpha4=0.01)
    ahead = propagate(model, seconds, time_step, 200, v=0.5, omega=0.0)
    # Two turns in each step.
    assert_variance(ahead[:, 2], 2 * 0.001 * 0.5**2 * seconds)
    along = ahead[:, 0] * math.cos(0.5) + ahead[:, 1] * math.sin(0.5)
    turned_back = 0.5 * (0.5 * ahead[:, 2] ** 2).mean() * seconds / 2
    assert abs(along.mean()) < 5 * along.std() / math.sqrt(200) + turned_back
    assert_variance(along, 0.004 * 0.5**2 * seconds)
    spun = propagate(model, seconds, time_step, 200, v=0.0, omega=0.7)
    assert_variance(spun[:, 2], 2 * 0.02 * (0.7 / 2) ** 2 * seconds)
    # Translations between turns in a known direction, all around.
    total = 2 * 0.01 * (0.7 / 2) ** 2 * seconds
    squared = (spun[:, :2] ** 2).sum(axis=1)
    assert squared.mean() == pytest.approx(total, rel=0.35)


def test_odometry_of_one_second_is_that_of_the_table():
    """Of Probabilistic Robotics, 5.6, from known draws."""
    model = Odometry(alpha1=0.1, alpha2=0.2, alpha3=0.3, alpha4=0.4)
    before, now = robot_row(0.0)[:3], robot_row(1.0, omega=0.6)[:3]
    normal = np.array([0.5, -1.0, 2.0])
    found = now + model.next_error(np.zeros(3), (before, now), 1.0, normal)
    turn_1 = math.atan2(*(now - before)[1::-1]) - before[2]
    way = math.dist(now[:2], before[:2])
    turn_2 = now[2] - before[2] - turn_1
    first = turn_1 + 0.5 * math.sqrt(0.1 * turn_1**2 + 0.2 * way**2)
    second = turn_2 - math.sqrt(0.1 * turn_2**2 + 0.2 * way**2)
    way += 2 * math.sqrt(0.3 * way**2 + 0.4 * (turn_1**2 + turn_2**2))
    x, y, yaw = before
    expected = [
        x + way * math.cos(yaw + first),
        y + way * math.sin(yaw + first),
        yaw + first + second,
    ]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_odometry_drives_on_from_its_own_pose():
    """With a wrong heading it goes astray in proportion to the way."""
    model = Odometry(**NO_ERRORS)
    error = np.array([0.1, -0.2, 0.3])
    way = np.array([3.0, 1.0])
    before = np.array([5.0, 6.0, 1.0])
    now = before + np.append(way, 0.4)
    found = model.next_error(error, (before, now), 0.1, np.ones(3))
    c, s = math.cos(0.3), math.sin(0.3)
    off = np.array([[c, -s], [s, c]]) @ way - way
    np.testing.assert_allclose(found, error + np.append(off, 0), atol=1e-12)


def test_a_robot_at_rest_knows_where_it_is_by_odometry():
    found, _ = errors_of(make(Odometry(), v=0.0), [0, 1, 2])
    np.testing.assert_array_equal(found, 0)


@pytest.mark.parametrize("time_step", [0.02, 0.05, 0.1])
def test_the_error_of_a_localizer_stays_as_large_and_as_correlated(time_step):
    model = GaussMarkov(
        position_deviation=0.2, yaw_deviation=0.1, correlation_time=0.5
    )
    times = np.arange(800) * 0.1
    dut = make(model, time_step=time_step, seed=2)
    found, _ = errors_of(dut, times)
    decay = math.exp(-0.1 / 0.5)
    for values, deviation in zip(found.T, (0.2, 0.2, 0.1), strict=True):
        scaled = values / deviation
        # What is new in each sample is independent: exactly chi squared.
        new = (scaled[1:] - decay * scaled[:-1]) / math.sqrt(1 - decay**2)
        assert_variance(new, 1.0)
        assert abs(new.mean()) < 5 / math.sqrt(len(new))
        echo = np.corrcoef(new[1:], new[:-1])[0, 1]
        assert abs(echo) < 5 / math.sqrt(len(new))
    assert abs(np.corrcoef(found.T) - np.eye(3)).max() < 0.25


def test_a_localizer_begins_with_an_error_like_all_others():
    model = GaussMarkov(position_deviation=0.2, yaw_deviation=0.1)
    first = [errors_of(make(model, seed=it), [0.0])[0][0] for it in range(200)]
    x, y, yaw = np.array(first).T
    for values, deviation in ((x, 0.2), (y, 0.2), (yaw, 0.1)):
        assert_variance(values, deviation**2)


@pytest.mark.parametrize(
    "model",
    [
        Odometry(**NO_ERRORS),
        GaussMarkov(position_deviation=0.0, yaw_deviation=0.0),
    ],
)
def test_without_errors_the_pose_is_exact(model):
    """Bit for bit, and so are people."""
    people = rows((1 / 3, 2 / 3), (OUTSIDE, OUTSIDE))
    people[0, 2:6] = [0.1, 1 / 7, -1 / 9, 0.3]

    def robot(time):
        return robot_row(time, omega=0.9, pose=(1 / 3, 1e3 / 7, 0.1))

    dut = Localization(model, num_people=2)
    diagram = moved(dut, robot_state=robot, people=lambda time: people)
    times = np.arange(40) * 0.05
    for name, expected in (
        ("estimated_robot_state", [robot(time) for time in times]),
        ("estimated_people", [people.ravel()] * 40),
    ):
        found = outputs(Simulator(diagram), name, times)
        np.testing.assert_array_equal(found, expected)


def relative(robot, people):
    """Rows of people as the robot sees them: places, velocities, headings."""
    c, s = math.cos(robot[2]), math.sin(robot[2])
    turn = np.array([[c, -s], [s, c]])
    return np.column_stack(
        [
            (people[:, :2] - robot[:2]) @ turn,
            people[:, 3:5] @ turn,
            people[:, 2] - robot[2],
            people[:, 5:],
        ]
    )


def test_people_are_to_the_estimate_as_they_are_to_the_robot():
    dut = Localization(
        GaussMarkov(position_deviation=2.0, yaw_deviation=1.0), num_people=3
    )
    context = dut.CreateDefaultContext()
    robot = robot_row(2.0, omega=0.4)
    people = rows((3, 4), (-1, 0), (OUTSIDE, OUTSIDE))
    people[:2, 2:6] = [0.7, 1.0, -0.5, 0.2]
    dut.GetInputPort("robot_state").FixValue(context, robot)
    dut.GetInputPort("people").FixValue(context, people.ravel())
    estimate = dut.GetOutputPort("estimated_robot_state").Eval(context)
    there = dut.GetOutputPort("estimated_people").Eval(context).reshape(3, 7)
    error = dut.GetOutputPort("localization").Eval(context)[:3]
    assert abs(error).min() > 0.05
    np.testing.assert_allclose(estimate[:3] - robot[:3], error, atol=1e-12)
    np.testing.assert_allclose(
        relative(estimate, there[:2]), relative(robot, people[:2]), atol=1e-12
    )
    # The robot knows its own speeds.
    np.testing.assert_allclose(
        relative(estimate, estimate[None])[:, 2:],
        relative(robot, robot[None])[:, 2:],
        atol=1e-12,
    )
    np.testing.assert_array_equal(there[2], people[2])


@pytest.mark.parametrize("model", [Odometry(), GaussMarkov()])
def test_a_clone_has_the_same_future_and_seeds_differ(model):
    times = np.arange(40) * 0.1
    dut = make(model, omega=0.3)
    expected, _ = errors_of(dut, times)
    _, forked = errors_of(dut, times[:21])
    clone = forked.get_context().Clone()
    rest, _ = errors_of(dut, times[21:], context=clone)
    np.testing.assert_array_equal(rest, expected[21:])
    other, _ = errors_of(make(model, seed=1, omega=0.3), times)
    assert (other[1:] != expected[1:]).all()


def test_the_default_makes_nothing():
    task = SensingTask(world=World(), num_humans=1)
    assert LOCALIZATIONS.make().MakeSystem(task) is None
