"""The planners that come with the package, by name."""

from hunav_drake.systems.planning.planner import PLANNERS
from hunav_drake.systems.planning.pursuit import PursuitPlanner

__all__ = ["PLANNERS", "PursuitPlanner"]
