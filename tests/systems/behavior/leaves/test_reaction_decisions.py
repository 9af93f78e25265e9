"""Decisions that differ from HuNavSim: a test for each."""

import itertools
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import (
    LoadBehavior,
    LoadTree,
    ParseTree,
    Person,
)
from hunav_drake.systems.behavior.behavior_tree import BehaviorTree
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people import BehaviorConfig, HumanConfig
from hunav_drake.trial.humans import MakeHumans
from tests.systems.behavior.ticks import as_original, at

REACTIONS = ["surprised", "scared", "curious", "threatening"]


class People:
    """People among whom a robot is put."""

    def __init__(self, *humans, time_step=0.05):
        self.time_step = time_step
        self.diagram = MakeHumans(humans, time_step=time_step)
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.steps = 0

    def step(self, robot, count=1):
        """Returns the states of the people after some steps."""
        self.diagram.GetInputPort("robot_states").FixValue(self.context, robot)
        self.steps += count
        # Updates come at the beginning of a step; this is half-way.
        self.simulator.AdvanceTo((self.steps - 0.5) * self.time_step)
        port = self.diagram.GetOutputPort("human_states")
        return port.Eval(self.context).reshape(-1, 7)

    def status(self):
        return self.diagram.GetOutputPort("behavior_status").Eval(self.context)

    def memory(self, index=0):
        tree = self.diagram.GetSubsystemByName(f"behavior_{index}")
        context = tree.GetMyContextFromRoot(self.context)
        return context.get_discrete_state(0).value().copy()


def human(behavior, pose=(0.0, 0.0, 0.0), goals=((20.0, 0.0),), **kwargs):
    return HumanConfig(
        behavior=behavior, pose=pose, goals=list(goals), **kwargs
    )


def command_of(behavior, state, robot, **kwargs):
    who = Person.from_config(human("regular", **kwargs), 0, time_step=0.05)
    tree = LoadBehavior(behavior)
    outcome = tree.tick(
        who, tree.initial_memory(who), np.array(state), np.array(robot)
    )
    return dict(zip(Command, outcome.command, strict=True))


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, 2.0])
def test_threatening_person_settles_in_front_not_beside(yaw):
    # From ahead and to the side.
    pose = (3 * math.cos(yaw + 0.5), 3 * math.sin(yaw + 0.5), yaw + 3.5)
    dut = People(human("threatening", pose=pose))
    (state,) = dut.step(at(0.0, 0.0, yaw), 100)
    front = [1.1 * math.cos(yaw), 1.1 * math.sin(yaw)]
    assert np.hypot(*(state[:2] - front)) < 0.1


@pytest.mark.parametrize("bearing", [-3.0, -1.5, -0.01, 0.01, 1.5, 3.0])
@pytest.mark.parametrize("time_step", [0.05, 0.01])
def test_surprised_person_turns_by_pi_per_second_without_overshoot(
    bearing, time_step
):
    # (All around, so that the robot stays in sight.)
    behavior = BehaviorConfig(
        type="surprised", ports={"field_of_view": 2 * math.pi}
    )
    dut = People(human(behavior), time_step=time_step)
    robot = at(2.0 * math.cos(bearing), 2.0 * math.sin(bearing))
    yaw = 0.0
    for _ in range(round(1.1 / time_step)):
        (state,) = dut.step(robot)
        left = bearing - yaw
        turn = math.copysign(min(abs(left), math.pi * time_step), left)
        assert state[2] == pytest.approx(yaw + turn, abs=1e-9)
        yaw = state[2]
    assert yaw == pytest.approx(bearing, abs=1e-9)


@pytest.mark.parametrize("name", ["surprised", "curious"])
def test_person_comes_to_rest_as_bodies_can(name):
    """At 2.5 m/s^2 at most, where HuNavSim stops people at once."""
    dut = People(human(name))
    (state,) = dut.step(at(90.0, 0.0), 40)
    robot = at(state[0] + 1.3, state[1])
    speed = np.hypot(*state[3:5])
    assert speed > 1
    for _ in range(12):
        (state,) = dut.step(robot)
        slower = np.hypot(*state[3:5])
        assert speed - slower <= 2.5 * 0.05 + 1e-9
        speed = slower
    assert speed == 0
    (later,) = dut.step(robot, 20)
    assert (later[:2] == state[:2]).all()


