"""Draws behavior trees: with Graphviz where it is installed, else as text."""

from collections.abc import Sequence
import html
from pathlib import Path
import shutil
from typing import Any, NamedTuple

from hunav_drake.systems.behavior.describe import describe_ports
from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.common.files import atomic_write


class _Look(NamedTuple):
    """The look of a status: its mark, its word, and two colors."""

    mark: str
    word: str
    fill: str
    line: str


# Colors that colorblind people can tell apart. (M. Okabe and K. Ito, "Color
# Universal Design", 2008; the fills are lighter, for the text.)
_LOOKS = {
    NodeStatus.IDLE: _Look("·", "not ticked", "#ffffff", "#555555"),
    NodeStatus.RUNNING: _Look("▶", "running", "#cfe8f8", "#0072b2"),
    NodeStatus.SUCCESS: _Look("✓", "success", "#bfe8d9", "#007a58"),
    NodeStatus.FAILURE: _Look("✗", "failure", "#f8cfae", "#b84a00"),
    NodeStatus.SKIPPED: _Look("↷", "skipped", "#e4e4e4", "#5f5f5f"),
}
# The signs of these nodes in papers on behavior trees.
_SIGNS = {
    "Sequence": "→",
    "ReactiveSequence": "→",
    "SequenceWithMemory": "→*",
    "Fallback": "?",
    "ReactiveFallback": "?",
    "Parallel": "⇉",
}
_SHAPES = {
    "Condition": "ellipse",
    "Action": "box",
    "Control": "box",
    "Decorator": "hexagon",
}
_MAX_LABEL = 40


