"""The meanings of a tree's ports, from the docstrings of its leaves."""

import inspect
import json
import re
from typing import Any

from hunav_drake.systems.behavior.language.documents import Documents
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.profiles import behavior_set
from hunav_drake.systems.behavior.tree import Tree

# The depth of subtrees up to which they are searched for help.
_DEEPEST = 5

# The JSON types of ports, by their types in XML.
_TYPES = {
    "double": "number",
    "float": "number",
    "int": "integer",
    "bool": "boolean",
    "std::string": "string",
}


def port_entries(tree: Tree) -> list[dict[str, Any]]:
    """Returns the ports of a tree that a scenario can set.

    The first leaf that takes a port gives its help, range and unit.
    """
    entries = []
    for port in tree.documents.main_ports().values():
        kind = _TYPES.get(port.type, "string")
        entry: dict[str, Any] = {
            "name": port.name,
            "type": kind,
            "default": _value(kind, port.default),
            "required": port.default is None,
            "help": "",
            "schema": {},
        }
        taker = _taker(tree.documents, tree.name, port.name)
        if taker is not None:
            leaf, name = taker
            entry["schema"] = leaf.ports[name].adapter.json_schema()
            words = _words_about(name, leaf.function) or leaf.doc
            entry["help"] = f"{leaf.name}: {words}"
        elif part := _part_switched(tree.documents, tree.name, port.name):
            entry["help"] = f"Switches the part {part} on or off."
        entries.append(entry)
    return entries


def _taker(
    documents: Documents, tree: str, port: str, depth: int = 0
) -> tuple[NodeType, str] | None:
    """Returns the first leaf that takes a tree's port, and its own port."""
    if tree not in documents.trees or depth > _DEEPEST:
        return None
    types = behavior_set("default").node_types()
    for element in documents.trees[tree].element.all():
        for name, value in element.attributes.items():
            if value != f"{{{port}}}":
                continue
            kind = element.attributes.get("ID", element.tag)
            if element.tag == "SubTree":
                taker = _taker(documents, kind, name, depth + 1)
                if taker is not None:
                    return taker
            leaf = types.get(element.tag) or types.get(kind)
            if leaf is not None and name in leaf.ports:
                return leaf, name
    return None


def _part_switched(documents: Documents, tree: str, port: str) -> str:
    """Returns the part of a tree that a port can skip, or an empty text."""
    for element in documents.trees[tree].element.all():
        condition = element.attributes.get("_skipIf", "")
        if re.search(rf"\b{re.escape(port)}\b", condition):
            return element.attributes.get("ID", element.tag)
    return ""


def _value(kind: str, text: str | None) -> Any:
    """Returns the default of a port as a value in a scenario."""
    if text is None or kind == "string":
        return text
    try:
        return json.loads(text)
    except ValueError:
        return text


def _words_about(port: str, function: Any) -> str:
    """Returns the sentence of a leaf's documentation that names a port."""
    text = " ".join((inspect.getdoc(function) or "").split())
    for sentence in re.split(r"(?<=[.;]) ", text):
        if f"`{port}`" in sentence:
            return re.sub(";$", ".", sentence.replace("`", ""))
    return ""
