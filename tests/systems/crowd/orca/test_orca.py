import dataclasses
import math

import numpy as np
import pytest

from hunav_drake.systems.common.layout import Command, RobotRole
from hunav_drake.systems.crowd import CrowdConfig, OrcaModel
from hunav_drake.systems.crowd.orca.queues import share_in_queue
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from tests.systems.crowd.crowds import box_between

# So that what people want is their desired velocity, at once.
AT_ONCE = 1e-6


@pytest.fixture
def exact():
    """The model of the paper, without what is added to it."""
    return OrcaModel(
        relaxation_time=AT_ONCE,
        epsilon=0.0,
        safety_margin=0.0,
        time_horizon=5.0,
        recovery_time=0.0,
        queue_distance=0.0,
    )


def velocities(model, snapshot):
    return model.advance(snapshot, model.forces(snapshot))[:, 3:5]


def gaps(states, radius=0.3):
    """Returns the free space between bodies at each time, in meters."""
    p = states[..., :2]
    d = np.linalg.norm(p[:, :, None] - p[:, None], axis=-1)
    i, j = np.triu_indices(p.shape[1], 1)
    return d[:, i, j] - 2 * radius


def test_head_on_with_an_offset_both_turn_to_the_leg_of_the_cone(
    exact, make_snapshot
):
    """The cone of p = (4, 0.2) has a leg at angle phi - beta."""
    snapshot = make_snapshot(
        [[0, 0, 0, 1, 0, 0], [4, 0.2, math.pi, -1, 0, 0]],
        [[100, 0], [-100, 0.2]],
        speed=1.0,
        max_speed=2.0,
    )
    leg = math.atan2(0.2, 4) - math.asin(0.6 / math.hypot(4, 0.2))
    half = 0.5 * 2 * math.sin(-leg)
    change = half * np.array([math.sin(leg), -math.cos(leg)])
    v = velocities(exact, snapshot)
    np.testing.assert_allclose(v[0], np.array([1, 0]) + change)
    np.testing.assert_allclose(v[1], np.array([-1, 0]) - change)
    np.testing.assert_allclose(math.atan2(*(v[0] - v[1])[::-1]), leg)


def test_towards_someone_who_holds_still_the_horizon_decides(
    exact, make_snapshot
):
    snapshot = make_snapshot(
        [[0, 0, 0, 0.2, 0, 0], [3, 0, 0, 0, 0, 0]], [[100, 0], [3, 0]]
    )
    snapshot.command[1, Command.HOLD] = 1
    v = velocities(exact, snapshot)
    np.testing.assert_allclose(v[0], [(3 - 0.6) / 5.0, 0], atol=1e-12)


@pytest.mark.parametrize(("distance", "expected"), [(0.8, 0.5), (2.0, 1.2)])
def test_towards_a_wall_the_horizon_decides(
    distance, expected, exact, make_snapshot
):
    wall = Obstacles.from_shapes([[[distance, -9], [distance, 9]]], solid=[0])
    snapshot = make_snapshot([0] * 6, [100, 0], walls=wall)
    np.testing.assert_allclose(velocities(exact, snapshot), [[expected, 0]])


def test_along_a_wall_people_walk_freely(exact, make_snapshot):
    wall = Obstacles.from_shapes([[[-9, 0.3], [9, 0.3]]], solid=[False])
    snapshot = make_snapshot([0] * 6, [8, 0], walls=wall)
    np.testing.assert_allclose(velocities(exact, snapshot), [[1.2, 0]])


def test_who_is_far_from_others_takes_the_desired_velocity(
    exact, make_snapshot
):
    states = [[0, 0, 0, 0, 0, 0], [11, 0, 0, 0, 0, 0]]
    snapshot = make_snapshot(states, [[100, 0], [-90, 0]])
    np.testing.assert_allclose(
        velocities(exact, snapshot), [[1.2, 0], [-1.2, 0]]
    )


