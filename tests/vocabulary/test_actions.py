"""Going, following and talking: the tests of the specification, by number."""

import math

import numpy as np
import pytest

from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.common.layout import Activity, Command, Signal
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.shapes import Polyline, World
from tests.vocabulary.stage import DT, STAND, Stage, robot_at, someone

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


def speeds(stage):
    return np.hypot(*stage.states[:, 3:5].T)


def after(seconds, node):
    return f'<TimeDelay delay="{seconds}">{node}</TimeDelay>'


def test_13_who_has_stopped_stands_until_told_to_go_on():
    nodes = after(
        1, "<Inverter><RunOnce><StopMovement/></RunOnce></Inverter>"
    ) + after(4, "<Inverter><RunOnce><ResumeMovement/></RunOnce></Inverter>")
    stage = Stage([someone(0, 0, nodes=nodes, goals=[(20, 0)])])
    still = []
    for t in stage.run(6.0):
        if 1.6 < t < 3.9:
            still.append(stage.states[0].copy())
        elif t > 4.6:
            assert speeds(stage)[0] > 1.0
    still = np.array(still)
    assert np.ptp(still, axis=0).max() == 0
    assert (still[:, 3:6] == 0).all()


def test_13_who_waits_for_some_time_walks_on():
    wait = '<RunOnce><StopAndWaitTimerAction wait_duration="2"/></RunOnce>'
    stage = Stage([someone(0, 0, nodes=after(1, wait), goals=[(20, 0)])])
    found, still = [], 0
    for _ in stage.run(5.0):
        found.append(stage.statuses(0)["StopAndWaitTimerAction"])
        still += speeds(stage)[0] == 0
    assert (found.count(R), found.count(S)) == (39, 1)
    # (It takes a moment to come to rest.)
    assert 30 <= still <= 40
    assert speeds(stage)[0] > 1.0


def test_14_a_place_is_reached_and_the_goals_stay():
    place = [Place(name="p", pose=(3, 2, 0))]
    node = (
        '<RunOnce><Sequence><GoTo name="go" goal_id="p" tolerance="0.1"/>'
        '<IsAtPosition name="there" goal_id="p" tolerance="0.1"/></Sequence>'
        "</RunOnce>"
    )
    stage = Stage([someone(0, 0, nodes=node, goals=[(9, 0)])], places=place)
    found = stage.statuses(0)
    while found["go"] != S:
        stage.step()
        found = stage.statuses(0)
    assert stage.k * DT < 5
    assert found["there"] == S
    assert np.hypot(*(stage.states[0, :2] - [3, 2])) <= 0.1
    for _ in stage.run(8.0):
        pass
    assert stage.states[0, :2] == pytest.approx([9, 0], abs=0.5)


def test_nobody_arrives_exactly():
    """Or turns exactly: a tolerance is more than nothing."""
    for node, port in (
        ('<GoTo goal_id="0"', "tolerance"),
        ('<LookAtPoint goal_id="0"', "yaw_tolerance"),
    ):
        person = someone(0, 0, 0, f'{node} {port}="0"/>')
        with pytest.raises(ValueError, match=f"{port}: must be in"):
            Stage([person], places=[Place(name="spot", pose=(3, 0, 0))])


def test_15_places_become_goals():
    places = [Place(name=f"p{i}", pose=(i, 4.0, 0)) for i in range(1, 4)]
    nodes = (
        '<RunOnce><SetGoal goal_id="p1"/></RunOnce>'
        '<RunOnce><SetGoal goal_id="p2" mode="next"/></RunOnce>'
        '<RunOnce><SetGoal goal_id="p3" mode="next"/></RunOnce>'
    )
    stage = Stage(
        [
            someone(0, 0, nodes=nodes, goals=[(2, 0), (5, 0)]),
            someone(0, 9, nodes=nodes, goals=[(2, 9), (5, 9)], cyclic=True),
            someone(0, 20, nodes=nodes),
            someone(
                *(0, 30, 0),
                '<RunOnce><SetGoal goal_id="p2" mode="replace"/></RunOnce>',
                goals=[(9, 30)],
            ),
        ],
        places=places,
    )
    named = {it.pose[:2]: it.name for it in places}
    way = [[], [], [], []]
    for _ in stage.run(60.0):
        for i, own in enumerate(way):
            command = stage.command(i)
            goal = tuple(command[:2].tolist())
            name = named.get(goal, goal) if command[Command.HAS_GOAL] else None
            if own[-1:] != [name]:
                own.append(name)
    assert way[0] == [(2, 0), "p3", "p2", (5, 0), "p1", None]
    assert way[1][:7] == [(2, 9), "p3", "p2", (5, 9), "p1", (2, 9), (5, 9)]
    assert way[2] == ["p1", "p3", "p2", None]
    assert way[3] == ["p2", None]


