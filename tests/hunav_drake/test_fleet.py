"""Several robots in one trial, each with its own planner."""

import itertools
import math

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    PlannerError,
    ReadRecording,
    RunTrial,
    SaveContext,
    SaveScenario,
    ScenarioError,
    SetTrialSeed,
    TransferContext,
)
from hunav_drake.systems.common.layout import RADIUS, X, Y
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.planning import (
    PLANNERS,
    Plan,
    PlannerStatus,
    register_plan,
)

PEOPLE = """
humans:
- {pose: [0, 2, 0], goals: [[0, -3], [0, 3]]}
- {pose: [2, 2, 0], goals: [[-2, -3], [2, 3]], behavior: curious}
"""
ANNA = """
- name: anna
  robot: {start: [-4, 0, 0], goal: [4, 0.3, 0]}
  planner: {type: dwb, sees: lidar}
  sensors: [{type: lidar, noise: 0.02, num_rays: 90}]
"""
BOB = """
- name: bob
  robot: {start: [0.5, -4, 1.57], goal: [0, 4, 1.57]}
  planner: {type: orca, sees: visible}
"""
CLEO = """
- name: cleo
  robot: {type: pmb2, start: [4, -0.2, 3.14], goal: [-4, -0.4, 3.14]}
  planner: pursuit
"""


