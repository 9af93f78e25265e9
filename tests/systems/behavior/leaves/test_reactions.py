"""The commands of people who react to the robot, tick by tick."""

import math

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    LoadBehavior,
    LoadTree,
    NodeStatus,
)
from hunav_drake.systems.common.layout import Command, RobotRole
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.behavior.ticks import (
    NO_ROBOT,
    as_original,
    at,
    person,
    tick,
    tree_of,
    wish,
)

WALL = Obstacles.from_shapes([[[1.0, -1.0], [1.0, 1.0]]], solid=[False])
REACTIONS = ["surprised", "scared", "curious", "threatening"]


class TestSight:
    def test_a_wall_hides_the_robot(self):
        dut = tree_of('<IsRobotVisible distance="4"/>')
        robot = at(2.0, 0.0)
        who = person(obstacles=WALL)
        assert tick(dut, robot=robot).node_status is NodeStatus.SUCCESS
        assert tick(dut, who, robot=robot).node_status is NodeStatus.FAILURE
        assert (
            tick(dut, who, robot=at(2.0, 2.5)).node_status is NodeStatus.SUCCESS
        )
        assert (
            tick(dut, who, robot=at(0.9, 0.0)).node_status is NodeStatus.SUCCESS
        )

    def test_occlusion_can_be_turned_off(self):
        dut = tree_of('<IsRobotVisible distance="4" occlusion="false"/>')
        who = person(obstacles=WALL)
        assert (
            tick(dut, who, robot=at(2.0, 0.0)).node_status is NodeStatus.SUCCESS
        )

    def test_of_two_robots_one_in_view_is_enough(self):
        dut = tree_of('<IsRobotVisible distance="4"/>')
        robots = np.concatenate([at(2.0, 0.0), at(0.0, 2.0)])
        assert tick(dut, person(obstacles=WALL), robot=robots).node_status is (
            NodeStatus.SUCCESS
        )

    @pytest.mark.parametrize("time_step", [0.05, 0.01])
    def test_robot_is_kept_in_mind_for_the_time_of_memory(self, time_step):
        dut = tree_of('<IsRobotVisible distance="4" memory="1.0"/>')
        who = person(time_step=time_step)
        outcome = tick(dut, who, robot=at(9.0, 0.0))
        assert outcome.node_status is NodeStatus.FAILURE
        outcome = tick(dut, who, None, at(3.0, 0.0), outcome.memory)
        for _ in range(round(1.0 / time_step)):
            outcome = tick(dut, who, None, at(-3.0, 0.0), outcome.memory)
            assert outcome.node_status is NodeStatus.SUCCESS
        outcome = tick(dut, who, None, at(-3.0, 0.0), outcome.memory)
        assert outcome.node_status is NodeStatus.FAILURE

    def test_by_default_out_of_sight_is_out_of_mind(self):
        dut = tree_of('<IsRobotVisible distance="4"/>')
        outcome = tick(dut, robot=at(3.0, 0.0))
        outcome = tick(dut, robot=at(-3.0, 0.0), memory=outcome.memory)
        assert outcome.node_status is NodeStatus.FAILURE


APPROACHING = {
    "ahead of it": (at(3.0, 0.0, math.pi, -0.5), True),
    "beside its course, but near": (at(3.0, 0.9, math.pi, -0.5), True),
    "far beside its course": (at(3.0, 1.1, math.pi, -0.5), False),
    "behind it": (at(-1.0, 0.0, math.pi, -0.5), False),
    "far ahead of it": (at(5.5, 0.0, math.pi, -0.5), False),
    "it stands": (at(3.0, 0.0, math.pi, -0.01), False),
    "it drives away": (at(3.0, 0.0, 0.0, 0.5), False),
    "no robot": (NO_ROBOT, False),
}


@pytest.mark.parametrize("name", APPROACHING)
def test_approaching_is_driving_at_the_person(name):
    robot, expected = APPROACHING[name]
    dut = tree_of('<IsRobotApproaching distance="5" width="1"/>')
    outcome = tick(dut, robot=robot)
    assert (outcome.node_status is NodeStatus.SUCCESS) == expected


