"""The collision-free speed model and the anticipation velocity model."""

import math

import numpy as np
import pytest

from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    TOTAL_FORCE,
    Command,
    RobotRole,
)
from hunav_drake.systems.crowd import (
    AnticipationVelocityModel,
    CollisionFreeSpeedModel,
)
from hunav_drake.systems.world.obstacles import Obstacles

# At once, as in the papers.
AT_ONCE = {
    "reaction_time": 0.0,
    "hesitation": 0.0,
    "acceleration": 1e6,
    "turn_rate": 1e3,
}
PAPER = CollisionFreeSpeedModel(**AT_ONCE, epsilon=0.0)
ANTICIPATING = AnticipationVelocityModel(
    **AT_ONCE,
    following=1.0,
    repulsion_strength=0.0,
    keep_right=0.0,
    side_width=0.0,
    side_reach=0.0,
    same_way=0.0,
    overtaking=0.0,
)
MODELS = [CollisionFreeSpeedModel(), AnticipationVelocityModel()]


@pytest.fixture(params=MODELS, ids=["collision_free", "anticipation"])
def dut(request):
    return request.param


def velocities(model, snapshot):
    """The velocities (n, 2) that a model has people take."""
    total = model.forces(snapshot)[:, TOTAL_FORCE : TOTAL_FORCE + 2]
    return snapshot.states[:, 3:5] + snapshot.time_step * total


@pytest.fixture
def mixed(make_snapshot):
    """People who walk to and fro, and look where they are told to."""
    rng = np.random.default_rng(3)
    n = 40
    states = np.zeros((n, 6))
    states[:, :2] = rng.uniform(-2.5, 2.5, (n, 2))
    angle = rng.uniform(-math.pi, math.pi, n)
    speed = rng.uniform(0.2, 1.3, n)
    states[:, 3] = speed * np.cos(angle)
    states[:, 4] = speed * np.sin(angle)
    goals = states[:, :2] + 50 * states[:, 3:5]
    snapshot = make_snapshot(states, goals, speed=1.2, max_speed=2.0)
    # People turned by command walk sideways as fast as ahead.
    snapshot.command[:, Command.TURN_RATE] = 1.0
    return snapshot


def speed_of(x, e, i, *, length, time, wish):
    """The speed of the papers: min(v0, max(0, (s - l) / T))."""
    most = wish
    for j in range(len(x)):
        d = x[j] - x[i]
        if j != i and d @ e >= 0 and abs(e[0] * d[1] - e[1] * d[0]) <= length:
            gap = np.linalg.norm(d) - length
            most = min(most, max(gap, 0.0) / time)
    return most


def test_it_is_the_collision_free_speed_model_of_the_paper(mixed):
    x = mixed.states[:, :2]
    goals = mixed.command[:, :2] - x
    found = velocities(PAPER, mixed)
    for i in range(len(x)):
        u = goals[i] / np.linalg.norm(goals[i])
        for j in range(len(x)):
            if j != i:
                d = x[i] - x[j]
                s = np.linalg.norm(d)
                # It grows no further in bodies that overlap deeply.
                u = u + 5 * math.exp(min((0.3 - s) / 0.1, 3)) * d / s
        e = u / np.linalg.norm(u)
        speed = speed_of(x, e, i, length=0.3, time=1.0, wish=1.2)
        np.testing.assert_allclose(found[i], speed * e, atol=1e-4)
    assert (np.linalg.norm(found, axis=1) > 0.01).sum() > 10


def test_it_is_the_anticipation_velocity_model_of_the_paper(mixed):
    """Except people nearer to the side than rounding: nobody here."""
    x = mixed.states[:, :2]
    v = mixed.states[:, 3:5]
    aim = v / np.linalg.norm(v, axis=1, keepdims=True)
    found = velocities(ANTICIPATING, mixed)
    for i in range(len(x)):
        e0 = aim[i]
        right = np.array([e0[1], -e0[0]])
        u = e0.copy()
        for j in range(len(x)):
            d = x[j] - x[i]
            if j == i or e0 @ d < 0:
                continue
            s = np.linalg.norm(d)
            left = max(s - 0.3 - (v[i] - v[j]) @ d / s, 0.0)
            alpha = 8 * (1 + (1 - e0 @ aim[j]) / 2)
            there = d + v[j]
            on_the_right = there @ right > 0
            side = -1 if on_the_right else 1
            u = u + side * alpha * math.exp(-left / 0.1) * right
        e = u / np.linalg.norm(u)
        speed = speed_of(x, e, i, length=0.3, time=1.0, wish=1.2)
        np.testing.assert_allclose(found[i], speed * e, atol=1e-4)
    assert (np.linalg.norm(found, axis=1) > 0.01).sum() > 10


