"""A step in one call of compiled code is the step part by part."""

import numpy as np
import pytest

from hunav_drake.systems.common.layout import Command, Hold
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.crowd.bodies.pairs import near_pairs
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.shapes import World
from tests.systems.crowd.crowds import (
    BODILESS,
    FREE,
    NO_WALLS,
    box_between,
    random_snapshot,
)

WALLS = World(
    walls=[box_between(-5, -1, -1, 1), box_between(1, 2, 2, 6)]
).obstacles()


def both_ways(config, walls, n, m, seed, *, spread=2.0, placed=()):
    """Returns a step by `take`, and part by part; each states and stances.

    Some people, by their rows, sit down: they are placed.
    """
    rng = np.random.default_rng(seed)
    given = random_snapshot(rng, n, m, walls=walls, spread=spread)
    placed = [i for i in placed if i < n]
    given.command[placed, Command.HOLD] = Hold.PLACED
    given.command[placed, Command.DESIRED_SPEED] = 1.0
    dut = CrowdStep(
        [HumanConfig(pose=(0, 0, 0))] * n,
        obstacles=walls,
        config=CrowdConfig(**config),
        time_step=0.05,
    )
    stances = np.zeros((n, 3))
    stances[::3] = np.column_stack([given.states[::3, :2], given.radii[::3]])
    stances[::3, 2] = 1.0
    arguments = given.states, given.command, given.robots, given.parameters
    for array in (*arguments, stances):
        array.setflags(write=False)
    snapshot = dut.look(*arguments)
    parts = dut.advance(snapshot, dut.forces(snapshot), stances)
    if spread < 1e9 and n:
        # A step that goes part by part, after all, fails.
        dut.look = None
    return dut.take(*arguments, stances), parts


HUNAVSIM = {"type": "social_force", "kernel": "hunavsim"}
IN_GAZEBO = {
    **HUNAVSIM,
    "time_gap": 0.0,
    "measured_velocities": True,
    "robot_obstacle_radius": 0.27,
}


@pytest.mark.parametrize(
    "config",
    [
        *({}, BODILESS, FREE, {"standing": False}, {"groups_part": False}),
        *({"profile": "hunavsim"}, {"model": HUNAVSIM}),
        {"profile": "hunavsim", "model": IN_GAZEBO, "keep_apart": True},
    ],
)
@pytest.mark.parametrize("walls", [NO_WALLS, WALLS], ids=["open", "walls"])
@pytest.mark.parametrize(("n", "m"), [(0, 1), (1, 0), (5, 2), (60, 1)])
def test_one_call_gives_the_same_bits(config, walls, n, m):
    for seed in range(3):
        whole, parts = both_ways(config, walls, n, m, seed)
        for got, expected in zip(whole, parts, strict=True):
            np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("config", [{}, FREE, {"model": HUNAVSIM}])
@pytest.mark.parametrize("walls", [NO_WALLS, WALLS], ids=["open", "walls"])
@pytest.mark.parametrize(("n", "m"), [(1, 0), (1, 1), (5, 2), (60, 1)])
def test_one_call_gives_the_same_bits_where_people_sit(config, walls, n, m):
    for seed, placed in enumerate([(0, 2, 3, 20, 40, 59), range(60)]):
        both = both_ways(config, walls, n, m, seed, placed=placed)
        for got, expected in zip(*both, strict=True):
            np.testing.assert_array_equal(got, expected)


def test_pushes_of_many_robots_have_the_same_bits():
    config = {"profile": "hunavsim", "model": IN_GAZEBO}
    for seed in range(40):
        for got, expected in zip(
            *both_ways(config, NO_WALLS, 60, 4, seed), strict=True
        ):
            np.testing.assert_array_equal(got, expected)


def test_numbers_without_bounds_give_the_same_bits():
    whole, parts = both_ways({}, NO_WALLS, 5, 1, 0, spread=1e13)
    np.testing.assert_array_equal(whole[0], parts[0])


@pytest.mark.parametrize("n", [0, 1, 2, 16, 17, 300])
def test_pairs_are_all_that_are_near(n):
    rng = np.random.default_rng(n)
    # (Many at the same places: of those, too, none is missing.)
    x, y = np.round(rng.uniform(0, 0.7 * n**0.5 + 1, (2, n)), 1)
    reach = rng.uniform(0.1, 0.8, n)
    distance = np.hypot(x - x[:, None], y - y[:, None])
    near = np.argwhere(np.triu(distance < reach + reach[:, None], 1))

    pairs = np.sort(near_pairs(x, y, reach), axis=1)

    assert {tuple(pair) for pair in pairs} == {tuple(pair) for pair in near}
    assert len(pairs) == len(near)
