"""The robots: kinematic, or physical bodies of a plant."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping
import dataclasses
from dataclasses import field
import json
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import (
    BeforeValidator,
    StrictBool,
    StrictFloat,
    StrictStr,
    WithJsonSchema,
)
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    FilePath,
    within,
)
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.robot.drives import (
    DRIVES,
    DifferentialWheels,
    DriveConfig,
)
from hunav_drake.systems.robot.robot_config import (
    RobotConfig,
    RobotLimits,
    RobotTask,
    register_robot,
)

if TYPE_CHECKING:
    from hunav_drake.systems.robot.plant_model import ModelSource


# The value of an argument of xacro: text, or a number or truth value as text.
Argument = Annotated[
    StrictStr,
    BeforeValidator(
        lambda it: json.dumps(it) if isinstance(it, bool | int | float) else it
    ),
    WithJsonSchema({"type": ["string", "number", "boolean"]}),
]

# A disc larger than the body by more than this is doubtful, in meters.
_LARGER_DISC = 0.02


@register_robot("differential_drive")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialDriveConfig(RobotConfig):
    """A kinematic robot that follows (v, omega) within its limits."""

    walls_stop: StrictBool = True
    """Whether walls stop the robot: its disc penetrates a wall by at most 1 cm
    and slides along it; otherwise the robot passes through walls, as through
    people. Contacts with walls count in both cases."""

    def MakeSystem(self, task: RobotTask) -> Any:
        """Makes a `DifferentialDrive`."""
        # Imported here, so that reading a scenario does not load Drake.
        from hunav_drake.systems.robot.differential_drive import (
            DifferentialDrive,
        )

        return DifferentialDrive(
            self,
            time_step=task.time_step,
            obstacles=task.obstacles,
            walls_stop=self.walls_stop,
            num_others=len(task.robots),
        )


@explain
@dataclass(kw_only=True, config=CONFIG)
class PhysicalRobot(RobotConfig):
    """Base class of robots that are bodies of a MultibodyPlant.

    In a trial, the plant is the system "plant", which also has people and walls
    as bodies; its SceneGraph is "scene_graph".
    """

    physical: ClassVar[bool] = True

    max_plant_step: Annotated[StrictFloat, within(1e-4, 0.02, "s")] = 0.0125
    """Maximum step of the plant, in seconds. The step is the trial's time step,
    or a half, a quarter ... of it."""

    @abstractmethod
    def GetModel(self) -> "ModelSource":
        """Returns the source of the model."""

    @abstractmethod
    def GetDrive(self) -> DriveConfig:
        """Returns the drive of the robot."""

    def MakeSystem(self, task: RobotTask) -> Any:
        """Makes a Diagram that contains a plant."""
        from pydrake.systems.framework import DiagramBuilder

        builder = DiagramBuilder()
        robot = self.AddToBuilder(builder, task)
        for name in ("velocity_command", "human_states"):
            if robot.HasInputPort(name):
                builder.ExportInput(robot.GetInputPort(name), name)
        for name in ("robot_state", "contacts"):
            builder.ExportOutput(robot.GetOutputPort(name), name)
        return builder.Build()

    def AddToBuilder(
        self, builder: Any, task: RobotTask, *, name: str = "robot"
    ) -> Any:
        """Adds robot, "plant" and "scene_graph" to a DiagramBuilder.

        The robot, named `name`, is returned; see `AddPlantRobots`.

        Raises:
            ValueError: If the model cannot be driven, or there is a system of
                one of these names.
        """
        return AddPhysicalRobots(builder, {name: self}, task)[0]

    def AddFigure(self, plant: Any, name: str) -> Any:
        """Adds the model to a plant for display only."""
        from hunav_drake.systems.robot.plant_model import AddFigure

        return AddFigure(plant, self.GetModel(), self.GetDrive(), name)

    def find_faults(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yields a fault if the model cannot be driven, or cannot start."""
        from hunav_drake.systems.common.models.apart import ModelFault
        from hunav_drake.systems.robot.plant_model import inspect_model

        try:
            facts = inspect_model(self.GetModel(), self.GetDrive())
        except ModelFault as fault:
            yield fault.place, str(fault)
            return
        axes = zip(("x", "y", "yaw"), self.start, facts.limits, strict=False)
        for axis, value, (low, high) in axes:
            if not low <= value <= high:
                yield (
                    ("start",),
                    f"must have {axis} in [{low:g}, {high:g}], the limits of"
                    f" the model's joint, got {value:g}; move it, or change"
                    " the limits",
                )

    def find_doubts(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yields doubts: a disc larger than the body, meshes not shown."""
        from hunav_drake.systems.common.models.reading import robot_text
        from hunav_drake.systems.robot.plant_robot import body_reach

        reach = body_reach(self.GetModel(), self.GetDrive(), self.start)
        if self.radius - reach > _LARGER_DISC:
            yield (
                ("radius",),
                f"is {self.radius:g} m, but the collision shapes of the model"
                f" reach only {reach:.3g} m from its base: people are moved off"
                " the disc without a force on the robot; for forces that count,"
                f" set it to {reach:.3g}",
            )
        source = self.GetModel()
        robot = robot_text(source.file, source.packages, source.arguments)
        if robot is not None and robot.unseen:
            yield (
                ("file",),
                "has meshes that are not there, or of a format that Drake"
                f" cannot show ({len(robot.unseen)}, as"
                f" {shown(robot.unseen[0])}): the collision shapes of their"
                " links are shown instead",
            )
        if robot is not None and robot.absent:
            yield (
                ("file",),
                "includes files of packages that are not there, which are left"
                f" out: {', '.join(robot.absent)}; if the robot lacks a part,"
                " name their folders under packages",
            )


def AddPhysicalRobots(
    builder: Any, robots: Mapping[str, PhysicalRobot], task: RobotTask
) -> list[Any]:
    """Adds robots, "plant" and "scene_graph" to a DiagramBuilder.

    Args:
        builder: A DiagramBuilder.
        robots: The robots by the names of their systems.
        task: The data of the world and the people. Its other robots are
            kinematic: they are bodies that follow their states.

    Returns:
        The systems of the robots, in order; see `AddPlantRobots` for the
        ports.

    Raises:
        ValueError: If a model cannot be driven, or there is a system of one
            of these names.
    """
    from hunav_drake.systems.robot.plant_robot import AddPlantRobots, Body

    bodies = [
        (name, it, Body(it.GetModel(), it.GetDrive(), it.max_plant_step))
        for name, it in robots.items()
    ]
    return AddPlantRobots(builder, bodies, task)


class PackageRobot(PhysicalRobot):
    """Base class of robots whose model, an SDF file, is in the package.

    Its base is the body "base"; the file cites where its figures are from.
    """

    model: ClassVar[str]
    """Name of the file in systems/robot/models."""

    drive: ClassVar[DriveConfig]
    """Drive of the robot."""

    def GetModel(self) -> "ModelSource":
        """Returns the model of the package."""
        from hunav_drake.systems.robot.plant_model import ModelSource

        folder = "package://hunav_drake/systems/robot/models"
        return ModelSource(file=f"{folder}/{self.model}.sdf", base="base")

    def GetDrive(self) -> DriveConfig:
        """Returns its wheels."""
        return self.drive


def _wheels(
    separation: float, radius: float, torque: float, speed: float
) -> DifferentialWheels:
    """Returns two wheels with a maximum speed of the rim, in m/s."""
    return DifferentialWheels(
        left_wheel="left_wheel_joint",
        right_wheel="right_wheel_joint",
        wheel_separation=separation,
        wheel_radius=radius,
        max_torque=torque,
        max_wheel_speed=speed / radius,
    )


def _limits(*values: float) -> Any:
    """Returns a field of limits, in the order of `RobotLimits`."""
    names = [it.name for it in dataclasses.fields(RobotLimits)]
    known = dict(zip(names, values, strict=True))
    return field(default_factory=lambda: RobotLimits(**known))


@register_robot("pmb2")
@dataclass(kw_only=True, config=CONFIG)
class PMB2Config(PackageRobot):
    """A round base on two driven wheels, with the parameters of PAL's PMB2."""

    radius: BodyRadius = 0.27
    """Radius of the robot's body, in meters."""

    model: ClassVar[str] = "pmb2"
    drive: ClassVar[DriveConfig] = _wheels(0.4044, 0.0985, 6.0, 1.0)


@register_robot("tiago_base")
@dataclass(kw_only=True, config=CONFIG)
class TiagoBaseConfig(PackageRobot):
    """PAL's TIAGo without an arm, its torso down: 50 kg on the base PMB2."""

    radius: BodyRadius = 0.27
    """Radius of the robot's body, in meters."""

    limits: RobotLimits = _limits(1.0, 0.2, 0.5, 1.05, 1.05)
    """Limits of the robot's motion: those of its base's controller."""

    model: ClassVar[str] = "tiago_base"
    drive: ClassVar[DriveConfig] = _wheels(0.4044, 0.0985, 6.0, 1.0)


@register_robot("turtlebot3_burger")
@dataclass(kw_only=True, config=CONFIG)
class TurtleBot3BurgerConfig(PackageRobot):
    """ROBOTIS' TurtleBot3 Burger: two wheels and a caster, 1 kg."""

    radius: BodyRadius = 0.125
    """Radius of the smallest disc around the middle of the wheels that covers
    the robot, in meters."""

    limits: RobotLimits = _limits(0.22, 0.22, 2.5, 2.84, 3.2)
    """Limits of the robot's motion, its accelerations those that its navigation
    plans with."""

    model: ClassVar[str] = "turtlebot3_burger"
    drive: ClassVar[DriveConfig] = _wheels(0.16, 0.033, 1.5, 0.24)


@register_robot("turtlebot3_waffle")
@dataclass(kw_only=True, config=CONFIG)
class TurtleBot3WaffleConfig(PackageRobot):
    """ROBOTIS' TurtleBot3 Waffle Pi: two wheels and two casters, 1.8 kg."""

    radius: BodyRadius = 0.24
    """Radius of the smallest disc around the middle of the wheels that covers
    the robot, in meters."""

    limits: RobotLimits = _limits(0.26, 0.26, 2.5, 1.82, 3.2)
    """Limits of the robot's motion, its accelerations those that its navigation
    plans with."""

    model: ClassVar[str] = "turtlebot3_waffle"
    drive: ClassVar[DriveConfig] = _wheels(0.288, 0.033, 3.0, 0.27)


@register_robot("jackal")
@dataclass(kw_only=True, config=CONFIG)
class JackalConfig(PackageRobot):
    """Clearpath's Jackal: a skid steer on four wheels, 18 kg."""

    radius: BodyRadius = 0.31
    """Radius of the smallest disc that covers the robot, in meters."""

    limits: RobotLimits = _limits(2.0, 2.0, 2.0, 4.0, 4.0)
    """Limits of the robot's motion. Those of its controller allow 20 m/s^2 and
    25 rad/s^2, which no tire gives."""

    model: ClassVar[str] = "jackal"
    drive: ClassVar[DriveConfig] = DifferentialWheels(
        left_wheel=["front_left_wheel_joint", "rear_left_wheel_joint"],
        right_wheel=["front_right_wheel_joint", "rear_right_wheel_joint"],
        wheel_separation=0.37559,
        wheel_radius=0.098,
        max_torque=5.0,
        max_wheel_speed=3.0 / 0.098,
    )


@register_robot("urdf")
@dataclass(kw_only=True, config=CONFIG)
class UrdfRobot(PhysicalRobot):
    """A robot from a URDF (also by xacro) or SDF file, with any drive."""

    file: FilePath
    """Model file: a path, in a scenario file relative to it, or
    package://name/..."""

    base: StrictStr
    """Body with the position and heading of the robot."""

    drive: Annotated[DriveConfig, DRIVES]
    """Drive of the robot; see `hunav_drake.systems.robot.DRIVES`."""

    packages: dict[StrictStr, StrictStr] = field(default_factory=dict)
    """Folders of packages by name, for package://name/..., in addition to those
    given by ROS_PACKAGE_PATH, by the package.xml above the file, and in folders
    beside it and its repository."""

    arguments: dict[StrictStr, Argument] = field(default_factory=dict)
    """Values of xacro's arguments, and of environment variables that it asks
    for: no others are read."""

    def GetModel(self) -> "ModelSource":
        """Returns the user's model."""
        from hunav_drake.systems.robot.plant_model import ModelSource

        return ModelSource(
            file=self.file,
            base=self.base,
            packages=dict(self.packages),
            arguments=dict(self.arguments),
        )

    def GetDrive(self) -> DriveConfig:
        """Returns the user's drive."""
        return self.drive