@pytest.fixture
def own_planners(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


def fleet(*robots, people=PEOPLE, duration=6, more=""):
    text = "robots:" + "".join(robots) + people
    text += f"simulation: {{duration: {duration}}}\n{more}"
    return LoadScenario(data=text, ways=False)


def states(diagram, context):
    ports = ("robot_states", "human_states", "trial_status", "robot_ends")
    return np.concatenate(
        [diagram.GetOutputPort(p).Eval(context) for p in ports]
    )


def least_gaps(recording):
    """Returns the least gap of each pair of robots, in meters."""
    return [
        float(
            np.min(
                np.hypot(*(a.robot[:, [X, Y]] - b.robot[:, [X, Y]]).T)
                - a.robot[:, RADIUS]
                - b.robot[:, RADIUS]
            )
        )
        for a, b in itertools.combinations(recording.robots, 2)
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "robots", [(ANNA, BOB), (ANNA, CLEO), (BOB, ANNA, CLEO)]
)
def test_their_order_does_not_matter(robots):
    found = [RunTrial(fleet(*it)) for it in (robots, robots[::-1])]
    paths = [
        {it.robot_name: it.robot for it in result.recording.robots}
        for result in found
    ]
    assert paths[0].keys() == paths[1].keys()
    for name, path in paths[0].items():
        np.testing.assert_allclose(path, paths[1][name], atol=1e-9)
        assert np.ptp(path[:, [X, Y]], axis=0).max() > 0.5
    np.testing.assert_allclose(
        found[0].recording.humans, found[1].recording.humans, atol=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["differential_drive", "pmb2"])
def test_a_list_of_one_robot_is_the_short_form(kind):
    robot = f"robot: {{type: {kind}, start: [-4, 0, 0], goal: [4, 0, 0]}}"
    rest = f"{PEOPLE}simulation: {{duration: 3}}\n"
    short = LoadScenario(data=f"{robot}\nplanner: orca\n{rest}")
    listed = LoadScenario(
        data=f"robots:\n- name: anna\n  {robot}\n  planner: orca\n{rest}"
    )
    one, other = RunTrial(short).recording, RunTrial(listed).recording
    np.testing.assert_array_equal(one.robot, other.robot)
    np.testing.assert_array_equal(one.humans, other.humans)
    np.testing.assert_array_equal(one.contacts, other.contacts)


@pytest.mark.parametrize("seed", range(5))
def test_kinematic_robots_never_overlap(own_planners, seed):
    @register_plan("ahead")
    def ahead(task, view, memory):
        return Plan(1.0, 0.0, PlannerStatus.DRIVING)

    rng = np.random.default_rng(seed)
    robots = []
    for i in range(6):
        angle = math.tau * i / 6 + rng.uniform(-0.2, 0.2)
        x, y = 3 * math.cos(angle), 3 * math.sin(angle)
        yaw = math.remainder(angle + math.pi + rng.uniform(-0.2, 0.2), math.tau)
        radius = rng.uniform(0.2, 0.5)
        robots.append(
            f"\n- name: r{i}\n  robot: {{start: [{x}, {y}, {yaw}],"
            f" goal: [9, 9, 0], radius: {radius}}}\n  planner: ahead"
        )
    walls = (
        "\nworld: {walls: [{type: box, center: [0.3, 0], size: [1, 0.2]}]}\n"
    )
    result = RunTrial(fleet(*robots, people=walls))
    assert min(least_gaps(result.recording)) > -1e-9
    # They came close, and touched.
    assert min(least_gaps(result.recording)) < 0.02
    assert result.metrics["contacts_between_robots"] > 0


@pytest.mark.slow
def test_physical_robots_are_bodies_for_each_other_and_for_kinematic_ones():
    stands = "\n- name: post\n  robot: {start: [1, 0, 0]}"
    drives = (
        "\n- name: NAME\n  robot: {type: pmb2, start: [X, 0.02, YAW], goal:"
        " [0, 9, 0]}\n  planner: ahead"
    )
    left, right = (
        drives.replace("NAME", name).replace("X", x).replace("YAW", yaw)
        for name, x, yaw in (("left", "-1", "0"), ("right", "3", "3.14159"))
    )
    PLANNERS_BEFORE = dict(PLANNERS._choices)
    try:

        @register_plan("ahead")
        def ahead(task, view, memory):
            return Plan(0.5, 0.0, PlannerStatus.DRIVING)

        # Both are stopped by the kinematic one, which stands.
        held = RunTrial(fleet(left, right, stands, people="\n", duration=5))
        assert min(least_gaps(held.recording)) > -0.02
        x = [it.robot[-1, X] for it in held.recording.robots]
        assert x[0] == pytest.approx(1 - 0.62, abs=0.1)
        assert x[1] == pytest.approx(1 + 0.62, abs=0.1)
        # They push each other to a stop.
        met = RunTrial(fleet(left, right, people="\n", duration=5))
        assert min(least_gaps(met.recording)) > -0.02
        assert met.metrics["contacts_between_robots"] >= 1
        assert abs(met.recording.robots[0].robot[-1, X] - 0.73) < 0.25
    finally:
        PLANNERS._choices.clear()
        PLANNERS._choices.update(PLANNERS_BEFORE)


@pytest.mark.slow
@pytest.mark.parametrize("instants", [20])
def test_forks_and_files_go_on_bit_for_bit(tmp_path, instants):
    mppi = BOB.replace("orca", "mppi, batch_size: 100")
    check_forks(fleet(ANNA, mppi, CLEO, duration=11), instants, tmp_path)


def test_a_fork_goes_on_bit_for_bit(tmp_path):
    check_forks(fleet(ANNA, BOB, CLEO, duration=3), 2, tmp_path)


def check_forks(scenario, instants, folder):
    diagram = MakeTrialDiagram(scenario)
    duration = scenario.simulation.duration
    simulator = MakeTrialSimulator(diagram)
    forks = []
    for k in range(instants):
        simulator.AdvanceTo((k + 0.5) * duration / instants)
        context = simulator.get_context()
        SaveContext(diagram, context, folder / "context.npz")
        forks += [context.Clone(), LoadContext(diagram, folder / "context.npz")]
        forks.append(TransferContext(diagram, context, diagram))
    simulator.AdvanceTo(duration)
    expected = states(diagram, simulator.get_context())
    for fork in forks:
        own = MakeTrialSimulator(diagram, fork)
        own.AdvanceTo(duration)
        np.testing.assert_array_equal(
            states(diagram, own.get_context()), expected
        )


@pytest.mark.slow
def test_states_of_robots_in_another_order_are_refused(tmp_path):
    """They would be those of the other robot."""
    bob = BOB.replace("{type: orca, sees: visible}", "stand")
    eve = bob.replace("bob", "eve").replace("[0.5, -4", "[2.5, -4")
    diagram = MakeTrialDiagram(fleet(bob, eve))
    other = MakeTrialDiagram(fleet(eve, bob))
    context = diagram.CreateDefaultContext()
    with pytest.raises(ValueError, match=r"robots\[0\]: it was 'bob', and is"):
        TransferContext(diagram, context, other)
    file = SaveContext(diagram, context, tmp_path / "context.npz")
    with pytest.raises(
        ValueError, match=r"bob.*in the file, .*eve.*in the dia"
    ):
        LoadContext(other, file)


@pytest.mark.slow
def test_another_planner_of_one_robot_takes_over():
    diagram = MakeTrialDiagram(fleet(ANNA, BOB))
    other = MakeTrialDiagram(fleet(ANNA, BOB.replace("orca", "sfm")))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(2)
    fork = TransferContext(diagram, simulator.get_context(), other)
    np.testing.assert_array_equal(
        states(other, fork), states(diagram, simulator.get_context())
    )
    for prefix in ("anna", "bob"):
        port = f"{prefix}_velocity_command"
        np.testing.assert_array_equal(
            other.GetOutputPort(port).Eval(fork),
            diagram.GetOutputPort(port).Eval(simulator.get_context()),
        )
    MakeTrialSimulator(other, fork).AdvanceTo(4)
    cleo = MakeTrialDiagram(fleet(ANNA, CLEO))
    with pytest.raises(ValueError, match="robot bob"):
        TransferContext(other, fork, cleo)


@pytest.mark.slow
def test_a_seed_set_later_is_that_of_a_new_diagram():
    scenario = fleet(*(ANNA, BOB, CLEO), more="", people=PEOPLE, duration=3)
    scenario.simulation.start_jitter = 0.2
    diagram = MakeTrialDiagram(scenario)
    first = RunTrial(scenario, 1, diagram=diagram).recording
    scenario.simulation.seed = 1
    assert RunTrial(scenario).recording == first
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, 2)
    second = RunTrial(scenario, 2).recording
    np.testing.assert_array_equal(
        diagram.GetOutputPort("human_states").Eval(context),
        second.humans[0].ravel(),
    )
    assert not np.array_equal(first.humans[0], second.humans[0])


