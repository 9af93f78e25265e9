"""Giving way at doors: the tests of the specification, by number."""

import json
import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.behavior import BehaviorTreeError, NodeStatus
from hunav_drake.systems.common.layout import Activity, Gesture, Signal
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situations import FindSituations
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.shapes import Polyline, World
from tests.vocabulary.stage import DT, Stage, robot_at, someone

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE

DOOR = Place(name="door", type="door", pose=(0, 0, 0))
WAY = '<GiveWayAtDoor name="it" place="door"/>'


def room(width):
    """Two rooms with a door between them."""
    off = width / 2
    return World(
        walls=[
            Polyline(points=[(0, -6), (0, -off)]),
            Polyline(points=[(0, off), (0, 6)]),
        ]
    )


def comer(side, generator, node=WAY, **more):
    y, goal = generator.uniform(-1.5, 1.5, 2)
    x = side * generator.uniform(3.5, 5.5)
    yaw = 0.0 if side < 0 else math.pi
    return someone(x, y, yaw, node, goals=[(-5 * side, goal)], **more)


@pytest.mark.parametrize(
    "seed",
    [0, 1, *(pytest.param(it, marks=pytest.mark.slow) for it in range(2, 30))],
)
def test_27_of_two_who_meet_at_a_door_one_waits(seed):
    generator = np.random.default_rng(seed)
    people = [comer(side, generator) for side in (-1, 1)]
    stage = Stage(people, places=[DOOR], obstacles=room(0.9))
    waited, through, least = set(), {}, math.inf
    for t in stage.run(14.0):
        least = min(least, stage.distance(0, 1))
        for i, it in enumerate(people):
            if stage.statuses(i)["it"] == R:
                waited.add(i)
            if stage.states[i, 0] * it.goals[0][0] > 0:
                through.setdefault(i, t)
    assert len(waited) == 1
    assert len(through) == 2
    assert least >= 0.5


def test_27_a_person_waits_while_a_robot_is_in_the_door():
    def robot(t):
        x = 0.3 if t < 8 else 0.3 + 0.8 * (t - 8)
        return [x, 0, 0, 0.8 * (t >= 8), 0, 0, 0.3]

    person = someone(-4, 0.5, 0, WAY, goals=[(4, 2)])
    stage = Stage([person], places=[DOOR], obstacles=room(0.9), robot=robot)
    still = []
    for t in stage.run(14.0):
        x = stage.states[0, 0]
        if 4 < t < 8:
            assert stage.statuses(0)["it"] == R
            still.append(stage.states[0, :3].copy())
            assert stage.signal(0, Signal.GESTURE) == Gesture.YOU_FIRST
            assert stage.signal(0, Signal.GAZE) == 1
    assert np.ptp(still, axis=0).max() == 0
    assert still[0][:2] == pytest.approx([-1.3, 0.9], abs=0.2)
    assert x > 2


def test_nobody_waits_for_a_robot_in_the_door_for_ever():
    robot = robot_at(0.4, 0.8)
    node = WAY.replace("/>", ' patience="3"/>')
    person = someone(-2.5, 0.5, 0, node, goals=[(4, -2)])
    stage = Stage([person], places=[DOOR], obstacles=room(0.9), robot=robot)
    found = [stage.statuses(0)["it"] for _ in stage.run(12.0)]
    assert found.count(R) == pytest.approx(3 / DT, abs=1)
    assert stage.states[0, 0] > 1


@pytest.mark.parametrize("seed", range(2))
def test_six_people_pass_a_door(seed):
    generator = np.random.default_rng(seed)
    people = [comer((-1, 1)[i % 2], generator) for i in range(6)]
    for i, it in enumerate(people):
        x, _, yaw = it.pose
        it.pose = (x * (1 + 0.2 * (i // 2)), 1.2 * (i // 2 - 1), yaw)
    stage = Stage(people, places=[DOOR], obstacles=room(0.9))
    for _ in stage.run(40.0):
        done = [
            stage.states[i, 0] * it.goals[0][0] > 0
            for i, it in enumerate(people)
        ]
        if all(done):
            break
    assert all(done)


@pytest.mark.parametrize(
    ("width", "goal"), [(1.6, (5, 0)), (0.9, (-0.5, 1.5)), (0.9, None)]
)
def test_nobody_waits_without_need(width, goal):
    """At a wide door, or on the way to a place on this side."""
    door = Place(name="door", type="door", pose=(0, 0, 0), width=width)
    people = [
        someone(-4, 0.3, 0, WAY, goals=[goal] if goal else []),
        someone(3, -0.3, math.pi, "", goals=[(-5, -0.3)]),
    ]
    stage = Stage(people, places=[door], obstacles=room(width))
    assert {stage.statuses(0)["it"] for _ in stage.run(6.0)} == {F}
    assert (stage.signals[:, Signal.ACTIVITY] != Activity.GIVE_WAY).all()


def test_only_doors_are_given_way_at():
    till = Place(name="door", type="counter", pose=(0, 0, 0))
    with pytest.raises(BehaviorTreeError, match="'door' is a counter"):
        Stage([someone(-4, 0, 0, WAY)], places=[till])


def test_a_trial_records_where_its_doors_are(tmp_path):
    frame = {"type": "door_frame", "yaw": 0.3}
    data = {
        "places": [
            {"type": "door", "pose": [2, 0, 0]},
            {"type": "point", "pose": [4, 0, 0]},
        ],
        # The first one is the frame of the place.
        "world": {
            "furniture": [
                frame | {"center": [2.1, 0.1]},
                frame | {"center": [9, 9]},
            ]
        },
        "humans": [{"pose": [1.5, 1.0, 0]}],
        "robot": {"start": [1, 0, 0], "goal": [1, 0, 0]},
        "planner": {"type": "stand"},
        "simulation": {"duration": 2.0},
    }
    scenario = LoadScenario(data=json.dumps(data))
    recording = RunTrial(scenario).recording
    assert recording.doors.tolist() == [[2, 0], [9, 9]]
    recording.save(tmp_path / "recording.npz")
    read = Recording.load(tmp_path / "recording.npz")
    assert FindSituations(read).flags["at_door"].all()
