"""Trees of the package in users' trees."""

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    BehaviorTreeError,
    ConvertTree,
    LoadBehavior,
    LoadTree,
    NodeStatus,
    ParseTree,
    Person,
)
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people.human_config import HumanConfig

HUNAVSIM = BEHAVIORS["regular"].parents[1] / "hunavsim"
OWN = """
<root BTCPP_format="4" main_tree_to_execute="Mine">
  {include}
  <BehaviorTree ID="Mine">
    <Fallback>
      <IsRobotVisible distance="1"/>
      <SubTree ID="RegularNavTree" robot="obstacle"/>
    </Fallback>
  </BehaviorTree>
</root>
"""
FALLS_BACK = {
    "by its ID": OWN.format(include=""),
    "by its file": OWN.format(include='<include path="regular.xml"/>'),
    "by a file that has it": OWN.format(include='<include path="scared.xml"/>'),
}


def command_of(tree):
    human = HumanConfig(pose=(0, 0, 0), goals=[(9.0, 0.0)])
    who = Person.from_config(human, 0, time_step=0.05)
    row = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35])
    robot = np.array([5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35])
    outcome = tree.tick(who, tree.initial_memory(who), row, robot)
    assert outcome.node_status is NodeStatus.SUCCESS
    return dict(zip(Command, outcome.command, strict=True))


@pytest.mark.parametrize("name", FALLS_BACK)
@pytest.mark.parametrize("way", ["text", "file", "behavior"])
def test_own_tree_falls_back_to_that_of_the_package(name, way, tmp_path):
    source = FALLS_BACK[name]
    path = tmp_path / "own.xml"
    path.write_text(source)
    tree = {
        "text": lambda: ParseTree(source),
        "file": lambda: LoadTree(path),
        "behavior": lambda: LoadBehavior(source),
    }[way]()
    command = command_of(tree)
    assert command[Command.GOAL_X] == 9.0
    assert command[Command.ROBOT_ROLE] == 2


@pytest.mark.parametrize("name", [*BEHAVIORS])
def test_each_tree_of_the_package_can_be_a_subtree_without_its_file(name):
    tree_id = LoadTree(name).name
    tree = ParseTree(
        f'<root BTCPP_format="4"><BehaviorTree ID="Own">'
        f'<SubTree ID="{tree_id}"/></BehaviorTree></root>'
    )
    assert tree.name == "Own"
    plain = LoadTree(name)
    assert [it.type for it in tree.nodes][1:] == [it.type for it in plain.nodes]


def test_own_file_of_that_name_comes_first(tmp_path):
    (tmp_path / "regular.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="RegularNavTree">'
        "<SurprisedNav/></BehaviorTree></root>"
    )
    path = tmp_path / "own.xml"
    path.write_text(
        '<root main_tree_to_execute="RegularNavTree">'
        '<include path="regular.xml"/></root>'
    )
    assert command_of(LoadTree(path))[Command.HOLD] == 1


def test_own_tree_of_that_id_comes_first():
    tree = ParseTree(
        '<root BTCPP_format="4" main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><SubTree ID="RegularNavTree"/></BehaviorTree>'
        '<BehaviorTree ID="RegularNavTree"><SurprisedNav/></BehaviorTree>'
        "</root>"
    )
    assert command_of(tree)[Command.HOLD] == 1


def test_unknown_subtree_is_still_told():
    with pytest.raises(BehaviorTreeError, match="RegularTree"):
        ParseTree(OWN.format(include="").replace("NavTree", "Tree"))


def test_written_tree_holds_what_it_fell_back_to(tmp_path):
    path = tmp_path / "own.xml"
    path.write_text(OWN.format(include=""))
    written = ConvertTree(path)
    assert '<BehaviorTree ID="RegularNavTree">' in written
    assert ParseTree(written).slots == LoadTree(path).slots


class TestProfile:
    def test_names_stand_for_the_trees_of_the_original(self):
        for name in {*BEHAVIORS} - {"distracted", "cooperative"}:
            tree = LoadTree(name, profile="hunavsim")
            assert tree.file == str(HUNAVSIM / f"{name}.xml")
            assert tree.documents != LoadTree(name).documents

    def test_what_the_original_has_not_is_as_ever(self):
        tree = LoadBehavior("distracted", profile="hunavsim")
        assert tree.file == str(BEHAVIORS["distracted"])

    def test_subtrees_are_those_of_the_original_too(self):
        source = OWN.format(include="")
        files = [
            name
            for name, _ in ParseTree(
                source, profile="hunavsim"
            ).documents.sources
        ]
        assert str(HUNAVSIM / "regular.xml") in files
        assert str(BEHAVIORS["regular"]) not in files