@pytest.mark.parametrize("distance", [0.5, 0.8, 1.2, 1.6])
def test_the_gap_says_how_fast_people_walk(distance, make_snapshot):
    """Those behind others in a row who are all as far from each other."""
    n = 30
    states = np.zeros((n, 6))
    states[:, 0] = distance * np.arange(n)
    states[:, 3] = 1.2
    model = CollisionFreeSpeedModel(repulsion_strength=0.0, acceleration=1e3)
    found = velocities(model, make_snapshot(states, [[999, 0]] * n))[:, 0]
    np.testing.assert_allclose(
        found[:-1], min(1.2, (distance - 0.3) / 1.0), rtol=1e-12
    )
    assert found[-1] == pytest.approx(1.2)


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.5])
def test_a_body_is_no_larger_than_the_model_has_it(
    radius, dut, make_snapshot, walk
):
    snapshot = make_snapshot(
        [[0, 0, 0, 0, 0, 0], [5, 0, 0, 0, 0, 0]],
        [[4.99, 0], [5, 0]],
        radius=radius,
    )
    snapshot.command[:, Command.GOAL_RADIUS] = 0.0
    snapshot.command[1, Command.HOLD] = 1
    states = walk(dut, snapshot, 20.0)
    apart = np.linalg.norm(states[:, 0, :2] - states[:, 1, :2], axis=1)
    assert 2 * min(radius, 0.15) <= apart.min() < 2 * min(radius, 0.15) + 0.3


@pytest.mark.parametrize("role", list(RobotRole))
def test_a_robot_counts_with_its_radius(role, dut, make_snapshot, walk):
    snapshot = make_snapshot(
        [-4, 0, 0, 1, 0, 0],
        [4, 0],
        radius=0.35,
        robots=[[0, 0, 0, 0, 0, 0, 0.3]],
        role=role,
    )
    states = walk(dut, snapshot, 25.0)[:, 0]
    apart = np.linalg.norm(states[:, :2], axis=1).min()
    unseen = role in (RobotRole.UNSEEN, RobotRole.UNSEEN_IN_TURN)
    assert (apart < 0.1) == unseen
    assert apart < 0.1 or apart > 0.64
    assert np.linalg.norm(states[-1, :2] - [4, 0]) < 0.4
    # They pass it on the right: it is on their left.
    assert apart < 0.1 or states[:, 1].min() < -0.6


def test_the_robots_push_drives_people_away(dut, make_snapshot):
    snapshot = make_snapshot(
        [0, 0, 0, 0, 0, 0], [5, 0], robots=[[0, 1.5, 0, 0, 0, 0, 0.3]]
    )
    still = velocities(dut, snapshot)[0, 1]
    snapshot.command[0, Command.ROBOT_REPULSION] = 4.0
    assert still == pytest.approx(0, abs=1e-3)
    assert velocities(dut, snapshot)[0, 1] < -0.05


def test_nobody_is_touched_by_who_walks_into_them(dut, make_snapshot, walk):
    """A crowd that walks to one place never overlaps by more than a bit."""
    rng = np.random.default_rng(0)
    states = np.zeros((36, 6))
    grid = np.stack(np.meshgrid(range(6), range(6)), axis=-1).reshape(-1, 2)
    states[:, :2] = grid - 2.5 + rng.uniform(-0.3, 0.3, (36, 2))
    p = walk(dut, make_snapshot(states, [[0, 0]] * 36), 15.0)[..., :2]
    distance = np.linalg.norm(p[:, :, None] - p[:, None], axis=-1)
    distance[:, np.arange(36), np.arange(36)] = np.inf
    assert distance.min() > 0.26


def test_a_goal_behind_is_turned_to_at_a_limited_rate(dut, make_snapshot, walk):
    states = walk(dut, make_snapshot([0] * 6, [-6, 0]), 12.0)[:, 0]
    rate = np.diff(np.unwrap(states[:, 2])) / 0.05
    assert rate.min() > -5.01
    # To the right.
    assert rate.max() < 0.01
    assert np.hypot(*(states[-1, :2] - [-6, 0])) < 0.31
    speeds = np.hypot(states[:, 3], states[:, 4])
    assert np.diff(speeds).max() < 4.0 * 0.05 + 1e-9
    assert np.diff(speeds).min() > -4.0 * 0.05 - 1e-9


@pytest.mark.parametrize(
    ("model", "mirrored"),
    [
        (CollisionFreeSpeedModel(), CollisionFreeSpeedModel(epsilon=-0.05)),
        (
            AnticipationVelocityModel(),
            AnticipationVelocityModel(keep_right=-0.3),
        ),
    ],
)
def test_a_mirrored_world_moves_the_same_way(model, mirrored, mixed):
    flip = np.array([1, -1, -1, 1, -1, -1])
    command = mixed.command.copy()
    command[:, Command.GOAL_Y] *= -1
    other = mixed._replace(states=mixed.states * flip, command=command)
    np.testing.assert_allclose(
        velocities(mirrored, other) * [1, -1],
        velocities(model, mixed),
        atol=1e-9,
    )


