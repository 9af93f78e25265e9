"""Motorized robot models in a simulated MultibodyPlant."""

from dataclasses import dataclass
import math

from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    JointActuator,
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
)

from hunav_drake.systems.robot.drives import (
    DifferentialWheels,
    DriveConfig,
    PlanarBase,
)
from hunav_drake.systems.robot.plant_model import (
    AddModel,
    ModelFacts,
    ModelSource,
    inspect_model,
)
from hunav_drake.systems.robot.robot_driver import MotorSpeeds

# A motor of the drive holds a speed: it is a damper with these gains, in N m
# s/rad, or N s/m for linear motors, and with a negligible spring, which Drake
# requires.
_WHEEL_DAMPING, _PUSH_DAMPING, _TURN_DAMPING = 10.0, 1e4, 1e3
_NO_SPRING = 1e-9

# Any other motor holds its joint's start position, with gains in N m/rad and N
# m s/rad, or in N/m and N s/m.
_HOLD = PdControllerGains(p=1e4, d=1e3)


@dataclass(frozen=True)
class DrivenModel:
    """A model with motors in a plant that is not finalized yet.

    The body `base` has the pose of the robot; `motors` are the joints of the
    drive, in the order of their speeds; `signs` are in `ModelFacts`.
    """

    instance: ModelInstanceIndex
    base: RigidBody
    motors: tuple[Joint, ...]
    signs: tuple[int, ...] = ()


def AddDrivenModel(
    plant: MultibodyPlant,
    source: ModelSource,
    drive: DriveConfig,
    start: tuple[float, float, float],
) -> DrivenModel:
    """Adds a model with motors to a plant that is not finalized yet.

    Its base starts at (x, y, yaw), in meters and radians.

    Raises:
        ModelFault: If the model does not fit the drive.
    """
    facts = inspect_model(source, drive)
    instance, base = AddModel(plant, source)
    motors: list[Joint]
    if isinstance(drive, DifferentialWheels):
        names = (drive.left_wheel, drive.right_wheel)
        motors = [plant.GetJointByName(name, instance) for name in names]
        limits = [drive.max_torque] * 2
        dampings = [_WHEEL_DAMPING] * 2
        _place(plant, instance, facts, start)
    else:
        assert isinstance(drive, PlanarBase), "inspect_model checks this"
        if drive.x:
            motors = [
                plant.GetJointByName(name, instance)
                for name in (drive.x, drive.y, drive.yaw)
            ]
        else:
            motors = _AddStages(plant, base, instance, drive.height)
        for joint, value in zip(motors, start, strict=True):
            joint.set_default_positions([value])
        limits = [drive.max_force, drive.max_force, drive.max_torque]
        dampings = [_PUSH_DAMPING, _PUSH_DAMPING, _TURN_DAMPING]
    known = _actuators(plant, instance)
    for actuator in known.values():
        actuator.set_controller_gains(_HOLD)
    for joint, limit, damping in zip(motors, limits, dampings, strict=True):
        actuator = known.get(joint.name())
        if actuator is None:
            actuator = plant.AddJointActuator(joint.name(), joint, limit)
        actuator.set_effort_limit(min(limit, actuator.effort_limit()))
        actuator.set_controller_gains(
            PdControllerGains(p=_NO_SPRING, d=damping)
        )
    return DrivenModel(instance, base, tuple(motors), facts.signs)


def _place(
    plant: MultibodyPlant,
    instance: ModelInstanceIndex,
    facts: ModelFacts,
    start: tuple[float, float, float],
) -> None:
    """Places a free body so that the base starts at a pose."""
    x, y, yaw = start
    X_WB = RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, facts.height])
    root = plant.GetBodyByName(facts.root, instance)
    plant.SetDefaultFloatingBaseBodyPose(root, X_WB @ facts.X_RB.inverse())


def _AddStages(
    plant: MultibodyPlant,
    base: RigidBody,
    instance: ModelInstanceIndex,
    height: float,
) -> list[Joint]:
    """Adds joints along x, along y and about z between world and base."""
    name, parent = base.name(), plant.world_frame()
    added = []
    for axis, direction in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        stage = plant.AddRigidBody(
            f"{name}_{axis}", instance, SpatialInertia.Zero()
        ).body_frame()
        joint = PrismaticJoint(f"{name}_{axis}", parent, stage, direction)
        added.append(plant.AddJoint(joint))
        parent = stage
    raised = plant.AddFrame(
        FixedOffsetFrame(
            f"{name}_stand", parent, RigidTransform([0.0, 0.0, height])
        )
    )
    turning = RevoluteJoint(f"{name}_yaw", raised, base.body_frame(), [0, 0, 1])
    return [*added, plant.AddJoint(turning)]


def _actuators(
    plant: MultibodyPlant, instance: ModelInstanceIndex
) -> dict[str, JointActuator]:
    """Returns the actuators of a model by the names of their joints."""
    every = [
        plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()
    ]
    return {
        actuator.joint().name(): actuator
        for actuator in every
        if actuator.joint().model_instance() == instance
    }


def make_motor_speeds(
    plant: MultibodyPlant, model: DrivenModel, drive: DriveConfig
) -> tuple[MotorSpeeds, list[float]]:
    """Returns the commands of all motors of a model in a finalized plant.

    These are the function of `RobotDriver` that gives the speeds of all motors,
    in the order of the plant's port, and the positions that they hold.
    """
    actuators = [
        plant.get_joint_actuator(index)
        for index in plant.GetJointActuatorIndices(model.instance)
    ]
    names = [actuator.joint().name() for actuator in actuators]
    places = [a.joint().default_positions()[0] for a in actuators]
    driven = [names.index(joint.name()) for joint in model.motors]
    for k in driven:
        places[k] = 0.0
    count = len(names)
    if isinstance(drive, DifferentialWheels):
        left, right = driven
        left_sign, right_sign = model.signs
        radius, half = drive.wheel_radius, drive.wheel_separation / 2
        fastest = drive.max_wheel_speed * radius

        def wheels(v: float, omega: float, yaw: float) -> list[float]:
            """Scales both wheels equally, which keeps the curvature."""
            rim = abs(v) + half * abs(omega)
            scale = min(1.0, fastest / rim) / radius if rim else 0.0
            speeds = [0.0] * count
            speeds[left] = left_sign * scale * (v - half * omega)
            speeds[right] = right_sign * scale * (v + half * omega)
            return speeds

        return wheels, places

    def planar(v: float, omega: float, yaw: float) -> list[float]:
        speeds = [0.0] * count
        speeds[driven[0]] = v * math.cos(yaw)
        speeds[driven[1]] = v * math.sin(yaw)
        speeds[driven[2]] = omega
        return speeds

    return planar, places