@pytest.mark.slow
def test_each_robot_ends_for_itself_and_the_trial_with_the_last():
    near = ANNA.replace("[4, 0.3, 0]", "[-2.5, 0, 0]")
    result = RunTrial(fleet(near, BOB, duration=40))
    ends = dict(result.robot_ends)
    assert ends == {"anna": "goal", "bob": "goal"}
    assert result.end_reason == "goal"
    times = {
        it.robot_name: result.metrics[f"{it.robot_name}.time_to_reach_goal"]
        for it in result.recording.robots
    }
    for robot in result.recording.robots:
        assert robot.end_time == pytest.approx(
            times[robot.robot_name], abs=0.1 + 1e-9
        )
        own = robot.until_end()
        assert own.times[-1] == pytest.approx(robot.end_time, abs=0.1)
        np.testing.assert_array_equal(
            result.steps.index[
                result.steps[f"{robot.robot_name}.final_dist_to_target"].notna()
            ],
            own.times,
        )
    assert times["anna"] < times["bob"] - 3
    assert result.end_time == pytest.approx(times["bob"], abs=0.1)
    assert result.metrics["makespan"] == times["bob"]
    assert result.metrics["sum_of_costs"] == sum(times.values())
    # A robot that is pushed or drives on after its end changes nothing of it.
    alone = {k: v for k, v in result.metrics.items() if k.startswith("anna.")}
    assert alone["anna.completed"] == 1


@pytest.mark.slow
def test_a_planner_that_fails_stops_its_robot_alone(own_planners):
    @register_plan("breaks")
    def breaks(task, view, memory):
        if view.robot[X] > -3.5:
            raise RuntimeError("a wheel came off")
        return Plan(0.5, 0.0, PlannerStatus.DRIVING)

    broken = ANNA.replace("{type: dwb, sees: lidar}", "breaks")
    result = RunTrial(fleet(broken, BOB, duration=40))
    assert result.robot_ends == {"anna": "planner_failed", "bob": "goal"}
    assert result.end_reason == "planner_failed"
    assert "a wheel came off" in result.end_message
    assert "anna: planner_failed after 1.35 s" in result.end_message
    anna = result.recording.robots[0]
    after = anna.robot[anna.times > anna.end_time + 1.0]
    assert len(after) > 50
    assert np.ptp(after[:, X]) == 0


def test_of_several_planners_that_fail_the_first_is_told(own_planners):
    class Breaks(RuntimeError):
        pass

    for name, at in (("late", -2.0), ("early", -3.5)):

        def breaks(task, view, memory, name=name, at=at):
            if view.robot[X] > at:
                raise Breaks(f"{name} has broken")
            return Plan(0.5, 0.0, PlannerStatus.DRIVING)

        register_plan(name)(breaks)
    first = ANNA.replace("{type: dwb, sees: lidar}", "late")
    second = ANNA.replace("{type: dwb, sees: lidar}", "early")
    second = second.replace("anna", "carl").replace("-4, 0", "-4, 3")
    with pytest.raises(PlannerError, match=r"carl.* at t = .*early has broken"):
        RunTrial(fleet(first, second, duration=40), on_planner_error="raise")