def test_the_desired_velocity_is_approached_in_the_relaxation_time(
    make_snapshot, walk
):
    snapshot = make_snapshot([0] * 6, [100, 0])
    states = walk(OrcaModel(relaxation_time=0.25), snapshot, 1.0)
    time = 0.05 * np.arange(21)
    np.testing.assert_allclose(
        states[:, 0, 3], 1.2 * (1 - np.exp(-time / 0.25)), atol=1e-12
    )


def test_the_robot_counts_as_commanded(exact, make_snapshot):
    def change(role):
        snapshot = make_snapshot(
            [0, 0, 0, 1, 0, 0],
            [100, 0],
            speed=1.0,
            max_speed=2.0,
            robots=[[3, 0.2, 0, -0.5, 0, 0, 0.35]],
            role=role,
        )
        return velocities(exact, snapshot)[0] - [1, 0]

    np.testing.assert_allclose(change(RobotRole.UNSEEN), 0, atol=1e-12)
    half, whole = change(RobotRole.PEDESTRIAN), change(RobotRole.OBSTACLE)
    assert half[1] < -0.05
    np.testing.assert_allclose(whole, 2 * half)


@pytest.mark.parametrize("speed", [0.0, 0.5, 1.2])
@pytest.mark.parametrize("y", [-0.2, 0.0, 0.2])
def test_a_robot_that_does_not_do_its_half_is_avoided_too(
    y, speed, make_snapshot
):
    dut = OrcaModel()
    snapshot = make_snapshot([0] * 6, [8, 0])
    for k in range(240):
        robot = np.array([5 - speed * 0.05 * k, y, 0, -speed, 0, 0, 0.35])
        snapshot = snapshot._replace(robots=robot[None])
        states = dut.advance(snapshot, dut.forces(snapshot))
        assert math.dist(states[0, :2], robot[:2]) > 0.3 + 0.35 + 0.04
        snapshot = snapshot._replace(states=states)
    assert math.dist(states[0, :2], (8, 0)) < 0.31


def test_the_robot_pushes_as_commanded(make_snapshot):
    dut = OrcaModel()
    snapshot = make_snapshot(
        [0] * 6,
        [0, 0],
        robots=[[-2, 0, 0, 0, 0, 0, 0.3]],
        role=RobotRole.UNSEEN,
        time_step=1e-6,
    )
    snapshot.command[0, Command.ROBOT_REPULSION] = 4.0
    total = dut.forces(snapshot)[0, 14:]
    np.testing.assert_allclose(total, [4.0 / (2 - 0.3), 0], rtol=1e-5)


def test_a_group_keeps_together(make_snapshot, walk):
    states = [[0, y, 0, 0, 0, 0] for y in (-2, 0, 2)]
    goals = [[20, y] for y in (-2, 0, 2)]

    def width(group_id):
        snapshot = make_snapshot(states, goals)
        snapshot.command[:, Command.GROUP_ID] = group_id
        return np.ptp(walk(OrcaModel(), snapshot, 6.0)[-1, :, 1])

    assert width(-1) == pytest.approx(4.0, abs=0.05)
    assert width(7) < 3.0


@pytest.mark.parametrize("relaxation_time", [AT_ONCE, 0.25])
def test_exactly_head_on_people_pass_on_the_right(
    relaxation_time, make_snapshot, walk
):
    snapshot = make_snapshot(
        [[-4, 0, 0, 0, 0, 0], [4, 0, math.pi, 0, 0, 0]], [[4, 0], [-4, 0]]
    )
    states = walk(OrcaModel(relaxation_time=relaxation_time), snapshot, 8.0)
    assert gaps(states).min() > 0.04
    assert np.abs(states[-1, :, :2] - [[4, 0], [-4, 0]]).max() < 0.31
    meet = np.argmin(gaps(states)[:, 0])
    assert states[meet, 0, 1] < -0.2 < 0.2 < states[meet, 1, 1]


def test_two_who_overlap_come_apart(make_snapshot, walk):
    snapshot = make_snapshot(
        [[0, 0, 0, 0, 0, 0], [0.1, 0.02, 0, 0, 0, 0]], [[0, 0], [0, 0]]
    )
    snapshot.command[:, Command.HAS_GOAL] = 0
    states = walk(OrcaModel(), snapshot, 1.0)
    assert gaps(states)[-1] > 0.05 - 1e-9
    # Half of the way each.
    np.testing.assert_allclose(
        states[:, :, :2].sum(axis=1), [[0.1, 0.02]] * 21, atol=1e-9
    )


