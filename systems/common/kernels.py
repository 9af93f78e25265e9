"""How numeric kernels are compiled, and the types of their arguments."""

import numba

from hunav_drake.systems.common.kernel_cache import drop_stale_kernels

# All compiled code imports this module first.
drop_stale_kernels()

# How the numeric kernels are compiled: on disk for the next process, and with
# IEEE results for divisions by zero.
jit = numba.njit(cache=True, error_model="numpy")

# Generators are not kept on disk: numba 0.68 fails (KeyError) to compile what
# calls one that was read from there. Only who compiles a caller needs them.
jit_generator = numba.njit(error_model="numpy")

# Types of arguments, for functions that Python calls: with fixed types they
# are compiled once, whether or not Drake hands out read-only arrays.
VECTOR = numba.types.Array(numba.float64, 1, "C", readonly=True)
MATRIX = numba.types.Array(numba.float64, 2, "C", readonly=True)
WALLS = VECTOR  # `Obstacles.table`: `opened` by `systems/world/walls.py`.
REAL = numba.float64
INTEGER = numba.int64


def jit_as(result, *arguments):
    """Returns the decorator `jit` for fixed types."""
    return numba.njit(result(*arguments), cache=True, error_model="numpy")