@pytest.mark.parametrize(
    ("yaw", "expected"), [(0.0, True), (1.0, True), (1.1, False), (3.0, False)]
)
def test_head_on_is_within_60_degrees_of_opposite(yaw, expected):
    dut = tree_of('<IsRobotApproaching distance="5" head_on="true"/>')
    robot = at(3.0, 0.0, math.pi, -0.5)
    outcome = tick(dut, human=at(0.0, 0.0, yaw), robot=robot)
    assert (outcome.node_status is NodeStatus.SUCCESS) == expected


def test_robot_behind_a_wall_does_not_approach():
    robot = at(3.0, 0.0, math.pi, -0.5)
    who = person(obstacles=WALL)
    for occlusion, status in (
        ("true", NodeStatus.FAILURE),
        ("false", NodeStatus.SUCCESS),
    ):
        dut = tree_of(
            f'<IsRobotApproaching distance="5" occlusion="{occlusion}"/>'
        )
        assert tick(dut, who, robot=robot).node_status is status


@pytest.mark.parametrize("name", REACTIONS)
class TestReaction:
    NEAR = at(2.0, 1.0)
    FAR = at(50.0, 0.0)

    def test_is_active_while_the_robot_is_in_sight(self, name):
        dut = LoadTree(name)
        assert tick(dut, robot=self.FAR).behavior_status == 0
        assert tick(dut, robot=self.NEAR).behavior_status == 1
        assert tick(dut, robot=at(-2.0, 0.0)).behavior_status == 0
        assert tick(dut).behavior_status == 0

    def test_ends_after_its_time(self, name):
        dut = LoadTree(name, {"duration": 1.0})
        who = person(time_step=0.25)
        memory = dut.initial_memory(who)
        active = []
        for _ in range(8):
            outcome = dut.tick(who, memory, at(0.0, 0.0), self.NEAR)
            memory = outcome.memory
            active.append(outcome.behavior_status)
        # The scared count anew.
        again = [1, 1, 1, 0] if name == "scared" else [0, 0, 0, 0]
        assert active == [1, 1, 1, 0, *again]

    def test_walks_through_the_goals_otherwise(self, name):
        dut = LoadTree(name)
        who = person(goals=[(0.1, 0.0), (5.0, 6.0)], max_speed=1.4)
        outcome = tick(dut, who, robot=self.FAR)
        command = wish(outcome)
        assert command[Command.GOAL_X] == 5.0
        assert command[Command.GOAL_Y] == 6.0
        assert command[Command.MAX_SPEED] == 1.4
        assert command[Command.DESIRED_SPEED] == 1.2
        assert not command[Command.HOLD]
        assert not command[Command.TURN_RATE]
        assert not command[Command.ROBOT_REPULSION]

    def test_takes_the_robot_for_a_person_otherwise(self, name):
        outcome = tick(LoadTree(name), robot=self.FAR)
        assert wish(outcome)[Command.ROBOT_ROLE] == RobotRole.PEDESTRIAN

    def test_can_ignore_the_robot_otherwise(self, name):
        dut = LoadTree(name, {"ignore_robot_when_idle": True})
        outcome = tick(dut, robot=self.FAR)
        assert wish(outcome)[Command.ROBOT_ROLE] == RobotRole.UNSEEN

    def test_depends_on_nothing_but_state_and_inputs(self, name):
        dut = LoadTree(name)
        who = person()
        memory = tuple(dut.initial_memory(who))
        first = dut.tick(who, memory, at(0.0, 0.0), self.NEAR)
        assert dut.tick(who, memory, at(0.0, 0.0), self.NEAR) == first

    def test_fails_without_a_robot(self, name):
        node = f"{name.capitalize()}Nav"
        outcome = tick(tree_of(f"<{node}/>"))
        assert outcome.node_status is NodeStatus.FAILURE
        assert outcome.behavior_status == 0

    def test_is_to_the_nearest_robot(self, name):
        near, far = at(1.3, 0.4), at(2.0, -1.0)
        dut = tree_of(f"<{name.capitalize()}Nav/>")
        both = [
            tick(dut, robot=np.concatenate(order)).command
            for order in ([near, far], [far, near])
        ]
        assert both[0] == both[1] == tick(dut, robot=near).command


def test_surprised_person_stands_and_turns_to_the_robot():
    command = wish(tick(LoadTree("surprised"), robot=at(2.0, 2.0)))
    assert command[Command.HOLD] == 1
    assert command[Command.TURN_RATE] == math.pi
    assert command[Command.YAW_TARGET] == pytest.approx(math.pi / 4)


