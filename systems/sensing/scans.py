"""What a scan tells: points."""

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.sensing.sensor_parameters import LidarParameters, Mount


def sensor_pose(
    config: Mount, robot_state: ArrayLike | None = None
) -> tuple[float, float, float]:
    """Returns where a sensor is and where it looks: (x, y, yaw) in W.

    Args:
        config: The sensor.
        robot_state: The row of the robot that carries it; it may be left out
            for a sensor on the ground.

    Returns:
        In meters and radians.

    Raises:
        ValueError: If the row of the robot is missing.
    """
    x, y, yaw = config.pose
    if config.mount == "world":
        return x, y, yaw
    if robot_state is None:
        raise ValueError(
            "the sensor is mounted on the robot: give robot_state, too"
        )
    robot = np.asarray(robot_state, dtype=float)
    c, s = float(np.cos(robot[YAW])), float(np.sin(robot[YAW]))
    return (
        float(robot[X]) + c * x - s * y,
        float(robot[Y]) + s * x + c * y,
        float(robot[YAW]) + yaw,
    )


def scan_points(
    config: LidarParameters,
    scan: ArrayLike,
    robot_state: ArrayLike | None = None,
) -> Array:
    """Returns the points that a scan met.

    Args:
        config: The lidar.
        scan: Its distances, shape (num_rays,), in meters.
        robot_state: The row of the robot that carries it, as it was when the
            scan was made; it may be left out for a lidar on the ground.

    Returns:
        Shape (k, 2), in W, in meters, in the order of the rays. A ray without
        a return, at `range_max`, gives none.

    Raises:
        ValueError: If the scan is of another lidar, or the row is missing.
    """
    distances = np.asarray(scan, dtype=float)
    if distances.shape != (config.num_rays,):
        raise ValueError(
            f"scan must have shape ({config.num_rays},), one distance for each"
            f" ray of the lidar, got {distances.shape}"
        )
    x, y, yaw = sensor_pose(config, robot_state)
    met = distances < config.range_max
    angles = yaw + config.angles()[met]
    points: Array = np.column_stack([np.cos(angles), np.sin(angles)])
    return distances[met, None] * points + [x, y]
