"""Writes trees as XML in format 4 of BehaviorTree.CPP, as for Groot2."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from hunav_drake.systems.behavior.language.blackboard import reference
from hunav_drake.systems.behavior.language.documents import Documents
from hunav_drake.systems.behavior.language.parser import (
    AUTOREMAP,
    LIMITS,
    SHARED,
    flag,
    is_limited,
    node_name,
    subtree_ports,
)
from hunav_drake.systems.behavior.language.xml_source import NOTES, XmlElement
from hunav_drake.systems.behavior.library import LoadTree
from hunav_drake.systems.behavior.nodes.errors import Place
from hunav_drake.systems.behavior.nodes.language_nodes import FURTHER_NODES
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.port import Port
from hunav_drake.systems.behavior.nodes.registry import (
    GENERIC_TAGS,
    NODE_TYPES,
    PORT_ALIASES,
    SUBTREE_TAGS,
)
from hunav_drake.systems.behavior.tree import Tree

_INDENT = "  "

# The C++ names of the types of ports.
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
    <TreeNodesModel>, which declares the leaves for Groot2. It does not hold
    values that were given for ports when the tree was loaded.

    Args:
        tree: The tree, or the documents of one.

    Raises:
        BehaviorTreeError: If a subtree of format 3 shares the blackboard and
            names an entry with an underscore, which format 4 keeps apart.
    """
    documents = tree.documents if isinstance(tree, Tree) else tree
    names = _tree_names(documents)
    main = documents.main
    root = {"BTCPP_format": "4", "main_tree_to_execute": names[main]}
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        *_comments(documents.comments, 0),
        f"<root{_attributes(root)}>",
    ]
    for name in (main, *(name for name in documents.trees if name != main)):
        written = documents.trees[name]
        others = {**written.element.attributes}
        others.pop("ID", None)
        element = replace(
            written.element,
            attributes={"ID": names[name], **others},
            children=[
                _node(child, documents, written.format)
                for child in written.element.children
            ],
        )
        lines += ["", *_lines(element, 1)]
    lines += ["", *_lines(_model(documents), 1), "", "</root>", ""]
    return "\n".join(lines)


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


def _attributes(attributes: Mapping[str, str]) -> str:
    # Imported here, as it loads what opens addresses of the web.
    from xml.sax.saxutils import quoteattr

    return "".join(
        f" {name}={quoteattr(value)}" for name, value in attributes.items()
    )


def _comments(comments: Iterable[str], depth: int) -> list[str]:
    return [f"{_INDENT * depth}<!--{comment}-->" for comment in comments]


def _lines(element: XmlElement, depth: int) -> Iterator[str]:
    """Yields the lines of an element, after those of its comments."""
    indent = _INDENT * depth
    yield from _comments(element.comments, depth)
    start = f"{indent}<{element.tag}{_attributes(element.attributes)}"
    if not element.children and not element.last_comments:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for child in element.children:
        yield from _lines(child, depth + 1)
    yield from _comments(element.last_comments, depth + 1)
    yield f"{indent}</{element.tag}>"


def _node(element: XmlElement, documents: Documents, form: int) -> XmlElement:
    """Returns the element of a node, written in a format, in format 4."""
    if element.tag in SUBTREE_TAGS:
        name = "SubTree"
        attributes = _subtree_attributes(element, documents, form)
    else:
        name = node_name(element)
        attributes = {
            PORT_ALIASES.get((name, key), key): _braces(value, element)
            for key, value in element.attributes.items()
            if key != "ID" or element.tag not in GENERIC_TAGS
        }
    children = [_node(child, documents, form) for child in element.children]
    return replace(element, tag=name, attributes=attributes, children=children)


def _braces(value: str, element: XmlElement) -> str:
    """Writes `${key}` of format 3 as `{key}`."""
    if not value.strip().startswith("$"):
        return value
    key = reference(value, "", element.spot)
    return value if key is None else f"{{{key}}}"


def _subtree_attributes(
    element: XmlElement, documents: Documents, form: int
) -> dict[str, str]:
    attributes = {
        name: value
        for name, value in element.attributes.items()
        if name in ("ID", "name", *NOTES)
        or (name.startswith("_") and name not in (*SHARED, *AUTOREMAP))
    }
    if flag(element, SHARED):
        _check_shared(element, documents)
        return {**attributes, "_autoremap": "true"}
    if flag(element, AUTOREMAP):
        attributes["_autoremap"] = "true"
    ports = subtree_ports(element, form)
    return attributes | {
        name: _braces(value, element) for name, value in ports.items()
    }


def _check_shared(element: XmlElement, documents: Documents) -> None:
    tree_id = element.attributes["ID"]
    tree = documents.trees.get(tree_id)
    if tree is None:
        return
    for node in tree.element.all():
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


def _model(documents: Documents) -> XmlElement:
    """Returns the <TreeNodesModel> of the leaves that are used."""
    used: dict[str, set[str]] = {}
    for tree in documents.trees.values():
        for node in tree.element.all():
            if node is tree.element or node.tag in SUBTREE_TAGS:
                continue
            node_type = NODE_TYPES.get(node_name(node))
            if node_type is not None and is_declared(node_type):
                more = LIMITS if is_limited(node, node_type) else set()
                ignored = (node_type.ignored | more) & node.attributes.keys()
                used.setdefault(node_type.name, set()).update(ignored)
    subtrees = {
        subtree.attributes["ID"]: _element(
            "SubTree",
            {"ID": subtree.attributes["ID"]},
            [
                _element(child.tag, child.attributes)
                for child in subtree.children
                if child.tag.endswith("_port")
            ],
        )
        for model in documents.models
        for subtree in model.children
        if subtree.tag == "SubTree" and "ID" in subtree.attributes
    }
    named = [subtree for _, subtree in sorted(subtrees.items())]
    return _element("TreeNodesModel", {}, [*_leaves(used), *named])


def is_declared(node_type: NodeType) -> bool:
    """Returns whether Groot2 does not know a type, and must be told of it."""
    return bool(node_type.source) or node_type.name in FURTHER_NODES


def tree_nodes_model(node_types: Iterable[NodeType]) -> str:
    """Returns the <TreeNodesModel> of leaves, for Groot2."""
    leaves = _leaves({node_type.name: () for node_type in node_types})
    return "\n".join(_lines(_element("TreeNodesModel", {}, leaves), 1))


def _leaves(used: Mapping[str, Iterable[str]]) -> list[XmlElement]:
    """Returns the models of leaves, with used attributes that are no ports."""
    types = [NODE_TYPES[name] for name in used]
    types.sort(key=lambda it: (it.category, it.name))
    return [
        _element(
            node_type.category,
            {"ID": node_type.name},
            [
                *map(_model_port, node_type.ports.values()),
                *(
                    _element("input_port", {"name": name})
                    for name in sorted(used[node_type.name])
                ),
            ],
        )
        for node_type in types
    ]


def _element(
    tag: str, attributes: dict[str, str], children: Iterable[XmlElement] = ()
) -> XmlElement:
    return XmlElement(tag, attributes, Place(""), [*children])


def _model_port(port: Port) -> XmlElement:
    attributes = {"name": port.name, "type": _CPP_TYPES[port.base]}
    if port.output:
        return _element("output_port", attributes)
    if port.default is not ...:
        default = str(port.default)
        is_bool = port.base is bool
        attributes["default"] = default.lower() if is_bool else default
    return _element("input_port", attributes)
