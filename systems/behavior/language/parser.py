"""Parses the nodes of a tree from its XML elements.

There are two passes: this one makes drafts, whose ports name blackboard
entries; `hunav_drake.systems.behavior.language.assembly` then makes the nodes.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from hunav_drake.systems.behavior.language.assembly import Assembled, assemble
from hunav_drake.systems.behavior.language.blackboard import (
    GIVEN,
    Entry,
    Scope,
    checked_key,
    reference,
)
from hunav_drake.systems.behavior.language.documents import (
    Documents,
    TreeElement,
)
from hunav_drake.systems.behavior.language.draft import Draft
from hunav_drake.systems.behavior.language.tree_ports import TreePortError
from hunav_drake.systems.behavior.language.xml_source import (
    MAX_DEPTH,
    NOTES,
    XmlElement,
)
from hunav_drake.systems.behavior.nodes.errors import (
    BehaviorTreeError,
    Place,
    Spot,
)
from hunav_drake.systems.behavior.nodes.language_nodes import SUBTREE
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.registry import (
    ALIASES,
    GENERIC_TAGS,
    NODE_TYPES,
    NODES_BY_PORT,
    PORT_ALIASES,
    SUBTREE_TAGS,
)
from hunav_drake.systems.common.suggest import shown

# Subtrees in subtrees can make a small file a huge tree.
MAX_NODES = 5000

# Attributes of a <SubTree>: those with two underscores are of format 3.
SHARED = ("__shared_blackboard",)
AUTOREMAP = ("_autoremap", "__autoremap")

_BOOLEANS = {"1": True, "true": True, "0": False, "false": False}


@dataclass(frozen=True)
class ParsedTree:
    """The result of the parser.

    Attributes:
        assembled: The nodes of the main tree, and the layout of its memory.
        entries: The blackboard entries of the main tree that have a slot.
        documents: The documents that it was parsed from.
        values: The values of the main tree's ports, as in XML.
    """

    assembled: Assembled
    entries: Mapping[str, int]
    documents: Documents
    values: Mapping[str, str]


# The attributes that name the person that ticks a tree.
_OWNERS = ("agent_id", "main_agent_id")


# The reactions that HuNavSim 2 gives a time limit, and its attributes.
_REACTIONS = ("SurprisedNav", "ScaredNav", "CuriousNav", "ThreateningNav")
_LIMIT = "beh_duration"
LIMITS = {_LIMIT, "only_once"}


class _Parser:
    def __init__(
        self, documents: Documents, node_types: Iterable[NodeType]
    ) -> None:
        self.documents = documents
        self.node_types = {it.name: it for it in node_types}
        self.entries: list[Entry] = []
        self.open_trees: list[str] = []
        self.count = 0

    def tree(self, tree: TreeElement, scope: Scope, depth: int) -> Draft:
        self.check_text(tree.element)
        (top,) = tree.element.children
        return self.draft(top, scope, tree.format, depth)

    def draft(
        self, element: XmlElement, scope: Scope, form: int, depth: int
    ) -> Draft:
        self.count += 1
        self.check_size(element, depth)
        self.check_text(element)
        if element.tag in SUBTREE_TAGS:
            return self.subtree(element, scope, form, depth)
        node_type = self.node_type(element)
        if is_limited(element, node_type):
            return self.draft(_limited(element), scope, form, depth)
        name = element.attributes.get("name", node_type.name)
        draft = Draft(node_type, Spot(element.place, name), scope)
        for attribute, text in element.attributes.items():
            self.bind(draft, element, attribute, text)
        for port in node_type.ports.values():
            if port.default is ... and port.name not in draft.bindings:
                raise draft.spot.fault(f"the port {port.name} must be given")
        for child in element.children:
            draft.children.append(self.draft(child, scope, form, depth + 1))
        _check_children(draft)
        return draft

    def node_type(self, element: XmlElement) -> NodeType:
        name = node_name(element)
        node_type = self.node_types.get(name)
        if node_type is None:
            known = (*self.node_types, *ALIASES, *SUBTREE_TAGS)
            raise Spot(element.place, name).unknown("node", name, known)
        return node_type

    def check_size(self, element: XmlElement, depth: int) -> None:
        if depth > MAX_DEPTH:
            message = f"nodes are nested more than {MAX_DEPTH} deep"
        elif self.count > MAX_NODES:
            message = f"the tree has more than {MAX_NODES} nodes"
        else:
            return
        raise element.spot.fault(f"{message}, subtrees included")

    def check_text(self, element: XmlElement) -> None:
        if element.text:
            raise element.spot.fault(
                f"a node holds nodes only, got the text {element.text[:40]!r}"
            )

    def bind(
        self, draft: Draft, element: XmlElement, attribute: str, text: str
    ) -> None:
        if attribute in ("name", *NOTES):
            return
        if attribute == "ID" and element.tag in GENERIC_TAGS:
            return
        if attribute.startswith("_"):
            draft.add_condition(attribute, text)
            return
        if attribute in draft.type.ignored:
            is_number = attribute in _OWNERS and text.strip().isdecimal()
            if is_number and draft.type.is_social:
                draft.owner = int(text)
            return
        name = PORT_ALIASES.get((draft.type.name, attribute), attribute)
        port = draft.type.ports.get(name)
        if port is None:
            known = {*draft.type.ports, *draft.type.ignored, "name"}
            raise draft.spot.unknown("port", attribute, known)
        key = reference(text, name, draft.spot)
        if port.output:
            key = key or checked_key(text.strip(), draft.spot)
            entry = draft.scope.entry(key, draft.spot.place)
            entry.set_by_nodes = True
            draft.bindings[name] = entry
        elif key is None:
            draft.bindings[name] = text
        else:
            draft.bindings[name] = draft.scope.entry(key, draft.spot.place)

    def subtree(
        self, element: XmlElement, scope: Scope, form: int, depth: int
    ) -> Draft:
        fault = element.spot.fault
        tree_id = element.attributes.get("ID")
        if not tree_id:
            raise fault("a subtree must have the attribute ID")
        if element.children:
            raise fault("a subtree cannot have children here")
        tree = self.documents.trees.get(tree_id)
        if tree is None:
            raise element.spot.unknown("tree", tree_id, self.documents.trees)
        if tree_id in self.open_trees:
            chain = " -> ".join([*self.open_trees, tree_id])
            raise fault(f"a tree cannot contain itself: {chain}")
        name = element.attributes.get("name", tree_id)
        draft = Draft(SUBTREE, Spot(element.place, name), scope)
        for attribute, text in element.attributes.items():
            if attribute.startswith("_") and attribute not in (
                *NOTES,
                *SHARED,
                *AUTOREMAP,
            ):
                draft.add_condition(attribute, text)
        inner = self.subtree_scope(element, scope, form, name)
        self.open_trees.append(tree_id)
        draft.children.append(self.tree(tree, inner, depth + 1))
        self.open_trees.pop()
        self.check_ports(element, inner)
        return draft

    def check_ports(self, element: XmlElement, inner: Scope) -> None:
        """Checks that a tree which declares ports knows those given to it."""
        declared = {
            port.attributes.get("name", "")
            for model in self.documents.models
            for tree in model.children
            if tree.attributes.get("ID") == element.attributes["ID"]
            for port in tree.children
        }
        for attribute in subtree_ports(element, 4):
            known = {*declared, *GIVEN, *inner.used}
            if declared and attribute not in known:
                raise element.spot.unknown("port", attribute, known)

    def subtree_scope(
        self, element: XmlElement, scope: Scope, form: int, name: str
    ) -> Scope:
        if flag(element, SHARED):
            return scope
        autoremap = flag(element, AUTOREMAP)
        inner = Scope(
            self.entries,
            parent=scope if autoremap else None,
            root=scope.root or scope,
            name=name,
        )
        given = subtree_ports(element, form)
        declared = self.documents.ports.get(element.attributes["ID"], {})
        for port in declared.values():
            if port.name in given or autoremap:
                continue
            if port.default is None:
                if port.name in GIVEN:
                    continue
                raise element.spot.fault(
                    f"the port {port.name} must be given: the TreeNodesModel"
                    f" at {port.place} has no default for it"
                )
            given[port.name] = port.default
        for attribute, text in given.items():
            key = reference(text, attribute, element.spot)
            if key is None:
                inner.constant(attribute, element.place, text)
            else:
                inner.entries[attribute] = scope.entry(key, element.place)
        return inner


def flag(element: XmlElement, names: tuple[str, ...]) -> bool:
    """Returns whether one of several attributes is true."""
    for name in names:
        text = element.attributes.get(name, "false")
        if text.lower() not in _BOOLEANS:
            raise element.spot.fault(
                f"{name} must be true or false, got {shown(text)}"
            )
        if _BOOLEANS[text.lower()]:
            return True
    return False


def subtree_ports(element: XmlElement, form: int) -> dict[str, str]:
    """Returns the ports that a <SubTree> gives to its tree, as in format 4.

    A plain SubTree of format 3 names entries without braces.
    """
    bare_keys = form == 3 and element.tag == "SubTree"
    result = {}
    for attribute, text in element.attributes.items():
        if attribute in ("ID", "name") or attribute.startswith("_"):
            continue
        checked_key(attribute, element.spot)
        if bare_keys and not reference(text, attribute, element.spot):
            text = f"{{{checked_key(text.strip(), element.spot)}}}"
        result[attribute] = text
    return result


def node_name(element: XmlElement) -> str:
    """Returns the name of the type of an element's node."""
    name = element.tag
    if name in GENERIC_TAGS:
        name = element.attributes.get("ID", "")
        if not name:
            raise element.spot.fault(
                f"<{element.tag}> must have the attribute ID"
            )
    name = ALIASES.get(name, name)
    node_type = NODE_TYPES.get(name)
    # (A user's own node may have such a port.)
    own = node_type.ports if node_type else ()
    given = (it for it in element.attributes if it not in own)
    others = (NODES_BY_PORT.get((name, it)) for it in given)
    return next(filter(None, others), name)


