"""Makes the tables of a tree that compiled code walks over."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.nodes.node import LeafFunction, Node
from hunav_drake.systems.behavior.nodes.operations import (
    AGAIN,
    AROUND,
    DELAY,
    PARALLEL,
    TIMEOUT,
    Instruction,
)
from hunav_drake.systems.behavior.nodes.port import (
    Constant,
    Meaning,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.nodes.table import PORT, ROW, SLOT, STEP
from hunav_drake.systems.behavior.nodes.tick_context import need_slots

# The first slot of an action that remembers: 1 while it runs.
RUNNING_SLOT = "(running)"

_END = Instruction(-1)
_CONSTANT = (-1, 0.0, 0.0, False)

# The columns of scripts, by attribute.
_SCRIPTS = {
    "_failureIf": "failure_if",
    "_successIf": "success_if",
    "_skipIf": "skip_if",
    "_while": "holds_while",
    "_onHalted": "on_halted",
    "_onFailure": "on_failure",
    "_onSuccess": "on_success",
}


class Program:
    """A tree in tables, which `walk` reads.

    Attributes:
        name: The ID of the tree.
        nodes: All its nodes, from the top down.
        names: The name of each number of the memory.
        leaves: What ticks each leaf in Python, by its place in `nodes`.
        rows: A row of `ROW` for each node, from the top down, and one more.
            A leaf is compiled, and its address is set, when it is first called.
        slots: A row of `SLOT` for each number of the memory.
        ports: A row of `PORT` for each port.
        numbers: The number of each port that is a constant.
        steps: The scripts, one after the other: rows of `STEP`.
        halted: The rows of nodes with `_onHalted`, those below first.
        is_social: Whether any of its leaves is social.
        num_needs: The number of needs that they name.
    """

    def __init__(
        self,
        name: str,
        nodes: Sequence[Node],
        names: Sequence[str],
        initial: Sequence[float],
    ) -> None:
        """Constructs the tables of a tree.

        Args:
            name: The ID of the tree.
            nodes: All its nodes, from the top down.
            names: The name of each number of the memory.
            initial: The memory at the start.
        """
        self.name, self.nodes, self.names = name, nodes, names
        self.is_social = any(it.type.is_social for it in nodes)
        self.num_needs = len(
            {
                value.value
                for it in nodes
                for key, value in it.ports.items()
                if it.type.ports[key].meaning is Meaning.NEED
                and isinstance(value, Constant)
            }
        )
        self._arguments = (name, nodes, names, initial)
        self.leaves: dict[int, LeafFunction] = {
            i: node.type.build(node)
            for i, node in enumerate(nodes)
            if node.type.build
        }
        self.rows = np.full(len(nodes) + 1, -1, ROW)
        self.slots = np.array([(-1, value) for value in initial], SLOT)
        self._ports: list[tuple[int, float, float, bool]] = []
        self._numbers: list[float] = []
        self._steps: list[Instruction] = []
        self._halted: list[int] = []
        self._count = 0
        self._add(nodes[0], -1, 0)
        ends = [node.first + len(node.slots) for node in nodes]
        self.rows[-1]["slots"] = max(ends)
        self.ports = np.array(self._ports, PORT)
        self.numbers = np.array(self._numbers, np.float64)
        self.steps = np.array(self._steps, STEP)
        self.halted = np.array(self._halted, np.int64)

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        """Returns how to make it in another process: without addresses."""
        return Program, self._arguments

    def _add(self, node: Node, parent: int, index: int) -> None:
        """Adds the row of a node, and those of its children."""
        number = self._count
        self._count += 1
        fields = {
            "operation": node.type.operation.code,
            **dict(zip("abcd", node.type.operation.numbers, strict=False)),
            "parent": parent,
            "index": index,
            "children": len(node.children),
            **self._add_slots(node),
            **self._add_ports(node),
            **self._add_scripts(node),
        }
        counts = node.type.operation.code in (AGAIN, DELAY, TIMEOUT)
        for i, child in enumerate(node.children):
            self._add(child, number, i)
        fields["end"] = self._count
        below = self.rows["counts"][number + 1 : self._count]
        fields["counts"] = bool(counts or (below > 0).any())
        for name, value in fields.items():
            self.rows[number][name] = value
        if fields["on_halted"] >= 0:
            self._halted.append(number)

    def _add_slots(self, node: Node) -> dict[str, int]:
        fields = {"slots": node.first}
        if node.conditions and node.conditions.slot is not None:
            begun = node.conditions.slot
            fields = {"slots": begun, "begun": begun}
            self.slots[begun]["flag"] = begun
        runs = node.slots[:1] == (RUNNING_SLOT,)
        for slot, name in enumerate(node.slots, node.first):
            if name not in node.type.kept:
                self.slots[slot]["flag"] = node.first if runs else slot
        if runs:
            fields["running"] = node.first
        fields["first"] = node.first + runs
        fields["size"] = len(node.slots) - runs
        return fields

    def _add_ports(self, node: Node) -> dict[str, int]:
        first = len(self._ports)
        is_checked = 0
        # (Leaves in Python read their ports themselves.)
        ports = {} if node.type.build else node.ports
        for name, value in ports.items():
            port = node.type.ports[name]
            if isinstance(value, Variable) and port.meaning is Meaning.RESULT:
                self._ports.append(_CONSTANT)
                self._numbers.append(float(value.slot))
            elif isinstance(value, Constant):
                is_any = port.takes_any
                number = (
                    value.number if is_any else self.number(port, value.value)
                )
                self._ports.append(_CONSTANT)
                self._numbers.append(number)
            else:
                is_checked |= int(not port.takes_any)
                low, high, is_whole = port.bounds()
                if node.type.operation.code == PARALLEL:
                    high = len(node.children)
                self._ports.append((value.slot, low, high, is_whole))
                self._numbers.append(0.0)
        # (The status that `AROUND` tells its leaf.)
        around = int(node.type.operation.code == AROUND)
        self._numbers += [0.0] * around
        self._ports += [_CONSTANT] * around
        return {
            "first_port": first,
            "num_ports": len(ports) + around,
            "is_checked": is_checked,
            "leaf": 0,
        }

    def number(self, port: Port, value: Any) -> float:
        """Returns the number of a port's value for compiled code."""
        if port.meaning is Meaning.NEED:
            return float(self.names.index(need_slots(value)[0]))
        return port.number(value)

    def _add_scripts(self, node: Node) -> dict[str, int]:
        scripts = dict(node.conditions.scripts) if node.conditions else {}
        after = scripts.pop("_post", ())
        for name in ("_onSuccess", "_onFailure"):
            scripts[name] = (*scripts.get(name, ()), *after)
        fields: dict[str, int] = {"asks": node.conditions is not None}
        for attribute, name in _SCRIPTS.items():
            fields[name] = -1
            if scripts.get(attribute):
                fields[name] = len(self._steps)
                self._steps += [*scripts[attribute], _END]
        return fields
