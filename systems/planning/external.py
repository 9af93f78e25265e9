"""A planner that holds the command which another program sets."""

from typing import Any

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.planner import (
    PlannerConfig,
    PlanningTask,
    register_planner,
)


@register_planner("external")
@dataclass(kw_only=True, config=CONFIG)
class ExternalPlanner(PlannerConfig):
    """Holds the command that `SetRobotCommand` sets, from rest.

    For a program that drives the robot itself: it sets a command in the Context
    between two steps, in Python.
    """

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `HeldCommand`."""
        # Imported here, so that reading a scenario does not load Drake.
        from hunav_drake.systems.planning.held_command import HeldCommand

        scan_size = (
            task.lidar.num_rays if self.sees.by_lidar and task.lidar else 0
        )
        return HeldCommand(task, scan_size)
