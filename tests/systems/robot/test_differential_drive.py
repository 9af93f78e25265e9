import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.robot import (
    DifferentialDrive,
    DifferentialDriveConfig,
    RobotLimits,
)


@pytest.fixture
def dut():
    return DifferentialDrive(
        DifferentialDriveConfig(start=[1, 2, 0.5], radius=0.3)
    )


def drive_as_commanded(dut, command, times, context=None):
    """Returns the states at some times, which lie between two updates."""
    simulator = Simulator(dut, context or dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    dut.get_velocity_command_input_port().FixValue(context, command)
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(dut.get_robot_state_output_port().Eval(context).copy())
    return np.array(states)


def test_starts_at_rest_at_its_start(dut):
    context = dut.CreateDefaultContext()
    np.testing.assert_array_equal(
        dut.get_robot_state_output_port().Eval(context),
        [1, 2, 0.5, 0, 0, 0, 0.3],
    )


def test_speeds_up_within_its_limits(dut):
    times = 0.05 * np.arange(1, 60) - 0.01
    states = drive_as_commanded(dut, [5.0, 9.0], times)
    speed = np.hypot(states[:, 3], states[:, 4])
    np.testing.assert_allclose(speed, np.minimum(times + 0.01, 1.0))
    np.testing.assert_allclose(
        states[:, 5], np.minimum(2.09 * (times + 0.01), 2.09)
    )


def test_drives_backwards_no_faster_than_allowed(dut):
    state = drive_as_commanded(dut, [-5.0, 0.0], [3.0])[0]
    heading = np.array([math.cos(0.5), math.sin(0.5)])
    assert state[3:5] @ heading == pytest.approx(-0.2)


def test_a_steady_command_drives_an_exact_circle():
    limits = RobotLimits(max_acceleration=100.0, max_turn_acceleration=1000.0)
    dut = DifferentialDrive(
        DifferentialDriveConfig(limits=limits), time_step=0.1
    )
    times = 0.1 * np.arange(1, 80) - 0.01
    states = drive_as_commanded(dut, [0.8, 0.5], times)
    center = np.array([0, 1.6])
    radii = np.hypot(*(states[:, :2] - center).T)
    np.testing.assert_allclose(radii, 1.6, rtol=1e-12)
    np.testing.assert_allclose(
        np.exp(1j * states[:, 2]), np.exp(0.5j * (times + 0.01)), atol=1e-12
    )


def test_the_yaw_stays_between_minus_pi_and_pi(dut):
    states = drive_as_commanded(dut, [0.0, 2.0], np.arange(1, 200) * 0.05)
    assert np.abs(states[:, 2]).max() <= math.pi


def test_two_contexts_do_not_disturb_each_other(dut):
    times = np.arange(1, 40) * 0.05
    alone = drive_as_commanded(dut, [0.5, 0.3], times)
    contexts = [dut.CreateDefaultContext() for _ in range(2)]
    both = []
    for time in times:
        both.append(drive_as_commanded(dut, [0.5, 0.3], [time], contexts[0])[0])
        drive_as_commanded(dut, [-0.5, 1.0], [time], contexts[1])
    np.testing.assert_array_equal(both, alone)


def test_a_clone_has_the_same_future(dut):
    context = dut.CreateDefaultContext()
    drive_as_commanded(dut, [0.5, 0.3], [1.0], context)
    clone = context.Clone()
    np.testing.assert_array_equal(
        drive_as_commanded(dut, [0.2, 0.1], [3.0], context),
        drive_as_commanded(dut, [0.2, 0.1], [3.0], clone),
    )


def test_can_be_put_elsewhere(dut):
    context = dut.CreateDefaultContext()
    dut.SetPose(context, [7, 8, -1])
    state = dut.get_robot_state_output_port().Eval(context)
    np.testing.assert_array_equal(state[:6], [7, 8, -1, 0, 0, 0])


def test_a_command_that_is_no_number_is_an_error_with_its_place(dut):
    dut.set_name("robot")
    with pytest.raises(RuntimeError, match=r"robot, t = 0\.000 s: .*nan"):
        drive_as_commanded(dut, [math.nan, 0.0], [0.1])


@pytest.mark.parametrize("time_step", [0.0, -1.0, math.nan])
def test_a_bad_step_is_refused(time_step):
    with pytest.raises(ValueError, match="time_step must be positive"):
        DifferentialDrive(DifferentialDriveConfig(), time_step=time_step)


def test_a_bad_configuration_is_refused():
    with pytest.raises(ValueError, match=r"must be in \[0.001, 5\] m, got 0"):
        DifferentialDriveConfig(radius=0.0)
    with pytest.raises(ValueError, match=r"must be in \(0, 10\] m/s, got -1"):
        RobotLimits(max_speed=-1.0)