def test_15_seventeen_places_are_too_many():
    place = [Place(name="p", pose=(5, 0, 0))]
    node = '<ForceFailure><SetGoal name="it" goal_id="p"/></ForceFailure>'
    stage = Stage(
        [someone(0, 0, nodes=node, rest=STAND, goals=[(9, 0)])], places=place
    )
    found = [stage.statuses(0)["it"]]
    found += [stage.statuses(0)["it"] for _ in stage.run(1.0)]
    assert found[:17] == [S] * 16 + [F]


def circle(count, seconds=10.0, more=""):
    others = ",".join(str(i) for i in range(2, count + 1))
    return (
        f'<RunOnce><ConversationFormation name="talk" goal_id="mid"'
        f' non_main_agent_ids="{others}" conversation_duration="{seconds}"'
        f"{more}/></RunOnce>"
    )


MIDDLE = [Place(name="mid", pose=(0, 0, 0))]


def around(count, seed, nodes, **more):
    """People who walk past the middle, and the first one's own nodes."""
    generator = np.random.default_rng(seed)
    people = []
    for i in range(count):
        bearing = 2 * math.pi * i / count + generator.uniform(-0.3, 0.3)
        x, y = generator.uniform(3, 8) * np.array(
            [math.cos(bearing), math.sin(bearing)]
        )
        people.append(
            someone(
                *(x, y, generator.uniform(-3, 3)),
                nodes if i == 0 else "",
                goals=[(-x, -y)],
                **(more if i else {}),
            )
        )
    return people


@pytest.mark.parametrize("seed", range(5))
def test_16_four_people_talk_in_a_circle_and_then_walk_on(seed):
    stage = Stage(around(4, seed, circle(4)), places=MIDDLE)
    ready = []
    for t in stage.run(25.0):
        if stage.statuses(0)["talk"] != R:
            break
        away = np.hypot(*stage.states[:, :2].T)
        bearing = np.arctan2(-stage.states[:, 1], -stage.states[:, 0])
        off = np.remainder(bearing - stage.states[:, 2] + np.pi, 2 * np.pi)
        if np.abs(away - 1.1).max() <= 0.2 and np.abs(off - np.pi).max() < 0.05:
            ready.append(t)
    assert stage.statuses(0)["talk"] == S
    assert ready[0] <= 12
    assert len(ready) * DT >= 9.9
    for _ in stage.run(12.0):
        pass
    goals = [-np.array(it.pose[:2]) for it in around(4, seed, "")]
    assert np.abs(stage.states[:, :2] - goals).max() < 0.6


def test_16_partners_walk_on_in_the_tick_after_the_host_is_halted():
    node = (
        '<ReactiveSequence><Inverter><TimeExpiredCondition seconds="6"'
        f' only_once="true"/></Inverter>{circle(4, 99)}</ReactiveSequence>'
    )
    stage = Stage(around(4, 0, node), places=MIDDLE)
    talking = []
    for _ in stage.run(8.0):
        talking.append(stage.signals[:, Signal.ACTIVITY] == 1)
    talking = np.array(talking)
    last = [np.flatnonzero(it)[-1] for it in talking.T]
    assert last[1:] == [last[0] + 1] * 3


def test_17_without_a_partner_there_is_no_talk():
    people = around(3, 0, circle(3), invitations="ignore")
    people[1].invitations = "accept"
    stage = Stage(people, places=MIDDLE)
    ticks = 0
    while stage.statuses(0)["talk"] == R:
        ticks += 1
        stage.step()
    assert stage.statuses(0)["talk"] == F
    assert ticks == pytest.approx(30 / DT, abs=1)
    for _ in stage.run(12.0):
        pass
    assert speeds(stage).max() < 0.2
    assert (stage.signals[:, Signal.ACTIVITY] == 0).all()


@pytest.mark.parametrize("speed", [0.6, 1.0, 1.2])
def test_19_a_person_follows_at_a_distance(speed):
    node = '<FollowAgent target_agent_id="2"/>'
    stage = Stage(
        [
            someone(-3, 0.5, nodes=node, desired_speed=1.2, max_speed=1.5),
            someone(0, 0, goals=[(14 * speed, 0)], desired_speed=speed),
        ]
    )
    for t in stage.run(26.0):
        if 10 < t < 12:
            assert stage.distance(0, 1) == pytest.approx(1.5, abs=0.15)
            assert stage.signal(0, Signal.ACTIVITY) == Activity.FOLLOW
    assert speeds(stage)[0] == 0
    assert stage.distance(0, 1) >= 1.3


