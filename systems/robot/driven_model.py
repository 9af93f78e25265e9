"""Motorized robot models in a simulated MultibodyPlant."""

from collections.abc import Callable
from dataclasses import dataclass
import math

from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
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
    AckermannSteering,
    DifferentialWheels,
    DriveConfig,
    MecanumWheels,
    PlanarBase,
    WheelDrive,
)
from hunav_drake.systems.robot.plant_model import (
    AddModel,
    ModelFacts,
    ModelSource,
    Wheel,
    inspect_model,
    root_of,
)
from hunav_drake.systems.robot.robot_driver import MotorStates

# A motor of the drive holds a speed: it is a damper with these gains, in N m
# s/rad, or N s/m for linear motors, and with a negligible spring, which Drake
# requires.
_WHEEL_DAMPING, _PUSH_DAMPING, _TURN_DAMPING = 10.0, 1e4, 1e3
_NO_SPRING = 1e-9

# The gain of wheels is this many times larger in models whose joints have
# damping, which would slow them.
_AGAINST_JOINTS = 20

# Any other motor holds its joint's start position, with gains in N m/rad and N
# m s/rad, or in N/m and N s/m.
_HOLD = PdControllerGains(p=1e4, d=1e3)

# Rubber on the floor carries this part of the weight sideways.
_GRIP = 0.9 * 9.81


@dataclass(frozen=True)
class DrivenModel:
    """A model with motors in a plant that is not finalized yet.

    The body `base` has the pose of the robot; `bodies` are all that joints hold
    to it, also those of other models of its file, and `joints` these joints.
    `motors` are the joints of the drive: those of `wheels` (see `ModelFacts`),
    then those along x, along y and about z, if there are any. A `floats` model
    is not carried by the floor.
    """

    instance: ModelInstanceIndex
    base: RigidBody
    bodies: tuple[BodyIndex, ...]
    joints: tuple[Joint, ...]
    motors: tuple[Joint, ...]
    wheels: tuple[Wheel, ...] = ()
    floats: bool = False


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
    num_before = plant.num_bodies()
    instance, base = AddModel(plant, source)
    motors: list[Joint] = [
        plant.GetJointByName(wheel.joint, instance) for wheel in facts.wheels
    ]
    limits, dampings = [], []
    if isinstance(drive, WheelDrive):
        limits = [
            math.inf if wheel.is_steered else drive.max_torque
            for wheel in facts.wheels
        ]
        joints = map(plant.get_joint, plant.GetJointIndices(instance))
        resists = any(
            isinstance(it, RevoluteJoint) and it.default_damping() > 0
            for it in joints
        )
        damping = _WHEEL_DAMPING * (_AGAINST_JOINTS if resists else 1)
        dampings = [damping] * len(motors)
    if isinstance(drive, MecanumWheels | PlanarBase):
        stages: list[Joint]
        if isinstance(drive, PlanarBase) and drive.x:
            stages = [
                plant.GetJointByName(name, instance)
                for name in (drive.x, drive.y, drive.yaw)
            ]
        else:
            stages = _AddStages(plant, base, instance, facts.height)
        for joint, value in zip(stages, start, strict=True):
            joint.set_default_positions([value])
        motors += stages
        known = _actuators(plant, instance)
        own = [
            known[wheel.joint].effort_limit()
            for wheel in facts.wheels
            if wheel.joint in known
        ]
        force, torque = _forces(drive, facts, min(own, default=math.inf))
        limits += [force, force, torque]
        dampings += [_PUSH_DAMPING, _PUSH_DAMPING, _TURN_DAMPING]
    else:
        _place(plant, instance, facts, start)
    known = _actuators(plant, instance)
    for actuator in known.values():
        actuator.set_controller_gains(_HOLD)
    steered = {wheel.joint for wheel in facts.wheels if wheel.is_steered}
    for joint, limit, damping in zip(motors, limits, dampings, strict=True):
        actuator = known.get(joint.name())
        if actuator is None:
            actuator = plant.AddJointActuator(joint.name(), joint, limit)
        actuator.set_effort_limit(min(limit, actuator.effort_limit()))
        actuator.set_controller_gains(
            _HOLD
            if joint.name() in steered
            else PdControllerGains(p=_NO_SPRING, d=damping)
        )
    floats = isinstance(drive, MecanumWheels)
    every = [plant.get_joint(index) for index in plant.GetJointIndices()]
    root = root_of(base, every)
    bodies = [
        BodyIndex(i)
        for i in range(num_before, plant.num_bodies())
        if root_of(plant.get_body(BodyIndex(i)), every) is root
    ]
    between = [it for it in every if it.child_body().index() in bodies]
    return DrivenModel(
        *(instance, base, tuple(bodies), tuple(between)),
        *(tuple(motors), facts.wheels, floats),
    )


