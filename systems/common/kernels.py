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
    """Returns the decorator `jit` for fixed types.

    A function is compiled, or read from disk, when it is first used: a command
    that uses few of them need not wait for all.
    """
    signature = result(*arguments)

    def decorate(function):
        return _compiled_when_used(jit(function), signature)

    return decorate


def _compiled_when_used(kernel, signature):
    """Holds a dispatcher of numba to one signature; it is compiled later."""
    call_template = kernel.get_call_template

    def fix():
        if not kernel.overloads:
            kernel.compile(signature)
            # From now on, other types are refused, and numbers converted.
            kernel.disable_compile()

    def compile_for_args(*values, **_):
        # Numba asks for this at the first call from Python alone.
        fix()
        if len(values) != len(signature.args):
            raise TypeError(
                f"{kernel.__name__} takes {len(signature.args)} arguments, got"
                f" {len(values)}"
            )
        for value, wanted in zip(values, signature.args, strict=True):
            given = kernel.typeof_pyval(value)
            if kernel.typingctx.can_convert(given, wanted) is None:
                raise TypeError(
                    f"No matching definition of {kernel.__name__} for an"
                    f" argument of the type {given}; it takes {wanted}"
                )
        return kernel.get_overload(signature)

    def get_call_template(types, keywords):
        # Asked for when another kernel that calls this one is compiled.
        fix()
        return call_template(types, keywords)

    kernel._compile_for_args = compile_for_args
    kernel.get_call_template = get_call_template
    return kernel
