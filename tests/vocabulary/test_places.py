"""Queues and seats: the tests of the specification, by number."""

import math

import numpy as np
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.common.layout import Activity, Posture, Signal
from hunav_drake.systems.people.places import Place, complete_places
from tests.vocabulary.stage import DT, STAND, Stage, someone

S, F = NodeStatus.SUCCESS, NodeStatus.FAILURE

TILL = Place(name="till", type="counter", pose=(0, 0, 0))


def queue(more=""):
    node = f'<Queue name="it" place="till"{more}/>'
    return f"<RunOnce>{node}</RunOnce>"


def comers(count, seed, more=""):
    generator = np.random.default_rng(seed)
    people = []
    for _ in range(count):
        away, bearing = generator.uniform(4, 7), generator.uniform(1.6, 4.7)
        x, y = away * math.cos(bearing), away * math.sin(bearing)
        people.append(
            someone(
                *(x, y, generator.uniform(-3, 3), queue(more)),
                goals=[(4.0, 6.0)],
            )
        )
    return people


@pytest.mark.parametrize(
    "seed",
    [
        0,
        1,
        2,
        *(pytest.param(it, marks=pytest.mark.slow) for it in range(3, 30)),
    ],
)
def test_24_people_are_served_in_order_one_at_a_time(seed):
    stage = Stage(comers(5, seed), places=[TILL])
    tickets, order, times = {}, [], []
    while len(order) < 5:
        stage.step()
        assert stage.k * DT < 60
        for i in range(5):
            in_queue = stage.signal(i, Signal.ACTIVITY) == Activity.QUEUE
            if in_queue and i not in tickets:
                tickets[i] = (stage.signal(i, Signal.SINCE), i)
            if stage.statuses(i)["it"] == S and i not in order:
                order.append(i)
                times.append(stage.k * DT)
    assert order == sorted(tickets, key=tickets.get)
    # Each is served for 5 s, and comes after the one before.
    between = np.diff(times) - 5.0
    assert between.min() >= 1.0
    assert between.max() <= 2.0
    assert times[-1] <= 42


def test_24_who_waits_too_long_leaves_and_the_others_move_up():
    stand = Place(name="till", type="counter", pose=(0, 0, 0), seconds=30)
    people = comers(3, 1)
    people[1] = HumanConfig(
        pose=people[1].pose,
        goals=[(4.0, 6.0)],
        behavior=people[1].behavior.replace('"till"', '"till" patience="12"'),
    )
    stage = Stage(people, places=[stand])
    for _ in stage.run(12.5):
        pass
    assert stage.statuses(1)["it"] == 0
    for _ in stage.run(8.0):
        pass
    own = stage.states[[0, 2], :2]
    assert np.sort(np.hypot(*own.T)) == pytest.approx([0, 0.9], abs=0.25)


def test_people_queue_at_a_door_at_its_spacing():
    door = Place(name="till", type="door", pose=(0, 0, 0), width=2, spacing=0.7)
    people = [someone(x, 0, 0, queue()) for x in (-0.5, -1.8)]
    stage = Stage(people, places=[door])
    for _ in stage.run(2.5):
        pass
    assert stage.states[:, 0] == pytest.approx([0, -0.7], abs=0.25)


def seats(*xs):
    slots = [(x, 0.0, -math.pi / 2) for x in xs]
    return Place(name="bench", type="seat", pose=(0, 0, 0), slots=slots)


SIT = '<UsePlace name="it" place="bench" seconds="20" patience="15"/>'


def test_25_of_two_who_claim_the_last_seat_one_sits():
    nodes = f"<RunOnce>{SIT}</RunOnce>"
    people = [
        someone(-2, 3, 0, nodes, rest=STAND),
        someone(2, 3, 0, nodes, rest=STAND),
    ]
    stage = Stage(people, places=[seats(0.0)])
    ends = {}
    for _ in stage.run(30.0):
        seated = stage.signals[:, Signal.POSTURE] == Posture.SEATED
        assert seated.sum() <= 1
        for i in range(2):
            found = stage.statuses(i)["it"]
            if found in (S, F) and i not in ends:
                ends[i] = found
    assert ends == {0: S, 1: F}


