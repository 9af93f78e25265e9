"""Commands of a differential drive that follow a velocity in any direction."""

import math

from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.robot.robot_config import RobotLimits

# The fraction of the turn acceleration that planning uses.
_BRAKES = 0.5


def brakable(
    omega: float, error: float, acceleration: float, reaction: float
) -> float:
    """Returns a turn rate that can stop within the remaining angle.

    A rate higher than that would overshoot, turn back, and so on. `error` is
    the remaining angle, in radians, `acceleration` the maximum, in rad/s^2,
    `reaction` the time until another rate takes effect, in seconds.
    """
    most = math.sqrt(2.0 * _BRAKES * acceleration * abs(error))
    most = min(most, abs(error) / reaction)
    return min(max(omega, -most), most)


def steer(
    vx: float,
    vy: float,
    yaw: float,
    turn_time: float,
    limits: RobotLimits,
    reaction: float,
) -> tuple[float, float]:
    """Returns the command (v, omega) that follows a velocity in W.

    It turns to the direction of the velocity in about `turn_time`, and drives
    at the forward component of the velocity. `reaction` is the time until
    another command takes effect. In SI units.
    """
    speed = math.hypot(vx, vy)
    if speed < 1e-6:
        return 0.0, 0.0
    error = wrap_angle(math.atan2(vy, vx) - yaw)
    most = limits.max_turn_rate
    omega = min(max(error / turn_time, -most), most)
    omega = brakable(omega, error, limits.max_turn_acceleration, reaction)
    return speed * max(math.cos(error), 0.0), omega