def test_stuck_robots_say_who_is_in_the_way():
    robots = [
        ANNA.replace("dwb, sees: lidar", "pursuit").replace("0.3", "0"),
        "\n- name: post\n  robot: {start: [0, 0, 0]}",
    ]
    scenario = fleet(*robots, people="\n", duration=30)
    scenario.simulation.stuck_time = 5.0
    result = RunTrial(scenario)
    assert result.robot_ends["anna"] == "stuck"
    assert "blocked by robot post" in result.end_message


def test_metrics_have_the_names_of_the_robots(tmp_path):
    result = RunTrial(fleet(ANNA, BOB, duration=2))
    named = [it.split(".") for it in result.metrics.index if "." in it]
    both = [[name for r, name in named if r == it] for it in ("anna", "bob")]
    assert both[0] == both[1]
    for robot in result.recording.robots:
        mine = RunTrial.__globals__["MakeTrialResult"](
            robot, provenance={}, end_reason="timeout"
        )
        for name, value in mine.metrics.items():
            np.testing.assert_equal(
                result.metrics[f"{robot.robot_name}.{name}"], value
            )
    assert result.metrics.attrs["units"]["bob.path_length"] == "m"
    assert set(result.by_behavior.columns) >= {"anna.path_length"}
    result.recording.save(tmp_path / "recording.npz")
    assert Recording.load(tmp_path / "recording.npz") == result.recording
    assert ReadRecording(tmp_path / "recording.npz") == result.recording


def test_a_planner_sees_the_other_robot_as_it_sees_people(own_planners):
    seen = []

    @register_plan("looks")
    def looks(task, view, memory):
        seen.append(view)
        return Plan(0.0, 0.0, PlannerStatus.IDLE)

    def views(sees, wall):
        seen.clear()
        box = f"{{type: box, center: {wall}, size: [0.2, 3]}}"
        world = f"\nworld: {{walls: [{box}]}}\n"
        watcher = ANNA.replace(
            "{type: dwb, sees: lidar}", f"{{type: looks, sees: {sees}}}"
        )
        watcher = watcher.replace("noise: 0.02, ", "")
        post = "\n- name: post\n  robot: {start: [0, 0, 0], radius: 0.3}"
        RunTrial(fleet(watcher, post, people=world, duration=0.1))
        return seen[-1]

    assert views("everything", [-2, 0]).humans[0, X] == 0
    assert views("visible", [-2, 9]).humans[0, X] == 0
    assert abs(views("visible", [-2, 0]).humans[0, X]) > 100
    assert views("lidar", [-2, 9]).humans.shape == (0, 7)
    scan = views("lidar", [-2, 9]).scan
    assert np.nanmin(scan) == pytest.approx(3.7, abs=0.01)
    assert np.nanmin(views("lidar", [-2, 0]).scan) == pytest.approx(
        1.9, abs=0.01
    )


def faults(text):
    with pytest.raises(ScenarioError) as caught:
        LoadScenario(data=text)
    return {it.path: it.message for it in caught.value.faults}


def test_faults_have_their_places(own_planners):
    @register_plan("scans", scan_size=90)
    def scans(task, view, memory):
        return Plan(0.0, 0.0, PlannerStatus.IDLE)

    twin = ANNA.replace("[-4, 0, 0]", "[-3.8, 0, 0]")
    found = faults(f"robots:{ANNA}{twin}{PEOPLE}")
    assert "already the name of robots[0]" in found["robots[1] ('anna').name"]
    assert (
        "overlaps 'anna' (robots[0]) by 0.50 m"
        in (found["robots[1] ('anna').robot.start"])
    )
    found = faults(f"robots:{ANNA}\n- {{name: bob, planner: scans}}{PEOPLE}")
    (message,) = found.values()
    assert "needs a lidar" in message
    assert list(found) == ["robots[1] ('bob').planner"]
    found = faults(f"robots:{ANNA}robot: {{goal: [3, 0, 0]}}{PEOPLE}")
    assert "must not be given besides robots" in found["robot"]
    found = faults(f"robots:{ANNA}sensors: [{{type: lidar}}]{PEOPLE}")
    assert list(found) == ["sensors[0]"]
    assert "the robots are a list" in found["sensors[0]"]
    high = "sensors: [{type: lidar, mount: world, height: 99}]"
    found = faults(f"robots:{ANNA}{high}{PEOPLE}")
    assert list(found) == ["sensors[0]"]
    assert "height must be at most 0.7 m" in found["sensors[0]"]
    found = faults(f"robots:{ANNA.replace('name: anna', 'name: a.b')}{PEOPLE}")
    assert "must begin with a letter" in found["robots[0] ('a.b').name"]
    walls = "world: {walls: [{type: box, center: [4, 0], size: [1, 1]}]}"
    found = faults(f"robots:{BOB}{ANNA}{PEOPLE}{walls}")
    assert "move it" in found["robots[1] ('anna').robot.goal"]


