"""The tree language, and the trees that are made from it."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    NODE_TYPES,
    BehaviorTreeError,
    LoadTree,
    NodeStatus,
    ParseTree,
)
from hunav_drake.systems.behavior.writer import is_declared, tree_nodes_model
from hunav_drake.systems.common.layout import Command, RobotRole
from tests.systems.behavior.ticks import ME, PERSON, ROBOT, WALK, at, tick_near

# The constructs of the trees that come with HuNavSim: format 3, a model with
# an action inside an action, an include, entries copied with SetBlackboard,
# a subtree whose ports are named without braces.
FORMAT_3 = """
<root main_tree_to_execute = "ShyTree">
    <TreeNodesModel>
        <Action ID="RegularNav">
            <input_port name="agent_id" type="int">who walks</input_port>
            <Action ID="Hum">

            </Action>
        </Action>
    </TreeNodesModel>
    <include path="walk.xml"/>
    <BehaviorTree ID="ShyTree">
        <Fallback name="Shy"> <!-- a remark -->
            <Sequence name="Stay">
                <IsRobotVisible agent_id="{id}" distance="3.0" />
                <Inverter>
                    <TimeExpiredCondition seconds="0.5" ts="{dt}"
                                          only_once="True" />
                </Inverter>
                <RegularNav agent_id="{id}" time_step="{dt}" robot="unseen"/>
            </Sequence>
            <Sequence name="Walk">
                <SetBlackboard output_key="who" value="{id}" />
                <SetBlackboard output_key="step" value="{dt}" />
                <SubTree ID="WalkTree" id="who" dt="step" />
            </Sequence>
        </Fallback>
    </BehaviorTree>
