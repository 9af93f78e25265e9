"""Calls of compiled functions that are compiled at the first call.

A kernel contains all that it calls. So a branch that is seldom taken takes as
long to compile as one that always is, and what several kernels call is compiled
into each of them, and into all that call these. Functions that are called late
are asked for by their name at the first call, and called by address.
"""

import ctypes
import importlib
import inspect

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.core.registry import CPUDispatcher
from numba.core.typing.templates import make_intrinsic_template

from hunav_drake.systems.common.kernels import jit_as

_SYMBOL = "hunav_drake_address_of"
_ADDRESS = ir.IntType(64)


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_char_p)
def _address_of(name):
    """Returns the address of a function, b"module:name"; 0 if there is none."""
    try:
        module, function = name.decode().split(":")
        made = getattr(importlib.import_module(module), function).compiled()
        return made.library.get_pointer_to_function(made.fndesc.llvm_func_name)
    # Nothing can be raised through compiled code: its caller raises.
    except BaseException:
        return 0


# Under this name, compiled code finds it, also if it is read from disk.
binding.add_symbol(_SYMBOL, ctypes.cast(_address_of, ctypes.c_void_p).value)


class _Late(CPUDispatcher):
    """A kernel that other kernels call by its address."""

    @property
    def _numba_type_(self):
        return self.called


def late_as(result, *arguments):
    """Returns the decorator `jit_as`, for functions that are called late.

    The module must have the function under its name. Kernels that call it raise
    a RuntimeError if it cannot be compiled, also if that is interrupted.
    """

    def decorate(function):
        kernel = jit_as(result, *arguments)(function)
        kernel.__class__ = _Late
        kernel.called = types.Function(
            make_intrinsic_template(kernel, _typed(kernel), kernel.__name__)
        )
        return kernel

    return decorate


def _typed(kernel):
    """Returns how a call of a kernel from compiled code is typed."""
    result, kinds = kernel.signature.return_type, kernel.signature.args
    name = f"{kernel.__module__}:{kernel.__name__}"

    def generate(context, builder, _, arguments):
        known = cgutils.add_global_variable(builder.module, _ADDRESS, "known")
        known.linkage = "internal"
        known.initializer = _ADDRESS(0)
        with cgutils.if_unlikely(
            builder, cgutils.is_null(builder, builder.load(known))
        ):
            text = context.insert_const_string(builder.module, name)
            ask = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(_ADDRESS, [text.type]), _SYMBOL
            )
            builder.store(builder.call(ask, [text]), known)
        address = builder.load(known)
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, address)):
            context.call_conv.return_user_exc(
                builder, RuntimeError, (f"{name} was not compiled",)
            )
        kind = context.call_conv.get_function_type(result, kinds)
        status, returned = context.call_conv.call_function(
            *(builder, builder.inttoptr(address, kind.as_pointer())),
            *(result, kinds, arguments),
        )
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return returned

    def call(typing_context, *given):
        return kernel.signature, generate

    # Numba would take `given` for one argument, a tuple.
    own = list(inspect.signature(kernel.py_func).parameters.values())
    first = inspect.Parameter("typing_context", own[0].kind)
    call.__signature__ = inspect.Signature([first, *own])
    return call