@pytest.mark.parametrize("name", ["surprised", "curious"])
def test_standing_person_has_no_velocity(name):
    dut = People(human(as_original(name)))
    (walking,) = dut.step(at(90.0, 0.0), 40)
    assert walking[3] > 1
    robot = at(walking[0] + 1.3, walking[1])
    # (It takes a while to brake at 3.5 m/s^2.)
    (standing,) = dut.step(robot, 9)
    assert dut.status() == [1]
    assert (standing[3:5] == 0).all()
    (later,) = dut.step(robot, 20)
    assert (later[:2] == standing[:2]).all()


@pytest.mark.parametrize("name", ["curious", "threatening"])
def test_near_person_turns_at_a_limited_rate(name):
    dut = People(human(name))
    robot = at(0.0, 1.1, -math.pi / 2)
    yaw = 0.0
    for _ in range(9):
        (state,) = dut.step(robot)
        assert abs(state[2] - yaw) <= math.pi * 0.05 + 1e-9
        yaw = state[2]
    assert yaw > 1


def test_curious_person_keeps_to_the_own_maximum():
    command = command_of(
        "curious", at(0, 0), at(9.9, 0), desired_speed=1.0, max_speed=1.1
    )
    assert command[Command.DESIRED_SPEED] == 1.1
    assert command[Command.MAX_SPEED] == 1.1


def test_threatening_person_uses_the_parameter_speed():
    command = command_of(
        as_original("threatening"),
        at(0, 0),
        at(2, 0),
        desired_speed=1.0,
        max_speed=1.1,
    )
    assert command[Command.DESIRED_SPEED] == 2.0
    assert command[Command.MAX_SPEED] == 2.0


def test_threatening_person_may_walk_faster_than_the_own_maximum():
    """As in HuNavSim: it has to overtake the robot."""
    dut = People(human("threatening", desired_speed=0.4, max_speed=0.5))
    speeds = []
    for step in range(80):
        robot = at(3.0 + 0.6 * 0.05 * step, 0.5, 0.0, 0.6)
        (state,) = dut.step(robot)
        speeds.append(np.hypot(*state[3:5]))
    assert 1.5 < max(speeds) <= 2.0 + 1e-9


def test_scared_person_never_walks_faster_than_the_own_maximum():
    """HuNavSim gives everybody 0.6 m/s, the slower too."""
    for behavior, expected in (("scared", 0.4), (as_original("scared"), 0.6)):
        command = command_of(behavior, at(0, 0), at(2, 0), desired_speed=0.4)
        assert command[Command.DESIRED_SPEED] == expected
        assert command[Command.MAX_SPEED] == expected


@pytest.mark.parametrize("name", ["regular", "impassive", *REACTIONS])
def test_tick_that_reaches_a_goal_goes_on_to_the_next(name):
    dut = People(human(name, goals=[(3.0, 0.0), (20.0, 0.0)]))
    speeds = []
    for _ in range(60):
        (state,) = dut.step(at(-90.0, 0.0))
        speeds.append(state[3])
    assert dut.memory()[0] == 1
    assert (np.diff(speeds) >= -1e-12).all()


@pytest.mark.parametrize("name", ["regular", "impassive", *REACTIONS])
def test_person_stands_at_the_only_goal_of_a_cycle(name):
    dut = People(human(name, goals=[(2.0, 0.0)], cyclic=True))
    (state,) = dut.step(at(-90.0, 0.0), 300)
    assert np.hypot(*state[3:5]) < 1e-6
    assert np.hypot(state[0] - 2.0, state[1]) < 0.35