def test_the_order_of_many_does_not_matter(dut, make_snapshot):
    rng = np.random.default_rng(1)
    n = 400
    states = np.zeros((n, 6))
    states[:, :2] = rng.uniform(0, 20, (n, 2))
    states[:, 3:5] = rng.uniform(-1, 1, (n, 2))
    goals = rng.uniform(0, 20, (n, 2))
    order = rng.permutation(n)
    found = velocities(dut, make_snapshot(states, goals))
    again = velocities(dut, make_snapshot(states[order], goals[order]))
    np.testing.assert_allclose(again, found[order], atol=1e-9)


def test_only_those_near_matter(dut, make_snapshot):
    """The cells in which people are looked for leave nobody out."""
    rng = np.random.default_rng(2)
    states = np.zeros((300, 6))
    states[:, :2] = rng.uniform(0, 14, (300, 2))
    states[:, 3:5] = rng.uniform(-0.5, 0.5, (300, 2))
    goals = rng.uniform(0, 14, (300, 2))
    found = velocities(dut, make_snapshot(states, goals))
    for i in range(0, 300, 17):
        near = np.linalg.norm(states[:, :2] - states[i, :2], axis=1) < 4.0
        alone = velocities(dut, make_snapshot(states[near], goals[near]))
        np.testing.assert_allclose(alone[near[:i].sum()], found[i], atol=1e-4)


def test_people_in_one_place_come_apart(dut, make_snapshot, walk):
    snapshot = make_snapshot(np.zeros((2, 6)), [[5, 3], [5, -3]])
    states = walk(dut, snapshot, 12.0)
    assert np.isfinite(states).all()
    assert np.hypot(*(states[-1, :, :2] - [[5, 3], [5, -3]]).T).max() < 0.35


def test_people_do_not_walk_into_walls(dut, make_snapshot, walk):
    corner = Obstacles.from_shapes(
        [[[3.0, -4.0], [3.0, 2.0], [-4.0, 2.0]]], solid=[False]
    )
    states = walk(
        dut, make_snapshot([0, 0, 0, 0, 0, 0], [9, 8], walls=corner), 20.0
    )[:, 0]
    # The body is at the walls of the corner, and at rest.
    np.testing.assert_allclose(states[-1, :2], [2.85, 1.85], atol=0.01)
    assert np.hypot(*states[-1, 3:5]) < 1e-2
    assert states[:, 0].max() < 2.851
    assert np.abs(np.diff(states[-40:, 2])).max() < 1e-3


def test_a_person_who_stands_in_the_way_is_passed(dut, make_snapshot, walk):
    snapshot = make_snapshot(
        [[0, 0, 0, 0, 0, 0], [4, 0, math.pi, 0, 0, 0]], [[8, 0], [4, 0]]
    )
    states = walk(dut, snapshot, 20.0)
    assert np.linalg.norm(states[-1, 0, :2] - [8, 0]) < 0.35


@pytest.mark.parametrize(
    ("overtaking", "ahead", "passes"),
    [(5.0, 0.8, True), (0.0, 0.8, False), (5.0, 1.2, False)],
)
def test_who_wants_to_be_slower_is_overtaken(
    overtaking, ahead, passes, make_snapshot, walk
):
    """And nobody else: in a queue people follow."""
    snapshot = make_snapshot(
        [[0, 0, 0, 0.8, 0, 0], [2, 0.02, 0, 0.8, 0, 0]], [[99, 0], [99, 0]]
    )
    snapshot.command[1, Command.DESIRED_SPEED] = ahead
    dut = AnticipationVelocityModel(overtaking=overtaking)
    states = walk(dut, snapshot, 20.0)
    assert (states[-1, 0, 0] > states[-1, 1, 0] + 1) == passes
    if passes:
        assert np.hypot(*(states[:, 0, :2] - states[:, 1, :2]).T).min() > 0.3
    else:
        assert np.abs(states[:, 0, 1]).max() < 0.1


def test_a_group_stays_together(dut, make_snapshot, walk):
    snapshot = make_snapshot(
        [[0, 0.6, 0, 0, 0, 0], [0, -0.6, 0, 0, 0, 0], [-1, 0, 0, 0, 0, 0]],
        [[40, 4], [40, -4], [40, 0]],
    )
    snapshot.command[:, Command.GROUP_ID] = 1
    p = walk(dut, snapshot, 20.0)[200:, :, :2]
    spread = np.linalg.norm(p - p.mean(axis=1, keepdims=True), axis=2)
    assert spread.max() < 1.5
    assert p[-1, :, 0].min() > 15


def test_the_forces_are_totals(dut, mixed):
    forces = dut.forces(mixed)
    assert forces.shape == (40, FORCES_SIZE)
    np.testing.assert_array_equal(forces[:, :TOTAL_FORCE], 0)
