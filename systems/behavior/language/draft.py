"""Drafts: nodes while their tree is parsed, with ports that name entries."""

from dataclasses import dataclass, field

from hunav_drake.systems.behavior.language.blackboard import Entry, Scope
from hunav_drake.systems.behavior.language.entry_types import EntryType
from hunav_drake.systems.behavior.language.script import (
    Assignment,
    Expression,
    bind,
    read_assignments,
    read_condition,
)
from hunav_drake.systems.behavior.language.xml_source import NOTES
from hunav_drake.systems.behavior.nodes.errors import Spot
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.pre_post_conditions import AFTER, BEFORE


@dataclass
class Draft:
    """A node that is being parsed.

    Attributes:
        type: Its node type.
        spot: Its name and place.
        scope: The entries that it can name.
        bindings: For each port that is given, its text or its entry.
        before: Its pre-conditions by attribute.
        after: Its post-conditions by attribute.
        source: The texts of both.
        kind: The common type of its ports that take any entry.
        children: The nodes under it.
        owner: As `Node.owner`.
    """

    type: NodeType
    spot: Spot
    scope: Scope
    bindings: dict[str, str | Entry] = field(default_factory=dict)
    before: dict[str, Expression] = field(default_factory=dict)
    after: dict[str, tuple[Assignment, ...]] = field(default_factory=dict)
    source: dict[str, str] = field(default_factory=dict)
    kind: EntryType = field(default_factory=EntryType)
    children: list["Draft"] = field(default_factory=list)
    owner: int | None = None

    def add_condition(self, attribute: str, text: str) -> None:
        """Parses a pre- or post-condition."""
        if attribute not in BEFORE and attribute not in AFTER:
            known = (*BEFORE, *AFTER, *NOTES)
            raise self.spot.unknown("condition", attribute, known)
        self.source[attribute] = text
        try:
            if attribute in BEFORE:
                self.before[attribute] = read_condition(text)
            else:
                self.after[attribute] = read_assignments(text)
        except ValueError as error:
            raise self.spot.fault(
                f"{attribute}={text[:80]!r}: {error}"
            ) from error
        for assignment in self.after.get(attribute, ()):
            bind(assignment.target, self.scope, self.spot.place)
            if assignment.target.entry is not None:
                assignment.target.entry.set_by_nodes = True
        for expression in self.expressions():
            bind(expression, self.scope, self.spot.place)

    def expressions(self) -> list[Expression]:
        """Returns the expressions in its pre- and post-conditions."""
        result = list(self.before.values())
        for assignments in self.after.values():
            for assignment in assignments:
                result += [assignment.target, assignment.value]
        return result
