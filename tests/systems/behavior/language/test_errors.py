"""Every fault in a tree is one BehaviorTreeError with its place."""

import itertools
import time

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    LoadTree,
    NodeStatus,
    ParseTree,
    Person,
    RenderBehaviorTree,
    TreePortError,
    WriteTree,
)
from hunav_drake.systems.people.human_config import HumanConfig

BOMB = """<!DOCTYPE root [
 <!ENTITY a "aaaaaaaaaa">
 <!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
]>
<root><BehaviorTree><RegularNav name="&b;"/></BehaviorTree></root>"""


def document(body):
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
        document('<RegularNav name="a" name="b"/>'),
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
    "unknown entity": (document('<RegularNav name="&x;"/>'), 3, "", "entity"),
    "too long": (b"<root>" + b" " * 2_000_000, 0, "", "1000000 bytes"),
    "too deep": (document(nested("Inverter", 5000)), 3, "Inverter", "100 deep"),
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
    "empty tree": (document(""), 2, "BehaviorTree", "exactly 1 node"),
    "two nodes at the top": (
        document("<RegularNav/><RegularNav/>"),
        2,
        "BehaviorTree",
        "has 2",
    ),
    # Nodes.
    "unknown node": (
        document("<IsGoalReachd/>"),
        3,
        "IsGoalReachd",
        "did you mean 'IsGoalReached'",
    ),
    "unknown node by ID": (
        document('<Action ID="RegularNaw"/>'),
        3,
        "RegularNaw",
        "did you mean 'RegularNav'",
    ),
    "node without ID": (document("<Action/>"), 3, "Action", "attribute ID"),
    "text": (
        document("<Sequence>RegularNav</Sequence>"),
        3,
        "Sequence",
        "the text 'RegularNav'",
    ),
    "control without children": (
        document("<Sequence/>"),
        3,
        "Sequence",
        "at least 1 children, has 0",
    ),
    "decorator without child": (
        document('<Inverter name="not"/>'),
        3,
        "not",
        "exactly 1 child, has 0",
    ),
    "decorator with two": (
        document("<Inverter><RegularNav/><RegularNav/></Inverter>"),
        3,
        "Inverter",
        "has 2",
    ),
    "leaf with child": (
        document("<RegularNav><UpdateGoal/></RegularNav>"),
        3,
        "RegularNav",
        "no children, has 1",
    ),
    "if without then": (
        document("<IfThenElse><IsGoalReached/></IfThenElse>"),
        3,
        "IfThenElse",
        "2 or 3 children, has 1",
    ),
    "while with too much": (
        document("<WhileDoElse>" + "<RegularNav/>" * 4 + "</WhileDoElse>"),
        3,
        "WhileDoElse",
        "has 4",
    ),
    "endless work": (
        document(nested("Repeat", 4, 'num_cycles="100"')),
        3,
        "Repeat",
        "at most 100000",
    ),
    # Ports.
    "unknown port": (
        document('<IsRobotVisible distance="4" field_of_wiev="1"/>'),
        3,
        "IsRobotVisible",
        "did you mean 'field_of_view'",
    ),
    "missing port": (
        document("<IsRobotVisible/>"),
        3,
        "IsRobotVisible",
        "distance must be given",
    ),
    "text for a number": (
        document('<IsRobotVisible distance="near"/>'),
        3,
        "IsRobotVisible",
        "valid number",
    ),
    "not a number": (
        document('<IsRobotVisible distance="nan"/>'),
        3,
        "IsRobotVisible",
        "finite number",
    ),
    "out of range": (
        document('<IsRobotVisible distance="-1"/>'),
        3,
        "IsRobotVisible",
        "[0, 100000] m, got -1",
    ),
    "fraction for an integer": (
        document('<Repeat num_cycles="2.5"><RegularNav/></Repeat>'),
        3,
        "Repeat",
        "valid integer",
    ),
    "word for a truth": (
        document('<TimeExpiredCondition only_once="maybe"/>'),
        3,
        "TimeExpiredCondition",
        "valid boolean",
    ),
    "unknown choice": (
        document('<RegularNav robot="wall"/>'),
        3,
        "RegularNav",
        "'pedestrian', 'obstacle' or 'unseen'",
    ),
    "threshold": (
        document('<Parallel success_count="2"><RegularNav/></Parallel>'),
        3,
        "Parallel",
        "at most 1",
    ),
    "switch without case": (
        document(
            '<Switch2 variable="a" case_1="a">' + "<RegularNav/>" * 3
        ).replace("</B", "</Switch2></B"),
        3,
        "Switch2",
        "case_2 must be given",
    ),
    "switch with too few": (
        document(
            '<Switch3 variable="a" case_1="a" case_2="b" case_3="c">'
            + "<RegularNav/>" * 3
            + "</Switch3>"
        ),
        3,
        "Switch3",
        "exactly 4 children, has 3",
    ),
    "switch of texts by numbers": (
        document(
            '<Switch2 variable="{id}" case_1="1" case_2="b">'
            + "<RegularNav/>" * 3
            + "</Switch2>"
        ),
        3,
        "Switch2",
        "the text 'b' needs a text",
    ),
    # Conditions.
    "unknown condition": (
        document('<RegularNav _skipif="true"/>'),
        3,
        "RegularNav",
        "did you mean '_skipIf'",
    ),
    "condition on a tree": (
        '<root>\n<BehaviorTree ID="A" _skipIf="true"><RegularNav/>'
        "</BehaviorTree></root>",
        2,
        "BehaviorTree",
        "no attribute '_skipIf'",
    ),
    "script with arithmetic": (
        document('<RegularNav _skipIf="id + 1 == 2"/>'),
        3,
        "RegularNav",
        "'+ 1 == 2' is not understood",
    ),
    "script that assigns where it should compare": (
        document('<RegularNav _skipIf="a = 1"/>'),
        3,
        "RegularNav",
        "'=' cannot be here",
    ),
    "script that compares where it should assign": (
        document('<RegularNav _onSuccess="id == 1"/>'),
        3,
        "RegularNav",
        "must be assignments",
    ),
    "script with an unknown entry": (
        document('<RegularNav _while="idd == 1"/>'),
        3,
        "RegularNav",
        "did you mean 'id'",
    ),
    "condition of a subtree": (
        trees(A='<SubTree ID="B" _whil="true"/>', B="<RegularNav/>"),
        2,
        "B",
        "did you mean '_while'",
    ),
    # The blackboard.
    "entry that nothing sets": (
        document(
            '<Sequence><SetBlackboard output_key="range" value="4"/>\n'
            '<IsRobotVisible distance="{rnge}"/></Sequence>'
        ),
        4,
        "IsRobotVisible",
        "did you mean 'range'",
    ),
    "entry without name": (
        document('<IsRobotVisible distance="{}"/>'),
        3,
        "IsRobotVisible",
        "named by letters",
    ),
    "text for a number on the blackboard": (
        document(
            '<Sequence><SetBlackboard output_key="a" value="hello"/>\n'
            '<IsRobotVisible distance="{a}"/></Sequence>'
        ),
        4,
        "IsRobotVisible",
        "the text 'hello' at my.xml:3",
    ),
    "number and text in an entry": (
        document(
            '<Sequence><SetBlackboard output_key="a" value="{dt}"/>\n'
            '<SetBlackboard output_key="a" value="hello"/></Sequence>'
        ),
        4,
        "SetBlackboard",
        "one or the other",
    ),
    "long text on the blackboard": (
        document(f'<SetBlackboard output_key="a" value="{"x" * 101}"/>'),
        3,
        "SetBlackboard",
        "100 letters",
    ),
    "number for a text": (
        document('<RegularNav robot="{id}"/>'),
        3,
        "RegularNav",
        "needs a text",
    ),
    "output without name": (
        document('<SetBlackboard output_key="a b" value="1"/>'),
        3,
        "SetBlackboard",
        "named by letters",
    ),
    # Subtrees.
    "subtree without ID": (
        document("<SubTree/>"),
        3,
        "SubTree",
        "attribute ID",
    ),
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
    "text of a subtree for an entry that is a number": (
        '<root BTCPP_format="4" main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><SubTree ID="B" d="far"/></BehaviorTree>\n'
        '<BehaviorTree ID="B"><Sequence><IsRobotVisible distance="{d}"/>'
        '<SetBlackboard output_key="d" value="1"/></Sequence>'
        "</BehaviorTree></root>",
        2,
        "SubTree",
        "the text 'far' needs a text",
    ),
    "port of a subtree that must be given": (
        '<root BTCPP_format="4" main_tree_to_execute="A">\n'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>\n'
        '<BehaviorTree ID="B"><IsRobotVisible distance="{d}"/></BehaviorTree>'
        '<TreeNodesModel><SubTree ID="B"><input_port name="d"/></SubTree>'
        "</TreeNodesModel></root>",
        2,
        "SubTree",
        "the port d must be given",
    ),
    "unknown port of a subtree": (
        trees(A='<SubTree ID="SurprisedNavTree" distanc="{id}"/>'),
        2,
        "SubTree",
        "did you mean 'distance'?",
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


# Files that include others, the file and line of the fault, and words.
FOLDERS = {
    "file in itself": (
        {"a.xml": '<root>\n<include path="a.xml"/></root>'},
        ("a.xml", 2),
        "a.xml -> a.xml",
    ),
    "files in each other": (
        {
            "a.xml": '<root><include path="b.xml"/></root>',
            "b.xml": '<root>\n\n<include path="./a.xml"/></root>',
        },
        ("b.xml", 3),
        "a.xml -> b.xml -> a.xml",
    ),
    "files in a ring": (
        {
            "a.xml": '<root><include path="b.xml"/></root>',
            "b.xml": '<root><include path="c.xml"/></root>',
            "c.xml": '<root>\n<include path="b.xml"/></root>',
        },
        ("c.xml", 2),
        "b.xml -> c.xml -> b.xml",
    ),
    "file that is not there": (
        {"a.xml": '<root>\n<include path="b.xml"/></root>'},
        ("a.xml", 2),
        "no file",
    ),
    "file outside": (
        {"a.xml": '<root>\n<include path="../b.xml"/></root>'},
        ("a.xml", 2),
        "outside",
    ),
    "bomb in an included file": (
        {"a.xml": '<root><include path="b.xml"/></root>', "b.xml": BOMB},
        ("b.xml", 1),
        "document type",
    ),
    "one ID in two files": (
        {
            "a.xml": '<root main_tree_to_execute="A"><include path="b.xml"/>\n'
            '<BehaviorTree ID="A"><RegularNav/></BehaviorTree></root>',
            "b.xml": '<root><BehaviorTree ID="A"><RegularNav/></BehaviorTree>'
            "</root>",
        },
        ("a.xml", 2),
        "already",
    ),
    "too many files": (
        {
            "a.xml": "<root>\n"
            + "".join(f'<include path="{i}.xml"/>' for i in range(101))
            + "</root>",
            **{f"{i}.xml": "<root/>" for i in range(101)},
        },
        ("a.xml", 2),
        "more than 100 files",
    ),
    "UTF-16 that ends in the middle": (
        {"a.xml": "<root/>".encode("utf-16")[:-1]},
        ("a.xml", 1),
        "not well-formed",
    ),
    "Latin letters said to be UTF-8": (
        {"a.xml": "<root>\n<!-- ä --></root>".encode("latin-1")},
        ("a.xml", 2),
        "not well-formed",
    ),
}


def test_there_are_enough_faults():
    assert len(FAULTS) + len(FOLDERS) >= 60


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_told_with_its_place(name):
    source, line, node, words = FAULTS[name]
    started = time.process_time()
    with pytest.raises(BehaviorTreeError) as caught:
        ParseTree(source, name="my.xml")
    # The largest of them take a tenth of it.
    assert time.process_time() - started < 2
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


# (A file may have includes.)
IN_FILES = sorted(FAULTS.keys() - {"include from a text"})


@pytest.mark.parametrize("name", IN_FILES)
def test_fault_in_a_file_names_the_file(name, tmp_path):
    source, line, _, _ = FAULTS[name]
    path = tmp_path / "tree.xml"
    path.write_bytes(source.encode() if isinstance(source, str) else source)
    with pytest.raises(BehaviorTreeError) as caught:
        LoadTree(path)
    assert caught.value.place.file == str(path)
    if line:
        assert str(caught.value).startswith(f"{path}:{line}: ")


@pytest.mark.parametrize("name", FOLDERS)
def test_fault_among_files_names_the_file_and_line(name, tmp_path):
    files, (file, line), words = FOLDERS[name]
    for other, source in files.items():
        if isinstance(source, str):
            source = source.encode()
        (tmp_path / other).write_bytes(source)
    with pytest.raises(BehaviorTreeError) as caught:
        LoadTree(tmp_path / "a.xml")
    assert words in str(caught.value)
    assert caught.value.place == (str(tmp_path / file), line)


def test_text_of_no_character_is_a_fault_of_the_tree():
    with pytest.raises(BehaviorTreeError, match=r"<text>:3.*not well-formed"):
        ParseTree(document("\ud800"))


def test_value_of_a_port_that_no_node_uses_is_refused():
    source = (
        '<root BTCPP_format="4"><BehaviorTree ID="A"><RegularNav/>'
        '</BehaviorTree><TreeNodesModel><SubTree ID="A"><input_port name="d"'
        ' default="1"/></SubTree></TreeNodesModel></root>'
    )
    ParseTree(source)
    with pytest.raises(TreePortError, match="no node of the tree uses it"):
        ParseTree(source, ports={"d": 2})
    # What must be given may be given.
    ParseTree(source.replace(' default="1"', ""), ports={"d": 2})


def test_an_output_port_of_a_subtree_is_known():
    ParseTree(
        '<root BTCPP_format="4" main_tree_to_execute="A"><BehaviorTree ID="A">'
        '<SubTree ID="B" d="2" r="{x}"/></BehaviorTree><BehaviorTree ID="B">'
        '<RegularNav/></BehaviorTree><TreeNodesModel><SubTree ID="B">'
        '<input_port name="d" default="1"/><output_port name="r"/></SubTree>'
        "</TreeNodesModel></root>"
    )


def test_nodes_nested_by_subtrees_are_bounded():
    names = [f"T{i}" for i in range(30)]
    bodies = {
        a: "<Inverter>" * 5 + f'<SubTree ID="{b}"/>' + "</Inverter>" * 5
        for a, b in itertools.pairwise(names)
    }
    source = trees(A='<SubTree ID="T0"/>', **bodies, T29="<RegularNav/>")
    with pytest.raises(BehaviorTreeError, match="nested more than 100 deep"):
        ParseTree(source)


def test_deepest_accepted_tree_with_conditions_works():
    """Python's own limit of nested calls is farther away."""
    conditions = "_skipIf=\"n == 'b'\" _onSuccess=\"n := 'b'\""
    dut = ParseTree(
        document(
            '<Sequence><SetBlackboard output_key="n" value="a"/>'
            f"{nested('Inverter', 96, conditions)}</Sequence>"
        )
    )
    person = Person.from_config(
        HumanConfig(pose=(0.0, 0.0, 0.0)), 0, time_step=0.1
    )
    outcome, _ = dut.trace(
        person, dut.initial_memory(person), np.zeros(7), np.zeros(7)
    )
    assert outcome.node_status is NodeStatus.SUCCESS
    assert ParseTree(WriteTree(dut)).slots == dut.slots
    assert len(str(RenderBehaviorTree(dut)).splitlines()) == len(dut.nodes)


def test_deepest_accepted_tree_ticks():
    dut = ParseTree(document(nested("Inverter", 97)))
    person = Person.from_config(
        HumanConfig(pose=(0.0, 0.0, 0.0)), 0, time_step=0.1
    )
    outcome, _ = dut.trace(
        person, dut.initial_memory(person), np.zeros(7), np.zeros(7)
    )
    assert outcome.node_status is NodeStatus.FAILURE
