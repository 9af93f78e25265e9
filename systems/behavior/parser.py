"""Makes the nodes of a tree from its XML elements.

It goes in two passes: the first makes drafts, whose ports name blackboard
entries; then it is known which entries change and need memory, and the second
makes the nodes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from hunav_drake.systems.behavior.blackboard import (
    Entry,
    Scope,
    checked_key,
    reference,
    resolve,
)
from hunav_drake.systems.behavior.decorators import SUBTREE
from hunav_drake.systems.behavior.documents import Documents, TreeElement
from hunav_drake.systems.behavior.errors import (
    BehaviorTreeError,
    Place,
    unknown,
)
from hunav_drake.systems.behavior.language_actions import Number
from hunav_drake.systems.behavior.node import (
    Constant,
    Node,
    NodeType,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.person import PERSON_MEMORY
from hunav_drake.systems.behavior.registry import ALIASES, NODE_TYPES
from hunav_drake.systems.behavior.xml_source import MAX_DEPTH, XmlElement

# Subtrees in subtrees can make a small file a huge tree.
MAX_NODES = 5000

_GENERIC_TAGS = ("Action", "Condition", "Control", "Decorator")
_SUBTREE_TAGS = ("SubTree", "SubTreePlus")

# What Groot writes for itself.
_NOTES = ("_description", "_fullpath", "_uid")

# Ports that BehaviorTree.CPP 3 calls otherwise.
_PORT_ALIASES = {
    ("Parallel", "success_threshold"): "success_count",
    ("Parallel", "failure_threshold"): "failure_count",
}

# What a literal is whose entry changes later.
_LITERAL = Port("value", Number)

_TRUTHS = {"1": True, "true": True, "0": False, "false": False}


@dataclass
class _Draft:
    type: NodeType
    name: str
    place: Place
    scope: Scope
    bindings: dict[str, str | Entry] = field(default_factory=dict)
    children: list["_Draft"] = field(default_factory=list)

    def fault(self, message: str) -> BehaviorTreeError:
        return BehaviorTreeError(message, self.place, node=self.name)


@dataclass(frozen=True)
class ParsedTree:
    """What the parser gives.

    Attributes:
        name: The ID of the main tree.
        root: Its topmost node.
        slots: What each number of the memory is.
        entries: The blackboard entries of the main tree that have a slot.
        literals: What the entries hold at first that a <SubTree> has set.
    """

    name: str
    root: Node
    slots: tuple[str, ...]
    entries: Mapping[str, int]
    literals: Mapping[int, float]


class _Parser:
    def __init__(self, documents: Documents) -> None:
        self.documents = documents
        self.entries: list[Entry] = []
        self.open_trees: list[str] = []
        self.count = 0

    def tree(self, tree: TreeElement, scope: Scope, depth: int) -> _Draft:
        self.check_text(tree.element)
        (top,) = tree.element.children
        return self.draft(top, scope, tree.format, depth)

    def draft(
        self, element: XmlElement, scope: Scope, form: int, depth: int
    ) -> _Draft:
        self.count += 1
        self.check_size(element, depth)
        self.check_text(element)
        if element.tag in _SUBTREE_TAGS:
            return self.subtree(element, scope, form, depth)
        node_type = _node_type(element)
        name = element.attributes.get("name", node_type.name)
        draft = _Draft(node_type, name, element.place, scope)
        for attribute, text in element.attributes.items():
            self.bind(draft, element, attribute, text)
        self.check_required(draft)
        for child in element.children:
            draft.children.append(self.draft(child, scope, form, depth + 1))
        _check_children(draft)
        return draft

    def check_size(self, element: XmlElement, depth: int) -> None:
        if depth > MAX_DEPTH:
            message = f"nodes are nested more than {MAX_DEPTH} deep"
        elif self.count > MAX_NODES:
            message = f"the tree has more than {MAX_NODES} nodes"
        else:
            return
        raise BehaviorTreeError(
            f"{message}, subtrees included", element.place, node=element.tag
        )

    def check_text(self, element: XmlElement) -> None:
        if element.text:
            raise BehaviorTreeError(
                f"a node holds nodes only, got the text {element.text[:40]!r}",
                element.place,
                node=element.tag,
            )

    def bind(
        self, draft: _Draft, element: XmlElement, attribute: str, text: str
    ) -> None:
        if attribute in ("name", *_NOTES):
            return
        if attribute == "ID" and element.tag in _GENERIC_TAGS:
            return
        if attribute.startswith("_"):
            raise draft.fault(
                f"the condition {attribute} is not supported; use a condition"
                " node"
            )
        if attribute in draft.type.ignored:
            return
        name = _PORT_ALIASES.get((draft.type.name, attribute), attribute)
        port = draft.type.ports.get(name)
        if port is None:
            known = {*draft.type.ports, *draft.type.ignored, "name"}
            raise unknown("port", attribute, known, draft.place, draft.name)
        key = reference(text, name, draft.place, draft.name)
        if port.output:
            key = key or checked_key(text.strip(), draft.place, draft.name)
            entry = draft.scope.entry(key, draft.place)
            entry.set_by_nodes = True
            draft.bindings[name] = entry
        elif key is None:
            draft.bindings[name] = text
        else:
            draft.bindings[name] = draft.scope.entry(key, draft.place)

    def check_required(self, draft: _Draft) -> None:
        for port in draft.type.ports.values():
            if port.default is ... and port.name not in draft.bindings:
                raise draft.fault(f"the port {port.name} must be given")

    def subtree(
        self, element: XmlElement, scope: Scope, form: int, depth: int
    ) -> _Draft:
        def fault(message: str) -> BehaviorTreeError:
            return BehaviorTreeError(message, element.place, node=element.tag)

        tree_id = element.attributes.get("ID")
        if not tree_id:
            raise fault("a subtree must have the attribute ID")
        if element.children:
            raise fault("a subtree cannot have children here")
        tree = self.documents.trees.get(tree_id)
        if tree is None:
            raise unknown(
                "tree",
                tree_id,
                self.documents.trees,
                element.place,
                element.tag,
            )
        if tree_id in self.open_trees:
            chain = " -> ".join([*self.open_trees, tree_id])
            raise fault(f"a tree cannot contain itself: {chain}")
        name = element.attributes.get("name", tree_id)
        draft = _Draft(SUBTREE, name, element.place, scope)
        inner = self.subtree_scope(element, scope, form)
        self.open_trees.append(tree_id)
        draft.children.append(self.tree(tree, inner, depth + 1))
        self.open_trees.pop()
        return draft

    def subtree_scope(
        self, element: XmlElement, scope: Scope, form: int
    ) -> Scope:
        def flag(*names: str) -> bool:
            for name in names:
                text = element.attributes.get(name, "false")
                if text.lower() not in _TRUTHS:
                    raise BehaviorTreeError(
                        f"{name} must be true or false, got {text!r}",
                        element.place,
                        node=element.tag,
                    )
                if _TRUTHS[text.lower()]:
                    return True
            return False

        if flag("__shared_blackboard"):
            return scope
        autoremap = flag("_autoremap", "__autoremap")
        inner = Scope(
            self.entries,
            parent=scope if autoremap else None,
            root=scope.root or scope,
        )
        # A plain SubTree of format 3 names entries without braces.
        bare_keys = form == 3 and element.tag == "SubTree"
        for attribute, text in element.attributes.items():
            if attribute in ("ID", "name") or (
                attribute.startswith("__") or attribute in _NOTES
            ):
                continue
            if attribute == "_autoremap":
                continue
            if attribute.startswith("_"):
                raise BehaviorTreeError(
                    f"the condition {attribute} is not supported; use a"
                    " condition node",
                    element.place,
                    node=element.tag,
                )
            checked_key(attribute, element.place, element.tag)
            key = reference(text, attribute, element.place, element.tag)
            if key is None and bare_keys:
                key = checked_key(text.strip(), element.place, element.tag)
            if key is None:
                inner.constant(attribute, element.place, text)
            else:
                inner.entries[attribute] = scope.entry(key, element.place)
        return inner


def _node_type(element: XmlElement) -> NodeType:
    name = element.tag
    if name in _GENERIC_TAGS:
        name = element.attributes.get("ID", "")
        if not name:
            raise BehaviorTreeError(
                f"<{element.tag}> must have the attribute ID",
                element.place,
                node=element.tag,
            )
    node_type = NODE_TYPES.get(ALIASES.get(name, name))
    if node_type is None:
        raise unknown(
            "node",
            name,
            (*NODE_TYPES, *ALIASES, *_SUBTREE_TAGS),
            element.place,
            name,
        )
    return node_type


def _check_children(draft: _Draft) -> None:
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
    raise draft.fault(f"must have {rule} {noun}, has {count}")


def _finish(draft: _Draft, slots: list[str]) -> Node:
    """Returns the node of a draft, and adds what it remembers to `slots`."""
    first = len(slots)
    own = list(draft.type.slots)
    for slot in draft.type.slots_per_child:
        own += [f"{slot} {i}" for i in range(len(draft.children))]
    slots += [f"{draft.name}: {slot}" for slot in own]
    ports: dict[str, Constant | Variable] = {}
    for port in draft.type.ports.values():
        ports[port.name] = _port_value(draft, port)
    return Node(
        draft.type,
        draft.name,
        draft.place,
        ports,
        tuple(_finish(child, slots) for child in draft.children),
        first,
        tuple(own),
    )


def _port_value(draft: _Draft, port: Port) -> Constant | Variable:
    binding = draft.bindings.get(port.name)
    if binding is None:
        return Constant(port.default)
    if isinstance(binding, str):
        return Constant(port.parse(binding, draft.place, draft.name))
    return resolve(binding, port, draft.place, draft.name, draft.scope.entries)


def _count_slots(draft: _Draft) -> int:
    per_child = len(draft.type.slots_per_child) * len(draft.children)
    below = sum(_count_slots(child) for child in draft.children)
    return len(draft.type.slots) + per_child + below


def parse_documents(documents: Documents) -> ParsedTree:
    """Returns the main tree of some documents.

    Raises:
        BehaviorTreeError: At the first fault in a tree.
    """
    parser = _Parser(documents)
    scope = Scope(parser.entries)
    parser.open_trees.append(documents.main)
    draft = parser.tree(documents.trees[documents.main], scope, 1)

    slots = list(PERSON_MEMORY)
    changing = [entry for entry in parser.entries if entry.set_by_nodes]
    following = len(slots) + _count_slots(draft)
    literals = {}
    for slot, entry in enumerate(changing, following):
        entry.slot = slot
        if entry.literal is not None:
            literals[slot] = _LITERAL.parse(
                entry.literal, entry.place, "SubTree"
            )
    root = _finish(draft, slots)
    slots += [f"{{{entry.key}}}" for entry in changing]
    return ParsedTree(
        documents.main,
        root,
        tuple(slots),
        {
            key: entry.slot
            for key, entry in scope.entries.items()
            if entry.set_by_nodes
        },
        literals,
    )
