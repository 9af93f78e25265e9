"""Planners that drive the robot."""

from hunav_drake.systems.planning.local_planner import LocalPlanner
from hunav_drake.systems.planning.planner import (
    PLANNERS,
    Plan,
    Planner,
    PlannerStatus,
    PlanningTask,
    make_planner,
    register_planner,
)
from hunav_drake.systems.planning.planner_config import PlannerConfig
from hunav_drake.systems.planning.pursuit import PursuitPlanner

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
