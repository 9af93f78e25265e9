"""Speech, looks and chance: the tests of the specification, by number."""

import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.behavior import BehaviorTreeError, NodeStatus
from hunav_drake.systems.behavior.nodes.social import uniform
from hunav_drake.systems.behavior.nodes.texts import WORDS, text_code
from hunav_drake.systems.common.layout import SILENT, Signal
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.shapes import Polyline, World
from tests.vocabulary.stage import DT, STAND, Stage, robot_at, someone

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


def says(seconds, text, **ports):
    more = "".join(f' {key}="{value}"' for key, value in ports.items())
    return (
        f'<TimeDelay delay="{seconds}"><RunOnce><SaySomething'
        f' message="{text}"{more}/></RunOnce></TimeDelay>'
    )


def listener(node, **more):
    return someone(0, 0, nodes=node, **more)


@pytest.mark.slow
def test_03_one_system_for_all_gives_the_same_bits():
    generator = np.random.default_rng(0)
    nodes = (
        says(1.0, "hello there")
        + '<Sequence><FindNearestAgent max_distance="4"'
        ' target_agent_id="{who}"/><RandomChanceCondition probability="0.4"/>'
        '<ApproachAgent target_agent_id="{who}" duration="2"/></Sequence>',
        '<Sequence><IsAnyoneSpeaking speaker_id="{who}"/><LookAtAgent'
        ' target_id="{who}"/><FollowAgent target_agent_id="{who}"'
        ' duration="6"/></Sequence>',
        '<Sequence><IsAnyoneLookingAtMe observer_id="{who}"/><StopMovement/>'
        '<TimeExpiredCondition seconds="0.3"/><ResumeMovement/></Sequence>',
        "",
    )
    people = [
        someone(
            *generator.uniform(-6, 6, 2),
            generator.uniform(-3, 3),
            nodes[i % 4],
            goals=[tuple(generator.uniform(-6, 6, 2)) for _ in range(3)],
            cyclic=True,
        )
        for i in range(25)
    ]
    one, other = (Stage(people, separate_trees=it) for it in (True, False))
    seen = set()
    for _ in one.run(20.0):
        other.step()
        np.testing.assert_array_equal(one.states, other.states)
        np.testing.assert_array_equal(one.signals, other.signals)
        seen |= set(np.flatnonzero((one.signals != SILENT).any(axis=0)))
    assert {Signal.UTTERANCE, Signal.GAZE, Signal.ACTIVITY} <= seen


def test_04_signals_follow_from_the_state_alone():
    people = [someone(i, 0, nodes=says(1, "hi")) for i in range(5)]
    stage = Stage(people)
    for i in range(5):
        system = stage.diagram.GetSubsystemByName(f"behavior_{i}")
        port = system.GetOutputPort("signals").get_index()
        for j in range(system.num_input_ports()):
            assert not system.HasDirectFeedthrough(j, port)
    assert not stage.diagram.HasInputPort("robot_signals")


def test_05_what_is_said_is_heard_in_the_next_tick_while_it_lasts():
    text = "one two three four five"
    hears = '<IsAnyoneSpeaking name="hears" duration="0"/>'
    stage = Stage(
        [
            listener(f"<Inverter>{hears}</Inverter>"),
            someone(3, 0, nodes=says(1.0, text), rest=STAND),
        ]
    )
    said = [stage.statuses(1)["SaySomething"] == S]
    heard = [stage.statuses(0)["hears"] == S]
    for _ in stage.run(13.0):
        said.append(stage.statuses(1)["SaySomething"] == S)
        heard.append(stage.statuses(0)["hears"] == S)
    assert said.count(True) == 1
    first = said.index(True)
    expected = [first < k <= first + 40 for k in range(len(heard))]
    assert heard == expected


def test_06_the_nearest_of_two_who_speak_is_heard():
    node = (
        '<Sequence><IsAnyoneSpeaking distance_threshold="5" speaker_id="{who}"'
        '/><LookAtAgent target_id="{who}" walk="true"/></Sequence>'
    )
    stage = Stage(
        [
            listener(node, rest=STAND),
            someone(-4, 0, nodes=says(0.5, "left"), rest=STAND),
            someone(2, 0, nodes=says(0.5, "right"), rest=STAND),
        ]
    )
    for _ in stage.run(1.0):
        pass
    assert stage.signal(0, Signal.GAZE) == 2


def test_06_who_is_too_far_is_not_heard_and_the_listener_walks_on():
    node = '<IsAnyoneSpeaking distance_threshold="5"/>'
    stage = Stage(
        [
            listener(f"<RunOnce>{node}</RunOnce>", goals=[(0, 30)], rest=""),
            someone(-5.01, 0, nodes=says(0.0, "far", duration=9), rest=STAND),
        ]
    )
    ticks = 0
    while stage.statuses(0)["IsAnyoneSpeaking"] == R:
        ticks += 1
        stage.step()
    assert ticks == 99
    assert stage.states[0, 1] > 4.5


