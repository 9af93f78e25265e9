from typing import ClassVar

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.planning import (
    PLANNERS,
    LocalPlanner,
    Plan,
    PlannerStatus,
    PlanningTask,
    PursuitPlanner,
    make_planner,
    register_planner,
)
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles


@dataclass
class Counter:
    """Commands how often it was asked."""

    memory_size: ClassVar[int] = 1

    def plan(self, task, robot, humans, goal, memory):
        count = memory[0] + 1
        return Plan(count, -count, PlannerStatus.DRIVING, (count,))


def make_task(period=0.05):
    return PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.3,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=Obstacles.from_shapes([], solid=[]),
        period=period,
    )


def make_simulator(dut, *, goal=(5, 0, 0)):
    context = dut.CreateDefaultContext()
    dut.get_robot_state_input_port().FixValue(context, [0, 0, 0, 0, 0, 0, 0.3])
    size = dut.get_human_states_input_port().size()
    dut.get_human_states_input_port().FixValue(context, np.zeros(size))
    if goal is not None:
        dut.get_goal_input_port().FixValue(context, goal)
    return Simulator(dut, context)


def command_of(dut, context):
    return dut.get_velocity_command_output_port().Eval(context).tolist()


def test_holds_zeros_until_the_first_command():
    dut = LocalPlanner(PursuitPlanner(), make_task(), num_humans=0)
    simulator = make_simulator(dut)
    context = simulator.get_context()
    assert command_of(dut, context) == [0, 0]
    simulator.AdvanceTo(0.01)
    assert command_of(dut, context) == [0.6, 0]
    assert dut.get_status_output_port().Eval(context) == PlannerStatus.DRIVING


def test_rests_without_a_goal():
    dut = LocalPlanner(PursuitPlanner(), make_task(), num_humans=1)
    simulator = make_simulator(dut, goal=None)
    simulator.AdvanceTo(1.0)
    context = simulator.get_context()
    assert command_of(dut, context) == [0, 0]
    assert dut.get_status_output_port().Eval(context) == PlannerStatus.IDLE


@pytest.mark.parametrize(
    ("time_step", "period"), [(0.05, 0.05), (0.01, 0.05), (0.05, 1.0)]
)
def test_decides_once_a_period(time_step, period):
    dut = LocalPlanner(
        Counter(), make_task(period), num_humans=0, time_step=time_step
    )
    simulator = make_simulator(dut)
    for k in range(1, 60):
        simulator.AdvanceTo(k * period - 0.5 * time_step)
        assert command_of(dut, simulator.get_context()) == [k, -k]


def test_remembers_in_the_context():
    """Two contexts do not disturb each other; a clone goes on alike."""
    dut = LocalPlanner(Counter(), make_task(), num_humans=0)
    first, second = make_simulator(dut), make_simulator(dut)
    first.AdvanceTo(0.49)
    second.AdvanceTo(0.09)
    assert command_of(dut, first.get_context()) == [10, -10]
    assert command_of(dut, second.get_context()) == [2, -2]
    clone = Simulator(dut, first.get_context().Clone())
    clone.AdvanceTo(0.99)
    first.AdvanceTo(0.99)
    assert command_of(dut, clone.get_context()) == [20, -20]
    assert command_of(dut, first.get_context()) == [20, -20]


def test_only_the_state_enters_the_command():
    dut = LocalPlanner(PursuitPlanner(), make_task(), num_humans=1)
    assert not dut.HasAnyDirectFeedthrough()


def test_a_period_between_two_steps_is_refused():
    with pytest.raises(ValueError, match="multiple of time_step"):
        LocalPlanner(Counter(), make_task(0.12), num_humans=0)


def test_planners_are_known_by_name():
    planner = make_planner("pursuit", {"cruise_speed": 0.4})
    assert planner == PursuitPlanner(cruise_speed=0.4)
    with pytest.raises(ValueError, match="did you mean 'pursuit'"):
        make_planner("persuit", {})
    with pytest.raises(ValueError, match="cruise"):
        make_planner("pursuit", {"cruise": 0.4})


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match="'pursuit' is registered already"):
        register_planner("pursuit")(Counter)
    assert PLANNERS["pursuit"] is PursuitPlanner


@pytest.mark.parametrize(
    ("v", "memory", "words"),
    [
        (float("nan"), (), "got Plan.v=nan"),
        (float("inf"), (), "got Plan.v=inf"),
        (0.5, (1.0, 2.0), "a memory of 0 numbers, got .*memory=.1.0, 2.0"),
    ],
)
def test_a_plan_that_cannot_be_is_told(v, memory, words):
    class Wild:
        memory_size = 0

        def plan(self, task, robot, humans, goal, memory_before):
            return Plan(v, 0.0, PlannerStatus.DRIVING, memory)

    dut = LocalPlanner(Wild(), make_task(), num_humans=0)
    simulator = make_simulator(dut)
    with pytest.raises(RuntimeError, match=rf"t = 0.000 s: Wild.*{words}"):
        simulator.AdvanceTo(0.1)


def test_what_is_no_plan_is_told():
    class Sloppy:
        memory_size = 0

        def plan(self, task, robot, humans, goal, memory):
            return 0.5, 0.0

    dut = LocalPlanner(Sloppy(), make_task(), num_humans=0)
    simulator = make_simulator(dut)
    with pytest.raises(RuntimeError, match=r"must give a Plan, got \(0.5, 0"):
        simulator.AdvanceTo(0.1)
