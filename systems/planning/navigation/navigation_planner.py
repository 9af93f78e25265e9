"""The base class of planners with costmaps that follow a global plan."""

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
    """Follows a global plan on costmaps, as Nav2's servers do together.

    Every `replanning_period` it plans a path on the global costmap
    (`plan_path`). In each cycle a local controller, the derived class's
    `control`, follows the part of the path near the robot on the local costmap.
    Without a path, a command or progress it runs recoveries, and it gives up
    after too many of them.

    Parameters that are None have the values of the profile.
    """

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        # Imported here, so that reading a scenario does not load numba.
        from hunav_drake.systems.planning.navigation.navigate import navigate
        from hunav_drake.systems.planning.navigation.recovery import Situation

        return navigate(Situation(self, task, view), memory)

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `NavigationSystem` that decides by `plan`.

        Raises:
            ValueError: If a map of the world would be too large.
        """
        from hunav_drake.systems.planning.navigation.navigation_system import (
            NavigationSystem,
        )

        # Later changes of parameters affect later systems only.
        planner = copy.deepcopy(self)
        planner.setup(task)
        return NavigationSystem(planner, task)
