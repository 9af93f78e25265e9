"""A whole trial is one Context: it repeats, forks and goes on."""

import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    ScenarioError,
)
from tests.processes import run_python


@pytest.fixture(scope="module")
def passing():
    return LoadScenario(filename="passing")


@pytest.fixture(scope="module")
def diagram(passing):
    return MakeTrialDiagram(passing)


def port_values(diagram, context):
    return np.concatenate(
        [
            diagram.GetOutputPort(name).Eval(context)
            for name in ("robot_state", "human_states", "velocity_command")
        ]
    )


def change(scenario, **parts):
    """Returns the scenario with some fields of some parts replaced."""
    return dataclasses.replace(
        scenario,
        **{
            part: dataclasses.replace(getattr(scenario, part), **fields)
            for part, fields in parts.items()
        },
    )


def test_a_trial_repeats_bit_for_bit(passing):
    assert RunTrial(passing).recording == RunTrial(passing).recording


@pytest.mark.slow
def test_another_process_repeats_it(passing):
    code = (
        "from hunav_drake import LoadScenario, RunTrial\n"
        "r = RunTrial(LoadScenario(filename='passing')).recording\n"
        "print(r.robot.tobytes().hex(), r.humans.tobytes().hex())"
    )
    output = run_python(code).stdout.split()
    recording = RunTrial(passing).recording
    assert output[0] == recording.robot.tobytes().hex()
    assert output[1] == recording.humans.tobytes().hex()


def test_the_seed_decides_where_people_start(passing):
    starts = [
        RunTrial(change(passing, simulation={"duration": 0.1}), seed).recording
        for seed in (0, 1)
    ]
    nominal = [human.pose[:2] for human in passing.humans]
    offsets = [start.humans[0, :, :2] - nominal for start in starts]
    assert (offsets[0] != offsets[1]).all()
    jitter = passing.simulation.start_jitter
    assert 0 < np.abs(offsets).max() <= jitter
    assert starts[0].times[0] == 0


def test_a_clone_has_the_same_future(diagram):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(7.0)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(14.0)
    fork = MakeTrialSimulator(diagram, clone)
    fork.AdvanceTo(14.0)
    np.testing.assert_array_equal(
        port_values(diagram, simulator.get_context()),
        port_values(diagram, fork.get_context()),
    )


@pytest.mark.parametrize(
    "stops", [[2.0, 2.0], [0.0], [0.0, 0.0], [3.0, 3.0, 3.0], [2.03, 2.03]]
)
def test_a_clone_may_be_taken_after_the_updates_of_its_instant(
    passing, diagram, stops
):
    """As when a cell of a notebook that calls `AdvanceTo` is run twice."""
    whole = RunTrial(passing)
    simulator = MakeTrialSimulator(diagram)
    for time in stops:
        simulator.AdvanceTo(time)
    fork = MakeTrialSimulator(diagram, simulator.get_context().Clone())
    part = GetTrialResult(passing, diagram, fork.get_context())
    assert (part.end_reason, part.end_time) == ("running", stops[-1])
    fork.AdvanceTo(passing.simulation.duration)
    result = GetTrialResult(passing, diagram, fork.get_context())
    assert result.recording == whole.recording


def test_a_resumed_trial_has_the_same_result(passing, diagram):
    """The recording, too, lives in the Context."""
    whole = RunTrial(passing)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(10.0)
    fork = MakeTrialSimulator(diagram, simulator.get_context().Clone())
    # What the first goes on to do is of no matter to its fork.
    simulator.AdvanceTo(20.0)
    fork.AdvanceTo(passing.simulation.duration)
    result = GetTrialResult(passing, diagram, fork.get_context())
    assert result.recording == whole.recording
    assert result.end_reason == "goal"
    assert result.metrics.equals(whole.metrics)


def test_a_fork_can_go_another_way(diagram):
    """A counterfactual: the same past, and the robot is put elsewhere."""
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(5.0)
    clone = simulator.get_context().Clone()
    robot = diagram.GetSubsystemByName("robot")
    robot.SetPose(robot.GetMyMutableContextFromRoot(clone), [0, 1, 0])
    fork = MakeTrialSimulator(diagram, clone)
    for other in (simulator, fork):
        other.AdvanceTo(6.0)
    states = [
        port_values(diagram, other.get_context()) for other in (simulator, fork)
    ]
    assert abs(states[0] - states[1]).max() > 1


