"""The perceptions: what a planner knows of people."""

from abc import ABC, abstractmethod
from dataclasses import fields
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.sensing.sensor_config import (
    PeopleDetectorConfig,
    SensingTask,
    VisiblePeopleConfig,
)
from hunav_drake.systems.sensing.sensor_parameters import (
    Delayed,
    DetectorErrors,
    Sight,
)


@explain
@dataclass(kw_only=True, config=CONFIG)
class PerceptionConfig(ABC):
    """Base class of perceptions."""

    by_lidar: ClassVar[bool] = False
    """Whether the planner gets the scan of a lidar instead of rows of people.
    """

    @property
    def num_false_rows(self) -> int:
        """The number of rows beyond those of people and robots."""
        return 0

    @abstractmethod
    def MakeSystem(self, task: SensingTask) -> Any | None:
        """Makes the system between people and planner; None for a direct link.

        It is a LeafSystem or a Diagram with the inputs ``robot_state`` and
        ``human_states``, or one of them, and the output ``visible_people``: as
        many rows as ``human_states``, with the row of each person out of view
        as `layout.OUTSIDE` defines it. Beside other robots, an optional input
        ``other_robot_states`` takes their rows, and there are as many more rows
        of ``visible_people``; the last rows are `num_false_rows` for people who
        do not exist.
        """


# The perceptions by type.
PERCEPTIONS = Registry("perception", PerceptionConfig, default="everything")

register_perception = PERCEPTIONS.register


@register_perception("everything")
@dataclass(kw_only=True, config=CONFIG)
class Everything(PerceptionConfig):
    """All people, anywhere, as for HuNavSim's planners."""

    def MakeSystem(self, task: SensingTask) -> None:
        """Makes nothing."""


@register_perception("visible")
@dataclass(kw_only=True, config=CONFIG)
class Visible(Sight, PerceptionConfig):
    """Only the people in the robot's view now: see `VisiblePeople`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `VisiblePeople`; low obstacles do not occlude people."""
        sight = {it.name: getattr(self, it.name) for it in fields(Sight)}
        return VisiblePeopleConfig(**sight).MakeSystem(task)


@register_perception("detector")
@dataclass(kw_only=True, config=CONFIG)
class Detector(DetectorErrors, Sight, Delayed, PerceptionConfig):
    """The people whom a detector on the robot reports: see `PeopleDetector`.

    As `visible`, but at a rate of its own, with missed and false detections,
    errors of position and velocity, and latency.
    """

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `PeopleDetector`, without its delay.

        The planner gets its rows later, but placed by the pose of the robot at
        the time of the detection.
        """
        keys = fields(DetectorErrors) + fields(Sight)
        values = {it.name: getattr(self, it.name) for it in keys}
        return PeopleDetectorConfig(**values).MakeSystem(task)


@register_perception("lidar")
@dataclass(kw_only=True, config=CONFIG)
class LidarAlone(PerceptionConfig):
    """No people as such, only the obstacles that the lidar scans.

    The planner gets the scan of the trial's first lidar; without one, the trial
    adds a default lidar. Walls are known from the map.
    """

    by_lidar: ClassVar[bool] = True

    def MakeSystem(self, task: SensingTask) -> None:
        """Makes nothing."""
