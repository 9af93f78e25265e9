"""Messages from rows of states, and back.

Rows are those of `layout.STATE_FIELDS`, in W. Angles are turned into
quaternions from which `yaw_of` gives the same angle, bit for bit.
"""

from collections.abc import Iterable, Sequence
import math
import re
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    OMEGA,
    RADIUS,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.planning.ros2.message_types import message
from hunav_drake.systems.sensing.sensor_parameters import LidarParameters
from hunav_drake.systems.world.maps.costs import Costmap

# Numbers of `hunav_msgs/msg/Agent`.
PERSON, ROBOT = 1, 2

_SECOND = 10**9

# Angles up to a turn are the same in single precision, in radians.
_SINGLE = 1e-5


def ros_name(name: str) -> str:
    """Returns a name with what topics must not have as underscores."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", name)
    if plain[:1].isdigit() or plain[:1] == "_":
        # (Nor may they have two underscores side by side.)
        return "r_" + plain.lstrip("_")
    return plain


def stamp(time: float) -> Any:
    """Returns a time, in seconds, as a message of whole nanoseconds."""
    seconds, nanoseconds = divmod(round(time * _SECOND), _SECOND)
    kind = "builtin_interfaces/msg/Time"
    return message(kind, sec=seconds, nanosec=nanoseconds)


def nanoseconds(told: Any) -> int:
    """Returns the whole nanoseconds of a time stamp."""
    return int(told.sec) * _SECOND + int(told.nanosec)


def header(time: float, frame: str) -> Any:
    """Returns the header of a message about a frame."""
    return message("std_msgs/msg/Header", stamp=stamp(time), frame_id=frame)


def vector(x: float, y: float, z: float = 0.0, kind: str = "Vector3") -> Any:
    """Returns a Vector3, a Point or another type with these fields."""
    values = {"x": float(x), "y": float(y), "z": float(z)}
    return message(f"geometry_msgs/msg/{kind}", **values)


def twist(vx: float, vy: float, omega: float) -> Any:
    """Returns a velocity, in m/s and rad/s."""
    return message(
        "geometry_msgs/msg/Twist",
        linear=vector(vx, vy),
        angular=vector(0.0, 0.0, omega),
    )


def quaternion(yaw: float) -> Any:
    """Returns a turn about the z axis by an angle, in [-2 pi, 2 pi].

    `yaw_of` gives exactly this angle.
    """
    z, w = math.sin(yaw / 2), math.cos(yaw / 2)
    kind = "geometry_msgs/msg/Quaternion"
    turn = message(kind, z=z, w=w)
    if yaw_of(turn) == yaw:
        return turn
    # Where the rounded sine and cosine do not give it, one of their neighbors
    # does; near 1/8, where half angles have gaps, with the least tilt.
    for x in (0.0, math.ulp(0.0)):
        for near_z in (z, math.nextafter(z, 2), math.nextafter(z, -2)):
            for near_w in (w, math.nextafter(w, 2), math.nextafter(w, -2)):
                near = message(kind, x=x, z=near_z, w=near_w)
                if yaw_of(near) == yaw:
                    return near
    return turn


def yaw_of(turn: Any) -> float:
    """Returns the heading of a quaternion, in [-2 pi, 2 pi]."""
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    if x == y == 0.0:
        return 2 * math.atan2(z, w)
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def pose(x: float, y: float, yaw: float, z: float = 0.0) -> Any:
    """Returns a pose from meters and radians."""
    return message(
        "geometry_msgs/msg/Pose",
        position=vector(x, y, z, "Point"),
        orientation=quaternion(yaw),
    )


def pose_stamped(time: float, frame: str, at: Sequence[float]) -> Any:
    """Returns a PoseStamped of a pose (x, y, yaw)."""
    kind = "geometry_msgs/msg/PoseStamped"
    return message(kind, header=header(time, frame), pose=pose(*at))


def agent(row: ArrayLike, **fields: Any) -> Any:
    """Returns HuNavSim's message of a person or robot from its row.

    `fields` are further ones, such as `id`, `type` and `name`.
    """
    x, y, yaw, vx, vy, omega, radius = np.asarray(row, float).tolist()
    return message(
        "hunav_msgs/msg/Agent",
        **{"type": PERSON, "group_id": -1, **fields},
        position=pose(x, y, yaw),
        yaw=yaw,
        velocity=twist(vx, vy, omega),
        radius=radius,
        linear_vel=math.hypot(vx, vy),
        angular_vel=omega,
    )


def row_of(told: Any) -> list[float]:
    """Returns the row of an `agent`.

    All but the radius is exact: that is the shortest decimal number that is
    the same in single precision, unless it is exact in an `observation`. The
    heading is `yaw`, as in HuNavSim, whose wrappers turn the orientation, or
    leave it out; where both are the same, it is that of the latter.
    """
    at, speed = told.position, told.velocity
    yaw = yaw_of(at.orientation)
    if math.isfinite(told.yaw) and (
        abs(math.remainder(told.yaw - yaw, 2 * math.pi)) > _SINGLE
    ):
        yaw = float(told.yaw)
    radius = at.position.z
    if np.float32(radius) != np.float32(told.radius):
        radius = float(str(np.float32(told.radius)))
    return [
        *(at.position.x, at.position.y, yaw),
        *(speed.linear.x, speed.linear.y, speed.angular.z, radius),
    ]


def agents(time: float, told: Iterable[Any], frame: str = "map") -> Any:
    """Returns HuNavSim's message of several people or robots."""
    kind = "hunav_msgs/msg/Agents"
    return message(kind, header=header(time, frame), agents=list(told))


