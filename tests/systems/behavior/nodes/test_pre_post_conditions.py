"""The conditions before and after a node, and the scripts in them."""

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    NodeStatus,
    ParseTree,
    register_action,
)
from tests.systems.behavior.ticks import traces

SUCCESS, FAILURE = NodeStatus.SUCCESS, NodeStatus.FAILURE
RUNNING, SKIPPED = NodeStatus.RUNNING, NodeStatus.SKIPPED


@pytest.fixture(autouse=True)
def leaves(node_types):
    """Registers the leaves of these tests."""

    @register_action("Run", memory={"ticks": 0.0})
    def run(context, own, *, ticks: int = 1000):
        own[0] += 1
        return RUNNING if own[0] <= ticks else SUCCESS


def parse_after_entries(body):
    # Sets the entries that the conditions below name, in its first tick.
    return ParseTree(
        '<root BTCPP_format="4"><BehaviorTree ID="T"><Sequence><ForceSuccess>'
        '<RunOnce><Sequence><SetBlackboard output_key="n" value="2"/>'
        '<SetBlackboard output_key="off" value="false"/>'
        '<SetBlackboard output_key="mode" value="shy"/></Sequence></RunOnce>'
        f"</ForceSuccess>{body}</Sequence></BehaviorTree></root>"
    )


def run_last_node(tree, count=1, memory=None):
    """Returns what the last node of the sequence says, and the memories."""
    index = tree.nodes.index(tree.root.children[-1])
    said, memories = [], []
    for outcome, statuses in traces(tree, count, memory):
        said.append(statuses[index])
        memories.append(dict(zip(tree.slots, outcome.memory, strict=True)))
    return said, memories


def text(tree, memories, key):
    return tree.texts[int(memories[-1][key])]


@pytest.mark.parametrize(
    ("conditions", "expected"),
    [
        ('_failureIf="true"', FAILURE),
        ('_successIf="true"', SUCCESS),
        ('_skipIf="true"', SKIPPED),
        ('_while="false"', SKIPPED),
        ('_failureIf="false"', RUNNING),
        ('_successIf="off"', RUNNING),
        ('_skipIf="off"', RUNNING),
        ('_while="n"', RUNNING),
        # In this order.
        ('_while="false" _successIf="true" _skipIf="true"', SUCCESS),
        ('_skipIf="true" _failureIf="true" _successIf="true"', FAILURE),
        ('_while="false" _skipIf="true"', SKIPPED),
    ],
)
def test_condition_before_says_the_result(conditions, expected):
    dut = parse_after_entries(f"<Run {conditions}/>")
    said, memories = run_last_node(dut)
    assert said == [expected]
    # The node itself was ticked or not.
    assert memories[-1]["Run: ticks"] == (expected is RUNNING)


@pytest.mark.parametrize(
    ("script", "expected"),
    [
        ("n == 2", True),
        ("n != 2", False),
        ("n < 2", False),
        ("n <= 2", True),
        ("2 > n", False),
        ("n >= 2.0", True),
        ("n == -2", False),
        ("n == 2e0", True),
        (".5 < 1.", True),
        ("mode == 'shy'", True),
        ("'bold' == mode", False),
        ("mode != 'bold'", True),
        ("mode == ''", False),
        ("'a' == 'a'", True),
        ("!off", True),
        ("!!off", False),
        ("off == false", True),
        ("!off == true", True),
        ("off || n == 2", True),
        ("off && nothing", False),
        ("n || nothing", True),
        ("true || false && false", True),
        ("(true || false) && false", False),
        ("!(n > 1 && mode == 'shy')", False),
        ("  n==2&&!off  ", True),
        ("id == 7", True),
        ("dt < 0.2 && dt > 0.05", True),
        ("(n == 2) == true", True),
    ],
)
def test_script_is_what_it_says(script, expected):
    script = script.replace("&", "&amp;").replace("<", "&lt;")
    # (The entry `nothing` is never set: what is not needed is not read.)
    dut = parse_after_entries(
        f'<Fallback><AlwaysSuccess _failureIf="!({script})"/>'
        '<Sequence _skipIf="true">'
        '<SetBlackboard output_key="nothing" value="1"/></Sequence></Fallback>'
    )
    said, _ = run_last_node(dut)
    assert said == [SUCCESS if expected else FAILURE]