class TreeDrawing:
    """A drawing of a tree, which shows itself in a notebook.

    Attributes:
        tree: The tree.
        node_status: The status of each of its nodes in a tick, or None.
    """

    def __init__(
        self, tree: Tree, node_status: tuple[NodeStatus, ...] | None = None
    ) -> None:
        """Constructs a TreeDrawing; `RenderBehaviorTree` checks the status."""
        self.tree = tree
        self.node_status = node_status

    @property
    def text(self) -> str:
        """The drawing as text."""
        lines: list[str] = []
        statuses = dict(self._statuses())
        _text_lines(self.tree.root, "", "", statuses, lines)
        if statuses:
            legend = [f"{it.mark} {it.word}" for it in _LOOKS.values()]
            lines += ["", "  ".join(legend)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.text

    def graph(self) -> Any:
        """Returns the drawing as a pydot.Dot graph."""
        import pydot

        # Children stand in the order in which they are ticked.
        graph = pydot.Dot(graph_type="digraph", bgcolor="white", ordering="out")
        graph.set_node_defaults(
            fontname="Helvetica", fontsize="10", margin="0.1,0.04"
        )
        graph.set_edge_defaults(arrowsize="0.6", color="#555555")
        statuses = dict(self._statuses())
        names = {id(node): f"n{i}" for i, node in enumerate(self.tree.nodes)}
        for node in self.tree.nodes:
            graph.add_node(_graph_node(pydot, node, names[id(node)], statuses))
        for node in self.tree.nodes:
            for child in node.children:
                graph.add_edge(pydot.Edge(names[id(node)], names[id(child)]))
        return graph

    def save(self, path: str | Path) -> None:
        """Writes the drawing to a file, in the format of its ending.

        Args:
            path: The file: .svg, .png, .pdf, .dot, or .txt for the text.

        Raises:
            ValueError: If the ending is another.
            RuntimeError: If the program `dot` of Graphviz is not installed
                and the ending needs it.
            OSError: If the file cannot be written.
        """
        path = Path(path)
        ending = path.suffix.removeprefix(".")
        if ending == "txt":
            data = f"{self.text}\n".encode()
        elif ending == "dot":
            data = self.graph().to_string().encode()
        elif ending not in ("svg", "png", "pdf"):
            raise ValueError(
                "a drawing is saved as .svg, .png, .pdf, .dot or .txt, got"
                f" {str(path)!r}"
            )
        else:
            data = self._drawn(ending)
        with atomic_write(path) as file:
            file.write(data)

    def _drawn(self, ending: str) -> bytes:
        if shutil.which("dot") is None:
            raise RuntimeError(
                "the program dot is not installed; install Graphviz, or save"
                " as .txt"
            )
        data: bytes = self.graph().create(format=ending, encoding="utf-8")
        return data

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        """Returns the formats that a notebook can show."""
        bundle = {"text/plain": self.text}
        if shutil.which("dot") is not None:
            bundle["image/svg+xml"] = self._drawn("svg").decode()
        return bundle

    def _statuses(self) -> Sequence[tuple[int, NodeStatus]]:
        if self.node_status is None:
            return ()
        nodes = map(id, self.tree.nodes)
        return tuple(zip(nodes, self.node_status, strict=True))


def RenderBehaviorTree(
    tree: Tree, node_status: Sequence[float] | None = None
) -> TreeDrawing:
    """Draws a tree.

    In a notebook the result shows itself, drawn by Graphviz if its program
    `dot` is installed, else as text; `print` it to see the text.

    Args:
        tree: The tree.
        node_status: The status of each node in a tick, which colors it, from
            `BehaviorTree.EvalNodeStatus` or `Tree.trace`.

    Raises:
        ValueError: If ``node_status`` has not one `NodeStatus` for each node.
    """
    if node_status is None:
        return TreeDrawing(tree)
    if len(node_status) != len(tree.nodes):
        raise ValueError(
            f"node_status must have a number for each of the {len(tree.nodes)}"
            f" nodes of {tree.name}, got {len(node_status)}"
        )
    return TreeDrawing(
        tree, tuple(NodeStatus(int(value)) for value in node_status)
    )


def _title(node: Node) -> str:
    sign = _SIGNS.get(node.type.name)
    return f"{sign} {node.type.name}" if sign else node.type.name


def _text_lines(
    node: Node,
    first: str,
    others: str,
    statuses: dict[int, NodeStatus],
    lines: list[str],
) -> None:
    parts = [_title(node)]
    if statuses:
        parts.insert(0, _LOOKS[statuses[id(node)]].mark)
    if node.name != node.type.name:
        parts.append(repr(node.name))
    parts += describe_ports(node, defaults=False)
    lines.append(first + " ".join(parts))
    for i, child in enumerate(node.children):
        last = i == len(node.children) - 1
        _text_lines(
            child,
            others + ("└─ " if last else "├─ "),
            others + ("   " if last else "│  "),
            statuses,
            lines,
        )


def _graph_node(
    pydot: Any, node: Node, name: str, statuses: dict[int, NodeStatus]
) -> Any:
    status = statuses.get(id(node), NodeStatus.IDLE)
    look = _LOOKS[status]
    rows = [f"<b>{_escaped(_title(node))}</b>"]
    if node.name != node.type.name:
        rows.append(f"<i>{_escaped(node.name)}</i>")
    rows += [
        f'<font point-size="9">{_escaped(port)}</font>'
        for port in describe_ports(node, defaults=False)
    ]
    if statuses:
        word = f"{look.mark} {look.word}"
        rows.append(f'<font point-size="9" color="{look.line}">{word}</font>')
    is_subtree = node.type.name == "SubTree"
    styles = ["filled"]
    if node.type.category == "Action":
        styles.append("rounded")
    if status is NodeStatus.SKIPPED:
        styles.append("dashed")
    return pydot.Node(
        name,
        label=f"<{'<br/>'.join(rows)}>",
        shape="folder" if is_subtree else _SHAPES[node.type.category],
        fillcolor=look.fill,
        color=look.line,
        fontcolor="#222222",
        penwidth="2" if status is NodeStatus.RUNNING else "1",
        style=f'"{",".join(styles)}"',
    )


def _escaped(text: str) -> str:
    if len(text) > _MAX_LABEL:
        text = text[: _MAX_LABEL - 1] + "…"
    return html.escape(text)
