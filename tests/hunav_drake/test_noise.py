"""Errors and delays in whole trials: by seed, in the Context, for planners."""

import dataclasses
import re

import numpy as np
from pydantic.dataclasses import dataclass
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    ScenarioError,
    SetRobotCommand,
    SetTrialSeed,
    TransferContext,
)
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.systems.common.layout import OUTSIDE, is_outside
from hunav_drake.systems.planning import (
    PERCEPTIONS,
    PLANNERS,
    Plan,
    PlannerStatus,
    register_plan,
)
from hunav_drake.systems.sensing import (
    LOCALIZATIONS,
    ErrorModel,
    register_localization,
)
from tests.choices import fast
from tests.planners import NAMES, planner_override

DETECTOR = (
    "{type: detector, missed: 0.1, missed_per_meter: 0.01, noise: 0.05,"
    " noise_per_meter: 0.02, velocity_noise: 0.1, false_rate: 1.0, delay: 0.1}"
)
LIDAR = "{type: lidar, num_rays: 90, dropout: 0.05, noise: 0.02, delay: 0.1}"
NO_ERRORS = (
    "missed: 0, missed_per_meter: 0, noise: 0, noise_per_meter: 0,"
    " velocity_noise: 0, false_rate: 0"
)
DETECTIONS = "{type: people_detector, missed: 0.3, false_rate: 2.0}"
ALL = f"sees: {DETECTOR}, localization: odometry"
SENSORS = f"sensors=[{LIDAR}, {DETECTIONS}]"
LATE = "robot.command_delay=0.1"


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    for registry in (PLANNERS, PERCEPTIONS, LOCALIZATIONS):
        monkeypatch.setattr(registry, "_choices", dict(registry))


def noisy(*overrides, planner="sfm", parameters=ALL, name="crossing"):
    return LoadScenario(
        filename=name,
        overrides=[
            "simulation.duration=4.0",
            planner_override(planner, parameters),
            SENSORS,
            LATE,
            *overrides,
        ],
    )


OUTPUTS = (
    *("robot_state", "estimated_robot_state", "velocity_command", "scan"),
    *("visible_people", "human_states"),
)


def run(diagram, *, context=None, end=2.0, names=OUTPUTS):
    """The outputs of a trial every 0.1 s, and its Context at the end."""
    simulator = MakeTrialSimulator(diagram, context)
    own = simulator.get_mutable_context()
    start = round(own.get_time() * 10) + (context is not None)
    found = []
    for k in range(start, round(end * 10) + 1):
        simulator.AdvanceTo(k / 10)
        ports = [diagram.GetOutputPort(name) for name in names]
        found.append(np.concatenate([it.Eval(own) for it in ports]))
    simulator.clear_monitor()
    return np.array(found), own


@pytest.mark.slow
def test_a_trial_with_errors_continues_bit_for_bit(tmp_path):
    """A clone, a saved and loaded Context, and whatever another one does."""
    diagram = MakeTrialDiagram(noisy())
    expected, _ = run(diagram)
    _, half = run(diagram, end=1.0)
    clone = half.Clone()
    path = SaveContext(diagram, half, tmp_path / "half.npz")
    run(diagram, context=half, end=1.5)
    loaded = LoadContext(MakeTrialDiagram(noisy()), path)
    for context in (clone, loaded):
        owner = diagram
        if context is loaded:
            owner = MakeTrialDiagram(noisy())
            context = LoadContext(owner, path)
        rest, _ = run(owner, context=context)
        np.testing.assert_array_equal(rest, expected[11:])


@pytest.mark.slow
def test_a_seed_can_be_set_and_others_differ():
    diagram = MakeTrialDiagram(noisy())
    first, context = run(diagram)
    SetTrialSeed(diagram, context, 7)
    reset, _ = run(diagram, context=context.Clone())
    anew = MakeTrialDiagram(noisy("simulation.seed=7"))
    expected, _ = run(anew)
    np.testing.assert_array_equal(reset, expected[1:])
    for name in ("estimated_robot_state", "scan", "visible_people"):
        one, _ = run(diagram, end=0.5, names=[name])
        two, _ = run(anew, end=0.5, names=[name])
        assert (one != two).any(), name
    assert (first != expected).any()
    told = " ".join(drawn_by_seed(noisy()))
    assert "errors of the detector, error of the loc" in told.replace(
        "detector error", "detector, error"
    )


def watched(*overrides, parameters, name="crossing"):
    """What a planner that stays gets of the robot, and of people."""
    given = []

    @register_plan("watching")
    def watching(task, view, memory):
        given.append((view.robot.copy(), view.humans.copy()))
        return Plan(0.3, 0.1, PlannerStatus.DRIVING)

    scenario = LoadScenario(
        filename=name,
        overrides=[
            "simulation.duration=2.0",
            f"planner={{type: watching, {parameters}}}",
            *overrides,
        ],
    )
    recording = RunTrial(scenario).recording
    robots, people = zip(*given, strict=True)
    return np.array(robots), np.array(people), recording


