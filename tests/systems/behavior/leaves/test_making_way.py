"""People who stand in a robot's way make room when it has waited."""

import dataclasses
import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.behavior import (
    BehaviorConfig,
    LoadTree,
    NodeStatus,
    Person,
)
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.behavior.ticks import at, tree_of

POLITE = [
    "regular",
    "surprised",
    "scared",
    "curious",
    "distracted",
    "cooperative",
]


# It faces the person, 0.5 m off.
WAITING = at(1.2, 0.0, math.pi)


def person(goals=(), obstacles=None):
    config = HumanConfig(pose=(0, 0, 0), goals=list(goals))
    return Person.from_config(config, 0, time_step=0.05, obstacles=obstacles)


class Ticks:
    """A tree that is ticked again and again."""

    def __init__(self, tree, who=None):
        self.tree, self.who = tree, who or person()
        self.memory = tree.initial_memory(self.who)

    def __call__(self, human, robot):
        outcome = self.tree.tick(self.who, self.memory, human, robot)
        self.memory = outcome.memory
        return outcome

    def until_success(self, human, robot, most):
        """Returns how many ticks it takes, or None."""
        for count in range(1, most + 1):
            status = self(human, robot).node_status
            if status is NodeStatus.SUCCESS:
                return count
        return None


class TestIsRobotWaiting:
    def dut(self, ports="", **kwargs):
        return Ticks(tree_of(f"<IsRobotWaiting {ports}/>"), person(**kwargs))

    def test_holds_once_both_have_stood_for_the_time(self):
        # (The first tick sees where they are.)
        dut = self.dut()
        assert dut.until_success(at(0, 0), WAITING, 200) == 101
        assert dut.until_success(at(0, 0), WAITING, 200) == 101
        quick = self.dut('seconds="1"')
        assert quick.until_success(at(0, 0), WAITING, 200) == 21

    @pytest.mark.parametrize(
        "robot",
        [
            at(1.2, 0.0, 0.0),
            at(1.2, 0.0, math.pi / 2),
            at(1.2, 1.0, math.pi),
            at(1.8, 0.0, math.pi),
        ],
        ids=["turned away", "turned aside", "beside", "far"],
    )
    def test_does_not_hold_otherwise(self, robot):
        assert self.dut().until_success(at(0, 0), robot, 200) is None

    def test_does_not_hold_while_one_of_them_moves(self):
        dut = self.dut()
        for step in range(200):
            moved = at(0.0, 0.008 * step)
            robot = at(1.2, 0.008 * step, math.pi)
            assert dut(moved, robot).node_status is NodeStatus.FAILURE

    def test_trembling_is_standing(self):
        dut = self.dut()
        held = [
            dut(at(0.1 * (-1) ** k, 0.0, 0.0, 1.0), WAITING).node_status
            for k in range(110)
        ]
        assert held.count(NodeStatus.SUCCESS) == 1

    def test_wall_between_ends_it(self):
        wall = Obstacles.from_shapes([[[0.6, -1.0], [0.6, 1.0]]], solid=[False])
        dut = self.dut(obstacles=wall)
        assert dut.until_success(at(0, 0), WAITING, 200) is None
        dut = self.dut('occlusion="false"', obstacles=wall)
        assert dut.until_success(at(0, 0), WAITING, 200) == 101

    def test_can_ask_only_those_on_their_way(self):
        dut = self.dut('with_goal="true"')
        assert dut.until_success(at(0, 0), WAITING, 200) is None
        dut = self.dut('with_goal="true"', goals=[(5.0, 0.0)])
        assert dut.until_success(at(0, 0), WAITING, 200) == 101


