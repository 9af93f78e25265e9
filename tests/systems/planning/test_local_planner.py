from typing import ClassVar, NamedTuple

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.planning import (
    PLANNERS,
    LocalPlanner,
    Plan,
    Planner,
    PlannerError,
    PlannerStatus,
    PlanningTask,
    PursuitPlanner,
    register_planner,
)
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles


class Count(NamedTuple):
    """What a Counter remembers."""

    cycles: int = 0
    last_goal: str = ""


@dataclass
class CountingPlanner(Planner):
    """Commands how often it was asked, and follows as many points."""

    initial_memory: ClassVar[Count] = Count()

    def plan(self, task, view, memory):
        count = memory.cycles + 1
        return Plan(
            count,
            -count,
            PlannerStatus.DRIVING,
            memory=Count(count, str(view.goal)),
            path=np.full((count, 2), 0.5),
        )


def make_task(*, num_humans=0, time_step=0.05):
    return PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.3,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=Obstacles.from_shapes([], solid=[]),
        num_humans=num_humans,
        time_step=time_step,
    )


def make_planner_simulator(dut, *, goal=(5, 0, 0)):
    context = dut.CreateDefaultContext()
    dut.get_robot_state_input_port().FixValue(context, [0, 0, 0, 0, 0, 0, 0.3])
    size = dut.get_human_states_input_port().size()
    dut.get_human_states_input_port().FixValue(context, np.zeros(size))
    if goal is not None:
        dut.get_goal_input_port().FixValue(context, goal)
    return Simulator(dut, context)


def velocity_command(dut, context):
    return dut.get_velocity_command_output_port().Eval(context).tolist()


def test_holds_zeros_until_the_first_command():
    dut = LocalPlanner(PursuitPlanner(), make_task())
    simulator = make_planner_simulator(dut)
    context = simulator.get_context()
    assert velocity_command(dut, context) == [0, 0]
    simulator.AdvanceTo(0.01)
    assert velocity_command(dut, context) == [0.6, 0]
    assert dut.get_status_output_port().Eval(context) == PlannerStatus.DRIVING


@pytest.mark.parametrize("goal", [None, [np.nan] * 3, [np.inf, 0, 0]])
def test_rests_without_a_goal(goal):
    dut = LocalPlanner(PursuitPlanner(), make_task(num_humans=1))
    simulator = make_planner_simulator(dut, goal=goal)
    simulator.AdvanceTo(1.0)
    context = simulator.get_context()
    assert velocity_command(dut, context) == [0, 0]
    assert dut.get_status_output_port().Eval(context) == PlannerStatus.IDLE


@pytest.mark.parametrize(
    ("time_step", "period"), [(0.05, 0.05), (0.01, 0.05), (0.05, 1.0)]
)
def test_decides_once_a_period(time_step, period):
    dut = LocalPlanner(
        CountingPlanner(period=period), make_task(time_step=time_step)
    )
    simulator = make_planner_simulator(dut)
    for k in range(1, 60):
        simulator.AdvanceTo(k * period - 0.5 * time_step)
        assert velocity_command(dut, simulator.get_context()) == [k, -k]


def test_remembers_in_the_context():
    """Two contexts do not disturb each other; a clone goes on alike."""
    dut = LocalPlanner(CountingPlanner(), make_task())
    first, second = make_planner_simulator(dut), make_planner_simulator(dut)
    first.AdvanceTo(0.49)
    second.AdvanceTo(0.09)
    assert velocity_command(dut, first.get_context()) == [10, -10]
    assert velocity_command(dut, second.get_context()) == [2, -2]
    clone = Simulator(dut, first.get_context().Clone())
    clone.AdvanceTo(0.99)
    first.AdvanceTo(0.99)
    assert velocity_command(dut, clone.get_context()) == [20, -20]
    assert velocity_command(dut, first.get_context()) == [20, -20]


def test_only_the_state_enters_the_command():
    dut = LocalPlanner(PursuitPlanner(), make_task(num_humans=1))
    assert not dut.HasAnyDirectFeedthrough()


def test_a_period_between_two_steps_is_refused():
    with pytest.raises(ValueError, match="multiple of time_step"):
        LocalPlanner(CountingPlanner(period=0.12), make_task())


