"""Nodes of one's own: Python functions that XML files use by name."""

from typing import Annotated, Literal

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import (
    BehaviorTree,
    BehaviorTreeError,
    LoadTree,
    ParseTree,
    Person,
    Status,
    WriteTree,
    register_action,
    register_condition,
    registry,
)
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.layout import YAW, Command, X
from hunav_drake.systems.schema import within

HUMAN = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(5.0, 0.0)], id=7)
PERSON = Person.from_config(HUMAN, index=0, time_step=0.1)
ME = np.array([0, 0, 0, 0, 0, 0, 0.35])
ROBOT = np.array([2.0, 0, 0, 0, 0, 0, 0.35])

# A person who waves for a while whenever the robot has come close for the
# n-th time. The nodes in it are registered below.
WAVING = """<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="Waving">
  <BehaviorTree ID="Waving">
    <Fallback>
      <Sequence>
        <IsRobotCloser distance="{range}" times="2"/>
        <SetBlackboard output_key="range" value="2.5"/>
        <SetBlackboard output_key="hand" value="left"/>
        <Wave seconds="0.3" hand="{hand}"/>
      </Sequence>
      <RegularNav/>
    </Fallback>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Waving">
      <input_port name="range" type="double" default="1.5"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""


@pytest.fixture(autouse=True)
def leaves(monkeypatch):
    """Lets a test register leaves that are gone after it."""
    monkeypatch.setattr(registry, "_TYPES", dict(registry._TYPES))
    for module in ("parser", "writer"):
        monkeypatch.setattr(
            f"hunav_drake.systems.behavior.{module}.NODE_TYPES",
            registry._TYPES,
        )


@pytest.fixture
def waving(tmp_path):
    """Returns the tree, from a file, with its two nodes."""

    @register_condition(
        "IsRobotCloser", memory={"was close": 0.0, "times": 0.0}
    )
    def is_robot_closer(
        moment,
        own,
        *,
        distance: Annotated[float, within(0, 100, "m")],
        times: int = 1,
    ) -> bool:
        """Holds from the n-th time on that a robot has come close."""
        close = any(robot[X] < distance for robot in moment.robots)
        if close and not own[0]:
            own[1] += 1
        own[0] = close
        return close and own[1] >= times

    @register_action("Wave", memory={"ticks": 0.0})
    def wave(
        moment,
        own,
        *,
        seconds: float,
        hand: Literal["left", "right"] = "right",
        often: bool = False,
    ) -> Status:
        """Stands, and turns to one side."""
        own[0] += 1
        moment.behavior_status = 1
        moment.command[Command.HOLD] = 1.0
        side = 1.0 if hand == "left" else -1.0
        moment.command[Command.YAW_TARGET] = moment.state[YAW] + side
        if own[0] * moment.person.time_step < seconds:
            return Status.RUNNING
        own[0] = 0.0
        return Status.SUCCESS

    path = tmp_path / "waving.xml"
    path.write_text(WAVING)
    return LoadTree(path)


def parse(body):
    return ParseTree(f"<root><BehaviorTree>{body}</BehaviorTree></root>")


def tick(tree, memory=None, robot=ROBOT):
    memory = tree.initial_memory(PERSON) if memory is None else memory
    return tree.tick(PERSON, memory, ME, robot)


def play(tree, distances):
    """Returns what is commanded as the robot is at some distances."""
    memory, result = None, []
    for distance in distances:
        robot = ROBOT.copy()
        robot[X] = distance
        outcome = tick(tree, memory, robot)
        memory = outcome.memory
        held = outcome.command[Command.HOLD]
        result.append((outcome.behavior_status, held))
    return result


def test_nodes_of_a_file_work_together(waving):
    walks, waves = (0, 0.0), (1, 1.0)
    # Near, far, near again: that is the second time. Waving takes 3 ticks.
    assert play(waving, [1, 1, 4, 1, 4, 4, 4]) == [
        *[walks] * 3,
        *[waves] * 3,
        walks,
    ]


def test_each_node_has_its_own_slots(waving):
    assert [s for s in waving.slots if "IsRobotCloser" in s] == [
        "IsRobotCloser: was close",
        "IsRobotCloser: times",
    ]
    assert [s for s in waving.slots if "Wave" in s] == [
        "Wave: (running)",
        "Wave: ticks",
    ]


def test_ports_follow_the_blackboard(waving):
    """After the first wave the person looks farther: {range} is 2.5."""
    assert play(waving, [1, 4, 1, 2, 2, 2])[3:] == [(1, 1.0)] * 3


def test_description_and_xml_show_the_ports(waving):
    text = waving.Describe()
    assert "IsRobotCloser distance={range} times=2" in text
    assert "Wave seconds=0.3 hand={hand} often=False" in text
    xml = WriteTree(waving)
    assert '<Action ID="Wave">' in xml
    assert '<input_port name="often" type="bool" default="false"/>' in xml
    assert WriteTree(ParseTree(xml)) == xml


@pytest.mark.parametrize(
    ("node", "words"),
    [
        ('<Wave seconds="soon"/>', "port seconds: should be a valid number"),
        ('<Wave seconds="1" hand="third"/>', "'left' or 'right'"),
        ('<Wave seconds="1" often="2"/>', "valid boolean"),
        ("<Wave/>", "port seconds must be given"),
        ('<Wave seconds="1" hands="left"/>', "did you mean 'hand'"),
        ('<IsRobotCloser distance="-1"/>', r"\[0, 100\] m, got -1"),
        ('<IsRobotCloser distance="1" times="1.5"/>', "valid integer"),
        ("<Wav/>", "did you mean 'Wave'"),
    ],
)
@pytest.mark.usefixtures("waving")
def test_ports_are_typed(node, words):
    with pytest.raises(BehaviorTreeError, match=words):
        parse(node)


def test_memory_of_a_node_lives_in_the_context(waving):
    """A clone in the middle of a wave continues as the run goes through."""
    dut = BehaviorTree(waving, HUMAN, 0, 1, time_step=0.125)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.get_human_states_input_port().FixValue(context, ME)

    def play(simulator, distances):
        context = simulator.get_mutable_context()
        result = []
        for distance in distances:
            robot = ROBOT.copy()
            robot[X] = distance
            dut.get_robot_state_input_port().FixValue(context, robot)
            result.append(dut.get_command_output_port().Eval(context).copy())
            simulator.AdvanceTo(context.get_time() + 0.125)
        return result

    play(simulator, [1, 4, 1])
    clone = context.Clone()
    rest = play(simulator, [4, 4, 1])
    again = Simulator(dut, clone)
    again.Initialize()
    np.testing.assert_array_equal(play(again, [4, 4, 1]), rest)
    assert rest[0][Command.HOLD] == 1.0


def test_own_condition_has_ports_and_memory():
    @register_condition("IsNthTick", memory={"running": 1.0})
    def is_nth_tick(moment, own, *, n: int, odd: bool = False) -> bool:
        own[0] += 1
        return own[0] - 1 == n

    dut = parse('<IsNthTick n="3"/>')
    memory, results = None, []
    for _ in range(4):
        outcome = tick(dut, memory)
        memory = outcome.memory
        results.append(outcome.status)
    assert [status is Status.SUCCESS for status in results] == [
        False,
        False,
        True,
        False,
    ]


def test_own_action_commands_and_reports():
    @register_action("Stop")
    def stop(moment):
        moment.command[Command.HOLD] = 1.0
        moment.behavior_status = 1
        return Status.RUNNING

    outcome = tick(parse("<Stop/>"))
    assert outcome.status is Status.RUNNING
    assert outcome.command[Command.HOLD] == 1.0
    assert outcome.behavior_status == 1


def test_halted_action_begins_anew():
    @register_action("Count", memory={"ticks": 5.0})
    def count(moment, own):
        own[0] += 1
        return Status.RUNNING

    dut = parse(
        "<ReactiveSequence><Inverter>"
        '<TimeExpiredCondition seconds="0.3"/></Inverter>'
        "<Count/></ReactiveSequence>"
    )
    slot = dut.slots.index("Count: ticks")
    memory, counts = None, []
    for _ in range(4):
        memory = tick(dut, memory).memory
        counts.append(memory[slot])
    assert counts == [6, 7, 5, 6]


@pytest.mark.parametrize("result", [True, 2, "SUCCESS", Status.SKIPPED])
def test_action_must_return_a_status(result):
    @register_action("Odd")
    def odd(moment):
        return result

    with pytest.raises(TypeError, match="action Odd must return"):
        tick(parse("<Odd/>"))


def test_same_function_can_be_registered_again():
    """A notebook's cell runs more than once."""

    def make(result):
        @register_condition("Maybe")
        def maybe(moment):
            return result

    make(True)
    make(False)
    assert tick(parse("<Maybe/>")).status is Status.FAILURE
