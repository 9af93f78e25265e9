"""Trials that another process drives, which knows them by DDS alone."""

import asyncio
import contextlib
import importlib.util
import itertools
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from tornado.websocket import websocket_connect

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialSimulator,
    ReadBag,
    RunBridge,
    RunTrial,
    SaveContext,
)
from hunav_drake.commands.cli import main
from hunav_drake.hunavsim.ros2.live import FoxgloveTopics, with_bridge
from hunav_drake.hunavsim.ros2.topics import TrialTopics
from hunav_drake.systems.planning import BridgePlanner
from hunav_drake.systems.planning.ros2 import DdsNode, messages as m
from hunav_drake.trial.diagram import MakeTrialDiagram

ROOT = Path(__file__).parents[3]

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("cyclonedds") is None,
    reason="no cyclonedds: it has no wheel for Python 3.14",
)

_NUMBERS = itertools.count()


@pytest.fixture
def domain(monkeypatch):
    """Sets a domain that no other test uses, and returns its number."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:]
    number = 100 + 30 * (int(worker) % 4) + next(_NUMBERS) % 30
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    return number


@contextlib.contextmanager
def driven(*scenario, fault=""):
    """Runs the planner of a scenario in a process that knows DDS alone."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.dds_planner", *scenario],
        cwd=ROOT,
        env={**os.environ, "HUNAV_TEST_FAULT": fault},
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def bridge(**settings):
    settings = {"command_type": "TwistStamped", "time_limit": 120.0} | settings
    return BridgePlanner(**settings)


SHORT = ["planner.type=dwb", "simulation.duration=4"]
LONG = [("house", "planner.type=dwb"), ("crossing", "planner.type=dwb")]


@pytest.mark.slow
def test_a_thousand_steps_are_those_of_one_process(domain):
    cycles = 0
    for scenario in LONG:
        alone = LoadScenario(filename=scenario[0], overrides=scenario[1:])
        expected = RunTrial(alone)
        with driven(*scenario):
            result = RunBridge(alone, bridge())
        assert result.recording == expected.recording
        assert result.end_reason == expected.end_reason == "goal"
        assert (result.metrics.dropna() == expected.metrics.dropna()).all()
        cycles += round(expected.end_time / alone.planner.period)
    assert cycles >= 1000


@pytest.mark.slow
def test_forks_and_files_go_on_as_in_one_process(domain, tmp_path):
    alone = LoadScenario(filename="crossing", overrides=SHORT)
    expected = RunTrial(alone).recording
    diagram = MakeTrialDiagram(with_bridge(alone, bridge()))
    port = diagram.GetOutputPort("robot_state")
    times = np.linspace(0.0, 3.8, 20).round(1)
    with driven("crossing", *SHORT):
        straight = MakeTrialSimulator(diagram)
        kept = []
        for k, now in enumerate(times):
            straight.AdvanceTo(now)
            context = straight.get_context()
            if k % 2:
                file = SaveContext(diagram, context, tmp_path / f"{k}.npz")
                kept.append(LoadContext(diagram, file))
            else:
                kept.append(context.Clone())
        straight.AdvanceTo(4.0)
        # (The other program goes back in time with each.)
        for now, context in zip(times, kept, strict=True):
            fork = MakeTrialSimulator(diagram, context)
            for later in (now + 0.1, 4.0):
                fork.AdvanceTo(later)
                sample = round(later / 0.1)
                np.testing.assert_array_equal(
                    port.Eval(fork.get_context()), expected.robot[sample]
                )
    np.testing.assert_array_equal(
        port.Eval(straight.get_context()), expected.robot[40]
    )


