"""Seats and beds on furniture: sitting down, sitting, standing up."""

import json
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeHumans,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
    ScenarioError,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
    Activity,
    Command,
    Hold,
    Posture,
    Signal,
)
from hunav_drake.systems.crowd.placed import place
from hunav_drake.systems.people.furniture_places import with_furniture
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world import Box
from hunav_drake.systems.world.obstacles import inside
from tests.vocabulary.stage import STAND, Stage, robot_at, someone, tree

CHAIR = {"type": "chair", "center": [0, 0]}
SIT = '<UsePlace name="it" place="chair_1" seconds="5"/>'


def scenario(people, furniture, **more):
    data = {
        "world": {"furniture": furniture},
        "humans": people,
        "robot": {"start": [-8, -8, 0], "goal": [-8, 8, 1.5]},
        "planner": {"type": "pursuit"},
        "simulation": {"duration": 30.0},
    }
    return LoadScenario(data=json.dumps(data | more))


def world(*furniture):
    robot = {"start": [-90, 0, 0]}
    data = {"world": {"furniture": furniture}, "robot": robot}
    return LoadScenario(data=json.dumps(data), ways=False).world


def seated(stage):
    return stage.signals[:, Signal.POSTURE] == Posture.SEATED


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_a_person_sits_down_on_a_chair_and_stands_up_in_a_second_each(yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    place = world(CHAIR | {"yaw": yaw})
    nodes = f"<RunOnce>{SIT}</RunOnce>"
    goal = (3 * c, 3 * s)
    person = someone(2 * c - s, 2 * s + c, 0, nodes, goals=[goal])
    stage = Stage([person], obstacles=place)
    times, down, on = [], [], []
    walls = place.obstacles()
    for t in stage.run(20.0):
        x, y, heading, vx, vy = stage.states[0, :5]
        if seated(stage)[0]:
            down.append(t)
            # It turns its back to the chair before.
            assert math.remainder(heading - yaw, math.tau) == pytest.approx(
                0, abs=0.06
            )
        if math.hypot(x, y) < 0.021:
            on.append(t)
            assert math.hypot(vx, vy) < 1e-9 or len(on) < 3
        if inside(walls, [(x, y)]).any():
            times.append(t)
    # A second down, 5 s on it, a second up.
    assert on[0] - down[0] == pytest.approx(1.0, abs=0.11)
    assert down[-1] - on[0] == pytest.approx(5.0, abs=0.11)
    # (The edge is a third of the way from the chair's middle.)
    assert times[-1] - times[0] == pytest.approx(5.0 + 2 / 3, abs=0.3)
    assert math.dist(stage.states[0, :2], goal) < 0.5


def test_who_is_interrupted_stands_up_before_anything_else():
    nodes = (
        '<Sequence><TimeDelay delay="6"><AlwaysSuccess/></TimeDelay>'
        "<RegularNav/></Sequence>"
        '<UsePlace name="it" place="chair_1" seconds="60"/>'
    )
    place = world(CHAIR)
    stage = Stage([someone(2, 0.5, 0, nodes, goals=[(0, 5)])], obstacles=place)
    walls = place.obstacles()
    before = stage.states[0, :2]
    seen = False
    for _ in stage.run(15.0):
        now = stage.states[0, :2]
        # Nobody jumps.
        assert math.dist(before, now) < 0.08
        before = now
        seen = seen or bool(inside(walls, [now]).any())
    assert seen
    assert math.dist(before, (0, 5)) < 0.5


def test_people_who_start_on_seats_sit_and_nobody_else_may_start_there():
    furniture = [CHAIR, CHAIR | {"center": [2, 0]}]
    people = [
        {"pose": [x, 0, 0], "behavior": tree('<UsePlace kind="seat"/>')}
        for x in (0.0, 2.0)
    ]
    trial = scenario(people, furniture)
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    for k in range(1, 60):
        simulator.AdvanceTo(0.05 * k)
        states = diagram.GetOutputPort("human_states").Eval(
            simulator.get_context()
        )
        at = states.reshape(-1, STATE_SIZE)[:, :2]
        assert at == pytest.approx(np.array([[0, 0], [2, 0]]), abs=1e-9)
    shown = diagram.GetOutputPort("social_signals").Eval(
        simulator.get_context()
    )
    postures = shown.reshape(-1, SIGNAL_SIZE)[:, Signal.POSTURE]
    assert postures.tolist() == [Posture.SEATED] * 2
    table = {"type": "table", "center": [0, 0]}
    with pytest.raises(ScenarioError, match="inside"):
        scenario(people, [table])


def test_who_walks_by_makes_way_for_who_sits():
    place = world(CHAIR)
    people = [
        someone(0, 0, 0, '<UsePlace place="chair_1" seconds="99"/>'),
        someone(0.3, -4, 1.57, goals=[(0.3, 4)]),
    ]
    stage = Stage(people, obstacles=place)
    nearest = math.inf
    for _ in stage.run(12.0):
        nearest = min(nearest, stage.distance(0, 1))
        assert stage.states[0, :2] == pytest.approx([0, 0], abs=1e-9)
    assert nearest > 0.5
    assert stage.states[1, 1] > 3.5


@pytest.mark.slow
def test_sitting_goes_on_in_a_fork_bit_for_bit(tmp_path):
    people = [
        {"pose": [2, 1, 0], "behavior": tree(f"<RunOnce>{SIT}</RunOnce>")},
        {"pose": [2, -1, 0], "goals": [[-3, 0.2]]},
    ]
    trial = scenario(people, [CHAIR])
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    files = []
    for k, time in enumerate(np.linspace(1.0, 11.0, 11)):
        simulator.AdvanceTo(time)
        file = tmp_path / f"{k}.npz"
        files.append(SaveContext(diagram, simulator.get_context(), file))
    simulator.AdvanceTo(14.0)
    end = SaveContext(diagram, simulator.get_context(), tmp_path / "end.npz")
    for file in files:
        forked = Simulator(diagram, LoadContext(diagram, file))
        forked.AdvanceTo(14.0)
        again = SaveContext(diagram, forked.get_context(), tmp_path / "f.npz")
        one, other = np.load(end), np.load(again)
        assert one.files == other.files
        for name in one.files:
            np.testing.assert_array_equal(one[name], other[name])


def test_a_patient_lies_in_bed():
    place = world({"type": "bed", "center": [0, 0]})
    person = someone(2, 3, 0, '<UsePlace kind="bed"/>', rest=STAND)
    stage = Stage([person], obstacles=place)
    for _ in stage.run(10.0):
        pass
    assert stage.signal(0, Signal.POSTURE) == Posture.LYING
    assert stage.states[0, :3] == pytest.approx([-0.1, 0, 0], abs=0.06)


def test_furniture_brings_places():
    furniture = [
        CHAIR | {"center": [2, 0]},
        {"type": "desk", "center": [0, 4], "yaw": 0.0},
        CHAIR | {"center": [0.85, 4], "yaw": math.pi},
        CHAIR | {"center": [5, 5], "name": "throne"},
        {"type": "counter", "center": [0, -4], "yaw": math.pi / 2},
        {"type": "sofa", "center": [6, 0]},
        {"type": "bench", "center": [-4, 0]},
        {"type": "shelf", "center": [-4, 4]},
        {"type": "plant", "center": [4, -4]},
    ]
    found = with_furniture([Place(name="x", pose=(9, 9, 0))], world(*furniture))
    types = {it.name: (it.id, it.type, len(it.slots)) for it in found}
    assert types == {
        "x": (1, "point", 0),
        "chair_1": (2, "seat", 1),
        "chair_2": (3, "workplace", 1),
        "throne": (4, "seat", 1),
        "counter_1": (5, "counter", 1),
        "sofa_1": (6, "seat", 2),
        "bench_1": (7, "seat", 2),
        "shelf_1": (8, "shelf", 2),
    }
    places = {it.name: it for it in found}
    assert places["counter_1"].slots[0] == pytest.approx(
        [0, -3.25, -math.pi / 2]
    )
    # One stands beside the chair where there is room.
    assert places["chair_1"].approaches[0] == pytest.approx([2.645, 0])
    assert places["chair_2"].approaches[0] == pytest.approx([0.85, 4.645])


def test_a_chair_between_walls_is_no_seat():
    boxes = [
        {"type": "table", "center": it, "size": [1, 1]}
        for it in ([1.1, 0], [-1.1, 0], [0, 1.1], [0, -1.1])
    ]
    assert with_furniture([], world(CHAIR, *boxes)) == []
    with pytest.raises(ScenarioError, match="there is no place 'chair_1'"):
        scenario([{"pose": [3, 3, 0], "behavior": tree(SIT)}], [CHAIR, *boxes])


def test_bad_approaches_are_told():
    with pytest.raises(ValueError, match="one for each slot"):
        Place(pose=(0, 0, 0), slots=[(0, 0, 0)], approaches=[(1, 1), (2, 2)])
    with pytest.raises(ValueError, match="must be within 3 m of its"):
        Place(pose=(0, 0, 0), approaches=[(3, 1)])


def test_nobody_sits_down_faster_than_it_walks():
    person = someone(
        0.7, 0, 0, SIT, rest=STAND, desired_speed=0.3, max_speed=0.3
    )
    stage = Stage([person], obstacles=world(CHAIR))
    before, fastest = stage.states[0, :2], 0.0
    for _ in stage.run(12.0):
        fastest = max(fastest, math.dist(before, stage.states[0, :2]))
        before = stage.states[0, :2]
    assert fastest == pytest.approx(0.3 * 0.05)


def test_who_is_put_elsewhere_no_longer_sits():
    nodes = f"<RunOnce>{SIT}</RunOnce>"
    stage = Stage([someone(0, 0, 0, nodes)], obstacles=world(CHAIR))
    for _ in stage.run(2.0):
        pass
    assert seated(stage)[0]
    crowd = stage.diagram.GetSubsystemByName("crowd")
    states = stage.states.copy()
    states[0, :2] = -6, 4
    crowd.SetStates(crowd.GetMyMutableContextFromRoot(stage.context), states)
    sits = []
    for _ in stage.run(20.0):
        sits.append(seated(stage)[0])
        away = math.hypot(*stage.states[0, :2])
        # It walks back, and sits down there.
        assert not sits[-1] or away < 0.8
    assert not sits[0]
    assert sits[200]


def test_a_recorded_person_sits_on_the_seat_and_goes_on(tmp_path):
    file = tmp_path / "walk.csv"
    rows = [f"{0.2 * k:.1f},1,0.645,{0.2 * k - 4:.2f}" for k in range(60)]
    file.write_text("\n".join(["time,id,x,y", *rows]))
    sit = {"type": "sit", "place": "seat", "seconds": 2.0}
    track = {"file": str(file), "id": 1, "mode": "reactive"}
    seat = {"name": "seat", "type": "seat", "pose": [0, 0, 0]}
    trial = scenario(
        [{"track": track, "behavior": sit}],
        [],
        places=[seat | {"approaches": [[0.645, 0]]}],
    )
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    ways = []
    for k in range(1, 241):
        simulator.AdvanceTo(0.05 * k)
        context = simulator.get_context()
        x, y = diagram.GetOutputPort("human_states").Eval(context)[:2]
        shown = diagram.GetOutputPort("social_signals").Eval(context)
        if shown[Signal.POSTURE] == Posture.SEATED:
            ways.append((x, y))
    assert np.abs(np.array(ways)[:, 1]).max() < 0.2
    assert ways[30] == pytest.approx((0, 0), abs=1e-9)
    assert 2.0 < 0.05 * len(ways) < 3.5
    assert y > 2.0


@pytest.mark.parametrize(
    "nodes",
    [
        '<GoTo goal_id="chair_1"/>',
        '<SetGoal goal_id="chair_1" mode="replace"/>',
        '<SetRandomGoal kind="seat"/>',
    ],
)
def test_who_only_goes_to_a_seat_stands_beside_it(nodes):
    person = someone(-2, 1, 0, f"<RunOnce>{nodes}</RunOnce>")
    stage = Stage([person], obstacles=world(CHAIR))
    for _ in stage.run(10.0):
        pass
    assert stage.states[0, :2] == pytest.approx([0.645, 0], abs=0.35)
    assert stage.states[0, 3:5] == pytest.approx([0, 0], abs=0.01)


def test_nobody_waits_for_ever_for_a_robot_before_a_seat():
    nodes = SIT.replace("seconds", 'patience="10" seconds')
    person = someone(2, 1, 0, f"<RunOnce>{nodes}</RunOnce>", goals=[(3, 3)])
    stage = Stage([person], obstacles=world(CHAIR), robot=robot_at(0.7, 0))
    for t in stage.run(20.0):
        if t == 8.0:
            assert stage.statuses(0)["it"] == 1
            assert stage.signal(0, Signal.PLACE) == 0
    assert math.dist(stage.states[0, :2], (3, 3)) < 0.5
    assert stage.signal(0, Signal.PLACE) == -1


def test_furniture_of_one_name_is_told_apart():
    names = ["x", "x", "", "chair_2", "7"]
    chairs = [
        CHAIR | {"center": [2 * k, 0], "name": name}
        for k, name in enumerate(names)
    ]
    found = with_furniture([], world(*chairs))
    assert [it.name for it in found] == [
        *("x", "chair_2_2", "chair_3", "chair_2", "chair_5")
    ]
    sit = {"type": "sit", "place": "chair_3", "seconds": 2.0}
    person = {"pose": [4, 2, 0], "behavior": sit}
    MakeTrialDiagram(scenario([person], chairs))


def test_who_can_sit_nowhere_walks_on():
    person = someone(0, 0, 0, '<UsePlace kind="seat"/>', goals=[(4, 0)])
    stage = Stage([person])
    for _ in stage.run(5.0):
        pass
    assert stage.states[0, 0] > 3.5


def test_who_waits_for_any_seat_keeps_off_those_taken():
    nodes = '<RunOnce><UsePlace kind="seat" seconds="5"/></RunOnce>'
    people = [someone(x, 0, 0, nodes, goals=[(3, 3)]) for x in (0.0, 0.75)]
    stage = Stage(people, obstacles=world(CHAIR))
    sat = np.zeros(2)
    for _ in stage.run(25.0):
        sat += seated(stage)
    assert sat * 0.05 == pytest.approx([5.0, 6.0], abs=0.3)
    goals = np.hypot(*(stage.states[:, :2] - [3, 3]).T)
    assert (goals < 1.0).all()


def test_who_starts_on_a_seat_and_waits_stands_up_first():
    """Nobody walks out of a chair as if it were not there."""
    nodes = (
        '<TimeDelay delay="4"><RunOnce>'
        '<UsePlace name="it" place="chair_1" seconds="2"/>'
        "</RunOnce></TimeDelay>"
    )
    place = world(CHAIR)
    person = someone(0, 0, 0, nodes, goals=[(-4, 0)])
    stage = Stage([person], obstacles=place)
    walls = place.obstacles()
    way = [tuple(stage.states[0, :2]) for _ in stage.run(3.0)]
    # A second to the place beside it, on the side of the goal or not.
    within = [bool(inside(walls, [it]).any()) for it in way]
    assert within[0]
    assert not any(within[25:])
    assert max(map(math.dist, way, way[1:])) < 0.08
    assert way[22][0] > 0.5
    assert any(seated(stage)[0] for _ in stage.run(12.0))


@pytest.mark.parametrize("kind", ["chair", "bed"])
def test_who_is_in_a_wheelchair_stays_in_it_beside_seats_and_beds(kind):
    place = world({"type": kind, "center": [0, 0]})
    (spot,) = with_furniture([], place)
    sit = SIT.replace("chair_1", f"{kind}_1")
    person = someone(
        2.5, 2, 0, f"<RunOnce>{sit}</RunOnce>", figure={"wheelchair": True}
    )
    stage = Stage([person], obstacles=place)
    walls = place.obstacles()
    used = []
    for t in stage.run(25.0):
        here = stage.states[0, :2]
        assert not inside(walls, [here]).any()
        if stage.signals[0, Signal.POSTURE] != Posture.STANDING:
            used.append(t)
            away = min(math.dist(here, it) for it in spot.all_approaches())
            assert away < 0.31
    assert 5.0 < used[-1] - used[0] < 6.5


def test_who_is_in_a_wheelchair_cannot_begin_on_a_seat():
    person = {
        "name": "ana",
        "pose": [0, 0, 0],
        "figure": {"wheelchair": True},
        "behavior": {"type": "sit"},
    }
    with pytest.raises(ScenarioError, match=r"pose: is inside world"):
        scenario([person], [CHAIR])


PICTURE = {"type": "picture", "center": [0.03, 0]}


@pytest.mark.parametrize(
    ("more", "count"),
    [
        ([], 5),
        # In a corridor, those beside it are behind its walls.
        ([(1.0, 1.2, 6, 0.1), (1.0, -1.2, 6, 0.1)], 3),
        # Before it is a wall.
        ([(0.5, 0.0, 0.1, 6)], 0),
        # Before it is a thin one.
        ([(0.07, 0.0, 0.02, 6)], 0),
        # On the other side of the wall on which it hangs.
        ([(-0.1, 0.0, 0.2, 9)], 5),
    ],
)
def test_people_look_at_a_picture_from_where_they_see_it(more, count):
    boxes = [
        {"type": "box", "center": [x, y], "size": [wide, deep]}
        for x, y, wide, deep in more
    ]
    # One sees over a sofa.
    sofa = {"type": "sofa", "center": [0.6, 0]}
    data = {"world": {"furniture": [PICTURE, sofa], "walls": boxes}}
    data["robot"] = {"start": [-90, 0, 0]}
    loaded = LoadScenario(data=json.dumps(data), ways=False).world
    found = with_furniture([], loaded)
    found = [it for it in found if it.name == "picture_1"]
    assert len(found) == bool(count)
    for it in found:
        assert (it.type, it.pose) == ("screen", (0.03, 0.0, 0.0))
        assert len(it.slots) == count
        for x, y, yaw in it.slots:
            assert math.hypot(x - 0.03, y) == pytest.approx(2.0)
            # All face it.
            away = math.atan2(-y, 0.03 - x)
            assert math.cos(yaw - away) == pytest.approx(1.0)


@pytest.mark.parametrize("side", [-0.45, -0.5, 0.5])
def test_nobody_is_seated_off_the_seat_while_a_robot_bars_it(side):
    """It waits standing beside the seat, gives up, and goes on."""
    chair = CHAIR | {"yaw": math.pi}
    nodes = SIT.replace("seconds", 'patience="5" seconds')
    person = someone(-3, 0, 0, f"<RunOnce>{nodes}</RunOnce>", goals=[(-3, 3)])
    stage = Stage(
        [person], obstacles=world(chair), robot=robot_at(-0.645, side)
    )
    for _ in stage.run(16.0):
        away = math.hypot(*stage.states[0, :2])
        assert away < 0.35 or not seated(stage)[0]
    assert math.dist(stage.states[0, :2], (-3, 3)) < 0.5
    assert stage.signal(0, Signal.PLACE) == -1


def test_nobody_waits_for_ever_for_a_seat_without_a_way():
    shelves = [
        {"type": "shelf", "center": center, "size": size}
        for center, size in (
            ([-1.35, 0], [0.3, 1.6]),
            ([-0.5, 0.95], [2.0, 0.3]),
            ([-0.5, -0.95], [2.0, 0.3]),
            ([0.5, 0], [0.3, 1.6]),
        )
    ]
    nodes = SIT.replace("seconds", 'patience="5" seconds')
    person = someone(-3, 0, 0, f"<RunOnce>{nodes}</RunOnce>", goals=[(-3, 3)])
    places = world(CHAIR | {"yaw": math.pi}, *shelves)
    assert with_furniture([], places)[0].name == "chair_1"
    stage = Stage([person], obstacles=places)
    for _ in stage.run(14.0):
        assert not seated(stage)[0]
    assert math.dist(stage.states[0, :2], (-3, 3)) < 0.5


def test_nobody_sits_down_through_a_wall():
    """A thin one beside the chair: the free side is the other one."""
    scene = world(
        CHAIR, {"type": "table", "center": [0.75, 0.1], "size": [0.9, 0.8]}
    )
    (free,) = with_furniture([], scene)[:1]
    assert free.approaches[0][1] < 0
    scene.walls.append(Box(center=[0, -0.28], size=[6, 0.08]))
    (place,) = with_furniture([], scene)[:1]
    assert place.approaches[0][1] > 0
    scene.walls.append(Box(center=[0, 0.28], size=[6, 0.08]))
    assert all(
        abs(y) < 0.24
        for it in with_furniture([], scene)
        if it.type in ("seat", "workplace")
        for _, y in it.approaches
    )


def test_who_queues_at_a_seat_is_served_beside_it():
    node = '<RunOnce><Queue name="it" place="chair_1"/></RunOnce>'
    person = someone(-3, 0, 0, node, goals=[(-3, 3)])
    stage = Stage([person], obstacles=world(CHAIR))
    for t in stage.run(75.0):
        if t == 15.0:
            assert stage.signal(0, Signal.ACTIVITY) == Activity.QUEUE
            assert math.dist(stage.states[0, :2], (0.645, 0)) < 0.2
    assert math.dist(stage.states[0, :2], (-3, 3)) < 0.5


@pytest.mark.slow
def test_who_sits_presses_slowly_against_who_stands_in_the_way_out():
    """Bystanders without goals do not move by themselves."""
    states = np.zeros((2, 6))
    states[1, 0] = 0.52
    command = np.zeros((2, COMMAND_SIZE))
    command[0, Command.HOLD] = Hold.PLACED
    command[0, [Command.GOAL_X, Command.DESIRED_SPEED]] = 1.0
    bodies = np.array([[0.0, 0, 0.25], [0.52, 0, 0.25]])
    after = place(states, command, bodies, 0.05)
    assert after[0, 0] == pytest.approx(0.1 * 0.05)
    # It waits for who walks by, and for a robot.
    states[1, 4] = 1.0
    assert place(states, command, bodies, 0.05)[0, 0] == 0.0
    alone = place(states[:1], command[:1], bodies, 0.05)
    assert alone[0, 0] == 0.0


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
@pytest.mark.parametrize(
    ("start", "speed"), [((1.4, 0.0), 0.06), ((2.5, 4.0), 1.3)]
)
def test_patience_does_not_count_progress(start, speed, dt):
    """However slow somebody is, and however short a step."""
    scene = world(CHAIR, {"type": "bed", "center": [0, 4]})
    kind = "bed" if start[1] else "seat"
    nodes = f'<UsePlace name="it" kind="{kind}" patience="2" seconds="3"/>'
    person = someone(
        *(*start, math.pi, f"<RunOnce>{nodes}</RunOnce>"),
        rest=STAND,
        desired_speed=speed,
        max_speed=speed,
    )
    people = MakeHumans([person], obstacles=scene, num_robots=0, time_step=dt)
    simulator = Simulator(people)
    for k in range(150):
        simulator.AdvanceTo(0.2 * k)
        signals = people.GetOutputPort("social_signals").Eval(
            simulator.get_context()
        )
        if signals[Signal.POSTURE] != 0 and k * 0.2 > 1:
            break
    assert signals[Signal.POSTURE] != 0


def test_who_queues_at_a_seat_without_approaches_faces_as_it_does():
    place = Place(name="spot", type="seat", pose=(0.0, 0.0, 1.57))
    node = '<Queue name="it" place="spot"/>'
    stage = Stage([someone(-2, 0, 0, node)], places=[place])
    for _ in stage.run(10.0):
        pass
    assert stage.states[0, 2] == pytest.approx(1.57, abs=0.1)