def test_scared_person_slows_down_and_is_pushed_away():
    command = wish(tick(LoadTree("scared"), robot=at(2.0, 0.0)))
    assert command[Command.MAX_SPEED] == command[Command.DESIRED_SPEED] == 0.6
    # 22 m/s^2 times 0.2 m.
    assert command[Command.ROBOT_REPULSION] == pytest.approx(22.0 * 0.2)
    assert command[Command.GOAL_X] == 9.0
    assert command[Command.ROBOT_ROLE] == RobotRole.UNSEEN


def test_curious_person_comes_slower_the_nearer():
    for distance in (9.0, 4.0, 1.6):
        robot = at(distance, 0.0)
        command = wish(
            tick(LoadTree("curious"), person(max_speed=3.0), robot=robot)
        )
        assert command[Command.GOAL_X] == distance
        assert command[Command.GOAL_RADIUS] == 0.35
        assert command[Command.DESIRED_SPEED] == pytest.approx(0.18 * distance)
        assert command[Command.MAX_SPEED] == command[Command.DESIRED_SPEED]
        assert not command[Command.HOLD]


def test_curious_person_stands_before_the_robot_and_looks_at_it():
    command = wish(tick(LoadTree("curious"), robot=at(1.0, -1.0)))
    assert command[Command.HOLD] == 1
    assert command[Command.TURN_RATE] == math.pi
    assert command[Command.YAW_TARGET] == pytest.approx(-math.pi / 4)


@pytest.mark.parametrize("yaw", [0.0, 1.0, math.pi / 2, -2.5])
def test_threatening_person_goes_to_the_point_before_the_robot(yaw):
    command = wish(
        tick(LoadBehavior(as_original("threatening")), robot=at(3.0, 1.0, yaw))
    )
    assert command[Command.GOAL_X] == pytest.approx(3.0 + 1.1 * math.cos(yaw))
    assert command[Command.GOAL_Y] == pytest.approx(1.0 + 1.1 * math.sin(yaw))
    assert command[Command.GOAL_RADIUS] == 0.05
    assert command[Command.MAX_SPEED] == command[Command.DESIRED_SPEED] == 2.0
    assert not command[Command.TURN_RATE]


def test_threatening_person_faces_the_robot_from_near():
    tree = LoadBehavior(as_original("threatening"))
    command = wish(tick(tree, robot=at(0.0, 1.1)))
    assert command[Command.TURN_RATE] == math.pi
    assert command[Command.YAW_TARGET] == pytest.approx(math.pi / 2)
    assert not command[Command.HOLD]


def test_person_on_the_robot_keeps_the_heading():
    outcome = tick(
        tree_of("<SurprisedNav/>"), human=at(1.0, 1.0, 0.7), robot=at(1.0, 1.0)
    )
    assert wish(outcome)[Command.YAW_TARGET] == 0.7


PORTS = {
    "surprised": ({"turn_rate": 1.0}, Command.TURN_RATE, 1.0),
    "scared": ({"speed": 0.3}, Command.MAX_SPEED, 0.3),
    "scared push": ({"push": 10.0}, Command.ROBOT_REPULSION, 2.0),
    "scared range": ({"push_range": 0.1}, Command.ROBOT_REPULSION, 2.2),
    "scared robot": ({"robot": "pedestrian"}, Command.ROBOT_ROLE, 1.0),
    "curious": ({"stop_distance": 3.0}, Command.HOLD, 1.0),
    "curious speed": ({"speed": 0.9}, Command.DESIRED_SPEED, 0.18),
    "curious distance": ({"speed_distance": 20.0}, Command.DESIRED_SPEED, 0.18),
    "curious turn": (
        {"turn_rate": 1.0, "stop_distance": 3.0},
        Command.TURN_RATE,
        1.0,
    ),
    "curious robot": ({"robot": "obstacle"}, Command.ROBOT_ROLE, 2.0),
}


@pytest.mark.parametrize("name", PORTS)
def test_numbers_of_a_reaction_are_ports(name):
    ports, element, expected = PORTS[name]
    robot = at(2.0, 0.0)
    plain = wish(tick(LoadTree(name.split()[0]), robot=robot))
    changed = wish(tick(LoadTree(name.split()[0], ports), robot=robot))
    assert plain[element] != pytest.approx(expected)
    assert changed[element] == pytest.approx(expected)