def test_19_who_is_out_of_sight_is_lost():
    node = '<FollowAgent name="it" target_agent_id="2" lost="1"/>'
    wall = World(walls=[Polyline(points=[(2, -9), (2, 9)])])
    people = [someone(0, 0, nodes=node), someone(4, 0, rest=STAND)]
    stage = Stage(people, obstacles=wall)
    found = [stage.statuses(0)["it"]]
    found += [stage.statuses(0)["it"] for _ in stage.run(1.5)]
    assert found.index(F) == 19


def test_20_a_person_walks_up_to_a_robot():
    node = '<ApproachRobot name="it"/>'
    for cap, low, high in ((1.8, 3.15, 3.55), (1.2, 3.2, 3.8)):
        stage = Stage(
            [someone(0, 0, 0, node, desired_speed=1.2, max_speed=cap)],
            robot=robot_at(5, 0),
        )
        arrival = 0.0
        for t in stage.run(6.0):
            assert speeds(stage)[0] <= cap + 1e-9
            if not arrival and 5 - stage.states[0, 0] <= 1.5:
                arrival = t
        assert low <= arrival <= high
        assert speeds(stage)[0] == 0
        assert abs(stage.states[0, 2]) < 0.05


def test_20_a_person_gives_way_to_a_robot_that_comes():
    robot = robot_at(6, 0, math.pi, 0.5)
    stage = Stage([someone(0, 0, 0, "<ApproachRobot/>")], robot=robot)
    nearest = math.inf
    for t in stage.run(10.0):
        if t > 4:
            nearest = min(nearest, abs(stage.robot[0] - stage.states[0, 0]))
    assert stage.states[0, 0] < 0
    assert nearest > 0.8


@pytest.mark.parametrize("yaw", [0.0, 2.0, -1.0])
def test_21_who_blocks_another_stands_in_front(yaw):
    node = '<BlockAgent target_agent_id="2"/>'
    stage = Stage([someone(3, 3, nodes=node), someone(0, 0, yaw, rest=STAND)])
    for _ in stage.run(8.0):
        pass
    expected = [math.cos(yaw), math.sin(yaw)]
    assert stage.states[0, :2] == pytest.approx(expected, abs=0.12)
    bearing = math.atan2(-stage.states[0, 1], -stage.states[0, 0])
    off = math.remainder(stage.states[0, 2] - bearing, 2 * math.pi)
    assert abs(off) < 0.05


