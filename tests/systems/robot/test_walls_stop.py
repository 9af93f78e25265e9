"""Walls stop kinematic robots, and contacts with them are counted."""

import json
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    RunTrial,
    SaveContext,
)
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.planning import Plan, PlannerStatus, register_plan
from hunav_drake.systems.robot import (
    DifferentialDrive,
    DifferentialDriveConfig,
    RobotLimits,
)
from hunav_drake.systems.world.obstacles import Obstacles

RADIUS = 0.35
# A room of 4 x 4 m, around the origin.
ROOM = Obstacles.from_shapes(
    [[[-2, -2], [2, -2], [2, 2], [-2, 2], [-2, -2]]], solid=[False]
)
DEEPEST = 0.01 + 1e-9


def drive(commands, *, yaw=0.0, walls_stop=True, step=0.05, walls=ROOM):
    """Returns the rows of robot and wall contact, after each command."""
    config = DifferentialDriveConfig(
        start=(0, 0, yaw), radius=RADIUS, limits=RobotLimits()
    )
    dut = DifferentialDrive(
        config, time_step=step, obstacles=walls, walls_stop=walls_stop
    )
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    rows = []
    for command in commands:
        dut.get_velocity_command_input_port().FixValue(context, command)
        simulator.AdvanceTo(context.get_time() + step)
        rows.append(
            [
                dut.get_robot_state_output_port().Eval(context),
                dut.get_wall_contact_output_port().Eval(context),
            ]
        )
    robot, contact = zip(*rows, strict=True)
    return np.array(robot), np.array(contact)


def depths(robot):
    return np.abs(robot[:, :2]).max(axis=1) + RADIUS - 2


def test_a_robot_stops_at_a_wall_and_is_in_one_contact():
    robot, contact = drive([(0.8, 0)] * 100)
    # It arrives after 1.66 m, in which it speeds up to 0.8 m/s at 1 m/s^2.
    begin = int(np.argmax(contact[:, Contact.LASTS] > 0))
    expected = (1.66 - 0.32) / 0.8 + 0.8
    assert 0.05 * (begin + 1) == pytest.approx(expected, abs=0.1)
    assert depths(robot).max() == pytest.approx(0.01, abs=1e-9)
    # Its speed is what is left of it.
    np.testing.assert_allclose(robot[begin + 1 :, 3], 0, atol=1e-9)
    assert contact[-1, Contact.LASTS] == 1
    assert contact[-1, Contact.BY_ROBOT] == 1


def wall_at(x):
    return Obstacles.from_shapes([[[x, -50], [x, 50]]], solid=[False])


@pytest.mark.parametrize("step", [0.1, 0.05, 0.01])
@pytest.mark.parametrize("angle", [0, 30, 60, 80])
def test_it_slides_along_a_wall_as_fast_as_it_drives_that_way(angle, step):
    """Port wall_contact says so, for any time step and place."""
    along = 0.8 * math.sin(math.radians(angle))
    for x in (2.0, 2.013, 2.027):
        robot, contact = drive(
            [(0.8, 0)] * round(16 / step),
            yaw=math.radians(angle),
            step=step,
            walls=wall_at(x),
        )
        way = robot[-1, :2] - robot[-2, :2]
        np.testing.assert_allclose(way / step, (0, along), atol=1e-9)
        np.testing.assert_allclose(robot[-1, 3:5], (0, along), atol=1e-9)
        begin = int(np.argmax(contact[:, Contact.LASTS] > 0))
        into = 0.8 * math.cos(math.radians(angle))
        assert contact[begin, Contact.RELATIVE_SPEED] == pytest.approx(into)


def test_who_is_put_inside_a_wall_is_put_out_of_it_at_rest():
    solid = Obstacles.from_shapes(
        [[[-1, -3], [2, -3], [2, 3], [-1, 3]]], solid=[True]
    )
    robot, contact = drive([(0, 0)] * 60, walls=solid)
    np.testing.assert_array_equal(robot, robot[[0] * 60])
    assert robot[0, 0] == pytest.approx(-1 - RADIUS + 0.01)
    assert (robot[:, 3:6] == 0).all()
    assert contact[-1, Contact.RELATIVE_SPEED] == 0


