"""Bags of ROS 2: written, read by two other libraries, and read back."""

from collections import Counter
import contextlib
import dataclasses
import math
import shutil
import warnings

from mcap_ros2.reader import read_ros2_messages
import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
import shapely

from hunav_drake import (
    ListScenarios,
    LoadScenario,
    ReadBag,
    ReadRecording,
    RunTrial,
    WriteBag,
)
from hunav_drake.commands.cli import main
from hunav_drake.hunavsim.ros2 import write_bag
from hunav_drake.hunavsim.ros2.topics import TrialTopics
from hunav_drake.hunavsim.ros2.write_bag import write
from hunav_drake.systems.planning.ros2 import message, messages as m, type_store
from hunav_drake.systems.planning.ros2.message_types import from_cdr, to_cdr
from hunav_drake.trial.diagram import MakeTrialDiagram
from hunav_drake.views.recorded_trial import LoadRecordedTrial
from tests.choices import fast

CROSSING = ["planner.type=dwb", "sensors=[{type: lidar, name: front}]"]


@pytest.fixture(scope="module")
def crossing():
    scenario = LoadScenario(filename="crossing", overrides=CROSSING)
    return scenario, RunTrial(scenario)


@pytest.fixture(scope="module")
def bag(crossing, tmp_path_factory):
    scenario, result = crossing
    path = tmp_path_factory.mktemp("bag") / "crossing" / "run.mcap"
    return WriteBag(result, path, scenario=scenario)


def plain(value):
    """Returns a message of any library as lists and numbers."""
    if hasattr(value, "__len__") and len(value) > 1000:
        # A map: as bytes, which are faster to compare.
        return np.asarray(value, dtype=np.int16).tobytes()
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple | bytes):
        return [plain(it) for it in value]
    if dataclasses.is_dataclass(value):
        names = [it.name for it in dataclasses.fields(value)]
        # (Constants are fields, too.)
        names = [it for it in names if not it.startswith("__")]
        names = [it for it in names if not it.isupper()]
    elif not (names := getattr(value, "__slots__", ())):
        return value
    return {it: plain(getattr(value, it)) for it in names}


def sent_by(path):
    """Returns what two libraries read in a bag, as (topic, ns, message)."""
    kept = []
    with AnyReader([path.parent]) as reader:
        for connection, stamp, data in reader.messages():
            told = reader.deserialize(data, connection.msgtype)
            kept.append((connection.topic, stamp, plain(told)))
    others = [
        (it.channel.topic, it.log_time_ns, plain(it.ros_msg))
        for it in read_ros2_messages(str(path), log_time_order=True)
    ]
    return kept, others


def check_bag(scenario, path):
    """Checks each message of a bag by two libraries."""
    written = []

    def keep(path, found):
        found = [(time, list(told)) for time, told in found]
        for time, told in found:
            stamp = m.nanoseconds(m.stamp(time))
            # (Some numbers are sent in single precision.)
            written.extend(
                (it, stamp, plain(from_cdr(to_cdr(sent), sent.__msgtype__)))
                for it, sent in told
            )
        write(path, found)

    result = RunTrial(scenario)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(write_bag, "write", keep)
        WriteBag(result, path, scenario=scenario)
    kept, others = sent_by(path)

    def by_topic(told):
        topics = {}
        for topic, stamp, it in told:
            topics.setdefault(topic, []).append((stamp, it))
        return topics

    # (In each topic in order: readers sort by time only.)
    first, second, third = map(by_topic, (written, kept, others))
    assert first.keys() == second.keys() == third.keys()
    for topic in first:
        assert first[topic] == second[topic], topic
        assert first[topic] == third[topic], topic
    return Counter(topic for topic, _, _ in written)


@pytest.mark.slow
@pytest.mark.parametrize("name", fast(ListScenarios(), "passing"))
def test_two_libraries_read_each_message(name, tmp_path):
    scenario = LoadScenario(filename=name, overrides=["simulation.duration=2"])
    topics = check_bag(scenario, tmp_path / "a" / "a.mcap")
    assert topics["/human_states"] == topics["/people"] == topics["/clock"]


@pytest.mark.slow
def test_a_bag_has_all_topics_of_a_trial(bag):
    with AnyReader([bag.parent]) as reader:
        types = {it.topic: it.msgtype for it in reader.connections}
        counts = {it.topic: it.msgcount for it in reader.connections}
    assert types == {
        "/clock": "rosgraph_msgs/msg/Clock",
        "/cmd_vel": "geometry_msgs/msg/Twist",
        "/global_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
        "/goal_pose": "geometry_msgs/msg/PoseStamped",
        "/goal_tolerance": "std_msgs/msg/Float64MultiArray",
        "/human_states": "hunav_msgs/msg/Agents",
        "/local_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/markers": "visualization_msgs/msg/MarkerArray",
        "/odom": "nav_msgs/msg/Odometry",
        "/people": "people_msgs/msg/People",
        "/plan": "nav_msgs/msg/Path",
        "/robot_states": "hunav_msgs/msg/Agent",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
    }
    assert counts["/human_states"] == counts["/scan"] == 131
    assert counts["/global_costmap/costmap"] == 14 - 1
    # One message of what does not change.
    assert counts["/map"] == counts["/tf_static"] == counts["/goal_pose"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".mcap", ".db3"])
