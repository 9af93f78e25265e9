"""Pre- and post-conditions: attributes that any node can have.

The pre-conditions, `_failureIf`, `_successIf`, `_skipIf` and `_while`, are
checked in this order when the node is to begin: the first that holds (or
`_while` that does not) gives the result instead of the node. While the node is
RUNNING only `_while` is checked, and halts it. (BehaviorTree.CPP does not check
the first child of a WhileDoElse again while another child runs; here it is a
node like any other.)

BehaviorTree.CPP differs where the children of a control node or decorator have
skipped: there it counts as RUNNING until its parent halts it. So it is not
asked again for its `_skipIf`, `_failureIf` and `_successIf`; and being halted,
for instance a ForceFailure, it runs its `_onHalted`. Here a node that was
skipped has not begun: the conditions are checked again in the next tick, and
there is nothing to halt.

The post-conditions, `_onHalted`, `_onFailure`, `_onSuccess` and `_post` (after
both), set blackboard entries.
"""

BEFORE = ("_failureIf", "_successIf", "_skipIf", "_while")
AFTER = ("_onHalted", "_onFailure", "_onSuccess", "_post")

# The slot of a node with one of these conditions: 1 while it runs.
BEGUN_SLOT = "(runs)"
_NEED_MEMORY = frozenset({*BEFORE, "_onHalted"})


def needs_memory(names: set[str]) -> bool:
    """Returns whether a node must remember that it is running."""
    return bool(_NEED_MEMORY & names)
