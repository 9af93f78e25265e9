"""The velocity controller of a robot in a plant."""

from collections.abc import Callable
from dataclasses import astuple
import math

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import OMEGA, STATE_SIZE, VX, VY, YAW
from hunav_drake.systems.robot.disc_step import next_velocity
from hunav_drake.systems.robot.robot_config import RobotLimits

# A function from a speed v in m/s, a turn rate in rad/s and a heading in rad to
# the positions that the motors hold, in their order, followed by their speeds.
# (Motors that hold speeds have no spring, so their positions do not count.)
MotorStates = Callable[[float, float, float], list[float]]

# How much may be added to speed and turn rate, as parts of their limits.
_ADDED = (0.1, 0.5)


class RobotDriver(LeafSystem):
    """Converts a velocity command to the desired state of a plant's motors.

    .. pydrake_system::

        name: RobotDriver
        input_ports:
        - velocity_command
        - robot_state (for drives that depend on it)
        output_ports:
        - desired_state

    Port ``velocity_command`` takes (v, omega), in m/s and rad/s, and
    ``robot_state`` the row (x, y, yaw, vx, vy, omega, radius) of the robot in
    W, of which heading and velocity count. Every ``period``, speed and turn
    rate change towards the command within the acceleration limits; the
    command itself is clipped to the limits. Port ``desired_state`` gives the
    state that the plant's motors hold from then on: all positions, then all
    speeds, in rad and rad/s, or m and m/s.

    With a ``gain``, the integrals of the differences between speed and turn
    rate and the actual ones are added to them, up to a part of their limits,
    and nothing at rest.

    The discrete state holds the output; a second group holds (v, omega), and a
    third one, with a ``gain``, what is added.
    """

    def __init__(
        self,
        limits: RobotLimits,
        motor_states: MotorStates,
        *,
        period: float,
        needs_heading: bool = False,
        gain: float = 0.0,
    ) -> None:
        """Constructs a RobotDriver that starts at rest.

        Without `needs_heading` or a `gain`, in 1/s, there is no port
        ``robot_state``. `period` is in seconds.
        """
        super().__init__()
        self._limits = np.array(astuple(limits))
        self._motor_states = motor_states
        self._gain = gain
        self._most_added = np.multiply(
            _ADDED, [limits.max_speed, limits.max_turn_rate]
        )
        self._period = period
        self._velocity_command = self.DeclareVectorInputPort(
            "velocity_command", 2
        )
        self._robot_state = (
            self.DeclareVectorInputPort("robot_state", STATE_SIZE)
            if needs_heading or gain
            else None
        )
        self._motors = self.DeclareDiscreteState(motor_states(0.0, 0.0, 0.0))
        self._speeds = self.DeclareDiscreteState(2)
        if gain:
            self._added = self.DeclareDiscreteState(2)
        self._desired_state = self.DeclareStateOutputPort(
            "desired_state", self._motors
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=period, offset_sec=0.0, update=self._Update
        )

    def get_velocity_command_input_port(self) -> InputPort:
        """Returns the port with the commanded speed and turn rate."""
        return self._velocity_command

    def get_robot_state_input_port(self) -> InputPort | None:
        """Returns the port with the state of the robot, if there is one."""
        return self._robot_state

    def get_desired_state_output_port(self) -> OutputPort:
        """Returns the port with the desired state of the motors."""
        return self._desired_state

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        before = context.get_discrete_state(self._speeds).value()
        period = self._period
        wanted = get_command(self, context, self._velocity_command)
        speeds_after = next_velocity(before, wanted, self._limits, period)
        v, omega = speeds_after.tolist()
        if self._robot_state is None and [v, omega] == before.tolist():
            return
        yaw = 0.0
        if self._robot_state is not None:
            row = self._robot_state.Eval(context)
            # The heading in the middle of the step of this command.
            yaw = float(row[YAW])
            yaw += 1.5 * omega * period
            if self._gain:
                ahead = row[VX] * math.cos(row[YAW]) + row[VY] * math.sin(
                    row[YAW]
                )
                missing = before - [ahead, row[OMEGA]]
                added = context.get_discrete_state(self._added).value()
                added = np.clip(
                    added + self._gain * period * missing,
                    -self._most_added,
                    self._most_added,
                )
                if not speeds_after.any():
                    # A robot that was held no longer pushes when it is to rest.
                    added = np.zeros(2)
                discrete_state.set_value(self._added, added)
                v, omega = (speeds_after + added).tolist()
        states = self._motor_states(v, omega, yaw)
        discrete_state.set_value(self._motors, states)
        discrete_state.set_value(self._speeds, speeds_after)


def get_command(
    system: LeafSystem, context: Context, command: InputPort
) -> Array:
    """Returns the commanded (v, omega), a view.

    Raises:
        RuntimeError: If it is not finite.
    """
    # (Eval() would copy it, in twice the time.)
    given = command.EvalBasicVector(context)
    v, omega = given.GetAtIndex(0), given.GetAtIndex(1)
    if not (math.isfinite(v) and math.isfinite(omega)):
        raise RuntimeError(
            f"{system.GetSystemPathname()}, t = {context.get_time():.3f} s:"
            f" velocity_command must be finite, got ({v}, {omega}). Look at"
            " the planner that gives it."
        )
    wanted: Array = given.value()
    return wanted
