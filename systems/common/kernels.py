"""Compiles numeric kernels, and has the types of their arguments.

Numba keeps compiled code beside the source file, as long as that file stays the
same. It does not notice when a function that was compiled into it, from another
file, has changed: so stale code is dropped first. Nor does it notice when a
file was damaged, or written by two processes at a time: so each has a checksum
here, and damaged code is compiled anew.
"""

from collections import namedtuple
from collections.abc import Callable
import contextlib
import dataclasses
import fcntl
import functools
import hashlib
import io
import itertools
import os
from pathlib import Path
import pickle
import re
import secrets
import sys
import time
import warnings
import zlib

import llvmlite.binding as llvm
import numba
from numba.core import environment as environments
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
)
from numba.core.cgutils import get_null_value
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, compile_result
from numba.core.compiler_lock import global_compiler_lock
from numba.core.event import trigger_event
from numba.core.runtime import rtsys
from numba.extending import intrinsic, overload
from numba.np.arrayobj import make_array, populate_array
from numba.np.unsafe.ndarray import to_fixed_tuple

_FOLDER = Path(__file__).parents[1]
_STAMP = _FOLDER / "__pycache__" / "kernels.sha256"
_JIT = re.compile(rb"(jit(_as|_part)?|late_as|part_as)\b")
_IMPORT = re.compile(rb"from hunav_drake\.systems\.([\w.]+) import")


def hash_sources(folder: Path = _FOLDER) -> str:
    """Returns a hash of all sources of compiled code.

    They are the files that compile something, and all that these import: a
    constant is compiled in like a function.
    """
    content = hashlib.sha256()
    for path, text in sorted(_compiled_from(folder).items()):
        content.update(f"{path}\n".encode() + text)
    return content.hexdigest()


def drop_stale_kernels(
    present: str, folder: Path = _FOLDER, stamp: Path = _STAMP
) -> bool:
    """Deletes all compiled code if one of its sources has changed.

    Where nothing can be written, numba keeps its code elsewhere, in a place
    that is named after the folder of the sources: there it is not read. The
    stamp is the file that keeps the hash. Returns whether the present one, from
    `hash_sources`, differs from it.
    """
    with contextlib.suppress(OSError):
        if stamp.read_text() == present:
            return False
    with contextlib.suppress(OSError):
        for path in folder.rglob("__pycache__/*.nb[ic]"):
            path.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(present)
    return True


def _compiled_from(folder: Path) -> dict[str, bytes]:
    """Returns the sources of compiled code, by their paths in the folder."""
    # (This is part of each start, so paths are texts.)
    start = len(f"{folder}/")
    texts = {str(p)[start:]: p.read_bytes() for p in folder.rglob("*.py")}
    found: dict[str, bytes] = {}
    todo = [path for path, text in texts.items() if _JIT.search(text)]
    while todo:
        path = todo.pop()
        if path in found or path not in texts:
            continue
        found[path] = texts[path]
        for name in _IMPORT.findall(found[path]):
            module = name.decode().replace(".", "/")
            todo += [f"{module}.py", f"{module}/__init__.py"]
    return found


def number_functions_apart() -> None:
    """Makes numba number compiled functions from a random number on.

    Numba distinguishes functions of one name, as two kinds of `sort`, by a
    number, counts from 1 in each process, and keeps the numbers on disk. So
    two processes can keep different functions under the same name. A third one
    that reads both uses the first for both, and crashes (numba issue 10486).
    """
    FunctionIdentity._unique_ids = itertools.count(secrets.randbits(62))


# All compiled code imports this module first.
SOURCES = hash_sources()
drop_stale_kernels(SOURCES)
number_functions_apart()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=number_functions_apart)


class _Unpickler(pickle.Unpickler):
    """Loads code without the modules of numba that its parts are from."""

    def find_class(self, module, name):
        if (module, name) == (environments.__name__, "_rebuild_env"):
            return _light_environment
        return super().find_class(module, name)


def _light_environment(module, constants, name):
    # Machine code needs the constants only. The globals, which some of numba's
    # functions load SciPy for, are those of code with Python objects.
    own = module.startswith("numba.") and module not in sys.modules
    return environments._rebuild_env(
        "numba" if own else module, constants, name
    )


