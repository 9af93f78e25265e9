"""SCL: DWB with costs around people on both of its costmaps."""

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
    """Plans around people's personal space: DWB with a social costmap layer.

    The layer is on the global costmap, so that plans lead around people, and on
    the local one. It follows the inflation, as in the example of
    nav2_social_costmap_plugin; before it, people would become impassable discs.
    """

    local_costmap: LocalCostmap = field(
        default_factory=lambda: LocalCostmap(
            layers=["obstacle", "inflation", "social"]
        )
    )
    """Local costmap around the robot, with costs around people."""

    global_costmap: GlobalCostmap = field(
        default_factory=lambda: GlobalCostmap(
            layers=["static", "obstacle", "inflation", "social"]
        )
    )
    """Global costmap of the whole world, with costs around people."""