def test_a_recording_comes_back(crossing, tmp_path, suffix):
    _, result = crossing
    told = result.recording
    path = WriteBag(result, tmp_path / "b" / f"run{suffix}")
    for place in (path, path.parent):
        read = ReadRecording(place)
        np.testing.assert_array_equal(read.robot, told.robot)
        np.testing.assert_array_equal(
            read.humans[..., :6], told.humans[..., :6]
        )
        # HuNavSim has radii in single precision.
        np.testing.assert_allclose(
            read.humans[..., 6], told.humans[..., 6], rtol=1e-7
        )
        np.testing.assert_allclose(read.times, told.times, atol=1e-9)
        np.testing.assert_array_equal(
            read.behavior_status, told.behavior_status
        )
        assert read.goal == told.goal
        for name in ("human_names", "human_ids", "behaviors", "group_ids"):
            assert getattr(read, name) == getattr(told, name)


@pytest.mark.slow
def test_a_folder_of_a_bag_can_be_shown(bag):
    trial = LoadRecordedTrial(bag.parent)
    assert trial.recording == ReadBag(bag)
    assert [it.name for it in trial.humans] == ["ana", "luis", "marta", "pablo"]


def test_walls_come_back_as_the_cells_of_the_map(crossing, bag):
    _, result = crossing
    told, read = result.recording.obstacles, ReadBag(bag).obstacles
    for point in ([0.0, 0.0], [-2.0, 1.0], [1.5, -1.5]):
        distances = [
            min(
                shapely.LineString(wall.reshape(2, 2)).distance(
                    shapely.Point(point)
                )
                for wall in it.segments
            )
            for it in (told, read)
        ]
        assert distances[0] == pytest.approx(distances[1], abs=0.06)


@pytest.mark.slow
def test_several_robots_come_back(tmp_path):
    scenario = LoadScenario(
        filename="elevator_lobby", overrides=["simulation.duration=5"]
    )
    told = RunTrial(scenario).recording
    read = ReadBag(WriteBag(told, tmp_path / "c" / "c.db3"))
    assert [it.robot_name for it in read.robots] == [
        it.robot_name for it in told.robots
    ]
    for one, two in zip(read.robots, told.robots, strict=True):
        np.testing.assert_array_equal(one.robot, two.robot)
        assert one.goal == pytest.approx(two.goal)


@pytest.mark.slow
def test_goals_count_as_in_the_trial(crossing, tmp_path):
    told = crossing[1].recording
    x, y = told.robot[-1, :2].tolist()
    near = dataclasses.replace(
        told,
        goal=(x + 0.4, y, 1.0 + told.robot[-1, 2]),
        goal_tolerance=0.5,
        goal_yaw_tolerance=1.5,
    )
    read = ReadBag(WriteBag(near, tmp_path / "one" / "a.mcap"))
    assert (read.goal_tolerance, read.goal_yaw_tolerance) == (0.5, 1.5)
    assert read.features.at_goal[-1]
    # Of several robots, each counts until its end.
    other = dataclasses.replace(near, robot_name="ben", end_time=7.25)
    several = dataclasses.replace(
        told, robot_name="anna", goal_tolerance=0.1, others=(other,)
    )
    for start in (0.0, 2.0):
        part = several.since(start)
        folder = tmp_path / f"from {start:g}"
        for suffix in (".mcap", ".db3"):
            read = ReadBag(WriteBag(part, folder / suffix[1:] / f"b{suffix}"))
            assert [it.goal_tolerance for it in read.robots] == [0.1, 0.5]
            assert [it.end_time for it in read.robots] == [
                None,
                pytest.approx(7.25 - start),
            ]
            assert [len(it.until_end()) for it in read.robots] == [
                len(it.until_end()) for it in part.robots
            ]


@pytest.mark.parametrize("again", [False, True])
def test_repeated_samples_come_back(tmp_path, again):
    scenario = LoadScenario(
        filename="crossing",
        overrides=["simulation.duration=2", "evaluator.stale_samples=3"],
    )
    result = RunTrial(scenario)
    told = result.recording
    path = WriteBag(
        result, tmp_path / "a" / "a.mcap", scenario=scenario if again else None
    )
    read = ReadBag(path)
    assert len(told) == 24
    np.testing.assert_allclose(read.times, told.times, atol=1e-9)
    np.testing.assert_array_equal(read.robot, told.robot)


@pytest.mark.slow
def test_people_who_are_not_there_are_not_in_it(tmp_path):
    scenario = LoadScenario(
        filename="station", overrides=["simulation.duration=12"]
    )
    told = RunTrial(scenario).recording
    read = ReadBag(WriteBag(told, tmp_path / "d" / "d.mcap"))
    here = ~np.isnan(told.humans[..., 0])
    seen = here.any(axis=0)
    assert not seen.all()
    assert read.human_ids == tuple(np.array(told.human_ids)[seen].tolist())
    np.testing.assert_array_equal(~np.isnan(read.humans[..., 0]), here[:, seen])


