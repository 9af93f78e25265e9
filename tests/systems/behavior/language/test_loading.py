"""Trees that cannot be loaded, and leaves that cannot be registered."""

import pytest

from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    LoadTree,
    ParseTree,
    register_action,
    register_condition,
)

WALK = "<root><BehaviorTree><RegularNav/></BehaviorTree></root>"


def test_unknown_behavior_names_the_nearest():
    with pytest.raises(BehaviorTreeError, match="did you mean 'regular'"):
        LoadTree("regulr")


@pytest.mark.parametrize("name", ["", "x" * 5000, "a\0b", "/", "/dev/zero"])
def test_what_is_no_file_is_told(name):
    with pytest.raises(BehaviorTreeError, match="no behavior or file"):
        LoadTree(name)


def test_missing_file_is_told(tmp_path):
    with pytest.raises(BehaviorTreeError, match=r"nowhere\.xml"):
        LoadTree(tmp_path / "nowhere.xml")


INCLUDES = {
    "missing": ('<include path="b.xml"/>', "no file"),
    "folder": ('<include path="."/>', "no file"),
    "outside": ('<include path="../b.xml"/>', "outside"),
    "absolute": ('<include path="/etc/passwd"/>', "outside"),
    "ros": ('<include ros_pkg="p" path="b.xml"/>', "no other"),
    "control characters": ('<include path="a&#9;b.xml"/>', "no file"),
}


@pytest.mark.parametrize("name", INCLUDES)
def test_bad_include_is_told(name, tmp_path):
    include, words = INCLUDES[name]
    (tmp_path / "b.xml").write_text(WALK)
    folder = tmp_path / "trees"
    folder.mkdir()
    main = folder / "a.xml"
    main.write_text(f"<root>\n{include}\n</root>")
    with pytest.raises(BehaviorTreeError, match=words) as caught:
        LoadTree(main)
    assert caught.value.place == (str(main), 2)
    assert caught.value.node == "include"


def test_link_out_of_the_folder_is_not_followed(tmp_path):
    (tmp_path / "b.xml").write_text(WALK)
    folder = tmp_path / "trees"
    folder.mkdir()
    (folder / "b.xml").symlink_to(tmp_path / "b.xml")
    (folder / "a.xml").write_text('<root><include path="b.xml"/></root>')
    with pytest.raises(BehaviorTreeError, match="outside"):
        LoadTree(folder / "a.xml")


def test_fault_in_an_included_file_names_that_file(tmp_path):
    (tmp_path / "a.xml").write_text(
        '<root main_tree_to_execute="B"><include path="b.xml"/></root>'
    )
    (tmp_path / "b.xml").write_text(
        '<root>\n<BehaviorTree ID="B"><Nonsense/></BehaviorTree></root>'
    )
    with pytest.raises(BehaviorTreeError) as caught:
        LoadTree(tmp_path / "a.xml")
    assert caught.value.place == (str(tmp_path / "b.xml"), 2)


def no_ports(context):
    return True


def bad_annotation(context, *, port: list):
    return True


def no_annotation(context, *, port):
    return True


def any_ports(context, **ports):
    return True


def two(context, own):
    return True


def bad_default(context, *, port: float = "x"):
    return True


REGISTRATIONS = {
    "taken": ("Sequence", no_ports, {}, "taken"),
    "taken by a leaf": ("RegularNav", no_ports, {}, "taken"),
    "a word of the language": ("SubTree", no_ports, {}, "taken"),
    "no name": ("my node", no_ports, {}, "letters and digits"),
    "annotation": ("TestLeaf", bad_annotation, {}, "port port must be"),
    "no annotation": ("TestLeaf", no_annotation, {}, "port port must be"),
    "ports without names": ("TestLeaf", any_ports, {}, "cannot be a port"),
    "memory not declared": ("TestLeaf", two, {}, "1 positional"),
    "memory not taken": ("TestLeaf", no_ports, {"a": 0.0}, "2 positional"),
    "default": ("TestLeaf", bad_default, {}, "valid number"),
}


@pytest.mark.parametrize("name", REGISTRATIONS)
@pytest.mark.parametrize("register", [register_action, register_condition])
def test_bad_registration_is_a_value_error(name, register):
    node, function, memory, words = REGISTRATIONS[name]
    with pytest.raises(ValueError, match=words):
        register(node, memory=memory)(function)


MINE = """<root BTCPP_format="4" main_tree_to_execute="Mine">
<include path="BT{}Nav.xml"/>
<BehaviorTree ID="Mine"><SubTree ID="{}NavTree"/></BehaviorTree></root>"""


@pytest.mark.parametrize("name", ["Regular", "Surprised", "Threatening"])
def test_trees_of_hunavsim_are_included_by_its_names(name, tmp_path):
    """Its files include them, and seldom have them beside themselves."""
    text = MINE.format(name, name)
    path = tmp_path / "mine.xml"
    path.write_text(text)
    ours = ParseTree(text.replace(f"BT{name}Nav", name.lower()))
    for tree in (ParseTree(text), LoadTree(path)):
        assert [it.name for it in tree.nodes] == [it.name for it in ours.nodes]


def test_a_tree_of_hunavsim_beside_the_file_is_taken(tmp_path):
    (tmp_path / "mine.xml").write_text(MINE.format("Regular", "Regular"))
    (tmp_path / "BTRegularNav.xml").write_text(
        '<root><BehaviorTree ID="RegularNavTree"><AlwaysFailure/>'
        "</BehaviorTree></root>"
    )
    tree = LoadTree(tmp_path / "mine.xml")
    assert tree.nodes[-1].type.name == "AlwaysFailure"
