"""The LeafSystem of planners with costmaps; it outputs the costmaps, too."""

from collections.abc import Callable
from typing import Any

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, OutputPort

from hunav_drake.systems.common.ports import GoalOf, weakly
from hunav_drake.systems.planning.local_planner import LocalPlanner
from hunav_drake.systems.planning.navigation.navigation_parameters import (
    NavigationParameters,
)
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.world.maps.costs import NO_MAP, Costmap

MapFunction = Callable[[PlanningTask, View, Any], Costmap]


class NavigationSystem(LocalPlanner):
    """Drives a robot to a goal with a costmap planner.

    .. pydrake_system::

        name: NavigationSystem
        input_ports:
        - robot_state
        - human_states
        - goal
        - scan
        output_ports:
        - velocity_command
        - status
        - path
        - local_costmap
        - global_costmap

    Ports ``local_costmap`` and ``global_costmap`` give a `Costmap` each: the
    one on which commands are evaluated, from the last observation, and the one
    on which a path would be planned now. They have no cells without a goal or
    before the first decision. A map is computed only when its port is
    evaluated. Everything else is as in a `LocalPlanner`.
    """

    _planner: NavigationParameters

    def __init__(
        self, planner: NavigationParameters, task: PlanningTask
    ) -> None:
        """Constructs a NavigationSystem: see `LocalPlanner`."""
        super().__init__(planner, task)
        self._local_costmap = self._DeclareMap(
            "local_costmap", self._CalcLocalCostmap
        )
        self._global_costmap = self._DeclareMap(
            "global_costmap", self._CalcGlobalCostmap
        )

    def get_local_costmap_output_port(self) -> OutputPort:
        """Returns the port with the map around the robot."""
        return self._local_costmap

    def get_global_costmap_output_port(self) -> OutputPort:
        """Returns the port with the map of the whole world."""
        return self._global_costmap

    def _DeclareMap(
        self, name: str, calc: Callable[[Context, AbstractValue], None]
    ) -> OutputPort:
        return self.DeclareAbstractOutputPort(
            name, alloc=lambda: AbstractValue.Make(NO_MAP), calc=weakly(calc)
        )

    def _CalcLocalCostmap(
        self, context: Context, output: AbstractValue
    ) -> None:
        output.set_value(self._Map(context, self._planner.local_map))

    def _CalcGlobalCostmap(
        self, context: Context, output: AbstractValue
    ) -> None:
        output.set_value(self._Map(context, self._planner.global_map))

    def _Map(self, context: Context, make: MapFunction) -> Costmap:
        """Returns a map of the planner now, with read-only costs."""
        memory = self._Decided(context).memory
        if GoalOf(self._goal, context) is None or not memory.goal:
            return NO_MAP
        costmap = make(self._task, self._Look(context), memory)
        costmap.costs.setflags(write=False)
        return costmap