def test_only_the_tree_changes_goals():
    """At a goal, and pushed over it, while the reaction takes no notice."""
    dut = People(human("surprised", goals=[(0.2, 0.0), (20.0, 0.0)]))
    dut.step(at(2.0, 0.0), 100)
    assert dut.status() == [1]
    assert dut.memory()[0] == 0
    # (The robot is in mind for a second.)
    dut.step(at(90.0, 0.0), 22)
    assert dut.memory()[0] == 1


def test_everybody_decides_and_moves_from_one_snapshot():
    """The order of people does not matter, whatever they do."""
    people = [
        human(name, pose=(1.5 * i, 0.7 * i % 2, 0.3), goals=[(9.0, float(i))])
        for i, name in enumerate(["regular", "impassive", *REACTIONS])
    ]
    robot = at(3.0, 2.0, -1.0, 0.3, -0.1)
    plain = People(*people).step(robot, 60)
    for order in ([5, 4, 3, 2, 1, 0], [2, 5, 0, 3, 1, 4]):
        permuted = People(*(people[i] for i in order)).step(robot, 60)
        np.testing.assert_allclose(permuted, plain[order], atol=1e-9)


def test_scared_person_keeps_the_robot_in_mind():
    """Without, the reaction goes on and off every few steps."""
    changes = []
    for behavior in (as_original("scared"), "scared"):
        dut = People(human(behavior, desired_speed=1.5))
        active = []
        for step in range(400):
            dut.step(at(6.0 - 0.025 * step, 0.8, math.pi, -0.5))
            active.append(dut.status()[0])
        changes.append(np.count_nonzero(np.diff(active)))
    assert changes[0] > 20
    assert changes[1] <= 2


def test_time_step_is_exact_in_subtrees():
    dut = ParseTree("""
    <root main_tree_to_execute="A">
    <BehaviorTree ID="A"><Sequence>
      <SetBlackboard output_key="step" value="{dt}"/>
      <SubTree ID="B" dt="step"/>
    </Sequence></BehaviorTree>
    <BehaviorTree ID="B">
      <TimeExpiredCondition seconds="{dt}" ts="{dt}"/>
    </BehaviorTree></root>
    """)
    step = 0.012345678901234567
    who = Person.from_config(human("regular"), 0, time_step=step)
    outcome = dut.tick(
        who, dut.initial_memory(who), np.array(at(0, 0)), np.zeros(0)
    )
    assert step in outcome.memory
    assert outcome.node_status.name == "SUCCESS"


@pytest.mark.parametrize("number", [0, 1, 2, 7])
def test_ids_of_people_and_robots_are_separate(number):
    """Nobody is blind to the robot for being numbered as it is."""
    dut = People(human("surprised", id=number))
    dut.step(at(2.0, 0.0))
    assert dut.status() == [1]


@pytest.mark.parametrize("name", REACTIONS)
def test_new_context_is_a_full_reset(name):
    """Timers, memories and goals, too."""
    people = [human(name, goals=[(0.2, 0.0), (20.0, 0.0)])]
    dut = People(*people)
    first = dut.step(at(2.0, 0.5), 200)
    dut.simulator.reset_context(dut.diagram.CreateDefaultContext())
    dut.context = dut.simulator.get_mutable_context()
    dut.steps = 0
    np.testing.assert_array_equal(dut.step(at(2.0, 0.5), 200), first)


def test_timers_count_simulated_time(monkeypatch):
    """Whatever the clock of the machine says."""
    import time

    ticking = itertools.count(step=1e6)
    for clock in ("time", "monotonic", "perf_counter"):
        monkeypatch.setattr(time, clock, lambda: next(ticking))
    dut = BehaviorTree(
        [LoadTree("curious", {"duration": 1.0})], [human("regular")]
    )
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.get_human_states_input_port().FixValue(context, at(0, 0))
    dut.get_robot_states_input_port().FixValue(context, at(3, 0))
    port = dut.get_behavior_status_output_port()
    active = 0
    for step in range(40):
        simulator.AdvanceTo(0.05 * step + 0.01)
        active += port.Eval(context)[0]
    # The 20th tick of 0.05 s completes the second; what is seen after each
    # step belongs to the tick that follows.
    assert active == 18