LEAF_PORTS = {
    'goal_distance="0.5"': (Command.GOAL_X, 2.5),
    'goal_radius="0.2"': (Command.GOAL_RADIUS, 0.2),
    'speed="1"': (Command.MAX_SPEED, 1.0),
    'face_distance="3"': (Command.TURN_RATE, math.pi),
    'turn_rate="1" face_distance="3"': (Command.TURN_RATE, 1.0),
    'robot="pedestrian"': (Command.ROBOT_ROLE, 1.0),
}


@pytest.mark.parametrize("ports", LEAF_PORTS)
def test_numbers_of_the_threatening_action_are_ports(ports):
    element, expected = LEAF_PORTS[ports]
    plain, changed = (
        wish(tick(tree_of(f"<ThreateningNav {text}/>"), robot=at(2.0, 0.0)))
        for text in ("", ports)
    )
    assert plain[element] != pytest.approx(expected)
    assert changed[element] == pytest.approx(expected)


@pytest.mark.parametrize("name", REACTIONS)
def test_sight_of_a_reaction_is_ports(name):
    robot = at(2.0, 0.0)
    hidden = person(obstacles=WALL)
    assert tick(LoadTree(name), robot=robot).behavior_status == 1
    dut = LoadTree(name, {"distance": 1.9})
    assert tick(dut, robot=robot).behavior_status == 0
    dut = LoadTree(name, {"field_of_view": 1.0})
    assert tick(dut, robot=at(1.0, 1.0)).behavior_status == 0
    assert tick(LoadTree(name), hidden, robot=robot).behavior_status == 0
    dut = LoadTree(name, {"occlusion": False})
    assert tick(dut, hidden, robot=robot).behavior_status == 1


def test_distracted_person_sees_the_robot_only_just_ahead():
    dut = LoadTree("distracted")
    for robot, noticed in (
        (at(1.4, 0.0), True),
        (at(1.6, 0.0), False),
        (at(1.0, 0.5), True),
        (at(1.0, 0.6), False),
    ):
        outcome = tick(dut, robot=robot)
        assert outcome.behavior_status == noticed
        is_unseen = wish(outcome)[Command.ROBOT_ROLE] == RobotRole.UNSEEN
        assert is_unseen != noticed


def test_standing_still_is_looking_at_the_robot():
    outcome = tick(tree_of("<StandStill/>"), robot=at(0.0, 3.0))
    assert wish(outcome)[Command.HOLD] == 1
    assert wish(outcome)[Command.YAW_TARGET] == pytest.approx(math.pi / 2)
    outcome = tick(tree_of("<StandStill/>"))
    assert outcome.node_status is NodeStatus.SUCCESS
    assert wish(outcome)[Command.TURN_RATE] == 0


def test_cooperative_person_yields_waits_and_walks_on():
    dut = LoadTree("cooperative")
    who = person()
    seen = []
    memory = dut.initial_memory(who)
    human = at(0.0, 0.0)
    for x in np.arange(7.0, -3.0, -0.1):
        robot = at(x, 0.0, math.pi, -2.0)
        outcome = dut.tick(who, memory, human, robot)
        memory = outcome.memory
        command = wish(outcome)
        if command[Command.HOLD]:
            seen.append("waits")
        elif outcome.behavior_status:
            seen.append("steps aside")
            # There at once.
            human = at(command[Command.GOAL_X], command[Command.GOAL_Y])
        else:
            seen.append("walks")
    order = [a for a, b in zip(seen, [None, *seen], strict=False) if a != b]
    assert order == ["walks", "steps aside", "waits", "walks"]


def test_cooperative_person_walks_on_when_the_robot_stops():
    dut = LoadTree("cooperative")
    who = person()
    outcome = dut.tick(
        who, dut.initial_memory(who), at(0.0, 0.0), at(4.0, 0, math.pi, -0.5)
    )
    assert outcome.behavior_status == 1
    for _ in range(100):
        outcome = dut.tick(
            who, outcome.memory, at(0.0, -1.1), at(4.0, 0, math.pi)
        )
    assert outcome.behavior_status == 0
    assert wish(outcome)[Command.GOAL_X] == 9.0