class TestMakeWay:
    def spot(self, walls=(), human=None):
        """Returns the last spot that the person walks to, in steps."""
        obstacles = Obstacles.from_shapes(walls, solid=[False] * len(walls))
        dut = Ticks(tree_of("<MakeWay/>"), person(obstacles=obstacles))
        human = at(0.0, 0.0) if human is None else human
        way = []
        for _ in range(60):
            outcome = dut(human, WAITING)
            if outcome.node_status is not NodeStatus.RUNNING:
                return None
            assert outcome.behavior_status == 2
            if outcome.command[Command.HOLD]:
                return way
            goal = outcome.command[: Command.GOAL_Y + 1]
            way.append(goal)
            # There at once.
            human = at(*goal)
        return way

    def test_steps_aside_where_there_is_room(self):
        ((x, y),) = self.spot()
        assert x == pytest.approx(0.0)
        # Two bodies and 0.3 m between.
        assert abs(y) == pytest.approx(1.0)

    def test_steps_back_out_of_a_door_first(self):
        """The robot is in front of a passage 1 m long; people are in it."""
        walls = [[[-1.0, s * 0.5], [1.0, s * 0.5]] for s in (1, -1)]
        (back, aside) = self.spot(walls)
        # All of the body.
        assert -1.7 < back[0] < -1.35
        assert back[1] == pytest.approx(0.0)
        assert aside[0] == pytest.approx(back[0])
        assert abs(aside[1]) == pytest.approx(1.0)

    def test_goes_away_where_there_is_no_room(self):
        """Until it is 3 m ahead of the robot, body to body."""
        walls = [[[-9.0, s * 0.5], [9.0, s * 0.5]] for s in (1, -1)]
        way = self.spot(walls)
        x, y = np.transpose(way)
        assert (np.diff(x) < 0).all()
        assert y == pytest.approx(np.zeros(len(way)))
        assert x[-1] < 1.2 - 0.7 - 3.0

    def test_takes_what_room_there_is(self):
        walls = [[[-9.0, y], [9.0, y]] for y in (-0.5, 1.1)]
        ((_, y),) = self.spot(walls)
        # 1.1 m less the body, which all but touches the wall.
        assert y == pytest.approx(1.1 - 0.25 - 0.03)

    def test_ends_when_the_robot_has_passed(self):
        dut = Ticks(tree_of("<MakeWay/>"))
        aside = at(0.0, 1.0)
        assert dut(at(0, 0), WAITING).node_status is NodeStatus.RUNNING
        for x in (1.0, 0.0, -0.6):
            outcome = dut(aside, at(x, 0.0, math.pi, -0.6))
            assert outcome.node_status is NodeStatus.RUNNING
        outcome = dut(aside, at(-0.8, 0.0, math.pi, -0.6))
        assert outcome.node_status is NodeStatus.SUCCESS

    def test_is_for_the_robot_that_has_waited(self):
        """Also when another one comes nearer."""
        dut = Ticks(tree_of("<Sequence><IsRobotWaiting/><MakeWay/></Sequence>"))
        other = at(-3.0, 0.0)
        for _ in range(102):
            outcome = dut(at(0, 0), np.concatenate([other, WAITING]))
        assert outcome.node_status is NodeStatus.RUNNING
        y = outcome.command[Command.GOAL_Y]
        near = at(-1.1, y)
        standing = dut(at(0.0, y), np.concatenate([near, WAITING]))
        target = standing.command[Command.YAW_TARGET]
        assert target == pytest.approx(math.atan2(-y, 1.2))

    def test_ends_after_its_time_if_the_robot_does_not_drive_on(self):
        dut = Ticks(tree_of('<MakeWay seconds="1"/>'))
        dut(at(0, 0), WAITING)
        assert dut.until_success(at(0.0, 1.0), WAITING, 100) == 19

    def test_without_a_robot_it_fails(self):
        dut = Ticks(tree_of("<MakeWay/>"))
        status = dut(at(0, 0), np.zeros(0)).node_status
        assert status is NodeStatus.FAILURE


@pytest.mark.parametrize("name", [*POLITE, "impassive", "threatening"])
def test_who_stands_and_is_asked_steps_aside(name):
    """Unless impassive, or told not to; the threatening when they are done."""
    ports = {}
    if name in ("surprised", "scared", "curious", "threatening"):
        # (After the reaction.)
        ports["duration"] = 0.0
    if name == "cooperative":
        # (It steps aside at once, and that is another reaction.)
        ports["distance"] = 0.0

    def makes_way(**other):
        dut = Ticks(LoadTree(name, ports | other))
        return any(
            dut(at(0.0, 0.0, math.pi), WAITING).behavior_status == 2
            for _ in range(150 if name in POLITE else 250)
        )

    assert makes_way() == (name != "impassive")
    assert name not in POLITE or not makes_way(make_way=False)


def in_a_door(behavior, width, model="social_force"):
    """Returns the trial of a person and a robot who meet in a door."""
    scenario = LoadScenario(
        filename="reaction_distracted",
        overrides=[
            f"crowd.model={model}",
            "simulation.duration=70",
            "simulation.stuck_time=60",
            "robot.start=[-5, 0, 0]",
        ],
    )
    beside = 4.0 - width / 2
    jambs = [
        dataclasses.replace(
            scenario.world.walls[0],
            name=name,
            center=(0.0, side * (width / 2 + beside / 2)),
            size=(0.2, beside),
        )
        for name, side in (("left", 1), ("right", -1))
    ]
    world = dataclasses.replace(
        scenario.world, walls=[*scenario.world.walls, *jambs]
    )
    (human,) = scenario.humans
    human = dataclasses.replace(
        human,
        behavior=behavior,
        pose=(3.0, 0.05, math.pi),
        goals=[(-6.0, 0.05)],
    )
    scenario = dataclasses.replace(scenario, world=world, humans=[human])
    return RunTrial(scenario)


@pytest.mark.parametrize("behavior", ["regular", "distracted", "impassive"])
@pytest.mark.parametrize("width", [0.9, 1.8])
def test_one_steps_back_where_two_meet_in_a_door(behavior, width):
    """With a model of motion in which bodies do not overlap."""
    result = in_a_door(behavior, width, "orca")
    assert result.end_reason == "goal"
    recording = result.recording
    person = recording.humans[:, 0]
    gap = np.hypot(*(person[:, :2] - recording.robot[:, :2]).T) - 0.7
    assert gap.min() > 0
    # The person is through the door, too.
    assert person[-1, 0] < -2.0
    waited = (recording.behavior_status == 2).sum()
    # (The distracted are through the narrow one before the robot.)
    assert width > 1 or waited > 10 or behavior == "distracted"


def test_two_who_meet_in_a_door_stand_for_ever_without_it():
    behavior = BehaviorConfig(type="regular", ports={"make_way": False})
    result = in_a_door(behavior, 0.9, "orca")
    assert result.end_reason != "goal"
