"""Every fault in a tree is one BehaviorTreeError with its place."""

import itertools

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    ParseTree,
    Person,
    Status,
)
from hunav_drake.systems.crowd.human_config import HumanConfig

BOMB = """<!DOCTYPE root [
 <!ENTITY a "aaaaaaaaaa">
 <!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
]>
<root><BehaviorTree><RegularNav name="&b;"/></BehaviorTree></root>"""


def tree(body):
    """Returns a document with a node in line 3."""
    return f"<root>\n<BehaviorTree>\n{body}\n</BehaviorTree></root>"


def trees(**bodies):
    """Returns a document with the tree A as the main one, a line each."""
    lines = [
        f'<BehaviorTree ID="{name}">{body}</BehaviorTree>'
        for name, body in bodies.items()
    ]
    text = "\n".join(lines)
    return f'<root main_tree_to_execute="A">\n{text}\n</root>'


def subtree_bomb():
    names = "ABCDEFGH"
    bodies = {
        a: "<Sequence>" + f'<SubTree ID="{b}"/>' * 8 + "</Sequence>"
        for a, b in itertools.pairwise(names)
    }
    return trees(**bodies, H="<RegularNav/>")


def nested(tag, depth, attributes=""):
    start = f"<{tag} {attributes}>"
    return start * depth + "<AlwaysSuccess/>" + f"</{tag}>" * depth


