"""Users' nodes: Python functions that XML files use by name."""

from functools import partial
from typing import Annotated, Literal

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import (
    BehaviorTree,
    BehaviorTreeError,
    LoadTree,
    NodeStatus,
    ParseTree,
    WriteTree,
    register_action,
    register_condition,
)
from hunav_drake.systems.common.layout import YAW, Command, RobotRole, X
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.human_config import HumanConfig
from tests.systems.behavior.ticks import ME, ROBOT, tick_near, tree_of

HUMAN = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(5.0, 0.0)], id=7)

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
def leaves(node_types):
    """Lets each test register leaves that are gone after it."""


@pytest.fixture
def waving(tmp_path):
    """Returns the tree, from a file, with its two nodes."""

    @register_condition(
        "IsRobotCloser", memory={"was close": 0.0, "times": 0.0}
    )
    def is_robot_closer(
        context,
        own,
        *,
        distance: Annotated[float, within(0, 100, "m")],
        times: int = 1,
    ) -> bool:
        """Holds from the n-th time on that a robot has come close."""
        close = any(robot[X] < distance for robot in context.robots)
        if close and not own[0]:
            own[1] += 1
        own[0] = close
        return close and own[1] >= times

    @register_action("Wave", memory={"ticks": 0.0})
    def wave(
        context,
        own,
        *,
        seconds: float,
        hand: Literal["left", "right"] = "right",
        often: bool = False,
    ) -> NodeStatus:
        """Stands, and turns to one side."""
        own[0] += 1
        context.behavior_status = 1
        context.command[Command.HOLD] = 1.0
        side = 1.0 if hand == "left" else -1.0
        context.command[Command.YAW_TARGET] = context.state[YAW] + side
        if own[0] * context.person.time_step < seconds:
            return NodeStatus.RUNNING
        own[0] = 0.0
        return NodeStatus.SUCCESS

    path = tmp_path / "waving.xml"
    path.write_text(WAVING)
    return LoadTree(path)


def play(tree, distances):
    """Returns what is commanded as the robot is at some distances."""
    memory, result = None, []
    for distance in distances:
        robot = ROBOT.copy()
        robot[X] = distance
        outcome = tick_near(tree, memory, robot)
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
        tree_of(node)


def test_memory_of_a_node_lives_in_the_context(waving):
    """A clone in the middle of a wave continues as the run goes through."""
    dut = BehaviorTree([waving], [HUMAN], time_step=0.125)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.get_human_states_input_port().FixValue(context, ME)

    def play(simulator, distances):
        context = simulator.get_mutable_context()
        result = []
        for distance in distances:
            robot = ROBOT.copy()
            robot[X] = distance
            dut.get_robot_states_input_port().FixValue(context, robot)
            result.append(dut.get_commands_output_port().Eval(context).copy())
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
    def is_nth_tick(context, own, *, n: int, odd: bool = False) -> bool:
        own[0] += 1
        return own[0] - 1 == n

    dut = tree_of('<IsNthTick n="3"/>')
    memory, results = None, []
    for _ in range(4):
        outcome = tick_near(dut, memory)
        memory = outcome.memory
        results.append(outcome.node_status)
    assert [status is NodeStatus.SUCCESS for status in results] == [
        False,
        False,
        True,
        False,
    ]


def test_own_action_commands_and_reports():
    @register_action("Stop")
    def stop(context):
        context.command[Command.HOLD] = 1.0
        context.behavior_status = 1
        return NodeStatus.RUNNING

    outcome = tick_near(tree_of("<Stop/>"))
    assert outcome.node_status is NodeStatus.RUNNING
    assert outcome.command[Command.HOLD] == 1.0
    assert outcome.behavior_status == 1


def test_halted_action_begins_anew():
    @register_action("Count", memory={"ticks": 5.0})
    def count(context, own):
        own[0] += 1
        return NodeStatus.RUNNING

    dut = tree_of(
        "<ReactiveSequence><Inverter>"
        '<TimeExpiredCondition seconds="0.3"/></Inverter>'
        "<Count/></ReactiveSequence>"
    )
    slot = dut.slots.index("Count: ticks")
    memory, counts = None, []
    for _ in range(4):
        memory = tick_near(dut, memory).memory
        counts.append(memory[slot])
    assert counts == [6, 7, 5, 6]


@pytest.mark.parametrize("result", [True, 2, "SUCCESS", NodeStatus.SKIPPED])
def test_action_must_return_a_status(result):
    @register_action("Odd")
    def odd(context):
        return result

    with pytest.raises(TypeError, match="action Odd must return"):
        tick_near(tree_of("<Odd/>"))


CELL = """
@register_condition("Maybe")
def {name}(context):
    return {result}
"""