def test_another_trial_is_refused(crossing, tmp_path):
    scenario, result = crossing
    other = dataclasses.replace(
        scenario, planner=LoadScenario(filename="crossing").planner
    )
    with pytest.raises(ValueError, match="another trial than the run"):
        WriteBag(result, tmp_path / "e" / "e.mcap", scenario=other)
    assert not (tmp_path / "e").exists()


def test_nothing_is_overwritten(crossing, tmp_path):
    _, result = crossing
    path = WriteBag(result, tmp_path / "f.mcap")
    before = path.read_bytes()
    for name in ("f.mcap", "g.mcap"):
        with pytest.raises(FileExistsError, match="write into a new folder"):
            WriteBag(result, tmp_path / name)
    assert path.read_bytes() == before
    with pytest.raises(ValueError, match=r"must end in \.mcap or \.db3"):
        WriteBag(result, tmp_path / "h.bag")


def test_numbers_that_messages_cannot_hold_are_told(crossing, tmp_path):
    _, result = crossing
    n = result.recording.num_humans
    large = dataclasses.replace(
        result.recording, group_ids=(300,) + (-1,) * (n - 1)
    )
    with pytest.raises(ValueError, match=r"group_id of .* must be below 128"):
        WriteBag(large, tmp_path / "i.mcap")
    assert list(tmp_path.iterdir()) == []


def test_a_trial_that_goes_back_tells_large_messages_again(crossing):
    scenario, _ = crossing
    diagram = MakeTrialDiagram(scenario)
    topics = TrialTopics(diagram)
    context = diagram.CreateDefaultContext()
    first = {it for it, _ in topics.at(context)}
    assert "/markers" in first
    assert "/markers" not in {it for it, _ in topics.at(context)}
    context.SetTime(5.0)
    assert "/markers" in {it for it, _ in topics.at(context)}
    context.SetTime(1.0)
    assert "/markers" in {it for it, _ in topics.at(context)}


# Damaged bags.


def damaged(bag, tmp_path, change):
    folder = tmp_path / "damaged"
    shutil.copytree(bag.parent, folder)
    file = folder / bag.name
    file.write_bytes(change(file.read_bytes()))
    return file


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data[: len(data) // 2],
        lambda data: b"",
        lambda data: b"nonsense" * 100,
        lambda data: data[:5000] + bytes(2000) + data[7000:],
        lambda data: data[:-2000] + bytes(2000),
    ],
    ids=["half", "empty", "nonsense", "zeros", "end"],
)
@pytest.mark.parametrize("whole", [True, False], ids=["folder", "file"])
def test_a_damaged_bag_is_told_in_one_line(
    bag, tmp_path, change, whole, capsys
):
    file = damaged(bag, tmp_path, change)
    place = file.parent if whole else file
    code = main(["evaluate", str(place), "--metrics", "paper"])
    told = capsys.readouterr().err.strip()
    # (Some bytes matter to nobody.)
    if code:
        assert code == 2
        assert told.count("\n") == 0
        assert str(place) in told
        assert "bug" not in told


def test_random_damages_are_told(bag, tmp_path):
    rng = np.random.default_rng(5)
    data = bag.read_bytes()
    for k in range(40):
        bad = bytearray(data)
        for at in rng.integers(0, len(data), 30):
            bad[at] = rng.integers(256)
        file = tmp_path / f"{k}.mcap"
        file.write_bytes(bytes(bad))
        # (Some bytes matter to nobody.)
        with contextlib.suppress(ValueError), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ReadBag(file)


def test_a_place_that_damaged_bytes_point_to_is_told(bag, monkeypatch):
    def fails(*_):
        raise OSError(22, "Invalid argument")

    monkeypatch.setattr(AnyReader, "open", fails)
    words = f"{bag}: is no bag that can be read: .*Invalid argument"
    with pytest.raises(ValueError, match=words):
        ReadBag(bag)


def test_a_folder_that_is_no_bag(tmp_path, capsys):
    assert main(["evaluate", str(tmp_path)]) == 2
    assert "it has no file metadata.yaml" in capsys.readouterr().err


# Bags from elsewhere.

HZ = 10.0


def people_at(k, frame="map", names=("ana", "ben")):
    """Returns people who walk along x, 0.5 m/s, one behind the other."""
    people = [
        message(
            "people_msgs/msg/Person",
            name=name,
            position=m.vector(0.5 * k / HZ - i, 1.0, 0.0, "Point"),
            velocity=m.vector(0.5, 0.0, 0.0, "Point"),
        )
        for i, name in enumerate(names)
    ]
    kind = "people_msgs/msg/People"
    return message(kind, header=m.header(100 + k / HZ, frame), people=people)


def robot_at(time, frame="odom"):
    """Returns the odometry of a robot that drives a circle of 2 m."""
    yaw = 0.3 * time
    row = [
        *(2 * math.sin(yaw), -2 * math.cos(yaw), yaw),
        *(0.6 * math.cos(yaw), 0.6 * math.sin(yaw), 0.3, 0.3),
    ]
    return m.odometry(100 + time, np.array(row), frame)


def odometry(count=120, period=0.05):
    return [
        (100 + k * period, [("/odom", robot_at(k * period))])
        for k in range(count)
    ]


def joined(time, at=(0.0, 0.0, 0.0), child="odom"):
    return ("/tf", m.transforms(m.transform(time, "map", child, at)))


