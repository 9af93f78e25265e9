"""People who make way use the room there is, and let the robot go."""

import functools
import itertools
import math

import numpy as np
import pytest
import yaml

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.common.layout import Contact
from tests.reaction_table import placements

PLANNERS = ["pursuit", "dwb"]
WIDTHS = [1.5, 1.7, 1.9, 2.1, 2.3, 2.6]


def some(cases, quick):
    """All cases, of which those not among the quick ones are slow."""
    return [
        it if it in quick else pytest.param(*it, marks=pytest.mark.slow)
        for it in cases
    ]


# People who meet a robot that drives from (-8, 0) to (8, 0): poses and goals.
MEETINGS = {
    "head-on": [((7.0, 0.1, math.pi), [(-7.0, 0.1)])],
    "aslant": [((7.0, -0.25, math.pi), [(-7.0, 0.2)])],
    "waiting ahead": [((-4.0, 0.1, 0.0), [(7.0, 0.1)])],
    "standing": [((1.0, 0.1, math.pi), [])],
    "standing, back turned": [((1.0, -0.1, 0.0), [])],
    "three": [
        ((6.0, 0.2, math.pi), [(-7.0, 0.2)]),
        ((5.0, -0.2, math.pi), [(-7.0, -0.2)]),
        ((1.0, 0.0, math.pi), []),
    ],
}
OVERTAKING = [((-8.0, 0.1, 0.0), [(8.0, 0.1)])]


def walls(kind, width):
    """The centers and sizes of boxes about a corridor along x."""
    half = width / 2
    sides = [((0.0, s * (half + 0.1)), (18.4, 0.2)) for s in (1, -1)]
    if kind == "open":
        return sides
    if kind == "closed":
        return sides + [((s * 9.1, 0.0), (0.2, width)) for s in (1, -1)]
    # A corridor of 10 m between two rooms.
    assert kind == "rooms"
    thick = 4.0 - half
    return [
        *(((0.0, s * 4.1), (18.4, 0.2)) for s in (1, -1)),
        *(((s * 9.1, 0.0), (0.2, 8.0)) for s in (1, -1)),
        *(((0.0, s * (half + thick / 2)), (10.0, thick)) for s in (1, -1)),
    ]


def trial(
    kind,
    width,
    people,
    planner="pursuit",
    *,
    behavior="cooperative",
    start=-8.0,
    turn=0.0,
    mirror=False,
):
    """Returns a scenario in a corridor, turned about the origin."""
    c, s = math.cos(turn), math.sin(turn)
    sign = -1.0 if mirror else 1.0

    def placed(x, y, *yaw):
        y = sign * y
        angles = [math.remainder(sign * it + turn, math.tau) for it in yaw]
        return [c * x - s * y, s * x + c * y, *angles]

    data = {
        "world": {
            "walls": [
                {
                    "type": "box",
                    "center": placed(*center),
                    "size": list(size),
                    "yaw": turn,
                }
                for center, size in walls(kind, width)
            ]
        },
        "humans": [
            {
                "name": f"person {i}",
                "pose": placed(*pose),
                "behavior": behavior,
                "goals": [placed(*goal) for goal in goals],
            }
            for i, (pose, goals) in enumerate(people)
        ],
        "robot": {
            "start": placed(start, 0.0, 0.0),
            "goal": placed(8.0, 0.0, 0.0),
            "goal_tolerance": 0.25,
            "goal_yaw_tolerance": 0.25,
        },
        "planner": planner,
        "simulation": {"duration": 150.0, "stuck_time": 60.0},
    }
    return LoadScenario(data=yaml.safe_dump(data))


def gaps(scenario, result):
    """The gaps between the robot and each body, of all samples."""
    recording = result.recording
    offsets = recording.humans[:, :, :2] - recording.robot[:, None, :2]
    radii = np.array([it.contact_radius for it in scenario.humans])
    away = np.hypot(offsets[..., 0], offsets[..., 1])
    return away - radii - scenario.robot.radius


def contacts(result):
    """Returns the numbers of contacts that the robot and people began."""
    columns = [Contact.BY_ROBOT, Contact.BY_PERSON]
    return (
        result.recording.contacts[-1]
        .reshape(-1, len(Contact))[:, columns]
        .sum()
    )


def check_let_go(scenario):
    """Runs a trial in which the robot arrives and nobody is touched."""
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    assert contacts(result) == 0
    assert gaps(scenario, result).min() > 0.02
    return result


@pytest.mark.parametrize(
    ("width", "planner"),
    some(itertools.product(WIDTHS, PLANNERS), [(1.5, "dwb"), (2.3, "pursuit")]),
)
def test_corridor_is_left_or_used_to_its_walls(width, planner):
    """If it is too narrow for both, the person goes out of it."""
    scenario = trial("rooms", width, MEETINGS["head-on"], planner)
    result = check_let_go(scenario)
    at = result.recording.humans[:, 0]
    # The person is past the robot, and on its own way again.
    assert at[-1, 0] < result.recording.robot[-1, 0] - 1.0
    robot = result.recording.robot
    beside = np.argmin(np.abs(at[:, 0] - robot[:, 0]))
    in_corridor = abs(at[beside, 0]) < 5.0
    assert in_corridor == (width > 2.2)
    if in_corridor:
        # 0.1 m more than both discs, where that leaves the body room.
        assert abs(at[beside, 1]) > min(width / 2 - 0.33, 1.05)
        assert abs(at[beside, 1]) > 0.8


