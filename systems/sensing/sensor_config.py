"""The sensors of trials: what each measures, and what carries it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

from pydantic.dataclasses import dataclass as checked_dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.sensing.sensor_parameters import (
    CameraParameters,
    LidarParameters,
    Mount,
    VisibleParameters,
)
from hunav_drake.systems.world.shapes import World


class Rendering(NamedTuple):
    """What a camera sees, and where it is mounted.

    Attributes:
        scene_graph: The SceneGraph of the scene.
        frames: The FrameId by what carries a sensor, "robot" and "world".
    """

    scene_graph: Any
    frames: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class SensingTask:
    """What stays constant while a sensor measures.

    Attributes:
        world: What does not move.
        num_humans: How many people there are.
        time_step: The time between two updates of the trial, in seconds.
        seed: That of the default Context.
        number: Which sensor of the trial it is, from 0; each has noise of its
            own.
        rendering: The geometry, for cameras; None where there is none.
    """

    world: World
    num_humans: int
    time_step: float = 0.05
    seed: int = 0
    number: int = 0
    rendering: Rendering | None = None


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class SensorConfig(Mount, ABC):
    """What all sensors have; which one it is, a derived class tells."""

    @abstractmethod
    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes the sensor: a LeafSystem or a Diagram.

        Of these inputs it may have any; a trial connects them by their names:
        ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
        robot, ``human_states`` such rows of the people, ``query_object`` the
        geometry of the scene. Its outputs become those of the trial.

        Args:
            task: What it is to know of the world.
        """

    def AddToBuilder(
        self, builder: Any, task: SensingTask, *, name: str = ""
    ) -> Any:
        """Adds the sensor to a builder, and returns it.

        Args:
            builder: A DiagramBuilder.
            task: What it is to know of the world.
            name: What the system is called; by default as the sensor, or its
                type.

        Raises:
            TypeError: If `MakeSystem` makes something else than a System.
        """
        # Reading a scenario does without Drake.
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
class LidarConfig(LidarParameters, SensorConfig):
    """A lidar that scans a horizontal plane. See `Lidar`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `Lidar`, for which walls are what its plane cuts."""
        from hunav_drake.systems.sensing.lidar import Lidar

        return Lidar(
            self,
            obstacles=task.world.obstacles_at(self.height),
            num_humans=task.num_humans,
            time_step=task.time_step,
            seed=task.seed,
            number=task.number,
        )


@register_sensor("visible_people")
@checked_dataclass(kw_only=True, config=CONFIG)
class VisiblePeopleConfig(VisibleParameters, SensorConfig):
    """Tells whom the robot can see. See `VisiblePeople`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `VisiblePeople`, for which what is low hides nobody."""
        from hunav_drake.systems.sensing.visible_people import VisiblePeople

        return VisiblePeople(
            self,
            obstacles=task.world.sight_obstacles(),
            num_humans=task.num_humans,
        )


@register_sensor("camera")
@checked_dataclass(kw_only=True, config=CONFIG)
class CameraConfig(CameraParameters, SensorConfig):
    """A camera: color, depth and labels. See `AddCamera`."""

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a diagram of the camera: see `MakeCamera`.

        Raises:
            ValueError: If there is no geometry to see.
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
    """Returns the names of sensors: their own, or free ones by type."""
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
