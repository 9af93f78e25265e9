"""A lidar that scans a horizontal plane."""

import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count, count_steps
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, X, Y
from hunav_drake.systems.common.ports import RequirePort
from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    draw_normal,
    halves_to_seed,
    seed_to_halves,
)
from hunav_drake.systems.people.gait import advance_gait, initial_gait
from hunav_drake.systems.people.legs import ELLIPSE_SIZE, legs_at
from hunav_drake.systems.sensing.ray_kernels import ray_distances
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_parameters import LidarParameters
from hunav_drake.systems.world.obstacles import Obstacles

# The height of people, in meters; a higher plane detects nobody.
PERSON_HEIGHT = 1.7


class Lidar(LeafSystem):
    """Measures the distances to walls, people and other robots.

    .. pydrake_system::

        name: Lidar
        input_ports:
        - robot_state
        - human_states
        - other_robot_states
        output_ports:
        - scan

    Ray i has the angle `config.angles()[i]` from straight ahead, and ends at
    the first obstacle in the plane of the lidar: a wall, the disc of another
    robot, or a person. People are two legs, ellipses that follow the gait of
    the figures of `AddScene`, or discs. A lidar does not detect the robot that
    carries it; a lidar on the ground detects the robot.

    Every ``config.period`` a scan of the current instant is taken; the port
    gives it at once, until the next one. With noise, each distance has a
    normally distributed error that depends on the seed, the number of the lidar
    and the number of the scan (Philox: see `random_streams`).

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
    robot, ``human_states`` n such rows of the people, and
    ``other_robot_states`` m rows of further robots, if there are any; all in W,
    in SI units. Port ``scan`` gives the distances, in meters, each in
    [range_min, range_max]. A ray without a hit in range gives `range_max`, and
    one with a hit nearer than `range_min` gives `range_min`, so distances are
    always finite, and near obstacles are never lost. `scan_points` converts
    them to points.

    The discrete state holds the last scan and its number (-1 before the first);
    a second group, for lidars that detect legs, holds the gait of each person.
    A numeric parameter holds the seed, in two halves. The state is updated
    every ``time_step``, for any period, so that all parts of a trial move at
    the same instants.
    """

    def __init__(
        self,
        config: LidarParameters | None = None,
        *,
        obstacles: Obstacles | None = None,
        num_humans: int = 0,
        num_other_robots: int = 0,
        time_step: float = 0.05,
        seed: int = 0,
        number: int = 0,
    ) -> None:
        """Constructs a Lidar.

        Args:
            config: Its rays and its mount.
            obstacles: The obstacles in its plane: see `World.obstacles`. None
                by default.
            num_humans: The number of people.
            num_other_robots: The number of robots besides that of
                ``robot_state``.
            time_step: The time between two updates, in seconds.
            seed: The seed of the default Context, in [0, 2^63).
            number: Distinguishes lidars with the same seed; from 0.

        Raises:
            ValueError: If a number is out of its range, or the period of the
                lidar is not a multiple of ``time_step``.
        """
        super().__init__()
        self._config = config or LidarParameters()
        self._steps_per_scan = count_steps(self._config.period, time_step)
        self._time_step = time_step
        self._number = check_count("number", number)
        if obstacles is None:
            obstacles = Obstacles.from_shapes([], solid=[])
        self._walls = obstacles.table
        self._rays = np.array(
            [self._config.first_angle, self._config.angle_step]
        )

        num_humans = check_count("num_humans", num_humans)
        self._has_humans = (
            num_humans > 0 and self._config.height <= PERSON_HEIGHT
        )
        num_others = check_count("num_other_robots", num_other_robots)
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._human_states = self.DeclareVectorInputPort(
            "human_states", num_humans * STATE_SIZE
        )
        self._others = None
        if num_others:
            self._others = self.DeclareVectorInputPort(
                "other_robot_states", num_others * STATE_SIZE
            )
        no_scan = np.full(self._config.num_rays + 1, self._config.range_max)
        no_scan[-1] = -1
        self._held = self.DeclareDiscreteState(no_scan)
        self._gait = None
        if self._has_humans and self._config.people == "legs":
            self._gait = self.DeclareDiscreteState(initial_gait(num_humans))
        self._seed = self.DeclareNumericParameter(
            BasicVector(seed_to_halves(check_seed(seed)))
        )
        self._scan = self.DeclareVectorOutputPort(
            "scan",
            self._config.num_rays,
            self._CalcScan,
            prerequisites_of_calc={
                self.time_ticket(),
                self.all_input_ports_ticket(),
                self.xd_ticket(),
                self.all_parameters_ticket(),
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_other_robot_states_input_port(self) -> InputPort:
        """Returns the port with the states of further robots.

        Raises:
            ValueError: If it was constructed without other robots.
        """
        return RequirePort(
            self, self._others, "other_robot_states", "num_other_robots=0"
        )

    def get_scan_output_port(self) -> OutputPort:
        """Returns the port with the distances."""
        return self._scan

    def SetSeed(self, context: Context, seed: int) -> None:
        """Sets the seed of the noise in a Context; nothing else changes.

        Raises:
            ValueError: If the seed is not in [0, 2^63).
        """
        halves = seed_to_halves(check_seed(seed))
        context.get_mutable_numeric_parameter(self._seed).SetFromVector(halves)

    def GetSeed(self, context: Context) -> int:
        """Returns the seed of a Context of this system."""
        parameter = context.get_numeric_parameter(self._seed)
        return halves_to_seed(parameter.CopyToVector())

    def _ScanNumber(self, context: Context) -> int:
        """Returns the number of the latest possible scan, from 0."""
        time: float = context.get_time()
        steps = math.floor(time / self._time_step + 1e-6)
        return steps // self._steps_per_scan

    def _CalcScan(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state(self._held).value()
        number = self._ScanNumber(context)
        if held[-1] >= number:
            output.SetFromVector(held[:-1])
        else:
            output.SetFromVector(self._Measure(context, number))

    def _Measure(self, context: Context, number: int) -> Array:
        config = self._config
        robot = self._Robot(context)
        distances = ray_distances(
            *sensor_pose(config, robot),
            self._rays,
            config.num_rays,
            config.range_max,
            self._Bodies(context, robot),
            self._walls,
        )
        if config.noise > 0.0:
            (errors,) = draw_normal(
                self.GetSeed(context),
                [self._number],
                Purpose.LIDAR_NOISE,
                config.num_rays,
                step=number,
            )
            distances = distances + config.noise * errors
        result: Array = np.clip(distances, config.range_min, config.range_max)
        return result

    def _Robot(self, context: Context) -> Array | None:
        """Returns the row of the robot; None if there is none."""
        if self._config.mount == "world" and not self._robot_state.HasValue(
            context
        ):
            return None
        state: Array = self._robot_state.Eval(context)
        return state

    def _Bodies(self, context: Context, robot: Array | None) -> Array:
        """Returns the ellipses of all moving bodies, shape (k, 5)."""
        parts = [np.zeros((0, ELLIPSE_SIZE))]
        if self._has_humans:
            states = self._human_states.Eval(context)
            if self._gait is None:
                parts.append(_discs(states))
            else:
                gait = context.get_discrete_state(self._gait).value()
                parts.append(legs_at(gait, states, self._config.height))
        if self._others is not None:
            parts.append(_discs(self._others.Eval(context)))
        if self._config.mount == "world" and robot is not None:
            parts.append(_discs(robot))
        return np.concatenate(parts)

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        number = self._ScanNumber(context)
        if context.get_discrete_state(self._held).value()[-1] < number:
            scan = self._scan.Eval(context)
            discrete_state.set_value(self._held, [*scan.tolist(), number])
        if self._gait is not None:
            gait = advance_gait(
                context.get_discrete_state(self._gait).value(),
                self._human_states.Eval(context),
                self._time_step,
            )
            discrete_state.set_value(self._gait, gait)


def _discs(states: Array) -> Array:
    """Returns the discs of rows of bodies, as ellipses, shape (k, 5)."""
    rows = states.reshape(-1, STATE_SIZE)
    result = np.zeros((len(rows), ELLIPSE_SIZE))
    result[:, :2] = rows[:, [X, Y]]
    result[:, 3:] = rows[:, [RADIUS]]
    return result
