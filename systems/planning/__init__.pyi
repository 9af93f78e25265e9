from .dwb.dwb import DwbPlanner as DwbPlanner
from .dwb.scl import SclPlanner as SclPlanner
from .local_planner import LocalPlanner as LocalPlanner
from .navigation.navigation_planner import (
    NavigationPlanner as NavigationPlanner,
)
from .planner import (
    PLANNERS as PLANNERS,
    Plan as Plan,
    Planner as Planner,
    PlannerConfig as PlannerConfig,
    PlannerStatus as PlannerStatus,
    PlanningTask as PlanningTask,
    View as View,
    register_planner as register_planner,
)
from .pursuit import PursuitPlanner as PursuitPlanner