def test_patience_of_the_cooperative_ends():
    dut = LoadTree("cooperative", {"patience": 1.0})
    who = person(time_step=0.25)
    memory = dut.initial_memory(who)
    creeping = at(4.0, 0.0, math.pi, -0.1)
    active = []
    for y in (0.0, -1.1, -1.1, -1.1, -1.1, -1.1):
        outcome = dut.tick(who, memory, at(0.0, y), creeping)
        memory = outcome.memory
        active.append(outcome.behavior_status)
    # The fourth tick is at the end of 1 s.
    assert active == [1, 1, 1, 0, 0, 0]


def test_patience_of_the_cooperative_is_new_in_each_encounter():
    dut = LoadTree("cooperative", {"patience": 1.0})
    who = person(time_step=0.25)
    memory = dut.initial_memory(who)
    waits = []
    # The first robot passes before patience ends, the others do not.
    for count in (1, 9, 9):
        for x in (4.0, *[3.0] * count, -3.0):
            y = 0.0 if x == 4.0 else -1.1
            robot = at(x, 0.0, math.pi, -0.5)
            outcome = dut.tick(who, memory, at(0.0, y), robot)
            memory = outcome.memory
            waits.append(wish(outcome)[Command.HOLD])
        assert sum(waits) == min(count, 2)
        waits.clear()


def test_cooperative_person_waits_for_a_robot_that_stops_near():
    """And walks past it in the end, beside its course."""
    dut = LoadTree(
        "cooperative", {"patience": 2.0, "gap": 0.0, "clearance": 0.7}
    )
    who = person(time_step=0.25)
    outcome = dut.tick(
        who, dut.initial_memory(who), at(0.0, 0.0), at(2.5, 0.0, math.pi, -0.5)
    )
    # Patience is 8 ticks, with the first.
    for count in range(12):
        outcome = dut.tick(
            who, outcome.memory, at(0.0, -0.69), at(2.0, 0.0, math.pi)
        )
        assert outcome.behavior_status == 1
        assert wish(outcome)[Command.HOLD] == (count < 6)
    assert wish(outcome)[Command.GOAL_X] < 1.0
    assert wish(outcome)[Command.GOAL_Y] < -0.65


def test_robot_that_stands_approaches_up_to_its_own_distance():
    standing = at(3.0, 0.0, math.pi)
    for distance, expected in (
        (2.9, NodeStatus.FAILURE),
        (3.1, NodeStatus.SUCCESS),
    ):
        dut = tree_of(
            f'<IsRobotApproaching distance="9" standing_distance="{distance}"/>'
        )
        assert tick(dut, robot=standing).node_status is expected
        away = at(3.0, 0.0, 0.0)
        assert tick(dut, robot=away).node_status is NodeStatus.FAILURE


IN_THE_WAY = {
    "on it": (at(2.0, 0.0), True),
    "beside it, but near": (at(2.0, 0.9), True),
    "beside it": (at(2.0, -1.1), False),
    "far ahead": (at(3.1, 0.0), False),
    "behind": (at(-0.1, 0.0), False),
    "at the goal": (at(8.5, 0.0), False),
    "beyond the goal": (at(11.0, 0.0), False),
    "no robot": (NO_ROBOT, False),
}


@pytest.mark.parametrize("name", IN_THE_WAY)
def test_in_the_way_is_between_the_person_and_the_goal(name):
    robot, expected = IN_THE_WAY[name]
    far = "3" if "goal" not in name else "99"
    dut = tree_of(f'<IsRobotInTheWay distance="{far}" clearance="1"/>')
    outcome = tick(dut, robot=robot)
    assert (outcome.node_status is NodeStatus.SUCCESS) == expected
    assert (
        tick(dut, person(goals=[]), robot=robot).node_status
        is NodeStatus.FAILURE
    )


def test_robot_behind_a_wall_is_not_in_the_way():
    dut = tree_of('<IsRobotInTheWay distance="3"/>')
    who = person(obstacles=WALL)
    assert tick(dut, who, robot=at(2.0, 0.0)).node_status is NodeStatus.FAILURE


@pytest.mark.parametrize(("y", "side"), [(0.2, 1), (0.0, -1), (-0.2, -1)])
def test_passing_by_leads_past_the_robot_on_the_persons_side(y, side):
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, y)])
    human = at(0.0, y)
    outcome = tick(dut, who, human, at(2.0, 0.0, math.pi))
    assert outcome.node_status is NodeStatus.RUNNING
    assert outcome.behavior_status == 1
    command = wish(outcome)
    assert command[Command.GOAL_X] > 0
    assert command[Command.GOAL_Y] == pytest.approx(1.1 * side)
    assert command[Command.ROBOT_ROLE] == RobotRole.OBSTACLE
    for robot in (at(-0.1, 0.0), at(4.0, 0.0), NO_ROBOT):
        assert tick(dut, who, human, robot).node_status is NodeStatus.SUCCESS