def test_two_contexts_do_not_disturb_each_other(diagram):
    alone = MakeTrialSimulator(diagram)
    alone.AdvanceTo(6.0)
    first = MakeTrialSimulator(diagram)
    second = MakeTrialSimulator(diagram)
    second.AdvanceTo(3.0)
    for k in range(1, 61):
        first.AdvanceTo(0.1 * k)
        second.AdvanceTo(3.0 + 0.1 * k)
    np.testing.assert_array_equal(
        port_values(diagram, first.get_context()),
        port_values(diagram, alone.get_context()),
    )


def test_the_order_of_people_does_not_matter():
    scenario = change(
        LoadScenario(filename="crossing"), simulation={"duration": 6.0}
    )
    backwards = dataclasses.replace(scenario, humans=scenario.humans[::-1])
    plain = RunTrial(scenario).recording
    permuted = RunTrial(backwards).recording
    np.testing.assert_allclose(permuted.robot, plain.robot, atol=1e-9)
    np.testing.assert_allclose(
        permuted.humans[:, ::-1], plain.humans, atol=1e-9
    )


def test_another_person_far_away_changes_no_draws(passing):
    """Nobody else starts elsewhere because someone was added."""
    stranger = dataclasses.replace(
        passing.humans[0], name="stranger", id=99, pose=(0.0, 2.0, 0.0)
    )
    more = dataclasses.replace(passing, humans=[stranger, *passing.humans])
    starts = [
        RunTrial(change(scenario, simulation={"duration": 0.1})).recording
        for scenario in (passing, more)
    ]
    np.testing.assert_array_equal(starts[0].humans[0], starts[1].humans[0, 1:])


def move(point, matrix):
    return tuple((matrix @ point).tolist())


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_moved_world_moves_the_same_way(mirrored):
    scenario = change(
        LoadScenario(
            filename="crossing",
            overrides=["crowd={profile: default, model: social_force}"],
        ),
        simulation={"duration": 8.0, "start_jitter": 0.0},
    )
    angle = 0.0 if mirrored else 0.6
    sign = -1.0 if mirrored else 1.0
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1.0, sign])

    def move_pose(pose):
        return (*move(pose[:2], matrix), sign * pose[2] + angle)

    humans = [
        dataclasses.replace(
            human,
            pose=move_pose(human.pose),
            goals=[move(goal, matrix) for goal in human.goals],
            forces=dataclasses.replace(
                human.forces, epsilon=sign * human.forces.epsilon
            ),
        )
        for human in scenario.humans
    ]
    walls = [
        dataclasses.replace(
            wall, center=move(wall.center, matrix), yaw=sign * wall.yaw + angle
        )
        for wall in scenario.world.walls
    ]
    moved = change(
        dataclasses.replace(scenario, humans=humans),
        world={"walls": walls},
        robot={
            "start": move_pose(scenario.robot.start),
            "goal": move_pose(scenario.robot.goal),
        },
    )
    plain, result = RunTrial(scenario).recording, RunTrial(moved).recording
    for before, after in (
        (plain.robot, result.robot),
        (plain.humans, result.humans),
    ):
        np.testing.assert_allclose(
            after[..., :2], before[..., :2] @ matrix.T, atol=1e-8
        )
        np.testing.assert_allclose(
            after[..., 3:5], before[..., 3:5] @ matrix.T, atol=1e-7
        )


def test_a_trial_ends_when_its_time_is_over(passing):
    result = RunTrial(change(passing, simulation={"duration": 3.0}))
    assert result.end_reason == "timeout"
    assert result.end_time == 3.0
    assert result.recording.times[-1] == 3.0
    assert math.isnan(result.metrics["time_to_reach_goal"])


def test_a_robot_before_a_wall_is_stuck(passing):
    scenario = change(
        passing,
        robot={"goal": (-7.7, -1.5, math.pi)},
        world={
            "walls": [
                *passing.world.walls,
                {"type": "box", "center": [4.0, 0.0], "size": [0.2, 4.0]},
            ]
        },
        simulation={"stuck_time": 5.0},
    )
    result = RunTrial(scenario)
    assert result.end_reason == "stuck"
    assert result.end_time < 30
    assert result.recording.robot[-1, 0] > 4.1 + passing.robot.radius


def test_without_a_goal_the_robot_rests_and_time_runs_out(passing):
    scenario = change(
        passing, robot={"goal": None}, simulation={"duration": 2.0}
    )
    result = RunTrial(scenario)
    assert result.end_reason == "timeout"
    np.testing.assert_array_equal(
        result.recording.robot[0], result.recording.robot[-1]
    )


