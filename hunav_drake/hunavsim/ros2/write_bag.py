"""Writes trials to ROS 2 bags, without ROS."""

from collections.abc import Iterable, Iterator
import contextlib
from itertools import chain
from pathlib import Path
import shutil
import tempfile
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from hunav_drake.hunavsim.ros2 import topics
from hunav_drake.hunavsim.ros2.topics import (
    END,
    LATCHED,
    TOLERANCE,
    Told,
    TrialTopics,
)
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.planning.ros2 import messages as m
from hunav_drake.systems.planning.ros2.message_types import (
    message,
    to_cdr,
    type_store,
)
from hunav_drake.trial.diagram import MakeTrialDiagram
from hunav_drake.trial.result import TrialResult
from hunav_drake.trial.simulation import RunTrial

# By the ends of their names.
STORAGES = {".mcap": "MCAP", ".db3": "SQLITE3"}

# Topics of samples without an instant of a trial.
_STALE = ("/human_states", "/robot_states", "/people", "/clock")


def WriteBag(
    run: TrialResult | Recording,
    filename: str | Path,
    *,
    scenario: Scenario | None = None,
) -> Path:
    """Writes a trial to a bag of ROS 2, of version 9.

    It has the topics `/human_states` and `/robot_states` (hunav_msgs),
    `/people`, `/odom`, `/tf`, `/markers`, `/clock`, `/map`, `/goal_pose`,
    `/goal_tolerance` and, of several robots, `/trial_end`.
    With the scenario, the trial is run again, for `/cmd_vel`, `/plan`, `/scan`,
    `/local_costmap/costmap` and `/global_costmap/costmap`, too. Time 0 of the
    trial is time 0 of the bag.

    Args:
        run: The trial.
        filename: The file: its name ends in .mcap or .db3. ROS 2 needs the
            file "metadata.yaml", which is written beside it, to be alone: give
            each bag its own folder.
        scenario: The scenario with the seed of the trial.

    Returns:
        The file.

    Raises:
        FileExistsError: If there is a file of this name, or a metadata.yaml.
        ImportError: If rosbags is not installed.
        OSError: If the file cannot be written.
        ValueError: If the name has another end, a number or a name does not
            fit into messages, or the scenario gives another trial.
    """
    recording = run.recording if isinstance(run, TrialResult) else run
    path = Path(filename)
    if path.suffix not in STORAGES:
        raise ValueError(f"{path}: its name must end in .mcap or .db3")
    for file in (path, path.with_name("metadata.yaml")):
        if file.exists():
            raise FileExistsError(f"{file} exists; write into a new folder")
    if scenario is None:
        _check(recording)
        write(path, chain(_recorded(recording), _facts(recording)))
        return path
    found: list[tuple[float, list[Told]]] = []
    diagram = MakeTrialDiagram(scenario)
    told = TrialTopics(diagram)
    due = set(recording.times.tolist())

    def watch(context: Context) -> bool:
        if context.get_time() in due:
            found.append((context.get_time(), list(told.at(context))))
        return True

    again = RunTrial(scenario, diagram=diagram, watch=watch)
    if again.recording != recording:
        raise ValueError(
            "the scenario gives another trial than the run: was the program,"
            " the machine or a file changed? Leave the scenario out"
        )
    stale = recording.times[recording.times > found[-1][0]]
    if stale.size:
        # The last sample is repeated; there is no odometry of these times.
        for time, sent in _recorded(recording.since(stale[0])):
            found.append((time, [it for it in sent if it[0].endswith(_STALE)]))
    constants = 0.0, list(told.constants())
    write(path, [constants, *found, *_facts(recording)])
    return path


def _facts(recording: Recording) -> Iterator[tuple[float, list[Told]]]:
    """Yields what messages of ROS do not tell of the robots of a recording."""
    for it in recording.robots:
        prefix, _ = topics.frames_of(it.robot_name)
        if it.goal is not None:
            told = message(
                "std_msgs/msg/Float64MultiArray",
                data=np.array([it.goal_tolerance, it.goal_yaw_tolerance]),
            )
            yield float(it.times[0]), [(prefix + TOLERANCE, told)]
        if it.end_time is not None:
            end = m.header(it.end_time, "")
            yield it.end_time, [(prefix + END, end)]


