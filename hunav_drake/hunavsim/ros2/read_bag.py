"""Reads recordings of people and robots from ROS bags, without ROS."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
import dataclasses
import errno
import math
import os
from pathlib import Path
from typing import Any, NamedTuple
import warnings

import numpy as np

from hunav_drake.hunavsim.agents_keys import BEHAVIOR_NAMES
from hunav_drake.hunavsim.ros2.bag import Bag, damage_told
from hunav_drake.hunavsim.ros2.frames import LONGEST_GAP, Frames, moved
from hunav_drake.hunavsim.ros2.topics import END, TOLERANCE
from hunav_drake.runs.tidy_csv import check_speeds, complete
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    RADIUS,
    STATE_FIELDS,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    X,
    Y,
)
from hunav_drake.systems.evaluation.recording import (
    GOAL_YAW_TOLERANCE,
    Recording,
)
from hunav_drake.systems.planning.ros2 import messages as m
from hunav_drake.systems.planning.ros2.message_types import type_store
from hunav_drake.systems.world.maps.map_file import CellMap, outlines_of
from hunav_drake.systems.world.obstacles import Obstacles

AGENTS, AGENT = "hunav_msgs/msg/Agents", "hunav_msgs/msg/Agent"
TRACKED = "spencer_tracking_msgs/msg/TrackedPersons"
PEOPLE = "people_msgs/msg/People"
ODOMETRY = "nav_msgs/msg/Odometry"
MAP = "nav_msgs/msg/OccupancyGrid"
GOAL = "geometry_msgs/msg/PoseStamped"
NUMBERS, HEADER = "std_msgs/msg/Float64MultiArray", "std_msgs/msg/Header"

# Types that tell of people and of robots, the best first, with the usual topic.
_PEOPLE = {AGENTS: "/human_states", TRACKED: "", PEOPLE: "/people"}
_ROBOTS = {AGENT: "/robot_states", ODOMETRY: "/odom"}

# A robot's own frame, where only transforms tell of it.
_BASES = ("base_link", "base_footprint")

# From this occupancy on, in percent, cells of a map are walls.
_OCCUPIED = 65

# The largest side of a cell of a map, in meters.
_LARGEST_CELL = 10.0


class Body(NamedTuple):
    """What a message tells of a person or robot.

    Attributes:
        key: What tells people apart: an id or a name.
        row: Its row; NaN where it is not told.
        name: Its name; empty if unknown.
        behavior: The name of its behavior; empty if it is not told.
        status: What it does.
        group_id: The number of its group.
    """

    key: Any
    row: list[float]
    name: str = ""
    behavior: str = "regular"
    status: int = 0
    group_id: int = -1


def ReadBag(
    filename: str | Path, *, people: str = "", robot: str = ""
) -> Recording:
    """Reads a bag of ROS 2, or of ROS 1, into a recording.

    People are read from hunav_msgs/Agents, spencer_tracking_msgs/TrackedPersons
    or people_msgs/People, robots from hunav_msgs/Agent, nav_msgs/Odometry or
    transforms to base_link. All are moved to the frame of the map, or else of
    the odometry, by `/tf`. Samples are at the times of the messages on people;
    the robot's states are interpolated. The goal is the last one on
    `/goal_pose`, walls are those of `/map`. What is missing is told by a
    warning; radii are then 0.35 m, headings those of the velocity.

    Args:
        filename: The folder of a bag, or a file .mcap, .db3 or .bag.
        people: The topic of people, if there are several.
        robot: The topic of the robot, if there are several; several of
            hunav_msgs/Agent are several robots.

    Raises:
        ImportError: If rosbags is not installed.
        OSError: If it cannot be read.
        ValueError: If it is no bag, or tells of no robot, with the place.
    """
    path = Path(filename)
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise ValueError(
            f"{path}: is no bag of ROS 2, and no run: it has no file"
            " metadata.yaml or recording.npz; name a folder that has one"
        )
    try:
        recording, missing = _read(path, people, robot)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    if missing:
        text = "; ".join(missing)
        warnings.warn(f"{path}: the bag has {text}", stacklevel=2)
    return recording


def _read(path: Path, people: str, robot: str) -> tuple[Recording, list[str]]:
    """Returns the recording of a bag, and what it lacks."""
    store = type_store()
    from rosbags.highlevel import AnyReader

    if not path.exists():
        raise FileNotFoundError(
            errno.ENOENT, os.strerror(errno.ENOENT), str(path)
        )
    with damage_told("is no bag that can be read"):
        reader = AnyReader([path], default_typestore=store)
        reader.open()
    bag = Bag(reader)
    try:
        return _recording(bag, people, robot)
    except AttributeError as error:
        kind = getattr(error.obj, "__msgtype__", "")
        if not kind:
            raise
        raise ValueError(
            f"{bag.last} has no field {error.name!r} in its {kind}: it is of"
            " another version; choose another topic"
        ) from error
    finally:
        reader.close()


def _recording(
    bag: Bag, people: str, robot: str
) -> tuple[Recording, list[str]]:
    people = _choose(bag, people, _PEOPLE, "people")
    chosen = [robot] if robot else _robots(bag)
    bag.begin_at(people or next(iter(chosen), ""))
    frames = Frames(bag)
    robots = {it: _track(bag, it, frames, people) for it in chosen}
    if not robots:
        robots = {"": _base_track(frames)}
    missing: list[str] = []
    samples = list(_samples(bag, people, frames, missing)) if people else []
    if not people:
        missing.append("no people")
        first = next(iter(robots.values()))
        samples = [(time, []) for time in first[0].tolist()]
    samples = _within(bag, samples, robots)
    times = np.array([time for time, _ in samples])
    facts: dict[Any, Body] = {}
    for _, bodies in samples:
        for body in bodies:
            facts.setdefault(body.key, body)
    if all(isinstance(it, int) for it in facts):
        facts = dict(sorted(facts.items()))
    index = {key: i for i, key in enumerate(facts)}
    humans = np.full((len(times), len(facts), STATE_SIZE), np.nan)
    status = np.zeros((len(times), len(facts)))
    for k, (_, bodies) in enumerate(samples):
        for body in bodies:
            humans[k, index[body.key]] = body.row
            status[k, index[body.key]] = body.status
    names = _names(facts)
    for i, name in enumerate(names):
        _fill(times, humans[:, i], name, missing)
    goals, ends = _goals(bag, frames), _ends(bag)
    walls = _walls(bag, frames, missing)
    shared: dict[str, Any] = {
        "times": times - times[0],
        "humans": humans,
        "behavior_status": status,
        "human_names": tuple(names),
        "human_ids": _ids(facts),
        "behaviors": tuple(it.behavior or "regular" for it in facts.values()),
        "group_ids": tuple(it.group_id for it in facts.values()),
        "obstacles": walls or Obstacles.from_points([]),
        "walls_known": walls is not None,
    }
    made = []
    for name, (topic, (known, rows)) in zip(
        _robot_names(robots), robots.items(), strict=True
    ):
        states = _at(bag, known, rows, times, topic or "/tf")
        _fill(times, states, "the robot", missing)
        prefix = topic.rpartition("/")[0]
        goal = goals.get(prefix)
        if goal is None and len(robots) == len(goals) == 1:
            (goal,) = goals.values()
        more: dict[str, Any] = {"robot_name": name, **(goal or {})}
        if goal is None and "no goal" not in missing:
            missing.append("no goal")
        if name and prefix in ends:
            more["end_time"] = ends[prefix] - times[0]
        made.append(Recording(robot=states, **shared, **more))
    missing += frames.gaps()
    first_robot, *others = made
    return dataclasses.replace(first_robot, others=tuple(others)), missing


def _choose(bag: Bag, given: str, kinds: dict[str, str], what: str) -> str:
    """Returns the topic of people or of a robot; empty if there is none."""
    if given:
        known = bag.types.get(given)
        if known not in kinds:
            have = [it for it, kind in bag.types.items() if kind in kinds]
            raise ValueError(
                f"the topic {given} of {what} is {known or 'not in the bag'};"
                f" valid: {', '.join(have) or 'none'}, of types"
                f" {', '.join(kinds)}"
            )
        return given
    for kind, usual in kinds.items():
        topics = bag.of_type(kind)
        if usual in topics:
            return usual
        if len(topics) > 1:
            raise ValueError(
                f"several topics tell of {what}: {', '.join(topics)}; choose"
                f" one with {what}=, or --{what}"
            )
        if topics:
            return topics[0]
    return ""


def _robots(bag: Bag) -> list[str]:
    """Returns the topics of all robots."""
    agents = bag.of_type(AGENT)
    if len(agents) > 1:
        return agents
    found = _choose(bag, "", _ROBOTS, "robot")
    return [found] if found else []


def _samples(
    bag: Bag, topic: str, frames: Frames, missing: list[str]
) -> Iterator[tuple[float, list[Body]]]:
    """Yields the times of messages on people, in s, and the people."""
    read = _READERS[bag.types[topic]]
    last, same = -math.inf, 0
    lacks: dict[str, None] = {}
    for _, came, told in bag.messages(topic):
        time = bag.time(told.header, came)
        if time <= last:
            if time == last:
                same += 1
                continue
            raise ValueError(
                f"{bag.place(topic, time)} comes after one at"
                f" {bag.clock(last)} s; cut the bag there"
            )
        last = time
        at = frames.pose(told.header.frame_id, time)
        bodies = read(told)
        keys = [it.key for it in bodies]
        if len(set(keys)) < len(keys):
            twice = next(it for it in keys if keys.count(it) > 1)
            raise ValueError(f"{bag.place(topic, time)} has {twice!r} twice")
        for k, body in enumerate(bodies):
            _check_row(bag, topic, time, body.row)
            bodies[k] = body._replace(row=moved(body.row, at))
            if not body.name and bag.types[topic] == PEOPLE:
                lacks["no names of people, whom their places tell apart"] = None
            if not body.behavior:
                lacks["no behaviors of HuNavSim for some people"] = None
        yield time, bodies
    missing += lacks
    if same:
        missing.append(
            f"{same} messages of {topic} with the time of the one before,"
            " which are left out"
        )


def _check_row(bag: Bag, topic: str, time: float, row: list[float]) -> None:
    """Refuses a row whose numbers are out of range; NaN is not told."""
    numbers = dict(zip(STATE_FIELDS, row, strict=True))
    known = {it: x for it, x in numbers.items() if it in "xy" or x == x}
    bag.check(topic, time, known)
    if row[RADIUS] < 0:
        raise ValueError(
            f"{bag.place(topic, time)} has radius = {row[RADIUS]:g}, which must"
            " not be negative; cut the bag there"
        )


def _agent(told: Any) -> Body:
    behavior, status = told.behavior, getattr(told, "behavior_state", 0)
    if not isinstance(behavior, int | np.integer):
        # HuNavSim 2.
        behavior, status = behavior.type, behavior.state
    number = int(behavior)
    return Body(
        int(told.id),
        m.row_of(told),
        str(told.name),
        BEHAVIOR_NAMES.get(number, str(number) if number else ""),
        int(status),
        int(told.group_id),
    )


def _read_agents(told: Any) -> list[Body]:
    return [_agent(it) for it in told.agents if it.type != m.ROBOT]


def _read_people(told: Any) -> list[Body]:
    nan = math.nan
    return [
        Body(
            str(it.name) or i,
            [
                *(it.position.x, it.position.y, nan),
                *(it.velocity.x, it.velocity.y, nan, nan),
            ],
            str(it.name),
        )
        for i, it in enumerate(told.people)
    ]


def _read_tracked(told: Any) -> list[Body]:
    bodies = []
    for it in told.tracks:
        at, speed = it.pose.pose, it.twist.twist
        row = [
            *(at.position.x, at.position.y, math.nan),
            *(speed.linear.x, speed.linear.y, speed.angular.z, math.nan),
        ]
        bodies.append(Body(int(it.track_id), row))
    return bodies


_READERS: dict[str, Callable[[Any], list[Body]]] = {
    AGENTS: _read_agents,
    PEOPLE: _read_people,
    TRACKED: _read_tracked,
}


def _track(
    bag: Bag, topic: str, frames: Frames, people: str
) -> tuple[Array, Array]:
    """Returns the times (s) and the rows of a robot.

    HuNavSim's agents name no frame: it is that of its `people`. Nor have they
    a stamp: it is as late as those of the people who come with them, so that
    stamps may be of a simulated time.
    """
    frame = frames.fixed
    if bag.types.get(people) == AGENTS:
        first = next(bag.messages(people), None)
        frame = first[2].header.frame_id if first else frame
    kind = bag.types.get(topic)
    if kind not in _ROBOTS:
        _choose(bag, topic, _ROBOTS, "robot")
    shifts = [(0.0, 0.0)]
    if kind == AGENT and people:
        shifts = [
            (came, bag.time(told.header, came) - came)
            for _, came, told in bag.messages(people)
        ] or shifts
    arrivals, late = np.array(shifts).T
    rows: dict[float, list[float]] = {}
    for _, came, told in bag.messages(topic):
        if kind == AGENT:
            time = came + float(np.interp(came, arrivals, late))
            row = m.row_of(told)
            _check_row(bag, topic, time, row)
            rows[time] = moved(row, frames.pose(frame, time))
            continue
        time = bag.time(told.header, came)
        at, speed = told.pose.pose, told.twist.twist
        yaw = m.yaw_of(at.orientation)
        c, s = math.cos(yaw), math.sin(yaw)
        vx, vy = speed.linear.x, speed.linear.y
        row = [
            *(at.position.x, at.position.y, yaw),
            *(c * vx - s * vy, s * vx + c * vy, speed.angular.z, math.nan),
        ]
        _check_row(bag, topic, time, row)
        rows[time] = moved(row, frames.pose(told.header.frame_id, time))
    if not rows:
        raise ValueError(f"topic {topic} has no messages")
    times = np.array(sorted(rows))
    return times, np.array([rows[it] for it in times.tolist()])


def _base_track(frames: Frames) -> tuple[Array, Array]:
    """Returns the times and rows of the robot from transforms alone."""
    for base in _BASES:
        root = frames.root(base)
        if root == base:
            continue
        chain = [frames.moves(base)]
        times = next(it for it in chain if it is not None)
        times = np.unique(times)
        rows = np.full((len(times), STATE_SIZE), np.nan)
        for k, time in enumerate(times.tolist()):
            rows[k, [X, Y, YAW]] = frames.pose(base, time)
        return times, rows
    raise ValueError(
        "the bag tells of no robot: it needs a topic of type"
        f" {', '.join(_ROBOTS)}, or transforms to {' or '.join(_BASES)}"
    )


def _within(
    bag: Bag,
    samples: Sequence[tuple[float, list[Body]]],
    tracks: dict[str, tuple[Array, Array]],
) -> list[tuple[float, list[Body]]]:
    """Returns the samples in the time that all robots are known."""
    first = max(float(times[0]) for times, _ in tracks.values())
    last = min(float(times[-1]) for times, _ in tracks.values())
    left = [it for it in samples if first - 1e-6 <= it[0] <= last + 1e-6]
    if left:
        return left
    ends = "never told of"
    if samples:
        begin, end = (bag.clock(samples[k][0]) for k in (0, -1))
        ends = f"told of from {begin} s to {end} s"
    fault = (
        f"people are {ends}, the robot from {bag.clock(first)} s to"
        f" {bag.clock(last)} s: they have no time in common; do their clocks"
        " differ?"
    )
    if any(bag.types.get(it) == AGENT for it in tracks):
        fault += f" {AGENT} has no stamp: choose an odometry with --robot"
    raise ValueError(fault)


def _robot_names(topics: Iterable[str]) -> list[str]:
    """Returns the names of robots by their topics; that of one is empty."""
    topics = list(topics)
    if len(topics) == 1:
        return [""]
    names = [it.rpartition("/")[0].strip("/") for it in topics]
    if all(names) and len(set(names)) == len(names):
        return names
    return [it.strip("/") for it in topics]


def _at(bag: Bag, told: Array, rows: Array, times: Array, topic: str) -> Array:
    """Returns the rows of a robot at other times, interpolated."""
    gaps = np.diff(told)
    for k in np.flatnonzero(gaps > LONGEST_GAP):
        if told[k] < times[-1] and told[k + 1] > times[0]:
            raise ValueError(
                f"topic {topic} has no message from {bag.clock(told[k])} s to"
                f" {bag.clock(told[k + 1])} s; cut the bag there"
            )
    smooth = rows.copy()
    smooth[:, YAW] = np.unwrap(rows[:, YAW])
    result = np.column_stack(
        [np.interp(times, told, smooth[:, i]) for i in range(STATE_SIZE)]
    )
    # Where a message has the time of a sample, to the rounding of clocks.
    near = np.clip(np.searchsorted(told, times - 1e-6), 0, len(told) - 1)
    same = np.abs(told[near] - times) <= 1e-6
    result[same] = rows[near[same]]
    return result


def _fill(times: Array, states: Array, name: str, missing: list[str]) -> None:
    """Computes the fields of a body that are nowhere told, in place."""
    there = ~np.isnan(states[:, X])
    lacks = {
        field
        for i, field in enumerate(STATE_FIELDS)
        if np.isnan(states[there, i]).any()
    }
    # Some trackers tell no velocities.
    moves = np.ptp(states[there][:, [X, Y]], axis=0).max(initial=0.0) > 0.1
    if moves and not states[there][:, [VX, VY]].any():
        lacks |= {"vx", "vy"}
    if lacks:
        complete(times, states, lacks)
        what = {RADIUS: "radii", YAW: "headings", VX: "velocities"}
        who = name if name == "the robot" else "people"
        for i, word in what.items():
            text = f"no {word} of {who}"
            if STATE_FIELDS[i] in lacks and text not in missing:
                missing.append(text)
    check_speeds(times, states, name)


def _names(facts: dict[Any, Body]) -> list[str]:
    """Returns the names of people, each once."""
    names = [it.name or f"person_{key}" for key, it in facts.items()]
    if len(set(names)) == len(names):
        return names
    return [f"person_{key}" for key in facts]


def _ids(facts: dict[Any, Body]) -> tuple[int, ...]:
    """Returns the ids of people: theirs, or 1, 2, ..."""
    if all(isinstance(it, int) for it in facts):
        return tuple(facts)
    return tuple(range(1, len(facts) + 1))


def _goals(bag: Bag, frames: Frames) -> dict[str, dict[str, Any]]:
    """Returns the last goal of each robot, by the first part of its topics.

    They are fields of `Recording`.
    """
    topics = [
        it
        for it in bag.of_type(GOAL)
        if it.endswith(("/goal_pose", "/move_base_simple/goal"))
    ]
    found: dict[str, dict[str, Any]] = {}
    for topic, came, told in bag.messages(*topics):
        time = bag.time(told.header, came)
        at = told.pose
        row = [at.position.x, at.position.y, m.yaw_of(at.orientation)]
        names = ("x", "y", "yaw")
        bag.check(topic, time, dict(zip(names, row, strict=True)))
        x, y, yaw = frames.pose(told.header.frame_id, time)
        goal = moved([*row, 0.0, 0.0, 0.0, 0.0], (x, y, yaw))[:3]
        prefix = topic.removesuffix("/goal_pose")
        found[prefix.removesuffix("/move_base_simple/goal")] = {
            "goal": tuple(goal),
            "goal_yaw_tolerance": GOAL_YAW_TOLERANCE,
        }
    topics = [it for it in bag.of_type(NUMBERS) if it.endswith(TOLERANCE)]
    for topic, came, told in bag.messages(*topics):
        prefix = topic.removesuffix(TOLERANCE)
        keys = ("goal_tolerance", "goal_yaw_tolerance")
        if prefix in found and len(told.data) == len(keys):
            numbers = dict(zip(keys, told.data.tolist(), strict=True))
            bag.check(topic, came, numbers)
            found[prefix] |= numbers
    return found


def _ends(bag: Bag) -> dict[str, float]:
    """Returns when robots ended, by the first part of their topics."""
    topics = [it for it in bag.of_type(HEADER) if it.endswith(END)]
    return {
        topic.removesuffix(END): bag.time(told, came)
        for topic, came, told in bag.messages(*topics)
    }


def _walls(bag: Bag, frames: Frames, missing: list[str]) -> Obstacles | None:
    """Returns the walls of the map; None without a map."""
    known = bag.types.get("/map") == MAP
    last = deque(bag.messages("/map") if known else (), maxlen=1)
    if not last:
        missing.append("no map")
        return None
    topic, came, told = last[0]
    info = told.info
    cells = np.asarray(told.data, dtype=np.int8)
    if cells.size != info.width * info.height:
        raise ValueError(
            f"/map has {cells.size} cells for a width of {info.width} and a"
            f" height of {info.height}; leave it out of the bag"
        )
    if not 0 < info.resolution <= _LARGEST_CELL:
        raise ValueError(
            f"/map has cells of {info.resolution:g} m, which must be in"
            f" (0, {_LARGEST_CELL:g}] m; leave it out of the bag"
        )
    if not (cells >= 0).any():
        missing.append("no known cells on its map")
        return None
    at = info.origin
    x, y, yaw = at.position.x, at.position.y, m.yaw_of(at.orientation)
    time = bag.time(told.header, came)
    bag.check(topic, time, {"x": x, "y": y, "yaw": yaw})
    try:
        pose = frames.pose(told.header.frame_id, time)
    except ValueError:
        missing.append(
            f"no transforms from its map's frame {told.header.frame_id!r}, so"
            " no walls"
        )
        return None
    x, y, yaw = moved([x, y, yaw, 0.0, 0.0, 0.0, 0.0], pose)[:3]
    cells = cells.reshape(info.height, info.width)
    resolution = float(str(np.float32(info.resolution)))
    map_ = CellMap(cells >= _OCCUPIED, cells == 0, resolution, (x, y, yaw))
    shapes = list(outlines_of(map_))
    return Obstacles.from_shapes(shapes, solid=[True] * len(shapes))