def test_twins_with_different_goals_come_apart(make_snapshot, walk):
    snapshot = make_snapshot([[1, 1, 0, 0, 0, 0]] * 2, [[5, 1], [-3, 1]])
    states = walk(OrcaModel(), snapshot, 10.0)
    assert np.abs(states[-1, :, :2] - [[5, 1], [-3, 1]]).max() < 0.31


def test_a_wall_across_the_way_stops_people(make_snapshot, walk):
    wall = Obstacles.from_shapes([[[2, -9], [2, 9]]], solid=[False])
    snapshot = make_snapshot([0] * 6, [5, 0.5], walls=wall)
    states = walk(OrcaModel(), snapshot, 12.0)
    assert 2 - states[:, 0, 0].max() > 0.35 - 1e-9
    assert np.hypot(*states[-1, 0, 3:5]) < 1e-2


def test_a_pillar_is_walked_around(make_snapshot, walk):
    pillar = [[2, -0.3], [2.6, -0.3], [2.6, 0.3], [2, 0.3]]
    walls = Obstacles.from_shapes([pillar], solid=[True])
    snapshot = make_snapshot([0] * 6, [5, 0.5], walls=walls)
    states = walk(OrcaModel(), snapshot, 10.0)
    p = states[:, 0, :2]
    outside = p - np.clip(p, [2, -0.3], [2.6, 0.3])
    assert np.linalg.norm(outside, axis=1).min() > 0.34
    assert math.dist(states[-1, 0, :2], (5, 0.5)) < 0.31


def test_walls_out_of_range_do_not_count(exact, make_snapshot):
    wall = Obstacles.from_shapes([[[0.8, -9], [0.8, 9]]], solid=[False])
    snapshot = make_snapshot([0] * 6, [100, 0], walls=wall)
    snapshot = snapshot._replace(obstacle_range=0.7)
    np.testing.assert_allclose(velocities(exact, snapshot), [[1.2, 0]])


@pytest.mark.parametrize("n", [2, 3, 8, 20])
def test_a_circle_swaps_sides(n, make_snapshot, walk):
    angle = 2 * math.pi * np.arange(n) / n
    places = (8 if n == 20 else 5) * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    )
    states = np.zeros((n, 6))
    states[:, :2] = places
    states = walk(OrcaModel(), make_snapshot(states, -places), 25.0)
    assert gaps(states).min() > 0.04
    left = np.linalg.norm(states[-1, :, :2] + places, axis=1)
    assert left.max() < 0.31


def test_people_pass_a_door(make_snapshot, walk):
    walls = Obstacles.from_shapes(
        [[[0, -9], [0, -0.8]], [[0, 0.8], [0, 9]]], solid=[False, False]
    )
    states = np.zeros((12, 6))
    states[:, :2] = np.random.default_rng(3).permutation(
        [[-x, y] for x in (2, 3, 4) for y in (-1.5, -0.5, 0.5, 1.5)]
    )
    states[:, 1] += np.linspace(-0.1, 0.1, 12)
    snapshot = make_snapshot(states, [[9, 0]] * 12, walls=walls)
    states = walk(OrcaModel(), snapshot, 40.0)
    passed = (states[:, :, 0] > 0).all(axis=1)
    assert passed[-1]
    # In a queue only bodies count; all want to stand on one point in the end.
    between = gaps(states, radius=0.25)
    assert between[: np.argmax(passed)].min() > -0.02
    assert between.min() > -0.05


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.2, 0.35])
@pytest.mark.parametrize("width", [1.0, 1.2])
def test_thirty_people_leave_a_room(width, radius, make_snapshot):
    walls = [
        box_between(-0.2, -0.2, 0, 6.2),
        box_between(-0.2, -0.2, 6.2, 0),
        box_between(-0.2, 6, 6.2, 6.2),
        box_between(6, 0, 6.2, 3 - width / 2),
        box_between(6, 3 + width / 2, 6.2, 6),
    ]
    starts = np.stack(
        np.meshgrid(np.linspace(0.5, 5, 5), np.linspace(0.5, 5.5, 6)), axis=-1
    ).reshape(-1, 2)
    starts += np.random.default_rng(0).uniform(-0.05, 0.05, starts.shape)
    step = CrowdStep(
        [HumanConfig(pose=(x, y, 0.0), radius=radius) for x, y in starts],
        obstacles=World(walls=walls).obstacles(),
        config=CrowdConfig(model=OrcaModel()),
        time_step=0.05,
    )
    states = np.zeros((30, 6))
    states[:, :2] = starts
    goals = np.stack([np.full(30, 30.0), starts[:, 1]], axis=1)
    wanted = make_snapshot(states, goals, radius=radius)
    stances = np.zeros((30, 3))
    for _ in range(2400):
        snapshot = step.look(
            states, wanted.command, wanted.robots, wanted.parameters
        )
        states, stances, _ = step.advance(
            snapshot, step.forces(snapshot), stances
        )
        if (states[:, 0] > 6.2).all():
            break
    assert (states[:, 0] > 6.2).all()


