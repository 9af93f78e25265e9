"""What the editors Groot and Groot2 need to know of our nodes."""

from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

from hunav_drake.systems.behavior.node import NodeType

_TYPES = {float: "double", int: "int", bool: "bool", str: "std::string"}


def tree_nodes_model(node_types: Iterable[NodeType]) -> str:
    """Returns the <TreeNodesModel> of some leaves.

    In a tree's file it makes Groot show the leaves with their ports.

    Args:
        node_types: The leaves.
    """
    lines = ["  <TreeNodesModel>"]
    for node_type in sorted(node_types, key=lambda t: (t.category, t.name)):
        start = f"    <{node_type.category} ID={quoteattr(node_type.name)}"
        if not node_type.ports:
            lines.append(f"{start}/>")
            continue
        lines.append(f"{start}>")
        for port in node_type.ports.values():
            text = f"name={quoteattr(port.name)} type="
            text += quoteattr(_TYPES[port.base])
            if port.default is not ...:
                default = str(port.default)
                if port.base is bool:
                    default = default.lower()
                text += f" default={quoteattr(default)}"
            lines.append(f"      <input_port {text}/>")
        lines.append(f"    </{node_type.category}>")
    lines.append("  </TreeNodesModel>")
    return "\n".join(lines)