@pytest.mark.parametrize("speed", [0.0, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("yaw", [0.0, 2.5])
def test_21_who_blocks_a_robot_stays_in_front(speed, yaw):
    """HuNavSim 2's BlockRobot, which its ports tell."""
    along = np.array([math.cos(yaw), math.sin(yaw)])
    stage = Stage(
        [someone(*(3.0 * along), yaw, nodes='<BlockRobot max_vel="2.0"/>')],
        robot=robot_at(0, 0, yaw, speed),
    )
    for t in stage.run(9.0):
        x, y, own = stage.states[0, :3]
        rx, ry = stage.robot[:2]
        gap = math.hypot(x - rx, y - ry)
        least = 0.0 if speed == 0 else -0.15
        if t > 3.5:
            off = math.remainder(math.atan2(y - ry, x - rx) - yaw, math.tau)
            assert abs(off) <= 0.2
            off = math.remainder(math.atan2(ry - y, rx - x) - own, math.tau)
            assert abs(off) <= 0.2
            most = 0.1 if speed == 0 else 0.15
            assert least <= gap - (1.0 + 0.5 * speed) <= most


def test_21_blocking_a_robot_ends():
    stage = Stage(
        [someone(2, 0, goals=[(9, 0)], nodes='<BlockRobot duration="3"/>')],
        robot=robot_at(0, 0, 0, 0),
    )
    ends = [
        t
        for t in stage.run(6.0)
        if stage.statuses(0)["StayInFrontOfRobot"] == S
    ]
    assert ends == pytest.approx([3.0, 6.0], abs=1.5 * DT)


@pytest.mark.parametrize(
    ("ports", "spans"),
    [
        ('beh_duration="2" only_once="false"', [(1, 3), (5, 7)]),
        ('beh_duration="2" only_once="true"', [(1, 3)]),
        ('beh_duration="2"', [(1, 3), (5, 7)]),
        ('beh_duration="0"', [(1, 4), (5, 8)]),
        ('only_once="true"', [(1, 4), (5, 8)]),
    ],
)
def test_reactions_of_hunavsim_2_have_a_limit(ports, spans):
    """Who is surprised stands; the robot is seen from 1 to 4 s and 5 to 8 s."""

    def robot(t):
        near = 1 <= t < 4 or 5 <= t < 8
        return robot_at(0, 3 if near else 500, 0, 0)(t)

    nodes = (
        "<Sequence><IsRobotClose threshold='100'/>"
        f"<SurprisedNav {ports}/></Sequence>"
    )
    stage = Stage([someone(0, 0, goals=[(50, 0)], nodes=nodes)], robot=robot)
    stands = [
        t for t in stage.run(9.0) if stage.statuses(0)["SurprisedNav"] == S
    ]
    expected = [
        t for t in np.arange(0, 9.0, DT) if any(a <= t < b for a, b in spans)
    ]
    assert len(stands) == pytest.approx(len(expected), abs=2 * len(spans))
    for a, b in spans:
        inside = [t for t in stands if a - 0.1 <= t <= b + 0.1]
        assert len(inside) * DT == pytest.approx(b - a, abs=0.1)


@pytest.mark.parametrize("condition", ["_skipIf", "_failureIf"])
def test_a_reaction_that_is_not_used_uses_no_time(condition):
    """It is left out for 2 s; then it lasts 1 s, and the walk goes on."""
    nodes = (
        "<Inverter><SetBlackboard output_key='wait' value='1'/></Inverter>"
        "<ForceFailure><Sequence><TimeOfTrial from='2'/><SetBlackboard"
        " output_key='wait' value='0'/></Sequence></ForceFailure>"
        f"<SurprisedNav beh_duration='1' {condition}='wait == 1'/>"
    )
    stage = Stage(
        [someone(0, 0, goals=[(50, 0)], nodes=nodes)],
        robot=robot_at(0, 3, 0, 0),
    )
    stands, walks = [], []
    for t in stage.run(5.0):
        statuses = stage.statuses(0)
        stands += [t] if statuses["SurprisedNav"] == S else []
        walks += [t] if statuses["RegularNav"] == S else []
    assert (stands[0], stands[-1]) == pytest.approx((2, 3), abs=1.5 * DT)
    assert len(stands) + len(walks) == round(5.0 / DT)


@pytest.mark.slow
def test_22_a_person_keeps_away_from_a_robot():
    node = "<AvoidRobot/>"
    stage = Stage(
        [someone(2, 0.1, nodes=node, desired_speed=1.5)],
        robot=robot_at(0, 0, 0, 0.5),
    )
    for t in stage.run(12.0):
        away = np.hypot(*(stage.states[0, :2] - stage.robot[:2]))
        assert t < 3 or away >= 2.9


def test_22_a_person_flees_along_a_wall_and_then_stands():
    wall = World(walls=[Polyline(points=[(3, -30), (3, 30)])])
    robot = robot_at(0.5, 0)
    stage = Stage(
        [someone(2, 0.2, nodes="<AvoidRobot/>", desired_speed=1.5)],
        robot=robot,
        obstacles=wall,
    )
    for _ in stage.run(10.0):
        pass
    away = np.hypot(*(stage.states[0, :2] - stage.robot[:2]))
    assert 3.0 <= away <= 3.45
    assert speeds(stage)[0] == 0
    assert stage.states[0, 0] < 2.7


def test_23_three_people_walk_to_a_goal_as_a_group():
    apart = {}
    for node in ('<SetGroupWalk non_main_agent_ids="2,3" duration="6"/>', ""):
        people = [
            someone(
                0,
                2.0 * (i - 1),
                nodes=f"<RunOnce>{node}</RunOnce>" if i == 1 and node else "",
                goals=[(30, 2.0 * (i - 1))],
                id=(2, 1, 3)[i],
            )
            for i in range(3)
        ]
        stage = Stage(people)
        for _ in stage.run(5.0):
            pass
        middle = stage.states[:, :2].mean(axis=0)
        apart[node] = np.hypot(*(stage.states[:, :2] - middle).T).max()
        if node:
            assert (stage.signals[:, Signal.ACTIVITY] == 10).all()
            assert (stage.signals[:, Signal.HOST] == 1).all()
            for _ in stage.run(2.0):
                pass
            assert (stage.signals[:, Signal.HOST] == -1).all()
    walk, alone = apart.values()
    assert walk < 0.9
    assert alone > 1.6


def test_32_a_greeting_is_not_said_again_for_some_time():
    node = (
        '<ForceFailure><Cooldown seconds="10"><Sequence><IsRobotVisible'
        ' distance="6"/><SaySomething name="it" message="hello"/></Sequence>'
        "</Cooldown></ForceFailure>"
    )
    stage = Stage(
        [someone(0, 0, nodes=node, goals=[(4, 0), (0, 0)], cyclic=True)],
        robot=robot_at(5, 1),
    )
    said = [
        k for k, _ in enumerate(stage.run(40.0)) if stage.statuses(0)["it"] == S
    ]
    assert len(said) >= 2
    assert np.diff(said).min() >= 200
    assert speeds(stage)[0] > 0.3