@pytest.mark.parametrize(
    "seed",
    [0, 1, *(pytest.param(it, marks=pytest.mark.slow) for it in range(2, 100))],
)
def test_25_nobody_sits_on_a_seat_that_is_taken(seed):
    generator = np.random.default_rng(seed)
    people = [
        someone(
            *(*generator.uniform(-4, 4, 2), 0, f"<RunOnce>{SIT}</RunOnce>"),
            rest=STAND,
        )
        for _ in range(4)
    ]
    stage = Stage(people, places=[seats(-1.0, 1.0)])
    agreed = []
    for _ in stage.run(15.0):
        claims = stage.signals[:, Signal.SLOT]
        own = claims[claims >= 0]
        agreed.append(len({*own}) == len(own))
        at = np.hypot(*(stage.states[:, :2] - [[-1.0, 0.0]]).T) < 0.2
        assert at.sum() <= 1
    assert all(agreed[4:])
    assert (stage.signals[:, Signal.POSTURE] == Posture.SEATED).sum() == 2


def test_26_who_has_sat_walks_on():
    person = someone(
        *(-3, 2, 0),
        f"<RunOnce>{SIT.replace('20', '60')}</RunOnce>",
        goals=[(6, 3)],
    )
    stage = Stage([person], places=[seats(0.0)])
    sat = []
    for _ in stage.run(75.0):
        if stage.signal(0, Signal.POSTURE) == Posture.SEATED:
            sat.append(stage.states[0].copy())
    sat = np.array(sat)
    moves = np.abs(sat[:, 3:6]).max(axis=1) > 0
    assert (~moves).sum() == pytest.approx(60 / DT, abs=2)
    # It sits down in a second at most, and then is at rest.
    first = int(moves.sum())
    assert first <= 1 / DT
    assert not moves[first:].any()
    assert np.abs(sat[:, 2] + math.pi / 2).max() <= 0.06
    assert math.dist(stage.states[0, :2], (6, 3)) < 0.5


def test_a_screen_has_places_before_it_and_is_looked_at():
    screen = Place(name="screen", type="screen", pose=(0, 0, 0), seconds=3)
    (place,) = complete_places([screen])
    slots = np.array(place.all_slots())
    assert np.hypot(*slots[:, :2].T) == pytest.approx([2.0] * 5)
    node = '<RunOnce><UsePlace name="it" kind="screen"/></RunOnce>'
    people = [someone(4, y, 0, node, rest=STAND) for y in (-1, 0, 1)]
    stage = Stage(people, places=[screen])
    watched = 0
    for _ in stage.run(10.0):
        is_watching = stage.signals[:, Signal.GAZE] == -2
        watched = max(watched, is_watching.sum())
        towards = np.arctan2(-stage.states[:, 1], -stage.states[:, 0])
        off = np.abs(np.remainder(towards - stage.states[:, 2] + 1, 6.2832) - 1)
        still = is_watching & (stage.signals[:, Signal.ACTIVITY] == 8)
        assert (off[still] < 0.4).all()
    assert watched == 3
    assert {stage.statuses(i)["it"] for i in range(3)} == {0}


@pytest.mark.parametrize(
    ("more", "fault"),
    [
        (
            {"slots": [(0, 0, 0), (5, 0, 0), (0, 0.1, 1)]},
            r"slots\[2\]: must be at least 0.2 m from slots\[0\], got 0.1",
        ),
        (
            {"slots": [(0, 0, 0), (1, 0, 0)], "approaches": [(0, 1)]},
            "approaches: must be 2, one for each slot, got 1",
        ),
        (
            {"approaches": [(0, 4)]},
            r"approaches\[0\]: must be within 3 m of its slot, got 4",
        ),
    ],
)
def test_slots_and_approaches_must_make_sense(more, fault):
    with pytest.raises(ValueError, match=fault):
        Place(type="seat", pose=(0, 0, 0), **more)


def test_slots_may_be_0_2_m_apart():
    """But for rounding: 0.3 - 0.1 is less than 0.2."""
    slots = [(0.1, 0, 0), (0.3, 0, 0)]
    assert Place(type="seat", pose=(0, 0, 0), slots=slots).slots == slots
