"""Planners that decide by a pure function: what users' own derive from."""

from typing import Any

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.planner import PlanningTask, PurePlanner


@explain
@dataclass(kw_only=True, config=CONFIG)
class Planner(PurePlanner):
    """A planner that decides by a pure function, as a `LocalPlanner` does.

    Whatever it wants to remember goes through ``memory``, an immutable value
    of any type, which lives in the Context: None, numbers, texts, tuples,
    NamedTuples, frozen dataclasses and read-only arrays are saved with it.
    """

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `LocalPlanner` that decides by `plan`."""
        from hunav_drake.systems.planning.local_planner import LocalPlanner

        return LocalPlanner(self, task)
