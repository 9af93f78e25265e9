"""The topics of a trial, as ROS 2's messages.

Frames are map, odom and base_link; people are in map. Of several robots, each
has its name before its topics and frames, as in `/anna/odom`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import Context

from hunav_drake.hunavsim.agents_keys import BEHAVIOR_NAMES
from hunav_drake.scenario.checks import scans_of
from hunav_drake.scenario.fleet import RobotPart, robot_parts
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, is_outside
from hunav_drake.systems.evaluation.recording import Recording, describe_people
from hunav_drake.systems.planning.costmap.static_layer import (
    costmap_from_obstacles,
)
from hunav_drake.systems.planning.navigation.regions import bounds_of
from hunav_drake.systems.planning.ros2 import messages as m
from hunav_drake.systems.planning.ros2.message_types import message
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.blocks import with_planner_lidar
from hunav_drake.trial.diagram import TrialDiagram

# A topic and a message on it.
Told = tuple[str, Any]

# Topics whose last message those who come later get, too.
LATCHED = ("/map", "/tf_static")

# Topics of bags: the tolerances of a goal, in meters and radians, and when one
# of several robots ended.
TOLERANCE, END = "/goal_tolerance", "/trial_end"

# Frames that lidars with these names do not take.
_FRAMES = ("map", "odom", "base_link", "laser")

# The time between two messages of large topics, in seconds, as Nav2's.
_PERIODS = {"markers": 0.1, "local_costmap": 0.2, "global_costmap": 1.0}

# The free space around walls on the map, and the side of its cells, in meters.
_MARGIN, _CELL = 1.0, 0.05

_NUMBERS = {name: number for number, name in BEHAVIOR_NAMES.items()}
_ADULT = 1.7


class People(NamedTuple):
    """What does not change about n people.

    Attributes:
        names: Their names.
        ids: Their numbers.
        behaviors: The names of their behaviors.
        group_ids: The numbers of their groups; -1 for nobody's.
        speeds: Their desired speeds, in m/s.
        heights: Their heights, in meters.
    """

    names: Sequence[str]
    ids: Sequence[int]
    behaviors: Sequence[str]
    group_ids: Sequence[int]
    speeds: Sequence[float]
    heights: Sequence[float]


def check_numbers(people: People) -> None:
    """Checks that numbers of people fit into HuNavSim's messages.

    Raises:
        ValueError: If one does not.
    """
    for what, numbers, bits in (
        ("id", people.ids, 31),
        ("group_id", people.group_ids, 7),
    ):
        for name, number in zip(people.names, numbers, strict=True):
            if not -(2**bits) <= number < 2**bits:
                raise ValueError(
                    f"{what} of {name!r} must be below {2**bits} in messages of"
                    f" ROS 2, got {number}; number them anew"
                )


def check_robots(names: Sequence[str]) -> None:
    """Checks that robots differ in the names of their topics.

    Raises:
        ValueError: If two do not.
    """
    _check_differ("robots", names, [m.ros_name(it) for it in names])


def _check_differ(
    what: str, names: Sequence[str], topics: Sequence[str]
) -> None:
    for i, topic in enumerate(topics):
        if topic in topics[:i]:
            other = names[topics.index(topic)]
            raise ValueError(
                f"the {what} {other!r} and {names[i]!r} would both be"
                f" {topic!r} in topics; rename one"
            )


def people_of(recording: Recording) -> People:
    """Returns the people of a recording, whose speeds are unknown."""
    n = recording.num_humans
    return People(
        *(recording.human_names, recording.human_ids),
        *(recording.behaviors, recording.group_ids),
        *([0.0] * n, [_ADULT] * n),
    )


def people_topics(
    time: float, people: People, humans: Array, status: Array
) -> Iterator[Told]:
    """Yields the messages on people at a time, in seconds.

    Args:
        time: The time.
        people: What does not change about n people.
        humans: Shape (n, 7), the rows of the people; those who are not there
            are outside, or rows of NaN.
        status: Shape (n,), what they do: see `BehaviorTree`.
    """
    here = [
        i
        for i, row in enumerate(humans)
        if row[0] == row[0] and not is_outside(row)
    ]
    told = [
        m.agent(
            humans[i],
            id=int(people.ids[i]),
            name=people.names[i],
            behavior=_NUMBERS.get(people.behaviors[i], 0),
            behavior_state=int(status[i]),
            group_id=int(people.group_ids[i]),
            desired_velocity=float(people.speeds[i]),
        )
        for i in here
    ]
    yield "/human_states", m.agents(time, told)
    seen = [
        message(
            "people_msgs/msg/Person",
            name=people.names[i],
            position=it.position.position,
            velocity=m.vector(
                *(it.velocity.linear.x, it.velocity.linear.y), kind="Point"
            ),
            reliability=1.0,
        )
        for i, it in zip(here, told, strict=True)
    ]
    kind = "people_msgs/msg/People"
    yield "/people", message(kind, header=m.header(time, "map"), people=seen)


def robot_topics(
    time: float,
    robots: Mapping[str, Array],
    estimates: Mapping[str, Array] = MappingProxyType({}),
) -> Iterator[Told]:
    """Yields the messages on robots at a time, in seconds.

    Args:
        time: The time.
        robots: The rows of the robots by name; that of a single one is empty.
        estimates: What they take to be their rows, if that differs.
    """
    poses = []
    for name, row in robots.items():
        prefix, frame = frames_of(name)
        known = estimates.get(name, row)
        odom, base = f"{frame}odom", f"{frame}base_link"
        robot = m.agent(row, type=m.ROBOT, name=name or "robot")
        yield f"{prefix}/robot_states", robot
        yield f"{prefix}/odom", m.odometry(time, known, odom, base)
        poses += [
            m.transform(time, "map", odom),
            m.transform(time, odom, base, known[:3].tolist()),
        ]
    yield "/tf", m.transforms(*poses)


def marker_topic(
    time: float, people: People, humans: Array, robots: Mapping[str, Array]
) -> Told:
    """Returns the markers of all people and robots, for RViz."""
    told = [_marker(time, "", 0, [0, 0, 0], [0, 0, 0], _DARK, action=3)]
    for i, row in enumerate(humans):
        if np.isnan(row[0]) or is_outside(row):
            continue
        x, y, yaw, *_ = row.tolist()
        tall, wide = people.heights[i], 2 * float(row[RADIUS])
        shirt = _COLORS[_NUMBERS.get(people.behaviors[i], 0)]
        scale = np.array([wide, wide, tall])
        for part, (form, height, share, color) in _PARTS.items():
            at = (x, y, yaw, height * tall)
            size = (scale * share).tolist()
            told.append(
                _marker(time, part, i, at, size, color or shirt, type=form)
            )
        told.append(_name(time, i, (x, y, 1.1 * tall), people.names[i]))
    for i, (name, row) in enumerate(robots.items()):
        x, y, yaw, *_ = row.tolist()
        side = 2 * float(row[RADIUS])
        arrow = (x, y, yaw, 0.42), (0.5 * side, 0.06, 0.06)
        told += [
            _marker(
                *(time, "robot", i, (x, y, yaw, 0.2), (side, side, 0.4)), _ROBOT
            ),
            _marker(time, "heading", i, *arrow, _DARK, type=ARROW),
            _name(time, -1 - i, (x, y, 0.7), name or "robot"),
        ]
    kind = "visualization_msgs/msg/MarkerArray"
    return "/markers", message(kind, markers=told)


# Types of markers.
ARROW, BALL, CYLINDER, TEXT = 0, 2, 3, 9

# By the numbers of behaviors: red, green, blue.
_COLORS = (
    *((0.55, 0.55, 0.6), (0.2, 0.45, 0.75), (0.5, 0.5, 0.5)),
    *((0.9, 0.6, 0.1), (0.75, 0.75, 0.2), (0.2, 0.65, 0.35)),
    (0.8, 0.2, 0.2),
)
_DARK, _SKIN, _ROBOT = (0.15, 0.17, 0.25), (0.85, 0.68, 0.55), (0.9, 0.9, 0.92)


# The parts of a person: type, height of the middle in that of the person, size
# in width, width and height, and color; None for that of the behavior.
_PARTS: dict[str, tuple[int, float, Array, Sequence[float] | None]] = {
    "legs": (CYLINDER, 0.25, np.array([0.45, 0.5, 0.5]), _DARK),
    "body": (CYLINDER, 0.67, np.array([0.5, 0.85, 0.34]), None),
    "head": (BALL, 0.92, np.array([0.32, 0.27, 0.16]), _SKIN),
}


def _name(
    time: float, number: int, at: tuple[float, float, float], name: str
) -> Any:
    """Returns a name above somebody, at (x, y, z)."""
    place, size = (at[0], at[1], 0.0, at[2]), (0.0, 0.0, 0.25)
    return _marker(
        time, "name", number, place, size, _DARK, type=TEXT, text=name
    )


def _marker(
    time: float,
    kind: str,
    number: int,
    at: Sequence[float],
    size: Sequence[float],
    color: Sequence[float],
    **more: Any,
) -> Any:
    """Returns a marker: a cylinder, unless another `type` is given."""
    red, green, blue = color
    return message(
        "visualization_msgs/msg/Marker",
        header=m.header(time, "map"),
        ns=kind,
        id=number,
        pose=m.pose(*at),
        scale=m.vector(size[0], size[1], size[2]),
        color=message("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
        **{"type": CYLINDER, **more},
    )


def frames_of(robot: str) -> tuple[str, str]:
    """Returns the first part of the topics and frames of a robot."""
    name = m.ros_name(robot)
    return (f"/{name}", f"{name}/") if name else ("", "")


def map_topic(obstacles: Obstacles) -> Iterator[Told]:
    """Yields the map of walls; none without walls."""
    low, high = bounds_of(obstacles)
    if np.isfinite(low).all():
        bounds = (*(low - _MARGIN).tolist(), *(high + _MARGIN).tolist())
        walls = costmap_from_obstacles(obstacles, bounds, _CELL)
        yield "/map", m.grid(0.0, walls)


class TrialTopics:
    """The topics of a trial that is simulated.

    It remembers when large messages were told last, so each user has its own.
    """

    def __init__(self, diagram: TrialDiagram, namespace: str = "") -> None:
        """Constructs TrialTopics.

        Args:
            diagram: The trial.
            namespace: The first part of the topics and frames of a robot
                without a name.

        Raises:
            ValueError: If a number of a person does not fit into messages.
        """
        self._diagram = diagram
        self._namespace = namespace
        self._parts = robot_parts(with_planner_lidar(diagram.scenario))
        humans = diagram.humans
        facts = describe_people(humans)
        self._people = People(
            *(facts["human_names"], facts["human_ids"], facts["behaviors"]),
            facts["group_ids"],
            [it.desired_speed for it in humans],
            [_ADULT * it.figure.tall for it in humans],
        )
        check_numbers(self._people)
        check_robots([part.name for part in self._parts])
        for part in self._parts:
            lidars = [name for _, name, _ in scans_of(part.scenario)]
            scans = [frame_of_scan(f"{m.ros_name(it)}/scan") for it in lidars]
            _check_differ("lidars", lidars, scans)
        self._lidars = [
            (part, port, f"{m.ros_name(name)}/scan".lstrip("/"), sensor)
            for part in self._parts
            for port, name, sensor in scans_of(part.scenario)
            if diagram.HasOutputPort(part.prefix + port)
        ]
        self._told: dict[str, Any] = {}

    def frames_of(self, part: RobotPart) -> tuple[str, str]:
        """Returns the first part of the topics and frames of a robot."""
        return frames_of(part.name or self._namespace)

    def constants(self) -> Iterator[Told]:
        """Yields what does not change: the map, sensors' frames, goals."""
        scenario = self._diagram.scenario
        yield from map_topic(scenario.world.obstacles())
        mounts = []
        for part, _, topic, sensor in self._lidars:
            _, frame = self.frames_of(part)
            parent = f"{frame}base_link" if sensor.mount == "robot" else "map"
            child = frame + frame_of_scan(topic)
            at = (*sensor.pose, sensor.height)
            mounts.append(m.transform(0.0, parent, child, at))
        if mounts:
            yield "/tf_static", m.transforms(*mounts)
        for part in self._parts:
            goal = part.scenario.robot.goal
            if goal is not None:
                prefix, _ = self.frames_of(part)
                told = m.pose_stamped(0.0, "map", goal)
                yield f"{prefix}/goal_pose", told

    def at(
        self,
        context: Context,
        *,
        commands: bool = True,
        wanted: Callable[[str], bool] = lambda topic: True,
    ) -> Iterator[Told]:
        """Yields the messages of an instant of the trial, its clock last.

        Args:
            context: The Context of the trial.
            commands: Whether `/cmd_vel` and `/plan` are told, too.
            wanted: Whether somebody reads a topic: those on people, which are
                large, are not made for nobody.
        """
        time = context.get_time()
        humans = self._rows("human_states", context)
        status = self._port("behavior_status").Eval(context)
        robots = {
            part.name or self._namespace: self._rows(
                f"{part.prefix}robot_state", context
            )[0]
            for part in self._parts
        }
        estimates = {
            part.name or self._namespace: self._rows(port, context)[0]
            for part in self._parts
            if self._diagram.HasOutputPort(
                port := f"{part.prefix}estimated_robot_state"
            )
        }
        if wanted("/human_states") or wanted("/people"):
            yield from people_topics(time, self._people, humans, status)
        yield from robot_topics(time, robots, estimates)
        if wanted("/markers") and self._is_due("markers", time):
            yield marker_topic(time, self._people, humans, robots)
        for part in self._parts:
            yield from self._costmaps(part, context)
            if commands:
                yield from self._commands(part, context)
        for part, port, topic, sensor in self._lidars:
            prefix, frame = self.frames_of(part)
            scan = self._port(part.prefix + port).Eval(context)
            taken = np.array([m.scan_time(time, sensor)])
            if self._is_new(f"{prefix}/{topic}", taken):
                frame += frame_of_scan(topic)
                told = m.laser_scan(time, frame, sensor, scan)
                yield f"{prefix}/{topic}", told
        yield "/clock", m.clock(time)

    def _commands(self, part: RobotPart, context: Context) -> Iterator[Told]:
        prefix, _ = self.frames_of(part)
        port = self._port(f"{part.prefix}velocity_command")
        v, omega = port.Eval(context).tolist()
        yield f"{prefix}/cmd_vel", m.twist(v, 0.0, omega)
        way = self._port(f"{part.prefix}planner_path").Eval(context)
        if self._is_new(f"{prefix}/plan", way):
            yield f"{prefix}/plan", m.path(context.get_time(), way)

    def _costmaps(self, part: RobotPart, context: Context) -> Iterator[Told]:
        prefix, _ = self.frames_of(part)
        time = context.get_time()
        for name in ("local_costmap", "global_costmap"):
            port = part.prefix + name
            if not self._diagram.HasOutputPort(port):
                continue
            if self._is_due(name, time, port):
                costs = self._port(port).Eval(context)
                if costs.costs.size:
                    yield f"{prefix}/{name}/costmap", m.grid(time, costs)

    def _is_due(self, name: str, time: float, key: str = "") -> bool:
        """Returns whether a large message is due; also if the time is back."""
        last = self._told.get(key or name, -np.inf)
        if 0 <= time - last < _PERIODS[name] - 1e-6:
            return False
        self._told[key or name] = time
        return True

    def _is_new(self, topic: str, values: Array) -> bool:
        last = self._told.get(topic)
        if last is not None and np.array_equal(last, values):
            return False
        self._told[topic] = np.array(values)
        return True

    def _port(self, name: str) -> Any:
        return self._diagram.GetOutputPort(name)

    def _rows(self, name: str, context: Context) -> Array:
        rows: Array = self._port(name).Eval(context).reshape(-1, STATE_SIZE)
        return rows


def frame_of_scan(topic: str) -> str:
    """Returns the frame of a scan: "laser", or the name of its lidar."""
    name = topic.rpartition("/")[0]
    return f"{name}_scan" if name in _FRAMES else name or "laser"
