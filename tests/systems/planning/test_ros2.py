"""ROS 2's messages, and DDS, without ROS."""

import gc
import importlib.util
import math
import time

from hypothesis import example, given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.layout import OUTSIDE
from hunav_drake.systems.planning import BridgePlanner
from hunav_drake.systems.planning.ros2 import (
    DdsNode,
    message,
    messages as m,
    type_store,
)
from hunav_drake.systems.planning.ros2.dds import default_domain
from hunav_drake.systems.planning.ros2.message_types import (
    DEFINITIONS,
    from_cdr,
    to_cdr,
)
from hunav_drake.systems.sensing import LidarConfig
from hunav_drake.systems.world.maps.costs import Costmap

needs_dds = pytest.mark.skipif(
    importlib.util.find_spec("cyclonedds") is None,
    reason="no cyclonedds: it has no wheel for Python 3.14",
)

angles = st.floats(-math.pi, math.pi).filter(lambda x: x == 0 or abs(x) > 1e-9)
numbers = st.floats(-1e5, 1e5)
rows = st.tuples(
    *(numbers, numbers, angles, numbers, numbers, numbers), st.floats(0.05, 5.0)
)


@given(angles)
@example(0.12498381590210071)
@example(-0.12497032063328346)
def test_a_quaternion_gives_its_angle_bit_for_bit(yaw):
    turn = m.quaternion(yaw)
    assert m.yaw_of(turn) == yaw
    assert turn.z**2 + turn.w**2 == pytest.approx(1.0, abs=1e-15)


def test_the_heading_of_a_tilted_quaternion_is_that_of_its_x_axis():
    # A turn by 0.3 about z, then by 0.2 about the new x.
    c, s = math.cos(0.1), math.sin(0.1)
    tilted = message(
        "geometry_msgs/msg/Quaternion",
        x=s * math.cos(0.15),
        y=s * math.sin(0.15),
        z=c * math.sin(0.15),
        w=c * math.cos(0.15),
    )
    assert m.yaw_of(tilted) == pytest.approx(0.3, abs=1e-12)


@given(rows, st.lists(rows, max_size=3))
def test_an_observation_is_exact(robot, people):
    humans = np.array([*people, (OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0)])
    sent = m.observation(1.25, np.array(robot), humans)
    data = to_cdr(sent)
    told = from_cdr(data, "hunav_msgs/msg/Agents")
    assert m.nanoseconds(told.header.stamp) == 1_250_000_000
    assert [it.id for it in told.agents] == [*range(len(people) + 1)]
    assert told.agents[0].type == m.ROBOT
    assert [m.row_of(it) for it in told.agents] == [
        list(it) for it in (robot, *people)
    ]


def test_radii_of_an_agent_are_decimal_numbers():
    row = (1.0, 2.0, 0.5, 0.1, 0.2, 0.3, 0.35)
    told = from_cdr(to_cdr(m.agent(row)), "hunav_msgs/msg/Agent")
    assert m.row_of(told) == list(row)


@pytest.mark.parametrize("name", sorted(DEFINITIONS))
def test_empty_messages_go_through_bytes(name):
    sent = message(name)
    assert to_cdr(from_cdr(to_cdr(sent), name)) == to_cdr(sent)
    assert name in type_store().types


def test_damaged_bytes_are_told():
    data = to_cdr(m.agent([0.0] * 7, name="ana"))
    with pytest.raises(ValueError, match="is no hunav_msgs/msg/Agent"):
        from_cdr(data[:40], "hunav_msgs/msg/Agent")


def test_odometry_has_the_velocity_in_the_frame_of_the_robot():
    row = np.array([1.0, 2.0, math.pi / 2, 0.0, 0.7, 0.1, 0.3])
    speed = m.odometry(0.5, row).twist.twist
    assert speed.linear.x == pytest.approx(0.7)
    assert speed.linear.y == pytest.approx(0.0, abs=1e-15)
    assert speed.angular.z == 0.1


def test_a_scan_has_the_angles_of_its_lidar():
    lidar = LidarConfig(num_rays=5, field_of_view=math.pi)
    told = m.laser_scan(0.0, "laser", lidar, np.arange(5.0))
    assert told.angle_min + 4 * told.angle_increment == pytest.approx(
        told.angle_max
    )
    assert told.ranges.tolist() == [0, 1, 2, 3, 4]


