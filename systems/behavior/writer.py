"""Writes trees as XML in format 4 of BehaviorTree.CPP, as for Groot2."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

from hunav_drake.systems.behavior.language.blackboard import reference
from hunav_drake.systems.behavior.language.documents import (
    Documents,
    TreeElement,
)
from hunav_drake.systems.behavior.language.parser import (
    AUTOREMAP,
    SHARED,
    flag,
    node_name,
    subtree_ports,
)
from hunav_drake.systems.behavior.language.xml_source import NOTES, XmlElement
from hunav_drake.systems.behavior.library import LoadTree
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.registry import (
    GENERIC_TAGS,
    NODE_TYPES,
    PORT_ALIASES,
    SUBTREE_TAGS,
)
from hunav_drake.systems.behavior.tree import Tree

_INDENT = "  "

# What the types of ports are called in C++.
_CPP_TYPES = {float: "double", int: "int", bool: "bool", str: "std::string"}


def ConvertTree(name_or_path: str | Path) -> str:
    """Returns a tree file in format 4, with its includes written into it.

    The tree of the result ticks like that of the file. Comments stay.

    Args:
        name_or_path: As for `LoadTree`; a file in format 3 or 4.

    Raises:
        BehaviorTreeError: As `LoadTree`, and as `WriteTree`.
    """
    return WriteTree(LoadTree(name_or_path))


def WriteTree(tree: Tree | Documents) -> str:
    """Returns the XML, in format 4, of a tree and of its subtrees.

    No file is written. The XML begins with the main tree, and ends with a
    <TreeNodesModel>, by which Groot2 knows the leaves. Values that were given
    for ports when the tree was loaded are not in it.

    Args:
        tree: The tree, or the documents of one.

    Raises:
        BehaviorTreeError: If a subtree of format 3 shares the blackboard and
            names an entry with an underscore, which format 4 keeps apart.
    """
    documents = tree.documents if isinstance(tree, Tree) else tree
    names = _tree_names(documents)
    main = documents.main
    order = [main, *(name for name in documents.trees if name != main)]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        *_comments(documents.comments, 0),
        f"<root{_text('BTCPP_format', '4')}"
        f"{_text('main_tree_to_execute', names[main])}>",
    ]
    for name in order:
        written = documents.trees[name]
        lines.append("")
        lines += _comments(written.element.comments, 1)
        attributes = {**written.element.attributes, "ID": names[name]}
        lines += _element(
            "BehaviorTree",
            {"ID": attributes.pop("ID"), **attributes},
            written.element,
            _Position(documents, written.format, 1),
        )
    trees = documents.trees.values()
    lines += ["", *_model(documents, trees), "", "</root>", ""]
    return "\n".join(lines)


class _Position:
    """The writer's position: the documents, the format, and the depth."""

    def __init__(self, documents: Documents, form: int, depth: int) -> None:
        self.documents = documents
        self.form = form
        self.depth = depth

    def inner(self) -> "_Position":
        return _Position(self.documents, self.form, self.depth + 1)


def _tree_names(documents: Documents) -> dict[str, str]:
    """Returns the ID of each tree; a tree without one is given one."""
    names = {name: name for name in documents.trees}
    for name, tree in documents.trees.items():
        if "ID" not in tree.element.attributes:
            new, count = "MainTree", 1
            while new in documents.trees:
                count += 1
                new = f"MainTree{count}"
            names[name] = new
    return names


def _text(attribute: str, value: str) -> str:
    return f" {attribute}={quoteattr(value)}"


def _comments(comments: Iterable[str], depth: int) -> list[str]:
    return [f"{_INDENT * depth}<!--{comment}-->" for comment in comments]


def _element(
    tag: str,
    attributes: Mapping[str, str],
    element: XmlElement,
    position: _Position,
) -> Iterator[str]:
    depth = position.depth
    start = f"{_INDENT * depth}<{tag}" + "".join(
        _text(name, value) for name, value in attributes.items()
    )
    if not element.children and not element.last_comments:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for child in element.children:
        yield from _comments(child.comments, depth + 1)
        yield from _node(child, position.inner())
    yield from _comments(element.last_comments, depth + 1)
    yield f"{_INDENT * depth}</{tag}>"


def _node(element: XmlElement, position: _Position) -> Iterator[str]:
    if element.tag in SUBTREE_TAGS:
        attributes = _subtree_attributes(element, position)
        yield from _element("SubTree", attributes, element, position)
        return
    name = node_name(element)
    attributes = {}
    for attribute, value in element.attributes.items():
        if attribute == "ID" and element.tag in GENERIC_TAGS:
            continue
        new = PORT_ALIASES.get((name, attribute), attribute)
        attributes[new] = _braces(value, element)
    yield from _element(name, attributes, element, position)


