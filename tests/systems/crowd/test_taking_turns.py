"""People who take turns in passages that are too narrow for two."""

import dataclasses
import math

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal
import pytest

from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.crowd.bodies.taking_turns import take_turns
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.crowd.test_bodies import FAR, commands_to, run

MODELS = (
    "social_force",
    "headed_social_force",
    "orca",
    "collision_free_speed",
    "anticipation_velocity",
)
WEIGHTS = dataclasses.astuple(SocialForceParameters())


def turned(angle, flip=1):
    """Returns the matrix that turns by an angle, and mirrors before."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]]) * [1, flip]


def door(width, *, depth=0.0, frame=None):
    """Returns a wall along y with a door at the origin."""
    d, h = depth / 2, width / 2
    if depth == 0:
        shapes = [[(0, -5), (0, -h)], [(0, h), (0, 5)]]
    else:
        shapes = [
            [(-d, -5), (d, -5), (d, -h), (-d, -h)],
            [(-d, h), (d, h), (d, 5), (-d, 5)],
        ]
    frame = np.eye(2) if frame is None else frame
    return Obstacles.from_shapes(
        [np.array(shape) @ frame.T for shape in shapes], solid=[depth > 0] * 2
    )


def meet(places, goals, *, width, depth=0.0, frame=None, **options):
    """Returns where people are, shape (k, n, 2), in the frame of the door."""
    frame = np.eye(2) if frame is None else frame
    rows, _, _ = run(
        (np.array(places) @ frame.T).tolist(),
        (np.array(goals) @ frame.T).tolist(),
        walls=door(width, depth=depth, frame=frame),
        **options,
    )
    return rows[:, :, :2] @ frame


def wanted_by(places, goals, walls):
    """Returns the commands of people, and those at a narrow passage."""
    states = np.zeros((len(places), 6))
    states[:, :2] = places
    command = commands_to(goals)
    felt = np.tile([0.35, 10.0], (len(places), 1))
    wanted, eased = take_turns(
        *(states, np.full(len(places), 0.25), command),
        *(np.tile(WEIGHTS, (len(places), 1)), felt, walls.table),
    )
    return command, wanted, eased


@pytest.mark.parametrize("width", [0.7, 0.8, 0.9])
@pytest.mark.parametrize("depth", [0.0, 0.2, 1.0])
def test_two_who_meet_in_a_door_both_get_through(width, depth):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        places = rng.uniform([[-4, -2], [2, -2]], [[-2, 2], [4, 2]])
        frame = turned(rng.uniform(-3, 3), 1 - 2 * (seed % 2))
        p = meet(
            *(places, [(3, 0), (-3, 0)]),
            **{"width": width, "depth": depth, "frame": frame, "time": 12.0},
        )
        assert p[-1, 0, 0] > 2.5, seed
        assert p[-1, 1, 0] < -2.5, seed
        # One after the other.
        inside = (abs(p[..., 0]) < depth / 2 + 0.1).all(axis=1)
        assert not inside.any()


@pytest.mark.parametrize("width", [0.9, 1.1, 1.3, 1.4])
@pytest.mark.parametrize("depth", [1.0, 2.5])
def test_who_keeps_more_than_bodies_apart_gets_through_wider_doors(
    width, depth
):
    for seed in range(3):
        rng = np.random.default_rng(seed + 17)
        places = rng.uniform([[-4.5, -0.5], [3.5, -0.5]], [[-4, 0.5], [4, 0.5]])
        p = meet(
            *(places, [(6, 0.3), (-6, -0.2)]),
            **{"width": width, "depth": depth, "time": 17.0, "model": "orca"},
        )
        assert p[-1, 0, 0] > 4, seed
        assert p[-1, 1, 0] < -4, seed


@pytest.mark.parametrize("model", MODELS)
def test_three_get_past_two_at_a_door(model):
    for seed in range(2):
        y = np.random.default_rng(seed).uniform(-0.6, 0.6, 5)
        places = np.column_stack([[-2, -2.8, -3.6, 2, 2.8], y])
        goals = [(4, -1.5), (4, 0), (4, 1.5), (-4, -1), (-4, 1)]
        p = meet(places, goals, width=0.8, time=30.0, model=model)
        passed = p[..., 0] * [1, 1, 1, -1, -1] > 0.8
        assert passed.any(axis=0).all(), seed


@pytest.mark.parametrize("y", [0.0, 0.2, -0.5])
def test_who_is_nearer_goes_and_the_other_one_waits_beside(y):
    walls = door(0.8)
    places = [(-0.5, 0.0), (0.8, y)]
    goals = [(3, 0), (-3, 0)]
    command, wanted, felt = wanted_by(places, goals, walls)
    assert_array_equal(wanted[0], command[0])
    # Outside of the door by the whole body, on the own side of it.
    assert wanted[1, 0] == pytest.approx(0.8)
    assert abs(wanted[1, 1]) > 0.4 + 0.25
    assert (wanted[1, 1] > 0) == (y > -0.3)
    assert felt[0, 0] < felt[1, 0] == 0.35


def test_of_two_in_a_door_the_one_who_is_less_deep_goes_back():
    walls = door(0.8, depth=1.0)
    places = [(-0.3, 0.0), (0.25, 0.0)]
    command, wanted, _ = wanted_by(places, [(3, 0), (-3, 0)], walls)
    assert_array_equal(wanted[1], command[1])
    assert wanted[0, 0] < -0.5 - 0.25
    assert abs(wanted[0, 1]) < 1e-9


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.7, -2.9])
def test_of_two_as_near_exactly_one_waits(angle):
    frame = turned(angle)
    places = np.array([(-0.7, 0.0), (0.7, 0.0)]) @ frame.T
    goals = (np.array([(3, 0), (-3, 0)]) @ frame.T).tolist()
    command, wanted, _ = wanted_by(places, goals, door(0.8, frame=frame))
    assert (wanted != command).any(axis=1).sum() == 1


@pytest.mark.parametrize("width", [1.2, 1.5, 9.0])
def test_where_there_is_room_for_two_nobody_waits(width):
    places = [(-0.7, 0.0), (0.8, 0.1)]
    command, wanted, felt = wanted_by(places, [(3, 0), (-3, 0)], door(width))
    assert_array_equal(wanted, command)
    assert_array_equal(felt, [[0.35, 10.0]] * 2)


def test_who_goes_the_same_way_or_stands_does_not_let_others_wait():
    walls = door(0.8)
    places = [(-0.5, 0.0), (0.8, 0.0)]
    for goals in ([(3, 0), (4, 0)], [None, (-3, 0)], [(-3, 0), (3, 0)]):
        command, wanted, _ = wanted_by(places, goals, walls)
        assert_array_equal(wanted, command)


def test_turns_are_the_same_in_any_order_and_in_any_frame():
    rng = np.random.default_rng(0)
    for _ in range(50):
        places = rng.uniform([-1.5, -0.8], [1.5, 0.8], (6, 2))
        goals = np.column_stack([-4 * np.sign(places[:, 0]), np.zeros(6)])
        _, wanted, felt = wanted_by(places, goals, door(0.8, depth=0.2))
        order = rng.permutation(6)
        _, other, others = wanted_by(
            places[order], goals[order], door(0.8, depth=0.2)
        )
        assert_array_equal(other, wanted[order])
        assert_array_equal(others, felt[order])
        frame = turned(rng.uniform(-3, 3))
        _, other, others = wanted_by(
            places @ frame.T, goals @ frame.T, door(0.8, depth=0.2, frame=frame)
        )
        assert_allclose(other[:, :2], wanted[:, :2] @ frame.T, atol=1e-9)
        assert_allclose(others, felt)


def test_the_compiled_step_takes_turns_as_look_does():
    places = [(-0.5, 0.05), (0.8, 0.1)]
    humans = [HumanConfig(pose=(*place, 0.0)) for place in places]
    step = CrowdStep(
        humans, obstacles=door(0.8), config=CrowdConfig(), time_step=0.05
    )
    states = np.zeros((2, 6))
    states[:, :2] = places
    command = commands_to([(3, 0), (-3, 0)])
    weights = np.tile(WEIGHTS, (2, 1))
    given = (states, command, np.array([FAR]), weights)
    looked = step.look(*given)
    assert looked.command[1, Command.GOAL_X] > 0.5
    stances = np.zeros((2, 3))
    expected = step.advance(looked, step.forces(looked), stances)
    stepped = step.take(*given, stances)
    assert_allclose(stepped.states, expected.states, atol=1e-9)


@pytest.mark.parametrize(
    "options",
    [
        {"profile": "hunavsim"},
        {"keep_apart": False},
        {"keep_out_of_walls": False},
    ],
)
def test_bodies_that_do_not_block_each_other_take_no_turns(options):
    places = [(-0.5, 0.05), (0.8, 0.1)]
    humans = [HumanConfig(pose=(*place, 0.0)) for place in places]
    step = CrowdStep(
        humans,
        obstacles=door(0.8),
        config=CrowdConfig(
            **{"model": {"type": "social_force", "time_gap": 0.0}, **options}
        ),
        time_step=0.05,
    )
    states = np.zeros((2, 6))
    states[:, :2] = places
    command = commands_to([(3, 0), (-3, 0)])
    looked = step.look(
        *(states, command, np.array([FAR]), np.tile(WEIGHTS, (2, 1)))
    )
    assert_array_equal(looked.command, command)