class _CheckedFiles(IndexDataCacheFile):
    """The index and the code of a kernel on disk, with checksums."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._version += f" {SOURCES}"

    def save(self, key, data):
        super().save(key, (key, data))

    def load(self, key):
        # Of two processes at a time, one may write the index, one the code.
        found = super().load(key)
        return found[1] if found and found[0] == key else None

    def _dump(self, obj):
        data = super()._dump(obj)
        return data + self._checksum(data)

    def _load_data(self, name):
        file = Path(self._data_path(name)).read_bytes()
        data, checksum = file[:-32], file[-32:]
        if checksum != self._checksum(data):
            raise ValueError("is damaged")
        return _Unpickler(io.BytesIO(data)).load()

    def _checksum(self, data):
        return hashlib.sha256(self._version.encode() + data).digest()


class _KeptCode(FunctionCache):
    """The code of a kernel on disk: damage, or a full disk, does no harm."""

    is_told = False
    _suffix = ""

    def __init__(self, function):
        super().__init__(function)
        self._cache_file = _CheckedFiles(
            self.cache_path,
            self._impl.filename_base + self._suffix,
            self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, sig, target_context):
        # Code from the disk needs only numba's runtime. What numba loads here
        # by itself, also SciPy, is for compiling, and takes 0.4 s.
        rtsys.initialize(target_context)
        try:
            return self._load_overload(sig, target_context)
        # Damaged code may fail anywhere in the unpacking.
        except Exception:
            self._tell("is damaged; it is compiled anew")
        try:
            self.flush()
        except OSError:
            self.disable()
        return None

    def save_overload(self, sig, data):
        try:
            super().save_overload(sig, data)
        except OSError as error:
            self.disable()
            self._tell(
                f"cannot be kept there ({error.strerror}): each run compiles it"
                " anew"
            )

    def _tell(self, fault):
        if not _KeptCode.is_told:
            _KeptCode.is_told = True
            warnings.warn(
                f"compiled code in {self.cache_path} {fault}",
                RuntimeWarning,
                stacklevel=2,
            )


@functools.cache
def keeps_code() -> bool:
    """Returns whether there is a folder to keep compiled code in."""
    with contextlib.suppress(RuntimeError):
        return bool(_KeptCode(hash_sources).cache_path)
    return False


# How long one waits for a process that has a kernel, in seconds: quietly, and
# until it is compiled here, too.
_MOMENT, _PATIENCE = 0.5, 120.0

# The kernels that this process compiles, each for the one before.
_held: list[int] = []

# What this process compiles while it waits for another one, the last one first.
meanwhile: list[Callable[[], object]] = []


@contextlib.contextmanager
def _locked(kernel, *, waits):
    """Has a kernel for this process alone; yields whether it does.

    Processes that need the same kernel wait for the one that compiles it,
    instead of compiling it, too. The lock is a byte of a file beside the code
    that is kept, and ends with its process. Where nothing is kept, or can be
    locked, nobody waits.
    """
    byte = zlib.crc32(f"{kernel.__module__}:{kernel.__name__}".encode())
    locks, held = _lock_file(kernel._cache.cache_path), False
    try:
        # (Who only reads the code holds the lock for a moment.)
        moment = 0.0 if meanwhile else _MOMENT
        held = _lock(locks, byte, moment if waits else 0.0)
        if not held and not waits:
            yield False
            return
        if not held:
            # The time of waiting counts as that of compiling.
            with trigger_event("numba:compile", {"dispatcher": kernel}):
                held = _lock(locks, byte, _PATIENCE)
    except (OSError, TypeError):
        pass
    _held.append(byte)
    try:
        yield True
    finally:
        _held.pop()
        if held:
            fcntl.lockf(locks, fcntl.LOCK_UN, 1, byte)


def _lock(locks, byte, patience):
    """Locks a byte of a file; returns whether it could, in so many seconds.

    Who holds it may have been stopped (Ctrl-Z).
    """
    end = time.monotonic() + patience
    while True:
        try:
            fcntl.lockf(locks, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            # (Another process may wait for what is held here.)
            ahead = None
            if not _held and patience == _PATIENCE:
                # (Another thread may clear it.)
                with contextlib.suppress(IndexError):
                    ahead = meanwhile.pop()
            if ahead is not None:
                ahead()
            else:
                time.sleep(0.01)
        else:
            return True


@functools.cache
def _lock_file(folder):
    """Returns the file of locks of a folder, or None if there is none."""
    with contextlib.suppress(OSError, TypeError):
        name = os.path.join(folder, "kernels.lock")
        return os.open(name, os.O_RDWR | os.O_CREAT, 0o666)
    return None


# Numba measures the time of each call of LLVM, which nobody asks for: that is a
# twentieth of the time of compiling.
with contextlib.suppress(AttributeError):
    llvm.ffi.lib._lock._cblist.clear()

# The options of all that is compiled. Division by zero is IEEE's. `fastmath` is
# never among them: it lets LLVM fuse and reorder, differently in each copy of
# a function that is inlined into callers, and which copy runs depends on what
# was compiled here and what was read from disk.
_compiled = numba.njit(error_model="numpy")


class _PartLibrary(JITCodeLibrary):
    """The LLVM code of a part of kernels, as numba generates it.

    LLVM optimizes it, and makes machine code of it, in each kernel. Numba does
    so for each function alone, too, which is a third of the time of compiling.
    """

    @classmethod
    def read(cls, codegen, data):
        name, bitcode = data
        part = cls(codegen, name)
        part._final_module = llvm.parse_bitcode(bitcode)
        part._finalize_final_module()
        return part

    def serialize_using_object_code(self):
        return self.name, self._get_module_for_linking().as_bitcode()

    def get_pointer_to_function(self, name):
        del name
        self._ensure_finalized()
        return 0  # There is no such machine code.

    @property
    def codegen(self):
        return self  # It is only asked to `set_env`.

    def set_env(self, name, environment):
        """Does nothing: see `_whole`."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