def test_it_turns_away_from_a_wall():
    robot, contact = drive([(0.8, 0)] * 60 + [(0, 2.0)] * 40 + [(0.8, 0)] * 20)
    assert depths(robot)[-1] < -0.3
    assert contact[-1, Contact.LASTS] == 0
    assert contact[-1, Contact.BY_ROBOT] == 1


def test_another_push_is_another_contact():
    away = [(0, 0)] * 5 + [(-0.2, 0)] * 30
    robot, contact = drive(([(0.5, 0)] * 80 + away) * 3)
    assert contact[-1, Contact.BY_ROBOT] == 3
    assert depths(robot).max() <= DEEPEST


@pytest.mark.parametrize("step", [0.01, 0.05, 0.5])
def test_no_step_is_too_long_or_short(step):
    commands = [(1.0, 0.3)] * round(30 / step)
    robot, contact = drive(commands, step=step)
    assert depths(robot).max() <= DEEPEST
    assert contact[-1, Contact.BY_ROBOT] >= 1


def test_walls_that_do_not_stop_it_are_counted_too():
    robot, contact = drive([(0.8, 0)] * 100, walls_stop=False)
    free, _ = drive([(0.8, 0)] * 20)
    np.testing.assert_array_equal(robot[:20], free)
    assert robot[-1, 0] > 3
    assert contact[-1, Contact.BY_ROBOT] == 1
    _, stopped = drive([(0.8, 0)] * 100)
    begins = [
        int(np.argmax(rows[:, Contact.LASTS] > 0))
        for rows in (contact, stopped)
    ]
    assert begins[0] == begins[1]


def test_a_clone_has_the_same_future():
    config = DifferentialDriveConfig(start=(0, 0, 0.3), radius=RADIUS)
    dut = DifferentialDrive(config, obstacles=ROOM)
    context = dut.CreateDefaultContext()
    simulator = Simulator(dut, context)
    dut.get_velocity_command_input_port().FixValue(context, (0.8, 0.1))
    simulator.AdvanceTo(2.4)
    clone = simulator.get_context().Clone()
    Simulator(dut, dut.CreateDefaultContext())
    ends = []
    for it in (clone, simulator.get_mutable_context()):
        other = Simulator(dut, it)
        other.AdvanceTo(6.0)
        ends.append(it.get_discrete_state(1).value().copy())
        ends.append(it.get_discrete_state(0).value().copy())
    np.testing.assert_array_equal(ends[0], ends[2])
    np.testing.assert_array_equal(ends[1], ends[3])
    assert ends[0][Contact.BY_ROBOT] == 1


@register_plan("blind_ahead")
def blind_ahead(task, view, memory):
    """Drives straight on, whatever is there."""
    return Plan(0.5, 0.0, PlannerStatus.DRIVING)


def blind_trial(**robot):
    return {
        "robot": {"start": [0, 0, 0], "goal": [6, 0, 0], **robot},
        "world": {
            "walls": [{"type": "box", "center": [3, 0], "size": [0.2, 4]}]
        },
        "planner": "blind_ahead",
        "simulation": {"duration": 12.0, "stuck_time": 60.0},
    }


@pytest.mark.parametrize("period", [0.05, 1.0])
@pytest.mark.parametrize("walls_stop", [True, False])
def test_a_trial_counts_contacts_with_walls(period, walls_stop):
    data = blind_trial(walls_stop=walls_stop)
    data["evaluator"] = {"period": period}
    result = RunTrial(LoadScenario(data=json.dumps(data)))
    assert result.metrics["contacts_with_walls"] == 1
    assert result.recording.wall_contact.shape == (len(result.recording), 8)
    assert (result.end_reason == "goal") != walls_stop


def test_a_saved_context_and_recording_keep_contacts_with_walls(tmp_path):
    scenario = LoadScenario(data=json.dumps(blind_trial()))
    diagram = MakeTrialDiagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(7.0)
    SaveContext(diagram, simulator.get_context(), tmp_path / "a.npz")
    loaded = LoadContext(diagram, tmp_path / "a.npz")
    recordings = []
    for context in (simulator.get_context(), loaded):
        evaluator = diagram.GetSubsystemByName("evaluator")
        own = evaluator.GetMyContextFromRoot(context)
        recordings.append(evaluator.GetRecording(own))
    one, other = recordings
    assert one == other
    assert one.wall_contact[-1, Contact.BY_ROBOT] == 1
    one.save(tmp_path / "b.npz")
    assert Recording.load(tmp_path / "b.npz") == one