# A document, the line of its fault, the node named, and words of the message.
FAULTS = {
    # Not a tree file.
    "empty": ("", 1, "", "no element found"),
    "not XML": ("behavior: regular", 1, "", "not well-formed"),
    "binary": (b"\x00\x01\xff\xfe\x80", 1, "", "not well-formed"),
    "wrong encoding": (
        b'<?xml version="1.0" encoding="UTF-8"?>\n<root a="\xff"/>',
        2,
        "",
        "not well-formed",
    ),
    "unknown encoding": (
        b'<?xml version="1.0" encoding="klingon"?><root/>',
        1,
        "",
        "unknown encoding",
    ),
    "tag left open": (
        "<root>\n<BehaviorTree>\n<Sequence>\n</BehaviorTree></root>",
        4,
        "",
        "mismatched tag",
    ),
    "cut off": ("<root>\n<BehaviorTree>\n", 3, "", "no element found"),
    "two roots": ("<root/>\n<root/>", 2, "", "junk after document"),
    "attribute twice": (
        tree('<RegularNav name="a" name="b"/>'),
        3,
        "",
        "duplicate attribute",
    ),
    "entity bomb": (BOMB, 1, "", "document type"),
    "external entity": (
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><root/>',
        1,
        "",
        "document type",
    ),
    "unknown entity": (tree('<RegularNav name="&x;"/>'), 3, "", "entity"),
    "too long": (b"<root>" + b" " * 2_000_000, 0, "", "1000000 bytes"),
    "too deep": (tree(nested("Inverter", 5000)), 3, "Inverter", "100 deep"),
    # The frame.
    "other root": ("<tree/>", 1, "tree", "must be <root>"),
    "unknown format": (
        '<root BTCPP_format="5"/>',
        1,
        "root",
        "must be 3 or 4, got '5'",
    ),
    "unknown root attribute": (
        '<root main_tree="A"/>',
        1,
        "root",
        "'main_tree_to_execute'",
    ),
    "unknown part": (
        "<root>\n<BehaviourTree/></root>",
        2,
        "BehaviourTree",
        "did you mean 'BehaviorTree'",
    ),
    "no tree": ("<root></root>", 1, "root", "there is none"),
    "which tree": (
        "<root>\n"
        '<BehaviorTree ID="A"><RegularNav/></BehaviorTree>\n'
        '<BehaviorTree ID="B"><RegularNav/></BehaviorTree></root>',
        1,
        "root",
        "there is A, B",
    ),
    "main tree unknown": (
        '<root main_tree_to_execute="MainTre">\n'
        '<BehaviorTree ID="MainTree"><RegularNav/></BehaviorTree></root>',
        1,
        "root",
        "did you mean 'MainTree'",
    ),
    "two trees of one name": (
        '<root main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><RegularNav/></BehaviorTree>\n'
        '<BehaviorTree ID="A"><RegularNav/></BehaviorTree></root>',
        3,
        "BehaviorTree",
        "already",
    ),
    "tree without name": (
        '<root main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><RegularNav/></BehaviorTree>\n'
        "<BehaviorTree><RegularNav/></BehaviorTree></root>",
        3,
        "BehaviorTree",
        "must have an ID",
    ),
    "tree named as a node": (
        trees(A='<SubTree ID="RegularNav"/>', RegularNav="<AlwaysSuccess/>"),
        3,
        "BehaviorTree",
        "name of a node",
    ),
    "tree attribute": (
        '<root><BehaviorTree IDD="A"><RegularNav/></BehaviorTree></root>',
        1,
        "BehaviorTree",
        "did you mean 'ID'",
    ),
    "empty tree": (tree(""), 2, "BehaviorTree", "exactly 1 node"),
    "two nodes at the top": (
        tree("<RegularNav/><RegularNav/>"),
        2,
        "BehaviorTree",
        "has 2",
    ),
    # Nodes.
    "unknown node": (
        tree("<IsGoalReachd/>"),
        3,
        "IsGoalReachd",
        "did you mean 'IsGoalReached'",
    ),
    "unknown node by ID": (
        tree('<Action ID="RegularNaw"/>'),
        3,
        "RegularNaw",
        "did you mean 'RegularNav'",
    ),
    "node without ID": (tree("<Action/>"), 3, "Action", "attribute ID"),
    "text": (
        tree("<Sequence>RegularNav</Sequence>"),
        3,
        "Sequence",
        "the text 'RegularNav'",
    ),
    "control without children": (
        tree("<Sequence/>"),
        3,
        "Sequence",
        "at least 1 children, has 0",
    ),
    "decorator without child": (
        tree('<Inverter name="not"/>'),
        3,
        "not",
        "exactly 1 child, has 0",
    ),
    "decorator with two": (
        tree("<Inverter><RegularNav/><RegularNav/></Inverter>"),
        3,
        "Inverter",
        "has 2",
    ),
    "leaf with child": (
        tree("<RegularNav><UpdateGoal/></RegularNav>"),
        3,
        "RegularNav",
        "no children, has 1",
    ),
    "if without then": (
        tree("<IfThenElse><IsGoalReached/></IfThenElse>"),
        3,
        "IfThenElse",
        "2 or 3 children, has 1",
    ),
    "while with too much": (
        tree("<WhileDoElse>" + "<RegularNav/>" * 4 + "</WhileDoElse>"),
        3,
        "WhileDoElse",
        "has 4",
    ),
    "endless work": (
        tree(nested("Repeat", 4, 'num_cycles="100"')),
        3,
        "Repeat",
        "at most 100000",
    ),
    # Ports.
    "unknown port": (
        tree('<IsRobotVisible distance="4" field_of_wiev="1"/>'),
        3,
        "IsRobotVisible",
        "did you mean 'field_of_view'",
    ),
    "missing port": (
        tree("<IsRobotVisible/>"),
        3,
        "IsRobotVisible",
        "distance must be given",
    ),
    "text for a number": (
        tree('<IsRobotVisible distance="near"/>'),
        3,
        "IsRobotVisible",
        "valid number",
    ),
    "not a number": (
        tree('<IsRobotVisible distance="nan"/>'),
        3,
        "IsRobotVisible",
        "finite number",
    ),
    "out of range": (
        tree('<IsRobotVisible distance="-1"/>'),
        3,
        "IsRobotVisible",
        "[0, 100000] m, got -1",
    ),
    "fraction for an integer": (
        tree('<Repeat num_cycles="2.5"><RegularNav/></Repeat>'),
        3,
        "Repeat",
        "valid integer",
    ),
    "word for a truth": (
        tree('<TimeExpiredCondition only_once="maybe"/>'),
        3,
        "TimeExpiredCondition",
        "valid boolean",
    ),
    "unknown choice": (
        tree('<RegularNav robot="wall"/>'),
        3,
        "RegularNav",
        "'pedestrian', 'obstacle' or 'unseen'",
    ),
    "threshold": (
        tree('<Parallel success_count="2"><RegularNav/></Parallel>'),
        3,
        "Parallel",
        "at most 1",
    ),
    "precondition": (
        tree('<RegularNav _skipIf="a == 1"/>'),
        3,
        "RegularNav",
        "_skipIf is not supported",
    ),
    # The blackboard.
    "entry that nothing sets": (
        tree(
            '<Sequence><SetBlackboard output_key="range" value="4"/>\n'
            '<IsRobotVisible distance="{rnge}"/></Sequence>'
        ),
        4,
        "IsRobotVisible",
        "did you mean 'range'",
    ),
    "entry without name": (
        tree('<IsRobotVisible distance="{}"/>'),
        3,
        "IsRobotVisible",
        "named by letters",
    ),
    "text on the blackboard": (
        tree('<SetBlackboard output_key="a" value="hello"/>'),
        3,
        "SetBlackboard",
        "valid number",
    ),
    "number for a text": (
        tree(
            '<Sequence><SetBlackboard output_key="r" value="1"/>'
            '<RegularNav robot="{r}"/></Sequence>'
        ),
        3,
        "RegularNav",
        "must be a text",
    ),
    "output without name": (
        tree('<SetBlackboard output_key="a b" value="1"/>'),
        3,
        "SetBlackboard",
        "named by letters",
    ),
    # Subtrees.
    "subtree without ID": (tree("<SubTree/>"), 3, "SubTree", "attribute ID"),
    "unknown subtree": (
        trees(A='<SubTree ID="Bee"/>', Be="<RegularNav/>"),
        2,
        "SubTree",
        "did you mean 'Be'",
    ),
    "subtree with child": (
        trees(A='<SubTree ID="B"><RegularNav/></SubTree>', B="<RegularNav/>"),
        2,
        "SubTree",
        "cannot have children",
    ),
    "tree in itself": (
        trees(A='<Inverter><SubTree ID="A"/></Inverter>'),
        2,
        "SubTree",
        "A -> A",
    ),
    "trees in each other": (
        trees(A='<SubTree ID="B"/>', B='<SubTree ID="A"/>'),
        3,
        "SubTree",
        "A -> B -> A",
    ),
    "subtree bomb": (subtree_bomb(), 0, "", "more than 5000 nodes"),
    "literal of a subtree": (
        '<root BTCPP_format="4" main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><SubTree ID="B" d="far"/></BehaviorTree>\n'
        '<BehaviorTree ID="B"><IsRobotVisible distance="{d}"/></BehaviorTree>'
        "</root>",
        3,
        "IsRobotVisible",
        "valid number",
    ),
    "text of a subtree for an entry that changes": (
        '<root BTCPP_format="4" main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><SubTree ID="B" d="far"/></BehaviorTree>\n'
        '<BehaviorTree ID="B"><SetBlackboard output_key="d" value="1"/>'
        "</BehaviorTree></root>",
        2,
        "SubTree",
        "valid number",
    ),
    "autoremap": (
        trees(A='<SubTree ID="B" _autoremap="2"/>', B="<RegularNav/>"),
        2,
        "SubTree",
        "true or false",
    ),
    "include from a text": (
        '<root>\n<include path="a.xml"/></root>',
        2,
        "include",
        "load a file",
    ),
    "include without path": ("<root>\n<include/></root>", 2, "include", "path"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_told_with_its_place(name):
    source, line, node, words = FAULTS[name]
    with pytest.raises(BehaviorTreeError) as caught:
        ParseTree(source, name="my.xml")
    error = caught.value
    assert words in str(error)
    assert error.place.file == "my.xml"
    assert str(error).startswith("my.xml")
    if line:
        assert error.place.line == line
    if node:
        assert error.node == node
        assert f"<{node}>" in str(error)
    if "did you mean" in words:
        assert error.nearest == words.split("'")[1]


def test_nodes_nested_by_subtrees_are_bounded():
    names = [f"T{i}" for i in range(30)]
    bodies = {
        a: "<Inverter>" * 5 + f'<SubTree ID="{b}"/>' + "</Inverter>" * 5
        for a, b in itertools.pairwise(names)
    }
    source = trees(A='<SubTree ID="T0"/>', **bodies, T29="<RegularNav/>")
    with pytest.raises(BehaviorTreeError, match="nested more than 100 deep"):
        ParseTree(source)


def test_deepest_accepted_tree_ticks():
    dut = ParseTree(tree(nested("Inverter", 97)))
    person = Person.from_config(
        HumanConfig(pose=(0.0, 0.0, 0.0)), 0, time_step=0.1
    )
    outcome, _ = dut.trace(
        person, dut.initial_memory(person), np.zeros(7), np.zeros(7)
    )
    assert outcome.status is Status.FAILURE
