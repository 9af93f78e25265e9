"""The closed forms of nav2_social_costmap_plugin, to the integer."""

import math

import numpy as np
import pytest

from hunav_drake.systems.planning.costmap import (
    SocialLayer,
    add_social_costs,
    social_parameters,
)
from hunav_drake.systems.world.maps.costs import region_around

RESOLUTION = 0.05


def social_costs(*, speed=0.0, heading=0.0, old=0, **config):
    """Returns the costs around a person in the middle of a cell, 10 m wide."""
    region = region_around(0.0, 0.0, 10.05, RESOLUTION)
    costs = np.full((region.rows, region.columns), old, np.uint8)
    human = [0.0, 0.0, 0, *(0, 0), 0, 0.4]
    human[3:5] = speed * math.cos(heading), speed * math.sin(heading)
    parameters = social_parameters(SocialLayer(**config))
    add_social_costs(costs, region, np.array([human]), parameters)
    i, j = region.as_map(costs).cell_at(0.0, 0.0)
    return costs, i, j


def gauss(distance, variance):
    return math.floor(255 * math.exp(-(distance**2) / (2 * variance)))


@pytest.mark.parametrize(
    ("cells", "expected"), [(7, 199), (12, 124), (18, 50), (25, 11), (26, 0)]
)
def test_who_stands_costs_the_same_all_around(cells, expected):
    costs, i, j = social_costs()
    around = [
        costs[i, j + cells],
        costs[i, j - cells],
        costs[i + cells, j],
        costs[i - cells, j],
    ]
    assert around == [expected] * 4
    assert expected in (0, gauss(0.05 * cells, 0.25))


def test_the_cell_of_a_person_is_lethal_and_only_that():
    costs, i, j = social_costs()
    assert costs[i, j] == 254
    assert (costs == 254).sum() == 1
    # 255 exp(-0.05^2 / 0.5) is the cost of the four cells beside it.
    assert (costs >= 253).sum() == 5


@pytest.mark.parametrize(
    ("speed", "reach"), [(0.4, 2.79), (0.6, 3.22), (1.0, 3.94), (1.5, 4.69)]
)
def test_room_ahead_grows_with_the_speed(speed, reach):
    costs, i, j = social_costs(speed=speed)
    ahead = np.flatnonzero(costs[i, j:])[-1]
    assert ahead == math.floor(reach / RESOLUTION)
    variance = 0.4 * (1 + 5 * speed)
    for cells in (5, 20, 50):
        assert costs[i, j + cells] == gauss(0.05 * cells, variance)


def test_room_behind_and_to_the_left_does_not():
    costs, i, j = social_costs(speed=1.5)
    for cells in (5, 20):
        assert costs[i, j - cells] == gauss(0.05 * cells, 0.25)
        assert costs[i + cells, j] == gauss(0.05 * cells, 0.25)
    assert costs[i, j - 26] == 0


def test_to_the_right_there_is_more_to_pass_on_the_left():
    costs, i, j = social_costs(speed=1.0)
    for cells in (5, 20, 27):
        assert costs[i - cells, j] == gauss(0.05 * cells, 0.3)
    bare, i, j = social_costs(speed=1.0, use_passing=False)
    for cells in (5, 20):
        assert bare[i - cells, j] == gauss(0.05 * cells, 0.25)


def test_speed_counts_only_if_it_shall():
    costs, i, j = social_costs(speed=1.5, use_vel_factor=False)
    assert costs[i, j + 20] == gauss(1.0, 0.4)


def test_it_turns_with_the_person():
    east = social_costs(speed=1.0)[0]
    north = social_costs(speed=1.0, heading=math.pi / 2)[0]
    turned = np.rot90(east, -1)
    # The original takes 1.57 for pi / 2; at the cutoff, costs jump.
    both = (north > 0) & (turned > 0)
    difference = np.abs(north.astype(int) - turned.astype(int))
    assert difference[both].max() <= 1
    assert (difference[~both] <= 10).all()
    assert ((north > 0) != (turned > 0)).sum() < 20


def test_who_creeps_counts_as_standing():
    np.testing.assert_array_equal(
        social_costs(speed=0.099)[0], social_costs()[0]
    )
    assert (social_costs(speed=0.1)[0] != social_costs()[0]).any()


def test_costs_never_sink_and_unknown_stays():
    assert social_costs(old=100)[0].min() == 100
    assert (social_costs(old=255)[0] == 255).all()


def test_a_cutoff_above_the_amplitude_leaves_nothing():
    assert social_costs(amplitude=9.0)[0].max() == 0


def test_the_higher_of_two_people_counts():
    region = region_around(0.0, 0.0, 6.0, RESOLUTION)
    humans = np.array(
        [[-0.5, 0, 0, 0, 0, 0, 0.4], [0.5, 0.1, 0, 0.7, 0, 0, 0.4]]
    )
    parameters = social_parameters(SocialLayer())
    both = np.zeros((120, 120), np.uint8)
    alone = []
    add_social_costs(both, region, humans, parameters)
    for k in range(2):
        costs = np.zeros((120, 120), np.uint8)
        add_social_costs(costs, region, humans[k : k + 1], parameters)
        alone.append(costs)
    np.testing.assert_array_equal(both, np.maximum(*alone))
