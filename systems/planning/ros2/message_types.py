"""The types of ROS 2's messages, and messages with defaults.

Types are known by names such as "nav_msgs/msg/Odometry". Those of ROS 2 itself
are those of its distribution humble, and equal in jazzy; others are defined
here by their fields.
"""

from functools import cache
import struct
from typing import Any

import numpy as np

# Fields of messages that do not belong to ROS 2 itself.
DEFINITIONS = {
    # HuNavSim 1 (robotics-upo/hunav_sim).
    "hunav_msgs/msg/Agent": """
        uint8 PERSON=1
        uint8 ROBOT=2
        uint8 OTHER=3
        int32 id
        uint8 type
        uint8 skin
        uint8 behavior
        string name
        uint8 behavior_state
        int8 group_id
        geometry_msgs/Pose position
        float32 yaw
        geometry_msgs/Twist velocity
        float32 desired_velocity
        float32 radius
        float32 linear_vel
        float32 angular_vel
        geometry_msgs/Pose[] goals
        bool cyclic_goals
        float32 goal_radius
        geometry_msgs/Point[] closest_obs
        """,
    "hunav_msgs/msg/Agents": """
        std_msgs/Header header
        hunav_msgs/Agent[] agents
        """,
    # wg-perception/people.
    "people_msgs/msg/Person": """
        string name
        geometry_msgs/Point position
        geometry_msgs/Point velocity
        float64 reliability
        string[] tagnames
        string[] tags
        """,
    "people_msgs/msg/People": """
        std_msgs/Header header
        people_msgs/Person[] people
        """,
    # spencer-project/spencer_people_tracking.
    "spencer_tracking_msgs/msg/TrackedPerson": """
        uint64 track_id
        bool is_occluded
        bool is_matched
        uint64 detection_id
        builtin_interfaces/Duration age
        geometry_msgs/PoseWithCovariance pose
        geometry_msgs/TwistWithCovariance twist
        """,
    "spencer_tracking_msgs/msg/TrackedPersons": """
        std_msgs/Header header
        spencer_tracking_msgs/TrackedPerson[] tracks
        """,
}


@cache
def type_store() -> Any:
    """Returns the store of all types, of rosbags.

    Raises:
        ImportError: If rosbags is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise ImportError(
            "messages of ROS 2 need rosbags: pip install 'hunav_drake[ros]'"
        ) from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    types: dict[str, Any] = {}
    for name, fields in DEFINITIONS.items():
        lines = [line.strip() for line in fields.strip().splitlines()]
        types |= get_types_from_msg("\n".join(lines), name)
    store.register(types)
    return store


def message(type_name: str, **fields: Any) -> Any:
    """Returns a message; fields that are not given are zero or empty."""
    return type_store().types[type_name](**{**_defaults(type_name), **fields})


@cache
def _defaults(type_name: str) -> dict[str, Any]:
    """Returns the fields of an empty message, which are never changed."""
    _, fields = type_store().fielddefs[type_name]
    return {name: _default(kind) for name, kind in fields}


def _default(kind: Any) -> Any:
    from rosbags.interfaces import Nodetype

    node, detail = kind
    if node == Nodetype.NAME:
        return message(detail)
    if node == Nodetype.BASE:
        return {"string": "", "bool": False}.get(
            detail[0], 0.0 if detail[0].startswith("float") else 0
        )
    (element, inner), count = detail
    if element == Nodetype.BASE and inner[0] != "string":
        return np.zeros(count, "?" if inner[0] == "bool" else inner[0])
    return [_default((element, inner)) for _ in range(count)]


def text_of(type_name: str) -> str:
    """Returns the fields of a type and of those in it, as ROS 2 writes them."""
    text: str = type_store().generate_msgdef(type_name, ros_version=2)[0]
    return text


def to_cdr(sent: Any) -> bytes:
    """Returns a message in ROS 2's encoding."""
    return bytes(type_store().serialize_cdr(sent, sent.__msgtype__))


def from_cdr(data: bytes, type_name: str) -> Any:
    """Returns the message that `to_cdr` encoded.

    Raises:
        ValueError: If the bytes are not such a message.
    """
    from rosbags.serde import SerdeError

    damaged = (SerdeError, struct.error, ValueError, IndexError, TypeError)
    try:
        return type_store().deserialize_cdr(data, type_name)
    except damaged as error:
        raise ValueError(f"is no {type_name}: {error}") from error
