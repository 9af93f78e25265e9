"""The conditions and actions of HuNavSim's trees, and its two calm people."""

import itertools
import math

import numpy as np
import pytest

from hunav_drake.systems.behavior import LoadTree, NodeStatus, ParseTree
from hunav_drake.systems.common.layout import Command, RobotRole
from tests.systems.behavior.ticks import NO_ROBOT, WALK, at, person, tree_of

FORMS = {
    "hunavsim": ParseTree(WALK),
    "regular": LoadTree("regular"),
    "impassive": LoadTree("impassive"),
}


def goals_at(tree, who, places):
    """Returns the goal x of each tick, or None without goal, and the memory."""
    memory = tree.initial_memory(who)
    goals = []
    for x in places:
        outcome = tree.tick(who, memory, at(x, 0.0), NO_ROBOT)
        memory = outcome.memory
        goals.append(
            outcome.command[Command.GOAL_X]
            if outcome.command[Command.HAS_GOAL]
            else None
        )
    return goals, memory


def condition(xml, who, human_states, robots=NO_ROBOT):
    dut = tree_of(xml)
    outcome = dut.tick(who, dut.initial_memory(who), human_states, robots)
    return outcome.node_status is NodeStatus.SUCCESS


@pytest.mark.parametrize("form", FORMS)
class TestGoals:
    def test_next_goal_follows_in_the_tick_that_reaches_one(self, form):
        who = person(goals=[(1.0, 0.0), (3.0, 0.0)])
        goals, _ = goals_at(FORMS[form], who, [0.0, 0.5, 0.65, 0.65])
        assert goals == [1.0, 1.0, 3.0, 3.0]

    def test_no_goal_is_left_after_the_last(self, form):
        who = person(goals=[(1.0, 0.0)])
        goals, memory = goals_at(FORMS[form], who, [0.0, 1.0, 1.0, 5.0])
        assert goals == [1.0, None, None, None]
        assert memory[0] == 1

    def test_first_goal_follows_the_last_of_a_cycle(self, form):
        who = person(goals=[(1.0, 0.0), (3.0, 0.0)], cyclic=True)
        goals, _ = goals_at(FORMS[form], who, [1.0, 3.0, 1.0, 3.0])
        assert goals == [3.0, 1.0, 3.0, 1.0]

    def test_only_goal_of_a_cycle_stays(self, form):
        who = person(goals=[(1.0, 0.0)], cyclic=True)
        goals, memory = goals_at(FORMS[form], who, [0.0, 1.0, 1.0])
        assert goals == [1.0, 1.0, 1.0]
        assert memory[0] == 0

    def test_goals_at_one_place_are_left_one_a_tick(self, form):
        who = person(goals=[(1.0, 0.0), (1.1, 0.0), (1.2, 0.0)])
        goals, _ = goals_at(FORMS[form], who, [1.0, 1.0, 1.0, 1.0])
        assert goals == [1.1, 1.2, None, None]

    def test_without_goals_there_is_nothing_to_do(self, form):
        goals, memory = goals_at(FORMS[form], person(goals=[]), [0.0, 1.0])
        assert goals == [None, None]
        assert memory[0] == 0


@pytest.mark.parametrize("form", FORMS)
def test_command_is_that_of_the_person(form):
    who = person(
        goals=[(1.0, 2.0)],
        desired_speed=0.8,
        max_speed=1.1,
        goal_radius=0.25,
        group_id=4,
    )
    tree = FORMS[form]
    for place in (at(0.0, 0.0), at(1.0, 2.0)):
        outcome = tree.tick(who, tree.initial_memory(who), place, NO_ROBOT)
        command = dict(zip(Command, outcome.command, strict=True))
        assert command[Command.GOAL_RADIUS] == 0.25
        assert command[Command.DESIRED_SPEED] == 0.8
        assert command[Command.MAX_SPEED] == 1.1
        assert command[Command.GROUP_ID] == 4
        assert command[Command.ROBOT_ROLE] == (
            RobotRole.OBSTACLE if form == "impassive" else RobotRole.PEDESTRIAN
        )
        for quiet in (
            Command.ROBOT_REPULSION,
            Command.HOLD,
            Command.TURN_RATE,
            Command.YAW_TARGET,
        ):
            assert command[quiet] == 0
        assert outcome.behavior_status == 0