def in_turn(cases):
    """Gives each case a planner, one after the other."""
    return [
        (*case, planner)
        for case, planner in zip(cases, itertools.cycle(PLANNERS))
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "meeting", "planner"),
    in_turn(itertools.product(WIDTHS, list(MEETINGS)[1:])),
)
def test_everybody_lets_go_in_corridors(meeting, width, planner):
    check_let_go(trial("rooms", width, MEETINGS[meeting], planner))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("meeting", "width", "planner"),
    in_turn(itertools.product(MEETINGS, [2.3, 2.6]))[::-1],
)
def test_there_is_room_in_a_closed_corridor(meeting, width, planner):
    check_let_go(trial("closed", width, MEETINGS[meeting], planner))


@pytest.mark.parametrize("planner", PLANNERS)
def test_nobody_is_stuck_at_the_end_of_a_closed_corridor(planner):
    """A person squeezes past the robot that stands before the end."""
    scenario = trial("closed", 1.9, MEETINGS["waiting ahead"], planner)
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    assert contacts(result) == 0


def random_people(number, width):
    """People in a corridor: every fourth time some, every second with goals."""
    rng = np.random.default_rng([9, number])
    half = np.array([4.5, width / 2 - 0.4])
    count = int(rng.integers(1, 4)) if number % 4 == 3 else 1
    people = []
    while len(people) < count:
        pose, goal = rng.uniform(-half, half, (2, 2)).round(3).tolist()
        yaw = float(rng.uniform(-math.pi, math.pi))
        if all(math.dist(pose, it[0][:2]) > 0.8 for it in people):
            goals = [(1.6 * goal[0], goal[1])] if number % 2 else []
            people.append(((*pose, yaw), goals))
    return people, float(rng.uniform(-3.0, 3.0))


def check_random(number, kind, planner):
    widths = WIDTHS[3:] if kind == "closed" else WIDTHS
    width = widths[number % len(widths)]
    people, turn = random_people(number, width)
    mirror = number % 3 == 0
    check_let_go(trial(kind, width, people, planner, turn=turn, mirror=mirror))


@pytest.mark.parametrize(("number", "planner"), [(3, "dwb"), (6, "pursuit")])
def test_first_random_corridors(number, planner):
    check_random(number, "rooms", planner)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(36))
def test_random_corridors(number):
    kind = ("rooms", "open", "closed")[number // 4 % 3]
    check_random(number, kind, PLANNERS[number // 12 % 2])


def test_corridors_may_lie_anyhow():
    """The same happens, turned."""
    people = MEETINGS["aslant"]
    straight = RunTrial(trial("rooms", 1.7, people)).recording
    turned = RunTrial(
        trial("rooms", 1.7, people, turn=-1.0, mirror=True)
    ).recording
    assert turned.times[-1] == pytest.approx(straight.times[-1], abs=0.6)
    # (A corridor has two equal sides, and rounding decides for one.)
    length = [
        np.hypot(*np.diff(it.robot[:, :2], axis=0).T).sum()
        for it in (straight, turned)
    ]
    assert length[0] == pytest.approx(length[1], abs=0.05)


@pytest.mark.parametrize(
    ("width", "planner"),
    some(itertools.product([1.5, 1.9, 2.6], PLANNERS), [(1.9, "dwb")]),
)
def test_nobody_overtakes_a_robot_without_room(width, planner):
    """They once walked 7.9 m beside it at a gap of 0.04 m."""
    scenario = trial("open", width, OVERTAKING, planner, start=-5.0)
    result = check_let_go(scenario)
    gap = gaps(scenario, result)[:, 0]
    at = result.recording.humans[:, 0]
    steps = np.hypot(*np.diff(at[:, :2], axis=0).T)
    assert steps[gap[1:] < 0.15].sum() == 0
    ahead = at[:, 0] > result.recording.robot[:, 0]
    assert ahead.any() == (width > 2.2)
    # People who stay behind keep off.
    assert ahead.any() or gap.min() > 0.4


def test_who_has_no_goal_goes_back_to_the_place():
    scenario = trial("closed", 2.6, MEETINGS["standing"])
    result = check_let_go(scenario)
    at = result.recording.humans[:, 0]
    assert np.abs(at[:, 1]).max() > 0.9
    assert math.dist(at[-1, :2], (1.0, 0.1)) < 0.2


@functools.cache
def threats(planner, with_goal):
    """The scenarios of the threatening behavior, in 20 places."""
    scenarios = []
    for pose, goal in placements("threatening"):
        overrides = [
            f"planner={planner}",
            "simulation={duration: 150.0, stuck_time: 60.0}",
            f"humans[0].pose={list(pose)}",
            f"humans[0].goals={[list(goal)] if with_goal else []}",
        ]
        scenarios.append(
            LoadScenario(filename="reaction_threatening", overrides=overrides)
        )
    return scenarios


def check_threat(scenario):
    """It is over after 40 s, and the robot gets to its goal."""
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    recording = result.recording
    active = recording.behavior_status[:, 0] > 0
    # 40 s, and what stepping aside takes.
    assert active.sum() * 0.1 < 55.0
    assert recording.times[-1] < 100.0


@pytest.mark.parametrize(("number", "planner"), [(3, "dwb"), (12, "pursuit")])
def test_threat_without_a_goal_steps_aside_in_the_end(number, planner):
    """Also who has not seen the robot, and stands with the back to it."""
    check_threat(threats(planner, False)[number])


@pytest.mark.slow
@pytest.mark.parametrize("with_goal", [False, True])
@pytest.mark.parametrize("place", range(2))
def test_every_threat_ends(place, with_goal):
    planner = PLANNERS[(place + with_goal) % 2]
    for scenario in threats(planner, with_goal)[place::2]:
        check_threat(scenario)