def test_07_chance_follows_from_seed_person_leaf_and_step():
    assert uniform(0, 0, 1, 4, 3, 0) == 0.19877603132755273
    assert uniform(0, 0, 1, 4, 3, 1) == 0.5945402471942259
    drawn = [uniform(0, 7, 2, 4, 1, k) < 0.3 for k in range(100_000)]
    assert np.mean(drawn) == pytest.approx(0.3, abs=0.005)


@pytest.mark.parametrize("seed", [0, 3, 2**40])
def test_07_a_person_more_changes_no_draw(seed):
    node = '<RandomChanceCondition name="chance" probability="0.3"/>'

    def drawn(count):
        stage = Stage([listener(node) for _ in range(count)], seed=seed)
        return [stage.statuses(0)["chance"] for _ in stage.run(5.0)]

    few, many = drawn(1), drawn(3)
    assert few == many
    assert {*few} == {S, F}


def test_07_a_draw_lasts_for_its_period():
    node = '<RandomChanceCondition name="it" probability="0.5" period="0.5"/>'
    stage = Stage([listener(node)])
    drawn = [stage.statuses(0)["it"] for _ in stage.run(30.0)][9:]
    blocks = [{*drawn[i : i + 10]} for i in range(0, 580, 10)]
    assert all(len(it) == 1 for it in blocks)
    assert len({*drawn}) == 2


@pytest.mark.parametrize(
    ("bearing", "distance", "wall", "occlusion", "seen"),
    [
        (1.73, 3, False, True, True),
        (1.75, 3, False, True, False),
        (-1.73, 3, False, True, True),
        (0.0, 5.0, False, True, True),
        (0.0, 5.01, False, True, False),
        (0.0, 3, True, True, False),
        (0.0, 3, True, False, True),
    ],
)
def test_08_who_is_in_view_is_seen(bearing, distance, wall, occlusion, seen):
    node = (
        '<IsAgentVisible name="it" agent_id="2"'
        f' occlusion="{str(occlusion).lower()}"/>'
    )
    walls = [Polyline(points=[(1, -9), (1, 9)])] * wall
    stage = Stage(
        [
            someone(0, 0, 0.4, node, rest=STAND),
            someone(
                distance * math.cos(0.4 + bearing),
                distance * math.sin(0.4 + bearing),
                rest=STAND,
            ),
        ],
        obstacles=World(walls=walls),
    )
    assert (stage.statuses(0)["it"] == S) == seen


def test_09_bounds_of_conditions():
    place = [Place(name="p", pose=(0.3, 0.4, 0))]
    nodes = "".join(
        f"<Inverter><ForceSuccess>{it}</ForceSuccess></Inverter>"
        for it in (
            '<IsAgentClose name="at" target_agent_id="2" threshold="2"/>',
            '<IsAgentClose name="in" target_agent_id="2" threshold="2.01"/>',
            '<IsAtPosition name="there" goal_id="p" tolerance="0.5"/>',
            '<IsAtPosition name="by id" goal_id="1" tolerance="0.5"/>',
            '<IsAtPosition name="off" goal_id="p" tolerance="0.499"/>',
            '<IsRobotClose name="near" threshold="3.01"/>',
            '<IsRobotClose name="not near" threshold="3"/>',
        )
    )
    people = [someone(0, 0, nodes=nodes), someone(2, 0, rest=STAND)]
    stage = Stage(people, places=place, robot=robot_at(0, 3))
    found = stage.statuses(0)
    assert {it for it in found if found[it] == S} >= {
        "in",
        "there",
        "by id",
        "near",
    }
    assert {found[it] for it in ("at", "off", "not near")} == {F}


@pytest.mark.parametrize(("off", "faces"), [(0.29, True), (0.31, False)])
def test_09_a_robot_faces_within_an_angle(off, faces):
    node = '<IsRobotFacingAgent name="it"/>'
    for sign in (1, -1):
        robot = robot_at(4, 0, math.pi + sign * off)
        stage = Stage([listener(node)], robot=robot)
        assert (stage.statuses(0)["it"] == S) == faces