def is_limited(element: XmlElement, node_type: NodeType) -> bool:
    """Returns whether an element is a reaction with HuNavSim 2's time limit."""
    return (
        node_type.name in _REACTIONS
        and not LIMITS.isdisjoint(element.attributes)
        # (A user's own node may have such a port.)
        and LIMITS.isdisjoint(node_type.ports)
    )


def _limited(element: XmlElement) -> XmlElement:
    """Returns a reaction of HuNavSim 2 as our nodes: with its time limit."""
    attributes = dict(element.attributes)
    seconds = attributes.pop(_LIMIT, None)
    once = attributes.pop("only_once", "false")
    if seconds is None:
        return replace(element, attributes=attributes)
    # Its pre- and post-conditions are of the whole: who skips it, does not use
    # up its time.
    around = {
        name: attributes.pop(name)
        for name in element.attributes
        if name.startswith("_") and name not in NOTES
    }
    reaction = replace(element, attributes=attributes)
    timer = {"seconds": seconds, "only_once": once}
    expired = XmlElement("HasRunFor", timer, element.place)
    going = XmlElement("Inverter", {}, element.place, [expired])
    return XmlElement("Sequence", around, element.place, [going, reaction])


def _check_children(draft: Draft) -> None:
    low, high = draft.type.children
    count = len(draft.children)
    if low <= count <= high:
        return
    if high == low:
        rule = f"exactly {low}" if low else "no"
    elif high > 10:
        rule = f"at least {low}"
    else:
        rule = f"{low} or {high}"
    noun = "child" if high == 1 else "children"
    raise draft.spot.fault(f"must have {rule} {noun}, has {count}")


