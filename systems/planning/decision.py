"""A planner's decision, as a value in the Context."""

from dataclasses import dataclass
import math
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.planning.planner import NO_PATH, Plan, PlannerStatus
from hunav_drake.systems.planning.value_arrays import from_arrays, to_arrays

_NUMBERS = (float, int, np.floating, np.integer)
_STATUSES = frozenset(PlannerStatus)


@dataclass(frozen=True, slots=True)
class Decision:
    """Holds a plan; it is immutable, so copies of a Context share it."""

    plan: Plan

    def __deepcopy__(self, memo: Any) -> Self:
        return self

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Returns the contents of the plan as arrays, by name.

        Raises:
            ValueError: If the planner's memory holds a value that arrays cannot
                hold: see `value_arrays`.
        """
        v, omega, status, memory, path, reason = self.plan
        return to_arrays(
            (v, omega, int(status), memory, path, reason),
            "the planner's memory",
        )

    def from_arrays(self, arrays: dict[str, NDArray[Any]]) -> "Decision":
        """Returns the decision that `to_arrays` turned into arrays.

        Raises:
            ValueError: If the arrays hold no decision.
        """
        v, omega, status, memory, path, reason = from_arrays(arrays)
        plan = Plan(v, omega, PlannerStatus(status), memory, path, reason)
        if fault := plan_fault(plan):
            raise ValueError(fault)
        return Decision(plan)


def idle(memory: Any) -> Decision:
    """Returns the decision of an idle planner."""
    return Decision(Plan(0.0, 0.0, PlannerStatus.IDLE, memory=memory))


def plan_fault(plan: Any, *, keeps: bool = True) -> str:
    """Returns why something is not a valid plan; empty if it is one.

    `keeps`: whether its planner has an initial memory.
    """
    if not isinstance(plan, Plan):
        return f"must give a Plan, got {plan!r:.80}"
    if not all(
        isinstance(value, _NUMBERS) and math.isfinite(value)
        for value in (plan.v, plan.omega)
    ):
        return (
            f"must give finite v and omega, got v = {plan.v!r:.80} and omega ="
            f" {plan.omega!r:.80}"
        )
    if plan.status not in _STATUSES:
        return f"must give a PlannerStatus, got {plan.status!r:.80}"
    path, memory = plan.path, plan.memory
    if not keeps:
        if memory is None and path is NO_PATH:
            return ""
        return (
            "must not give a memory or a path without an initial_memory; give"
            f" its class one that is not None. Got {plan}"
        )
    if not (
        isinstance(path, np.ndarray)
        and path.ndim == 2
        and path.shape[1] in (2, 3)
        and path.dtype == np.float64
        and np.isfinite(path).all()
    ):
        return (
            "must give a path that is an array of finite numbers of shape"
            f" (k, 2) or (k, 3), got {path!r:.80}"
        )
    if not isinstance(plan.reason, str):
        return f"must give a reason that is a text, got {plan.reason!r:.80}"
    return memory_fault(memory)


def memory_fault(memory: Any) -> str:
    """Returns why a value cannot be a memory; empty if it can."""
    mutable = isinstance(memory, list | dict | set | bytearray)
    if mutable or (isinstance(memory, np.ndarray) and memory.flags.writeable):
        return (
            "must remember an immutable value, such as a tuple, a frozen"
            f" dataclass or a read-only array; got {memory!r:.80}"
        )
    return ""
