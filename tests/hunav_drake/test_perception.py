"""What planners see: one option for all of them."""

import dataclasses

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain
import pytest

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    RunTrial,
    SaveScenario,
    ScenarioError,
)
from hunav_drake.scenario.checks import first_lidar
from hunav_drake.systems.common.layout import OUTSIDE
from hunav_drake.systems.planning import (
    PERCEPTIONS,
    PLANNERS,
    PerceptionConfig,
    Plan,
    Planner,
    PlannerConfig,
    PlannerStatus,
    register_perception,
    register_plan,
    register_planner,
)
from hunav_drake.systems.sensing import LidarConfig
from hunav_drake.trial.blocks import with_planner_lidar
from tests.choices import fast
from tests.planners import NAMES, planner_override


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    for registry in (PLANNERS, PERCEPTIONS):
        monkeypatch.setattr(registry, "_choices", dict(registry))


def planner_of(name, sees):
    return planner_override(name, f"sees: {sees}")


def crossing(name, sees, *overrides):
    return LoadScenario(
        filename="crossing",
        overrides=[planner_of(name, sees), "simulation.duration=4", *overrides],
    )


def test_all_planners_of_the_package_are_tested():
    of_package = {
        name
        for name, planner in PLANNERS.items()
        if planner.__module__.startswith("hunav_drake.")
    }
    # (These see nobody, or what another program makes of it.)
    assert {*NAMES, "stand", "external", "bridge"} == of_package


# Behind a wall.

# A corner that the robot is to turn around, and who stands behind it.
CORNER = """
world:
  walls:
    - {type: polyline, points: [[1.2, 0.5], [1.2, 6]]}
humans:
  - {pose: [2.0, 1.3, -1.57], desired_speed: 0.0, behavior: impassive}
robot: {start: [0, 0.2, 0], goal: [2.6, 2.6, 1.57]}
simulation: {duration: 2.0}
"""
# Straight on beside a thin wall, and who stands close behind it.
LANE = """
world:
  walls:
    - {type: polyline, points: [[0.2, 0.4], [3.5, 0.4]]}
humans:
  - {pose: [1, 0.76, 0], desired_speed: 0.0, behavior: impassive, radius: 0.35}
robot: {start: [0, 0, 0], goal: [6, 0, 0]}
simulation: {duration: 2.0}
"""


def commands(text, *overrides, people=True):
    """Returns what a planner has commanded, every 0.05 s."""
    scenario = LoadScenario(data=text, overrides=list(overrides))
    if not people:
        scenario = dataclasses.replace(scenario, humans=[])
    diagram = MakeTrialDiagram(scenario)
    simulator = Simulator(diagram)
    command = diagram.GetOutputPort("velocity_command")
    result = []
    for k in range(1, 25):
        simulator.AdvanceTo(0.05 * k)
        result.append(command.Eval(simulator.get_context()).copy())
    return np.array(result)


@pytest.mark.parametrize("name", NAMES)
def test_who_is_behind_a_wall_counts_only_for_who_sees_everything(name):
    """Blind to walls, it is another drive; else, bit for bit the same."""
    text = LANE if name == "pursuit" else CORNER
    alone = commands(text, planner_of(name, "visible"), people=False)
    hidden = commands(text, planner_of(name, "visible"))
    np.testing.assert_array_equal(hidden, alone)
    known = commands(text, planner_of(name, "everything"))
    assert np.abs(known - alone).max() > 0.01
    assert np.isfinite(known).all()


@pytest.mark.parametrize(
    ("option", "seen"),
    [
        ("range_max: 5.0", [True, True, False, True]),
        ("field_of_view: 3.0", [True, False, False, True]),
        ("hidden_by_people: true", [True, True, True, False]),
    ],
)
def test_range_field_and_occlusion_are_options(option, seen):
    given = []

    @register_plan("watching")
    def watching(task, view, memory):
        given.append(view.humans.copy())
        return Plan(0.0, 0.0, PlannerStatus.DRIVING)

    humans = "[{pose: [2, 0, 0]}, {pose: [-2, 0, 0]}, {pose: [0, 7, 0]}, "
    humans += "{pose: [4, 0, 0]}]"
    RunTrial(
        LoadScenario(
            data=f"humans: {humans}\n"
            "robot: {start: [0, 0, 0], goal: [9, 9, 0]}\n"
            f"planner: {{type: watching, sees: {{type: visible, {option}}}}}\n"
            "simulation: {duration: 0.05}\n"
        )
    )
    rows = given[0]
    assert rows.shape == (4, 7)
    np.testing.assert_array_equal(rows[:, 0] < 100, seen)
    for row in rows[~np.array(seen)]:
        np.testing.assert_array_equal(row, [OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0])