def test_planners_are_known_by_name():
    planner = PLANNERS.make({"type": "pursuit", "cruise_speed": 0.4})
    assert planner == PursuitPlanner(cruise_speed=0.4)
    with pytest.raises(ValueError, match="did you mean 'pursuit'"):
        PLANNERS.make("persuit")
    with pytest.raises(ValueError, match="cruise"):
        PLANNERS.make({"type": "pursuit", "cruise": 0.4})


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match="'pursuit' is registered already"):
        register_planner("pursuit")(CountingPlanner)
    assert PLANNERS["pursuit"] is PursuitPlanner


def path_of(dut, context):
    return dut.get_path_output_port().Eval(context)


def test_the_path_is_what_was_decided_last():
    dut = LocalPlanner(CountingPlanner(), make_task())
    simulator = make_planner_simulator(dut)
    context = simulator.get_context()
    assert path_of(dut, context).shape == (0, 3)
    simulator.AdvanceTo(0.09)
    path = path_of(dut, context)
    np.testing.assert_array_equal(path, np.full((2, 2), 0.5))
    assert not path.flags.writeable
    clone = context.Clone()
    simulator.AdvanceTo(0.19)
    assert len(path_of(dut, context)) == 4
    assert len(path_of(dut, clone)) == 2


def plan_that_gives(plan, memory=()):
    class Wild(Planner):
        initial_memory = memory

        def plan(self, task, view, memory):
            return plan

    return Wild()


DRIVING = PlannerStatus.DRIVING


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        (Plan(float("nan"), 0.0, DRIVING), "finite v .*got v = nan"),
        (Plan(float("inf"), 0.0, DRIVING), "finite v .*got v = inf"),
        (Plan(0.5, 0.0, DRIVING, memory=[1]), r"immutable value.*got \[1\]"),
        (Plan(0.5, 0.0, DRIVING, memory={}), r"immutable value.*got {}"),
        (
            Plan(0.5, 0.0, DRIVING, memory=np.zeros(2)),
            "immutable value.*read-only array; got array",
        ),
        (Plan(0.5, 0.0, DRIVING, path=np.zeros(3)), "a path .*of shape"),
        (Plan(0.5, 0.0, DRIVING, path=[[0, 0]]), "a path that is an array"),
        (Plan(0.5, 0.0, DRIVING, path=np.full((1, 2), np.nan)), "finite"),
        (Plan("fast", 0.0, DRIVING), "finite v .*got v = 'fast'"),
        (Plan(None, 0.0, DRIVING), "finite v .*got v = None"),
        (Plan(0.5, 0.0, 77), "must give a PlannerStatus, got 77"),
        (Plan(0.5, 0.0, None), "must give a PlannerStatus, got None"),
        (None, "must give a Plan, got None"),
        ((0.5, 0.0), r"must give a Plan, got \(0.5, 0"),
    ],
)
def test_a_plan_that_cannot_be_is_told(plan, words):
    dut = LocalPlanner(plan_that_gives(plan), make_task())
    simulator = make_planner_simulator(dut)
    with pytest.raises(PlannerError, match=rf"t = 0.000 s: Wild.*{words}"):
        simulator.AdvanceTo(0.1)


@pytest.mark.parametrize("more", [{"memory": 1}, {"path": np.zeros((1, 2))}])
def test_nothing_is_lost_of_who_declares_no_memory(more):
    plan = Plan(0.5, 0.0, DRIVING, **more)
    dut = LocalPlanner(plan_that_gives(plan, None), make_task())
    simulator = make_planner_simulator(dut)
    with pytest.raises(PlannerError, match=r"Wild.* without an initial_memory"):
        simulator.AdvanceTo(0.1)


def test_only_who_asks_for_a_scan_has_its_port():
    seen = []

    class Looking(Planner):
        scan_size = 3

        def plan(self, task, view, memory):
            seen.append(view.scan.tolist())
            return Plan(0.0, 0.0, DRIVING)

    dut = LocalPlanner(Looking(), make_task())
    simulator = make_planner_simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("scan").FixValue(context, [1.0, 2.0, 3.0])
    simulator.AdvanceTo(0.01)
    assert seen == [[1.0, 2.0, 3.0]]
    other = LocalPlanner(PursuitPlanner(), make_task())
    assert not other.HasInputPort("scan")


def test_a_planner_cannot_write_to_what_it_sees():
    class Writing(Planner):
        def plan(self, task, view, memory):
            view.robot[:] = 0.0

    simulator = make_planner_simulator(LocalPlanner(Writing(), make_task()))
    with pytest.raises(PlannerError, match=r"ValueError: .*read-only"):
        simulator.AdvanceTo(0.1)
