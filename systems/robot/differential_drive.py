"""A kinematic robot with two driven wheels."""

import math

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_time_step
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.robot.robot_config import RobotConfig


class DifferentialDrive(LeafSystem):
    """A robot that follows a speed and a turn rate within its limits.

    .. pydrake_system::

        name: DifferentialDrive
        input_ports:
        - velocity_command
        output_ports:
        - robot_state

    Every ``time_step``, the speed and the turn rate move towards the command,
    no faster than the limits allow; the robot then drives an exact arc. The
    command itself is cut to the limits.

    Port ``velocity_command`` takes (v, omega): the speed forwards in m/s and
    the turn rate in rad/s, counter-clockwise. Port ``robot_state`` gives the
    row (x, y, yaw, vx, vy, omega, radius) in W, in SI units.

    The discrete state holds (x, y, yaw, v, omega).
    """

    def __init__(self, config: RobotConfig, *, time_step: float = 0.05) -> None:
        """Constructs a DifferentialDrive that starts at rest.

        Args:
            config: The radius, the limits and the start of the robot.
            time_step: The time between two updates, in seconds.

        Raises:
            ValueError: If ``time_step`` is not positive.
        """
        super().__init__()
        self._time_step = check_time_step(time_step)
        self._radius = config.radius
        self._limits = config.limits

        self._velocity_command = self.DeclareVectorInputPort(
            "velocity_command", 2
        )
        self._state = self.DeclareDiscreteState([*config.start, 0.0, 0.0])
        self._robot_state = self.DeclareVectorOutputPort(
            "robot_state",
            STATE_SIZE,
            self._CalcRobotState,
            prerequisites_of_calc={self.discrete_state_ticket(self._state)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_velocity_command_input_port(self) -> InputPort:
        """Returns the port with the wanted speed and turn rate."""
        return self._velocity_command

    def get_robot_state_output_port(self) -> OutputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def SetPose(self, context: Context, pose: ArrayLike) -> None:
        """Puts the robot at rest at a pose (x, y, yaw), in meters, radians."""
        context.SetDiscreteState(
            self._state, np.concatenate([np.asarray(pose, dtype=float), [0, 0]])
        )

    def _CalcRobotState(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state(self._state).value()
        x, y, yaw, v, omega = state.tolist()
        vx, vy = v * math.cos(yaw), v * math.sin(yaw)
        # (Drake takes an array in half the time of a list.)
        row = np.array([x, y, yaw, vx, vy, omega, self._radius])
        output.SetFromVector(row)

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        wanted_v, wanted_omega = self._velocity_command.Eval(context).tolist()
        if not (math.isfinite(wanted_v) and math.isfinite(wanted_omega)):
            raise RuntimeError(
                f"{self.GetSystemPathname()}, t = {context.get_time():.3f} s:"
                f" velocity_command must be finite, got ({wanted_v},"
                f" {wanted_omega}). Look at the planner that gives it."
            )
        state = context.get_discrete_state(self._state).value()
        x, y, yaw, v, omega = state.tolist()
        dt = self._time_step
        limits = self._limits
        v = _approach(
            v,
            _clip(wanted_v, -limits.max_reverse_speed, limits.max_speed),
            limits.max_acceleration * dt,
        )
        omega = _approach(
            omega,
            _clip(wanted_omega, -limits.max_turn_rate, limits.max_turn_rate),
            limits.max_turn_acceleration * dt,
        )
        turn = omega * dt
        # The chord of the arc: its length is that of the arc times
        # sin(turn/2) / (turn/2), and it points half the turn ahead.
        half = turn / 2
        chord = v * dt * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        x += chord * math.cos(yaw + half)
        y += chord * math.sin(yaw + half)
        yaw = wrap_angle(yaw + turn)
        discrete_state.set_value(self._state, np.array([x, y, yaw, v, omega]))


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _approach(value: float, target: float, most: float) -> float:
    """Returns the value moved towards the target by at most `most`."""
    return value + _clip(target - value, -most, most)
