from .local_planner import LocalPlanner as LocalPlanner
from .planner import (
    Plan as Plan,
    Planner as Planner,
    PlannerConfig as PlannerConfig,
    PlannerStatus as PlannerStatus,
    PlanningTask as PlanningTask,
    View as View,
    register_planner as register_planner,
)
from .planners import PLANNERS as PLANNERS, PursuitPlanner as PursuitPlanner
