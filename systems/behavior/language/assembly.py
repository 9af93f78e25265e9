"""Makes nodes from drafts, once the whole tree has been read.

Only then is it known which blackboard entries change and need memory, and
which of them hold texts.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from hunav_drake.systems.behavior.language import script
from hunav_drake.systems.behavior.language.blackboard import (
    Entry,
    literal_of,
    resolve,
)
from hunav_drake.systems.behavior.language.draft import Draft
from hunav_drake.systems.behavior.language.entry_types import (
    EntryType,
    TextTable,
    number_of,
)
from hunav_drake.systems.behavior.nodes.errors import Spot
from hunav_drake.systems.behavior.nodes.node import Conditions, Node
from hunav_drake.systems.behavior.nodes.operations import Script
from hunav_drake.systems.behavior.nodes.port import (
    UNSET,
    Constant,
    Meaning,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.nodes.pre_post_conditions import (
    BEGUN_SLOT,
    needs_memory,
)
from hunav_drake.systems.behavior.nodes.tick_context import (
    PERSON_MEMORY,
    SOCIAL_MEMORY,
    need_slots,
)


@dataclass(frozen=True)
class Assembled:
    """A tree with the layout of its memory.

    Attributes:
        root: Its topmost node.
        slots: The name of each number in the memory.
        initial: The value of each number before the first tick.
        texts: The texts that entries can hold.
        is_social: Whether any of its leaves is.
    """

    root: Node
    slots: tuple[str, ...]
    initial: tuple[float, ...]
    texts: tuple[str, ...]
    is_social: bool


def assemble(draft: Draft, entries: list[Entry]) -> Assembled:
    """Returns the tree of its topmost draft; entries that change get slots."""
    drafts = list(_preorder(draft))
    for each in drafts:
        _settle(each)
    changing = [entry for entry in entries if entry.set_by_nodes]
    for entry in changing:
        if entry.literal is not None:
            entry.kind.literal(entry.literal, Spot(entry.place, "SubTree"))
    texts = _collect_texts(drafts, changing)
    own = dict.fromkeys(PERSON_MEMORY, 0.0)
    is_social = any(each.type.is_social for each in drafts)
    if is_social:
        own |= SOCIAL_MEMORY
    for need in sorted({*_needs(drafts)}):
        own |= dict.fromkeys(need_slots(need), 0.0)
    slots, initial = list(own), list(own.values())
    following = len(slots) + sum(len(_own_slots(each)) for each in drafts)
    for slot, entry in enumerate(changing, following):
        entry.slot = slot
    root = _Finisher(slots, initial, texts).finish(draft)
    for entry in changing:
        slots.append(str(entry))
        literal = entry.literal
        initial.append(
            UNSET if literal is None else texts.number(literal, entry.kind)
        )
    return Assembled(
        root, tuple(slots), tuple(initial), texts.table(), is_social
    )


def _preorder(draft: Draft) -> Iterator[Draft]:
    yield draft
    for child in draft.children:
        yield from _preorder(child)


def _bound_ports(draft: Draft) -> Iterator[tuple[Port, str | Entry]]:
    for name, binding in draft.bindings.items():
        yield draft.type.ports[name], binding


def _needs(drafts: list[Draft]) -> Iterator[str]:
    """Yields the needs that nodes name."""
    for draft in drafts:
        for port, binding in _bound_ports(draft):
            if port.meaning is not Meaning.NEED:
                continue
            name = _literal(binding)
            if name is None:
                raise draft.spot.fault(
                    f"port {port.name}: must be the name of a need, not an"
                    " entry that is set later; write the name"
                )
            yield name


def _settle(draft: Draft) -> None:
    """Infers the types of the entries that a node refers to."""
    spot = draft.spot
    for port, binding in _bound_ports(draft):
        if isinstance(binding, Entry) and binding.set_by_nodes:
            if port.takes_any:
                draft.kind.join(binding.kind, spot)
            else:
                # (An entry has the number of one of several people.)
                text = port.base is str and port.meaning is not Meaning.PEOPLE
                reason = f"port {port.name} with {{{binding.key}}}"
                binding.kind.require(text, reason, spot)
            continue
        if isinstance(binding, Entry):
            binding = literal_of(binding, spot)
        if port.takes_any:
            draft.kind.literal(binding, spot)
    for expression in draft.expressions():
        script.settle(expression, spot)
    for attribute, expression in draft.before.items():
        expression.kind.require(False, attribute, spot)
    for assignments in draft.after.values():
        for assignment in assignments:
            assignment.target.kind.join(assignment.value.kind, spot)


def _collect_texts(drafts: list[Draft], changing: list[Entry]) -> TextTable:
    """Returns all texts that the memory can hold or is compared with."""
    literals: list[tuple[EntryType, str | None]] = []
    for draft in drafts:
        for port, binding in _bound_ports(draft):
            if port.takes_any:
                literals.append((draft.kind, _literal(binding)))
        for expression in draft.expressions():
            literals += script.literals(expression)
    literals += [(entry.kind, entry.literal) for entry in changing]
    texts = TextTable()
    for kind, literal in literals:
        if literal is not None and kind.is_text:
            texts.add(literal)
    return texts


def _literal(binding: str | Entry) -> str | None:
    if isinstance(binding, str):
        return binding
    return None if binding.set_by_nodes else binding.literal


def _own_slots(draft: Draft) -> list[tuple[str, float]]:
    """Returns the names and initial values of a node's numbers in memory."""
    result = []
    if needs_memory({*draft.before, *draft.after}):
        result.append((BEGUN_SLOT, 0.0))
    result += draft.type.slots.items()
    for slot in draft.type.slots_per_child:
        result += [(f"{slot} {i}", 0.0) for i in range(len(draft.children))]
    return result