def test_while_halts_what_runs():
    dut = parse_after_entries(
        '<Parallel success_count="1">'
        '<Run _while="mode == \'shy\'" _onHalted="n := 7"/>'
        '<Delay delay_msec="200"><Fallback><Inverter>'
        '<SetBlackboard output_key="mode" value="bold"/></Inverter>'
        '<Run name="other"/></Fallback></Delay></Parallel>'
    )
    _, memories = run_last_node(dut, 4)
    assert [m["Run: ticks"] for m in memories] == [1, 2, 3, 0]
    assert [m["{n}"] for m in memories] == [2, 2, 2, 7]
    assert text(dut, memories, "{mode}") == "bold"


def test_conditions_before_are_not_checked_while_the_node_runs():
    dut = parse_after_entries(
        '<Parallel success_count="2"><Run ticks="3" _skipIf="n == 9"/>'
        '<SetBlackboard output_key="n" value="9"/></Parallel>'
    )
    assert run_last_node(dut, 4)[0] == [RUNNING] * 3 + [SUCCESS]


def test_conditions_before_are_checked_anew_when_the_node_begins_anew():
    dut = parse_after_entries(
        '<Run ticks="1" _skipIf="n == 9" _onSuccess="n := 9"/>'
    )
    said, _ = run_last_node(dut, 4)
    assert said == [RUNNING, SUCCESS, SKIPPED, SKIPPED]


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ("AlwaysSuccess", {"{n}": 10, "{p}": 1}),
        ("AlwaysFailure", {"{n}": 20, "{p}": 1}),
        ('AlwaysSuccess _successIf="true"', {"{n}": 10, "{p}": 1}),
        ('AlwaysSuccess _failureIf="true"', {"{n}": 20, "{p}": 1}),
        ('AlwaysSuccess _skipIf="true"', {"{n}": 2, "{p}": -np.inf}),
        ("Run", {"{n}": 2, "{p}": -np.inf}),
    ],
)
def test_conditions_after_follow_the_result(node, expected):
    dut = parse_after_entries(
        f'<{node} _onSuccess="n := 10" _onFailure="n = 20" _post="p := true"/>'
    )
    _, memories = run_last_node(dut)
    assert {key: memories[0][key] for key in expected} == expected


def test_assignments_take_values_entries_and_comparisons():
    dut = parse_after_entries(
        "<AlwaysSuccess _onSuccess=\"a := n; mode := 'bold'; b := n > 1;"
        ' copy = mode;"/>'
    )
    _, memories = run_last_node(dut)
    assert memories[0]["{a}"] == 2
    assert memories[0]["{b}"] == 1
    assert text(dut, memories, "{mode}") == "bold"
    assert text(dut, memories, "{copy}") == "bold"


def test_halting_is_told_once_and_only_to_what_runs():
    dut = parse_after_entries(
        '<ReactiveFallback><Inverter><Run ticks="0" name="now"/></Inverter>'
        '<Run _onHalted="n := 5"/></ReactiveFallback>'
    )
    assert run_last_node(dut, 3)[1][-1]["{n}"] == 2
    dut = parse_after_entries(
        '<ReactiveFallback><Delay delay_msec="100"><RunOnce>'
        '<AlwaysFailure/></RunOnce></Delay><Run _onHalted="n := 5"/>'
        "</ReactiveFallback>"
    )
    assert run_last_node(dut, 1)[1][-1]["{n}"] == 2


def test_subtree_has_conditions_in_the_scope_around_it():
    dut = ParseTree(
        '<root BTCPP_format="4" main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><Sequence>'
        '<SetBlackboard output_key="n" value="1"/>'
        '<SubTree ID="B" _skipIf="n == 1"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="B"><Sequence>'
        '<SetBlackboard output_key="n" value="3"/><AlwaysFailure/></Sequence>'
        "</BehaviorTree></root>"
    )
    assert run_last_node(dut)[0] == [SKIPPED]
    assert [s for s in dut.slots if "{n}" in s] == ["{n}", "{n} of B"]


