"""The configuration of sensors: measurements and mounts."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

from pydantic.dataclasses import dataclass as checked_dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.people.figure_config import Figures
from hunav_drake.systems.sensing.sensor_parameters import (
    CameraParameters,
    Delayed,
    DetectorParameters,
    LidarParameters,
    Mount,
    VisibleParameters,
)
from hunav_drake.systems.world.shapes import World


class Rendering(NamedTuple):
    """The geometry of cameras and their mounts.

    Attributes:
        scene_graph: The SceneGraph of the scene.
        frames: The FrameId of each mount, "robot" and "world".
    """

    scene_graph: Any
    frames: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class SensingTask:
    """The constant data of a sensor's task.

    Attributes:
        world: The static world.
        num_humans: The number of people.
        num_other_robots: The number of robots besides the one with the sensor.
        time_step: The time between two updates of the trial, in seconds.
        seed: The seed of the default Context.
        number: The number of the sensor in the trial, from 0; each has
            different noise.
        rendering: The geometry for cameras; None without geometry.
        figures: The figures of the people; None for adults. If lively, there
            are "social_signals".
    """

    world: World
    num_humans: int
    num_other_robots: int = 0
    time_step: float = 0.05
    seed: int = 0
    number: int = 0
    rendering: Rendering | None = None
    figures: Figures | None = None


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class SensorConfig(Mount, ABC):
    """Base class of sensors."""

    @abstractmethod
    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes the sensor: a LeafSystem or a Diagram.

        All inputs are optional; a trial connects them by name: ``robot_state``
        takes the row (x, y, yaw, vx, vy, omega, radius) of the robot,
        ``human_states`` such rows of the people, ``other_robot_states`` those
        of other robots, ``social_signals`` what people show, if their trees
        have social leaves, ``query_object`` the geometry of the scene. Its
        outputs become outputs of the trial.
        """

    def AddToBuilder(
        self, builder: Any, task: SensingTask, *, name: str = ""
    ) -> Any:
        """Adds the sensor to a DiagramBuilder and returns it.

        The name is by default that of the sensor, or its type.

        Raises:
            TypeError: If `MakeSystem` returns anything else than a System.
        """
        # Imported here, so that reading a scenario does not load Drake.
        from hunav_drake.systems.common.ports import CheckPorts

        system = self.MakeSystem(task)
        CheckPorts(
            system, f"the sensor {type(self).__name__}", inputs={}, outputs={}
        )
        return builder.AddNamedSystem(
            name or self.name or name_of(self), system
        )


# The sensors by type.
SENSORS = Registry("sensor", SensorConfig)

register_sensor = SENSORS.register


@register_sensor("lidar")
@checked_dataclass(kw_only=True, config=CONFIG)
class LidarConfig(Delayed, LidarParameters, SensorConfig):
    """A lidar that scans a horizontal plane. See `Lidar`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `Lidar` with the obstacles in its plane."""
        from hunav_drake.systems.sensing.delay import MakeDelayed
        from hunav_drake.systems.sensing.lidar import Lidar

        lidar = Lidar(
            self,
            obstacles=task.world.obstacles_at(self.height),
            num_humans=task.num_humans,
            num_other_robots=task.num_other_robots,
            time_step=task.time_step,
            seed=task.seed,
            number=task.number,
            figures=task.figures,
        )
        return MakeDelayed(lidar, self.delay, task.time_step)


@register_sensor("visible_people")
@checked_dataclass(kw_only=True, config=CONFIG)
class VisiblePeopleConfig(Delayed, VisibleParameters, SensorConfig):
    """Detects the people in the robot's view: see `VisiblePeople`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `VisiblePeople`; low obstacles do not occlude people."""
        from hunav_drake.systems.sensing.delay import MakeDelayed
        from hunav_drake.systems.sensing.visible_people import VisiblePeople

        people = VisiblePeople(
            self,
            obstacles=task.world.sight_obstacles(),
            num_humans=task.num_humans,
            num_other_robots=task.num_other_robots,
        )
        return MakeDelayed(people, self.delay, task.time_step)


@register_sensor("people_detector")
@checked_dataclass(kw_only=True, config=CONFIG)
class PeopleDetectorConfig(Delayed, DetectorParameters, SensorConfig):
    """Detects people in view, with errors: see `PeopleDetector`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `PeopleDetector`; low obstacles do not occlude people."""
        from hunav_drake.systems.sensing.delay import MakeDelayed
        from hunav_drake.systems.sensing.people_detector import PeopleDetector

        detector = PeopleDetector(
            self,
            obstacles=task.world.sight_obstacles(),
            num_humans=task.num_humans,
            num_other_robots=task.num_other_robots,
            time_step=task.time_step,
            seed=task.seed,
            number=task.number,
            human_ids=task.figures.ids if task.figures else None,
        )
        return MakeDelayed(detector, self.delay, task.time_step)


@register_sensor("camera")
@checked_dataclass(kw_only=True, config=CONFIG)
class CameraConfig(CameraParameters, SensorConfig):
    """A camera: color, depth and labels. See `AddCamera`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a diagram of the camera: see `MakeCamera`.

        Raises:
            ValueError: If there is no geometry or no such mount.
        """
        from hunav_drake.systems.sensing.camera import MakeCamera

        if task.rendering is None:
            raise ValueError(
                "a camera needs geometry to see: give its task a Rendering,"
                " or use AddCamera()"
            )
        scene_graph, frames = task.rendering
        if self.mount not in frames:
            raise ValueError(
                f"a camera cannot be mounted on {self.mount!r}, which the"
                " geometry does not have; choose another mount"
            )
        return MakeCamera(self, scene_graph, frames[self.mount])


def name_sensors(sensors: list[SensorConfig]) -> list[str]:
    """Returns the names of sensors: the given ones, or free ones by type."""
    taken = {sensor.name for sensor in sensors if sensor.name}
    names = []
    for sensor in sensors:
        kind = name_of(sensor)
        name, number = sensor.name or kind, 2
        while not sensor.name and name in taken:
            name, number = f"{kind}_{number}", number + 1
        taken.add(name)
        names.append(name)
    return names
