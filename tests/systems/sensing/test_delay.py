"""Signals that come later, by whole time steps."""

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.sensing import Delay, LidarConfig, SensingTask
from hunav_drake.systems.sensing.delay import MakeDelayed
from hunav_drake.systems.sensing.sensor_config import (
    PeopleDetectorConfig,
    VisiblePeopleConfig,
)
from hunav_drake.systems.world.shapes import World
from tests.systems.sensing.scans import moved, outputs, rows


def late_clock(steps, time_step):
    dut = Delay(2, steps * time_step, time_step=time_step)
    return moved(dut, u=lambda time: [1, time**2])


@pytest.mark.parametrize("steps", [1, 2, 7])
@pytest.mark.parametrize("time_step", [0.02, 0.05, 0.1])
def test_a_signal_is_that_of_some_steps_ago(steps, time_step):
    """And that of the start before the first one arrives."""
    times = np.arange(20) * time_step
    simulator = Simulator(late_clock(steps, time_step))
    found = outputs(simulator, "delayed_u", times)
    then = np.maximum(np.arange(20) - steps, 0) * time_step
    np.testing.assert_allclose(found[:, 1], then**2, atol=1e-12)
    np.testing.assert_array_equal(found[:, 0], 1)


def test_a_clone_of_a_delay_has_the_same_future():
    diagram = late_clock(3, 0.1)
    times = np.arange(20) * 0.1
    expected = outputs(Simulator(diagram), "delayed_u", times)
    first = Simulator(diagram)
    outputs(first, "delayed_u", times[:6])
    fork = Simulator(diagram, first.get_context().Clone())
    outputs(first, "delayed_u", times[6:9])
    found = outputs(fork, "delayed_u", times[6:])
    np.testing.assert_array_equal(found, expected[6:])


@pytest.mark.parametrize("delay", [0.07, -0.1, 0.0])
def test_a_delay_that_is_no_whole_number_of_steps_is_refused(delay):
    with pytest.raises(ValueError, match=r"must be (a multiple|positive)"):
        Delay(1, delay, time_step=0.05)


@pytest.mark.parametrize(
    ("config", "names"),
    [
        (LidarConfig, ["scan"]),
        (VisiblePeopleConfig, ["visible", "visible_people"]),
        (PeopleDetectorConfig, ["visible", "visible_people"]),
    ],
)
def test_a_sensor_comes_later_with_the_same_ports(config, names):
    task = SensingTask(world=World(), num_humans=1, time_step=0.05)
    options = {} if config is VisiblePeopleConfig else {"period": 0.05}
    exact, late = (
        moved(
            config(delay=it, **options).MakeSystem(task),
            robot_state=lambda time: rows((0, 0)),
            human_states=lambda time: rows((3 + time, 2 * time)),
        )
        for it in (0.0, 0.1)
    )
    times = np.arange(8) * 0.05
    for name in names:
        now = outputs(Simulator(exact), name, times)
        then = outputs(Simulator(late), name, times)
        assert name == "visible" or np.ptp(now, axis=0).any()
        np.testing.assert_array_equal(then[2:], now[:-2])
        np.testing.assert_array_equal(then[:2], [now[0], now[0]])


def test_without_a_delay_nothing_is_added():
    system = Delay(1, 0.1, time_step=0.1)
    assert MakeDelayed(system, 0.0, 0.05) is system