def test_costs_are_those_of_nav2():
    costs = np.array([[0, 1, 252], [253, 254, 255]], dtype=np.uint8)
    told = m.grid(2.0, Costmap(costs, (-1.0, 3.0), 0.5))
    # nav2_costmap_2d's table: 0, 1 to 98, 99 inscribed, 100 lethal, -1.
    assert told.data.tolist() == [0, 1, 98, 99, 100, -1]
    assert (told.info.width, told.info.height) == (3, 2)
    assert told.info.origin.position.y == 3.0


def test_a_path_without_headings_looks_along_itself():
    told = m.path(0.0, np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]))
    yaws = [m.yaw_of(it.pose.orientation) for it in told.poses]
    assert yaws == pytest.approx([0.0, math.pi / 2, math.pi / 2])
    assert m.path(0.0, np.zeros((0, 2))).poses == []
    assert len(m.path(0.0, np.array([[3.0, 4.0]])).poses) == 1


@pytest.mark.parametrize("text", ["-1", "233", "ten", "1.5"])
def test_a_wrong_domain_is_told(monkeypatch, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(ValueError, match="ROS_DOMAIN_ID must be a whole"):
        default_domain()


def wait(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end
        time.sleep(0.01)
    return found


@needs_dds
def test_nodes_tell_each_other():
    one, two = DdsNode(97), DdsNode(97)
    kind = "geometry_msgs/msg/TwistStamped"
    reader = two.subscribe("/cmd_vel", kind)
    late = "nav_msgs/msg/OccupancyGrid"
    one.publish("/map", message(late), latched=True)
    one.advertise("/cmd_vel", kind)
    wait(lambda: reader.num_writers and one.num_readers("/cmd_vel"))
    for k in range(100):
        sent = message(kind, twist=m.twist(0.1 * k, 0.0, 1.0))
        one.publish("/cmd_vel", sent)
    found = []
    wait(lambda: found.extend(reader.take()) or len(found) == 100)
    told = [it.twist.linear.x for it in found]
    assert told == [0.1 * k for k in range(100)]
    # Who comes late still gets the map.
    maps = two.subscribe("/map", late, latched=True)
    (got,) = wait(maps.take)
    assert to_cdr(got) == to_cdr(message(late))
    # What a node publishes, it does not read.
    own = one.subscribe("/cmd_vel", kind)
    one.publish("/cmd_vel", message(kind))
    wait(reader.take)
    assert own.take() == []


@needs_dds
def test_names_are_those_of_ros():
    from cyclonedds.builtin import (
        BuiltinDataReader,
        BuiltinTopicDcpsPublication,
    )
    from cyclonedds.domain import DomainParticipant

    node = DdsNode(98)
    node.publish("/a/b", message("hunav_msgs/msg/Agents"))
    other = DomainParticipant(98)
    reader = BuiltinDataReader(other, BuiltinTopicDcpsPublication)

    def find():
        found = {it.topic_name: it.type_name for it in reader.take(100)}
        return found.get("rt/a/b")

    assert wait(find) == "hunav_msgs::msg::dds_::Agents_"


@needs_dds
def test_types_are_those_of_who_publishes_now():
    node, other = DdsNode(97), DdsNode(97)
    kind = "geometry_msgs/msg/Twist"
    other.advertise("/a", kind)
    assert wait(lambda: node.published_types("/a")) == [kind]
    assert node.published_types("/a", beyond=True) == []
    del other
    gc.collect()
    assert wait(lambda: not node.published_types("/a"))


def test_what_is_missing_is_found_before_a_run(monkeypatch):
    def faults(planner):
        return list(planner.find_faults(None, None, None))

    assert faults(BridgePlanner()) == []
    ((place, text),) = faults(BridgePlanner(network="nope"))
    assert place == ("network",)
    assert "there is no network interface 'nope'; valid: lo" in text
    monkeypatch.setenv("ROS_DOMAIN_ID", "x")
    ((place, _),) = faults(BridgePlanner())
    assert place == ("domain",)
    assert faults(BridgePlanner(domain=3)) == []
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    ((place, text),) = faults(BridgePlanner())
    assert place == ()
    assert "pip install 'hunav_drake[ros]'" in text
