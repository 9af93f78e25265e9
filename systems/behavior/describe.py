"""Describes nodes and trees in text."""

from collections.abc import Iterator, Sequence

from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.port import Constant, Variable


def _describe_port(value: Constant | Variable) -> str:
    if isinstance(value, Constant):
        return repr(value.value)
    return f"{{{value.key}}}"


def _describe_node(node: Node) -> str:
    parts = [node.type.name]
    if node.name != node.type.name:
        parts.append(repr(node.name))
    return " ".join(parts + describe_ports(node))


def describe_ports(node: Node, *, defaults: bool = True) -> list[str]:
    """Returns the ports (or all but defaults) and the conditions of a node."""
    parts = [
        f"{name}={_describe_port(value)}"
        for name, value in node.ports.items()
        if defaults
        or not isinstance(value, Constant)
        or value.value != node.type.ports[name].default
    ]
    if node.conditions:
        source = node.conditions.source
        parts += [f'{name}="{text}"' for name, text in source.items()]
    return parts


def describe_tree(
    title: str,
    nodes: Sequence[Node],
    slots: Sequence[str],
    texts: Sequence[str],
) -> str:
    """Returns the nodes, the layout of the memory and the texts of a tree."""
    lines = [title, "Nodes:"]
    depths = dict(_depths(nodes[0], 0))
    owners: dict[int, int] = {}
    for i, node in enumerate(nodes):
        indent = "  " * depths[id(node)]
        lines.append(f"  {i:3d}  {indent}{_describe_node(node)}")
        for slot in range(node.first, node.first + len(node.slots)):
            owners[slot] = i
        if node.conditions and node.conditions.slot is not None:
            owners[node.conditions.slot] = i
    lines.append("Memory:")
    for i, name in enumerate(slots):
        owner = f" (node {owners[i]})" if i in owners else ""
        lines.append(f"  {i:3d}  {name}{owner}")
    if texts:
        lines.append("Texts, and the numbers that stand for them:")
        lines += [f"  {i:3d}  {text!r}" for i, text in enumerate(texts)]
    return "\n".join(lines)


def _depths(node: Node, depth: int) -> Iterator[tuple[int, int]]:
    yield id(node), depth
    for child in node.children:
        yield from _depths(child, depth + 1)