@given(st.sampled_from([3.0, -3.0]))
def test_10_a_look_at_a_point_takes_as_long_as_the_turn(bearing):
    place = [
        Place(name="p", pose=(5 * math.cos(bearing), 5 * math.sin(bearing), 0))
    ]
    stage = Stage(
        [listener('<LookAtPoint name="it" goal_id="p"/>', rest=STAND)],
        places=place,
    )
    statuses, yaws = [stage.statuses(0)["it"]], [stage.states[0, 2]]
    for _ in stage.run(2.0):
        statuses.append(stage.statuses(0)["it"])
        yaws.append(stage.states[0, 2])
    assert statuses[:19] == [R] * 19
    assert statuses[19] == S
    turned = np.abs(np.unwrap(yaws))
    assert np.diff(turned).max() <= math.pi * DT + 1e-9
    assert turned.max() <= 3.0 + 1e-9


def test_11_a_look_follows_who_walks_by():
    for near, expected in ((0.05, S), (0.01, R)):
        node = f'<LookAtAgent name="it" target_id="2" yaw_tolerance="{near}"/>'
        stage = Stage(
            [
                listener(node, rest=STAND),
                someone(
                    1.5, -2, math.pi / 2, goals=[(1.5, 9)], desired_speed=1.0
                ),
            ]
        )
        for _ in stage.run(2.5):
            pass
        assert abs(stage.states[1, 1]) < 1.0
        assert stage.statuses(0)["it"] == expected
        assert stage.signal(0, Signal.GAZE) == 1


def test_12_a_look_is_a_gaze_and_not_a_walk():
    looks = '<LookAtPoint goal_id="p" walk="true"/>'
    place = [Place(name="p", pose=(6, 9, 0))]
    watcher = someone(
        *(0, 0, 0.0),
        '<IsAnyoneLookingAtMe name="it" duration="60"/>',
        rest=STAND,
    )
    walker = someone(
        *(6, 0, math.pi, f"<Inverter>{looks}</Inverter>"), goals=[(1, 0)]
    )
    stage = Stage([watcher, walker], places=place)
    for _ in stage.run(2.0):
        assert stage.statuses(0)["it"] == R
    # Without a gaze elsewhere, who walks here looks here.
    stage = Stage([watcher, someone(6, 0, math.pi, goals=[(1, 0)])])
    for _ in stage.run(2.0):
        pass
    assert stage.statuses(0)["it"] == S


def test_12_a_look_must_be_held():
    watcher = someone(
        *(0, 0, 0.0),
        '<IsAnyoneLookingAtMe name="it" duration="60" hold="1"'
        ' observer_id="{who}"/>',
        rest=STAND,
    )
    looks = (
        '<TimeDelay delay="1"><LookAtAgent target_id="1" walk="true"/>'
        "</TimeDelay>"
    )
    other = someone(2, 0, math.pi / 2, f"<Inverter>{looks}</Inverter>", STAND)
    stage = Stage([watcher, other])
    seen, statuses = [], []
    for _ in stage.run(3.0):
        seen.append(stage.signal(1, Signal.GAZE) == 0)
        statuses.append(stage.statuses(0)["it"])
    first = seen.index(True)
    assert statuses.index(S) == first + 19


@pytest.mark.parametrize(
    ("node", "words"),
    [
        ('<IsAgentClose target_agent_id="9"/>', "nobody has the number 9"),
        (
            '<GoTo goal_id="bar"/>',
            "there is no place 'bar'; add it.*did you mean 'bat'",
        ),
        (
            '<SetGroupWalk non_main_agent_ids="2, 2"/>',
            "must be at most 6 different numbers",
        ),
        (
            '<SetGroupWalk non_main_agent_ids="two"/>',
            "must be numbers of people",
        ),
        ("<FollowAgent/>", "the port target_agent_id must be given"),
    ],
)
def test_who_and_what_is_not_there_is_told_when_people_are_made(node, words):
    places = [Place(name="bat", pose=(0, 0, 0))]
    people = [listener(node), someone(1, 0)]
    with pytest.raises(BehaviorTreeError, match=words):
        Stage(people, places=places)


def test_an_entry_that_nothing_has_set_is_nobody():
    node = (
        '<Fallback><IsAgentClose name="it" target_agent_id="{who}"/><Sequence>'
        "<AlwaysFailure/><FindNearestAgent"
        ' target_agent_id="{who}"/></Sequence></Fallback>'
    )
    stage = Stage([listener(node), someone(1, 0)])
    assert stage.statuses(0)["it"] == F


def test_the_number_of_a_text_tells_its_words():
    assert text_code("") == 0
    assert text_code("one two  three") % WORDS == 3
    assert text_code("a b") != text_code("b a")
    assert text_code("x " * 5000) < 2**33


def test_trees_without_social_leaves_have_no_signals():
    stage = Stage([someone(0, 0), someone(1, 0)], robot=robot_at(5, 0))
    assert not stage.diagram.HasOutputPort("social_signals")
    assert not stage.diagram.HasInputPort("robot_signals")
    system = stage.diagram.GetSubsystemByName("behavior_0")
    assert not system.HasOutputPort("signals")
