"""People of a group go one behind the other where two have no room."""

import numpy as np
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd.walls.parted_groups import parted
from hunav_drake.systems.world.shapes import Polyline, World
from tests.systems.crowd.walls.test_passages import (
    MODELS,
    arrive,
    room_with_a_door,
)


def pair(*starts, goals=((6, 0.5), (6, -0.5))):
    return [
        HumanConfig(pose=[*start, 0.0], goals=[goal], group_id=1)
        for start, goal in zip(starts, goals, strict=True)
    ]


def who_parts(positions, goals, world, groups=(1, 1), radius=0.35):
    n = len(positions)
    command = np.zeros((n, COMMAND_SIZE))
    command[:, [Command.GOAL_X, Command.GOAL_Y]] = goals
    command[:, Command.HAS_GOAL] = 1
    command[:, Command.DESIRED_SPEED] = 1.0
    command[:, Command.GROUP_ID] = groups
    table = world.obstacles().table
    radii = np.full(n, radius)
    return parted(np.array(positions, dtype=float), command, radii, table)


@pytest.mark.parametrize("width", [0.8, 0.9, 1.0])
@pytest.mark.parametrize(
    "starts", [((0, 0.6), (0, -0.6)), ((0, 0), (0, 1)), ((2, 0.6), (2, -0.6))]
)
def test_two_in_a_group_pass_a_door(width, starts):
    """In twice the time that one alone needs, at 1 m/s."""
    people = pair(*starts)
    assert arrive(*people, world=room_with_a_door(width), time=14.0)


# (Two who come side by side block each other there with ORCA, in a group or
# not.)
@pytest.mark.parametrize("model", [m for m in MODELS if m != "orca"])
def test_two_in_a_group_pass_a_door_with_other_models(model):
    people = pair((0, 0.6), (0, -0.6))
    assert arrive(*people, world=room_with_a_door(0.9), model=model)


def corridor(width):
    lines = ([[-5, y], [9, y]] for y in (-width / 2, width / 2))
    return World(walls=[Polyline(points=line) for line in lines])


@pytest.mark.parametrize(("width", "alone"), [(1.3, True), (1.5, False)])
def test_whom_a_corridor_has_room_for_stays_together(width, alone):
    """Two of 0.7 m take 1.4 m."""
    places = [[0, 0.3], [0, -0.3]]
    parts = who_parts(places, [[5, 0.3], [5, -0.3]], corridor(width))
    assert parts.tolist() == [alone, alone]


def test_who_has_a_wall_before_the_center_of_the_group_is_parted():
    wall = World(walls=[Polyline(points=[[0.5, -3], [0.5, 3]])])
    goals = [[-6, 9], [6, 9]]
    assert who_parts([[-2, 0], [2, 0]], goals, wall).tolist() == [False, True]
    assert not who_parts([[-2, 4], [2, 4]], goals, wall).any()


def test_who_is_in_no_group_or_alone_in_it_is_never_parted():
    places, goals = [[0, 0.3], [0, -0.3]], [[5, 0.3], [5, -0.3]]
    for groups in ((-1, -1), (1, 2), (1, -1)):
        assert not who_parts(places, goals, corridor(1.0), groups).any()


def test_it_does_not_depend_on_order_direction_or_place():
    rng = np.random.default_rng(0)
    n = 12
    places = rng.uniform(-1, 1, (n, 2)) * [3, 2]
    goals = places + rng.uniform(-3, 3, (n, 2))
    groups = rng.integers(-1, 4, n)
    lines = rng.uniform(-4, 4, (8, 2, 2))

    def told(order, turn, shift):
        def moved(p):
            return p @ turn.T + shift

        world = World(
            walls=[Polyline(points=moved(line).tolist()) for line in lines]
        )
        return who_parts(
            moved(places[order]), moved(goals[order]), world, groups[order]
        )

    here = told(np.arange(n), np.eye(2), 0.0)
    assert 0 < here.sum() < (groups >= 0).sum()
    order = rng.permutation(n)
    c, s = np.cos(0.7), np.sin(0.7)
    for turn in ([[c, -s], [s, c]], [[1, 0], [0, -1]]):
        there = told(order, np.array(turn), np.array([3.0, -8.0]))
        np.testing.assert_array_equal(there, here[order])
