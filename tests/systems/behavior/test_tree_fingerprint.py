"""The fingerprint of a tree: the same where the tree is the same."""

import re

import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    LoadTree,
    register_condition,
    tree_fingerprint,
)
from hunav_drake.systems.people import BehaviorConfig

INNER = """<root BTCPP_format="4">
  <BehaviorTree ID="Look">
    <IsRobotVisible distance="{distance}"/>
  </BehaviorTree>
  <TreeNodesModel><SubTree ID="Look">
    <input_port name="distance" type="double" default="3.0"/>
  </SubTree></TreeNodesModel>
</root>
"""
OUTER = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <include path="inner.xml"/>
  <BehaviorTree ID="Main">
    <Fallback>
      <SubTree ID="Look"/>
      <RegularNav ignore_robot="{blind}"/>
    </Fallback>
  </BehaviorTree>
  <TreeNodesModel><SubTree ID="Main">
    <input_port name="blind" type="bool" default="false"/>
  </SubTree></TreeNodesModel>
</root>
"""


def fingerprint(folder, outer=OUTER, inner=INNER, **ports):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "outer.xml").write_text(outer)
    (folder / "inner.xml").write_text(inner)
    path = str(folder / "outer.xml")
    return tree_fingerprint(BehaviorConfig(type=path, ports=ports))


def test_fingerprint_is_of_the_content_not_of_the_place(tmp_path):
    here = fingerprint(tmp_path / "here")
    assert re.fullmatch("[0-9a-f]{64}", here)
    assert fingerprint(tmp_path / "there" / "below") == here
    assert fingerprint(tmp_path, "<!-- Hello -->\n" + OUTER) == here
    assert fingerprint(tmp_path, OUTER.replace("    <Fall", "<Fall")) == here


@pytest.mark.parametrize(
    "change",
    [
        {"inner": INNER.replace("3.0", "3.5")},
        {"inner": INNER.replace('distance="{d', 'occlusion="0" distance="{d')},
        {"outer": OUTER.replace("Fallback", "ReactiveFallback")},
        {"outer": OUTER.replace('default="false"', 'default="true"')},
        {"blind": True},
    ],
    ids=["default of an include", "include", "node", "default", "port"],
)
def test_what_matters_changes_the_fingerprint(change, tmp_path):
    assert fingerprint(tmp_path, **change) != fingerprint(tmp_path)


def test_default_that_is_given_changes_nothing(tmp_path):
    assert fingerprint(tmp_path, blind=False) == fingerprint(tmp_path)


def test_each_behavior_has_its_own(monkeypatch, tmp_path):
    before = {name: tree_fingerprint(name) for name in BEHAVIORS}
    assert len(set(before.values())) == len(BEHAVIORS)
    monkeypatch.chdir(tmp_path)
    for name, value in before.items():
        assert tree_fingerprint(LoadTree(name)) == value
        assert tree_fingerprint(BehaviorConfig(type=name)) == value


@pytest.mark.usefixtures("node_types")
def test_default_of_ones_own_leaf_matters():
    xml = "<root><BehaviorTree><IsLate/></BehaviorTree></root>"
    values = set()
    for default in (1.0, 2.0):

        @register_condition("IsLate", replace=True)
        def is_late(context, *, seconds: float = default) -> bool:
            return True

        values.add(tree_fingerprint(xml))
    assert len(values) == 2