def _braces(value: str, element: XmlElement) -> str:
    """Writes `${key}` of format 3 as `{key}`."""
    if not value.strip().startswith("$"):
        return value
    key = reference(value, "", element.spot)
    return value if key is None else f"{{{key}}}"


def _subtree_attributes(
    element: XmlElement, position: _Position
) -> dict[str, str]:
    attributes = {
        name: value
        for name, value in element.attributes.items()
        if name in ("ID", "name", *NOTES)
        or (name.startswith("_") and name not in (*SHARED, *AUTOREMAP))
    }
    if flag(element, SHARED):
        _check_shared(element, position.documents)
        return {**attributes, "_autoremap": "true"}
    if flag(element, AUTOREMAP):
        attributes["_autoremap"] = "true"
    ports = subtree_ports(element, position.form)
    return attributes | {
        name: _braces(value, element) for name, value in ports.items()
    }


def _check_shared(element: XmlElement, documents: Documents) -> None:
    tree_id = element.attributes["ID"]
    tree = documents.trees.get(tree_id)
    if tree is None:
        return
    for node in _walk(tree.element):
        for attribute, value in node.attributes.items():
            key = reference(value, attribute, node.spot)
            if attribute == "output_key":
                key = key or value.strip()
            if key and key.startswith("_"):
                raise node.spot.fault(
                    f"the subtree {tree_id} shares the blackboard, and names"
                    f" {key!r}; format 4 keeps names with an underscore apart,"
                    " so rename the entry"
                )


def _walk(element: XmlElement) -> Iterator[XmlElement]:
    yield element
    for child in element.children:
        yield from _walk(child)


def _model(documents: Documents, trees: Iterable[TreeElement]) -> list[str]:
    """Returns the <TreeNodesModel> of the leaves that are used."""
    used: dict[str, set[str]] = {}
    for tree in trees:
        for node in _walk(tree.element):
            if node is tree.element or node.tag in SUBTREE_TAGS:
                continue
            node_type = NODE_TYPES.get(node_name(node))
            if node_type is not None and node_type.source:
                ignored = node_type.ignored & node.attributes.keys()
                used.setdefault(node_type.name, set()).update(ignored)
    subtrees = {
        subtree.attributes["ID"]: subtree
        for model in documents.models
        for subtree in model.children
        if subtree.tag == "SubTree" and "ID" in subtree.attributes
    }
    text = tree_nodes_model(
        [NODE_TYPES[name] for name in used],
        ignored=used,
        subtrees=list(subtrees.values()),
    )
    return text.splitlines()


def tree_nodes_model(
    node_types: Iterable[NodeType],
    *,
    ignored: Mapping[str, Iterable[str]] = MappingProxyType({}),
    subtrees: Iterable[XmlElement] = (),
) -> str:
    """Returns the <TreeNodesModel> of leaves, which tells Groot2 their ports.

    Args:
        node_types: The leaves.
        ignored: For a leaf, attributes to show that it accepts and ignores.
        subtrees: The <SubTree> elements of other models, to be in it, too.
    """
    lines = ["  <TreeNodesModel>"]
    for node_type in sorted(node_types, key=lambda t: (t.category, t.name)):
        ports = list(_model_ports(node_type))
        ports += [
            f"<input_port name={quoteattr(name)}/>"
            for name in sorted(ignored.get(node_type.name, ()))
        ]
        lines += _model_entry(node_type.category, node_type.name, ports)
    for subtree in sorted(subtrees, key=lambda s: s.attributes["ID"]):
        ports = [
            f"<{child.tag}{_port_attributes(child)}/>"
            for child in subtree.children
            if child.tag.endswith("_port")
        ]
        lines += _model_entry("SubTree", subtree.attributes["ID"], ports)
    lines.append("  </TreeNodesModel>")
    return "\n".join(lines)


def _model_entry(tag: str, name: str, ports: list[str]) -> Iterator[str]:
    start = f"    <{tag} ID={quoteattr(name)}"
    if not ports:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for port in ports:
        yield f"      {port}"
    yield f"    </{tag}>"


def _model_ports(node_type: NodeType) -> Iterator[str]:
    for port in node_type.ports.values():
        text = f"name={quoteattr(port.name)} type="
        text += quoteattr(_CPP_TYPES[port.base])
        if port.default is not ...:
            default = str(port.default)
            if port.base is bool:
                default = default.lower()
            text += f" default={quoteattr(default)}"
        yield f"<input_port {text}/>"


def _port_attributes(element: XmlElement) -> str:
    return "".join(
        f" {name}={quoteattr(value)}"
        for name, value in element.attributes.items()
    )