@pytest.mark.slow
def test_a_late_answer_changes_nothing(domain):
    alone = LoadScenario(
        filename="crossing",
        overrides=["planner.type=dwb", "simulation.duration=1"],
    )
    with driven("crossing", "planner.type=dwb", fault="late"):
        result = RunBridge(alone, bridge())
    assert result.recording == RunTrial(alone).recording


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("never", "no command on /cmd_vel within time_limit = 3 s"),
        pytest.param(
            *("nonsense", "a command on /cmd_vel is not finite: v = nan"),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            *("stale", "came for other times, the last for 0 s"),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_faulty_answer_is_a_planner_that_failed(domain, fault, words):
    scenario = LoadScenario(filename="crossing", overrides=SHORT)
    with driven("crossing", *SHORT, fault=fault):
        # (Its start may take longer than the limit.)
        diagram = MakeTrialDiagram(with_bridge(scenario, bridge()))
        Simulator(diagram).AdvanceTo(0.05)
        result = RunBridge(scenario, bridge(time_limit=3.0))
    assert result.end_reason == "planner_failed"
    assert words in result.end_message
    assert "planner 'bridge' failed at t = 0." in result.end_message


def test_nobody_who_answers_is_told(domain):
    scenario = LoadScenario(filename="crossing", overrides=SHORT)
    result = RunBridge(scenario, bridge(time_limit=0.5))
    assert result.end_reason == "planner_failed"
    assert (
        f"nobody publishes /cmd_vel on DDS domain {domain}, network lo"
        in result.end_message
    )


@pytest.mark.slow
def test_the_other_program_may_be_started_anew(domain):
    """Killed after a second of the trial, another one takes over."""
    scenario = LoadScenario(filename="crossing", overrides=SHORT)
    diagram = MakeTrialDiagram(with_bridge(scenario, bridge()))
    simulator = Simulator(diagram)
    with driven("crossing", *SHORT) as first:
        simulator.AdvanceTo(1.0)
        first.send_signal(signal.SIGKILL)
        first.wait()
    with contextlib.ExitStack() as stack:
        # It comes while the trial waits.
        later = threading.Timer(
            1.0, lambda: stack.enter_context(driven("crossing", *SHORT))
        )
        later.start()
        simulator.AdvanceTo(2.0)
        later.join()
    state = diagram.GetOutputPort("robot_state").Eval(simulator.get_context())
    assert np.isfinite(state).all()
    assert simulator.get_context().get_time() == 2.0


@pytest.mark.slow
def test_real_time_takes_the_last_command(domain):
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=3", "humans=[]"]
    )
    node = DdsNode()
    node.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    stop = threading.Event()

    def drive():
        while not stop.wait(0.02):
            node.publish("/cmd_vel", m.twist(0.3, 0.0, 0.0))

    thread = threading.Thread(target=drive)
    thread.start()
    told = []
    started = time.monotonic()
    try:
        result = RunBridge(
            scenario, BridgePlanner(lockstep=False), tell=told.append
        )
    finally:
        stop.set()
        thread.join()
    assert time.monotonic() - started > 2.5
    robot = result.recording.robot
    assert np.hypot(robot[-1, 3], robot[-1, 4]) == pytest.approx(0.3, abs=1e-3)


def test_a_trial_that_falls_behind_real_time_says_so(domain):
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=1", "humans=[]"]
    )
    told = []

    def slow(seconds):
        time.sleep(0.08)

    planner = BridgePlanner(lockstep=False)
    RunBridge(scenario, planner, tell=told.append, progress=slow)
    # (Each 5 s at most; a slow machine may tell it again.)
    assert re.fullmatch(
        r"at [\d.]+ s the trial is [\d.]+ s behind real time", told[0]
    )
    assert len(told) < 10