def test_the_draws_of_a_planner_do_not_depend_on_sensors():
    alone = watched(parameters=ALL)
    beside = watched(SENSORS, parameters=ALL)
    for one, other in zip(alone[:2], beside[:2], strict=True):
        np.testing.assert_array_equal(one, other)


def test_by_default_the_planner_gets_the_truth():
    diagram = MakeTrialDiagram(LoadScenario(filename="crossing"))
    assert not diagram.HasOutputPort("estimated_robot_state")
    for name in ("localization", "perception_delay", "command_delay"):
        assert not diagram.HasSubsystemNamed(name)


@pytest.mark.parametrize("sees", ["everything", "visible", "detector"])
def test_without_errors_a_trial_is_the_exact_one(sees):
    """Bit for bit, with all the systems that have errors."""
    none = "localization: {type: gauss_markov, position_deviation: 0.0,"
    none += " yaw_deviation: 0.0}"
    exact = "visible" if sees == "detector" else sees
    period = (
        f"{{type: detector, period: 0.05, {NO_ERRORS}}}"
        if sees == "detector"
        else sees
    )
    robots, people, recording = watched(parameters=f"sees: {period}, {none}")
    expected = watched(parameters=f"sees: {exact}")
    np.testing.assert_array_equal(robots, expected[0])
    np.testing.assert_array_equal(people, expected[1])
    assert recording == expected[2]


@pytest.mark.parametrize("time_step", [0.02, 0.05, 0.1])
def test_a_detector_is_late_by_its_delay(time_step):
    step = [f"simulation.time_step={time_step}", "evaluator.period=0.1"]
    period = f"period: {time_step}"
    sees = (
        f"sees: {{type: detector, {period}, {NO_ERRORS}, delay: %s}}, {period}"
    )
    now = watched(*step, parameters=sees % "0.0")[1]
    late = watched(*step, parameters=sees % "0.2")[1]
    k = round(0.2 / time_step)
    assert (now[1:] != now[:-1]).any()
    np.testing.assert_array_equal(late[k:], now[:-k])
    np.testing.assert_array_equal(late[:k], [now[0]] * k)


@pytest.mark.parametrize("time_step", [0.02, 0.05, 0.1])
def test_a_robot_obeys_later_by_the_delay_of_commands(time_step):
    """Its whole drive is that of a robot without, as much later."""
    options = [f"simulation.time_step={time_step}", "humans=[]"]
    options.append(f"evaluator.period={time_step}")
    period = f"period: {time_step}"
    now = watched(*options, parameters=period)[0]
    late = watched(*options, "robot.command_delay=0.2", parameters=period)[0]
    k = round(0.2 / time_step)
    np.testing.assert_array_equal(late[k:], now[:-k])
    np.testing.assert_array_equal(late[:k], [now[0]] * k)


def test_the_first_command_is_late_too():
    """One that is set before the first step, with no planner's rest before."""
    options = ["simulation.time_step=0.1", "robot.command_delay=0.3"]
    scenario = noisy(*options, planner="external", parameters="period: 0.1")
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    SetRobotCommand(diagram, simulator.get_mutable_context(), [1.0, 0.0])
    robot = diagram.GetOutputPort("robot_state")
    speeds = []
    for step in range(1, 6):
        simulator.AdvanceTo(0.1 * step)
        row = robot.Eval(simulator.get_context())
        speeds.append(float(np.hypot(*row[3:5])))
    np.testing.assert_allclose(speeds, [0, 0, 0, 0.1, 0.2], atol=1e-9)


def test_the_evaluation_takes_the_true_pose():
    far = "localization: {type: gauss_markov, position_deviation: 1.0}"
    robots, people, recording = watched(parameters=far)
    true = watched(parameters="period: 0.05")
    np.testing.assert_array_equal(recording.robot, true[2].robot)
    off = robots[:, :2] - true[0][:, :2]
    assert abs(off).max() > 0.3
    # The people whom the planner sees are off with it: as far away as ever.
    away, expected = (
        np.hypot(*np.moveaxis(humans[..., :2] - own[:, None, :2], -1, 0))
        for own, humans in ((robots, people), true[:2])
    )
    np.testing.assert_allclose(away, expected, atol=1e-9)


def test_the_end_of_a_trial_tells_how_far_off_the_pose_is():
    result = RunTrial(noisy("simulation.duration=1.0"))
    told = r"the pose that the planner has is off by 0\.\d\d m and 0\.\d\d rad"
    assert re.search(told, result.end_message)


