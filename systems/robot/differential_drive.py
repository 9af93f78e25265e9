"""A kinematic differential-drive robot."""

from dataclasses import astuple
import math

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_numbers, check_time_step
from hunav_drake.systems.common.layout import CONTACT_SIZE, STATE_SIZE
from hunav_drake.systems.crowd.walls.keep_out import LEANING, LEAST_MARGIN
from hunav_drake.systems.robot.contact_rows import MEMORY_SIZE
from hunav_drake.systems.robot.disc_step import (
    STATE,
    STATE_AND_LOST,
    drive_disc,
)
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.robot.robot_driver import get_command
from hunav_drake.systems.world.obstacles import Obstacles

_NO_OTHERS = np.zeros(0)


class DifferentialDrive(LeafSystem):
    """Follows a speed and a turn rate within the limits of the robot.

    .. pydrake_system::

        name: DifferentialDrive
        input_ports:
        - velocity_command
        - other_robot_states (only with other robots)
        output_ports:
        - robot_state
        - wall_contact

    Every ``time_step``, the speed and the turn rate change towards the command
    within the acceleration limits; the robot then drives an exact arc. The
    command itself is clipped to the limits.

    Port ``velocity_command`` takes (v, omega): the forward speed in m/s and the
    counterclockwise turn rate in rad/s. Port ``robot_state`` gives the row (x,
    y, yaw, vx, vy, omega, radius) in W, in SI units.

    Walls stop the disc of the robot: it moves as far as possible, and then
    along the wall (see `keep_out_of_walls`), while its wheels keep turning;
    port ``robot_state`` gives the actual velocity. Port ``wall_contact`` gives
    a row of `layout.Contact` for all walls together: the robot is in contact
    where walls stop it, or would if they could. Forces are 0.

    Port ``other_robot_states`` takes the rows of other robots. A step takes up
    at most half of the gap to each of their discs, so that robots which all do
    so never overlap.

    The discrete state holds (x, y, yaw, v, omega), with the speed v of the
    wheels; a row of `contact_rows`; and the velocity (vx, vy) in W that walls
    and other robots took away in the last step.
    """

    def __init__(
        self,
        config: RobotConfig,
        *,
        time_step: float = 0.05,
        obstacles: Obstacles | None = None,
        walls_stop: bool = True,
        num_others: int = 0,
    ) -> None:
        """Constructs a DifferentialDrive that starts at rest.

        There are no walls by default; `time_step` is in seconds; `num_others`
        is the number of other robots.

        Raises:
            ValueError: If ``time_step`` is not positive.
        """
        super().__init__()
        self._time_step = check_time_step(time_step)
        self._radius = config.radius
        self._margin = max(config.radius - LEANING, LEAST_MARGIN)
        self._limits = np.array(astuple(config.limits))
        self._obstacles = obstacles or Obstacles.from_shapes([], solid=[])
        self._walls_stop = walls_stop

        self._velocity_command = self.DeclareVectorInputPort(
            "velocity_command", 2
        )
        self._others = None
        if num_others:
            self._others = self.DeclareVectorInputPort(
                "other_robot_states", STATE_SIZE * num_others
            )
        # (Numbers are found faster by an integer than by a typed index.)
        self._state = int(self.DeclareDiscreteState([*config.start, 0.0, 0.0]))
        self._robot_state = self.DeclareVectorOutputPort(
            "robot_state",
            STATE_SIZE,
            self._CalcRobotState,
            prerequisites_of_calc={self.xd_ticket()},
        )
        self._memory = int(self.DeclareDiscreteState(MEMORY_SIZE))
        self._lost = int(self.DeclareDiscreteState(2))
        self._wall_contact = self.DeclareVectorOutputPort(
            "wall_contact",
            CONTACT_SIZE,
            self._CalcWallContact,
            prerequisites_of_calc={
                self.discrete_state_ticket(DiscreteStateIndex(self._memory))
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_velocity_command_input_port(self) -> InputPort:
        """Returns the port with the commanded speed and turn rate."""
        return self._velocity_command

    def get_robot_state_output_port(self) -> OutputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_wall_contact_output_port(self) -> OutputPort:
        """Returns the port with the contact with walls."""
        return self._wall_contact

    def SetPose(self, context: Context, pose: ArrayLike) -> None:
        """Places the robot at rest at (x, y, yaw), in meters and radians.

        Raises:
            ValueError: If these are not three finite numbers.
        """
        self.ValidateContext(context)
        x_y_yaw = check_numbers(
            "the pose", pose, "three finite numbers (x, y, yaw)", 3
        )
        context.SetDiscreteState(self._state, np.append(x_y_yaw, [0, 0]))
        context.SetDiscreteState(self._lost, np.zeros(2))

    def Shift(self, context: Context, offset: ArrayLike) -> None:
        """Moves the robot by (x, y) in W, in meters; it drives on.

        Raises:
            ValueError: If these are not two finite numbers.
        """
        self.ValidateContext(context)
        offset = check_numbers(
            "the offset", offset, "two finite numbers (x, y)", 2
        )
        state = context.get_discrete_state(self._state).CopyToVector()
        state[:2] += offset
        context.SetDiscreteState(self._state, state)

    def _CalcRobotState(self, context: Context, output: BasicVector) -> None:
        # (A few numbers take less time than views of vectors.)
        state = context.get_discrete_state(self._state).GetAtIndex
        lost = context.get_discrete_state(self._lost).GetAtIndex
        x, y, yaw, v = state(0), state(1), state(2), state(3)
        vx, vy = v * math.cos(yaw) - lost(0), v * math.sin(yaw) - lost(1)
        row = (x, y, yaw, vx, vy, state(4), self._radius)
        for i, number in enumerate(row):
            output.SetAtIndex(i, number)

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        after = drive_disc(
            context.get_discrete_state(self._state).value(),
            get_command(self, context, self._velocity_command),
            *(self._limits, self._time_step, self._margin, self._radius),
            self._walls_stop,
            context.get_discrete_state(self._memory).value(),
            self._obstacles.table,
            _NO_OTHERS
            if self._others is None
            else self._others.EvalBasicVector(context).value(),
        )
        discrete_state.set_value(self._state, after[:STATE])
        discrete_state.set_value(self._lost, after[STATE:STATE_AND_LOST])
        discrete_state.set_value(self._memory, after[STATE_AND_LOST:])

    def _CalcWallContact(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).value()
        output.SetFromVector(memory[:CONTACT_SIZE])