def test_who_is_nearer_to_the_place_goes_first(exact, make_snapshot):
    """The other one does all of the avoiding, and more the later it is."""

    def changes(y):
        snapshot = make_snapshot(
            [[-2, 0, 0, 1, 0, 0], [0, -y, math.pi / 2, 0, 1, 0]],
            [[0, 0], [0, 0]],
            speed=1.0,
            max_speed=2.0,
            radius=0.2,
        )
        dut = dataclasses.replace(exact, queue_distance=1.0)
        change = velocities(dut, snapshot) - snapshot.states[:, 3:5]
        return np.hypot(*change.T)

    one, other = changes(2.0)
    assert one == pytest.approx(other)
    assert one > 0.05
    one, other = changes(2.2)
    assert 0 < one < other
    one, other = changes(3.0)
    assert one == pytest.approx(0, abs=1e-9)


def test_queues_are_of_those_who_go_the_same_way(make_snapshot):
    def share(own, goal, other, others, near=1.0):
        commands = make_snapshot(
            [[*own, 0, 0, 0, 0], [*other, 0, 0, 0, 0]], [goal, others]
        ).command
        rows = [np.array([*place, 0, 0, 0, 0]) for place in (own, other)]
        return [
            share_in_queue(
                *(rows[i], commands[i], rows[1 - i], commands[1 - i], near)
            )
            for i in range(2)
        ]

    # One behind the other, to the same place.
    assert share((0, 0), (9.0, 0), (2, 0), (9.0, 0)) == [1, 0]
    # By a place on the way of the other.
    assert sum(share((0, 0), (9.0, 0), (2, 2), (4.0, 0))) == pytest.approx(1)
    # Beside each other, and towards each other.
    assert share((0, 0), (9.0, 0), (0, 3), (9.0, 3)) == [-1, -1]
    assert share((0, 0), (9.0, 0), (9, 0), (0.0, 0)) == [-1, -1]
    # With 0 nobody queues.
    assert share((0, 0), (9.0, 0), (2, 0), (9.0, 0), near=0.0) == [-1, -1]


def test_a_dense_crowd_stays_finite(make_snapshot, walk):
    """All in one corner, with bodies in each other and in the walls."""
    rng = np.random.default_rng(5)
    states = np.zeros((60, 6))
    states[:, :2] = rng.uniform(-0.5, 1.5, (60, 2))
    states[:, 3:5] = rng.uniform(-9, 9, (60, 2))
    walls = Obstacles.from_shapes([[[0, 9], [0, 0], [9, 0]]], solid=[False])
    snapshot = make_snapshot(states, [[0.0, 0.0]] * 60, walls=walls)
    states = walk(OrcaModel(), snapshot, 3.0)
    assert np.isfinite(states).all()
    assert np.hypot(*states[-1, :, 3:5].T).max() <= 1.2 * (1 + 1e-12)
