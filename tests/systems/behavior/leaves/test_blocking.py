"""Getting in the way of a robot: around it, not through it, and staying."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import NodeStatus, ParseTree, Person
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import MakeHumans
from tests.systems.behavior.ticks import as_original

BODIES = 0.7


def tick(xml, human, robot, memory=None, **kwargs):
    tree = ParseTree(f"<root><BehaviorTree>{xml}</BehaviorTree></root>")
    config = HumanConfig(pose=(0, 0, 0), goals=[(9.0, 0.0)])
    who = Person.from_config(config, 0, time_step=0.05, **kwargs)
    memory = memory or tree.initial_memory(who)
    return tree.tick(who, memory, np.array(human), np.array(robot))


def row(x, y, yaw=0.0, vx=0.0, vy=0.0, radius=0.35):
    return [x, y, yaw, vx, vy, 0.0, radius]


def follow(
    robot_at, steps, pose, *, behavior="threatening", model="", obstacles=None
):
    """Returns the states of a person, and of the robot, step by step."""
    human = HumanConfig(pose=pose, goals=[(60.0, 0.0)], behavior=behavior)
    config = CrowdConfig(model=model) if model else None
    diagram = MakeHumans([human], config=config, obstacles=obstacles)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    humans, robots, active = [], [], []
    for step in range(steps):
        robot = robot_at(0.05 * step)
        diagram.GetInputPort("robot_states").FixValue(context, robot)
        simulator.AdvanceTo(0.05 * (step + 0.5))
        port = diagram.GetOutputPort("human_states")
        humans.append(port.Eval(context).copy())
        robots.append(robot)
        status = diagram.GetOutputPort("behavior_status").Eval(context)
        active.append(status[0])
    return np.array(humans), np.array(robots), np.array(active)


def gaps(humans, robots):
    return np.hypot(*(humans - robots)[:, :2].T) - BODIES


def off_front(humans, robots):
    yaw = robots[:, 2]
    front = robots[:, :2] + 1.1 * np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    return np.hypot(*(humans[:, :2] - front).T)


def drives(t, speed=0.6):
    return row(speed * t, 0.0, 0.0, speed)


@pytest.mark.parametrize("model", ["", "orca"])
@pytest.mark.parametrize("bearing", np.linspace(-math.pi, math.pi, 9))
def test_person_overtakes_a_driving_robot_at_a_distance(bearing, model):
    """HuNavSim's walks through it: 0.01 m from center to center."""
    pose = (3 * math.cos(bearing), 3 * math.sin(bearing), bearing + math.pi)
    humans, robots, active = follow(drives, 300, pose, model=model)
    assert gaps(humans, robots).min() > 0.15
    # It does not lose it by turning away from it.
    assert active.all()
    assert off_front(humans, robots)[120:].max() < 0.35


def test_original_walks_into_the_robot():
    humans, robots, _ = follow(
        drives, 300, (-3.0, 0.0, 0.0), behavior=as_original("threatening")
    )
    # (And through it, were bodies not kept apart.)
    assert gaps(humans, robots).min() < 0.0


def test_person_in_front_neither_shakes_nor_drifts():
    """HuNavSim's steps to and fro at 2.2 Hz, with up to 8 m/s^2."""
    humans, robots, _ = follow(lambda t: row(0.0, 0.0), 400, (-3.0, 0.5, 0.0))
    # From standing there on.
    late = humans[160:]
    assert np.hypot(late[:, 3], late[:, 4]).max() < 0.02
    assert off_front(late, robots[160:]).max() < 0.1
    bearing = np.arctan2(-late[:, 1], -late[:, 0])
    turn = np.angle(np.exp(1j * (bearing - late[:, 2])))
    assert np.abs(turn).max() < 0.05


def test_speed_changes_as_bodies_can():
    humans, _, _ = follow(drives, 300, (-3.0, 0.2, 0.0))
    change = np.diff(humans[:, 3:5], axis=0) / 0.05
    assert np.hypot(*change.T).max() < 2.8
    assert np.hypot(humans[:, 3], humans[:, 4]).max() <= 2.0 + 1e-9