def test_constant_of_a_subtree_in_a_script():
    dut = ParseTree(
        '<root BTCPP_format="4" main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><Sequence>'
        '<SubTree ID="B" k="shy" m="4"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="B">'
        "<AlwaysSuccess _failureIf=\"k == 'shy' &amp;&amp; m > 3\"/>"
        "</BehaviorTree></root>"
    )
    assert run_last_node(dut)[0] == [FAILURE]


def test_memory_is_only_where_it_is_needed():
    with_result = parse_after_entries('<AlwaysSuccess _onSuccess="n := 1"/>')
    with_start = parse_after_entries('<AlwaysSuccess _skipIf="n == 1"/>')
    assert "AlwaysSuccess: (runs)" not in with_result.slots
    assert "AlwaysSuccess: (runs)" in with_start.slots


def test_entry_that_is_not_set_yet_is_told():
    dut = parse_after_entries(
        '<AlwaysSuccess _skipIf="late" _onSuccess="late := 1"/>'
    )
    with pytest.raises(BehaviorTreeError, match=r"nothing has set \{late\}"):
        run_last_node(dut)


SCRIPTS = {
    "arithmetic": ('_skipIf="n + 1 == 2"', "'+ 1 == 2'"),
    "braces": ('_skipIf="{n} == 2"', "'{n} == 2'"),
    "double quotes": ("_skipIf='mode == \"shy\"'", "is not understood"),
    "open text": ('_skipIf="mode == \'shy"', "is not understood"),
    "nothing": ('_skipIf=""', "ends too early"),
    "half": ('_skipIf="n =="', "ends too early"),
    "assignment before": ('_skipIf="n := 2"', "':=' cannot be here"),
    "chain": ('_skipIf="1 == n == 2"', "'==' cannot be here"),
    "two values": ('_skipIf="n n"', "'n' cannot be here"),
    "open bracket": ('_skipIf="(n == 2"', "ends too early"),
    "bracket": ('_skipIf="n)"', "')' cannot be here"),
    "single &": ('_skipIf="n &amp; 1"', "is not understood"),
    "text as truth": ("_skipIf=\"'yes'\"", "_skipIf needs a number"),
    "text and number": ("_skipIf=\"n > 1 || n == 'two'\"", "one type"),
    "number for a text": ('_skipIf="mode == 2"', "one type"),
    "order of texts": ("_skipIf=\"mode &lt; 'x'\"", "< needs a number"),
    "unknown entry": ('_skipIf="moed"', "did you mean 'mode'"),
    "comparison after": ('_onSuccess="n == 2"', "assignments"),
    "value after": ('_onSuccess="n"', "assignments"),
    "assignment to a number": ('_onSuccess="2 := n"', "assignments"),
    "assignment of nothing": ('_onSuccess="n := "', "ends too early"),
    "no semicolon": ('_onSuccess="n := 2 n := 3"', "'n' cannot be here"),
    "other type": ("_skipIf='n' _onSuccess=\"n := 'two'\"", "one type"),
    "unknown condition": ('_skipif="n == 2"', "did you mean '_skipIf'"),
    "deep": (f'_skipIf="{"(" * 30}n{")" * 30}"', "20 deep"),
    "very deep": (f'_skipIf="{"!" * 900}n"', "20 deep"),
    "long": (f'_skipIf="{"n || " * 400}n"', "1000 letters"),
    "long text": (f"_onSuccess=\"mode := '{'x' * 200}'\"", "100 letters"),
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_script_that_cannot_be_is_told(name):
    conditions, words = SCRIPTS[name]
    with pytest.raises(BehaviorTreeError) as caught:
        parse_after_entries(f"<AlwaysSuccess {conditions}/>")
    assert words in str(caught.value)
    assert caught.value.node == "AlwaysSuccess"
    assert caught.value.place.line == 1
