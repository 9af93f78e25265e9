"""Compiled leaves: functions that `walk` calls by their address.

Such a leaf is compiled, or read from disk, when it is first called.
"""

from typing import Any, NamedTuple

from hunav_drake.systems.behavior.nodes.pointers import leaf_signature
from hunav_drake.systems.behavior.nodes.tick import TICK_RECORD


class CompiledLeaf(NamedTuple):
    """A compiled function of a tick.

    Attributes:
        kernel: The function, a dispatcher of numba.
        ports: The number of its ports.
        remembers: Whether it takes its own numbers.
    """

    kernel: Any
    ports: int
    remembers: bool


def address_of(leaf: CompiledLeaf) -> int:
    """Returns the address of a leaf in this process; compiles it if need be."""
    signature = leaf_signature(TICK_RECORD, leaf.ports, leaf.remembers)
    kernel = leaf.kernel.whole()
    if signature.args not in kernel.overloads:
        kernel.compile(signature)
    made = kernel.overloads[signature.args]
    address: int = made.library.get_pointer_to_function(
        made.fndesc.llvm_func_name
    )
    return address
