"""Planners that are pure functions: a class or a plain function."""

from collections.abc import Callable
from typing import Any

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.planner import (
    Plan,
    PlanningTask,
    PurePlanner,
    View,
    check_arguments,
    register_planner,
)


@explain
@dataclass(kw_only=True, config=CONFIG)
class Planner(PurePlanner):
    """A planner that decides by a pure function, run by a `LocalPlanner`.

    Its state is ``memory``, an immutable value of any type that lives in the
    Context. None, numbers, texts, tuples, NamedTuples, frozen dataclasses and
    read-only arrays are saved with it.
    """

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `LocalPlanner` that decides by `plan`."""
        from hunav_drake.systems.planning.local_planner import LocalPlanner

        return LocalPlanner(self, task)


PlanFunction = Callable[[PlanningTask, View, Any], Plan]


def register_plan[Function: PlanFunction](
    name: str, *, initial_memory: Any = None, scan_size: int = 0
) -> Callable[[Function], Function]:
    """Returns a decorator that registers a function as a planner.

    For a planner without additional parameters:

        @register_plan("straight")
        def straight(task, view, memory):
            return Plan(0.5, 0.0, PlannerStatus.DRIVING)

    Its class is `straight.planner`.

    Args:
        name: Its name in scenarios.
        initial_memory: See `Planner`.
        scan_size: See `Planner`.

    Raises:
        TypeError: If the function does not take (task, view, memory).
        ValueError: If the name is taken.
    """

    def add(function: Function) -> Function:
        label = getattr(function, "__qualname__", repr(function))
        check_arguments(function, f"the planner's function {label}")

        class FunctionPlanner(Planner):
            """Decides by a function."""

            def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
                return function(task, view, memory)

        made: Any = FunctionPlanner
        # The function that errors refer to.
        made.plan.__wrapped__ = function
        made.initial_memory = initial_memory
        made.scan_size = scan_size
        # Lets pickle find it, and lets it be defined again.
        made.__module__ = function.__module__
        made.__name__ = label.rpartition(".")[2]
        made.__qualname__ = f"{label}.planner"
        made.__doc__ = function.__doc__
        made = dataclass(kw_only=True, config=CONFIG)(made)
        register_planner(name)(made)
        known: Any = function
        known.planner = made
        return function

    return add