def test_each_of_several_robots_has_errors_of_its_own():
    robots = ", ".join(
        f"{{name: {name}, planner: {{type: sfm, {ALL}}}, sensors: [{LIDAR}],"
        f" robot: {{start: [0, {y}, 0], goal: [9, {y}, 0],"
        " command_delay: 0.1}}"
        for name, y in (("north", 2), ("south", -2))
    )
    scenario = LoadScenario(
        data=f"humans: [{{pose: [4, 0, 0]}}]\nrobots: [{robots}]\n"
        "simulation: {duration: 1.0}\n"
    )
    diagram = MakeTrialDiagram(scenario)
    errors = []
    for prefix in diagram.prefixes.values():
        ports = [f"{prefix}{it}robot_state" for it in ("", "estimated_")]
        rows, _ = run(diagram, end=1, names=ports)
        errors.append((rows[:, 7:] - rows[:, :7])[:, :3])
        planner = diagram.GetSubsystemByName(f"{prefix}planner")
        # A person, the other robot, and false detections.
        assert planner.GetInputPort("human_states").size() == 7 * (1 + 1 + 5)
    # (Robots that drive alike, by the same draws, would have equal ratios.)
    one, other = np.diff(errors, axis=1)[:, 3:, 2]
    assert np.ptp(one / other) > 0.1
    assert RunTrial(scenario, diagram=diagram).recording == (
        RunTrial(scenario).recording
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", fast(NAMES, "sfm"))
def test_every_planner_drives_with_errors_and_delays(name):
    for lidar in (False, True):
        seen = "lidar" if lidar else DETECTOR
        result = RunTrial(
            noisy(
                "simulation.duration=8.0",
                planner=name,
                parameters=f"sees: {seen}, localization: gauss_markov",
            )
        )
        assert result.end_reason in ("goal", "timeout")
        assert np.isfinite(result.recording.robot).all()
        assert result.metrics["path_length"] > 1.0


def test_a_trial_with_errors_continues_in_another_diagram():
    """With another planner, its error of localization stays."""
    diagram = MakeTrialDiagram(noisy())
    _, context = run(diagram, end=1.5)
    other = MakeTrialDiagram(noisy(planner="orca"))
    moved = TransferContext(diagram, context, other)
    name = "estimated_robot_state"
    for owner, own in ((diagram, context), (other, moved)):
        row = owner.GetOutputPort(name).Eval(own)
        if owner is diagram:
            expected = row
    np.testing.assert_array_equal(row, expected)
    exact = MakeTrialDiagram(noisy(planner="orca", parameters="sees: visible"))
    _, end = run(
        exact,
        context=TransferContext(diagram, context, exact),
        names=["robot_state"],
    )
    assert end.get_time() == 2.0
    back = TransferContext(exact, end, diagram)
    run(diagram, context=back, end=2.5)


def test_a_localization_of_ones_own_is_an_option():
    @register_localization("shifted")
    @dataclass(kw_only=True)
    class Shifted(ErrorModel):
        by: float = 1.0

        def next_error(self, error, motion, time_step, normal):
            return np.array([self.by, 0.0, 0.0])

    robots, _, recording = watched(
        parameters="localization: {type: shifted, by: 0.5}"
    )
    off = robots[0] - recording.robot[0]
    np.testing.assert_array_equal(off, [0.5, 0, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("override", "place", "words"),
    [
        ("robot.command_delay=0.12", "robot.command_delay", "0.1 or 0.15"),
        ("sensors=[{type: lidar, delay: 0.07}]", "sensors[0].delay", "0.05"),
        (
            "planner={sees: {type: detector, delay: 0.07}}",
            "planner.sees.delay",
            "0.05 or 0.1",
        ),
        (
            "planner={sees: {type: detector, period: 0.07}}",
            "planner.sees.period",
            "0.05 or 0.1",
        ),
        ("sensors=[{type: camera, delay: 0.1}]", "sensors[0].delay", "unknown"),
        (
            "planner={localization: {type: odometry, alpha5: 1}}",
            "planner.localization.alpha5",
            "alpha4",
        ),
        ("planner={localization: gps}", "planner.localization", "odometry"),
    ],
)
def test_faults_are_told_with_place_and_remedy(override, place, words):
    with pytest.raises(ScenarioError) as info:
        LoadScenario(filename="crossing", overrides=[override])
    (fault,) = info.value.faults
    assert fault.path.startswith(place)
    assert words in fault.message


def test_absent_people_are_not_detected():
    """Those who have not come yet, nor is anybody where nobody is."""
    options = ["population={}", "humans=[]"]
    _, people, _ = watched(
        *options, parameters="sees: {type: detector, false_rate: 4}"
    )
    assert people.shape[1:] == (5, 7)
    gone = people[is_outside(people)]
    np.testing.assert_array_equal(
        gone, [[OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0]] * len(gone)
    )
    assert 0 < len(gone) < people.shape[0] * 5


@pytest.mark.slow
def test_a_physical_robot_drives_with_errors_and_delays():
    scenario = dataclasses.replace(
        noisy("robot.type=pmb2", "simulation.duration=2.0"), name="physical"
    )
    first, second = (RunTrial(scenario, 3) for _ in range(2))
    assert first.recording == second.recording
    assert first.metrics["path_length"] > 0.3
