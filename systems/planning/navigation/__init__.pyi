from .maps import Maps as Maps
from .memory import (
    Control as Control,
    LocalPlan as LocalPlan,
    NavigationMemory as NavigationMemory,
)
from .navigation_parameters import (
    ProgressChecker as ProgressChecker,
    Recoveries as Recoveries,
)
from .navigation_planner import NavigationPlanner as NavigationPlanner
