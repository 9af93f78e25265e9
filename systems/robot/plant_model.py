"""Robot models from files in a MultibodyPlant."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    ModelInstanceIndex,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
)
from pydrake.systems.framework import Context

from hunav_drake.systems.common.models.apart import ModelFault, drake_words
from hunav_drake.systems.common.models.reading import (
    AddModels,
    check_model_file,
)
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.robot.drives import (
    AckermannSteering,
    DriveConfig,
    MecanumWheels,
    PlanarBase,
    WheelDrive,
)
from hunav_drake.systems.robot.robot_config import MOUNT


@dataclass(frozen=True, kw_only=True)
class ModelSource:
    """The file of a model and its base.

    Attributes:
        file: A URDF, SDF or other file that Drake reads: a path or
            "package://...".
        base: The body with the position and heading of the robot.
        packages: Folders of packages by name, in addition to those given by
            ROS_PACKAGE_PATH and by the package.xml above the file.
        arguments: The values of xacro's arguments.
    """

    file: str
    base: str
    packages: Mapping[str, str] = field(default_factory=dict)
    arguments: Mapping[str, str] = field(default_factory=dict)


def AddModel(
    plant: MultibodyPlant, source: ModelSource
) -> tuple[ModelInstanceIndex, RigidBody]:
    """Adds a model to a plant and returns its instance and its base.

    Raises:
        ModelFault: If there is no such file, model or body.
    """
    instances = AddModels(plant, source.file, source.packages, source.arguments)
    names = []
    for instance in instances:
        for index in plant.GetBodyIndices(instance):
            body = plant.get_body(index)
            if body.name() == source.base:
                return instance, body
            names.append(body.name())
    raise ModelFault(
        ("base",),
        f"there is no body {shown(source.base)} in the model;"
        f" {suggestion(source.base, names)}",
    )


class Wheel(NamedTuple):
    """A joint of a drive: a driven wheel, or one that is steered.

    Attributes:
        joint: Its name.
        setting: The setting of the drive that names it.
        place: (x, y, z) in the base, in meters.
        sign: 1 if a positive joint rate drives forwards, or to the left,
            else -1.
    """

    joint: str
    setting: str
    place: tuple[float, float, float]
    sign: int

    @property
    def is_steered(self) -> bool:
        """Whether the joint steers a wheel."""
        return self.setting.endswith("_steering")


@dataclass(frozen=True)
class ModelFacts:
    """The properties of a checked model.

    `root` is the root body R of the model, empty if the world carries it;
    `height` that of the base B above the floor, in meters; `mass` in kg.
    `wheels` is empty for a `PlanarBase`; of one on joints of the model,
    `limits` are the least and the largest x, y and yaw, in m and rad.
    """

    root: str
    X_RB: RigidTransform
    height: float
    mass: float
    wheels: tuple[Wheel, ...] = ()
    limits: tuple[tuple[float, float], ...] = ()


# The facts of the package's own models, whose files do not change.
_OWN = "package://hunav_drake/"
_facts_of_own: dict[tuple[str, str, str], ModelFacts] = {}


def inspect_model(source: ModelSource, drive: DriveConfig) -> ModelFacts:
    """Checks that a model can be driven and returns its properties.

    Raises:
        ModelFault: If it cannot.
    """
    if not source.file.startswith(_OWN) or source.packages or source.arguments:
        return _inspect(source, drive)
    key = source.file, source.base, repr(drive)
    if key not in _facts_of_own:
        _facts_of_own[key] = _inspect(source, drive)
    return _facts_of_own[key]


def _inspect(source: ModelSource, drive: DriveConfig) -> ModelFacts:
    """Returns the properties of a model: see `inspect_model`."""
    if isinstance(drive, WheelDrive | PlanarBase):
        check_model_file(
            source.file,
            source.packages,
            "hunav_drake.systems.robot.attempt:try_robot",
            source.base,
            {"type": name_of(drive), **asdict(drive)},
            arguments=source.arguments,
        )
    plant = MultibodyPlant(time_step=0.0)
    instance, base = AddModel(plant, source)
    joints = {
        plant.get_joint(index).name(): plant.get_joint(index)
        for index in plant.GetJointIndices(instance)
    }
    root = root_of(base, list(joints.values()))
    _finalize(plant)
    context = plant.CreateDefaultContext()
    mass = plant.CalcTotalMass(context)
    if not mass > 0:
        raise ModelFault(
            ("file",),
            "has no mass, so no motor can drive it; give its links inertias",
        )
    world = plant.world_body()
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        if joint.child_body() is world:
            raise ModelFault(
                ("file",),
                f"has the joint {shown(joint.name())} that carries the world;"
                " give it a link of the robot as its child",
            )
    for motor in map(plant.get_joint_actuator, plant.GetJointActuatorIndices()):
        if motor.model_instance() != instance:
            apart = plant.GetModelInstanceName(motor.model_instance())
            raise ModelFault(
                ("file",),
                f"has the motor {shown(motor.name())} in another model,"
                f" {shown(apart)}, than that of {shown(source.base)}: nothing"
                " holds or commands it; move its joint to the model of the"
                " base, or make it fixed",
            )
    wheels: tuple[Wheel, ...] = ()
    limits: tuple[tuple[float, float], ...] = ()
    if isinstance(drive, WheelDrive):
        if root is world:
            raise ModelFault(
                ("base",),
                f"{shown(source.base)} is carried by the world, so wheels"
                " cannot move it; take out the joint to the world, or choose"
                " drive: {type: omnidirectional}",
            )
        if base not in plant.GetBodiesWeldedTo(root):
            raise ModelFault(
                ("base",),
                f"{shown(source.base)} moves relative to {shown(root.name())},"
                f" which carries it; choose {shown(root.name())}",
            )
        if isinstance(drive, MecanumWheels):
            _check_root(root, base)
        wheels = _check_wheels(plant, context, base, joints, drive)
        height = drive.wheel_radius - float(
            np.mean([it.place[2] for it in wheels if not it.is_steered])
        )
    elif isinstance(drive, PlanarBase) and (drive.x or drive.y or drive.yaw):
        limits = _check_stages(plant, context, base, joints, drive)
        height = 0.0
    elif isinstance(drive, PlanarBase):
        height = drive.height
        _check_root(root, base)
    else:
        raise ModelFault(
            ("drive",), f"must be one of the package, got {drive!r:.60}"
        )
    return ModelFacts(
        root="" if root is world else root.name(),
        X_RB=plant.CalcRelativeTransform(
            context, root.body_frame(), base.body_frame()
        ),
        height=height,
        mass=mass,
        wheels=wheels,
        limits=limits,
    )


def _finalize(plant: MultibodyPlant) -> None:
    try:
        plant.Finalize()
    except RuntimeError as error:
        raise ModelFault(
            ("file",), f"cannot be simulated: {drake_words(error)}"
        ) from error


def root_of(body: RigidBody, joints: list[Joint]) -> RigidBody:
    """Returns the root that carries a body over all joints."""
    carrier = {joint.child_body().index(): joint for joint in joints}
    while body.index() in carrier:
        body = carrier[body.index()].parent_body()
    return body


def _joint(
    joints: Mapping[str, Joint], key: str, name: str, kind: type[Joint]
) -> Joint:
    """Returns the joint of a name after a check of its kind."""
    if name not in joints:
        fitting = [it for it in joints if isinstance(joints[it], kind)]
        raise ModelFault(
            ("drive", key),
            f"there is no joint {shown(name)} in the model;"
            f" {suggestion(name, fitting)}",
        )
    if not isinstance(joints[name], kind):
        wanted = (
            "revolute or continuous" if kind is RevoluteJoint else ("prismatic")
        )
        raise ModelFault(
            ("drive", key),
            f"must be a {wanted} joint, but {shown(name)} is"
            f" {joints[name].type_name()}; no motor can drive it so",
        )
    return joints[name]


def _check_root(root: RigidBody, base: RigidBody) -> None:
    if root is not base:
        raise ModelFault(
            ("base",),
            f"{shown(base.name())} is carried by {shown(root.name())}, so no"
            " motors can be added below it; choose the body that nothing"
            " carries, or, of an omnidirectional drive, name the joints x, y"
            " and yaw",
        )


def _check_wheels(
    plant: MultibodyPlant,
    context: Context,
    base: RigidBody,
    joints: Mapping[str, Joint],
    drive: WheelDrive,
) -> tuple[Wheel, ...]:
    """Returns the driven wheels, then the joints that steer."""
    wheels: dict[str, Wheel] = {}
    for key, names in drive.joints().items():
        for name in names:
            if name in wheels:
                raise ModelFault(
                    ("drive", key),
                    f"must be another joint than {wheels[name].setting}, got"
                    f" {shown(name)}",
                )
            joint = _joint(joints, key, name, RevoluteJoint)
            wheels[name] = _wheel(plant, context, base, joint, key)
    every = tuple(wheels.values())

    def places(key: str, axis: int) -> list[float]:
        return [it.place[axis] for it in every if it.setting == key]

    for key in drive.joints():
        other = key.replace("left", "right")
        if "left" not in key:
            continue
        left, right = min(places(key, 1)), max(places(other, 1))
        if not left > right:
            raise ModelFault(
                ("drive", key),
                "must be left of the right one, seen along x of"
                f" {shown(base.name())}, but is at y = {left:g} m and that at"
                f" {right:g} m; swap them, or choose a base whose x points"
                " forwards",
            )
        rear = key.replace("front", "rear")
        if rear != key and not min(places(key, 0)) > max(places(rear, 0)):
            raise ModelFault(
                ("drive", key),
                f"must be ahead of {rear}, along x of {shown(base.name())};"
                " swap them, or choose a base whose x points forwards",
            )
    if isinstance(drive, AckermannSteering):
        driven, steered = (
            [it.place[0] for it in every if it.is_steered is flag]
            for flag in (False, True)
        )
        if min(steered) < max(driven) + 0.01:
            raise ModelFault(
                ("drive", "left_steering"),
                "must be ahead of the driven wheels, which do not turn, along x"
                f" of {shown(base.name())}, but is at x = {min(steered):g} m"
                f" and those at {max(driven):g} m; swap them, or choose a base"
                " whose x points forwards",
            )
    return every


def _wheel(
    plant: MultibodyPlant,
    context: Context,
    base: RigidBody,
    joint: Joint,
    key: str,
) -> Wheel:
    """Returns a driven or steered wheel after a check of its axis."""
    axis_name, axis_index = ("z", 2) if key.endswith("_steering") else ("y", 1)
    p_BW = plant.CalcRelativeTransform(
        context, base.body_frame(), joint.frame_on_child()
    ).translation()
    X_BF = plant.CalcRelativeTransform(
        context, base.body_frame(), joint.frame_on_parent()
    )
    axis = X_BF.rotation().multiply(joint.revolute_axis())
    if abs(axis[axis_index]) < 0.999:
        raise ModelFault(
            ("drive", key),
            f"must turn about the {axis_name} axis of {shown(base.name())}, but"
            f" the axis of {shown(joint.name())} is"
            f" {np.round(axis, 3).tolist()} there; choose a base whose x points"
            " forwards, or another joint",
        )
    if axis_name == "z":
        (low,), (high,) = (
            joint.position_lower_limits(),
            joint.position_upper_limits(),
        )
        if not low < 0 < high:
            raise ModelFault(
                ("drive", key),
                f"must turn to both sides of straight ahead, but the limits of"
                f" {shown(joint.name())} are [{low:g}, {high:g}] rad; correct"
                " them, so that 0 is straight ahead",
            )
    place = (float(p_BW[0]), float(p_BW[1]), float(p_BW[2]))
    return Wheel(joint.name(), key, place, 1 if axis[axis_index] > 0 else -1)


def _check_stages(
    plant: MultibodyPlant,
    context: Context,
    base: RigidBody,
    joints: Mapping[str, Joint],
    drive: PlanarBase,
) -> tuple[tuple[float, float], ...]:
    """Returns the limits of x, y and yaw after a check of their joints."""
    stages = {}
    for key, kind in (
        ("x", PrismaticJoint),
        ("y", PrismaticJoint),
        ("yaw", RevoluteJoint),
    ):
        name = getattr(drive, key)
        if not name:
            raise ModelFault(
                ("drive", key),
                "is missing; name all of x, y and yaw, or none of them",
            )
        stages[key] = _joint(joints, key, name, kind)
    start = plant.GetPositions(context)
    position = start.copy()
    # (x and y of the world stay what they are when the base has turned.)
    for column, key in ((2, "yaw"), (0, "x"), (1, "y")):
        joint = stages[key]
        here = _pose(plant, context, base)
        position[joint.position_start()] += 0.1
        plant.SetPositions(context, position)
        change = _pose(plant, context, base) - here
        if abs(change - 0.1 * np.eye(3)[column]).max() > 1e-6:
            raise ModelFault(
                ("drive", key),
                f"must move {shown(base.name())} along {key} of the world, but"
                f" 0.1 of {shown(joint.name())} changes (x, y, yaw) by"
                f" {np.round(change, 6).tolist()}; let the joints of x and y"
                " carry that of yaw",
            )
    plant.SetPositions(context, start)
    if abs(_pose(plant, context, base)).max() > 1e-6:
        raise ModelFault(
            ("base",),
            f"{shown(base.name())} must be at the origin while all joints are"
            f" at 0, got (x, y, yaw) ="
            f" {np.round(_pose(plant, context, base), 6).tolist()}",
        )
    return tuple(
        (float(*it.position_lower_limits()), float(*it.position_upper_limits()))
        for it in stages.values()
    )


def _pose(
    plant: MultibodyPlant, context: Context, body: RigidBody
) -> NDArray[np.float64]:
    """Returns (x, y, yaw) of a body."""
    X_WB = plant.EvalBodyPoseInWorld(context, body)
    x, y = X_WB.translation()[:2]
    matrix = X_WB.rotation().matrix()
    return np.array([x, y, np.arctan2(matrix[1, 0], matrix[0, 0])])


def AddFigure(
    plant: MultibodyPlant, source: ModelSource, drive: DriveConfig, name: str
) -> list[Joint]:
    """Adds a model to a plant for display only, as a model instance.

    The plant is registered with a SceneGraph and not finalized yet.

    Returns:
        The joints whose positions, in this order, are x, y and yaw of its base.

    Raises:
        ModelFault: If the model does not fit the drive.
    """
    facts = inspect_model(source, drive)
    instance, base = AddModel(plant, source)
    plant.RenameModelInstance(instance, name)
    # It is on the floor below the base, with its heading.
    mount = plant.AddRigidBody(MOUNT, instance).body_frame()
    height = RigidTransform([0.0, 0.0, facts.height])
    X_MB = height if facts.root else facts.X_RB
    plant.WeldFrames(base.body_frame(), mount, X_MB.inverse())
    if not facts.root:
        return [
            plant.GetJointByName(getattr(drive, key), instance)
            for key in ("x", "y", "yaw")
        ]
    floor = plant.AddFrame(
        FixedOffsetFrame(
            f"{name}_floor",
            plant.world_frame(),
            RigidTransform([0.0, 0.0, facts.height]),
            instance,
        )
    )
    root = plant.GetBodyByName(facts.root, instance)
    at_base = plant.AddFrame(
        FixedOffsetFrame(
            f"{name}_pose", root.body_frame(), facts.X_RB, instance
        )
    )
    return [plant.AddJoint(PlanarJoint("pose", floor, at_base))]
