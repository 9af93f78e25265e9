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

# Numbers in memory: reference counts of arrays would take most of the time.
NUMBERS = types.CPointer(float64)


@intrinsic
def numbers_at(typing_context, address):
    """Returns the numbers at an address, which have no length."""
    return _pointing(NUMBERS)


@intrinsic
def integers_at(typing_context, address):
    """Returns the integers at an address, which have no length."""
    return _pointing(types.CPointer(int64))


def _pointing(pointer):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(pointer))

    return pointer(int64), generate


@intrinsic
def record_at(typing_context, address, index, dtype):
    """Returns one of several records that begin at an address."""
    record = dtype.dtype

    def generate(context, builder, signature, arguments):
        pointer = context.get_data_type(record).as_pointer()
        first = builder.inttoptr(arguments[0], pointer)
        return builder.gep(first, [arguments[1]])

    return record(int64, int64, dtype), generate


@intrinsic
def vector_at(typing_context, address, size):
    """Returns the vector at an address, only to be read."""

    def generate(context, builder, signature, arguments):
        view = make_array(VECTOR)(context, builder)
        eight = context.get_constant(types.intp, 8)
        populate_array(
            view,
            data=builder.inttoptr(arguments[0], view.data.type),
            shape=[arguments[1]],
            strides=[eight],
            itemsize=eight,
            meminfo=None,
        )
        return view._getvalue()

    return VECTOR(int64, int64), generate


def leaf_signature(record, ports, remembers):
    """Returns the types of a compiled leaf.

    Args:
        record: The type of the tick.
        ports: The number of ports.
        remembers: Whether it takes its own numbers.

    Raises:
        ValueError: If there are too many ports.
    """
    if ports > MAX_PORTS:
        raise ValueError(f"a leaf has at most {MAX_PORTS} ports, got {ports}")
    own = (NUMBERS,) if remembers else ()
    return int64(record, *own, *[float64] * ports)


@intrinsic
def call_leaf(typing_context, address, ports, remembers, tick, own, values):
    """Calls the compiled leaf at an address: see `leaf_signature`."""

    def generate(context, builder, signature, arguments):
        address, ports, remembers, tick, own, values = arguments
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
                        builder.gep(
                            values, [context.get_constant(types.intp, i)]
                        )
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
