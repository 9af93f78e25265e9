"""The localizations: the pose that a planner takes for that of its robot."""

from abc import ABC, abstractmethod
import math
from typing import Annotated, Any

import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.sensing.sensor_config import SensingTask
from hunav_drake.systems.sensing.sensor_parameters import Deviation

Alpha = Annotated[StrictFloat, within(0, 10)]


@explain
@dataclass(kw_only=True, config=CONFIG)
class LocalizationConfig(ABC):
    """Base class of localizations."""

    @abstractmethod
    def MakeSystem(self, task: SensingTask) -> Any | None:
        """Makes the system between robot and planner; None for a direct link.

        It is a LeafSystem or a Diagram with the input ``robot_state`` and the
        output ``estimated_robot_state``, a row of `layout` each, in W. If
        ``task.num_humans`` is not 0, it takes so many rows of perceived people
        from ``people``, in W, and gives them in ``estimated_people`` where they
        are relative to the estimated pose as they are to the robot.
        """


# The localizations by type.
LOCALIZATIONS = Registry("localization", LocalizationConfig, default="exact")

register_localization = LOCALIZATIONS.register


@register_localization("exact")
@dataclass(kw_only=True, config=CONFIG)
class ExactLocalization(LocalizationConfig):
    """The true pose."""

    def MakeSystem(self, task: SensingTask) -> None:
        """Makes nothing."""


class ErrorModel(LocalizationConfig, ABC):
    """Base class of localizations with an error that is drawn every step.

    An error (x, y, yaw) is the estimated pose less the true one, in W, in
    meters and radians.
    """

    @abstractmethod
    def next_error(
        self,
        error: Array | None,
        motion: tuple[Array, Array],
        time_step: float,
        normal: Array,
    ) -> Array:
        """Returns the error after a step, shape (3,).

        `error` is the last one, None at the start; `motion` are the true poses
        (x, y, yaw) at both ends of the step, in W; `time_step` is in seconds;
        `normal` are three independent standard normal numbers.
        """

    def MakeSystem(self, task: SensingTask) -> Any:
        """Makes a `Localization`."""
        from hunav_drake.systems.sensing.localization import Localization

        return Localization(
            self,
            num_people=task.num_humans,
            time_step=task.time_step,
            seed=task.seed,
            number=task.number,
        )


@register_localization("odometry")
@dataclass(kw_only=True, config=CONFIG)
class Odometry(ErrorModel):
    """Odometry alone, whose error grows with the motion, without bound.

    The odometry motion model of Thrun, Burgard and Fox, "Probabilistic
    Robotics" (2005), table 5.6: a motion is a turn, a translation and another
    turn, each with a normally distributed error. The variances of the table are
    for motions of one second; a shorter step has a share of them, so that they
    add up to the same for any time step. Each turn is half of the change of
    heading, as it is on an arc.
    """

    alpha1: Alpha = 0.002
    """Variance of a turn, per rad^2 of the turn."""

    alpha2: Alpha = 0.0005
    """Variance of a turn, in rad^2, per m^2 of translation."""

    alpha3: Alpha = 0.002
    """Variance of the translation, per m^2 of translation."""

    alpha4: Alpha = 0.0005
    """Variance of the translation, in m^2, per rad^2 of both turns."""

    def next_error(
        self,
        error: Array | None,
        motion: tuple[Array, Array],
        time_step: float,
        normal: Array,
    ) -> Array:
        """Returns the error after a motion, 0 at the start."""
        if error is None:
            return np.zeros(3)
        before, now = motion
        dx, dy, turned = (now - before).tolist()
        half = 0.5 * math.remainder(turned, 2 * math.pi)
        moved = math.hypot(dx, dy)
        of_turn = self.alpha1 * half**2 + self.alpha2 * moved**2
        of_way = self.alpha3 * moved**2 + 2 * self.alpha4 * half**2
        # (Variances are proportional to the time, not to its square.)
        turn_1, turn_2 = np.sqrt(of_turn / time_step) * normal[:2]
        way = math.sqrt(of_way / time_step) * normal[2]
        # The direction of the translation; without one, straight ahead.
        ahead = math.atan2(dy, dx) if moved else before[YAW] + half
        along_x = dx + way * math.cos(ahead)
        along_y = dy + way * math.sin(ahead)
        angle = error[YAW] + turn_1
        c, s = math.cos(angle), math.sin(angle)
        return np.array(
            [
                error[X] + (c * along_x - s * along_y - dx),
                error[Y] + (s * along_x + c * along_y - dy),
                angle + turn_2,
            ]
        )


@register_localization("gauss_markov")
@dataclass(kw_only=True, config=CONFIG)
class GaussMarkov(ErrorModel):
    """A localizer in a map, as AMCL, with a correlated error that stays small.

    x, y and yaw have independent errors: each a stationary Gauss-Markov process
    of first order (Ornstein-Uhlenbeck), with the autocorrelation exp(-t /
    correlation_time), discretized exactly.
    """

    position_deviation: Deviation = 0.05
    """Standard deviation of x and of y, in meters."""

    yaw_deviation: Annotated[StrictFloat, within(0, math.pi, "rad")] = 0.03
    """Standard deviation of the heading, in radians."""

    correlation_time: Annotated[
        StrictFloat, within(0, 1e4, "s", low_open=True)
    ] = 5.0
    """Time in which the autocorrelation of the error falls to 1/e, in
    seconds."""

    def next_error(
        self,
        error: Array | None,
        motion: tuple[Array, Array],
        time_step: float,
        normal: Array,
    ) -> Array:
        """Returns the error after some time; also at the start a random one."""
        position, yaw = self.position_deviation, self.yaw_deviation
        new = np.array([position, position, yaw]) * normal
        if error is None:
            return new
        ratio = time_step / self.correlation_time
        return (
            math.exp(-ratio) * error + math.sqrt(-math.expm1(-2 * ratio)) * new
        )
