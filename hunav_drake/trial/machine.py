"""The traits of a machine that the last bits of a result depend on.

They are part of a result's provenance, `docs/repeatability.md` shows them, and
tests compare results bit for bit only on machines with equal traits.
"""

from collections.abc import Callable
import functools
import hashlib
import os
import platform
from typing import NamedTuple

import numpy as np


class Trait(NamedTuple):
    """A trait of a machine that the last bits of results depend on.

    Attributes:
        read: Returns its value on this machine.
        about: Its meaning and its effect; a sentence of the docs.
    """

    read: Callable[[], str]
    about: str


def _c_library() -> str:
    """Returns the C library, and the settings that select its functions."""
    name, version = platform.libc_ver()
    tunables = os.environ.get("GLIBC_TUNABLES", "")
    return " ".join(part for part in (name, version, tunables) if part)


def _processor() -> str:
    """Returns LLVM's name of the processor, and a hash of its features."""
    from llvmlite import binding

    features = binding.get_host_cpu_features().flatten()
    return f"{binding.get_host_cpu_name()} {_short_hash(features)}"


def _numpy_simd() -> str:
    """Returns the instruction sets by which NumPy selects functions."""
    told = np.show_config(mode="dicts") or {}
    found = told.get("SIMD Extensions", {}).get("found", [])
    return " ".join(found) or "baseline"


def _numba_target() -> str:
    """Returns the target of Numba, and a hash of its options."""
    from numba.core import config
    from numba.core.registry import cpu_target

    target = cpu_target.target_context.codegen().magic_tuple()
    names = "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DISABLE_JIT"
    options = [str(getattr(config, name)) for name in (*names, "USING_SVML")]
    return f"{target[1]} {_short_hash(' '.join([*target, *options]))}"


def _short_hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


MACHINE_TRAITS = {
    "machine": Trait(platform.machine, "The type of machine, such as x86_64."),
    "system": Trait(platform.system, "The operating system."),
    "c_library": Trait(
        _c_library,
        "The C library, with `GLIBC_TUNABLES` if it is set. Its `exp`, `sin`,"
        " `pow` and the like have several versions, chosen by the processor's"
        " instruction sets.",
    ),
    "processor": Trait(
        _processor,
        "The processor, and a hash of its instruction sets. The C library and"
        " Drake choose code by them, for example with or without fused"
        " multiply-add.",
    ),
    "numpy_simd": Trait(
        _numpy_simd,
        "The instruction sets that NumPy uses for its own `exp`, `sin` and the"
        " like; `NPY_DISABLE_CPU_FEATURES` disables some.",
    ),
    "numba_target": Trait(
        _numba_target,
        "The processor for which Numba compiles, and a hash of its instruction"
        " sets and Numba's options. Kernels are compiled without `fastmath`, so"
        " results should not depend on this trait, but that is not proven."
        " `NUMBA_CPU_NAME` and `NUMBA_CPU_FEATURES` set it.",
    ),
}


@functools.cache
def _read() -> tuple[tuple[str, str], ...]:
    return tuple((name, trait.read()) for name, trait in MACHINE_TRAITS.items())


def machine_traits() -> dict[str, str]:
    """Returns the traits of this machine."""
    return dict(_read())
