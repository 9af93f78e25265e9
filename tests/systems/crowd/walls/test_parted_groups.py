"""People of a group go one behind the other where two have no room."""

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.crowd.walls.parted_groups import parted, walking_groups
from hunav_drake.systems.world.shapes import Polyline, World
from hunav_drake.trial.humans import MakeHumans
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


def together(positions, goals, groups=None, stands=()):
    """Returns who walk together, as sets of people."""
    n = len(positions)
    command = np.zeros((n, COMMAND_SIZE))
    command[:, [Command.GOAL_X, Command.GOAL_Y]] = goals
    command[:, Command.GOAL_RADIUS] = 0.3
    command[:, Command.HAS_GOAL] = 1
    command[list(stands), Command.HAS_GOAL] = 0
    command[:, Command.GROUP_ID] = [1] * n if groups is None else groups
    found = walking_groups(np.array(positions, dtype=float), command, command)
    # Numbers of groups are whole, and not those of others.
    assert (found == np.round(found)).all()
    return {
        frozenset(np.flatnonzero(found == group).tolist())
        for group in set(found[found >= 0])
    }


def test_who_goes_the_same_way_walks_together():
    three = [(0, 0), (0, 0.8), (0, -0.8)]
    everybody = {frozenset({0, 1, 2})}
    assert together(three, [(9, 0), (9, 0.8), (9, -0.8)]) == everybody
    assert together(three, [(9, 0), (9, 5), (9, -5)]) == everybody
    # To one place from all sides, however far.
    assert together([(0, 0), (9, 9), (9, -9)], [(8, 0)] * 3) == everybody
    # The one in the middle is with both others, who are not with each other.
    fan = [(9, 0), (5, 7), (5, -7)]
    assert together(three, fan) == everybody
    assert together(three[1:], fan[1:]) == set()


def test_who_goes_elsewhere_or_has_arrived_goes_alone():
    places = [(0, 0), (0, 0.8), (0, -0.8), (0.8, 0)]
    ways = [(9, 0), (9, 0), (-9, 0), (-9, 0)]
    assert together(places, ways) == {frozenset({0, 1}), frozenset({2, 3})}
    assert together(places[1:], ways[1:]) == {frozenset({1, 2})}
    assert together(places, ways, stands=[0]) == {frozenset({2, 3})}
    # A person who stands at the goal of others is with them, too.
    goals = [(0.5, 0)] * 4
    assert together(places, goals, stands=[0]) == {frozenset(range(4))}
    # Far from each other people do not look who goes the same way.
    far = [(0, 0), (0, 3.1)]
    assert together(far, [(9, 0), (9, 3.1)]) == set()
    assert together(far, [(9, 0), (9, 0.5)]) == {frozenset({0, 1})}


def test_groups_keep_to_themselves():
    places = [(0, 0), (0, 0.8), (0, -0.8), (0, 1.6), (0, 2.4)]
    found = together(places, [(9, 0)] * 5, groups=[1, 2, 1, 2, -1])
    assert found == {frozenset({0, 2}), frozenset({1, 3})}


@pytest.mark.parametrize("seed", range(20))
def test_the_order_of_people_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    n = 9
    places, goals = rng.uniform(-4, 4, (2, n, 2))
    groups = rng.integers(-1, 3, n)
    stands = np.flatnonzero(rng.random(n) < 0.3)
    order = rng.permutation(n)
    rank = np.argsort(order)
    found = together(places, goals, groups, stands)
    again = together(
        places[order], goals[order], groups[order], rank[stands].tolist()
    )
    assert {frozenset(order[list(it)].tolist()) for it in again} == found


def make_groups(seed):
    """Returns people of three groups, each of whom has two goals of their own.

    Everybody walks to and fro between the last two.
    """
    rng = np.random.default_rng([7, seed])
    people = []
    for group in range(3):
        center = rng.uniform(-7, 7, 2)
        size = int(rng.integers(2, 5))
        for k in range(size):
            turn = 2 * np.pi * k / size
            place = center + 0.6 * np.array([np.cos(turn), np.sin(turn)])
            goals = rng.uniform(-8, 8, (2, 2))
            people.append(
                HumanConfig(
                    pose=(*place, rng.uniform(-3, 3)),
                    goals=[tuple(goal) for goal in goals],
                    group_id=group,
                    cyclic=seed % 2 == 1,
                )
            )
    return people


def longest_halt(people, **crowd):
    """Returns how long anybody stays within 1 m of a way to a goal, in s."""
    diagram = MakeHumans(people, num_robots=0, config=CrowdConfig(**crowd))
    simulator = Simulator(diagram)
    context = simulator.get_context()
    commands = diagram.GetSubsystemByName("crowd").get_commands_input_port()
    crowd_context = diagram.GetSubsystemByName("crowd").GetMyContextFromRoot(
        context
    )
    since = np.zeros(len(people))
    place = np.full((len(people), 2), np.inf)
    was = np.full((len(people), 2), np.inf)
    longest = 0.0
    for second in range(50):
        simulator.AdvanceTo(second)
        states = diagram.GetOutputPort("human_states").Eval(context)
        now = states.reshape(-1, 7)[:, :2]
        rows = commands.Eval(crowd_context).reshape(len(people), -1)
        goal = rows[:, [Command.GOAL_X, Command.GOAL_Y]]
        moved = np.hypot(*(now - place).T) > 1.0
        moved |= (goal != was).any(axis=1) | (rows[:, Command.HAS_GOAL] == 0)
        since[moved] = second
        place[moved] = now[moved]
        was = goal
        longest = max(longest, float((second - since).max()))
    return longest


@pytest.mark.parametrize("seed", range(3))
def test_groups_of_people_with_goals_of_their_own_get_there(seed):
    assert longest_halt(make_groups(seed)) < 8.0


@pytest.mark.parametrize("model", ["social_force", "headed_social_force"])
@pytest.mark.parametrize("seed", [4, 6])
def test_members_walk_around_others_who_have_arrived(seed, model):
    """Who touched somebody who stood crept around at 0.02 m/s."""
    people = make_groups(seed)
    assert longest_halt(people, model=model) < 10.0
    if seed == 6:
        slow = {"type": model, "passing_speed": 0.02}
        assert longest_halt(people, model=slow) > 12.0


def test_without_parting_such_groups_stand():
    assert longest_halt(make_groups(0), groups_part=False) > 15.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "model"),
    [(3 + i, (MODELS[:2] + MODELS[3:])[i % 4]) for i in range(12)],
)
def test_more_groups_of_people_with_goals_of_their_own_get_there(seed, model):
    assert longest_halt(make_groups(seed), model=model) < 15.0