@pytest.mark.parametrize(
    ("robots", "paths"),
    [
        ("5", ["robots"]),
        (
            "[box, {name: 1, robot: {start: [9, 9, 0]}}]",
            ["robots[0]", "robots[1].name"],
        ),
        ("[{name: far, robot: {start: [9, 9, 0]}}, box]", ["robots[1]"]),
        ("[{robot: {start: 3}}]", ["robots[0].name", "robots[0].robot.start"]),
    ],
)
def test_robots_of_another_form_are_told_and_nothing_is_concluded(
    robots, paths
):
    person = "\nhumans: [{name: ana, pose: [0, 0, 0]}, {name: ana}]"
    people = ["humans[1] ('ana').name", "humans[1] ('ana').pose"]
    found = faults(f"robots: {robots}{person}")
    assert sorted(found) == sorted([*paths, *people])


def test_overrides_are_of_each_robot_and_files_keep_them():
    text = f"robots:{ANNA}{BOB}{PEOPLE}"
    changed = LoadScenario(
        data=text, overrides=["planner.type=sfm", "robots[1].robot.radius=0.2"]
    )
    types = [type(it.planner).__name__ for it in changed.robots]
    assert types[0] == types[1]
    assert [it.robot.radius for it in changed.robots] == [0.35, 0.2]
    assert LoadScenario(data=SaveScenario(changed)) == changed
    with pytest.raises(ScenarioError, match="there is no planner 'fly'"):
        LoadScenario(data=text, overrides=["planner.type=fly"])


def test_a_table_of_several_robots_is_read(tmp_path):
    path = tmp_path / "fleet.csv"
    rows = ["time,agent,x,y"]
    for t in range(5):
        rows += [
            f"{t},robot:anna,{t},0",
            f"{t},ana,2,1",
            f"{t},robot:bob,{4 - t},1",
        ]
    path.write_text("\n".join(rows))
    recording = ReadRecording(path)
    assert [it.robot_name for it in recording.robots] == ["anna", "bob"]
    assert recording.human_names == ("ana",)
    assert recording.robots[1].robot[:, X].tolist() == [4, 3, 2, 1, 0]
    path.write_text("\n".join([*rows, "5,robot,0,0"]))
    with pytest.raises(ValueError, match="give each of several robots a name"):
        ReadRecording(path)


def test_names_that_would_be_taken_twice_are_refused():
    robot = BOB.replace("bob", "sensor")
    for name in ("robot", "encounters"):
        sensor = f"sensors: [{{type: lidar, mount: world, name: {name}}}]\n"
        found = faults(f"robots:{ANNA}{robot}{PEOPLE}{sensor}")
        assert f"called 'sensor_{name}'" in found["robots[1] ('sensor').name"]
    lidars = (
        "sensors: [{type: lidar, mount: world},"
        " {type: lidar, mount: world, name: anna}]\n"
    )
    scenario = LoadScenario(data=f"robots:{ANNA}{BOB}{PEOPLE}{lidars}")
    with pytest.raises(ScenarioError, match="called 'anna_scan'"):
        MakeTrialDiagram(scenario)


def test_a_trigger_begins_the_recordings_of_all():
    scenario = fleet(ANNA, BOB, more="evaluator: {start: by_trigger}\n")
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("trigger").FixValue(context, [0.0])
    simulator = MakeTrialSimulator(diagram, context)
    simulator.AdvanceTo(0.5)
    diagram.GetInputPort("trigger").FixValue(context, [1.0])
    simulator.AdvanceTo(1.0)
    recording = GetTrialResult(scenario, diagram, context).recording
    for robot in recording.robots:
        assert robot.times[0] == pytest.approx(0.5, abs=0.1)


def test_a_robot_without_a_goal_ends_with_the_trial():
    near = ANNA.replace("[4, 0.3, 0]", "[-2.5, 0, 0]")
    post = "\n- name: post\n  robot: {start: [0, -3, 0]}"
    result = RunTrial(fleet(near, post, people="\n", duration=20))
    assert result.robot_ends == {"anna": "goal", "post": "end"}
    assert result.end_reason == "goal"
    assert result.end_time < 15
