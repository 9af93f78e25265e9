"""Memory by its address, and calls of functions by theirs; for compiled code.

Nothing here keeps memory alive: who gives an address away does.
"""

from numba import float64, int64, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from hunav_drake.systems.common.kernels import VECTOR

# The largest number of ports of a leaf.
MAX_PORTS = 12

NUMBERS = types.Array(float64, 1, "C")


def _pointer(context, builder, address, item):
    kind = context.get_data_type(item).as_pointer()
    return builder.inttoptr(address, kind)


@intrinsic
def array_at(typing_context, address, size, dtype):
    """Returns the array of a size at an address, which owns nothing."""
    return _viewing(types.Array(dtype.dtype, 1, "C"), dtype)


@intrinsic
def vector_at(typing_context, address, size):
    """Returns the numbers at an address, only to be read."""
    return _viewing(VECTOR)


def _viewing(array, *more):
    """Returns the type and the code of a function that views memory."""

    def generate(context, builder, signature, arguments):
        view = make_array(array)(context, builder)
        item = context.get_constant(
            types.intp,
            context.get_abi_sizeof(context.get_data_type(array.dtype)),
        )
        populate_array(
            view,
            data=_pointer(context, builder, arguments[0], array.dtype),
            shape=[arguments[1]],
            strides=[item],
            itemsize=item,
            meminfo=None,
        )
        return view._getvalue()

    return array(int64, int64, *more), generate


@intrinsic
def record_at(typing_context, address, dtype):
    """Returns the record at an address."""

    def generate(context, builder, signature, arguments):
        return _pointer(context, builder, arguments[0], dtype.dtype)

    return dtype.dtype(int64, dtype), generate


def leaf_signature(record, ports, remembers):
    """Returns the types of a compiled leaf.

    Args:
        record: The type of the tick.
        ports: The number of ports.
        remembers: Whether it takes its own numbers.
    """
    own = (NUMBERS,) if remembers else ()
    return int64(record, *own, *[float64] * ports)


@intrinsic
def call_leaf(typing_context, address, ports, remembers, tick, own, values):
    """Calls the compiled leaf at an address: see `leaf_signature`."""

    def generate(context, builder, signature, arguments):
        address, ports, remembers, tick, own, values = arguments
        data = make_array(NUMBERS)(context, builder, values).data
        result = cgutils.alloca_once(builder, context.get_value_type(int64))
        end = builder.append_basic_block("end")
        # A leaf has one of these signatures.
        kinds = builder.add(builder.add(ports, ports), remembers)
        switch = builder.switch(kinds, end)
        for count in range(MAX_PORTS + 1):
            for remembering in (False, True):
                block = builder.append_basic_block()
                switch.add_case(2 * count + remembering, block)
                builder.position_at_end(block)
                called = leaf_signature(signature.args[3], count, remembering)
                kind = context.call_conv.get_function_type(
                    called.return_type, called.args
                )
                numbers = [
                    builder.load(
                        builder.gep(data, [context.get_constant(types.intp, i)])
                    )
                    for i in range(count)
                ]
                _, returned = context.call_conv.call_function(
                    builder,
                    builder.inttoptr(address, kind.as_pointer()),
                    called.return_type,
                    called.args,
                    [tick, *([own] if remembering else []), *numbers],
                )
                builder.store(returned, result)
                builder.branch(end)
        builder.position_at_end(end)
        return builder.load(result)

    return int64(int64, int64, int64, tick, NUMBERS, NUMBERS), generate
