from .maps import Maps as Maps
from .memory import (
    Control as Control,
    LocalPlan as LocalPlan,
    NavigationMemory as NavigationMemory,
)
from .navigation_planner import (
    NavigationPlanner as NavigationPlanner,
    ProgressChecker as ProgressChecker,
    Recoveries as Recoveries,
)
