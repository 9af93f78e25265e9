"""Planners with maps in the shipped trials, with real people."""

import dataclasses

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
)
from hunav_drake.systems.world.obstacles import nearest_wall

PLANNERS = ["dwb", "scl"]
ALL = [*PLANNERS, "sfw", "sfm", "orca", "mppi"]


def load(name, planner, *overrides):
    # (HuNavSim's people run into robots that stand.)
    return LoadScenario(
        filename=f"scenarios/{name}.yaml",
        overrides=[
            *(f"planner.type={planner}", "crowd.profile=default"),
            *overrides,
        ],
    )


@pytest.mark.slow
@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", ["passing", "crossing", "combined", "cafe"])
def test_reaches_the_goal_for_nearly_all_seeds(name, planner):
    scenario = load(name, planner)
    diagram = MakeTrialDiagram(scenario)
    results = [RunTrial(scenario, seed, diagram=diagram) for seed in range(10)]
    reasons = [result.end_reason for result in results]
    assert reasons.count("goal") >= 9, reasons
    for result in results:
        assert result.metrics["static_obstacle_collisions"] == 0
        if planner == "scl" and name in ("passing", "crossing"):
            # People may run into the robot, but it does not into them.
            assert result.metrics["robot_on_person_collisions"] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "planner", ["dwb", "scl", "sfw", "sfm", "orca", "mppi"]
)
@pytest.mark.parametrize("name", ["warehouse", "house"])
def test_reaches_the_goal_in_buildings(name, planner):
    """One seed of what `hunav bench planners` measures."""
    scenario = LoadScenario(
        filename=name, overrides=[f"planner.type={planner}"]
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal", result.end_message
    # Planned is with PMB2's radius: see docs/planners.md.
    walls = scenario.world.obstacles()
    way = result.recording.robot[:, :2]
    gaps = np.hypot(*(way - nearest_wall(walls, way)).T)
    assert gaps.min() > 0.27


@pytest.mark.slow
def test_sfw_does_not_stay_between_walls():
    """Their forces are weakest there, and would hold it forever."""
    scenario = LoadScenario(
        data="""
            world:
              walls:
                - {type: box, center: [0, 2.0], size: [0.2, 3.0]}
                - {type: box, center: [0, -2.0], size: [0.2, 3.0]}
            robot: {start: [0, 0, 0], goal: [4, 0, 0]}
            simulation: {duration: 30}
            """,
        overrides=["planner=sfw"],
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    patient = dataclasses.replace(scenario.planner, patience=60.0)
    held = RunTrial(dataclasses.replace(scenario, planner=patient))
    assert held.end_reason == "stuck"


@pytest.mark.slow
def test_scl_keeps_farther_from_people_than_dwb():
    """From those who leave it to the robot."""
    nearest = []
    for planner in PLANNERS:
        scenario = load("passing", planner, "crowd.robot_gap=0.0")
        run = RunTrial(scenario, 3).recording
        away = run.humans[:, :, :2] - run.robot[:, None, :2]
        nearest.append(np.hypot(*away.transpose(2, 0, 1)).min())
    assert nearest[1] > nearest[0] + 0.1


def test_a_trial_tells_why_its_planner_gave_up():
    scenario = LoadScenario(
        data="""
            world:
              walls:
                - type: polyline
                  points: [[2, -1], [4, -1], [4, 1], [2, 1], [2, -1]]
            robot: {goal: [3, 0, 0]}
            planner: dwb
            simulation: {duration: 30, stuck_time: 2}
            """
    )
    result = RunTrial(scenario)
    assert result.end_reason == "stuck"
    assert result.end_message.startswith(
        "the robot no longer gets anywhere; the planner: there is no path"
    )


@pytest.mark.slow
@pytest.mark.parametrize("planner", PLANNERS)
def test_a_fork_amid_people_has_the_same_future(planner):
    """Also in the middle of a plan, a map or a turn: bit for bit."""
    diagram = MakeTrialDiagram(load("crossing", planner))
    straight = Simulator(diagram)
    straight.AdvanceTo(6.0)
    for time in (0.97, 3.05, 4.43):
        forked = Simulator(diagram)
        forked.AdvanceTo(time)
        clone = Simulator(diagram, forked.get_context().Clone())
        for it in (clone, forked):
            it.AdvanceTo(6.0)
            for port in ("robot_state", "velocity_command", "planner_path"):
                np.testing.assert_array_equal(
                    diagram.GetOutputPort(port).Eval(it.get_context()),
                    diagram.GetOutputPort(port).Eval(straight.get_context()),
                )


def test_a_robot_that_is_held_from_behind_does_not_back_up_for_ever():
    """Another robot stands behind it, nearer than its costmap tells."""
    scenario = LoadScenario(
        data="""
world:
  walls:
    - {type: box, center: [2, 0.55], size: [8, 0.2]}
    - {type: box, center: [2, -0.55], size: [8, 0.2]}
humans: [{name: ana, pose: [0.9, 0, 3.14]}]
robots:
  - name: a
    robot: {start: [0, 0, 0], goal: [4, 0, 0]}
    planner: {type: dwb, profile: humble, recoveries: {spin_angle: 0.0}}
  - name: b
    robot: {start: [-0.72, 0, 0]}
    planner: {type: stand}
simulation: {duration: 20.0, stuck_time: 100.0}
"""
    )
    diagram = MakeTrialDiagram(scenario)
    planner = diagram.GetSubsystemByName("a_planner")
    simulator = MakeTrialSimulator(diagram)
    since = []
    for k in range(1, 21):
        simulator.AdvanceTo(float(k))
        own = planner.GetMyContextFromRoot(simulator.get_context())
        if planner.GetReason(own).startswith("recovers (back_up)"):
            since.append(k)
    assert 9 <= len(since) <= 12
    assert since[-1] < 19