@pytest.mark.parametrize(
    ("distance", "reached"), [(0.0, True), (0.39, True), (0.41, False)]
)
def test_goal_counts_as_reached_10_cm_outside_its_radius(distance, reached):
    who = person(goals=[(3.0, 4.0)], goal_radius=0.3)
    place = at(3.0 - distance * 0.6, 4.0 - distance * 0.8)
    assert condition("<IsGoalReached/>", who, place) == reached


def test_goal_is_that_of_the_own_row():
    who = person(goals=[(3.0, 0.0)], index=1)
    rows = np.concatenate([at(3.0, 0.0), at(0.0, 0.0)])
    assert not condition("<IsGoalReached/>", who, rows)
    rows = np.concatenate([at(0.0, 0.0), at(3.0, 0.0)])
    assert condition("<IsGoalReached/>", who, rows)


@pytest.mark.parametrize("yaw", [0.0, 1.0, 3.0, -3.0, 100.0])
@pytest.mark.parametrize(
    ("distance", "bearing", "visible"),
    [
        (3.9, 0.0, True),
        (4.1, 0.0, False),
        (1.0, math.pi / 2 + 0.16, True),
        (1.0, -math.pi / 2 - 0.16, True),
        (1.0, math.pi / 2 + 0.18, False),
        (1.0, -math.pi / 2 - 0.18, False),
        (1.0, math.pi, False),
    ],
)
def test_robot_is_visible_ahead_and_a_little_behind_the_sides(
    yaw, distance, bearing, visible
):
    direction = yaw + bearing
    robot = at(
        2.0 + distance * math.cos(direction),
        1.0 + distance * math.sin(direction),
    )
    seen = condition(
        '<IsRobotVisible agent_id="{id}" distance="4.0"/>',
        person(goals=[]),
        at(2.0, 1.0, yaw),
        robot,
    )
    assert seen == visible


def test_field_of_view_is_a_port():
    xml = '<IsRobotVisible distance="4.0" field_of_view="1.0"/>'
    assert condition(xml, person(goals=[]), at(0, 0), at(1.0, 0.5))
    assert not condition(xml, person(goals=[]), at(0, 0), at(1.0, 0.6))


def test_any_of_several_robots_is_visible_and_none_of_none():
    xml = '<IsRobotVisible distance="4.0"/>'
    two = np.concatenate([at(9.0, 0.0), at(1.0, 0.0)])
    assert condition(xml, person(goals=[]), at(0, 0), two)
    assert not condition(xml, person(goals=[]), at(0, 0), NO_ROBOT)


@pytest.mark.parametrize(
    ("seconds", "time_step", "failures"),
    [
        (30.0, 0.05, 599),
        (40.0, 0.05, 800),
        (30.0, 0.25, 119),
        (40.0, 0.25, 159),
        (0.3, 0.1, 2),
        (0.0, 0.1, 0),
    ],
)
def test_timer_adds_up_the_steps(seconds, time_step, failures):
    """With their rounding: 800 times 0.05 s is a little less than 40 s."""
    # (Python's own sum() would correct the rounding.)
    assert list(itertools.accumulate([0.05] * 800))[-1] < 40
    who = person(time_step=time_step)
    dut = ParseTree(
        f'<root><BehaviorTree><TimeExpiredCondition seconds="{seconds}"'
        ' ts="{dt}"/></BehaviorTree></root>'
    )
    memory = dut.initial_memory(who)
    ticks = 0
    status = NodeStatus.FAILURE
    while status is NodeStatus.FAILURE:
        status, _, _, memory = dut.tick(who, memory, at(0, 0), NO_ROBOT)
        ticks += 1
    assert ticks == failures + 1


@pytest.mark.parametrize(
    ("only_once", "expected"), [("true", "FFSSSS"), ("false", "FFSFFS")]
)
def test_timer_expires_for_good_or_starts_over(only_once, expected):
    who = person(time_step=0.1)
    dut = ParseTree(
        '<root><BehaviorTree><TimeExpiredCondition seconds="0.3"'
        f' only_once="{only_once}"/></BehaviorTree></root>'
    )
    memory = dut.initial_memory(who)
    results = ""
    for _ in expected:
        status, _, _, memory = dut.tick(who, memory, at(0, 0), NO_ROBOT)
        results += status.name[0]
    assert results == expected
