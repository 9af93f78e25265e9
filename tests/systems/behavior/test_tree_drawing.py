"""Drawings of trees, and the status of their nodes."""

import re
import shutil

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    BehaviorTree,
    LoadTree,
    NodeStatus,
    ParseTree,
    RenderBehaviorTree,
)
from hunav_drake.systems.people.human_config import HumanConfig

needs_dot = pytest.mark.skipif(
    shutil.which("dot") is None, reason="Graphviz is not installed"
)
HUMAN = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(5.0, 0.0)])
ME = [0.0, 0, 0, 0, 0, 0, 0.35]
NEAR = [2.0, 0, 0, 0, 0, 0, 0.35]
FAR = [20.0, 0, 0, 0, 0, 0, 0.35]
TREE = ParseTree("""<root BTCPP_format="4" main_tree_to_execute="A">
<BehaviorTree ID="A"><Fallback name="a &lt; b &amp; ü">
  <Sequence _onSuccess="n := 1">
    <IsRobotVisible distance="3"/>
    <RegularNav robot="obstacle" _skipIf="id == 1"/>
    <Delay delay_msec="100"><AlwaysSuccess/></Delay>
  </Sequence>
  <SubTree ID="B"/>
</Fallback></BehaviorTree>
<BehaviorTree ID="B"><Parallel><AlwaysFailure/></Parallel></BehaviorTree>
</root>""")
IDLE, RUNNING, SUCCESS, FAILURE, SKIPPED = 0, 1, 2, 3, 4


@pytest.fixture
def dut():
    return BehaviorTree([TREE], [HUMAN], time_step=0.125)


def fix_states(dut, context, robot):
    dut.get_human_states_input_port().FixValue(context, ME)
    dut.get_robot_states_input_port().FixValue(context, robot)


def node_status(dut, context):
    return dut.get_node_status_output_port().Eval(context).tolist()


def test_status_has_a_number_for_each_node(dut):
    context = dut.CreateDefaultContext()
    assert dut.get_node_status_output_port().get_name() == "node_status"
    fix_states(dut, context, NEAR)
    near = [RUNNING, RUNNING, SUCCESS, SKIPPED, RUNNING, IDLE, IDLE, IDLE, IDLE]
    assert node_status(dut, context) == near
    fix_states(dut, context, FAR)
    assert node_status(dut, context) == [
        FAILURE,
        FAILURE,
        FAILURE,
        *[IDLE] * 3,
        FAILURE,
        FAILURE,
        FAILURE,
    ]


def test_status_follows_the_state(dut):
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_states(dut, context, NEAR)
    simulator.AdvanceTo(0.0625)
    ticked = [SUCCESS, SUCCESS, IDLE, IDLE, SUCCESS, SUCCESS, *[IDLE] * 3]
    assert node_status(dut, context) == ticked


def test_asking_for_the_status_changes_nothing(dut):
    results = []
    for asks in (False, True):
        simulator = Simulator(dut)
        context = simulator.get_mutable_context()
        fix_states(dut, context, NEAR)
        for i in range(10):
            if asks:
                node_status(dut, context)
            simulator.AdvanceTo(0.125 * i)
        results.append(context.get_discrete_state(0).value().copy())
    np.testing.assert_array_equal(*results)


def test_text_shows_the_tree():
    text = str(RenderBehaviorTree(TREE))
    assert text.splitlines() == [
        "? Fallback 'a < b & ü'",
        '├─ → Sequence _onSuccess="n := 1"',
        "│  ├─ IsRobotVisible distance=3.0",
        "│  ├─ RegularNav robot='obstacle' _skipIf=\"id == 1\"",
        "│  └─ Delay delay_msec=100.0",
        "│     └─ AlwaysSuccess",
        "└─ SubTree 'B'",
        "   └─ ⇉ Parallel",
        "      └─ AlwaysFailure",
    ]


def test_text_shows_the_status(dut):
    context = dut.CreateDefaultContext()
    fix_states(dut, context, NEAR)
    drawing = RenderBehaviorTree(
        TREE, dut.get_node_status_output_port().Eval(context)
    )
    lines = str(drawing).splitlines()
    marks = [re.search("[·▶✓✗↷]", line)[0] for line in lines[:9]]
    assert marks == list("▶▶✓↷▶····")
    assert lines[-1].startswith("· not ticked  ▶ running")


@pytest.mark.parametrize("value", [[], [0] * 8, [0] * 10])
def test_status_must_be_of_all_nodes(value):
    with pytest.raises(ValueError, match="each of the 9 nodes"):
        RenderBehaviorTree(TREE, value)


def test_status_must_be_a_status():
    with pytest.raises(ValueError, match="7 is not a valid NodeStatus"):
        RenderBehaviorTree(TREE, [7] * 9)


def test_without_graphviz_there_is_text(monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    drawing = RenderBehaviorTree(TREE)
    assert drawing._repr_mimebundle_() == {"text/plain": drawing.text}
    with pytest.raises(RuntimeError, match="install Graphviz"):
        drawing.save(tmp_path / "tree.svg")
    drawing.save(tmp_path / "tree.txt")
    assert (tmp_path / "tree.txt").read_text().startswith("? Fallback")
    drawing.save(tmp_path / "tree.dot")
    assert (tmp_path / "tree.dot").read_text().startswith("digraph")


def test_other_endings_are_told(tmp_path):
    with pytest.raises(ValueError, match=r"\.svg, \.png"):
        RenderBehaviorTree(TREE).save(tmp_path / "tree.gif")


@needs_dot
def test_graphviz_draws_all_nodes_and_edges():
    svg = RenderBehaviorTree(TREE)._repr_mimebundle_()["image/svg+xml"]
    assert svg.count('class="node"') == len(TREE.nodes)
    assert svg.count('class="edge"') == len(TREE.nodes) - 1
    assert "a &lt; b &amp; ü" in svg
    assert "running" not in svg


@needs_dot
def test_graphviz_shows_the_status_by_color_and_word():
    colors = {}
    for value in NodeStatus:
        svg = RenderBehaviorTree(TREE, [value] * 9)._drawn("svg").decode()
        shapes = r'<(?:polygon|ellipse|path) fill="(#\w+)"'
        # The other color is that of the arrows.
        (fill,) = set(re.findall(shapes, svg)) - {"#555555"}
        colors[value] = fill
        words = {0: "not ticked", 4: "skipped"}
        assert svg.count(words.get(value, value.name.lower())) == 9
    assert len(set(colors.values())) == len(NodeStatus)


@needs_dot
@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_saves_pictures(ending, tmp_path):
    path = tmp_path / f"tree.{ending}"
    RenderBehaviorTree(TREE).save(path)
    start = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[ending]
    assert path.read_bytes().startswith(start)


@pytest.mark.parametrize("name", BEHAVIORS)
def test_shipped_trees_can_be_drawn(name):
    tree = LoadTree(name)
    assert len(str(RenderBehaviorTree(tree)).splitlines()) == len(tree.nodes)
