from .cycles import time_cycles as time_cycles
from .dwb.dwb import DwbPlanner as DwbPlanner
from .dwb.scl import SclPlanner as SclPlanner
from .external import ExternalPlanner as ExternalPlanner
from .held_command import HeldCommand as HeldCommand
from .local_planner import LocalPlanner as LocalPlanner
from .mppi.mppi import MppiPlanner as MppiPlanner
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
from .pure_planner import Planner as Planner, register_plan as register_plan
from .pursuit import PursuitPlanner as PursuitPlanner
from .ros2.bridge import BridgePlanner as BridgePlanner
from .social.orca import OrcaPlanner as OrcaPlanner
from .social.sfm import SfmPlanner as SfmPlanner
from .social.sfw import SfwPlanner as SfwPlanner
from .stand import StandPlanner as StandPlanner
