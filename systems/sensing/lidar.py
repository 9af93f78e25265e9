"""A lidar that scans a horizontal plane."""

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count
from hunav_drake.systems.common.layout import (
    RADIUS,
    SIGNAL_SIZE,
    STATE_SIZE,
    X,
    Y,
)
from hunav_drake.systems.common.ports import RequirePort
from hunav_drake.systems.common.random_streams import (
    Purpose,
    draw_normal,
    draw_uniform,
)
from hunav_drake.systems.common.sampling import Sampling
from hunav_drake.systems.people.figure_config import (
    BODY_SIZE,
    Figures,
    adult_figures,
)
from hunav_drake.systems.people.gait import (
    advance_gait,
    initial_gait,
    pose_figures,
)
from hunav_drake.systems.people.legs import ELLIPSE_SIZE, legs_at
from hunav_drake.systems.people.manners import (
    advance_manners,
    hold_figures,
    initial_manners,
)
from hunav_drake.systems.sensing.ray_kernels import ray_distances
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_parameters import LidarParameters
from hunav_drake.systems.world.obstacles import Obstacles

# The height of people, in meters; a higher plane detects nobody.
PERSON_HEIGHT = 1.7


class Lidar(Sampling, LeafSystem):
    """Measures the distances to walls, people and other robots.

    .. pydrake_system::

        name: Lidar
        input_ports:
        - robot_state
        - human_states
        - other_robot_states
        - social_signals (only if lively, and of lidars that detect legs)
        output_ports:
        - scan

    Ray i has the angle `config.angles()[i]` from straight ahead, and ends at
    the first obstacle in the plane of the lidar: a wall, the disc of another
    robot, or a person. People are two legs, ellipses that follow the gait of
    the figures of `AddScene`, and sit as these do, or discs. A lidar does not
    detect the robot that carries it; a lidar on the ground detects the robot.

    Every ``config.period`` a scan of the current instant is taken; the port
    gives it at once, until the next one. With noise, each distance has a
    normally distributed error, and with dropout some rays have no return; both
    depend on the seed, the number of the lidar and the number of the scan
    (Philox: see `random_streams`).

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
    robot, ``human_states`` n such rows of the people, and
    ``other_robot_states`` m rows of further robots, if there are any; all in W,
    in SI units. Port ``social_signals`` takes n rows of `layout.Signal`: who
    sits. Port ``scan`` gives the distances, in meters, each in
    [range_min, range_max]. A ray without a hit in range gives `range_max`, and
    one with a hit nearer than `range_min` gives `range_min`, so distances are
    always finite, and near obstacles are never lost. `scan_points` converts
    them to points.

    The discrete state holds the last scan and its step (-1 before the first);
    a second group, for lidars that detect legs, holds the gait of each person,
    and a third one, if they are lively, their `manners`.
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
        figures: Figures | None = None,
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
            figures: The figures of the people; by default adults. If lively,
                ``social_signals`` tell who sits.

        Raises:
            ValueError: If a number is out of its range, or the period of the
                lidar is not a multiple of ``time_step``.
        """
        super().__init__()
        self._config = config or LidarParameters()
        self._DeclareSampling(
            np.full(self._config.num_rays, self._config.range_max),
            period=self._config.period,
            time_step=time_step,
            seed=seed,
            number=number,
        )
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
        self._gait = self._manners = self._signals = None
        if self._has_humans and self._config.people == "legs":
            figures = figures or Figures(adult_figures(num_humans))
            self._figures = np.asarray(figures.rows, dtype=float)
            if self._figures.shape != (num_humans, BODY_SIZE):
                raise ValueError(
                    f"figures.rows: must have the shape ({num_humans},"
                    f" {BODY_SIZE}), got {self._figures.shape}"
                )
            ids = figures.numbers()
            self._gait = self.DeclareDiscreteState(initial_gait(ids))
            if figures.lively:
                self._manners = self.DeclareDiscreteState(initial_manners(ids))
                self._signals = self.DeclareVectorInputPort(
                    "social_signals", SIGNAL_SIZE * num_humans
                )
        self._samples = self.DeclareVectorOutputPort(
            "scan", self._config.num_rays, self._CalcSample
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
        return self._samples

    def DescribeMemory(self) -> list[str]:
        """Returns what the state depends on: the parameters of the lidar."""
        return [f"of {self._config}"]

    def _Measure(self, context: Context, held: Array, number: int) -> Array:
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
        draw = (self.GetSeed(context), [self._number])
        count = config.num_rays
        if config.is_noisy:
            (errors,) = draw_normal(
                *draw, Purpose.LIDAR_NOISE, count, step=number
            )
            distances = distances + config.deviation(distances) * errors
        if config.dropout > 0.0:
            (chances,) = draw_uniform(
                *draw, Purpose.LIDAR_DROPOUT, count, step=number
            )
            lost = chances < config.dropout
            distances = np.where(lost, config.range_max, distances)
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
                part = self._Figures(context, states), states, self._figures
                parts.append(legs_at(*part, self._config.height))
        if self._others is not None:
            parts.append(_discs(self._others.Eval(context)))
        if self._config.mount == "world" and robot is not None:
            parts.append(_discs(robot))
        return np.concatenate(parts)

    def _Figures(self, context: Context, states: Array) -> Array:
        """Returns the positions of the figures of people, as they are drawn."""
        groups = context.get_discrete_state()
        gait = groups.value(self._gait)
        figures: Array = pose_figures(gait, states, self._figures)
        if self._manners is None:
            return figures
        manners = groups.value(self._manners)
        lively: Array = hold_figures(figures, manners, self._figures)
        return lively

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        super()._Update(context, discrete_state)
        if self._gait is not None:
            gait = advance_gait(
                context.get_discrete_state(self._gait).value(),
                self._human_states.Eval(context),
                self._time_step,
            )
            discrete_state.set_value(self._gait, gait)
        if self._signals is not None and self._signals.HasValue(context):
            # (Where they look does not move their legs.)
            manners = advance_manners(
                context.get_discrete_state(self._manners).value(),
                self._signals.Eval(context),
                self._human_states.Eval(context),
                np.zeros(0),
                self._time_step,
            )
            discrete_state.set_value(self._manners, manners)


def _discs(states: Array) -> Array:
    """Returns the discs of rows of bodies, as ellipses, shape (k, 5)."""
    rows = states.reshape(-1, STATE_SIZE)
    result = np.zeros((len(rows), ELLIPSE_SIZE))
    result[:, :2] = rows[:, [X, Y]]
    result[:, 3:] = rows[:, [RADIUS]]
    return result
