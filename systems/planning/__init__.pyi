from .local_planner import LocalPlanner as LocalPlanner
from .planner import (
    Plan as Plan,
    Planner as Planner,
    PlannerStatus as PlannerStatus,
    PlanningTask as PlanningTask,
    register_planner as register_planner,
)
from .planner_config import PlannerConfig as PlannerConfig
from .planners import (
    PLANNERS as PLANNERS,
    PursuitPlanner as PursuitPlanner,
    make_planner as make_planner,
)
