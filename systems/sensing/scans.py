"""Points from scans."""

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.sensing.sensor_parameters import LidarParameters, Mount


def sensor_pose(
    config: Mount, robot_state: ArrayLike | None = None
) -> tuple[float, float, float]:
    """Returns the pose (x, y, yaw) of a sensor in W, in meters and radians.

    `robot_state` is the row of the robot that carries it; not needed for a
    sensor on the ground.

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
    """Returns the points of a scan's hits.

    Args:
        config: The lidar.
        scan: Its distances, shape (num_rays,), in meters.
        robot_state: The row of the robot that carries it, at the time of the
            scan; not needed for a lidar on the ground.

    Returns:
        Shape (k, 2), in W, in meters, in the order of the rays. A ray without a
        hit, at `range_max`, gives no point.

    Raises:
        ValueError: If the scan has another size, or the row is missing.
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
