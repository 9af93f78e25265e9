"""What planners with maps share: they add how to follow the global plan."""

import copy
from typing import Any

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.navigation.navigation_parameters import (
    NavigationParameters,
)
from hunav_drake.systems.planning.planner import Plan, PlanningTask, View


@explain
@dataclass(kw_only=True, config=CONFIG)
class NavigationPlanner(NavigationParameters):
    """Follows a global plan on costmaps, as the servers of Nav2 do together.

    Once per `replanning_period` it finds a way on the global map (`plan_path`);
    in each cycle a local controller, which a derived class gives by `control`,
    follows the part of it near the robot on the local map. If there is no way
    or no command, or if the robot does not get on, it tries recoveries, and
    after too many of them it gives up.

    What is None is as the profile tells.
    """

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        # Reading a scenario does without numba.
        from hunav_drake.systems.planning.navigation.navigate import navigate

        return navigate(self, task, view, memory)

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `NavigationSystem`, which decides by `plan`.

        Raises:
            ValueError: If a map of the world would be too large.
        """
        from hunav_drake.systems.planning.navigation.navigation_system import (
            NavigationSystem,
        )

        # Parameters that are changed later are those of later systems.
        planner = copy.deepcopy(self)
        planner.setup(task)
        return NavigationSystem(planner, task)
