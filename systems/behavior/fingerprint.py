"""The fingerprint of a tree: a hash of its meaning, not of its files."""

import hashlib
import json
from typing import Any

from hunav_drake.systems.behavior.language.documents import Documents
from hunav_drake.systems.behavior.language.xml_source import NOTES, XmlElement
from hunav_drake.systems.behavior.library import LoadBehavior
from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.port import Constant, Variable
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.people.behavior_choice import BehaviorConfig


def tree_fingerprint(behavior: str | BehaviorConfig | Tree) -> str:
    """Returns the SHA-256 hash of a tree and all that it includes.

    It covers the elements of all files, the values of the ports, given or by
    default, the leaves with their defaults and, for leaves from outside this
    package, the names of their functions. Comments and the locations of files
    and of this package's leaves have no effect.

    Args:
        behavior: A tree, or a behavior as in `HumanConfig.behavior`.

    Returns:
        64 hexadecimal digits.

    Raises:
        BehaviorTreeError: If there is no such tree, or at the first fault in
            it.
    """
    tree = behavior if isinstance(behavior, Tree) else LoadBehavior(behavior)
    content = {
        "main": tree.name,
        "values": dict(tree.values),
        "nodes": [_node(node) for node in tree.nodes],
        "documents": _documents(tree.documents),
    }
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _node(node: Node) -> list[Any]:
    """Returns what defines a node beyond its XML: its type and its ports."""
    ports = {name: _value(value) for name, value in node.ports.items()}
    slots = dict(node.type.slots)
    source = "" if node.type.is_ours else node.type.source
    return [node.type.name, source, ports, slots, len(node.children)]


def _value(value: Constant | Variable) -> str:
    if isinstance(value, Constant):
        return repr(value.value)
    return f"{{{value.key}}} {value.slot}"


def _documents(documents: Documents) -> dict[str, Any]:
    return {
        "trees": {
            name: [tree.format, _element(tree.element)]
            for name, tree in documents.trees.items()
        },
        "ports": {
            name: {port.name: [port.type, port.default] for port in it.values()}
            for name, it in documents.ports.items()
        },
    }


def _element(element: XmlElement) -> list[Any]:
    attributes = {
        name: text
        for name, text in element.attributes.items()
        if name not in NOTES
    }
    children = [_element(child) for child in element.children]
    return [element.tag, attributes, children]
