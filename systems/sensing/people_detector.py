"""The LeafSystem that detects people with errors."""

from collections.abc import Sequence
import math

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    RADIUS,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.common.random_streams import (
    Purpose,
    draw_normal,
    draw_uniform,
)
from hunav_drake.systems.common.sampling import Sampling
from hunav_drake.systems.people.legs import ELLIPSE_SIZE
from hunav_drake.systems.sensing.ray_kernels import ray_distances
from hunav_drake.systems.sensing.sensor_parameters import DetectorParameters
from hunav_drake.systems.sensing.visible_people import VisiblePeople, only_seen
from hunav_drake.systems.world.obstacles import Obstacles

# The radius of a false detection, in meters.
FALSE_RADIUS = 0.3

_NOBODY = np.zeros((0, ELLIPSE_SIZE))


class PeopleDetector(Sampling, VisiblePeople):
    """Detects people in a robot's view, with errors.

    .. pydrake_system::

        name: PeopleDetector
        input_ports:
        - robot_state
        - human_states
        - other_robot_states (only with other robots)
        output_ports:
        - visible_people
        - visible

    Every ``config.period`` it detects the people in view, as `VisiblePeople`
    does; the ports give that at once, until the next detection. At distance d
    from the detector, a person is missed with the probability `missed` +
    `missed_per_meter` d; x and y have normally distributed errors with the
    standard deviation `noise` + `noise_per_meter` d, and both components of the
    velocity such errors with `velocity_noise`, all in W. Heading, turn rate and
    radius are exact, and rows keep their order: nobody is taken for another.

    False detections begin as a Poisson process of `false_rate`, and last
    exponentially distributed times with the mean `false_duration`, in whole
    periods; each ends early when it is no longer in view. They are at rest in
    W, in a direction that is uniformly distributed over the field of view, and
    there uniformly over the area up to the first wall, but not on the robot;
    they face the detector, and have the radius 0.3 m. There are at most
    `max_false`.

    The ports are those of `VisiblePeople`; after the rows of people and robots
    come `config.num_false_rows` for false detections. Draws depend on the seed,
    the number of the detector, that of the person and that of the detection.
    For the state see `Sampling`: a sample holds the rows.
    """

    _config: DetectorParameters

    def __init__(
        self,
        config: DetectorParameters | None = None,
        *,
        obstacles: Obstacles | None = None,
        num_humans: int,
        num_other_robots: int = 0,
        time_step: float = 0.05,
        seed: int = 0,
        number: int = 0,
        human_ids: Sequence[int] | None = None,
    ) -> None:
        """Constructs a PeopleDetector; see `Lidar` and `VisiblePeople`.

        ``human_ids`` are the numbers of the people, on which their errors
        depend; by default 1, 2, ...

        Raises:
            ValueError: If a number is out of its range, or the period of the
                detector is not a multiple of ``time_step``.
        """
        # Here, since only trials with a detector need it, and it loads slowly.
        from scipy.special import pdtr

        config = config or DetectorParameters()
        num_false = config.num_false_rows
        super().__init__(
            config,
            obstacles=obstacles,
            num_humans=num_humans,
            num_other_robots=num_other_robots,
            num_more_rows=num_false,
        )
        self._samples = self._visible_people
        rows = np.zeros((self._num_bodies + num_false, STATE_SIZE))
        self._DeclareSampling(
            only_seen(rows, np.zeros(len(rows), dtype=np.bool_)).ravel(),
            period=config.period,
            time_step=time_step,
            seed=seed,
            number=number,
        )
        ids = range(1, num_humans + 1) if human_ids is None else human_ids
        # Streams of draws: of people by their numbers, and of other robots.
        self._ids = [(i - 1) % 2**31 for i in ids]
        others = range(self._num_bodies - num_humans)
        self._ids += [2**20 - 1 - k for k in others]
        begun = config.false_rate * config.period
        # The probabilities that at most 0, 1, ... begin in a period.
        self._at_most = pdtr(np.arange(num_false), begun)
        self._lasting = math.exp(-config.period / config.false_duration)

    def DescribeMemory(self) -> list[str]:
        """Returns what the state depends on: the parameters of the detector."""
        return [f"of {self._config}"]

    def _CalcVisible(self, context: Context, output: BasicVector) -> None:
        rows = self._visible_people.Eval(context).reshape(-1, STATE_SIZE)
        output.SetFromVector((~is_outside(rows)).astype(float))

    _CalcVisiblePeople = Sampling._CalcSample

    def _Measure(self, context: Context, held: Array, number: int) -> Array:
        n, config, seed = self._num_bodies, self._config, self.GetSeed(context)
        before = held[n * STATE_SIZE : -1].reshape(-1, STATE_SIZE)
        if not n:
            nobody = np.zeros(0)
            return self._Imagine(context, nobody, before, seed, number)
        bodies = self._Bodies(context)
        seen = self._Look(context, bodies)
        rows = bodies.reshape(-1, STATE_SIZE).copy()
        x, y, _ = self._Pose(context)
        away = np.hypot(rows[:, X] - x, rows[:, Y] - y)
        # People do not change the draws of others.
        ids = [(self._number << 20) + i for i in self._ids]
        purpose = Purpose.MISSED_DETECTION
        (chances,) = draw_uniform(seed, ids, purpose, 1, step=number).T
        seen &= chances >= config.missed + config.missed_per_meter * away
        purpose = Purpose.DETECTION_NOISE
        errors = draw_normal(seed, ids, purpose, 4, step=number)
        deviation = config.noise + config.noise_per_meter * away[:, None]
        rows[:, [X, Y]] += deviation * errors[:, :2]
        rows[:, [VX, VY]] += config.velocity_noise * errors[:, 2:]
        false = self._Imagine(context, bodies, before, seed, number)
        return np.append(only_seen(rows, seen), false)

    def _Imagine(
        self,
        context: Context,
        bodies: Array,
        before: Array,
        seed: int,
        number: int,
    ) -> Array:
        """Returns the rows of false detections, from those `before`.

        Those behind the `bodies` of people may end.
        """
        if not len(before):
            return np.zeros(0)
        ids = [(self._number << 20) + i for i in range(len(before))]
        purpose = Purpose.FALSE_DETECTION
        draws = draw_uniform(seed, ids, purpose, 4, step=number)
        stay = ~is_outside(before) & (draws[:, 0] < self._lasting)
        for i, row in enumerate(before):
            stay[i] &= self._Look(context, np.append(bodies, row))[-1]
        # (The first row's draw has the number of those that begin.)
        begun = int(np.searchsorted(self._at_most, draws[0, 1], side="right"))
        rows = before.copy()
        for i in np.flatnonzero(~stay)[:begun]:
            rows[i] = self._Place(context, *draws[i, 2:].tolist())
            stay[i] = True
        purpose = Purpose.FALSE_VELOCITY
        speeds = draw_normal(seed, ids, purpose, 2, step=number)
        rows[:, [VX, VY]] = self._config.velocity_noise * speeds
        return only_seen(rows, stay).ravel()

    def _Place(self, context: Context, turn: float, share: float) -> Array:
        """Returns the row of a false detection at a place drawn in view."""
        config = self._config
        x, y, yaw = self._Pose(context)
        angle = yaw + config.field_of_view * (turn - 0.5)
        (most,) = ray_distances(
            *(x, y, angle),
            np.array([0.0, 1.0]),
            *(1, config.range_max, _NOBODY, self._walls),
        )
        most = min(most, config.range_max)
        least = FALSE_RADIUS
        if config.mount == "robot":
            least += self._robot_state.Eval(context)[RADIUS]
            least += math.hypot(*config.pose[:2])
        least = min(least, most)
        away = math.sqrt(least**2 + share * (most**2 - least**2))
        row = np.zeros(STATE_SIZE)
        row[[X, Y]] = x + away * math.cos(angle), y + away * math.sin(angle)
        row[[YAW, RADIUS]] = angle + math.pi, FALSE_RADIUS
        return row
