"""Beside robots and before them: the tests of the specification, by number."""

import math

import numpy as np
import pytest

from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.common.layout import Activity, Signal
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.shapes import Polyline, World
from tests.vocabulary.stage import DT, Stage, robot_at, someone

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


def turning(speed, rate):
    """Returns a robot that drives along a circle."""

    def state(t):
        yaw, far = rate * t, speed / rate
        vx, vy = speed * math.cos(yaw), speed * math.sin(yaw)
        x, y = far * math.sin(yaw), far * (1 - math.cos(yaw))
        return [x, y, yaw, vx, vy, rate, 0.3]

    return state


def place_beside(stage):
    """Returns where a person is ahead and to the left of the robot."""
    x, y, yaw = stage.robot[:3]
    dx, dy = stage.states[0, :2] - [x, y]
    c, s = math.cos(yaw), math.sin(yaw)
    return dx * c + dy * s, dy * c - dx * s


@pytest.mark.parametrize("speed", [0.4, 0.8, 1.2])
@pytest.mark.parametrize("rate", [0.0, 0.1, -0.1])
def test_28_a_person_accompanies_a_robot(speed, rate):
    robot = turning(speed, rate) if rate else robot_at(0, 0, 0, speed)
    person = someone(-1, -0.6, 0, "<AccompanyRobot/>", max_speed=1.6)
    stage = Stage([person], robot=robot)
    for t in stage.run(20.0):
        if t > 6:
            along, beside = place_beside(stage)
            assert beside == pytest.approx(-1.0, abs=0.1)
            assert along == pytest.approx(0.0, abs=0.15)
    assert stage.signal(0, Signal.ACTIVITY) == Activity.ACCOMPANY


def test_who_accompanies_a_robot_stands_when_it_does():
    def robot(t):
        goes = t < 8
        return [0.8 * min(t, 8), 0, 0, 0.8 * goes, 0, 0, 0.3]

    node = '<AccompanyRobot name="it" side="left" ahead="0.5" duration="12"/>'
    stage = Stage([someone(-1, -0.6, 0, node)], robot=robot)
    still, found = [], []
    for t in stage.run(12.5):
        found.append(stage.statuses(0)["it"])
        if 10 < t < 11.9:
            still.append(stage.states[0].copy())
    assert np.ptp(still, axis=0)[:3].max() < 1e-9
    assert place_beside(stage) == pytest.approx((0.5, 1.0), abs=0.3)
    assert found.index(S) == pytest.approx(12 / DT - 2, abs=1)


@pytest.mark.parametrize(("wall", "side"), [(-0.9, 1), (0.9, -1)])
def test_the_side_with_more_room_is_chosen(wall, side):
    walls = World(walls=[Polyline(points=[(-9, wall), (20, wall)])])
    person = someone(-2, 0, 0, "<AccompanyRobot/>")
    stage = Stage([person], robot=robot_at(0, 0, 0, 0.6), obstacles=walls)
    for _ in stage.run(8.0):
        pass
    assert place_beside(stage)[1] == pytest.approx(side, abs=0.1)


LOOK = '<SubTree ID="StopAndLookTree"/>'


def test_29_a_person_stops_once_for_each_time_that_a_robot_passes():
    def robot(t):
        """Passes, drives on by 4 m, and returns."""
        x, speed = (6 - 0.5 * t, -0.5) if t < 20 else (-14 + 0.5 * t, 0.5)
        return [x, 1.0, 0, speed, 0, 0, 0.3]

    stage = Stage(
        [
            someone(
                0,
                0,
                0,
                LOOK,
                goals=[(0, -0.6), (0, 0)],
                cyclic=True,
                goal_radius=0.1,
            )
        ],
        robot=robot,
    )
    found = [stage.statuses(0)["StandStill"] for _ in stage.run(40.0)]
    stops = np.flatnonzero(np.diff([0, *(np.array(found) > 0), 0]))
    lengths = (stops[1::2] - stops[::2]) * DT
    assert lengths == pytest.approx([2.0, 2.0], abs=DT)
    assert stops[2] - stops[0] > 4 / 0.5 / DT


@pytest.mark.slow
def test_a_share_of_goals_is_drawn_anew():
    """0.3 of the chances, among all other places alike."""
    places = [Place(name=f"p{i}", pose=(3.0 * i, 2.0, 0)) for i in range(4)]
    node = '<SubTree ID="RandomGoalsTree" period="0.5"/>'
    people = [someone(3.0 * i, 0, 0, node) for i in range(6)]
    stage = Stage(people, places=places, seed=3)
    tried, chosen = 0, np.zeros(4)
    for _ in stage.run(110.0):
        for i in range(6):
            found = stage.statuses(i)
            tried += found["RandomChanceCondition"] != 0
            if found["SetRandomGoal"] == S:
                chosen[round(stage.command(i)[0] / 3)] += 1
    assert tried > 1000
    assert chosen.sum() / tried == pytest.approx(0.3, abs=0.05)
    assert chosen / chosen.sum() == pytest.approx([0.25] * 4, abs=0.06)


def corridor(width):
    off = width / 2
    return World(
        walls=[Polyline(points=[(-9, y), (20, y)]) for y in (-off, off)]
    )


WAIT = '<Sequence><Inverter><WaitForFreeWay name="it"/></Inverter></Sequence>'


def test_30_a_person_waits_before_a_robot_that_bars_the_way():
    def robot(t):
        x, vy = (4, 0) if t < 10 else (4, 1.0)
        return [x, max(0.0, t - 10), 1.57, 0, vy, 0, 0.3]

    stage = Stage(
        [someone(-2, 0, 0, WAIT, goals=[(9, 0)])],
        robot=robot,
        obstacles=corridor(1.2),
    )
    moving = None
    for t in stage.run(12.0):
        x, speed = stage.states[0, 0], stage.states[0, 3]
        if 7 < t < 10:
            assert 1.35 <= 4 - x <= 1.65
            assert speed == 0
            assert stage.signal(0, Signal.ACTIVITY) == Activity.WAIT
        free = stage.statuses(0)["it"] == S
        if t > 10 and free:
            moving = moving or t
        if moving and t >= moving + 0.5:
            assert speed > 0.3
    assert moving


def test_30_nobody_waits_where_there_is_room():
    stage = Stage(
        [someone(-2, 0, 0, WAIT, goals=[(9, 0)])],
        robot=robot_at(4, 0),
        obstacles=corridor(3.0),
    )
    assert {stage.statuses(0)["it"] for _ in stage.run(9.0)} == {S}
    assert stage.states[0, 0] > 5