def _check(recording: Recording) -> None:
    """Checks that a recording fits into messages.

    Raises:
        ValueError: If it does not.
    """
    topics.check_numbers(topics.people_of(recording))
    topics.check_robots([it.robot_name for it in recording.robots])
    times = recording.times
    for time in (times[0], times[-1]):
        if not 0 <= time < 2**31:
            raise ValueError(
                "times of a recording must be in [0, 2147483648) s in messages"
                f" of ROS 2, got {time:g} s; let it begin at 0 s"
            )
    stamps = [m.nanoseconds(m.stamp(it)) for it in times.tolist()]
    for k, step in enumerate(np.diff(stamps)):
        if step < 1:
            raise ValueError(
                "samples must be at least 1 ns apart in messages of ROS 2, but"
                f" sample {k + 1} at {times[k + 1]} s follows sample {k} at"
                f" {times[k]} s; leave one out"
            )
    status = recording.behavior_status
    if status is not None and status.size:
        for number in (status.min(), status.max()):
            if not 0 <= number <= 255:
                raise ValueError(
                    "behavior_status must be in [0, 255] in messages of ROS 2,"
                    f" got {number:g}; number them anew"
                )


def _recorded(recording: Recording) -> Iterator[tuple[float, list[Told]]]:
    """Yields the topics of a recording, by time."""
    people = topics.people_of(recording)
    start = float(recording.times[0])
    known = topics.map_topic(recording.obstacles)
    yield start, [*known] if recording.walls_known else []
    for it in recording.robots:
        if it.goal is not None:
            prefix, _ = topics.frames_of(it.robot_name)
            goal = m.pose_stamped(start, "map", it.goal)
            yield start, [(f"{prefix}/goal_pose", goal)]
    known_status = recording.behavior_status
    status = np.zeros(recording.humans.shape[:2])
    if known_status is not None:
        status += known_status
    for k, time in enumerate(recording.times.tolist()):
        robots = {it.robot_name: it.robot[k] for it in recording.robots}
        humans = recording.humans[k]
        told = [
            *topics.people_topics(time, people, humans, status[k]),
            *topics.robot_topics(time, robots),
            topics.marker_topic(time, people, humans, robots),
            ("/clock", m.clock(time)),
        ]
        yield time, told


def write(path: Path, found: Iterable[tuple[float, Iterable[Told]]]) -> None:
    """Writes messages to a bag, whole or not at all.

    Args:
        path: The file.
        found: Times, in seconds, and the messages of each.

    Raises:
        OSError: If the file cannot be written.
    """
    from rosbags.rosbag2 import (
        CompressionFormat,
        CompressionMode,
        StoragePlugin,
        Writer,
    )

    plugin = StoragePlugin[STORAGES[path.suffix]]
    with contextlib.ExitStack() as stack:
        if not path.parent.exists():
            path.parent.mkdir(parents=True)
            stack.callback(_remove_if_empty, path.parent)
        draft = stack.enter_context(
            tempfile.TemporaryDirectory(
                dir=path.parent, prefix=f".{path.name}."
            )
        )
        folder = Path(draft) / path.stem
        bag = Writer(folder, version=9, storage_plugin=plugin)
        if plugin == StoragePlugin.MCAP:
            bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            connections: dict[str, Any] = {}
            for time, told in found:
                for topic, sent in told:
                    if topic not in connections:
                        connections[topic] = _connect(bag, topic, sent)
                    stamp = m.nanoseconds(m.stamp(time))
                    bag.write(connections[topic], stamp, to_cdr(sent))
        for file in folder.iterdir():
            shutil.move(file, path.with_name(file.name))


def _remove_if_empty(folder: Path) -> None:
    with contextlib.suppress(OSError):
        folder.rmdir()


def _connect(bag: Any, topic: str, sent: Any) -> Any:
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    never = QosTime(2147483647, 4294967295)
    latched = topic in LATCHED
    return bag.add_connection(
        topic,
        sent.__msgtype__,
        typestore=type_store(),
        offered_qos_profiles=[
            Qos(
                history=QosHistory.KEEP_LAST,
                depth=1 if latched else 10,
                reliability=QosReliability.RELIABLE,
                durability=QosDurability.TRANSIENT_LOCAL
                if latched
                else QosDurability.VOLATILE,
                deadline=never,
                lifespan=never,
                liveliness=QosLiveliness.AUTOMATIC,
                liveliness_lease_duration=never,
                avoid_ros_namespace_conventions=False,
            )
        ],
    )