# By the lidar alone.


def test_a_lidar_is_made_where_there_is_none():
    scenario = crossing("dwb", "lidar")
    assert first_lidar(scenario) is None
    diagram = MakeTrialDiagram(scenario)
    assert diagram.HasSubsystemNamed("sensor_lidar")
    planner = diagram.GetSubsystemByName("planner")
    assert planner.GetInputPort("human_states").size() == 0
    context = diagram.CreateDefaultContext()
    assert diagram.GetOutputPort("scan").Eval(context).size == 360
    # What is written is what was asked for.
    assert "sensors" not in SaveScenario(scenario)


def test_the_lidar_of_the_scenario_is_taken():
    sensors = "sensors=[{type: lidar, num_rays: 181, field_of_view: 3.14}]"
    scenario = crossing("scl", "lidar", sensors)
    assert with_planner_lidar(scenario) is scenario
    planner = MakeTrialDiagram(scenario).GetSubsystemByName("planner")
    assert planner.GetInputPort("scan").size() == 181


POST = """
humans:
  - {pose: [3, 0.1, 0], desired_speed: 0.0, behavior: impassive, radius: 0.25}
robot: {start: [0, 0, 0], goal: [6, 0, 0], radius: 0.25}
simulation: {duration: 40}
"""


@pytest.mark.parametrize("name", fast(NAMES, "pursuit", "orca"))
def test_who_stands_in_the_way_is_met_by_the_lidar(name):
    """Without it nothing is known of anybody, and the robot drives on."""
    scenario = LoadScenario(data=POST, overrides=[planner_of(name, "lidar")])
    result = RunTrial(scenario)
    assert result.metrics["robot_on_person_collisions"] == 0
    if name == "pursuit":
        # It stops, as it does for all that it sees.
        assert result.recording.robot[-1, 0] < 3 - 0.6
        return
    assert result.end_reason == "goal"
    nobody = RunTrial(dataclasses.replace(scenario, humans=[]))
    assert np.ptp(result.recording.robot[:, 1]) > 0.2
    assert np.ptp(nobody.recording.robot[:, 1]) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["crossing", "passing"])
def test_dwb_gets_through_by_the_lidar(name):
    """People are obstacles that it sees: it leaves the way it has alone."""
    scenario = LoadScenario(
        filename=name, overrides=[planner_of("dwb", "lidar")]
    )
    result = RunTrial(scenario, 1)
    assert result.end_reason == "goal"
    assert result.metrics["robot_on_person_collisions"] == 0
    assert result.metrics["static_obstacle_collisions"] == 0
    alone = RunTrial(dataclasses.replace(scenario, humans=[]), 1)
    steps = min(len(result.recording.robot), len(alone.recording.robot))
    way, free = (run.recording.robot[:steps, :2] for run in (result, alone))
    if name == "crossing":
        assert np.abs(way - free).max() > 0.1


def test_ones_own_planner_gets_the_scan_and_nobody():
    seen = []

    @register_planner("own")
    @dataclass
    class Own(Planner):
        def plan(self, task, view, memory):
            seen.append((view.humans.shape, view.scan.copy(), task.lidar))
            return Plan(0.0, 0.0, PlannerStatus.DRIVING)

    RunTrial(crossing("own", "lidar", "simulation.duration=0.1"))
    for humans, scan, lidar in seen:
        assert humans == (0, 7)
        assert scan.shape == (lidar.num_rays,)
    Own.scan_size = 9
    with pytest.raises(ScenarioError, match="needs a lidar of 9 rays, but"):
        crossing("own", "lidar", "sensors=[{type: lidar}]")
    lidar = with_planner_lidar(crossing("own", "lidar")).sensors[0]
    assert lidar.num_rays == 9


class Blind(PlannerConfig):
    """A system without an input for scans."""

    def MakeSystem(self, task):
        from hunav_drake.systems.planning import LocalPlanner, PursuitPlanner

        return LocalPlanner(PursuitPlanner(), task)