def _arms(drive: WheelDrive, wheels: tuple[Wheel, ...]) -> list[float]:
    """Returns by how much turning to the left slows the rim of each wheel.

    It is in m/s per rad/s: for a wheel that only rolls, how far it is to the
    left of the base; a mecanum wheel ahead or behind is as much faster. Wheels
    of a skid steer slip sideways: with equal loads, and no torque left about
    the middle, the rims need (x² + y²) / |y|, with places from the middle of
    the wheels.
    """
    if isinstance(drive, DifferentialWheels):
        half = drive.wheel_separation / 2
        xs, ys, _ = zip(*(wheel.place for wheel in wheels), strict=True)
        middle, left = sum(xs) / len(xs), (min(ys) + max(ys)) / 2
        if drive.skids:
            half += sum((x - middle) ** 2 for x in xs) / len(xs) / half
        return [
            left + (half if wheel.setting == "left_wheel" else -half)
            for wheel in wheels
        ]
    if isinstance(drive, MecanumWheels):
        # Rollers of wheels on a diagonal are parallel.
        diagonal = ("front_left_wheel", "rear_right_wheel")
        return [
            wheel.place[1]
            + (1 if wheel.setting in diagonal else -1) * wheel.place[0]
            for wheel in wheels
        ]
    return [wheel.place[1] for wheel in wheels]


def _forces(
    drive: MecanumWheels | PlanarBase, facts: ModelFacts, limit: float
) -> tuple[float, float]:
    """Returns the largest force, in N, and torque, in N m, on the base.

    `limit` is that of the model's motors of wheels, in N m.
    """
    if isinstance(drive, PlanarBase):
        return drive.max_force, drive.max_torque
    arms = list(map(abs, _arms(drive, facts.wheels)))
    force = min(
        len(arms) * min(drive.max_torque, limit) / drive.wheel_radius,
        _GRIP * facts.mass,
    )
    return force, force * sum(arms) / len(arms)


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


def make_motor_states(
    plant: MultibodyPlant, model: DrivenModel, drive: DriveConfig
) -> MotorStates:
    """Returns the commands of all motors of a model in a finalized plant.

    It is the function of `RobotDriver`, in the order of the plant's port.
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
    still = [0.0] * len(names)
    rolling: list[tuple[int, int, float]] = []
    radius, fastest, widest = 1.0, math.inf, 0.0
    if isinstance(drive, WheelDrive):
        radius, fastest = drive.wheel_radius, drive.max_wheel_speed
        fastest *= radius
        rolling = [
            (k, wheel.sign, arm)
            for k, wheel, arm in zip(
                driven, model.wheels, _arms(drive, model.wheels), strict=False
            )
            if not wheel.is_steered
        ]
        widest = max(abs(arm) for _, _, arm in rolling)
    steer = _make_steering(plant, model, drive, driven)
    planar = driven[len(model.wheels) :]

    def states(v: float, omega: float, yaw: float) -> list[float]:
        """Scales all motors equally, which keeps the curvature."""
        angles, omega = steer(v, omega)
        rim = abs(v) + widest * abs(omega)
        limit = min(1.0, fastest / rim) if rim else 1.0
        scale = limit / radius
        speeds = still.copy()
        for k, sign, arm in rolling:
            speeds[k] = sign * scale * (v - arm * omega)
        if planar:
            v, omega = limit * v, limit * omega
            values = v * math.cos(yaw), v * math.sin(yaw), omega
            for k, value in zip(planar, values, strict=True):
                speeds[k] = value
        held = places
        if angles:
            held = places.copy()
            for k, angle in angles:
                held[k] = angle
        return [*held, *speeds]

    return states


def _make_steering(
    plant: MultibodyPlant,
    model: DrivenModel,
    drive: DriveConfig,
    driven: list[int],
) -> Callable[[float, float], tuple[list[tuple[int, float]], float]]:
    """Returns a function of (v, omega) to angles of joints, and a turn rate.

    The turn rate is that which the steering allows at this speed.
    """
    if not isinstance(drive, AckermannSteering):
        return lambda v, omega: ([], omega)
    wheels = list(zip(driven, model.wheels, strict=True))
    steered = [(k, wheel) for k, wheel in wheels if wheel.is_steered]
    axle = [wheel.place[0] for _, wheel in wheels if not wheel.is_steered]
    rear = sum(axle) / len(axle)
    # The curvature at which the inner wheel is at its limit.
    sharpest = math.inf
    for _, wheel in steered:
        joint = plant.GetJointByName(wheel.joint, model.instance)
        (low,), (high,) = (
            joint.position_lower_limits(),
            joint.position_upper_limits(),
        )
        angle = min(drive.max_steering_angle, -low, high)
        x, y, _ = wheel.place
        sharpest = min(sharpest, 1 / ((x - rear) / math.tan(angle) + abs(y)))

    def steer(v: float, omega: float) -> tuple[list[tuple[int, float]], float]:
        limit = abs(v) * sharpest
        omega = min(max(omega, -limit), limit)
        curvature = omega / v if v else 0.0
        angles = []
        for k, wheel in steered:
            x, y, _ = wheel.place
            slope = curvature * (x - rear) / (1 - curvature * y)
            angles.append((k, wheel.sign * math.atan(slope)))
        return angles, omega

    return steer