def test_nobody_has_to_be_there(passing):
    result = RunTrial(dataclasses.replace(passing, humans=[]))
    assert result.end_reason == "goal"
    assert math.isnan(result.metrics["min_dist_to_people"])


@pytest.mark.parametrize("time_step", [0.01, 0.05, 0.1])
def test_the_outcome_does_not_hang_on_the_step(passing, time_step):
    scenario = change(
        passing,
        simulation={"time_step": time_step},
        planner={"period": 0.1},
        evaluator={"period": 1.0},
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    assert result.end_time == pytest.approx(26.5, abs=1.5)
    np.testing.assert_allclose(
        result.recording.times[:-1], np.arange(len(result.recording.times) - 1)
    )


def test_a_result_in_the_middle_says_so(passing, diagram):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(2.0)
    result = GetTrialResult(passing, diagram, simulator.get_context())
    assert result.end_reason == "running"
    assert result.end_message == "the trial is not over"
    assert result.end_time == 2.0


def test_a_seed_may_be_drawn_by_numpy(passing):
    short = change(passing, simulation={"duration": 1.0})
    drawn = RunTrial(short, np.random.default_rng(1).integers(9))
    plain = RunTrial(short, int(np.random.default_rng(1).integers(9)))
    assert drawn.recording == plain.recording
    assert drawn.provenance["seed"] == plain.provenance["seed"]


@pytest.mark.parametrize("seed", [-1, 1.5, 2**63, True, "1"])
def test_a_wrong_seed_is_refused(passing, seed):
    words = r"seed: must be a whole number in \[0, 2\^63\), got"
    with pytest.raises(ScenarioError, match=words):
        RunTrial(passing, seed)


@pytest.mark.parametrize("function", [RunTrial, MakeTrialDiagram])
def test_a_name_is_no_scenario(function):
    with pytest.raises(TypeError, match=r"filename='passing'\) gives one"):
        function("passing")


def test_the_progress_is_told(passing):
    times = []
    RunTrial(
        change(passing, simulation={"duration": 1.0}), progress=times.append
    )
    np.testing.assert_allclose(times, 0.05 * np.arange(len(times)), atol=1e-9)
    assert times[-1] == 1.0


def test_a_scenario_made_wrong_is_refused_before_anything_runs(passing):
    wrong = dataclasses.replace(
        passing, humans=[passing.humans[0], passing.humans[0]]
    )
    with pytest.raises(ScenarioError, match="must be unique"):
        RunTrial(wrong)


@pytest.mark.slow
def test_a_headless_trial_opens_no_meshcat():
    code = (
        "import sys, pydrake.geometry as g\n"
        "def refuse(*args, **kwargs): raise SystemExit('a Meshcat was made')\n"
        "g.Meshcat = refuse\n"
        "from hunav_drake import LoadScenario, RunTrial\n"
        "RunTrial(LoadScenario(filename='passing'))\n"
        "sys.exit(any('matplotlib' in m for m in sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_a_changed_tree_file_shows_in_the_provenance(tmp_path):
    tree = tmp_path / "mine.xml"
    text = """
scenario: {humans: [{pose: [5, 5, 0], behavior: mine.xml}],
           simulation: {duration: 1.0}}
"""
    (tmp_path / "mine.yaml").write_text(text)
    hashes = []
    for seconds in ("1.0", "1.0", "2.0"):
        tree.write_text(
            '<root BTCPP_format="4"><BehaviorTree ID="T">'
            f'<TimeExpiredCondition seconds="{seconds}"/>'
            "</BehaviorTree></root>"
        )
        scenario = LoadScenario(
            filename=tmp_path / "mine.yaml", scenario_name="scenario"
        )
        provenance = RunTrial(scenario).provenance
        hashes.append(provenance["behavior_sha256"])
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.slow
def test_a_scenario_says_what_part_of_a_trial_is_recorded(passing):
    scenario = change(passing, evaluator={"timeout": 5.0})
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    assert result.recording.times[-1] == pytest.approx(5.0)
    whole = RunTrial(passing)
    assert result.end_time == whole.end_time == whole.recording.times[-1]
    scenario = change(passing, evaluator={"stop_at_goal": True})
    assert RunTrial(scenario).recording.features.at_goal[-1]


def test_why_a_trial_ended_is_told_of_its_own_end(passing):
    ends = {}
    for timeout in (None, 3.0):
        changes = {"evaluator": {"timeout": timeout}}
        scenario = change(passing, simulation={"duration": 9.0}, **changes)
        ends[timeout] = RunTrial(scenario)
    assert ends[3.0].recording.times[-1] == pytest.approx(3.0)
    assert ends[3.0].end_time == ends[None].end_time == 9.0
    assert ends[3.0].end_message == ends[None].end_message
    assert "on its way at" in ends[None].end_message


def test_between_two_steps_nothing_is_recorded(passing, diagram):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(3.051)
    context = simulator.get_context()
    result = GetTrialResult(passing, diagram, context)
    assert result.end_time == context.get_time() == 3.051
    recording = result.recording
    assert recording.times[-1] == pytest.approx(3.0)
    # A last sample at the end of a step is of its own instant.
    simulator.AdvanceTo(3.25)
    recording = GetTrialResult(passing, diagram, context).recording
    assert recording.times[-1] == pytest.approx(3.25)
    # Once the updates of an instant are done, its state is gone.
    for _ in range(2):
        simulator.AdvanceTo(3.25)
        late = GetTrialResult(passing, diagram, context)
        assert late.recording.times[-1] == pytest.approx(3.2)
        fork = MakeTrialSimulator(diagram, context.Clone()).get_context()
        forked = GetTrialResult(passing, diagram, fork)
        assert forked.recording == late.recording
    steps = np.diff(recording.robot[-3:, 0]) / np.diff(recording.times[-3:])
    assert abs(steps).max() < 1.1 * passing.robot.limits.max_speed
    assert steps[1] == pytest.approx(steps[0], rel=0.2)


@pytest.mark.parametrize(
    "command",
    [
        "branch passing --at 1",
        "who passing --at 1",
        "risk passing --set crowd.decisions={}",
        "risk passing --set crowd.decisions={} --splitting 9",
        "falsify space.yaml",
        "bench suite.yaml",
    ],
)
def test_no_command_waits_for_a_trigger(hunav, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    start = "evaluator.start=by_trigger"
    space = (
        f"scenario: passing\noverrides: [{start}]\n"
        "space: {'robot.start[0]': [-1, 1]}\n"
    )
    (tmp_path / "space.yaml").write_text(space)
    suite = f"scenarios: [passing]\noverrides: [{start}]\n"
    (tmp_path / "suite.yaml").write_text(suite)
    name, *words = command.split()
    if words[0] == "passing":
        words += ["--set", start]
    code, _, told = hunav(name, *words)
    assert code == 2
    assert "leaves unconnected" in told


def test_a_recording_begun_by_a_trigger_is_for_a_diagram(passing):
    scenario = change(passing, evaluator={"start": "by_trigger"})
    with pytest.raises(ScenarioError, match="leaves unconnected"):
        RunTrial(scenario)
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    trigger = diagram.GetInputPort("trigger")
    trigger.FixValue(simulator.get_mutable_context(), 0.0)
    simulator.AdvanceTo(1.0)
    trigger.FixValue(simulator.get_mutable_context(), 1.0)
    simulator.AdvanceTo(2.0)
    result = GetTrialResult(scenario, diagram, simulator.get_context())
    assert result.recording.times[0] == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("sees", ["lidar", "detector"])
def test_the_order_of_people_does_not_matter_to_sensors(sees):
    """Legs and errors of detections follow people's numbers."""
    overrides = [
        f"planner={{type: sfm, sees: {sees}}}",
        "simulation.duration=6.0",
        *(f"humans[{i}].id={11 + 3 * i}" for i in range(4)),
    ]
    scenario = LoadScenario(filename="crossing", overrides=overrides)
    backwards = dataclasses.replace(scenario, humans=scenario.humans[::-1])
    plain, permuted = (RunTrial(it).recording for it in (scenario, backwards))
    np.testing.assert_allclose(permuted.robot, plain.robot, atol=1e-9)
    other = LoadScenario(
        filename="crossing", overrides=[*overrides, "humans[0].id=71"]
    )
    assert np.abs(RunTrial(other).recording.robot - plain.robot).max() > 1e-3


@pytest.mark.parametrize("time", [0.0, 2.0])
def test_a_fork_may_advance_to_its_own_instant(diagram, time):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    simulator.AdvanceTo(time)
    fork = simulator
    for _ in range(4):
        fork = MakeTrialSimulator(diagram, fork.get_context().Clone())
        fork.AdvanceTo(time)
    for each in (simulator, fork):
        each.AdvanceTo(time + 1.0)
    np.testing.assert_equal(
        *(port_values(diagram, it.get_context()) for it in (simulator, fork))
    )