def test_without_commands_the_robot_stops(domain):
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=2", "humans=[]"]
    )
    planner = BridgePlanner(lockstep=False, hold_time=0.3)
    diagram = MakeTrialDiagram(with_bridge(scenario, planner))
    port = diagram.GetOutputPort("velocity_command")
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1)
    node = DdsNode()
    node.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    end = time.monotonic() + 20
    while not node.num_readers("/cmd_vel"):
        assert time.monotonic() < end
        time.sleep(0.01)
    node.publish("/cmd_vel", m.twist(0.4, 0.0, 0.1))
    time.sleep(0.3)
    speeds = []
    for now in np.arange(0.2, 1.0, 0.1):
        simulator.AdvanceTo(now)
        speeds.append(port.Eval(simulator.get_context())[0])
    held = speeds.count(0.4)
    assert held in (3, 4)
    assert speeds == [0.4] * held + [0.0] * (len(speeds) - held)


@pytest.mark.slow
def test_what_is_published(domain):
    """Maps and frames are there for those who come late; people have names."""
    scenario = LoadScenario(
        filename="crossing",
        overrides=[
            "simulation.duration=2",
            "sensors=[{type: lidar}, {type: lidar, name: rear}]",
        ],
    )
    node = DdsNode()
    kinds = {
        "/human_states": "hunav_msgs/msg/Agents",
        "/robot_states": "hunav_msgs/msg/Agent",
        "/people": "people_msgs/msg/People",
        "/markers": "visualization_msgs/msg/MarkerArray",
        "/odom": "nav_msgs/msg/Odometry",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/rear/scan": "sensor_msgs/msg/LaserScan",
        "/clock": "rosgraph_msgs/msg/Clock",
        "/goal_pose": "geometry_msgs/msg/PoseStamped",
    }
    readers = {it: node.subscribe(it, kind) for it, kind in kinds.items()}
    latched = {"/map": "nav_msgs/msg/OccupancyGrid", "/tf_static": kinds["/tf"]}
    for topic, kind in latched.items():
        readers[topic] = node.subscribe(topic, kind, latched=True)
    RunBridge(scenario, BridgePlanner(lockstep=False))
    told = {topic: reader.take() for topic, reader in readers.items()}
    assert all(told.values()), [it for it, got in told.items() if not got]
    names = [it.name for it in told["/human_states"][-1].agents]
    assert names == ["ana", "luis", "marta", "pablo"]
    frames = {it.child_frame_id for it in told["/tf_static"][-1].transforms}
    assert frames == {"laser", "rear"}
    stamps = [m.nanoseconds(it.clock) for it in told["/clock"]]
    assert stamps == sorted(stamps)
    # Each instant of the clock is told once.
    assert len(set(stamps)) == len(stamps)
    goal = told["/goal_pose"][0].pose.position
    assert (goal.x, goal.y) == scenario.robot.goal[:2]


def test_a_namespace_is_before_all_topics_of_the_robot(domain):
    sensors = "[{type: lidar}, {type: lidar, name: rear}]"
    scenario = LoadScenario(
        filename="crossing",
        overrides=["simulation.duration=1", f"sensors={sensors}"],
    )
    node = DdsNode()
    scan, agent = "sensor_msgs/msg/LaserScan", "hunav_msgs/msg/Agent"
    first, rear = (
        node.subscribe(f"/bob/{it}", scan) for it in ("scan", "rear/scan")
    )
    robot = node.subscribe("/bob/robot_states", agent)
    moving = node.subscribe("/tf", "tf2_msgs/msg/TFMessage")
    fixed = node.subscribe("/tf_static", "tf2_msgs/msg/TFMessage", latched=True)
    RunBridge(scenario, BridgePlanner(lockstep=False, namespace="bob"))
    assert robot.take()
    parents = {
        it.child_frame_id: it.header.frame_id
        for told in (moving.take()[-1], fixed.take()[-1])
        for it in told.transforms
    }
    for reader in (first, rear):
        frame = reader.take()[-1].header.frame_id
        assert parents[frame] == "bob/base_link"
    assert parents["bob/base_link"] == "bob/odom"