def observation(time: float, robot: Array, humans: Array) -> Any:
    """Returns what a planner observes: the robot, then people who are there.

    Their ids are 0 and the numbers of their rows, from 1. In `position.z` is
    the radius, which `radius` has in single precision only.
    """
    told = [agent(robot, type=ROBOT)]
    told += [
        agent(row, id=i + 1)
        for i, row in enumerate(humans.reshape(-1, STATE_SIZE))
        if not is_outside(row)
    ]
    rows = [robot, *humans[[it.id - 1 for it in told[1:]]]]
    for it, row in zip(told, rows, strict=True):
        it.position.position.z = float(row[RADIUS])
    return agents(time, told)


def odometry(
    time: float, row: Array, frame: str = "odom", base: str = ""
) -> Any:
    """Returns the odometry of a robot; its velocity is in its own frame."""
    c, s = math.cos(row[YAW]), math.sin(row[YAW])
    along = c * row[VX] + s * row[VY]
    aside = -s * row[VX] + c * row[VY]
    return message(
        "nav_msgs/msg/Odometry",
        header=header(time, frame),
        child_frame_id=base,
        pose=message(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=pose(row[X], row[Y], row[YAW]),
        ),
        twist=message(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=twist(along, aside, row[OMEGA]),
        ),
    )


def transform(
    time: float, parent: str, child: str, at: Sequence[float] = (0, 0, 0, 0)
) -> Any:
    """Returns the pose (x, y, yaw[, z]) of a child frame in its parent."""
    x, y, yaw, *z = at
    return message(
        "geometry_msgs/msg/TransformStamped",
        header=header(time, parent),
        child_frame_id=child,
        transform=message(
            "geometry_msgs/msg/Transform",
            translation=vector(x, y, sum(z)),
            rotation=quaternion(yaw),
        ),
    )


def transforms(*told: Any) -> Any:
    """Returns the message of several transforms."""
    return message("tf2_msgs/msg/TFMessage", transforms=list(told))


def scan_time(time: float, lidar: LidarParameters) -> float:
    """Returns when the scan was taken that a lidar gives at a time."""
    since = time - float(getattr(lidar, "delay", 0.0))
    return max(0.0, math.floor(since / lidar.period + 1e-6) * lidar.period)


def laser_scan(
    time: float, frame: str, lidar: LidarParameters, distances: Array
) -> Any:
    """Returns the scan that a lidar gives at a time, stamped with its own.

    A ray without a hit has the maximum range.
    """
    angles = lidar.angles()
    step = float(angles[1] - angles[0]) if len(angles) > 1 else 0.0
    return message(
        "sensor_msgs/msg/LaserScan",
        header=header(scan_time(time, lidar), frame),
        angle_min=float(angles[0]),
        angle_max=float(angles[-1]),
        angle_increment=step,
        scan_time=lidar.period,
        range_min=lidar.range_min,
        range_max=lidar.range_max,
        ranges=np.asarray(distances, np.float32),
    )


def path(time: float, points: Array, frame: str = "map") -> Any:
    """Returns a planned path from rows (x, y) or (x, y, yaw).

    Without headings, each pose looks at the next one.
    """
    if points.shape[1] == 2 and len(points):
        steps = np.diff(points, axis=0, append=points[-1:])
        if len(points) > 1:
            steps[-1] = steps[-2]
        yaws = np.arctan2(steps[:, 1], steps[:, 0])
        points = np.column_stack([points, yaws])
    return message(
        "nav_msgs/msg/Path",
        header=header(time, frame),
        poses=[pose_stamped(time, frame, row) for row in points.tolist()],
    )


def grid(time: float, costs: Costmap, frame: str = "map") -> Any:
    """Returns a costmap as a map, with ROS 2's values from 0 to 100, and -1."""
    table = np.empty(256, np.int8)
    # As Nav2's Costmap2DPublisher does.
    table[:253] = 1 + 97 * (np.arange(253) - 1) // 251
    table[[0, 253, 254, 255]] = 0, 99, 100, -1
    rows, columns = costs.costs.shape
    return message(
        "nav_msgs/msg/OccupancyGrid",
        header=header(time, frame),
        info=message(
            "nav_msgs/msg/MapMetaData",
            map_load_time=stamp(0.0),
            resolution=costs.resolution,
            width=columns,
            height=rows,
            origin=pose(*costs.origin, 0.0),
        ),
        data=table[costs.costs].ravel(),
    )


def clock(time: float) -> Any:
    """Returns the time of a trial."""
    return message("rosgraph_msgs/msg/Clock", clock=stamp(time))


def command(told: Any) -> tuple[float, float]:
    """Returns (v, omega) of a Twist or a TwistStamped."""
    told = getattr(told, "twist", told)
    return float(told.linear.x), float(told.angular.z)