class _PartCompiler(Compiler):
    """Compiles a part of kernels."""

    def define_pipelines(self):
        codegen = self.state.targetctx.codegen()
        name = self.state.func_id.func_qualname
        self.state.library = _PartLibrary(codegen, name)
        return super().define_pipelines()


# What numba keeps of a compiled function, after its code.
_KEPT_FIELDS = (
    *("fndesc", "environment", "signature", "objectmode", "lifted"),
    *("type_annotation", "reload_init", "referenced_envs"),
)


class _PartsOnDisk(CompileResultCacheImpl):
    """Reads the code of parts."""

    def rebuild(self, target_context, payload):
        code, *values = payload
        part = _PartLibrary.read(target_context.codegen(), code)
        fields = dict(zip(_KEPT_FIELDS, values, strict=True))
        fields["entry_point"] = target_context.get_executable(
            part, fields["fndesc"], fields["environment"]
        )
        return compile_result(
            typing_context=target_context.typing_context,
            target_context=target_context,
            library=part,
            **fields,
        )


class _KeptPart(_KeptCode):
    """The code of a part on disk."""

    _impl_class = _PartsOnDisk
    _suffix = "-part"


def _whole(function):
    """Compiles a function that Python calls, and keeps it on disk.

    If numba finds no folder for it, each process compiles anew.
    """
    kernel = _compiled(function)
    add_overload = kernel.add_overload

    def add_with_parts(result):
        # Numba sets those of functions with machine code of their own.
        for environment in result._find_referenced_environments():
            result.codegen.set_env(environment.env_name, environment)
        add_overload(result)

    kernel.add_overload = add_with_parts
    with contextlib.suppress(RuntimeError):
        kernel._cache = _KeptCode(function)
    return kernel


_compiled_part = numba.njit(
    error_model="numpy",
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    pipeline_class=_PartCompiler,
)


def jit_part(function):
    """Compiles a part of kernels.

    Called from Python, as by tests, it is compiled as a kernel of its own:
    `part.whole()`.
    """
    part = _compiled_part(function)

    def add_overload(result):
        part.overloads[tuple(result.signature.args)] = result

    @functools.cache
    def whole():
        return _whole(function)

    def compile_for_args(*values, **named):
        # (One thread compiles, the others wait for it.)
        with global_compiler_lock:
            own = part.whole()
            known = len(own.overloads)
            entry = own._compile_for_args(*values, **named)
            for result in [*own.overloads.values()][known:]:
                types = [it._code for it in result.signature.args]
                part._insert(types, result.entry_point, False)
        return entry

    def reduce(protocol):
        # By its name, as other functions: its machine code is elsewhere.
        found = sys.modules.get(function.__module__)
        for name in function.__qualname__.split("."):
            found = getattr(found, name, None)
        if found is part:
            return function.__qualname__
        return type(part).__reduce_ex__(part, protocol)

    part.whole = whole
    part.__reduce_ex__ = reduce
    part.add_overload = add_overload
    part._compile_for_args = compile_for_args
    return part


def jit(function):
    """Compiles a part of kernels, and keeps it on disk.

    If numba finds no folder for it, each process compiles anew.
    """
    part = jit_part(function)
    with contextlib.suppress(RuntimeError):
        part._cache = _KeptPart(function)
    return part


def part_as(result, *arguments):
    """Returns the decorator `jit` for fixed types.

    Numbers, such as 1 and a whole number that is computed, are the same types
    then; else, each combination of types is compiled.
    """
    signature = result(*arguments)

    def decorate(function):
        part = jit(function)
        part.whole = functools.cache(
            lambda: _compiled_when_used(_whole(function), signature)
        )
        call_template = part.get_call_template

        def get_call_template(types, keywords):
            if not part.overloads:
                part.compile(signature)
            # Only Python may call it with other types.
            part.disable_compile()
            try:
                return call_template(types, keywords)
            finally:
                part.disable_compile(False)

        part.get_call_template = get_call_template
        return part

    return decorate


