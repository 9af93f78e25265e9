"""The tables of a tree that compiled code walks over."""

from typing import get_type_hints

import numpy as np


class Row:
    """The fields of the row of a node; rows are from the top down.

    Scripts are the indices of their first instructions, or -1.
    """

    # Its operation, and the numbers of that.
    operation: int
    a: int
    b: int
    c: int
    d: int

    # The row of the node above it, its place there, the number of its
    # children, and the row after those.
    parent: int
    index: int
    children: int
    end: int

    # Whether it, or a node below, counts cycles or steps.
    counts: int

    # The first slot of it and all below; of its own numbers, and how many; of
    # the flags that it has begun, and that an action runs, or -1.
    slots: int
    first: int
    size: int
    begun: int
    running: int

    # The first of its ports, how many, and whether any must be checked.
    first_port: int
    num_ports: int
    is_checked: int

    # The address of a compiled leaf; 0 until it is called.
    leaf: int

    # Whether anything is to be asked before it begins; its scripts.
    asks: int
    failure_if: int
    success_if: int
    skip_if: int
    holds_while: int
    on_halted: int
    on_failure: int
    on_success: int


ROW = np.dtype([(name, np.int64) for name in get_type_hints(Row)])

# A number in memory: it is reset when its node is halted if the slot `flag` is
# not 0; never, if that is -1.
SLOT = np.dtype([("flag", np.int64), ("initial", np.float64)])

# A port: the slot of its entry or -1, and the numbers that surely fit it.
PORT = np.dtype(
    [
        ("slot", np.int64),
        ("low", np.float64),
        ("high", np.float64),
        ("is_whole", np.int64),
    ]
)

# An instruction of a script; each script ends with code -1.
STEP = np.dtype([("code", np.int64), ("value", np.float64)])
