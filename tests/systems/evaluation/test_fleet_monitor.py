from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.evaluation.fleet_monitor import FleetMonitor
from hunav_drake.systems.evaluation.trial_monitor import TrialStatus

ERROR = 7
RUNNING, GOAL, STUCK, FAILED = map(int, TrialStatus)


def set_statuses(dut, context, statuses, planners):
    dut.get_statuses_input_port().FixValue(context, statuses)
    dut.get_planner_statuses_input_port().FixValue(context, planners)


def status(dut, context):
    return int(dut.get_trial_status_output_port().Eval(context)[0])


@pytest.fixture
def dut():
    return FleetMonitor([True, True, False], planner_error=ERROR)


def test_the_first_end_of_each_robot_counts_and_the_worst_of_all(dut):
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    set_statuses(dut, context, [RUNNING] * 3, [1, 1, 0])
    simulator.AdvanceTo(1)
    assert status(dut, context) == RUNNING
    set_statuses(dut, context, [GOAL, RUNNING, RUNNING], [4, 1, 0])
    simulator.AdvanceTo(2)
    assert status(dut, context) == RUNNING
    # The first robot is pushed away; the second one's planner fails.
    set_statuses(dut, context, [STUCK, RUNNING, RUNNING], [1, ERROR, 0])
    assert status(dut, context) == FAILED
    simulator.AdvanceTo(3)
    ends = dut.get_robot_ends_output_port().Eval(context).reshape(3, 2)
    assert ends.tolist() == [
        [GOAL, pytest.approx(1.0)],
        [FAILED, pytest.approx(2.0)],
        [RUNNING, -1],
    ]


def test_the_trial_is_the_worst_of_goal_and_stuck(dut):
    context = dut.CreateDefaultContext()
    set_statuses(dut, context, [GOAL, STUCK, RUNNING], [4, 1, 0])
    assert status(dut, context) == STUCK
    set_statuses(dut, context, [GOAL, GOAL, RUNNING], [4, 4, 0])
    assert status(dut, context) == GOAL


def test_without_goals_the_trial_goes_on():
    dut = FleetMonitor([False, False], planner_error=ERROR)
    context = dut.CreateDefaultContext()
    set_statuses(dut, context, [RUNNING, RUNNING], [0, 0])
    assert status(dut, context) == RUNNING


def test_contexts_do_not_disturb_each_other_and_clones_go_on(dut):
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    other = dut.CreateDefaultContext()
    set_statuses(dut, other, [RUNNING] * 3, [1, 1, 0])
    set_statuses(dut, context, [GOAL, RUNNING, RUNNING], [4, 1, 0])
    simulator.AdvanceTo(0.2)
    clone = context.Clone()
    for it in (context, clone):
        set_statuses(dut, it, [RUNNING, GOAL, RUNNING], [1, 4, 0])
        Simulator(dut, it).AdvanceTo(0.4) if it is clone else None
    simulator.AdvanceTo(0.4)
    ends = dut.get_robot_ends_output_port()
    assert (ends.Eval(context) == ends.Eval(clone)).all()
    assert (ends.Eval(other)[::2] == RUNNING).all()
