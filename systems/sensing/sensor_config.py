"""The sensors of trials: what each measures, and what carries it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
import math
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, StrictBool, StrictFloat, model_validator
from pydantic.dataclasses import dataclass as checked_dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Name,
    Pose,
    within,
)
from hunav_drake.systems.world.shapes import World

Height = Annotated[StrictFloat, within(0, 100, "m", low_open=True)]
Range = Annotated[StrictFloat, within(0, 1000, "m", low_open=True)]
Period = Annotated[StrictFloat, within(0, 10, "s", low_open=True)]
Pitch = Annotated[StrictFloat, within(-math.pi / 2, math.pi / 2, "rad")]
Turn = Annotated[StrictFloat, within(0, 2 * math.pi, "rad", low_open=True)]
Pixels = Annotated[Integer, Field(ge=16, le=4096)]

# The highest plane, in meters, that cuts legs alone, of people of all gaits.
LEG_HEIGHT = 0.7


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
class SensorConfig(ABC):
    """What all sensors have; which one it is, a derived class tells."""

    name: Name = ""
    """What it is called in the diagram; by default as its type, with a number
    if that is taken."""

    mount: Literal["robot", "world"] = "robot"
    """What carries it: the robot, or the ground."""

    pose: Pose = (0.0, 0.0, 0.0)
    """Where it is on what carries it, and where it looks: (x, y, yaw), in
    meters and radians."""

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
class LidarConfig(SensorConfig):
    """A lidar that scans a horizontal plane. See `Lidar`."""

    height: Height = 0.3
    """How high the plane is above the floor, in meters."""

    num_rays: Annotated[Integer, Field(ge=1, le=100_000)] = 360
    """How many distances a scan has. The rays go counter-clockwise, the same
    step apart, and the middle of the field is straight ahead. A full turn
    begins straight back."""

    field_of_view: Turn = 2 * math.pi
    """How wide a scan is, in radians."""

    range_min: Annotated[StrictFloat, within(0, 1000, "m")] = 0.05
    """The least distance, in meters. A ray that meets something nearer gives
    this."""

    range_max: Range = 10.0
    """The largest distance, in meters. A ray that meets nothing gives this."""

    period: Period = 0.1
    """The time between two scans, in seconds: a multiple of the step."""

    noise: Annotated[StrictFloat, within(0, 10, "m")] = 0.0
    """The standard deviation of the distances, in meters; 0 for exact ones."""

    people: Literal["legs", "discs"] = "legs"
    """What people are taken for: two legs that walk as the figures do, or the
    discs of the crowd."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.range_max <= self.range_min:
            raise _fault(
                f"range_max must be above range_min ({self.range_min:g} m),"
                f" got {self.range_max:g}"
            )
        if self.people == "legs" and self.height > LEG_HEIGHT:
            raise _fault(
                f"height must be at most {LEG_HEIGHT:g} m where it meets legs,"
                f" got {self.height:g}; lower it, or set people: discs"
            )
        return self

    @property
    def angle_step(self) -> float:
        """The angle from a ray to the next one, in radians."""
        full = self.field_of_view > 2 * math.pi - 1e-9
        return self.field_of_view / max(self.num_rays - (not full), 1)

    @property
    def first_angle(self) -> float:
        """The angle of the first ray from straight ahead, in radians."""
        return -0.5 * self.field_of_view if self.num_rays > 1 else 0.0

    def angles(self) -> Array:
        """Returns the angle of each ray from straight ahead, in radians."""
        steps = np.arange(self.num_rays, dtype=float)
        return self.first_angle + self.angle_step * steps

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


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class Sight:
    """How far and how wide something sees people."""

    range_max: Range = 10.0
    """How far it sees, in meters."""

    field_of_view: Turn = 2 * math.pi
    """How wide it sees, in radians."""

    hidden_by_people: StrictBool = False
    """Whether people hide those behind them; walls always do."""


@register_sensor("visible_people")
@checked_dataclass(kw_only=True, config=CONFIG)
class VisiblePeopleConfig(Sight, SensorConfig):
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
class CameraConfig(SensorConfig):
    """A camera: color, depth and labels. See `AddCamera`."""

    height: Height = 1.0
    """How high it is above the floor, in meters."""

    pitch: Pitch = 0.0
    """How far it looks down, in radians."""

    image_size: tuple[Pixels, Pixels] = (640, 480)
    """The width and the height of its images, in pixels."""

    field_of_view_y: Annotated[
        StrictFloat, within(0, 3.0, "rad", low_open=True)
    ] = math.pi / 4
    """How much it sees from the lowest row to the highest, in radians."""

    range_min: Range = 0.1
    """The least depth, in meters. What is nearer gives 0."""

    range_max: Range = 20.0
    """The largest depth, in meters. What is farther gives infinity."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.range_max <= self.range_min:
            raise _fault(
                f"range_max must be above range_min ({self.range_min:g} m),"
                f" got {self.range_max:g}"
            )
        return self

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


def _fault(rule: str) -> PydanticCustomError:
    return PydanticCustomError("rule", "{rule}", {"rule": rule})