def run_cell(name, result, module="__main__", file="<string>"):
    """Runs a cell of a notebook, or a module anew."""
    scope = {"register_condition": register_condition, "__name__": module}
    code = compile(CELL.format(name=name, result=result), file, "exec")
    exec(code, scope)


@pytest.mark.parametrize("module", ["__main__", "my_leaves"])
def test_code_that_runs_again_replaces_its_leaf(module):
    run_cell("maybe", True, module)
    run_cell("maybe", False, module)
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.FAILURE


@pytest.mark.parametrize(
    "files", [("<stdin>", "<stdin>"), ("/tmp/cell_1.py", "/tmp/cell_2.py")]
)
def test_changed_cell_replaces_its_leaf(files):
    """Also where the function has another name by now."""
    run_cell("maybe", False, file=files[0])
    run_cell("perhaps", True, file=files[1])
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.SUCCESS


@pytest.mark.parametrize("module", ["__main__", "my_leaves"])
def test_another_function_of_a_file_replaces_a_leaf_only_on_request(module):
    run_cell("maybe", True, module, "my_leaves.py")
    with pytest.raises(ValueError, match=f"maybe of {module}; .*replace=True"):
        run_cell("perhaps", False, module, "my_leaves.py")
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.SUCCESS


def test_function_without_a_name_replaces_another_only_on_request():
    register_condition("Maybe")(lambda context: True)
    with pytest.raises(ValueError, match=r"lambda.*replace=True"):
        register_condition("Maybe")(lambda context: False)


def test_same_function_can_be_registered_again():
    def maybe(context):
        return False

    register_condition("Maybe")(maybe)
    register_condition("Maybe", ignored=["agent_id"])(maybe)
    outcome = tick_near(tree_of('<Maybe agent_id="3"/>'))
    assert outcome.node_status is NodeStatus.FAILURE


def test_leaf_of_another_module_is_replaced_only_on_request():
    run_cell("maybe", True, "my_leaves")
    with pytest.raises(ValueError, match=r"leaf of my_leaves; .*replace=True"):
        run_cell("maybe", False, "other_leaves")
    with pytest.raises(ValueError, match=r"a leaf of hunav_drake\.systems"):
        register_action("RegularNav")(lambda context: None)
    register_condition("Maybe", replace=True)(lambda context: False)
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.FAILURE


@pytest.mark.parametrize(
    "xml", ['<BlockRobot duration="2"/>', '<SurprisedNav beh_duration="2"/>']
)
def test_own_nodes_have_the_ports_that_hunavsim_2_has(xml):
    @register_action("BlockRobot", replace=True)
    def block(context, *, duration: float):
        return NodeStatus.SUCCESS if duration == 2 else NodeStatus.FAILURE

    @register_action("SurprisedNav", replace=True)
    def be_surprised(context, *, beh_duration: float):
        return NodeStatus.SUCCESS if beh_duration == 2 else NodeStatus.FAILURE

    tree = tree_of(xml)
    (leaf,) = (it for it in tree.nodes if not it.children)
    assert f"<{leaf.name} " in xml
    assert tick_near(tree).node_status is NodeStatus.SUCCESS
    assert xml in WriteTree(tree)


def test_functions_that_one_function_makes_do_not_replace_each_other():
    def make(result):
        def maybe(context):
            return result

        return maybe

    register_condition("Maybe")(make(True))
    with pytest.raises(ValueError, match="another leaf of the same function"):
        register_condition("Maybe")(make(False))
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.SUCCESS
    register_condition("Maybe", replace=True)(make(False))
    assert tick_near(tree_of("<Maybe/>")).node_status is NodeStatus.FAILURE


@pytest.mark.parametrize("name", ["Sequence", "SubTree", "SequenceStar"])
def test_nodes_of_the_language_cannot_be_replaced(name):
    with pytest.raises(ValueError, match=f"{name}' is taken; choose"):
        register_action(name, replace=True)(lambda context: None)


class Nearer:
    """Holds if the robot is near.

    And so on.
    """

    def __init__(self, most=3.0):
        self.most = most

    def __call__(self, context, *, factor: float = 1.0) -> bool:
        return context.robot[X] < self.most * factor

    def method(self, context, *, factor: float = 1.0) -> bool:
        return self(context, factor=factor)


def nearer(context, *, most: float, factor: float = 1.0) -> bool:
    """Holds if the robot is near."""
    return context.robot[X] < most * factor


@pytest.mark.parametrize(
    "leaf",
    [Nearer(3.0), Nearer, Nearer(3.0).method, partial(nearer, most=3.0)],
    ids=["object", "class", "method", "partial"],
)
def test_objects_that_can_be_called_are_leaves(leaf):
    assert register_condition("IsNearer")(leaf) is leaf
    assert tick_near(tree_of("<IsNearer/>")).node_status is NodeStatus.SUCCESS
    dut = tree_of('<IsNearer factor="0.5"/>')
    assert tick_near(dut).node_status is NodeStatus.FAILURE
    with pytest.raises(BehaviorTreeError, match="there is no port 'most'"):
        tree_of('<IsNearer most="1"/>')