# Standing; without walls, the person walks along the x-axis.
SIDE_BY_SIDE = [
    [(2.0, 0.4), (2.0, -0.4)],
    [(2.0, 0.8), (2.0, -0.8)],
    [(2.0, 0.0), (2.0, 0.8), (2.0, -0.8)],
    [(2.5, 0.3), (1.5, -1.3)],
]


@pytest.mark.parametrize("robots", SIDE_BY_SIDE)
def test_passing_by_keeps_off_all_robots_ahead(robots):
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    rows = np.concatenate([at(x, y, math.pi) for x, y in robots])
    outcome = tick(dut, person(goals=[(9.0, 0.0)]), robot=rows)
    lane = wish(outcome)[Command.GOAL_Y]
    assert min(abs(lane - y) for _, y in robots) == pytest.approx(1.1)
    # Nobody goes farther out than that.
    assert abs(lane) < 2.4


def test_passing_by_keeps_to_its_side():
    """Also if the robot moves a little to that side."""
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, 0.0)])
    memory = None
    for y in (-0.2, 0.0, 0.2, 0.3):
        outcome = tick(dut, who, robot=at(2.0, y), memory=memory)
        memory = outcome.memory
        assert wish(outcome)[Command.GOAL_Y] == pytest.approx(y + 1.1)
    outcome = tick(dut, who, robot=at(2.0, 0.3))
    assert wish(outcome)[Command.GOAL_Y] == pytest.approx(0.3 - 1.1)


@pytest.mark.parametrize("width", [1.0, 1.8, 2.0, 2.4, 3.0])
@pytest.mark.parametrize("y", [0.0, 0.2])
def test_passing_by_never_leads_beyond_a_wall(width, y):
    walls = Obstacles.from_shapes(
        [[[-9.0, s * width / 2], [9.0, s * width / 2]] for s in (1, -1)],
        solid=[False, False],
    )
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, 0.0)], obstacles=walls)
    command = wish(tick(dut, who, at(0.0, y), at(2.0, 0.0, math.pi)))
    assert command[Command.GOAL_X] > 0
    # A body of 0.35 m that touches the wall is just free of it.
    assert abs(command[Command.GOAL_Y]) <= max(width / 2 - 0.35, y) + 1e-9


def test_passing_by_takes_the_side_where_two_bodies_fit_in():
    """The robot is a little to the right, of 0.35 m, in 2.4 m."""
    walls = Obstacles.from_shapes(
        [[[-9.0, s * 1.2], [9.0, s * 1.2]] for s in (1, -1)],
        solid=[False, False],
    )
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, 0.0)], obstacles=walls)
    command = wish(tick(dut, who, robot=at(2.0, -0.08)))
    assert command[Command.GOAL_Y] == pytest.approx(0.85)


def test_passing_by_chooses_the_wider_gap_between_robots_and_walls():
    walls = Obstacles.from_shapes(
        [[[-9.0, s * 1.5], [9.0, s * 1.5]] for s in (1, -1)],
        solid=[False, False],
    )
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, 0.0)], obstacles=walls)
    robots = np.concatenate([at(2.0, 1.1), at(2.0, -0.7)])
    command = wish(tick(dut, who, robot=robots))
    assert command[Command.GOAL_Y] == pytest.approx(0.2)


def test_wall_across_is_walked_around_on_the_way_to_the_goal():
    walls = Obstacles.from_shapes([[[0.5, 9.0], [0.5, -9.0]]], solid=[False])
    dut = tree_of('<PassBy distance="3" clearance="1.1"/>')
    who = person(goals=[(9.0, 0.0)], obstacles=walls)
    command = wish(tick(dut, who, robot=at(2.0, 0.0)))
    assert command[Command.GOAL_X] == 9.0
    assert command[Command.ROBOT_ROLE] == RobotRole.OBSTACLE


