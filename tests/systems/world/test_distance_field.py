import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)

WALLS = Obstacles.from_shapes(
    [[[0, 0], [2, 0], [2, 1], [0, 1]], [[3, -1], [3, 3]], [[-1.0, 2.0]]],
    solid=[True, False, False],
)


def exact_distances(obstacles, points):
    away = nearest_points(obstacles, points) - points[..., None, :]
    distance = np.hypot(away[..., 0], away[..., 1]).min(axis=-1)
    return np.where(inside(obstacles, points).any(axis=-1), -1, 1) * distance


@given(st.floats(0.05, 1.0), st.floats(-3, 1), st.floats(-3, 1))
def test_every_place_has_its_exact_distance(resolution, x, y):
    dut = WALLS.distance_field(resolution, (x, y, x + 4, y + 3))
    rows, columns = dut.distances.shape
    j, i = np.meshgrid(np.arange(columns), np.arange(rows))
    places = dut.origin + dut.resolution * np.stack([j, i], axis=-1)
    np.testing.assert_allclose(
        dut.distances, exact_distances(WALLS, places), rtol=1e-12, atol=1e-15
    )
    assert places[-1, -1] == pytest.approx(
        places[-1, -1].clip([x + 4, y + 3], [x + 5, y + 4]), abs=1e-6
    )


def test_rows_go_up_and_columns_to_the_right():
    dut = WALLS.distance_field(0.5, (0, 0, 4, 2))
    assert dut.distances.shape == (5, 9)
    assert dut.distances[1, 2] == -0.5
    assert dut.distances[4, 8] == 1.0
    assert not dut.distances.flags.writeable


def test_distances_between_places_are_those_of_the_nearest():
    dut = WALLS.distance_field(0.1, (-2, -2, 5, 4))
    points = np.random.default_rng(0).uniform([-2, -2], [5, 4], (500, 2))
    error = np.abs(dut.at(points) - exact_distances(WALLS, points))
    assert error.max() <= 0.1 / math.sqrt(2) + 1e-9
    assert dut.at([100, 100]) == dut.distances[-1, -1]


def test_the_same_field_is_computed_once():
    other = Obstacles(WALLS.segments.copy(), WALLS.first, WALLS.solid)
    bounds = (0, 0, 1, 1)
    dut = WALLS.distance_field(0.25, bounds)
    assert other.distance_field(0.25, bounds) is dut
    assert WALLS.distance_field(0.5, bounds) is not dut


def test_without_walls_everything_is_infinitely_far():
    dut = Obstacles.from_points([]).distance_field(0.5, (0, 0, 1, 1))
    assert (dut.distances == np.inf).all()


@pytest.mark.parametrize(
    ("resolution", "bounds", "words"),
    [
        (0.0, (0, 0, 1, 1), "resolution must be positive, got 0.0 m"),
        (math.nan, (0, 0, 1, 1), "resolution must be positive"),
        (0.1, (1, 0, 0, 1), "bounds must be"),
        (0.1, (0, 0, math.inf, 1), "bounds must be"),
        (1e-4, (0, 0, 10, 10), "at most 25000000"),
    ],
)
def test_a_field_that_cannot_be_is_an_error(resolution, bounds, words):
    with pytest.raises(ValueError, match=words):
        WALLS.distance_field(resolution, bounds)
