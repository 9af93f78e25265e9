"""Planners that drive the robot."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.systems.planning.local_planner import (
        LocalPlanner,
    )
    from hunav_drake.systems.planning.planner import (
        Plan,
        Planner,
        PlannerStatus,
        PlanningTask,
        register_planner,
    )
    from hunav_drake.systems.planning.planner_config import (
        PlannerConfig,
    )
    from hunav_drake.systems.planning.planners import (
        PLANNERS,
        PursuitPlanner,
        make_planner,
    )

__all__ = [
    "PLANNERS",
    "LocalPlanner",
    "Plan",
    "Planner",
    "PlannerConfig",
    "PlannerStatus",
    "PlanningTask",
    "PursuitPlanner",
    "make_planner",
    "register_planner",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "LocalPlanner": "hunav_drake.systems.planning.local_planner",
        "PLANNERS": "hunav_drake.systems.planning.planners",
        "Plan": "hunav_drake.systems.planning.planner",
        "Planner": "hunav_drake.systems.planning.planner",
        "PlannerConfig": "hunav_drake.systems.planning.planner_config",
        "PlannerStatus": "hunav_drake.systems.planning.planner",
        "PlanningTask": "hunav_drake.systems.planning.planner",
        "PursuitPlanner": "hunav_drake.systems.planning.planners",
        "make_planner": "hunav_drake.systems.planning.planners",
        "register_planner": "hunav_drake.systems.planning.planner",
    },
)