</root>
"""


def parse_trees(body, version=4, **trees):
    others = "".join(
        f'<BehaviorTree ID="{name}">{text}</BehaviorTree>'
        for name, text in trees.items()
    )
    form = 'BTCPP_format="4"' if version == 4 else ""
    return ParseTree(
        f'<root {form} main_tree_to_execute="Main">'
        f'<BehaviorTree ID="Main">{body}</BehaviorTree>{others}</root>'
    )


def roles(tree, count, robot=ROBOT):
    memory, result = None, []
    for _ in range(count):
        outcome = tick_near(tree, memory, robot)
        memory = outcome.memory
        result.append(outcome.command[Command.ROBOT_ROLE])
    return result


def test_reads_what_hunavsim_writes(tmp_path):
    (tmp_path / "shy.xml").write_text(FORMAT_3)
    (tmp_path / "walk.xml").write_text(WALK)
    dut = LoadTree(str(tmp_path / "shy.xml"))
    # The fifth tick makes 0.5 s.
    unseen, pedestrian = RobotRole.UNSEEN, RobotRole.PEDESTRIAN
    assert roles(dut, 6) == [unseen] * 4 + [pedestrian] * 2
    assert roles(dut, 2, at(20.0, 0.0)) == [pedestrian] * 2
    memory = tick_near(dut, robot=at(20.0, 0.0)).memory
    entries = dict(zip(dut.slots, memory, strict=True))
    assert entries["{who}"] == PERSON.id
    assert entries["{step}"] == PERSON.time_step


def test_files_may_include_a_file_that_another_includes(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.xml").write_text(
        '<root><include path="sub/b.xml"/><include path="sub/c.xml"/>'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree></root>'
    )
    (tmp_path / "sub" / "b.xml").write_text(
        '<root><include path="c.xml"/><include path="c.xml"/>'
        '<BehaviorTree ID="B"><SubTree ID="C"/></BehaviorTree></root>'
    )
    (tmp_path / "sub" / "c.xml").write_text(
        '<root><BehaviorTree ID="C"><AlwaysFailure/></BehaviorTree></root>'
    )
    assert (
        tick_near(LoadTree(tmp_path / "a.xml")).node_status
        is NodeStatus.FAILURE
    )


def test_files_outside_are_included_if_that_is_allowed(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.xml").write_text(
        '<root><include path="../b.xml"/>'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree></root>'
    )
    (tmp_path / "b.xml").write_text(
        '<root><BehaviorTree ID="B"><AlwaysFailure/></BehaviorTree></root>'
    )
    path = tmp_path / "sub" / "a.xml"
    with pytest.raises(BehaviorTreeError, match="allow_outside=True"):
        LoadTree(path)
    dut = LoadTree(path, allow_outside=True)
    assert tick_near(dut).node_status is NodeStatus.FAILURE


def test_formats_name_leaves_by_tag_or_by_id():
    by_tag = parse_trees('<RegularNav robot="obstacle"/>')
    by_id = parse_trees(
        '<Action ID="RegularNav" name="walk" robot="obstacle"/>'
    )
    assert tick_near(by_tag).command == tick_near(by_id).command
    assert by_id.root.name == "walk"


def test_nodes_may_carry_the_notes_of_groot():
    noted = parse_trees(
        '<RegularNav _description="walks" _fullpath="a" _uid="3"/>'
    )
    assert noted.root.ports == parse_trees("<RegularNav/>").root.ports
    assert tick_near(noted) == tick_near(parse_trees("<RegularNav/>"))


@pytest.mark.parametrize(
    "subtree",
    [
        '<SubTree ID="See" range="3.0"/>',
        '<SubTree ID="See" range="{r}"/>',
        '<SubTree ID="See" range="{ r }"/>',
        '<SubTree ID="See2" _autoremap="true"/>',
        '<SubTree ID="See3"/>',
    ],
)
def test_subtree_takes_ports(subtree):
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="r" value="3"/>'
        f"{subtree}</Sequence>",
        See='<IsRobotVisible distance="{range}"/>',
        See2='<IsRobotVisible distance="{r}"/>',
        See3='<IsRobotVisible distance="{@r}"/>',
    )
    assert tick_near(dut).node_status is NodeStatus.SUCCESS
    assert tick_near(dut, robot=at(20.0, 0.0)).node_status is NodeStatus.FAILURE


def test_subtree_of_format_3_can_share_the_blackboard():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="r" value="3"/>'
        '<SubTree ID="See" __shared_blackboard="true"/></Sequence>',
        version=3,
        See='<IsRobotVisible distance="{r}"/>',
    )
    assert tick_near(dut).node_status is NodeStatus.SUCCESS


def test_subtree_keeps_its_own_entries():
    with pytest.raises(BehaviorTreeError, match="no node that sets"):
        parse_trees(
            '<Sequence><SetBlackboard output_key="r" value="3"/>'
            '<SubTree ID="See"/></Sequence>',
            See='<IsRobotVisible distance="{r}"/>',
        )


def test_literal_of_a_subtree_can_be_changed_in_it():
    dut = parse_trees(
        '<SubTree ID="Look" d="3"/>',
        Look='<Sequence><IsRobotVisible distance="{d}"/>'
        '<SetBlackboard output_key="d" value="1"/></Sequence>',
    )
    first = tick_near(dut)
    assert first.node_status is NodeStatus.SUCCESS
    assert tick_near(dut, first.memory).node_status is NodeStatus.FAILURE


def test_two_uses_of_a_subtree_remember_apart():
    dut = parse_trees(
        '<Parallel><SubTree ID="T"/><SubTree ID="T"/></Parallel>',
        T='<TimeExpiredCondition seconds="1"/>',
    )
    timers = [s for s in dut.slots if s.startswith("TimeExpired")]
    assert len(timers) == 2


def test_equals_sign_stands_for_the_name_of_the_port():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="distance" value="3"/>'
        '<IsRobotVisible distance="{=}"/></Sequence>'
    )
    assert tick_near(dut).node_status is NodeStatus.SUCCESS


def test_port_follows_the_entry_as_it_changes():
    dut = parse_trees(
        "<Sequence>"
        '<ForceSuccess><RunOnce><SetBlackboard output_key="d" value="3"/>'
        "</RunOnce></ForceSuccess>"
        '<IsRobotVisible distance="{d}"/>'
        '<SetBlackboard output_key="{d}" value="1"/></Sequence>'
    )
    first = tick_near(dut)
    assert first.node_status is NodeStatus.SUCCESS
    assert tick_near(dut, first.memory).node_status is NodeStatus.FAILURE


@pytest.mark.parametrize(
    ("text", "value"), [("2", 2.0), ("-1.5e1", -15.0), ("True", 1.0)]
)
def test_blackboard_holds_numbers_and_truths(text, value):
    dut = parse_trees(f'<SetBlackboard output_key="a" value="{text}"/>')
    assert tick_near(dut).memory[-1] == value


def test_copying_an_entry_that_is_not_set_fails():
    dut = parse_trees(
        '<Fallback><SetBlackboard output_key="a" value="{b}"/>'
        '<SetBlackboard output_key="b" value="1"/></Fallback>'
    )
    first = tick_near(dut)
    assert first.node_status is NodeStatus.SUCCESS
    assert dict(zip(dut.slots, first.memory, strict=True))["{b}"] == 1


def test_reading_an_entry_that_is_not_set_names_the_node():
    dut = parse_trees(
        '<Sequence><IsRobotVisible distance="{d}"/>'
        '<SetBlackboard output_key="d" value="1"/></Sequence>'
    )
    with pytest.raises(BehaviorTreeError, match=r"nothing has set \{d\}"):
        tick_near(dut)


def test_entry_out_of_a_ports_range_names_the_node():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="d" value="-1"/>'
        '<IsRobotVisible distance="{d}"/></Sequence>'
    )
    with pytest.raises(BehaviorTreeError, match=r"IsRobotVisible.*got -1"):
        tick_near(dut)


def test_truth_from_the_blackboard():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="t" value="false"/>'
        '<TimeExpiredCondition seconds="0.1" only_once="{t}"/></Sequence>'
    )
    assert tick_near(dut).node_status is NodeStatus.SUCCESS


@pytest.mark.parametrize("name", BEHAVIORS)
def test_shipped_tree_loads(name):
    dut = LoadTree(name)
    assert dut.file == str(BEHAVIORS[name])
    # The robot stands in the way: some are walking past it.
    passing = name in ("cooperative", "impassive")
    assert tick_near(dut).node_status is (
        NodeStatus.RUNNING if passing else NodeStatus.SUCCESS
    )
    assert tick_near(dut, robot=at(20.0, 0.0)).node_status is NodeStatus.SUCCESS


def test_shipped_trees_tell_groot_of_our_nodes():
    """The model that they all include is that of the leaves as they are."""
    ours = [
        node_type
        for node_type in NODE_TYPES.values()
        if node_type.is_ours and is_declared(node_type)
    ]
    file = BEHAVIORS["regular"].with_name("node_models.xml")
    written = ET.parse(file).getroot().find("TreeNodesModel")
    expected = ET.fromstring(tree_nodes_model(ours))
    assert ET.canonicalize(
        ET.tostring(written), strip_text=True
    ) == ET.canonicalize(ET.tostring(expected), strip_text=True)
    for name in BEHAVIORS:
        models = LoadTree(name).documents.models
        assert any(model.place.file == str(file) for model in models)


def test_description_shows_nodes_and_memory():
    dut = parse_trees(
        '<Sequence name="all"><TimeExpiredCondition seconds="2"/>'
        '<SetBlackboard output_key="a" value="1"/>'
        '<RegularNav robot="{who}" _skipIf="who == \'obstacle\'"/>'
        '<SetBlackboard output_key="who" value="unseen"/></Sequence>'
    )
    assert dut.Describe().splitlines() == [
        "Main (<text>)",
        "Nodes:",
        "    0  Sequence 'all'",
        "    1    TimeExpiredCondition seconds=2.0 only_once=False",
        "    2    SetBlackboard value=1.0 output_key={a}",
        "    3    RegularNav robot={who} ignore_robot=False"
        " _skipIf=\"who == 'obstacle'\"",
        "    4    SetBlackboard value='unseen' output_key={who}",
        "Memory:",
        "    0  goal index",
        "    1  all: child (node 0)",
        "    2  all: skipped (node 0)",
        "    3  TimeExpiredCondition: seconds (node 1)",
        "    4  RegularNav: (runs) (node 3)",
        "    5  {a}",
        "    6  {who}",
        "Texts, and the numbers that stand for them:",
        "    0  'obstacle'",
        "    1  'unseen'",
    ]
    assert len(dut.initial_memory(PERSON)) == len(dut.slots) == 7


def test_tick_is_pure():
    dut = parse_trees('<TimeExpiredCondition seconds="2"/>')
    memory = tuple(dut.initial_memory(PERSON))
    humans, robots = ME.copy(), ROBOT.copy()
    first = dut.tick(PERSON, memory, humans, robots)
    assert dut.tick(PERSON, memory, humans, robots) == first
    assert memory == tuple(dut.initial_memory(PERSON))
    assert list(first.memory) != list(memory)
    np.testing.assert_array_equal(humans, ME)
    np.testing.assert_array_equal(robots, ROBOT)


@pytest.mark.parametrize("entry", ["obstacle", "unseen", "pedestrian"])
def test_blackboard_holds_texts(entry):
    dut = parse_trees(
        f'<Sequence><SetBlackboard output_key="r" value="{entry}"/>'
        '<SetBlackboard output_key="copy" value="{r}"/>'
        '<RegularNav robot="{copy}"/></Sequence>'
    )
    outcome = tick_near(dut)
    assert outcome.command[Command.ROBOT_ROLE] == RobotRole[entry.upper()]
    assert dut.texts == (entry,)
    assert outcome.memory[-2:] == [0.0, 0.0]


def test_text_that_a_port_does_not_take_names_the_node():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="r" value="wall"/>'
        '<RegularNav robot="{r}"/></Sequence>'
    )
    with pytest.raises(BehaviorTreeError, match=r"RegularNav.*from \{r\}"):
        tick_near(dut)


def test_number_is_a_text_where_the_entry_holds_texts():
    dut = parse_trees(
        '<Sequence><SetBlackboard output_key="m" value="1"/>'
        '<Switch2 variable="{m}" case_1="01" case_2="1">'
        '<AlwaysSuccess/><AlwaysFailure/><SetBlackboard output_key="m"'
        ' value="none"/></Switch2></Sequence>'
    )
    assert tick_near(dut).node_status is NodeStatus.FAILURE
    assert dut.texts == ("1", "01", "none")


SWITCH = (
    '<Switch3 variable="{m}" case_1="1" case_2="{c}" case_3="3">'
    '<SetBlackboard output_key="at" value="1"/>'
    '<SetBlackboard output_key="at" value="2"/>'
    '<SetBlackboard output_key="at" value="3"/>'
    '<SetBlackboard output_key="at" value="4"/></Switch3>'
)


@pytest.mark.parametrize(
    ("before", "expected"),
    [
        ("", 4),
        ('<SetBlackboard output_key="m" value="1"/>', 1),
        ('<SetBlackboard output_key="m" value="3.0"/>', 3),
        ('<SetBlackboard output_key="m" value="{id}"/>', 4),
        ('<SetBlackboard output_key="c" value="1"/>', 4),
        (
            '<SetBlackboard output_key="m" value="7"/>'
            '<SetBlackboard output_key="c" value="{id}"/>',
            2,
        ),
    ],
)
def test_switch_follows_an_entry(before, expected):
    dut = parse_trees(
        f'<Sequence>{before}{SWITCH}<ForceSuccess _skipIf="true"><Sequence>'
        '<SetBlackboard output_key="m" value="0"/>'
        '<SetBlackboard output_key="c" value="0"/></Sequence></ForceSuccess>'
        "</Sequence>"
    )
    memory = dict(zip(dut.slots, tick_near(dut).memory, strict=True))
    assert memory["{at}"] == expected


def test_switch_halts_the_child_that_it_leaves():
    dut = parse_trees(
        '<Parallel><Switch2 variable="{m}" case_1="a" case_2="b">'
        '<Delay delay_msec="900"><AlwaysSuccess/></Delay><AlwaysFailure/>'
        '<Delay delay_msec="800"><AlwaysSuccess/></Delay></Switch2>'
        '<Sequence><SetBlackboard output_key="m" value="a"/>'
        '<Delay delay_msec="200"><SetBlackboard output_key="m" value="c"/>'
        "</Delay></Sequence></Parallel>"
    )
    steps = [i for i, s in enumerate(dut.slots) if s == "Delay: steps"]
    memory, seen = None, []
    for _ in range(4):
        memory = tick_near(dut, memory).memory
        seen.append([memory[i] for i in steps[:2]])
    assert seen == [[0, 1], [1, 0], [2, 0], [0, 1]]


MODEL = (
    '<TreeNodesModel><SubTree ID="See"><input_port name="d" default="{}"/>'
    '<input_port name="e" default="1"/></SubTree></TreeNodesModel>'
)


@pytest.mark.parametrize(
    ("subtree", "default", "sees"),
    [
        ('<SubTree ID="See"/>', "3", True),
        ('<SubTree ID="See"/>', "1", False),
        ('<SubTree ID="See" d="3"/>', "1", True),
        ('<SubTree ID="See" d="{r}"/>', "1", True),
        ('<SubTree ID="See"/>', "{r}", True),
        # Automatically remapped ports need no default.
        ('<SubTree ID="See" _autoremap="true"/>', "1", True),
    ],
)
def test_subtree_takes_the_defaults_of_its_model(subtree, default, sees):
    dut = ParseTree(
        '<root BTCPP_format="4" main_tree_to_execute="Main">'
        '<BehaviorTree ID="Main"><Sequence>'
        '<SetBlackboard output_key="r" value="3"/>'
        '<SetBlackboard output_key="d" value="3"/>'
        f"{subtree}</Sequence></BehaviorTree>"
        '<BehaviorTree ID="See"><IsRobotVisible distance="{d}"/>'
        f"</BehaviorTree>{MODEL.replace('{}', default)}</root>"
    )
    expected = NodeStatus.SUCCESS if sees else NodeStatus.FAILURE
    assert tick_near(dut).node_status is expected


GIVEN_PORTS = """
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">{main}</BehaviorTree>
  <BehaviorTree ID="See"><IsRobotVisible distance="{{id}}"/></BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="{tree}"><input_port name="id" {default}/></SubTree>
  </TreeNodesModel>
</root>
"""


def given_ports(tree, default, main='<SubTree ID="See"/>'):
    return ParseTree(GIVEN_PORTS.format(tree=tree, default=default, main=main))


@pytest.mark.parametrize(
    ("distance", "status"), [(3, NodeStatus.SUCCESS), (1, NodeStatus.FAILURE)]
)
def test_subtree_may_have_a_port_named_id(distance, status):
    assert (
        tick_near(given_ports("See", f'default="{distance}"')).node_status
        is status
    )


def test_id_of_the_main_tree_is_that_of_the_person():
    """A declaration is welcome, as files of HuNavSim have it."""
    main = '<SubTree ID="See" id="{id}"/>'
    assert (
        tick_near(given_ports("Main", "", main)).node_status
        is NodeStatus.SUCCESS
    )
    with pytest.raises(
        BehaviorTreeError,
        match="<text>:6: the port id of the main tree cannot have a default",
    ):
        given_ports("Main", 'default="3"', main)


def test_id_that_a_subtree_is_not_given_is_told_where_it_is_used():
    with pytest.raises(BehaviorTreeError, match="sets the entry 'id'"):
        given_ports("See", "")