def test_passing_by_does_not_end_and_begin_again_at_its_distance():
    dut = tree_of('<PassBy distance="3"/>')
    near = tick(dut, person(goals=[(9.0, 0.0)]), robot=at(3.4, 0.0))
    far = tick(dut, person(goals=[(9.0, 0.0)]), robot=at(3.6, 0.0))
    assert near.node_status is NodeStatus.RUNNING
    assert far.node_status is NodeStatus.SUCCESS


class TestTwoRobots:
    """The nearer is behind, unseen; the other is ahead."""

    ROBOTS = np.concatenate([at(-1.0, 0.0), at(2.5, 0.5)])

    @pytest.mark.parametrize("name", REACTIONS)
    def test_reaction_is_to_the_robot_that_is_seen(self, name):
        both = tick(LoadTree(name), robot=self.ROBOTS)
        alone = tick(LoadTree(name), robot=self.ROBOTS[7:])
        assert both.behavior_status == 1
        assert both.command == alone.command

    def test_of_those_in_view_the_nearest_counts(self):
        robots = np.concatenate([at(3.5, 0.0), at(0.0, 2.0), at(2.5, 0.5)])
        dut = LoadTree("surprised", {"field_of_view": 1.0})
        command = wish(tick(dut, robot=robots))
        assert command[Command.YAW_TARGET] == math.atan2(0.5, 2.5)

    def test_robot_that_is_kept_in_mind_stays_the_one(self):
        dut = LoadTree("surprised", {"memory": 5.0})
        first = tick(dut, robot=self.ROBOTS)
        turned = at(0.0, 0.0, math.pi / 2 + 1.3)
        nobody = np.concatenate([at(0.0, -1.0), at(2.5, 0.5)])
        later = tick(dut, None, turned, nobody, first.memory)
        assert later.behavior_status == 1
        assert wish(later)[Command.YAW_TARGET] == math.atan2(0.5, 2.5)

    def test_person_stands_still_for_the_robot_that_comes(self):
        dut = tree_of(
            '<Sequence><IsRobotApproaching distance="5"/>'
            "<StandStill/></Sequence>"
        )
        robots = np.concatenate([at(0.0, 1.0), at(3.0, 0.0, math.pi, -0.5)])
        command = wish(tick(dut, robot=robots))
        assert command[Command.YAW_TARGET] == 0.0


@pytest.mark.parametrize(
    ("memory", "expected"), [(0.0, [1, 0, 0, 0, 0]), (0.1, [1, 1, 1, 1, 0])]
)
def test_tracked_robot_is_noticed_while_it_is_near(memory, expected):
    """Out of view, near: that takes no memory. Behind a wall, it does."""
    dut = tree_of(
        f'<IsRobotVisible distance="4" track="true" memory="{memory}"/>'
    )
    who = person(obstacles=WALL, time_step=0.05)
    seen, kept = [], None
    behind, far = at(-2.0, 0.0), at(-5.0, 0.0)
    for robot in (at(0.5, 0.0), behind, far, far, far):
        outcome = tick(dut, who, None, robot, kept)
        kept = outcome.memory
        seen.append(int(outcome.node_status is NodeStatus.SUCCESS))
    assert seen == expected
    # A wall ends it.
    outcome = tick(dut, who, None, at(0.5, 0.0))
    for _ in range(2):
        outcome = tick(dut, who, None, at(2.0, 0.0), outcome.memory)
    outcome = tick(dut, who, None, at(2.0, 0.0), outcome.memory)
    assert outcome.node_status is NodeStatus.FAILURE


@pytest.mark.parametrize(
    ("seconds", "ticks"), [(0.0, 1), (0.25, 1), (0.3, 2), (1.0, 4)]
)
def test_standing_still_takes_its_time(seconds, ticks):
    dut = tree_of(f'<StandStill seconds="{seconds}"/>')
    who, memory, statuses = person(time_step=0.25), None, []
    for _ in range(2 * ticks):
        outcome = tick(dut, who, memory=memory)
        memory = outcome.memory
        statuses.append(outcome.node_status)
    once = [*[NodeStatus.RUNNING] * (ticks - 1), NodeStatus.SUCCESS]
    assert statuses == 2 * once


@pytest.mark.parametrize("name", BEHAVIORS)
def test_no_behavior_needs_a_robot(name):
    outcome = tick(LoadTree(name))
    assert outcome.behavior_status == 0
    assert wish(outcome)[Command.GOAL_X] == 9.0