def test_person_stays_before_a_robot_that_turns():
    humans, robots, active = follow(
        lambda t: row(0.0, 0.0, 0.5 * t), 300, (2.0, 0.0, math.pi)
    )
    assert active.all()
    assert gaps(humans, robots).min() > 0.25
    assert off_front(humans, robots)[60:].max() < 0.5


def test_who_blocks_holds_the_ground_until_the_robot_is_near():
    """Then gives way, no faster than the robot comes."""
    xml = "<BlockRobot/>"
    slow = tick(xml, row(1.1, 0.0), row(0.0, 0.0, 0.0, 0.3))
    assert slow.command[Command.HOLD] == 1
    near = tick(xml, row(0.8, 0.0), row(0.0, 0.0, 0.0, 0.3))
    assert near.command[Command.HOLD] == 0
    assert near.command[Command.GOAL_X] > 0.8


def test_wide_robot_is_met_farther_off():
    robot = row(0.0, 0.0, radius=1.0)
    outcome = tick("<BlockRobot/>", row(2.0, 0.0), robot)
    # 1 m, 0.35 m and 0.3 m between, and a little more.
    assert outcome.command[Command.GOAL_X] < 2.0
    there = tick("<BlockRobot/>", row(1.7, 0.0), robot)
    assert there.command[Command.HOLD] == 1


@pytest.mark.parametrize(("y", "side"), [(0.2, 1), (-0.2, -1), (0.0, 1)])
def test_side_from_behind_is_the_persons_and_is_kept(y, side):
    outcome = tick("<BlockRobot/>", row(-2.0, y), row(0.0, 0.0))
    assert (outcome.command[Command.GOAL_Y] - y) * side > 0
    other = tick("<BlockRobot/>", row(-2.0, -y), row(0.0, 0.0), outcome.memory)
    assert (other.command[Command.GOAL_Y] + y) * side > 0


def test_side_without_a_wall_is_taken():
    wall = Obstacles.from_shapes([[[-5.0, 0.9], [5.0, 0.9]]], solid=[False])
    outcome = tick(
        "<BlockRobot/>", row(-2.0, 0.1), row(0.0, 0.0), obstacles=wall
    )
    assert outcome.command[Command.GOAL_Y] < 0.1


def test_person_stays_behind_where_there_is_no_way_around():
    walls = Obstacles.from_shapes(
        [[[-9.0, y], [30.0, y]] for y in (-1.0, 1.0)], solid=[False, False]
    )
    humans, robots, active = follow(
        drives, 300, (-3.0, 0.1, 0.0), obstacles=walls
    )
    assert active.all()
    assert (humans[:, 0] < robots[:, 0]).all()
    assert gaps(humans, robots).min() > 0.25
    assert gaps(humans, robots)[120:].max() < 0.8


@pytest.mark.parametrize(("wall", "stands"), [(1.2, True), (1.42, False)])
def test_nobody_walks_into_the_wall_before_a_robot(wall, stands):
    walls = Obstacles.from_shapes([[[wall, -5.0], [wall, 5.0]]], solid=[False])
    command = tick(
        "<BlockRobot/>", row(1.07, 1.5), row(0.0, 0.0), obstacles=walls
    ).command
    assert (command[Command.HOLD] == 1) == stands
    if stands:
        expected = math.atan2(-1.5, -1.07)
        assert command[Command.YAW_TARGET] == pytest.approx(expected)
    else:
        # Straight to the place that there is.
        assert command[Command.GOAL_X] == pytest.approx(1.07)
        assert command[Command.GOAL_Y] < 1.5


def test_without_a_robot_it_fails():
    tree = ParseTree("<root><BehaviorTree><BlockRobot/></BehaviorTree></root>")
    who = Person.from_config(HumanConfig(pose=(0, 0, 0)), 0, time_step=0.05)
    outcome = tree.tick(
        who, tree.initial_memory(who), np.array(row(0, 0)), np.zeros(0)
    )
    assert outcome.node_status is NodeStatus.FAILURE
