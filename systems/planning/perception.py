"""What a planner sees of the people: one choice for all planners."""

from abc import ABC, abstractmethod
from dataclasses import fields
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.sensing.sensor_config import (
    SensingTask,
    VisiblePeopleConfig,
)
from hunav_drake.systems.sensing.sensor_parameters import Sight


@explain
@dataclass(kw_only=True, config=CONFIG)
class PerceptionConfig(ABC):
    """What all perceptions have; which one it is, a derived class tells."""

    by_lidar: ClassVar[bool] = False
    """Whether the planner gets no rows of people, but the scan of a lidar."""

    @abstractmethod
    def MakeSystem(self, task: SensingTask) -> Any | None:
        """Makes what stands between people and planner; None for nothing.

        A LeafSystem or a Diagram with the inputs ``robot_state`` and
        ``human_states``, or one of them, and the output ``visible_people``:
        as many rows as ``human_states`` has, those of people who are not seen
        as `layout.OUTSIDE` tells.

        Args:
            task: What it is to know of the world.
        """


# The perceptions by type.
PERCEPTIONS = Registry("perception", PerceptionConfig, default="everything")

register_perception = PERCEPTIONS.register


@register_perception("everything")
@dataclass(kw_only=True, config=CONFIG)
class Everything(PerceptionConfig):
    """All people, wherever they are: HuNavSim's planners get them so."""

    def MakeSystem(self, task: SensingTask) -> None:
        """Makes nothing."""


@register_perception("visible")
@dataclass(kw_only=True, config=CONFIG)
class Visible(Sight, PerceptionConfig):
    """The people whom the robot can see now. See `VisiblePeople`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `VisiblePeople`, for which what is low hides nobody."""
        sight = {it.name: getattr(self, it.name) for it in fields(Sight)}
        return VisiblePeopleConfig(**sight).MakeSystem(task)


@register_perception("lidar")
@dataclass(kw_only=True, config=CONFIG)
class LidarAlone(PerceptionConfig):
    """Nobody as such: people are obstacles that the lidar meets.

    The planner gets the scan of the first lidar of the trial; if there is
    none, the trial makes one with its defaults. Walls are known from the map.
    """

    by_lidar: ClassVar[bool] = True

    def MakeSystem(self, task: SensingTask) -> None:
        """Makes nothing."""