def test_two_objects_of_a_class_do_not_replace_each_other():
    register_condition("IsNearer")(Nearer(3.0))
    with pytest.raises(ValueError, match="same function or class"):
        register_condition("IsNearer")(Nearer(1.0))


@pytest.mark.parametrize("register", [register_action, register_condition])
def test_a_decorator_without_a_name_is_told_at_once(register):
    """Otherwise nothing would be registered, without a word."""

    def wave(context):
        return True

    with pytest.raises(ValueError, match=r'write @register_\w+\("Name"\)'):
        register(wave)


def test_leaf_must_be_something_to_call():
    with pytest.raises(ValueError, match=r"a leaf is a function.*got 3"):
        register_condition("Three")(3)
    with pytest.raises(ValueError, match="register one that you make"):
        register_condition("Zip")(partial)


@pytest.mark.parametrize("port", ["name", "ID", "_x"])
def test_port_that_no_attribute_could_set_is_refused(port):
    scope = {"register_action": register_action}
    code = f"def leaf(context, *, {port}: str = ''): pass"
    exec(code, scope)
    with pytest.raises(ValueError, match=f"no port can be called '{port}'"):
        register_action("Leaf")(scope["leaf"])


@pytest.mark.parametrize(
    "memory", [["seconds"], {"seconds": "0"}, {"seconds": None}, {"n": np.nan}]
)
def test_memory_is_names_with_numbers(memory):
    with pytest.raises(ValueError, match=r"Wait: memory must be names with t"):
        register_action("Wait", memory=memory)


def test_ignored_attributes_are_several_names_and_no_ports():
    with pytest.raises(ValueError, match=r"write \['agent_id'\]"):
        register_action("Leaf", ignored="agent_id")
    with pytest.raises(ValueError, match="x is a port, and cannot be ignored"):

        @register_action("Leaf", ignored=["x"])
        def leaf(context, *, x: float = 1.0):
            pass


@pytest.mark.parametrize(
    ("result", "status"),
    [
        (True, NodeStatus.SUCCESS),
        (np.True_, NodeStatus.SUCCESS),
        (NodeStatus.SUCCESS, NodeStatus.SUCCESS),
        (False, NodeStatus.FAILURE),
        (np.False_, NodeStatus.FAILURE),
        (NodeStatus.FAILURE, NodeStatus.FAILURE),
    ],
)
def test_condition_may_return_a_truth_or_a_status(result, status):
    register_condition("Maybe")(lambda context: result)
    assert tick_near(tree_of("<Maybe/>")).node_status is status


@pytest.mark.parametrize("result", [None, 1, "yes", NodeStatus.RUNNING, []])
def test_condition_must_return_a_truth(result):
    register_condition("Maybe")(lambda context: result)
    with pytest.raises(TypeError, match="<text>:2: condition Maybe must"):
        tick_near(tree_of("\n<Maybe/>"))


@pytest.mark.parametrize("register", [register_action, register_condition])
def test_error_in_a_leaf_has_the_place_of_the_node(register):
    register("Divide")(lambda context: 1 / 0)
    with pytest.raises(
        BehaviorTreeError, match="<text>:2: <half>: ZeroDivisionError: div"
    ) as caught:
        tick_near(tree_of('\n<Divide name="half"/>'))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def set_command(element, value):
    def write(context, own):
        context.command[element] = value

    return write


def set_status(value):
    def write(context, own):
        context.behavior_status = value

    return write


def set_memory(value):
    def write(context, own):
        own[0] = value

    return write


