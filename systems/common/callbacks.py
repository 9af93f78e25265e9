"""Callbacks that do not keep their system alive."""

from collections.abc import Callable
from typing import Any
from weakref import WeakMethod


def weakly(method: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a callback that does not keep its object alive.

    pydrake keeps the callbacks of cache entries and of abstract output ports
    where Python's garbage collector does not see them: a bound method there
    would keep its system, and the whole diagram, alive for ever.

    Args:
        method: A bound method.
    """
    reference = WeakMethod(method)

    def call(*arguments: Any) -> Any:
        bound = reference()
        assert bound is not None, "Drake calls back only while it is alive"
        return bound(*arguments)

    return call
