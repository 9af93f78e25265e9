from .cycles import time_cycles as time_cycles
from .dwb.dwb import DwbPlanner as DwbPlanner
from .dwb.scl import SclPlanner as SclPlanner
from .function_planner import register_plan as register_plan
from .local_planner import LocalPlanner as LocalPlanner
from .navigation.navigation_planner import (
    NavigationPlanner as NavigationPlanner,
)
from .perception import (
    PERCEPTIONS as PERCEPTIONS,
    PerceptionConfig as PerceptionConfig,
    register_perception as register_perception,
)
from .planner import (
    PLANNERS as PLANNERS,
    Plan as Plan,
    PlannerConfig as PlannerConfig,
    PlannerStatus as PlannerStatus,
    PlanningTask as PlanningTask,
    View as View,
    register_planner as register_planner,
)
from .planner_error import PlannerError as PlannerError
from .pure_planner import Planner as Planner
from .pursuit import PursuitPlanner as PursuitPlanner