def test_a_goal_may_be_changed(domain):
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=3", "humans=[]"]
    )
    node = DdsNode()
    kind = "geometry_msgs/msg/PoseStamped"
    node.advertise("/goal_pose", kind)
    clock = node.subscribe("/clock", "rosgraph_msgs/msg/Clock")
    start = scenario.robot.start

    def change():
        end = time.monotonic() + 60
        while not clock.take() and time.monotonic() < end:
            time.sleep(0.01)
        node.publish("/goal_pose", m.pose_stamped(0.0, "map", start))

    thread = threading.Thread(target=change)
    thread.start()
    result = RunBridge(scenario, BridgePlanner(lockstep=False))
    thread.join()
    # The robot stands where it starts: at the new goal.
    assert result.end_reason == "goal"
    assert result.end_time < 2.5


POSE = "geometry_msgs/msg/PoseStamped"


def alone(*overrides):
    return LoadScenario(
        filename="crossing",
        overrides=["simulation.duration=1", "humans=[]", *overrides],
    )


def reader_of_clocks(node):
    return node.subscribe("/clock", "rosgraph_msgs/msg/Clock")


@contextlib.contextmanager
def beside(do, clock):
    """Does something in a thread as soon as a trial runs."""

    def wait():
        end = time.monotonic() + 60
        while not clock.take() and time.monotonic() < end:
            time.sleep(0.01)
        do()

    thread = threading.Thread(target=wait)
    thread.start()
    try:
        yield
    finally:
        thread.join()


@pytest.mark.parametrize(
    ("frame", "at", "words"),
    [
        ("base_link", (1.0, 0.0, 0.0), "is in the frame 'base_link'; send it"),
        ("map", (np.nan, 0.0, 0.0), "must be a finite number, got nan"),
        ("map", (1e300, 0.0, 0.0), "must be in [-100000, 100000] m, got 1e+30"),
    ],
)
def test_a_goal_that_cannot_be_taken_is_told(domain, frame, at, words):
    scenario = alone()
    node = DdsNode()
    node.advertise("/goal_pose", POSE)

    def change():
        for _ in range(3):
            node.publish("/goal_pose", m.pose_stamped(0.0, frame, at))

    told = []
    with beside(change, reader_of_clocks(node)):
        result = RunBridge(
            scenario, BridgePlanner(lockstep=False), tell=told.append
        )
    (line,) = [it for it in told if "behind" not in it]
    assert line.startswith("the goal on /goal_pose is not taken: ")
    assert words in line
    assert result.recording.goal == scenario.robot.goal


def test_a_goal_of_who_begins_to_read_goals_counts(domain):
    """The trial tells its own goal then, which is nobody's new one."""
    node = DdsNode()
    node.advertise("/goal_pose", POSE)
    kept = []

    def change():
        kept.append(node.subscribe("/goal_pose", POSE))
        node.publish("/goal_pose", m.pose_stamped(0.0, "odom", (1, 2, 0)))

    with beside(change, reader_of_clocks(node)):
        result = RunBridge(alone(), BridgePlanner(lockstep=False))
    assert result.recording.goal == (1.0, 2.0, 0.0)


@pytest.mark.slow
def test_a_command_for_the_trial_before_moves_no_robot(domain):
    planner = BridgePlanner(lockstep=False)
    node = DdsNode()
    node.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    RunBridge(alone(), planner)
    node.publish("/cmd_vel", m.twist(0.5, 0.0, 0.0))
    time.sleep(0.3)
    result = RunBridge(alone(), planner)
    robot = result.recording.robot
    np.testing.assert_array_equal(robot[-1, :2], robot[0, :2])
    assert "the planner: no command comes on /cmd_vel" in result.end_message


@pytest.mark.parametrize("lockstep", [True, False])
def test_commands_of_another_type_are_told(domain, lockstep):
    node = DdsNode()
    node.advertise("/cmd_vel", "geometry_msgs/msg/TwistStamped")
    planner = BridgePlanner(lockstep=lockstep, time_limit=0.5)
    result = RunBridge(alone(), planner)
    assert (
        "/cmd_vel is published as geometry_msgs/msg/TwistStamped, not as"
        " geometry_msgs/msg/Twist; choose the other command_type"
        in result.end_message
    )