@dataclass(frozen=True)
class _Finisher:
    slots: list[str]
    initial: list[float]
    texts: TextTable

    def finish(self, draft: Draft) -> Node:
        """Returns the node of a draft, and adds its numbers to the memory."""
        first = len(self.slots)
        own = _own_slots(draft)
        self.slots.extend(f"{draft.spot.node}: {slot}" for slot, _ in own)
        self.initial.extend(value for _, value in own)
        conditions = self.conditions(draft, first)
        if conditions and conditions.slot is not None:
            own = own[1:]
            first += 1
        ports = {
            port.name: self.port_value(draft, port)
            for port in draft.type.ports.values()
        }
        return Node(
            draft.type,
            draft.spot.node,
            draft.spot.place,
            ports,
            tuple(self.finish(child) for child in draft.children),
            first,
            tuple(slot for slot, _ in own),
            conditions,
            draft.owner,
        )

    def port_value(self, draft: Draft, port: Port) -> Constant | Variable:
        binding = draft.bindings.get(port.name)
        if binding is None:
            return Constant(port.default)
        literal = _literal(binding)
        if port.takes_any and literal is not None:
            number = self.texts.number(literal, draft.kind)
            value = literal if draft.kind.is_text else number_of(literal)
            return Constant(value, number)
        if isinstance(binding, str):
            return Constant(port.parse(binding, draft.spot))
        return resolve(binding, port, draft.spot, self.texts.table())

    def conditions(self, draft: Draft, slot: int) -> Conditions | None:
        if not draft.source:
            return None
        scripts: dict[str, Script] = {
            name: script.compiled(expression, self.texts)
            for name, expression in draft.before.items()
        }
        for name, assignments in draft.after.items():
            scripts[name] = tuple(
                instruction
                for assignment in assignments
                for instruction in script.assigning(assignment, self.texts)
            )
        remembers = needs_memory({*scripts})
        return Conditions(scripts, slot if remembers else None, draft.source)
