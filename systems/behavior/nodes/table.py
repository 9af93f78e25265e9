"""The tables of a tree that compiled code walks over."""

import numpy as np

# The row of a node; rows are from the top down. Scripts are the indices of
# their first instructions, or -1.
_ROW = (
    # Its operation, and the numbers of that.
    *("operation", "a", "b", "c", "d"),
    # The row of the node above it, its place there, the number of its children,
    # the row after those, and whether it, or a node below, counts.
    *("parent", "index", "children", "end", "counts"),
    # The first slot of it and all below; of its own numbers, and how many; of
    # the flags that it has begun, and that an action runs, or -1.
    *("slots", "first", "size", "begun", "running"),
    # The first of its ports, how many, and whether any must be checked.
    *("first_port", "num_ports", "is_checked"),
    # The address of a compiled leaf; 0 until it is called.
    "leaf",
    # Whether anything is to be asked before it begins; its scripts.
    *("asks", "failure_if", "success_if", "skip_if", "holds_while"),
    *("on_halted", "on_failure", "on_success"),
)
ROW = np.dtype([(name, np.int64) for name in _ROW])

# A number in memory: it is reset when its node is halted if the slot `flag` is
# not 0; never, if that is -1.
SLOT = np.dtype([("flag", np.int64), ("initial", np.float64)])

# A port: the slot of its entry or -1, and the numbers that surely fit it.
PORT = np.dtype(
    [
        ("slot", np.int64),
        ("low", float),
        ("high", float),
        ("is_whole", np.int64),
    ]
)

# An instruction of a script; each script ends with code -1.
STEP = np.dtype([("code", np.int64), ("value", np.float64)])
