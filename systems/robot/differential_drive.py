"""A kinematic differential-drive robot."""

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

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_time_step
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    MOTION_SIZE,
    STATE_SIZE,
    Contact,
    X,
    Y,
)
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.crowd.walls.keep_out import (
    LEANING,
    LEAST_MARGIN,
    keep_out_of_walls,
)
from hunav_drake.systems.robot.contact_rows import MEMORY_SIZE, count_contacts
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.robot.robot_driver import next_velocity
from hunav_drake.systems.world.obstacles import Obstacles, nearest_wall


class DifferentialDrive(LeafSystem):
    """Follows a speed and a turn rate within the limits of the robot.

    .. pydrake_system::

        name: DifferentialDrive
        input_ports:
        - velocity_command
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

    The discrete state holds (x, y, yaw, v, omega), with the speed v of the
    wheels; a row of `contact_rows`; and the velocity (vx, vy) in W that walls
    took away in the last step.
    """

    def __init__(
        self,
        config: RobotConfig,
        *,
        time_step: float = 0.05,
        obstacles: Obstacles | None = None,
        walls_stop: bool = True,
    ) -> None:
        """Constructs a DifferentialDrive that starts at rest.

        There are no walls by default; `time_step` is in seconds.

        Raises:
            ValueError: If ``time_step`` is not positive.
        """
        super().__init__()
        self._time_step = check_time_step(time_step)
        self._radius = config.radius
        self._margin = np.array([max(config.radius - LEANING, LEAST_MARGIN)])
        self._limits = config.limits
        self._obstacles = obstacles or Obstacles.from_shapes([], solid=[])
        self._walls_stop = walls_stop

        self._velocity_command = self.DeclareVectorInputPort(
            "velocity_command", 2
        )
        self._state = self.DeclareDiscreteState([*config.start, 0.0, 0.0])
        self._robot_state = self.DeclareVectorOutputPort(
            "robot_state",
            STATE_SIZE,
            self._CalcRobotState,
            prerequisites_of_calc={self.xd_ticket()},
        )
        self._memory = self.DeclareDiscreteState(MEMORY_SIZE)
        self._lost = self.DeclareDiscreteState(2)
        self._wall_contact = self.DeclareVectorOutputPort(
            "wall_contact",
            CONTACT_SIZE,
            self._CalcWallContact,
            prerequisites_of_calc={self.discrete_state_ticket(self._memory)},
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
        """Places the robot at rest at (x, y, yaw), in meters and radians."""
        context.SetDiscreteState(
            self._state, np.concatenate([np.asarray(pose, dtype=float), [0, 0]])
        )
        context.SetDiscreteState(self._lost, np.zeros(2))

    def _CalcRobotState(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state(self._state).value()
        x, y, yaw, v, omega = state.tolist()
        lost_x, lost_y = context.get_discrete_state(self._lost).value().tolist()
        vx, vy = v * math.cos(yaw) - lost_x, v * math.sin(yaw) - lost_y
        # (Drake converts an array in half the time of a list.)
        row = np.array([x, y, yaw, vx, vy, omega, self._radius])
        output.SetFromVector(row)

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        state = context.get_discrete_state(self._state).value()
        x, y, yaw, *velocity = state.tolist()
        dt = self._time_step
        v, omega = next_velocity(
            *(self, context, self._velocity_command, velocity),
            *(self._limits, dt),
        )
        turn = omega * dt
        # The chord of the arc: its length is that of the arc times sin(turn/2)
        # / (turn/2), and it points along the heading at half the turn.
        half = turn / 2
        chord = v * dt * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        start = np.array([x, y])
        x += chord * math.cos(yaw + half)
        y += chord * math.sin(yaw + half)
        yaw = wrap_angle(yaw + turn)
        if len(self._obstacles):
            place = self._MeetWalls(
                context, discrete_state, start, np.array([x, y])
            )
            lost = np.zeros(2)
            if self._walls_stop and (place != (x, y)).any():
                x, y = place.tolist()
                lost += [v * math.cos(yaw), v * math.sin(yaw)]
                # (A robot that is moved out of a wall is at rest.)
                if math.dist(place, start) <= abs(chord) * (1 + 1e-9):
                    lost -= (place - start) / dt
            discrete_state.set_value(self._lost, lost)
        discrete_state.set_value(self._state, np.array([x, y, yaw, v, omega]))

    def _MeetWalls(
        self,
        context: Context,
        discrete_state: DiscreteValues,
        start: Array,
        end: Array,
    ) -> Array:
        """Counts contacts in a step; returns the position that walls allow."""
        before = np.zeros((1, MOTION_SIZE))
        after = before.copy()
        before[0, : Y + 1] = start
        after[0, : Y + 1] = end
        place: Array = keep_out_of_walls(
            before, after, self._margin, self._obstacles.table
        )[0, : Y + 1]
        stopped = (place != end).any()
        memory = context.get_discrete_state(self._memory).CopyToVector()
        if stopped or memory[Contact.LASTS]:
            gap = math.dist(start, nearest_wall(self._obstacles, start))
            gap -= self._radius
            # The speed into the wall, at any distance from it.
            into, way = (end - place).tolist(), (end - start).tolist()
            speed = into[X] * way[X] + into[Y] * way[Y]
            speed /= max(math.hypot(*into), 1e-12) * self._time_step
            memory = count_contacts(
                memory[None],
                np.array([stopped]),
                None,
                np.array([gap]),
                np.array([[max(speed, 0.0)], [0.0]]),
                self._time_step,
            )
            discrete_state.set_value(self._memory, memory.ravel())
        return place

    def _CalcWallContact(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).value()
        output.SetFromVector(memory[:CONTACT_SIZE])
