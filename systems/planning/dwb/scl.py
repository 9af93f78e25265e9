"""SCL: DWB with the costs of people on both of its maps."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.planning.costmap.costmap_config import (
    GlobalCostmap,
    LocalCostmap,
)
from hunav_drake.systems.planning.dwb.dwb import DwbPlanner
from hunav_drake.systems.planning.planner import register_planner


@register_planner("scl")
@dataclass(kw_only=True, config=CONFIG)
class SclPlanner(DwbPlanner):
    """DWB with a social costmap layer: it plans around people's space.

    The layer is on the global map, so that plans lead around people, and on
    the local one. It comes after the inflation, as in the example of
    nav2_social_costmap_plugin; before it, people would become discs that may
    not be entered.
    """

    local_costmap: LocalCostmap = field(
        default_factory=lambda: LocalCostmap(
            layers=["obstacle", "inflation", "social"]
        )
    )
    """The map around the robot, with costs around people."""

    global_costmap: GlobalCostmap = field(
        default_factory=lambda: GlobalCostmap(
            layers=["static", "obstacle", "inflation", "social"]
        )
    )
    """The map of the whole world, with costs around people."""