def told_people(count=50, **settings):
    return [
        (100 + k / HZ, [("/people", people_at(k, **settings))])
        for k in range(count)
    ]


def in_order(*parts):
    return sorted((it for part in parts for it in part), key=lambda it: it[0])


def test_people_and_odometry_at_other_rates(tmp_path):
    # The odometry begins at (1, 2), turned by 90 degrees.
    frames = [(100.0, [joined(100.0, (1.0, 2.0, math.pi / 2))])]
    path = tmp_path / "k" / "k.mcap"
    write(path, in_order(frames, told_people(), odometry()))
    with pytest.warns(UserWarning, match="the bag has") as caught:
        read = ReadBag(path)
    (told,) = caught
    for lack in ("no radii of people", "no headings of people", "no map"):
        assert lack in str(told.message)
    assert "no goal" in str(told.message)
    assert len(read) == 50
    np.testing.assert_allclose(np.diff(read.times), 0.1, atol=1e-9)
    yaw = 0.3 * read.times
    np.testing.assert_allclose(read.robot[:, 0], 1 + 2 * np.cos(yaw), atol=1e-9)
    np.testing.assert_allclose(read.robot[:, 1], 2 + 2 * np.sin(yaw), atol=1e-9)
    np.testing.assert_allclose(read.robot[:, 2], yaw + math.pi / 2, atol=1e-9)
    np.testing.assert_allclose(read.humans[:, 0, 0], 0.5 * read.times)
    np.testing.assert_allclose(read.humans[..., 3], 0.5)
    np.testing.assert_allclose(read.humans[..., 2], 0.0)
    assert read.human_names == ("ana", "ben")
    assert not read.walls_known


def test_people_in_the_frame_of_the_robot(tmp_path):
    """A detector tells of somebody who stands, from a robot that drives."""
    path = tmp_path / "l" / "l.mcap"
    found = []
    for k in range(60):
        time = k * 0.05
        row = m.row_of(m.agent([0.5 * time, 0.0, 0.4 * time, 0, 0, 0, 0.3]))
        x, y, yaw = row[:3]
        c, s = math.cos(-yaw), math.sin(-yaw)
        dx, dy = 3.0 - x, 1.0 - y
        tracked = message(
            "spencer_tracking_msgs/msg/TrackedPerson",
            track_id=7,
            pose=message(
                "geometry_msgs/msg/PoseWithCovariance",
                pose=m.pose(c * dx - s * dy, s * dx + c * dy, 0.0),
            ),
        )
        kind = "spencer_tracking_msgs/msg/TrackedPersons"
        told = message(
            kind, header=m.header(5 + time, "base_link"), tracks=[tracked]
        )
        poses = m.transforms(
            m.transform(5 + time, "odom", "base_link", row[:3])
        )
        found.append((5 + time, [("/tf", poses), ("/tracks", told)]))
    write(path, found)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = ReadBag(path)
    np.testing.assert_allclose(read.humans[:, 0, 0], 3.0, atol=1e-9)
    np.testing.assert_allclose(read.humans[:, 0, 1], 1.0, atol=1e-9)
    np.testing.assert_allclose(read.robot[:, 0], 0.5 * read.times, atol=1e-9)
    np.testing.assert_allclose(read.robot[:, 3], 0.5, atol=1e-6)
    assert read.human_names == ("person_7",)


