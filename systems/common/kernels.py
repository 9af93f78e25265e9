"""How numeric kernels are compiled, and the types of their arguments.

Numba keeps what it compiles beside the source file, for as long as that file
stays the same. It does not notice when a function that was compiled into it,
from another file, has changed: so stale code is dropped first.
"""

import contextlib
import hashlib
import itertools
import os
from pathlib import Path
import re
import secrets

import numba
from numba.core.bytecode import FunctionIdentity
from numba.core.cgutils import get_null_value
from numba.extending import intrinsic, overload
from numba.np.arrayobj import make_array

_FOLDER = Path(__file__).parents[1]
_STAMP = _FOLDER / "__pycache__" / "kernels.sha256"
_JIT = re.compile(rb"\bn?jit(_as)?\b")
_IMPORT = re.compile(rb"^ *from hunav_drake\.systems\.([\w.]+) import", re.M)


def drop_stale_kernels(folder: Path = _FOLDER, stamp: Path = _STAMP) -> bool:
    """Deletes all compiled code if one of its sources has changed.

    They are the files that compile something, and all that these import: a
    constant is compiled in like a function.

    Where nothing can be written, numba keeps its code elsewhere, in a place
    that is named after the folder of the sources.

    Returns:
        Whether the sources differ from what file `stamp` remembers.
    """
    content = hashlib.sha256()
    for path, text in sorted(_compiled_from(folder).items()):
        content.update(f"{path.relative_to(folder)}\n".encode() + text)
    present = content.hexdigest()
    with contextlib.suppress(OSError):
        if stamp.read_text() == present:
            return False
    with contextlib.suppress(OSError):
        for path in folder.rglob("__pycache__/*.nb[ic]"):
            path.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(present)
    return True


def _compiled_from(folder: Path) -> dict[Path, bytes]:
    """Returns the files that compiled code is made of, and their texts."""
    found: dict[Path, bytes] = {}
    todo = [p for p in folder.rglob("*.py") if _JIT.search(p.read_bytes())]
    while todo:
        path = todo.pop()
        if path in found or not path.is_file():
            continue
        found[path] = path.read_bytes()
        for name in _IMPORT.findall(found[path]):
            module = folder / name.decode().replace(".", "/")
            todo += [module.with_suffix(".py"), module / "__init__.py"]
    return found


def number_functions_apart() -> None:
    """Makes numba number what it compiles from a random number on.

    Numba tells functions of one name apart, as two kinds of `sort`, by a
    number, counts from 1 in each process, and keeps the numbers on disk. So
    two processes can keep different functions by the same name. A third one
    that reads both uses the first for both, and crashes (numba issue 10486).
    """
    FunctionIdentity._unique_ids = itertools.count(secrets.randbits(62))


# All compiled code imports this module first.
drop_stale_kernels()
number_functions_apart()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=number_functions_apart)

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
INTEGERS = numba.types.Array(numba.int64, 1, "C", readonly=True)
CHANGED = numba.types.Array(numba.float64, 2, "C")  # It is written to.
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


def unowned(array):
    """Returns an array of an argument's numbers that counts no references.

    Each time that compiled code hands an array on, it counts one more reference
    to its memory, and later one less, which takes longer than a short loop over
    its numbers. Views of this one need not count. They must all be gone when
    the kernel returns: from then on, nothing keeps the memory alive.
    """
    return array


@intrinsic
def _without_owner(typing_context, array):
    def generate(context, builder, signature, arguments):
        view = make_array(array)(context, builder, arguments[0])
        view.meminfo = get_null_value(view.meminfo.type)
        view.parent = get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), generate


@overload(unowned)
def _compiled_unowned(array):
    def compiled(array):
        return _without_owner(array)

    return compiled