@pytest.mark.slow
def test_a_slow_answer_without_a_stamp_is_not_asked_for_again(domain):
    """Else the second one would count for the next cycle."""
    node = DdsNode()
    node.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    asked = node.subscribe("/observation", "hunav_msgs/msg/Agents")
    stop = threading.Event()

    def answer():
        while not stop.wait(0.01):
            for told in asked.take():
                time.sleep(1.3)
                stamp = m.nanoseconds(told.header.stamp) * 1e-9
                node.publish("/cmd_vel", m.twist(0.0, 0.0, stamp))

    diagram = MakeTrialDiagram(
        with_bridge(alone(), BridgePlanner(time_limit=60.0))
    )
    port = diagram.GetOutputPort("velocity_command")
    simulator = Simulator(diagram)
    thread = threading.Thread(target=answer)
    thread.start()
    commands = []
    try:
        for k in range(4):
            simulator.AdvanceTo(0.05 * k)
            commands.append(port.Eval(simulator.get_context())[1])
    finally:
        stop.set()
        thread.join()
    # (The first one is that of the instant 0, before its update is seen.)
    assert commands == pytest.approx([0.0, 0.0, 0.05, 0.1])


@pytest.mark.slow
@pytest.mark.parametrize("run", [RunBridge, RunTrial])
def test_an_interrupt_ends_the_wait_for_a_command(domain, run):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    scenario = with_bridge(alone(), bridge())
    options = {"planner": bridge()} if run is RunBridge else {}
    if run is RunTrial:
        options["on_planner_error"] = "raise"
    timer = threading.Timer(3.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    started = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            run(scenario, **options)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - started < 30


OTHER = """
import time
from hunav_drake.systems.planning.ros2 import DdsNode, message
node = DdsNode()
node.advertise("/observation", "hunav_msgs/msg/Agents")
print("ready", flush=True)
while True:
    time.sleep(0.02)
    if {runs}:
        node.publish("/observation", message("hunav_msgs/msg/Agents"))
"""


@pytest.mark.slow
@pytest.mark.parametrize("runs", [True, False])
def test_another_trial_with_the_same_topics_is_told(domain, runs):
    """Both would get the same commands; one that does not run, none."""
    other = subprocess.Popen(
        [sys.executable, "-c", OTHER.format(runs=runs)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
    )
    try:
        assert other.stdout.readline() == b"ready\n"
        result = RunBridge(alone(), BridgePlanner(lockstep=False))
    finally:
        other.kill()
        other.communicate()
    assert result.end_reason == ("planner_failed" if runs else "timeout")
    words = f"another trial publishes /observation on DDS domain {domain}"
    assert (words in result.end_message) == runs


def test_a_wrong_configuration_of_dds_is_named(domain, monkeypatch):
    monkeypatch.setenv("CYCLONEDDS_URI", "<nonsense")
    with pytest.raises(ValueError, match="CYCLONEDDS_URI names, '<nonsense'"):
        RunBridge(alone(), bridge())


def test_a_lidar_that_the_trial_adds_has_its_frame(domain):
    scenario = alone("planner.sees=lidar")
    diagram = MakeTrialDiagram(with_bridge(scenario, bridge()))
    told = dict(TrialTopics(diagram).constants())
    (mount,) = told["/tf_static"].transforms
    assert mount.child_frame_id == "laser"


def test_a_robot_needs_a_goal():
    scenario = LoadScenario(filename="passing", overrides=["robot.goal=null"])
    with pytest.raises(ValueError, match="has no goal, so its planner"):
        RunBridge(scenario)


def test_robots_that_share_topics_are_told(domain):
    scenario = LoadScenario(
        filename="elevator_lobby", overrides=["simulation.duration=1"]
    )
    for member in scenario.robots:
        member.planner = BridgePlanner(lockstep=False, namespace="both")
    result = RunTrial(scenario)
    assert result.end_reason == "planner_failed"
    assert "have the same topics; give their planners" in result.end_message


@pytest.mark.slow
@pytest.mark.parametrize("whole", [True, False], ids=["bridge", "run"])
def test_several_robots_have_their_names_before_topics(domain, whole):
    scenario = LoadScenario(
        filename="elevator_lobby", overrides=["simulation.duration=2"]
    )
    names = [it.name for it in scenario.robots]
    node = DdsNode()
    kind = "hunav_msgs/msg/Agents"
    readers = {it: node.subscribe(f"/{it}/observation", kind) for it in names}
    if whole:
        RunBridge(scenario, BridgePlanner(lockstep=False))
    else:
        # Nor do planners of the scenario share topics.
        for member in scenario.robots:
            member.planner = BridgePlanner(lockstep=False)
        RunTrial(scenario)
    for reader in readers.values():
        told = reader.take()
        # People, and the other robot.
        assert len(told[-1].agents) == len(scenario.humans) + 2


def test_the_command_tells_what_fails(domain, capsys):
    options = ["bridge", "passing", "--set", "simulation.duration=1"]
    assert main([*options, "--time-limit", "0.3"]) == 1
    told = capsys.readouterr().err
    assert "hunav: planner 'bridge' failed at t = 0.000 s: nobody" in told
    assert main([*options, "--network", "nope"]) == 2
    assert "there is no network interface 'nope'" in capsys.readouterr().err
    assert main([*options, "--time-limit", "0"]) == 2
    assert "time_limit: must be in (0, 3600] s" in capsys.readouterr().err
    assert main([*options, "--time-limit", "3", "--real-time"]) == 2
    told = capsys.readouterr().err
    assert "--time-limit does not go with --real-time" in told


@pytest.mark.slow
def test_the_command_drives(domain, capsys, tmp_path):
    options = ["--stamped", "--time-limit", "120", "--out", str(tmp_path)]
    with driven("passing", "planner.type=dwb"):
        assert main(["bridge", "passing", *options]) == 0
    assert "Wrote the run to" in capsys.readouterr().out
    run = tmp_path / "runs" / "passing_bridge_0"
    scenario = LoadScenario(filename=run / "scenario.yaml")
    assert isinstance(scenario.planner, BridgePlanner)
    # To export it, the other program is not asked again.
    assert main(["export", str(run)]) == 0
    assert "another program drove" in capsys.readouterr().err
    assert ReadBag(run / "bag").times[-1] == pytest.approx(27.3)


# Foxglove.


def test_foxglove_gets_the_topics():
    scenario = LoadScenario(filename="passing")
    diagram = MakeTrialDiagram(scenario)
    topics = FoxgloveTopics(diagram, 0)

    async def told():
        """Returns what the server tells of its channels."""
        client = await websocket_connect(
            topics.address, subprotocols=["foxglove.sdk.v1"]
        )
        text = ""
        while "/human_states" not in text:
            got = await asyncio.wait_for(client.read_message(), 20)
            assert got is not None
            text += got if isinstance(got, str) else ""
        client.close()
        return text

    try:
        with pytest.raises(OSError, match="cannot be used"):
            FoxgloveTopics(diagram, int(topics.address.rpartition(":")[2]))
        topics.Publish(diagram.CreateDefaultContext())
        text = asyncio.run(told())
    finally:
        topics.Close()
    assert "hunav_msgs/msg/Agents" in text
    assert "ros2msg" in text


def test_the_command_shows_a_trial_in_foxglove(capsys):
    options = ["--set", "simulation.duration=1", "--quiet"]
    main(["run", "passing", "--foxglove", "0", *options])
    assert "Open the connection ws://127.0.0.1:" in capsys.readouterr().out
    assert main(["run", "passing", "--foxglove", "--meshcat"]) == 2
    assert "--foxglove does not go with --meshcat" in capsys.readouterr().err
