"""A planner that stands still."""

from typing import Any

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.planner import (
    Plan,
    PlannerStatus,
    PlanningTask,
    View,
    register_planner,
)
from hunav_drake.systems.planning.pure_planner import Planner


@register_planner("stand")
@dataclass(kw_only=True, config=CONFIG)
class StandPlanner(Planner):
    """Stands still, whatever the goal is.

    A robot that moves brakes within its limits.
    """

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        return Plan(0.0, 0.0, PlannerStatus.IDLE)
