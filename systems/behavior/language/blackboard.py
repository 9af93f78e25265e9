"""The blackboard entries of a tree that is being parsed.

An entry that nothing sets is a constant; every other has a slot in the
tree's memory, and holds numbers (or booleans), or texts.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
import re
from types import MappingProxyType

from hunav_drake.systems.behavior.language.entry_types import EntryType
from hunav_drake.systems.behavior.nodes.errors import Place, Spot
from hunav_drake.systems.behavior.nodes.port import Constant, Port, Variable
from hunav_drake.systems.common.suggest import shown

# `{key}`, and `${key}` as BehaviorTree.CPP 3 also writes it.
_REFERENCE = re.compile(r"\$?\{(.*)\}", re.DOTALL)
_KEY = re.compile(r"@?[A-Za-z_][\w.]*", re.ASCII)

# The entries that every person has on the blackboard, and their meanings.
GIVEN: Mapping[str, str] = MappingProxyType(
    {
        "id": "it is the number of the person",
        "dt": "it is the time step in seconds",
    }
)


@dataclass(eq=False)
class Entry:
    """An entry of the blackboard.

    Attributes:
        key: Its first name.
        place: The place of its first use.
        scope: The scope in which it has this name.
        literal: The text that it has from the start, or None.
        set_by_nodes: Whether a node, or the person, gives it a value.
        slot: Its index in the memory, once that is known.
        kind: Whether it holds numbers or texts.
    """

    key: str
    place: Place
    scope: "Scope"
    literal: str | None = None
    set_by_nodes: bool = False
    slot: int = -1
    kind: EntryType = field(default_factory=EntryType)

    def __str__(self) -> str:
        """Returns its name, with the name of its subtree."""
        return f"{{{self.key}}}" + (
            f" of {self.scope.name}" if self.scope.name else ""
        )


@dataclass
class Scope:
    """The entries that the nodes of one tree or subtree can refer to.

    Attributes:
        entries: The entries by name.
        all_entries: Those of all scopes, in the order of their appearance.
        parent: The scope of the tree around it, if names that are not in
            this scope are looked up there.
        root: The scope of the main tree; None in itself.
        name: The name of the subtree; empty for the main tree.
        used: The names that nodes refer to.
    """

    all_entries: list[Entry]
    entries: dict[str, Entry] = field(default_factory=dict)
    parent: "Scope | None" = None
    root: "Scope | None" = None
    name: str = ""
    used: set[str] = field(default_factory=set)

    def entry(self, key: str, place: Place) -> Entry:
        """Returns the entry of a name; makes it if it does not exist."""
        if key.startswith("@"):
            return (self.root or self).entry(key[1:], place)
        self.used.add(key)
        if key not in self.entries:
            # Names with an underscore stay private to a tree.
            if self.parent is not None and not key.startswith("_"):
                self.entries[key] = self.parent.entry(key, place)
            else:
                given = not self.root and key in GIVEN
                entry = Entry(key, place, self, set_by_nodes=given)
                if given:
                    entry.kind.require(False, f"{{{key}}}", Spot(place, key))
                self.all_entries.append(entry)
                self.entries[key] = entry
        return self.entries[key]

    def constant(self, key: str, place: Place, literal: str) -> None:
        """Makes an entry with a constant value."""
        self.entries[key] = Entry(key, place, self, literal)
        self.all_entries.append(self.entries[key])


def reference(text: str, port: str, spot: Spot) -> str | None:
    """Returns the key in `{key}`, or None for a literal; `{=}` names the port.

    Raises:
        BehaviorTreeError: If the text between the braces is not a name.
    """
    match = _REFERENCE.fullmatch(text.strip())
    if match is None:
        return None
    key = match[1].strip()
    return checked_key(port if key == "=" else key, spot)


def checked_key(key: str, spot: Spot) -> str:
    """Returns the name of an entry if it is valid."""
    if not _KEY.fullmatch(key):
        raise spot.fault(
            f"a blackboard entry is named by letters, digits and _, got"
            f" {shown(key)}"
        )
    return key


def literal_of(entry: Entry, spot: Spot) -> str:
    """Returns the literal of an entry that no node sets."""
    if entry.literal is not None:
        return entry.literal
    known = {
        name
        for name, other in entry.scope.entries.items()
        if other.set_by_nodes or other.literal is not None
    }
    raise spot.unknown("node that sets the entry", entry.key, {*known, *GIVEN})


def resolve(
    entry: Entry, port: Port, spot: Spot, texts: tuple[str, ...]
) -> Constant | Variable:
    """Returns the value of a port that refers to an entry."""
    if entry.set_by_nodes:
        return Variable(
            entry.key, entry.slot, texts if entry.kind.is_text else None
        )
    return Constant(port.parse(literal_of(entry, spot), spot))