def test_a_system_without_a_port_for_scans_is_refused():
    register_planner("system")(dataclass(kw_only=True)(Blind))
    MakeTrialDiagram(crossing("system", "visible"))
    with pytest.raises(ScenarioError, match="no input port scan, so it would"):
        MakeTrialDiagram(crossing("system", "lidar"))


# Perceptions of one's own, and faults.


def test_a_perception_of_ones_own_stands_between():
    given = []

    @register_perception("mirrored")
    @dataclass(kw_only=True)
    class Mirrored(PerceptionConfig):
        output: str = "visible_people"

        def MakeSystem(self, task):
            builder = DiagramBuilder()
            gain = builder.AddSystem(Gain(-1.0, 7 * task.num_humans))
            builder.ExportInput(gain.get_input_port(), "human_states")
            builder.ExportOutput(gain.get_output_port(), self.output)
            return builder.Build()

    @register_plan("watching")
    def watching(task, view, memory):
        given.append(view.humans.copy())
        return Plan(0.0, 0.0, PlannerStatus.DRIVING)

    scenario = crossing("watching", "mirrored", "simulation.duration=0.05")
    result = RunTrial(scenario)
    np.testing.assert_array_equal(given[0], -result.recording.humans[0])
    wrong = crossing("watching", "{type: mirrored, output: people}")
    with pytest.raises(TypeError, match=r"Mirrored lacks .* visible_people"):
        MakeTrialDiagram(wrong)


def test_a_lidar_in_a_perception_knows_who_sits():
    @register_perception("by_legs")
    @dataclass(kw_only=True)
    class ByLegs(PerceptionConfig):
        def MakeSystem(self, task):
            builder = DiagramBuilder()
            lidar = builder.AddSystem(LidarConfig().MakeSystem(task))
            for name in ("robot_state", "social_signals"):
                builder.ExportInput(lidar.GetInputPort(name), name)
            passed = builder.AddSystem(Gain(1.0, 7 * task.num_humans))
            builder.ExportInput(passed.get_input_port(), "human_states")
            builder.ConnectInput(
                "human_states", lidar.get_human_states_input_port()
            )
            builder.ExportOutput(passed.get_output_port(), "visible_people")
            return builder.Build()

    overrides = [planner_of("dwb", "by_legs")]
    scenario = LoadScenario(filename="living_cafe", overrides=overrides)
    diagram = MakeTrialDiagram(scenario)
    system = diagram.GetSubsystemByName("perception")
    context = system.GetMyContextFromRoot(diagram.CreateDefaultContext())
    assert system.GetInputPort("social_signals").HasValue(context)


@pytest.mark.parametrize(
    ("sees", "words"),
    [
        ("visibel", "did you mean 'visible'"),
        ("{type: visible, range_max: -1}", r"must be in \(0, 1000\] m"),
        ("{type: lidar, range_max: 5}", "range_max: unknown key"),
        ("3", "planner.sees"),
    ],
)
def test_faults_are_told_with_their_place(sees, words):
    with pytest.raises(ScenarioError, match=words) as info:
        crossing("dwb", sees)
    assert "planner.sees" in str(info.value)


# State.


@pytest.mark.parametrize(
    ("name", "sees"),
    [
        pytest.param(name, sees, marks=[pytest.mark.slow] * ((i + k) % 3 > 0))
        for i, name in enumerate(NAMES)
        for k, sees in enumerate(["everything", "visible", "lidar"])
    ],
)
def test_a_fork_goes_on_alike_whatever_is_seen(name, sees):
    """Bit for bit; and what another Context does changes nothing."""
    diagram = MakeTrialDiagram(crossing(name, sees))
    straight = Simulator(diagram)
    straight.AdvanceTo(2.4)
    first = Simulator(diagram)
    first.AdvanceTo(1.53)
    fork = Simulator(diagram, first.get_context().Clone())
    other = Simulator(diagram)
    for time in (1.7, 2.4):
        other.AdvanceTo(time - 0.9)
        fork.AdvanceTo(time)
        first.AdvanceTo(time)
    for port in ("robot_state", "velocity_command", "planner_path"):
        expected, *got = (
            diagram.GetOutputPort(port).Eval(it.get_context())
            for it in (straight, first, fork)
        )
        for values in got:
            np.testing.assert_array_equal(values, expected)
