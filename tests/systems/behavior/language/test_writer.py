"""Trees of format 3 or 4 are written in format 4, and tick the same."""

import xml.etree.ElementTree as ET

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    BehaviorTreeError,
    ConvertTree,
    LoadTree,
    ParseTree,
    Person,
    WriteTree,
)
from hunav_drake.systems.people.human_config import HumanConfig

PERSON = Person.from_config(
    HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(3.0, 0.0), (9.0, 1.0)], id=7),
    index=0,
    time_step=0.1,
)

# Names and forms that differ in format 4.
FORMAT_3 = """<?xml version="1.0"?>
<!-- A shy person -->
<root main_tree_to_execute="Shy">
  <TreeNodesModel>
    <Action ID="RegularNav"><Action ID="Hum"/></Action>
  </TreeNodesModel>
  <include path="walk.xml"/>
  <BehaviorTree ID="Shy">
    <Fallback name="&quot;Shy&quot; &amp; more">
      <!-- stays -->
      <SequenceStar name="Stay">
        <Condition ID="IsRobotVisible" agent_id="{id}" distance="3.0"/>
        <Inverter>
          <TimeExpiredCondition seconds="0.5" ts="${dt}" only_once="True"/>
        </Inverter>
        <Parallel success_threshold="2" failure_threshold="1">
          <Action ID="RegularNav" time_step="{dt}" robot="unseen"/>
          <RetryUntilSuccesful num_attempts="2"><AlwaysSuccess/>
          </RetryUntilSuccesful>
        </Parallel>
      </SequenceStar>
      <Sequence name="Walk">
        <SetBlackboard output_key="who" value="${id}"/>
        <SetBlackboard output_key="{step}" value="{dt}"/>
        <SetBlackboard output_key="role" value="obstacle"/>
        <SetBlackboard output_key="pause" value="200"/>
        <SubTree ID="Walk" id="who" dt="step" how="role"/>
        <SubTree ID="Rest" __shared_blackboard="true"/>
        <SubTreePlus ID="Rest" __autoremap="1"/>
        <SubTreePlus ID="Rest" pause="300"/>
        <SubTreePlus ID="Rest" pause="{pause}"/>
      </Sequence>
      <!-- the end -->
    </Fallback>
  </BehaviorTree>
</root>
"""
WALK = """
<root>
  <BehaviorTree ID="Walk">
    <Fallback>
      <Sequence>
        <Inverter><IsGoalReached agent_id="{id}"/></Inverter>
        <RegularNav agent_id="{id}" time_step="{dt}" robot="{how}"/>
      </Sequence>
      <UpdateGoal agent_id="{id}"/>
    </Fallback>
  </BehaviorTree>
  <BehaviorTree ID="Rest">
    <Delay delay_msec="{pause}"><AlwaysSuccess/></Delay>
  </BehaviorTree>
</root>
"""


@pytest.fixture
def shy(tmp_path):
    (tmp_path / "walk.xml").write_text(WALK)
    path = tmp_path / "shy.xml"
    path.write_text(FORMAT_3)
    return path


def assert_same_ticks(first, second, seed=0, count=40):
    random = np.random.default_rng(seed)
    assert first.slots == second.slots
    assert first.texts == second.texts
    memories = [tree.initial_memory(PERSON) for tree in (first, second)]
    for _ in range(count):
        x, y, yaw, robot_x = random.uniform(-4, 4, size=4)
        me = np.array([x, y, yaw, 0.5, 0, 0, 0.35])
        robot = np.array([robot_x, 0, 0, 0, 0, 0, 0.35])
        outcomes = [
            tree.trace(PERSON, memory, me, robot)
            for tree, memory in zip((first, second), memories, strict=True)
        ]
        assert outcomes[0] == outcomes[1]
        memories = [outcome.memory for outcome, _ in outcomes]


def test_format_3_becomes_format_4(shy):
    text = ConvertTree(shy)
    root = ET.fromstring(text)
    assert root.attrib == {"BTCPP_format": "4", "main_tree_to_execute": "Shy"}
    assert [tree.get("ID") for tree in root.findall("BehaviorTree")] == [
        "Shy",
        "Walk",
        "Rest",
    ]
    assert not root.findall("include")
    tags = {element.tag for element in root.iter()}
    assert tags >= {"SequenceWithMemory", "RetryUntilSuccessful", "RegularNav"}
    assert not tags & {"SequenceStar", "SubTreePlus", "Parallel "}
    subtrees = [s.attrib for s in root.find("BehaviorTree").iter("SubTree")]
    assert subtrees == [
        {"ID": "Walk", "id": "{who}", "dt": "{step}", "how": "{role}"},
        {"ID": "Rest", "_autoremap": "true"},
        {"ID": "Rest", "_autoremap": "true"},
        {"ID": "Rest", "pause": "300"},
        {"ID": "Rest", "pause": "{pause}"},
    ]
    (parallel,) = root.iter("Parallel")
    assert parallel.attrib == {"success_count": "2", "failure_count": "1"}
    assert "$" not in text
    for comment in ("<!-- A shy person -->", "<!-- stays -->", "the end"):
        assert comment in text


