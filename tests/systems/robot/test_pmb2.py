"""The physical PMB2 alone, at walls and among people."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.robot.driven_robots import drive, make_diagram

PLANT_STEP = 0.0125
RADIUS = 0.27
BODY = 0.25
# What both wheels push with, at 6 N m each and a radius of 0.0985 m.
STALL_FORCE = 2 * 6 / 0.0985


def standing_person(x=2.0, y=0.0):
    """Returns one with HuNavSim's weights: no force moves it off a robot.

    (With the default's, a robot that is as near as this pushes it aside.)
    """
    return HumanConfig(
        pose=(x, y, math.pi), desired_speed=0.0, forces=SocialForceParameters()
    )


def gaps(run):
    """Returns the gaps between bodies at all samples, in meters."""
    way = run.people[:, 0, :2] - run.robot[:, :2]
    return np.hypot(*way.T) - (RADIUS + BODY)


@pytest.fixture(scope="module")
def alone():
    return make_diagram("pmb2")


@pytest.mark.parametrize(
    ("command", "column"), [((0.45, 0.0), 3), ((0.0, 0.8), 5), ((-0.2, 0.0), 3)]
)
def test_it_follows_a_step_of_the_command(alone, command, column):
    run = drive(alone, command, duration=3.0)
    settled = run.robot[run.times >= 0.5 - 1e-9, column]
    wanted = sum(command)
    print(f"{command}: off by at most {abs(settled / wanted - 1).max():.2%}")
    np.testing.assert_allclose(settled, wanted, rtol=0.05)


def test_it_speeds_up_no_faster_than_its_limits(alone):
    run = drive(alone, (5.0, 0.0), duration=2.0, every=PLANT_STEP)
    v = run.robot[:, 3]
    assert v.max() == pytest.approx(1.0, rel=0.01)
    acceleration = np.diff(v) / PLANT_STEP
    assert acceleration.max() < 1.1


def test_it_closes_a_square(alone):
    v, omega = 0.4, 0.8
    side, corner = 1.0 / v, (math.pi / 2) / omega
    # Ramps up and down cancel where each command is held so long.
    pause = 1.0
    plan = []
    for _ in range(4):
        plan += [(side, v, 0), (pause, 0, 0), (corner, 0, omega), (pause, 0, 0)]
    ends = np.cumsum([part[0] for part in plan])

    def command(time, row):
        k = min(np.searchsorted(ends, time, side="right"), len(plan) - 1)
        return plan[k][1:]

    run = drive(alone, command, duration=ends[-1], every=PLANT_STEP)
    x, y, yaw = run.robot[-1, :3]
    print(
        f"off by {1e3 * math.hypot(x, y):.1f} mm, {math.degrees(yaw):.2f} deg"
    )
    assert math.hypot(x, y) < 0.05
    assert run.robot[:, :2].max() > 0.95


def test_it_stops_at_a_standing_person():
    diagram = make_diagram("pmb2", [standing_person()])
    run = drive(diagram, (0.5, 0.0), duration=6.0, every=PLANT_STEP)
    rows = run.contacts[:, 0]
    assert run.robot[-1, 3] == pytest.approx(0, abs=1e-3)
    assert -0.01 < gaps(run).min() < 0
    # The contact is reported in the step in which the bodies meet.
    told = int(np.flatnonzero(rows[:, Contact.LASTS])[0])
    meet = int(np.flatnonzero(gaps(run) <= 0)[0])
    assert abs(told - meet) <= 1
    assert np.isfinite(rows).all()
    assert 300 < rows[-1, Contact.PEAK_FORCE] < 3000
    # The stalled wheels go on to push.
    assert -rows[-1, Contact.FORCE_X] == pytest.approx(STALL_FORCE, rel=0.02)
    assert abs(rows[-1, Contact.FORCE_Y]) < 10
    assert rows[-1, Contact.BY_ROBOT] == 1
    assert rows[-1, Contact.BY_PERSON] == 0
    assert rows[-1, Contact.RELATIVE_SPEED] == pytest.approx(0.5, rel=0.1)
    # The person has given way by no more than the push calls for.
    assert np.hypot(*(run.people[-1, 0, :2] - [2, 0])) < 0.02


def test_the_impulse_is_that_of_the_forces():
    diagram = make_diagram("pmb2", [standing_person()])
    run = drive(diagram, (0.5, 0.0), duration=5.0, every=PLANT_STEP)
    force = np.hypot(*run.contacts[:, 0, 1:3].T)
    impulse = np.cumsum(force) * PLANT_STEP
    np.testing.assert_allclose(
        run.contacts[:, 0, Contact.IMPULSE], impulse, rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(
        run.contacts[:, 0, Contact.PEAK_FORCE], np.maximum.accumulate(force)
    )


def test_it_is_pushed_by_who_runs_into_it():
    person = HumanConfig(
        pose=(2, 0.02, math.pi), goals=[(-3, 0)], desired_speed=1.3
    )
    run = drive(make_diagram("pmb2", [person]), (0, 0), duration=5.0)
    row = run.contacts[-1, 0]
    assert row[Contact.BY_PERSON] == 1
    assert row[Contact.BY_ROBOT] == 0
    assert row[Contact.PEAK_FORCE] > 100
    assert row[Contact.IMPULSE] > 5
    assert run.robot[-1, 0] < -0.01
    assert gaps(run).min() > -0.01
    # The contact is over once the person has passed.
    assert run.people[-1, 0, 0] < -1
    assert row[Contact.LASTS] == 0
    assert row[Contact.FORCE_X] == row[Contact.FORCE_Y] == 0


def test_bodies_are_where_people_are():
    people = [
        HumanConfig(pose=(4, y, math.pi), goals=[(-4, y)], desired_speed=1.3)
        for y in (1.5, 3.0)
    ]
    diagram = make_diagram("pmb2", people)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.0, 0.0])
    plant = diagram.GetSubsystemByName("plant")
    instance = plant.GetModelInstanceByName("people")
    errors = []
    for k in range(1, 80):
        simulator.AdvanceTo(0.05 * k)
        own = plant.GetMyContextFromRoot(context)
        bodies = plant.GetPositions(own, instance).reshape(-1, 2)
        # At the end of a step, before the next is computed.
        states = diagram.GetOutputPort("human_states").Eval(context)
        error = bodies - states.reshape(-1, 7)[:, :2]
        errors.append(np.hypot(*error.T).max())
    print(f"off by {1e3 * max(errors):.2f} mm, {1e3 * np.median(errors):.2f}")
    # While they speed up; then
    assert max(errors) < 0.008
    assert np.median(errors) < 0.001


WALL = Obstacles.from_shapes(
    [[[-5, 1], [9, 1], [9, 1.4], [-5, 1.4]], [[9, -4], [9, 1]]],
    solid=[True, False],
)


@pytest.mark.parametrize("yaw", [0.1, 0.5, math.pi / 2])
@pytest.mark.parametrize("reverse", [False, True])
def test_it_never_passes_through_a_wall(yaw, reverse):
    # The same shape, for both orders of its corners.
    wall = WALL
    if reverse:
        corners = [[-5, 1], [-5, 1.4], [9, 1.4], [9, 1]]
        wall = Obstacles.from_shapes([corners], solid=[True])
    robot = {"type": "pmb2", "start": (0.0, 0.5, yaw)}
    diagram = make_diagram(robot, obstacles=wall)
    run = drive(diagram, (1.0, 0.0), duration=6.0)
    assert run.robot[:, 1].max() < 1 - RADIUS + 0.01
    # It did arrive, and was not held off.
    assert run.robot[:, 1].max() > 1 - RADIUS - 0.005
    if yaw < 0.2:
        assert run.robot[-1, 0] > 1.0


@pytest.mark.slow
def test_energy_does_not_grow_at_rest():
    diagram = make_diagram("pmb2", [standing_person(0.54)])
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.0, 0.0])
    plant = diagram.GetSubsystemByName("plant")
    energies, places = [], []
    for second in range(1, 601):
        simulator.AdvanceTo(float(second))
        own = plant.GetMyContextFromRoot(context)
        energies.append(plant.CalcKineticEnergy(own))
        base = plant.GetBodyByName("base")
        places.append(plant.EvalBodyPoseInWorld(own, base).translation())
    first, last = np.max(energies[:300]), np.max(energies[300:])
    drift = np.hypot(*(places[-1] - places[10])[:2])
    print(f"kinetic energy {first:.1e} J, {last:.1e} J; drift {drift:.1e} m")
    assert last <= max(first, 1e-9)
    assert last < 1e-6
    assert drift < 1e-3


@pytest.mark.parametrize("seed", [0, 4])
def test_nobody_is_run_over_by_a_reckless_robot(seed):
    rng = np.random.default_rng(seed)
    room = Obstacles.from_shapes(
        [[[-4, -3], [4, -3], [4, 3], [-4, 3], [-4, -3]]], solid=[False]
    )
    people = []
    while len(people) < 12:
        place = rng.uniform([-3.5, -2.5], [3.5, 2.5]).tolist()
        others = [(0, 0), *(person.pose[:2] for person in people)]
        if min(math.dist(place, other) for other in others) < 0.8:
            continue
        goals = rng.uniform([-3.4, -2.4], [3.4, 2.4], (3, 2))
        people.append(
            HumanConfig(
                pose=(*place, 0.0),
                goals=list(map(tuple, goals.tolist())),
                cyclic=True,
                desired_speed=float(rng.uniform(0, 1.5)),
            )
        )
    commands = rng.uniform([-0.2, -1.5], [1.0, 1.5], (30, 2))
    commands[::2] = 1.0, 0.0
    run = drive(
        make_diagram("pmb2", people, obstacles=room),
        lambda time, row: commands[min(int(2 * time), 29)],
        duration=12.0,
    )
    way = run.people[..., :2] - run.robot[:, None, :2]
    depth = RADIUS + BODY - np.linalg.norm(way, axis=-1)
    print(f"robot and people overlap by at most {1e3 * depth.max():.1f} mm")
    assert np.isfinite(run.contacts).all()
    # There are contacts, and they are reported.
    assert run.contacts[-1, :, Contact.BY_ROBOT :].sum() >= 1
    assert run.contacts[..., Contact.PEAK_FORCE].max() < 5000
    assert depth.max() < 0.02
    outside = np.abs(run.robot[:, :2]) + RADIUS - [4, 3]
    assert outside.max() < 0.01