def parse_documents(
    documents: Documents,
    values: Mapping[str, str] = MappingProxyType({}),
    node_types: Iterable[NodeType] | None = None,
) -> ParsedTree:
    """Parses the main tree of documents.

    `values` are those of ports of the main tree, as in XML; the other ports
    have their defaults. `node_types` are the known node types, by default all
    that are registered.
    """
    if node_types is None:
        node_types = NODE_TYPES.values()
    parser = _Parser(documents, node_types)
    scope = Scope(parser.entries)
    for port in documents.ports.get(documents.main, {}).values():
        if port.name in GIVEN and port.default is not None:
            raise BehaviorTreeError(
                f"the port {port.name} of the main tree cannot have a"
                f" default: {GIVEN[port.name]}",
                port.place,
            )
    all_values = {}
    for port in documents.main_ports().values():
        value = values.get(port.name, port.default)
        if value is not None:
            scope.constant(port.name, port.place, value)
            all_values[port.name] = value
    parser.open_trees.append(documents.main)
    draft = parser.tree(documents.trees[documents.main], scope, 1)
    for name in values:
        # (One without a default must be given.)
        has_default = documents.main_ports()[name].default is not None
        if has_default and name not in scope.used:
            raise TreePortError(
                "no node of the tree uses it; leave it out",
                Place(documents.file),
                port=name,
            )
    assembled = assemble(draft, parser.entries)
    entries = {
        key: entry.slot
        for key, entry in scope.entries.items()
        if entry.set_by_nodes
    }
    return ParsedTree(assembled, entries, documents, all_values)
