"""A tree is parsed once, and anew when anything that it is made of changes."""

import pytest

from hunav_drake import HumanConfig, MakeHumans
from hunav_drake.systems.behavior import (
    BehaviorConfig,
    CheckBehavior,
    LoadBehavior,
    LoadTree,
    ParseTree,
    library,
    register_condition,
    tree_fingerprint,
)

INNER = """<root BTCPP_format="4"><BehaviorTree ID="Look">
<IsRobotVisible distance="3.0"/></BehaviorTree></root>"""
OUTER = """<root BTCPP_format="4" main_tree_to_execute="Main">
<include path="inner.xml"/>
<BehaviorTree ID="Main"><Fallback><SubTree ID="Look"/>
<RegularNav ignore_robot="{blind}"/></Fallback></BehaviorTree>
<TreeNodesModel><SubTree ID="Main">
<input_port name="blind" type="bool" default="false"/>
</SubTree></TreeNodesModel></root>"""


@pytest.fixture
def parses(monkeypatch):
    """The list of the trees that are parsed, from an empty cache on."""
    library._parse.cache_clear()
    parsed = []
    parse = library.parse_documents

    def count(documents, *args):
        parsed.append(documents.main)
        return parse(documents, *args)

    monkeypatch.setattr(library, "parse_documents", count)
    yield parsed
    library._parse.cache_clear()


@pytest.fixture
def file(tmp_path):
    (tmp_path / "inner.xml").write_text(INNER)
    (tmp_path / "outer.xml").write_text(OUTER)
    return tmp_path / "outer.xml"


def test_people_of_one_behavior_share_one_parse(parses):
    config = BehaviorConfig(type="curious", ports={"distance": 4.0})
    humans = [
        HumanConfig(pose=(i, 0, 0), behavior=behavior)
        for i, behavior in enumerate(["curious", config, "regular"] * 10)
    ]
    trees = MakeHumans(humans).GetSubsystemByName("behaviors").trees()
    assert len(parses) == 3
    assert len({id(tree) for tree in trees}) == 3


def test_checks_and_fingerprints_parse_nothing_anew(parses, file):
    behavior = BehaviorConfig(type=str(file), ports={"blind": True})
    tree = LoadBehavior(behavior)
    assert not list(CheckBehavior(behavior))
    tree_fingerprint(behavior)
    assert LoadTree(file, {"blind": True}) is tree
    assert parses == ["Main"]


def test_text_is_parsed_once(parses):
    assert ParseTree(INNER) is ParseTree(INNER.encode())
    assert ParseTree(INNER, name="other").file == "other"
    assert parses == ["Look", "Look"]


def test_other_values_of_ports_are_another_tree(parses, file):
    trees = [LoadTree(file, {"blind": blind}) for blind in (False, True)]
    assert [tree.values["blind"] for tree in trees] == ["false", "true"]
    assert len(parses) == 2


@pytest.mark.parametrize("name", ["outer.xml", "inner.xml"])
def test_file_that_has_changed_is_read_anew(parses, file, name):
    before = LoadTree(file)
    changed = file.with_name(name)
    text = changed.read_text()
    changed.write_text(text.replace("3.0", "5.0").replace("false", "true"))
    after = LoadTree(file)
    assert after is not before
    assert after.Describe() != before.Describe()
    changed.write_text(text)
    assert LoadTree(file) is before
    assert len(parses) == 2


@pytest.mark.usefixtures("node_types")
def test_leaf_that_is_registered_anew_is_used(parses):
    xml = "<root><BehaviorTree><IsMoody/></BehaviorTree></root>"
    trees = []
    for _ in range(2):

        @register_condition("IsMoody", replace=True)
        def is_moody(context) -> bool:
            return True

        trees.append(ParseTree(xml))
    leaves = [tree.root.type.function for tree in trees]
    assert leaves[0] is not leaves[1]
    assert leaves[1] is is_moody
    assert len(parses) == 2


def test_fault_is_found_each_time():
    for _ in range(2):
        with pytest.raises(ValueError, match="there is no node 'Regular'"):
            ParseTree("<root><BehaviorTree><Regular/></BehaviorTree></root>")
