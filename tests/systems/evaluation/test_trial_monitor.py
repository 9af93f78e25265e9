import math

from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.evaluation.trial_monitor import (
    TrialMonitor,
    TrialStatus,
)


@pytest.fixture
def dut():
    return TrialMonitor(
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.3,
        stuck_time=2.0,
        stuck_distance=0.5,
    )


def status_at(dut, context, x, y=0.0, yaw=0.0):
    dut.get_robot_state_input_port().FixValue(
        context, [x, y, yaw, 0, 0, 0, 0.3]
    )
    return int(dut.get_trial_status_output_port().Eval(context)[0])


@pytest.mark.parametrize(
    ("pose", "status"),
    [
        ((5.2, 0, 0), TrialStatus.GOAL),
        ((5.3, 0, 0), TrialStatus.RUNNING),
        ((5, 0, 2 * math.pi - 0.2), TrialStatus.GOAL),
        ((5, 0, 0.4), TrialStatus.RUNNING),
    ],
)
def test_the_goal_is_reached_within_both_tolerances(dut, pose, status):
    context = dut.CreateDefaultContext()
    dut.get_goal_input_port().FixValue(context, [5, 0, 0])
    assert status_at(dut, context, *pose) == status


def test_without_a_goal_the_trial_goes_on(dut):
    context = dut.CreateDefaultContext()
    simulator = Simulator(dut, context)
    assert status_at(dut, context, 1) == TrialStatus.RUNNING
    simulator.AdvanceTo(9)
    assert status_at(dut, context, 1) == TrialStatus.RUNNING


def test_the_time_without_a_goal_or_at_it_does_not_count(dut):
    context = dut.CreateDefaultContext()
    simulator = Simulator(dut, context)
    end = 0.0
    for goal in ([math.nan] * 3, [1, 0, 0], [50, 0, 0]):
        dut.get_goal_input_port().FixValue(context, goal)
        status_at(dut, context, 1)
        end += 1.9 if goal[0] == 50 else 3
        simulator.AdvanceTo(end)
        assert status_at(dut, context, 1) == (
            TrialStatus.GOAL if goal[0] == 1 else TrialStatus.RUNNING
        )
    simulator.AdvanceTo(end + 0.2)
    assert status_at(dut, context, 1) == TrialStatus.STUCK


def test_a_robot_that_stays_is_stuck_and_one_that_moves_is_not(dut):
    context = dut.CreateDefaultContext()
    dut.get_goal_input_port().FixValue(context, [50, 0, 0])
    simulator = Simulator(dut, context)
    for k in range(40):
        assert status_at(dut, context, 0.3 * k) == TrialStatus.RUNNING
        simulator.AdvanceTo(0.3 * (k + 1))
    # Turning about in one place is not moving.
    start = context.get_time()
    for k in range(30):
        x = 20 + 0.2 * math.cos(k)
        status = status_at(dut, context, x)
        simulator.AdvanceTo(start + 0.1 * (k + 1))
        assert (status == TrialStatus.STUCK) == (k >= 20)


def test_two_contexts_do_not_disturb_each_other(dut):
    contexts = [dut.CreateDefaultContext() for _ in range(2)]
    for i, context in enumerate(contexts):
        dut.get_goal_input_port().FixValue(context, [50, 0, 0])
        status_at(dut, context, 0.0)
        Simulator(dut, context).AdvanceTo(1.0 + 2 * i)
    assert status_at(dut, contexts[0], 0.0) == TrialStatus.RUNNING
    assert status_at(dut, contexts[1], 0.0) == TrialStatus.STUCK
    clone = contexts[0].Clone()
    Simulator(dut, clone).AdvanceTo(3.0)
    assert status_at(dut, clone, 0.0) == TrialStatus.STUCK
