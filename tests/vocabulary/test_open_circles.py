"""Open circles: the tests of the specification, by number."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.common.layout import OUTSIDE, SILENT, Activity, Signal
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.people.traffic import Sink, Traffic
from tests.vocabulary.stage import DT, STAND, Stage, someone

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE

MIDDLE = [Place(name="mid", pose=(0, 0, 0))]
OPENS = '<RunOnce><Converse name="it" center="mid" seconds="{}"{}/></RunOnce>'
JOINS = (
    '<TimeDelay delay="{}"><RunOnce><JoinConversation name="it" distance="9"'
    ' max_members="9" seconds="{}"/></RunOnce></TimeDelay>'
)


def radius(count):
    return 0.7 + 0.12 * (count - 1)


def comers(
    count, seed, *, last=60.0, host=60.0, late=1, more=' max_members="9"'
):
    """People who talk around the middle; after the host, `late` join later."""
    generator = np.random.default_rng(seed)
    people = []
    for i in range(count + late):
        away, bearing = generator.uniform(2, 6), generator.uniform(-3.1, 3.1)
        node = OPENS.format(host, more)
        if i:
            node = JOINS.format(
                0.05 if i < count else 20, last if i == 1 else 60
            )
        x, y = away * math.cos(bearing), away * math.sin(bearing)
        people.append(someone(x, y, generator.uniform(-3, 3), node, rest=STAND))
    return people


def members(stage):
    return np.flatnonzero(stage.signals[:, Signal.HOST] >= 0)


def is_formed(stage, rows):
    """Whether some people are all in a circle around the middle."""
    away = np.hypot(*stage.states[rows, :2].T)
    still = np.hypot(*stage.states[rows, 3:5].T) == 0
    return bool(
        (np.abs(away - radius(len(rows))) <= 0.12).all() and still.all()
    )


def least_distance(stage, rows):
    x, y = stage.states[rows, :2].T
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    return (apart + 99 * np.eye(len(rows))).min()


SEEDS = [0, *(pytest.param(it, marks=pytest.mark.slow) for it in range(1, 20))]


@pytest.mark.parametrize(
    "count", [2, pytest.param(3, marks=pytest.mark.slow), 4, 5, 6]
)
@pytest.mark.parametrize("seed", SEEDS)
def test_18_people_form_a_circle_and_another_one_joins(count, seed):
    stage = Stage(comers(count, seed), places=MIDDLE)
    own, everybody = np.arange(count), np.arange(count + 1)
    formed, joined = None, None
    for t in stage.run(26.0):
        if t <= 20 and is_formed(stage, own):
            formed = formed or t
        if t <= 20 and formed and t > formed + 0.5:
            assert is_formed(stage, own)
            assert least_distance(stage, own) >= 1.1
        if t > 20.1 and is_formed(stage, everybody):
            joined = joined or t
    assert formed
    assert formed <= 7
    assert joined


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("who", [0, 1])
def test_18_one_leaves_and_the_others_stay_around_the_same_middle(who, seed):
    people = comers(4, seed, late=0, **{("host", "last")[who]: 6.0})
    stage = Stage(people, places=MIDDLE)
    left, followed, seen = None, None, set()
    for t in stage.run(25.0):
        seen.add(stage.statuses(who)["it"])
        others = [it for it in members(stage) if it != who]
        if left is None and t > 7 and who not in members(stage):
            left = t
        if left and is_formed(stage, others):
            followed = followed or t
        for i in np.flatnonzero(stage.signals[:, Signal.OPEN]):
            middle = stage.signals[i, [Signal.CENTER_X, Signal.CENTER_Y]]
            assert np.abs(middle).max() <= 1e-12
    assert left
    assert S in seen
    assert F not in seen
    assert followed - left <= 3
    assert len(members(stage)) == 3


def test_who_leaves_as_the_host_may_end_the_circle():
    people = comers(4, 1, late=0, host=5.0, more=' leave="host"')
    stage = Stage(people, places=MIDDLE)
    ended = {}
    for _ in stage.run(20.0):
        for i in range(4):
            if stage.statuses(i)["it"] == S:
                ended.setdefault(i, stage.k)
    assert {ended[i] - ended[0] for i in (1, 2, 3)} == {1}


def test_a_full_circle_takes_nobody_in_until_somebody_leaves():
    people = comers(3, 3, late=0, last=8.0, more=' max_members="3"')
    nodes = JOINS.format(6, 5).replace("RunOnce", "ForceFailure")
    people.append(someone(3, 3, 0, nodes, rest=STAND))
    stage = Stage(people, places=MIDDLE)
    found, together = set(), 0
    for _ in stage.run(6.5):
        found.add(stage.statuses(3)["it"])
    assert found == {0, F}
    for _ in stage.run(20.0):
        found.add(stage.statuses(3)["it"])
        together = max(together, len(members(stage)))
    assert S in found
    assert together == 3


def test_of_those_who_come_to_the_last_place_at_once_one_stays():
    people = comers(1, 0, late=0, more=' max_members="2"')
    nodes = JOINS.format(1, 9).replace('members="9"', 'members="2"')
    people += [someone(3, y, 3.1, nodes, rest=STAND) for y in (-1, 1)]
    stage = Stage(people, places=MIDDLE)
    for _ in stage.run(3.0):
        pass
    assert [stage.statuses(i)["it"] for i in range(3)] == [R, R, 0]
    assert members(stage).tolist() == [0, 1]


def test_who_opens_a_circle_beside_another_one_joins_it():
    node = '<Converse name="it" seconds="9"/>'
    people = [
        someone(0, 0, 0, node, rest=STAND),
        someone(2, 0.3, math.pi, node, rest=STAND),
    ]
    stage = Stage(people)
    for _ in stage.run(5.0):
        pass
    assert stage.signals[:, Signal.HOST].tolist() == [0, 0]
    assert is_close(stage.distance(0, 1), 2 * radius(2))


def is_close(one, other):
    return abs(one - other) <= 0.24


def test_nobody_waits_alone_for_ever():
    node = '<Converse name="it" patience="3"/>'
    stage = Stage([someone(0, 0, 0, node, goals=[(6, 0)])])
    found = [stage.statuses(0)["it"] for _ in stage.run(3.5)]
    assert found.index(F) + 2 == pytest.approx(3 / DT, abs=1)


def test_a_robot_may_open_a_circle():
    node = '<JoinConversation name="it" seconds="4"/>'
    robot = [3.0, 0, 0, 0, 0, 0, 0.3]
    stage = Stage([someone(0, 0, 0, node)], robot=lambda t: robot)
    signal = np.array(SILENT)
    for which, value in (
        (Signal.ACTIVITY, Activity.CONVERSATION),
        (Signal.HOST, 1),
        (Signal.OPEN, 2),
        (Signal.CENTER_X, 3.0 - radius(2)),
    ):
        signal[which] = value
    stage.diagram.GetInputPort("robot_signals").FixValue(stage.context, signal)
    stage.step()
    found = {stage.statuses(0)["it"] for _ in stage.run(9.0)}
    assert S in found
    x, y = stage.states[0, :2]
    assert math.hypot(x - 3 + 2 * radius(2), y) <= 0.15


def test_who_goes_outside_is_no_longer_in_the_circle():
    """The host has gone by a sink; the others go on."""
    people = [
        someone(0, 1.0, -1.5, OPENS.format(3, ""), goals=[(0, 2.4)]),
        *(
            someone(x, 0, 0, JOINS.format(1, 60), rest=STAND)
            for x in (-1.0, 1.0)
        ),
    ]
    area = np.array([[0.0, 2.4]])
    traffic = Traffic(
        (), (Sink("exit", area, 1.0),), np.array([0, -1, -1]), np.zeros((3, 2))
    )
    stage = Stage(people, places=MIDDLE, traffic=traffic)
    for _ in stage.run(12.0):
        pass
    assert stage.states[0, 0] == OUTSIDE
    assert stage.signals[1:, Signal.HOST].tolist() == [1, 1]
    assert is_formed(stage, [1, 2])


@pytest.mark.parametrize("separate", [True, False])
def test_02_open_circles_go_on_bit_for_bit_from_forks(separate):
    people = comers(4, 2, host=4.0, last=5.0)
    stage = Stage(people, places=MIDDLE, separate_trees=separate)
    clones = []
    for k, _ in enumerate(stage.run(12.0)):
        if k % 24 == 7:
            clones.append(stage.context.Clone())
    expected = np.concatenate([stage.states.ravel(), stage.signals.ravel()])
    for clone in clones:
        simulator = Simulator(stage.diagram, clone)
        simulator.Initialize()
        simulator.AdvanceTo(12.0)
        found = [
            stage.diagram.GetOutputPort(name).Eval(clone)
            for name in ("human_states", "social_signals")
        ]
        np.testing.assert_array_equal(np.concatenate(found), expected)


def test_03_separate_trees_and_one_system_are_equal():
    rows = []
    for separate in (True, False):
        people = comers(5, 4, host=4.0, last=5.0)
        stage = Stage(people, places=MIDDLE, separate_trees=separate)
        own = [
            np.concatenate([stage.states.ravel(), stage.signals.ravel()])
            for _ in stage.run(14.0)
        ]
        rows.append(own)
    np.testing.assert_array_equal(*rows)


CHAT = '<SubTree ID="ChatTree" probability="1" seconds="10"/>'


@pytest.mark.parametrize("seed", range(4))
def test_people_who_meet_chat_and_then_walk_on(seed):
    beside = np.random.default_rng(seed).uniform(-1.2, 1.2)
    arrivals = []
    for node in ("", CHAT):
        people = [
            someone(-8, 0, 0, node, goals=[(8, 0)]),
            someone(8, beside, math.pi, node, goals=[(-8, beside)]),
        ]
        stage = Stage(people, seed=seed)
        there, talked = {}, 0
        for t in stage.run(45.0):
            talked += bool(node) and len(members(stage)) == 2
            for i, it in enumerate(people):
                if math.dist(stage.states[i, :2], it.goals[0]) < 0.5:
                    there.setdefault(i, t)
        arrivals.append(there)
        assert (talked > 8 / DT) == bool(node)
    later = [arrivals[1][i] - arrivals[0][i] for i in (0, 1)]
    assert min(later) >= 10
    assert max(later) <= 25