# Generators are not kept on disk: numba 0.68 fails (KeyError) to compile the
# callers of one that was read from there. Only these compilations need them.
jit_generator = _compiled

# Types of arguments, for functions that Python calls: with fixed types they
# are compiled once, whether or not Drake hands out read-only arrays.
VECTOR = numba.types.Array(numba.float64, 1, "C", readonly=True)
MATRIX = numba.types.Array(numba.float64, 2, "C", readonly=True)
CHANGED = numba.types.Array(numba.float64, 2, "C")  # It is written to.
CHANGED_VECTOR = numba.types.Array(numba.float64, 1, "C")
WALLS = VECTOR  # `Obstacles.table`: `opened` by `systems/world/walls.py`.
REAL = numba.float64
INTEGER = numba.int64
# `Snapshot.as_arguments`, without the last.
SNAPSHOT = (MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, WALLS, REAL)


def jit_as(result, *arguments):
    """Returns the decorator `jit` for fixed types.

    A function is compiled, or read from disk, when it is first used: a command
    that uses few of them need not wait for all.
    """
    signature = result(*arguments)

    def decorate(function):
        return _compiled_when_used(_whole(function), signature)

    return decorate


def _compiled_when_used(kernel, signature):
    """Restricts a dispatcher of numba to one signature, compiled later."""
    call_template = kernel.get_call_template

    def compiled():
        compile_once()
        return kernel.overloads[signature.args]

    def compile_once(*, waits=True):
        # (One thread compiles, the others wait for it.)
        with global_compiler_lock:
            if kernel.overloads:
                return
            with _locked(kernel, waits=waits) as is_mine:
                # (While this one waited, another kernel may have needed it.)
                if is_mine and not kernel.overloads:
                    kernel.compile(signature)
                    # Now other types are refused, and numbers converted.
                    kernel.disable_compile()

    def compile_for_args(*values, **_):
        # Numba asks for this at the first call from Python alone.
        compiled()
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
        compiled()
        return call_template(types, keywords)

    kernel.signature = signature
    kernel.compiled = compiled
    kernel.compile_once = compile_once
    kernel._compile_for_args = compile_for_args
    kernel.get_call_template = get_call_template
    return kernel


def reads(kind):
    """Returns a compiled function that reads a NamedTuple from an array.

    Kernels that Python calls take parameters as one array, since Python passes
    a NamedTuple of many numbers ten times slower, and use them by name.

    Args:
        kind: The class of the NamedTuple, or a dataclass that has such fields;
            all are numbers.
    """
    if dataclasses.is_dataclass(kind):
        kind = _fields_of(kind)
    size = len(kind._fields)

    @jit_part
    def read(array):
        return kind(*to_fixed_tuple(array, size))

    return read


def _fields_of(config):
    """Returns a NamedTuple of the fields of a dataclass, as its `Numbers`."""
    names = [field.name for field in dataclasses.fields(config)]
    config.Numbers = namedtuple("Numbers", names, module=config.__module__)
    # Its name for a kernel that takes it and is read from disk.
    config.Numbers.__qualname__ = f"{config.__qualname__}.Numbers"
    return config.Numbers


def rows_of(vector, width):
    """Returns a vector as rows, an array (n, width), as `unowned` does.

    (NumPy's reshape takes two seconds to compile.)
    """
    return vector.reshape(-1, width)


@intrinsic
def _rows_without_owner(typing_context, vector, width):
    kind = vector.copy(ndim=2)

    def generate(context, builder, signature, arguments):
        given = make_array(vector)(context, builder, arguments[0])
        view = make_array(kind)(context, builder)
        count = builder.sdiv(given.nitems, arguments[1])
        size = given.itemsize
        populate_array(
            view,
            data=given.data,
            shape=[count, arguments[1]],
            strides=[builder.mul(size, arguments[1]), size],
            itemsize=size,
            meminfo=None,
        )
        return view._getvalue()

    return kind(vector, numba.int64), generate


@overload(rows_of)
def _compiled_rows_of(vector, width):
    def compiled(vector, width):
        return _rows_without_owner(vector, width)

    return compiled


def unowned(array):
    """Returns an array of an argument's numbers that counts no references.

    Each time that compiled code passes an array on, it counts one more
    reference to its memory, and later one less, which takes longer than a short
    loop over its numbers. Views of this one need not count. They must all be
    gone when the kernel returns: from then on, nothing keeps the memory alive.
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
