"""What the editors Groot and Groot2 need to know of our nodes."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

from hunav_drake.systems.behavior.language.xml_source import XmlElement
from hunav_drake.systems.behavior.nodes.node import NodeType

_TYPES = {float: "double", int: "int", bool: "bool", str: "std::string"}


def tree_nodes_model(
    node_types: Iterable[NodeType],
    *,
    ignored: Mapping[str, Iterable[str]] = MappingProxyType({}),
    subtrees: Iterable[XmlElement] = (),
) -> str:
    """Returns the <TreeNodesModel> of some leaves.

    In a tree's file it makes Groot show the leaves with their ports.

    Args:
        node_types: The leaves.
        ignored: For a leaf, attributes to show that it accepts and ignores.
        subtrees: The <SubTree> elements of other models, to be in it, too.
    """
    lines = ["  <TreeNodesModel>"]
    for node_type in sorted(node_types, key=lambda t: (t.category, t.name)):
        ports = list(_ports(node_type))
        ports += [
            f"<input_port name={quoteattr(name)}/>"
            for name in sorted(ignored.get(node_type.name, ()))
        ]
        lines += _entry(node_type.category, node_type.name, ports)
    for subtree in sorted(subtrees, key=lambda s: s.attributes["ID"]):
        ports = [
            f"<{child.tag}{_attributes(child)}/>"
            for child in subtree.children
            if child.tag.endswith("_port")
        ]
        lines += _entry("SubTree", subtree.attributes["ID"], ports)
    lines.append("  </TreeNodesModel>")
    return "\n".join(lines)


def _entry(tag: str, name: str, ports: list[str]) -> Iterator[str]:
    start = f"    <{tag} ID={quoteattr(name)}"
    if not ports:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for port in ports:
        yield f"      {port}"
    yield f"    </{tag}>"


def _ports(node_type: NodeType) -> Iterator[str]:
    for port in node_type.ports.values():
        text = f"name={quoteattr(port.name)} type="
        text += quoteattr(_TYPES[port.base])
        if port.default is not ...:
            default = str(port.default)
            if port.base is bool:
                default = default.lower()
            text += f" default={quoteattr(default)}"
        yield f"<input_port {text}/>"


def _attributes(element: XmlElement) -> str:
    return "".join(
        f" {name}={quoteattr(value)}"
        for name, value in element.attributes.items()
    )
