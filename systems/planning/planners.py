"""The planners that come with the package, by name."""

from hunav_drake.systems.planning.planner import PLANNERS, make_planner
from hunav_drake.systems.planning.pursuit import PursuitPlanner

__all__ = ["PLANNERS", "PursuitPlanner", "make_planner"]