WRONG = {
    "NaN": (set_command(Command.GOAL_X, np.nan), "GOAL_X.*finite.*nan"),
    "infinity": (set_command(Command.GOAL_Y, np.inf), "GOAL_Y.*finite.*inf"),
    "text": (set_command(Command.HOLD, "yes"), "HOLD.*got 'yes'"),
    "nothing": (set_command(Command.HOLD, None), "HOLD.*got None"),
    "negative": (set_command(Command.MAX_SPEED, -1), "MAX_SPEED.*least 0"),
    "radius": (set_command(Command.GOAL_RADIUS, -1), "GOAL_RADIUS.*least 0"),
    "turn": (set_command(Command.TURN_RATE, -1.0), "TURN_RATE.*least 0"),
    "role": (set_command(Command.ROBOT_ROLE, 7), "RobotRole, got 7"),
    "long": (lambda context, own: context.command.append(1.0), "12.*got 13"),
    "short": (lambda context, own: context.command.pop(), "12.*got 11"),
    "status": (set_status(np.nan), "behavior_status must be in.*nan"),
    "status text": (set_status("1"), "behavior_status must be in.*'1'"),
    "large status": (set_status(101), "behavior_status must be in.*101"),
    "flag": (set_command(Command.HAS_GOAL, 0.3), "HAS_GOAL.*0 or 1, got 0.3"),
    "hold": (set_command(Command.HOLD, -1), "HOLD.*a Hold, got -1"),
    "half a group": (
        set_command(Command.GROUP_ID, 1.5),
        "GROUP_ID.*whole.*1.5",
    ),
    "list": (set_command(Command.GOAL_X, np.array([1.0])), "GOAL_X.*array"),
    "complex": (set_command(Command.GOAL_X, 1j), "GOAL_X.*got 1j"),
    "half a status": (
        set_status(1.5),
        "behavior_status.*whole number, got 1.5",
    ),
    "status list": (set_status(np.array([1.0])), "behavior_status.*array"),
    "memory list": (set_memory(np.array([1.0])), "memory 'Odd: kept'.*array"),
    "memory": (set_memory(np.nan), "memory 'Odd: kept' must be.*nan"),
    "memory text": (set_memory("a"), "memory 'Odd: kept' must be.*'a'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_leaf_writes_is_checked_and_the_leaf_is_named(name):
    function, words = WRONG[name]

    @register_action("Odd", memory={"kept": 0.0})
    def odd(context, own):
        function(context, own)

    body = "<Sequence><RegularNav/>\n<Odd/></Sequence>"
    with pytest.raises(BehaviorTreeError, match=f"<text>:2: <Odd>: .*{words}"):
        tick_near(tree_of(body))


@pytest.mark.parametrize(
    "function",
    [
        set_command(Command.HOLD, True),
        set_command(Command.GOAL_X, np.float64(1e308)),
        set_command(Command.GOAL_X, np.float32(1.5)),
        set_command(Command.GROUP_ID, 3),
        set_status(np.int64(2)),
        set_memory(np.bool_(True)),
        set_status(100),
        set_status(True),
        set_memory(np.inf),
        set_memory(7),
    ],
)
def test_what_is_right_passes(function):
    register_action("Odd", memory={"kept": 0.0})(function)
    body = (
        '<Sequence><Odd/><SetBlackboard output_key="a" value="1"/>'
        '<Inverter><SetBlackboard output_key="b" value="{c}"/></Inverter>'
        '<ForceSuccess><Sequence><AlwaysFailure/><SetBlackboard value="1"'
        ' output_key="c"/></Sequence></ForceSuccess></Sequence>'
    )
    assert tick_near(tree_of(body)).node_status is NodeStatus.SUCCESS


@pytest.mark.parametrize(
    ("leaf", "entry", "expected"),
    [
        ('<SetBehaviorStatus status="{x}"/>', "7", 7),
        ('<SetBehaviorStatus status="{x}"/>', "7.5", "status.*valid integer"),
        ('<SetBehaviorStatus status="{x}"/>', "101", r"\[0, 100\], got 101"),
        ('<RegularNav ignore_robot="{x}"/>', "true", RobotRole.UNSEEN),
        ('<RegularNav ignore_robot="{x}"/>', "2", "ignore_robot.*boolean"),
        ('<RegularNav robot="{x}"/>', "obstacle", RobotRole.OBSTACLE),
        ('<RegularNav robot="{x}"/>', "wall", "robot.*'pedestrian'.*from {x}"),
        (
            '<Parallel success_count="{x}"><AlwaysSuccess/></Parallel>',
            "2",
            "success_count: must be at most 1, the number of children, got 2",
        ),
    ],
)
def test_compiled_leaf_gets_entries_that_fit_its_ports(leaf, entry, expected):
    body = f'<SetBlackboard output_key="x" value="{entry}"/>{leaf}'
    dut = tree_of(f"<Sequence>{body}</Sequence>")
    if isinstance(expected, str):
        with pytest.raises(BehaviorTreeError, match=expected):
            tick_near(dut)
        return
    outcome = tick_near(dut)
    role = outcome.command[Command.ROBOT_ROLE]
    is_status = "Status" in leaf
    assert (outcome.behavior_status if is_status else role) == expected


def test_entry_that_a_compiled_leaf_needs_must_be_set():
    body = (
        '<Fallback><Inverter><AlwaysSuccess _onFailure="x := 1"/></Inverter>'
        '<SetBehaviorStatus name="mark" status="{x}"/></Fallback>'
    )
    with pytest.raises(
        BehaviorTreeError, match=r"<mark>: port status: nothing has set \{x\}"
    ):
        tick_near(tree_of(body))