def test_a_bag_of_ros_1(tmp_path):
    path = tmp_path / "m.bag"
    store = get_typestore(Stores.ROS1_NOETIC)
    types = {
        name: type_store().fielddefs[name]
        for name in (
            "people_msgs/msg/Person",
            "people_msgs/msg/People",
            "tf2_msgs/msg/TFMessage",
        )
    }
    store.register(types)

    def converted(told):
        """Returns a message as ROS 1 has it: headers have a sequence."""
        made = store.types[told.__msgtype__]
        values = {}
        for name, value in vars(told).items():
            if name == "__msgtype__":
                continue
            if isinstance(value, list):
                value = [converted(it) for it in value]
            elif hasattr(value, "__msgtype__"):
                value = converted(value)
            values[name] = value
        if told.__msgtype__ == "std_msgs/msg/Header":
            values["seq"] = 0
        return made(**values)

    frames = [(100.0, [joined(100.0)])]
    with rosbag1.Writer(path) as writer:
        connections = {}
        for time, told in in_order(frames, told_people(), odometry()):
            for topic, sent in told:
                kind = sent.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(
                        topic, kind, typestore=store
                    )
                data = store.serialize_ros1(converted(sent), kind)
                writer.write(connections[topic], round(time * 1e9), data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = ReadRecording(path)
    np.testing.assert_allclose(read.humans[:, 0, 0], 0.5 * read.times)
    np.testing.assert_allclose(
        read.robot[:, 0], 2 * np.sin(0.3 * read.times), atol=1e-9
    )


def faulty(tmp_path, *parts):
    path = tmp_path / "n" / "n.mcap"
    write(path, in_order(*parts))
    return path


JOIN = [(100.0, [joined(100.0)])]


@pytest.mark.slow
def test_what_a_bag_must_have(tmp_path):
    for number, (parts, words) in enumerate(
        [
            ([told_people()], "tells of no robot: it needs a topic"),
            ([told_people(), odometry()], "no transforms on /tf join"),
            ([JOIN, told_people(), odometry(20)[:1]], None),
            (
                [
                    JOIN,
                    told_people(),
                    [(t + 900, x) for t, x in late_odometry()],
                ],
                "they have no time in common",
            ),
            (
                [JOIN, told_people(), odometry()[:10], odometry()[60:]],
                "topic /odom has no message from 100.45 s to 103 s",
            ),
            (
                [JOIN, told_people(names=("ana", "ana")), odometry()],
                "has 'ana' twice",
            ),
            (
                [
                    JOIN,
                    [
                        (t, [("/other", it) for _, it in told])
                        for t, told in told_people()
                    ],
                    [
                        (t, [("/more", it) for _, it in told])
                        for t, told in told_people()
                    ],
                    odometry(),
                ],
                "several topics tell of people: /other, /more",
            ),
        ]
    ):
        path = tmp_path / str(number) / "n.mcap"
        write(path, in_order(*parts))
        if words is None:
            continue
        with pytest.raises(ValueError, match=words) as info:
            ReadBag(path)
        assert str(info.value).startswith(str(path))


def late_odometry():
    return [
        (100 + k * 0.05, [("/odom", robot_at(900 + k * 0.05))])
        for k in range(20)
    ]


def test_a_topic_may_be_chosen(tmp_path, capsys):
    twice = [
        (t, [("/other", it) for _, it in told])
        for t, told in told_people(names=("eva",))
    ]
    path = faulty(tmp_path, JOIN, told_people(), twice, odometry())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert ReadBag(path).num_humans == 2
        assert ReadRecording(path, people="/other").human_names == ("eva",)
    options = ["evaluate", str(path), "--metrics", "path_length"]
    assert main([*options, "--people", "/odom"]) == 2
    told = capsys.readouterr().err
    assert "the topic /odom of people is nav_msgs/msg/Odometry" in told
    assert "valid: /people, /other" in told
    assert main([*options, "--people", "/other"]) == 0
    told = capsys.readouterr()
    assert "no map" in told.err
    assert "path_length" in told.out


def test_topics_are_for_bags(tmp_path):
    with pytest.raises(ValueError, match="is no bag, and has no topics"):
        ReadRecording(tmp_path / "a.csv", people="/people")


# The command.


@pytest.mark.slow
def test_a_run_is_exported(tmp_path, capsys):
    options = ["--quiet", "--no-replay", "--out", str(tmp_path)]
    assert main(["run", "passing", "--planner", "dwb", *options]) == 0
    assert main(["export", str(tmp_path), "--mcap"]) == 0
    (run,) = (tmp_path / "runs").iterdir()
    assert f"Wrote the bag {run / 'bag'}" in capsys.readouterr().out
    with rosbag2.Reader(run / "bag") as reader:
        topics = {it.topic for it in reader.connections}
    assert {"/plan", "/local_costmap/costmap", "/human_states"} <= topics
    assert main(["export", str(run)]) == 2
    assert "choose another folder with --output" in capsys.readouterr().err
    # A recording alone has no plans.
    output = ["-o", str(tmp_path / "other"), "--db3"]
    shutil.copy(run / "recording.npz", tmp_path / "alone.npz")
    assert main(["export", str(tmp_path / "alone.npz"), *output]) == 0
    with rosbag2.Reader(tmp_path / "other") as reader:
        topics = {it.topic for it in reader.connections}
    assert "/plan" not in topics
    assert "/human_states" in topics
    # Nor has a run that its scenario does not repeat.
    text = (run / "scenario.yaml").read_text()
    (run / "scenario.yaml").write_text(
        text.replace("type: dwb", "type: pursuit")
    )
    assert main(["export", str(run), "-o", str(tmp_path / "third")]) == 0
    assert "cannot be repeated" in capsys.readouterr().err


def test_what_cannot_be_exported(tmp_path, capsys):
    assert main(["export", str(tmp_path / "none")]) == 2
    assert "there is no such file or folder" in capsys.readouterr().err
    assert main(["export", str(tmp_path)]) == 2
    assert "there is no recording" in capsys.readouterr().err


def test_bytes_are_those_of_the_store():
    sent = m.clock(1.5)
    assert to_cdr(sent)[:4] == b"\0\1\0\0"


# Odd bags from elsewhere.


def later(parts, seconds):
    """Returns messages whose times are all later, also their stamps."""
    moved = []
    for time, told in parts:
        for _, sent in told:
            headers = [it.header for it in getattr(sent, "transforms", [sent])]
            for it in headers:
                stamp = m.nanoseconds(it.stamp) + seconds * 10**9
                whole, rest = divmod(stamp, 10**9)
                it.stamp = message(
                    "builtin_interfaces/msg/Time", sec=whole, nanosec=rest
                )
        moved.append((time + seconds, told))
    return moved


EPOCH = 1_700_000_000


def read_quietly(path, **topics):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ReadBag(path, **topics)


def test_times_since_1970_lose_no_digits(tmp_path):
    parts = [[(100.0, [joined(100.0)])], told_people(), odometry()]
    read = read_quietly(faulty(tmp_path, *(later(it, EPOCH) for it in parts)))
    np.testing.assert_allclose(np.diff(read.times), 0.1, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        read.robot[:, 0], 2 * np.sin(0.3 * read.times), atol=1e-12
    )


def test_simulated_times_may_begin_at_0(tmp_path):
    """In a bag that was recorded in real time."""
    people = [(EPOCH + t, told) for t, told in told_people()]
    robot = [(EPOCH + t, told) for t, told in odometry()]
    for _, [(_, told)] in (*people, *robot):
        stamp = m.nanoseconds(told.header.stamp) * 1e-9
        told.header.stamp = m.stamp(stamp - 100)
    frames = [(EPOCH + 99.9, [joined(0.0)])]
    read = read_quietly(faulty(tmp_path, frames, people, robot))
    np.testing.assert_allclose(read.times, np.arange(50) / HZ, atol=1e-9)
    np.testing.assert_allclose(
        read.robot[:, 0], 2 * np.sin(0.3 * read.times), atol=1e-9
    )


def test_a_first_stamp_of_0_before_a_clock_is_none(tmp_path):
    """As of a node that has not heard the time yet."""
    parts = [[(100.0, [joined(100.0)])], told_people(), odometry()]
    parts = [later(it, EPOCH) for it in parts]
    parts[1][0][1][0][1].header.stamp = m.stamp(0.0)
    read = read_quietly(faulty(tmp_path, *parts))
    assert read.times[[0, -1]].tolist() == pytest.approx([0, 4.9])
    np.testing.assert_allclose(
        read.robot[:, 0], 2 * np.sin(0.3 * read.times), atol=1e-9
    )


def test_times_since_1970_are_told_in_full(tmp_path):
    gap = [*odometry()[:10], *odometry()[60:]]
    parts = [[(100.0, [joined(100.0)])], told_people(), gap]
    path = faulty(tmp_path, *(later(it, EPOCH) for it in parts))
    words = r"no message from 1700000100\.45\d* s to 1700000103 s"
    with pytest.raises(ValueError, match=words):
        ReadBag(path)


def agents_at(k, frame="map", size=0.3, **fields):
    row = [0.5 * k / HZ, 1.0, 0.0, 0.5, 0.0, 0.0, size]
    told = m.agents(100 + k / HZ, [m.agent(row, id=3, **fields)], frame)
    return 100 + k / HZ, [("/human_states", told)]


def test_a_robot_of_hunavsim_is_moved_as_its_people(tmp_path):
    robot = m.agent([2.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.3], type=m.ROBOT)
    path = faulty(
        tmp_path,
        [(100.0, [joined(100.0, (10.0, 20.0, math.pi / 2))])],
        [agents_at(k, "odom", name="ana", behavior=1) for k in range(20)],
        [(100 + k / HZ, [("/robot_states", robot)]) for k in range(20)],
    )
    read = read_quietly(path)
    np.testing.assert_allclose(read.robot[0, :2], [5.0, 22.0])
    np.testing.assert_allclose(read.humans[0, 0, :2], [9.0, 20.0])


def map_at(frame="map", cell=0.05, x=0.0, cells=None):
    cells = np.zeros((20, 30), np.int8) if cells is None else cells
    info = message(
        "nav_msgs/msg/MapMetaData",
        resolution=cell,
        width=30,
        height=20,
        origin=m.pose(x, 0.0, 0.0),
    )
    header, data = m.header(100.0, frame), cells.ravel()
    kind = "nav_msgs/msg/OccupancyGrid"
    told = message(kind, header=header, info=info, data=data)
    return [(100.0, [("/map", told)])]


def test_a_robot_of_hunavsim_has_the_simulated_time_of_its_people(tmp_path):
    """As in a bag that was recorded without simulated time."""

    def robot(k):
        row = [0.2 * k / HZ, 5.0, 0.0, 0.2, 0.0, 0.0, 0.3]
        return m.agent(row, type=m.ROBOT)

    # The simulation runs at half of real time.
    people = [agents_at(k, name="ana", behavior=1) for k in range(20)]
    late = [(EPOCH + 2 * time, told) for time, told in people]
    robots = [
        (EPOCH + 2 * (100 + k / HZ) + 0.003, [("/robot_states", robot(k))])
        for k in range(-1, 21)
    ]
    read = read_quietly(faulty(tmp_path, late, robots))
    np.testing.assert_allclose(read.times, np.arange(20) / HZ, atol=1e-6)
    expected = 0.2 * (read.times - 0.0015)
    np.testing.assert_allclose(read.robot[1:-1, 0], expected[1:-1], atol=1e-6)


def test_headings_are_those_that_hunavsim_reads(tmp_path):
    """Its wrapper of Webots tells no orientation of the robot, that of Isaac
    Sim turns those of people."""
    robot = m.agent([2.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.3], type=m.ROBOT, id=0)
    robot.yaw = 2.5
    people = []
    for k in range(20):
        time, told = agents_at(k, name="ana", behavior=1)
        told[0][1].agents[0].yaw = -math.pi / 2
        people.append((time, told))
    path = faulty(
        tmp_path,
        [(100.0, [joined(100.0)])],
        people,
        [(100 + k / HZ, [("/robot_states", robot)]) for k in range(20)],
    )
    read = read_quietly(path)
    np.testing.assert_allclose(read.robot[:, 2], 2.5)
    np.testing.assert_allclose(read.humans[:, 0, 2], -math.pi / 2, rtol=1e-6)


def test_a_map_is_moved_from_its_frame(tmp_path):
    cells = np.zeros((20, 30), np.int8)
    cells[5, 7] = 100
    join = [(100.0, [joined(100.0, (10.0, 20.0, 0.0))])]
    parts = [join, told_people(), odometry()]
    for frame, known in (("odom", True), ("elsewhere", False)):
        path = tmp_path / frame / "n.mcap"
        write(path, in_order(*parts, map_at(frame, cells=cells)))
        with pytest.warns(UserWarning, match="the bag has") as caught:
            read = ReadBag(path)
        assert read.walls_known == known
        lacks = "no transforms from its map's frame 'elsewhere'"
        assert (lacks in str(caught[0].message)) != known
        if known:
            low = read.obstacles.segments.reshape(-1, 2).min(axis=0)
            np.testing.assert_allclose(low, [10.35, 20.25])


def test_a_map_without_known_cells_is_none(tmp_path):
    unknown = map_at(cells=np.full((20, 30), -1, np.int8))
    path = faulty(tmp_path, JOIN, told_people(), odometry(), unknown)
    with pytest.warns(UserWarning, match="no known cells on its map"):
        assert not ReadBag(path).walls_known


def changed(parts, number, change):
    """Returns messages of which one is changed."""
    ((_, sent),) = parts[number][1]
    change(sent)
    return parts


def set_pose(value):
    def change(sent):
        sent.pose.pose.position.x = value

    return change


@pytest.mark.slow
def test_numbers_out_of_range_are_told_with_their_message(tmp_path):
    parts = [told_people(), odometry()]
    at = "the message of topic"
    large = "which must be finite and at most 1e"
    far = changed(odometry(), 30, set_pose(math.inf))
    nobody = changed(odometry(), 30, set_pose(math.nan))
    lost = [(100.0, [joined(100.0, (math.nan, 0.0, 0.0))])]
    minus = [agents_at(k, size=-1.0) for k in range(20)]
    for number, (told, words) in enumerate(
        [
            ([JOIN, told_people(), far], f"{at} /odom at 101.5 s has x = inf"),
            ([JOIN, told_people(), nobody], f"x = nan, {large}"),
            ([lost, *parts], f"{at} /tf at 100 s has x = nan"),
            ([JOIN, *parts, map_at(cell=math.nan)], "cells of nan m"),
            ([JOIN, *parts, map_at(cell=1e30)], r"must be in \(0, 10\] m"),
            ([JOIN, *parts, map_at(x=math.nan)], f"{at} /map at 100 s has x"),
            ([JOIN, minus, odometry()], "radius = -1, which must not be neg"),
        ]
    ):
        path = tmp_path / str(number) / "n.mcap"
        write(path, in_order(*told))
        with pytest.raises(ValueError, match=words):
            ReadBag(path)


def test_frames_that_cannot_be_joined_are_told(tmp_path):
    twice = [
        (
            100.0 + k,
            [joined(100.0 + k, child="cam"), ("/tf", m.transforms(other))],
        )
        for k in range(3)
        for other in [m.transform(100.5 + k, "odom", "cam", (1.0, 0.0, 0.0))]
    ]
    for number, (parts, words) in enumerate(
        [
            ([twice, told_people(frame="cam")], "'cam' has two parents on /tf"),
            ([told_people(frame="")], r"without a frame \(header.frame_id\)"),
        ]
    ):
        path = tmp_path / str(number) / "n.mcap"
        write(path, in_order(JOIN, odometry(), *parts))
        with pytest.raises(ValueError, match=words):
            ReadBag(path)


def lacks_of(path):
    with pytest.warns(UserWarning, match="the bag has") as caught:
        ReadBag(path)
    return str(caught[0].message)


def test_transforms_that_come_seldom_are_told(tmp_path):
    slips = [
        (100.0 + k, [joined(100.0 + k, (0.1 * k, 0.0, 0.0))]) for k in (0, 1, 4)
    ]
    path = faulty(tmp_path, slips, told_people(), odometry())
    assert "no transforms of the frame 'odom' for up to 3 s" in lacks_of(path)


@pytest.mark.slow
def test_what_is_left_out_of_messages_is_told(tmp_path):
    doubled = [*told_people(30), *told_people(30)]
    nameless = told_people(names=("ana", ""))
    for number, (people, words) in enumerate(
        [
            (doubled, "30 messages of /people with the time of the one before"),
            (nameless, "no names of people, whom their places tell apart"),
            (
                [agents_at(k, name="eva") for k in range(20)],
                "no behaviors of HuNavSim for some people",
            ),
        ]
    ):
        path = tmp_path / str(number) / "n.mcap"
        write(path, in_order(JOIN, people, odometry()))
        assert words in lacks_of(path)
    assert read_quietly(tmp_path / "1").human_names == ("ana", "person_1")


def test_goals_of_others_are_not_the_robots(tmp_path):
    goals = [
        (101.0, [(topic, m.pose_stamped(101.0, "map", (1.0, 2.0, 0.0)))])
        for topic in ("/a/goal_pose", "/b/goal_pose")
    ]
    path = faulty(tmp_path, JOIN, told_people(), odometry(), goals)
    assert "no goal" in lacks_of(path)
    path = tmp_path / "one" / "n.mcap"
    write(path, in_order(JOIN, told_people(), odometry(), goals[:1]))
    assert read_quietly(path).goal == (1.0, 2.0, 0.0)


def test_robots_of_one_namespace_have_names(tmp_path):
    robot = m.agent([2.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.3], type=m.ROBOT)
    both = [
        (100 + k / HZ, [("/one", robot), ("/two", robot)]) for k in range(20)
    ]
    read = read_quietly(faulty(tmp_path, JOIN, told_people(), both))
    assert [it.robot_name for it in read.robots] == ["one", "two"]


def test_messages_that_lack_a_field_are_told(tmp_path):
    folder = tmp_path / "b"
    with rosbag2.Writer(
        folder, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP
    ) as bag:
        connections = {}
        for time, told in in_order(JOIN, told_people(), odometry()):
            for topic, sent in told:
                if topic not in connections:
                    connections[topic] = bag.add_connection(
                        topic, sent.__msgtype__, typestore=type_store()
                    )
                bag.write(connections[topic], round(time * 1e9), to_cdr(sent))
    path = folder / "b.mcap"
    data = path.read_bytes()
    path.write_bytes(data.replace(b" twist", b" twisd"))
    with pytest.raises(ValueError, match="/odom at 100 s has no field 'twist'"):
        ReadBag(path)


# What cannot be written.


@pytest.mark.slow
def test_a_scan_has_the_time_at_which_it_was_taken(tmp_path):
    """Of late and slow lidars, too: its points lie on the walls."""
    slow = "{type: lidar, num_rays: 30, period: 0.15, delay: 0.2}"
    scenario = LoadScenario(
        filename="free_run",
        overrides=["simulation.duration=4", f"sensors=[{slow}]"],
    )
    result = RunTrial(scenario)
    path = WriteBag(result, tmp_path / "a" / "a.mcap", scenario=scenario)
    told = result.recording
    walls = shapely.MultiLineString(
        list(told.obstacles.segments.reshape(-1, 2, 2))
    )
    taken = []
    with AnyReader([path.parent]) as reader:
        scans = [it for it in reader.connections if it.topic == "/scan"]
        for connection, _, data in reader.messages(scans):
            scan = reader.deserialize(data, connection.msgtype)
            time = m.nanoseconds(scan.header.stamp) * 1e-9
            taken.append(time)
            x, y, yaw = (
                np.interp(time, told.times, told.robot[:, i]) for i in range(3)
            )
            angles = yaw + scan.angle_min + np.arange(30) * scan.angle_increment
            hits = scan.ranges < scan.range_max
            points = shapely.points(
                x + (scan.ranges * np.cos(angles))[hits],
                y + (scan.ranges * np.sin(angles))[hits],
            )
            assert shapely.distance(points, walls).max() < 0.01
    np.testing.assert_allclose(taken, 0.15 * np.arange(len(taken)), atol=1e-9)
    assert len(taken) > 20


def test_lidars_have_frames_of_their_own():
    names = ("first", "laser", "rear")
    sensors = ", ".join(f"{{type: lidar, name: {it}}}" for it in names)
    scenario = LoadScenario(
        filename="free_run", overrides=[f"sensors=[{sensors}]"]
    )
    told = dict(TrialTopics(MakeTrialDiagram(scenario)).constants())
    frames = [it.child_frame_id for it in told["/tf_static"].transforms]
    assert frames == ["laser", "laser_scan", "rear"]


def test_names_of_topics_are_those_of_ros():
    assert m.ros_name("a b") == m.ros_name("a__b") == "a_b"
    assert m.ros_name("__x") == "r_x"
    assert m.ros_name("3") == "r_3"
    assert m.ros_name("") == ""


def test_recordings_that_messages_cannot_hold_are_told(crossing, tmp_path):
    told = crossing[1].recording
    early = dataclasses.replace(told, times=told.times - 1)
    late = dataclasses.replace(told, times=told.times + 3e9)
    close = dataclasses.replace(told, times=told.times * 1e-9)
    odd = dataclasses.replace(told, behavior_status=told.behavior_status + 300)
    twins = dataclasses.replace(
        told,
        robot_name="a b",
        others=(dataclasses.replace(told, robot_name="a_b"),),
    )
    for recording, words in (
        (early, r"must be in \[0, 2147483648\) s .* got -1 s"),
        (late, r"must be in \[0, 2147483648\) s"),
        (close, "at least 1 ns apart"),
        (odd, r"behavior_status must be in \[0, 255\]"),
        (twins, "the robots 'a b' and 'a_b' would both be 'a_b'"),
    ):
        with pytest.raises(ValueError, match=words):
            WriteBag(recording, tmp_path / "new" / "a.mcap")
    assert list(tmp_path.iterdir()) == []


def test_what_fails_leaves_no_folder(crossing, tmp_path, monkeypatch):
    def fails(sent):
        raise OSError("no space left")

    monkeypatch.setattr(write_bag, "to_cdr", fails)
    with pytest.raises(OSError, match="no space left"):
        WriteBag(crossing[1], tmp_path / "new" / "a.mcap")
    assert list(tmp_path.iterdir()) == []
