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

    A higher one would overshoot, turn back, and so on.

    Args:
        omega: The wanted turn rate, in rad/s.
        error: The remaining angle, in radians.
        acceleration: The maximum angular acceleration, in rad/s^2.
        reaction: The time until another rate takes effect, in seconds.
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
    at the forward component of the velocity.

    Args:
        vx: The x component of the velocity to follow, in m/s.
        vy: Its y component.
        yaw: The heading of the robot, in radians.
        turn_time: In seconds.
        limits: The limits of the robot.
        reaction: The time until another command takes effect, in seconds.
    """
    speed = math.hypot(vx, vy)
    if speed < 1e-6:
        return 0.0, 0.0
    error = wrap_angle(math.atan2(vy, vx) - yaw)
    most = limits.max_turn_rate
    omega = min(max(error / turn_time, -most), most)
    omega = brakable(omega, error, limits.max_turn_acceleration, reaction)
    return speed * max(math.cos(error), 0.0), omega
