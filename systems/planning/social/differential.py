"""How a robot with two wheels follows a velocity in any direction."""

import math

from hunav_drake.systems.common.poses import wrap_angle


def steer(
    vx: float, vy: float, yaw: float, turn_time: float, most: float
) -> tuple[float, float]:
    """Returns the command (v, omega) that follows a velocity in W.

    It turns into the direction of the velocity in about `turn_time`, and
    drives as fast as the part of the velocity that lies ahead.

    Args:
        vx: The velocity to follow, in m/s.
        vy: The same along the other axis.
        yaw: The heading of the robot, in radians.
        turn_time: In seconds.
        most: The largest turn rate, in rad/s.
    """
    speed = math.hypot(vx, vy)
    if speed < 1e-6:
        return 0.0, 0.0
    error = wrap_angle(math.atan2(vy, vx) - yaw)
    omega = min(max(error / turn_time, -most), most)
    return speed * max(math.cos(error), 0.0), omega
