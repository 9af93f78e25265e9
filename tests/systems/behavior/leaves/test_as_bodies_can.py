"""Additions of leaves to the original: hysteresis, gradual stops, gaps."""

import math

import numpy as np
import pytest

from hunav_drake.systems.behavior import NodeStatus, ParseTree, Person
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people.human_config import HumanConfig
from tests.systems.behavior.ticks import wish

STEP = 0.05


def row(x, y, yaw=0.0, vx=0.0, vy=0.0, radius=0.35):
    return np.array([x, y, yaw, vx, vy, 0.0, radius])


class Ticks:
    """A tree that is ticked again and again."""

    def __init__(self, xml, **kwargs):
        source = f"<root><BehaviorTree>{xml}</BehaviorTree></root>"
        self.tree = ParseTree(source)
        human = HumanConfig(
            **{"pose": (0, 0, 0), "goals": [(9.0, 0.0)], **kwargs}
        )
        self.who = Person.from_config(human, 0, time_step=STEP)
        self.memory = self.tree.initial_memory(self.who)

    def __call__(self, human, *robots):
        outcome = self.tree.tick(
            self.who, self.memory, human, np.concatenate([*robots, []])
        )
        self.memory = outcome.memory
        return outcome

    def holds(self, human, *robots):
        return self(human, *robots).node_status is NodeStatus.SUCCESS


class TestHysteresis:
    def test_noticed_robot_counts_farther_away(self):
        dut = Ticks('<IsRobotVisible distance="4" hysteresis="1"/>')
        held = [dut.holds(row(0, 0), row(x, 0)) for x in (4.5, 3.9, 4.9, 5.1)]
        assert held == [False, True, True, False]
        # It has to come nearer again.
        assert not dut.holds(row(0, 0), row(4.5, 0))

    def test_it_is_not_for_another_robot(self):
        dut = Ticks('<IsRobotVisible distance="4" hysteresis="1"/>')
        near, far = row(3.0, 0), row(20.0, 0)
        assert dut.holds(row(0, 0), near, far)
        assert not dut.holds(row(0, 0), far, row(4.5, 0))

    def test_tracking_reaches_as_far(self):
        dut = Ticks(
            '<IsRobotVisible distance="4" hysteresis="1" track="true"'
            ' memory="0.1"/>'
        )
        assert dut.holds(row(0, 0), row(3, 0))
        for _ in range(50):
            assert dut.holds(row(0, 0), row(-4.5, 0))
        held = [dut.holds(row(0, 0), row(-5.5, 0)) for _ in range(4)]
        assert held == [True, True, False, False]

    def test_without_it_the_distance_is_one(self):
        dut = Ticks('<IsRobotVisible distance="4"/>')
        held = [dut.holds(row(0, 0), row(x, 0)) for x in (3.9, 4.1)]
        assert held == [True, False]


WALKING = row(0, 0, 0, 1.0)
STOPS = [
    '<SurprisedNav deceleration="2"/>',
    '<StandStill deceleration="2"/>',
    '<CuriousNav deceleration="2" stop_distance="3"/>',
]


@pytest.mark.parametrize("xml", STOPS)
def test_stops_take_their_time(xml):
    robot = row(2.0, 1.0)
    command = wish(Ticks(xml)(WALKING, robot))
    assert not command[Command.HOLD]
    assert command[Command.MAX_SPEED] == pytest.approx(1.0 - 2 * STEP)
    # Straight on, and turning to the robot.
    assert command[Command.GOAL_Y] == 0.0
    assert command[Command.YAW_TARGET] == pytest.approx(math.atan2(1, 2))
    slow = wish(Ticks(xml)(row(0, 0, 0, 0.09), robot))
    assert slow[Command.HOLD]
    at_once = xml.replace('deceleration="2"', "")
    assert wish(Ticks(at_once)(WALKING, robot))[Command.HOLD]


def test_scared_person_slows_down_in_time():
    command = wish(Ticks('<ScaredNav deceleration="2"/>')(WALKING, row(2, 1)))
    assert command[Command.DESIRED_SPEED] == 0.6
    assert command[Command.MAX_SPEED] == pytest.approx(1.0 - 2 * STEP)


def test_curious_person_slows_down_before_the_place():
    dut = Ticks('<CuriousNav deceleration="2"/>')
    standing = row(0, 0)
    speeds = [
        wish(dut(standing, row(1.5 + left, 0)))[Command.MAX_SPEED]
        for left in (0.005, 0.02, 2.0)
    ]
    assert speeds[:2] == pytest.approx([0.1, 0.2])
    # Far away as ever: 1.8 m/s at 10 m.
    assert speeds[2] == pytest.approx(0.18 * 3.5)


def test_stepping_aside_slows_down_before_the_spot():
    dut = Ticks('<MakeWay deceleration="2" speed="9"/>')
    coming = row(4.0, 0.0, math.pi, -0.5)
    assert wish(dut(row(0, 0), coming))[Command.MAX_SPEED] == 1.2
    near = wish(dut(row(0, -0.92), coming))
    assert near[Command.MAX_SPEED] == pytest.approx(0.4)
    # The wish is as strong as ever, against walls nearby.
    assert near[Command.DESIRED_SPEED] == 1.2


def test_who_stands_is_met_from_any_side():
    coming = row(3.0, 0.0, math.pi, -0.5)
    away = row(0, 0, math.pi)
    walking = row(0, 0, math.pi, -1.0)
    xml = '<IsRobotApproaching distance="5" head_on="true"'
    assert not Ticks(f"{xml}/>").holds(away, coming)
    assert Ticks(f'{xml} at_rest="true"/>').holds(away, coming)
    assert not Ticks(f'{xml} at_rest="true"/>').holds(walking, coming)


@pytest.mark.parametrize("radius", [0.35, 1.0])
def test_gap_is_between_bodies_of_any_size(radius):
    robot = row(4.0, 0.1, math.pi, radius=radius)
    keep = 0.35 + radius + 0.3
    xml = '<PassBy distance="5" clearance="0" gap="0.3" status="0"/>'
    outcome = Ticks(xml)(row(0, 0), robot)
    assert outcome.behavior_status == 0
    assert wish(outcome)[Command.GOAL_Y] == pytest.approx(0.1 - keep)
    for beside, expected in ((keep - 0.01, True), (keep + 0.01, False)):
        dut = Ticks('<IsRobotInTheWay distance="5" clearance="0" gap="0.3"/>')
        at = row(4.0, beside, math.pi, radius=radius)
        assert dut.holds(row(0, 0), at) == expected
