"""The speeds of robot and people, and the smoothness of the robot's speed."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.features import mean_of_present
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.goal import SEAN
from hunav_drake.systems.evaluation.metrics.path import since_previous
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="speeds")

SOCNAVBENCH = "SocNavBench, Biswas et al. 2022"
KATYAL = "Katyal et al. 2022"

# A robot below both is not moving, in m/s and rad/s.
STILL_SPEED = 0.01
STILL_TURN_RATE = 0.02


@_metric(unit="s", direction="lower", source=SEAN, reduce=reduce.total)
def time_not_moving(recording: Recording) -> Array:
    """The total time of the intervals in which the robot did not move.

    These are intervals with |v| < 0.01 m/s and |omega| < 0.02 rad/s at both
    ends. Series: the time not moving since the previous sample.
    """
    features = recording.features
    still = (np.abs(features.forward_speed) < STILL_SPEED) & (
        features.turn_rate < STILL_TURN_RATE
    )
    return since_previous(
        np.where(still[1:] & still[:-1], features.intervals, 0.0)
    )


@_metric(unit="m/s", direction="higher", source=SOCNAVBENCH, reduce=reduce.mean)
def avg_robot_linear_speed(recording: Recording) -> Array:
    """The mean over the samples of the robot's forward speed v.

    Backward speeds are negative. Series: the speed.
    """
    return recording.features.forward_speed


@_metric(
    unit="rad/s", direction="lower", source=SOCNAVBENCH, reduce=reduce.mean
)
def avg_robot_angular_speed(recording: Recording) -> Array:
    """The mean over the samples of the robot's turn rate |omega|.

    Series: the turn rate |omega|, unsigned.
    """
    return recording.features.turn_rate


@_metric(
    unit="m/s^2",
    direction="lower",
    source=SOCNAVBENCH,
    aliases=["avg_acceleration"],
    reduce=reduce.mean,
)
def avg_robot_acceleration(recording: Recording) -> Array:
    """The mean over the intervals of |v_{k+1} - v_k| / (t_{k+1} - t_k).

    Intervals shorter than 1 microsecond, between repeated stamps, do not count.
    NaN for a single sample. Series: the value of the previous interval.
    """
    return since_previous(np.abs(recording.features.acceleration), np.nan)


@_metric(
    unit="m/s^3",
    direction="lower",
    source=SOCNAVBENCH,
    aliases=["avg_overacceleration", "avg_robot_overacceleration"],
    reduce=reduce.mean,
)
def avg_robot_jerk(recording: Recording) -> Array:
    """The mean over successive intervals of |a_{k+1} - a_k| / dt.

    a_k = (v_{k+1} - v_k) / (t_{k+1} - t_k) is signed, and dt is the time
    between the middles of the two intervals. Intervals shorter than 1
    microsecond, between repeated stamps, have none. NaN for fewer than three
    samples. Series: the value of the two previous intervals.
    """
    features = recording.features
    dt = (features.intervals[1:] + features.intervals[:-1]) / 2
    jerk = np.abs(np.diff(features.acceleration)) / dt
    empty = np.full(len(recording) - len(jerk), np.nan)
    return np.concatenate([empty, jerk])


@_metric(
    unit="m/s",
    direction="higher",
    source=KATYAL,
    aliases=["avg_pedestrians_velocity"],
    reduce=reduce.mean,
)
def avg_pedestrian_velocity(recording: Recording) -> Array:
    """The mean over the samples of the mean speed of the people present.

    NaN without people. Series: the mean speed.
    """
    return mean_of_present(recording.features.human_speed)


@_metric(unit="m/s", direction="higher", source=KATYAL, reduce=reduce.mean)
def avg_closest_pedestrian_velocity(recording: Recording) -> Array:
    """The mean over the samples of the closest person's speed.

    The closest person is the one whose center is closest to the robot's; NaN
    without people. Series: that speed.
    """
    return recording.features.closest_human_speed
