"""A body of a MultibodyPlant as a robot among people."""

import math

from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_number
from hunav_drake.systems.common.layout import STATE_SIZE


class BodyState(LeafSystem):
    """Converts the pose and velocity of a body B to a row of `robot_state`.

    .. pydrake_system::

        name: BodyState
        input_ports:
        - body_poses
        - body_spatial_velocities
        output_ports:
        - robot_state

    The inputs take the outputs of a MultibodyPlant that have these names. Port
    ``robot_state`` gives the row (x, y, yaw, vx, vy, omega, radius) in W, in SI
    units: the position and velocity of the body's origin Bo projected onto the
    floor (the x-y plane), the direction of the body's x axis seen from above,
    and the turn rate about the vertical. For a body whose x axis is vertical,
    the yaw is 0.

    It has no state: the output is a function of the inputs.
    """

    def __init__(self, body_index: BodyIndex, radius: float) -> None:
        """Constructs a BodyState of a body in the plant.

        The radius of the robot's disc for people is around the body's origin,
        in meters.

        Raises:
            ValueError: If ``radius`` is not positive and finite.
        """
        super().__init__()
        self._index = int(body_index)
        self._radius = check_number("radius", radius, "m", low_open=True)
        self._body_poses = self.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self._body_spatial_velocities = self.DeclareAbstractInputPort(
            "body_spatial_velocities",
            AbstractValue.Make([SpatialVelocity.Zero()]),
        )
        self._robot_state = self.DeclareVectorOutputPort(
            "robot_state",
            STATE_SIZE,
            self._CalcRobotState,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def get_body_poses_input_port(self) -> InputPort:
        """Returns the port with the poses X_WB of all bodies."""
        return self._body_poses

    def get_body_spatial_velocities_input_port(self) -> InputPort:
        """Returns the port with the velocities V_WB of all bodies."""
        return self._body_spatial_velocities

    def get_robot_state_output_port(self) -> OutputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def _CalcRobotState(self, context: Context, output: BasicVector) -> None:
        X_WB = self._body_poses.Eval(context)[self._index]
        V_WB = self._body_spatial_velocities.Eval(context)[self._index]
        (cos, _, _, x), (sin, _, _, y), *_ = X_WB.GetAsMatrix34().tolist()
        # Rounding leaves about 1e-17 of a vertical axis.
        upright = math.hypot(cos, sin) < 1e-9
        yaw = 0.0 if upright else math.atan2(sin, cos)
        _, _, omega, vx, vy, _ = V_WB.get_coeffs().tolist()
        output.SetFromVector([x, y, yaw, vx, vy, omega, self._radius])


def AddBodyState(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    body: RigidBody,
    *,
    radius: float,
) -> OutputPort:
    """Adds the state of a plant's body as a robot among people.

    Args:
        builder: The builder with the plant; the added system is named
            "state_of_" and the scoped name of the body, with "_" for "::".
        plant: A finalized plant.
        body: A body of the plant, such as the base of a robot.
        radius: The radius of the robot's disc for people, in meters.

    Returns:
        The port ``robot_state``: see `BodyState`.

    Raises:
        ValueError: If ``radius`` is not positive, if the plant is not
            finalized or does not have the body, or if the body's state has
            been added already.
    """
    if not plant.is_finalized():
        raise ValueError(
            f"plant {plant.get_name()!r} must be finalized before the state of"
            f" its body {body.name()!r} is added: call Finalize()"
        )
    scoped_name = body.scoped_name().get_full()
    if body.GetParentPlant() is not plant:
        raise ValueError(
            f"body {scoped_name!r} does not belong to plant"
            f" {plant.get_name()!r}: take it from plant.GetBodyByName(...)"
        )
    name = "state_of_" + scoped_name.replace("::", "_")
    # Drake aborts the interpreter if a name is taken.
    if builder.HasSubsystemNamed(name):
        raise ValueError(
            f"there is a system {name!r} already: connect its port robot_state"
            f" instead of adding the state of {scoped_name!r} again"
        )
    state = builder.AddNamedSystem(name, BodyState(body.index(), radius))
    builder.Connect(
        plant.get_body_poses_output_port(), state.get_body_poses_input_port()
    )
    builder.Connect(
        plant.get_body_spatial_velocities_output_port(),
        state.get_body_spatial_velocities_input_port(),
    )
    port: OutputPort = state.get_robot_state_output_port()
    return port