def test_what_is_written_ticks_the_same(shy):
    assert_same_ticks(LoadTree(shy), ParseTree(ConvertTree(shy)))


def test_groot_is_told_of_the_attributes_in_use(shy):
    root = ET.fromstring(ConvertTree(shy))
    ports = {
        port.get("name")
        for port in root.find("TreeNodesModel/Condition[@ID='IsRobotVisible']")
    }
    assert ports >= {"distance", "agent_id"}
    assert root.find("TreeNodesModel/Action[@ID='UpdateGoal']") is not None
    assert root.find("TreeNodesModel/Action[@ID='CuriousNav']") is None


@pytest.mark.parametrize("name", BEHAVIORS)
def test_shipped_tree_stays_as_it_is(name):
    dut = LoadTree(name)
    text = WriteTree(dut)
    assert text == ConvertTree(name) == WriteTree(dut.documents)
    again = ParseTree(text)
    assert_same_ticks(dut, again)
    assert WriteTree(again) == text
    assert again.documents.ports.keys() == dut.documents.ports.keys()


@settings(max_examples=20)
@given(st.integers(0, 2**32))
def test_same_ticks_whatever_happens(seed):
    for name in ("curious", "cooperative"):
        dut = LoadTree(name)
        assert_same_ticks(dut, ParseTree(WriteTree(dut)), seed, count=10)


@pytest.mark.parametrize(
    "text", ["a&b", 'say "no"', "<x>", "it's", "ä漢", "a&#10;b", " {x} "]
)
def test_texts_are_escaped(text):
    escaped = text.replace("&b", "&amp;b").replace("<", "&lt;")
    escaped = escaped.replace('"', "&quot;")
    dut = ParseTree(
        f'<root><BehaviorTree><AlwaysSuccess name="{escaped}"/>'
        "</BehaviorTree></root>"
    )
    again = ParseTree(WriteTree(dut))
    assert again.root.name == dut.root.name == text.replace("&#10;", "\n")


def test_tree_without_name_gets_one(tmp_path):
    (tmp_path / "b.xml").write_text(
        '<root><BehaviorTree ID="MainTree"><AlwaysFailure/></BehaviorTree>'
        "</root>"
    )
    (tmp_path / "a.xml").write_text(
        '<root><include path="b.xml"/><BehaviorTree>'
        '<SubTree ID="MainTree"/></BehaviorTree></root>'
    )
    dut = ParseTree(ConvertTree(tmp_path / "a.xml"))
    assert dut.name == "MainTree2"
    assert dut.root.children[0].type.name == "AlwaysFailure"


def test_conditions_are_kept():
    source = (
        '<root BTCPP_format="4" main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><Sequence _post="n := 1">'
        '<SubTree ID="B" _skipIf="n == 1" _onSuccess="m := \'x\'"/>'
        '</Sequence></BehaviorTree><BehaviorTree ID="B">'
        '<AlwaysSuccess _description="a &lt; b"/></BehaviorTree></root>'
    )
    text = WriteTree(ParseTree(source))
    for part in (
        '_post="n := 1"',
        '_skipIf="n == 1"',
        "_onSuccess=\"m := 'x'\"",
        '_description="a &lt; b"',
    ):
        assert part in text


def test_private_entries_cannot_be_shared():
    """Format 3 shares `_x` with such a subtree, format 4 never does."""
    dut = ParseTree(
        '<root main_tree_to_execute="A"><BehaviorTree ID="A"><Sequence>'
        '<SetBlackboard output_key="_x" value="3"/>'
        '<SubTree ID="B" __shared_blackboard="true"/></Sequence>'
        '</BehaviorTree>\n<BehaviorTree ID="B">'
        '<IsRobotVisible distance="{_x}"/></BehaviorTree></root>'
    )
    with pytest.raises(BehaviorTreeError, match="rename the entry") as caught:
        WriteTree(dut)
    assert caught.value.place.line == 2


def test_tree_that_nothing_uses_is_written_too():
    text = WriteTree(
        ParseTree(
            '<root main_tree_to_execute="A"><BehaviorTree ID="B">'
            '<Unknown x="1"/></BehaviorTree>'
            '<BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree></root>'
        )
    )
    assert '<Unknown x="1"/>' in text
    assert text.index('ID="A"') < text.index('ID="B"')


def test_the_limit_of_a_reaction_is_declared_too():
    tree = ParseTree(
        '<root><BehaviorTree><SurprisedNav beh_duration="2" only_once="true"/>'
        "</BehaviorTree></root>"
    )
    root = ET.fromstring(WriteTree(tree))
    model = root.find("TreeNodesModel/Action[@ID='SurprisedNav']")
    names = {port.get("name") for port in model}
    assert names >= {"beh_duration", "only_once", "turn_rate"}
