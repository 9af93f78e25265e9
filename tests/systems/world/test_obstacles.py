import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)
from hunav_drake.systems.world.shapes import Box, Polygon, Polyline, World

L_SHAPE = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [0, 3]]


@pytest.fixture
def world():
    return World(
        walls=[
            Box(center=[2, -3], size=[2, 1], yaw=0.3),
            Polygon(points=L_SHAPE),
            Polyline(points=[[6, 0], [6, 2], [8, 2]]),
        ]
    )


def test_a_world_without_walls_has_no_obstacles():
    obstacles = World().obstacles()
    assert len(obstacles) == 0
    assert nearest_points(obstacles, [[1, 2]]).shape == (1, 0, 2)


def test_a_box_has_its_corners_where_it_is_turned_to():
    box = Box(center=[1, 2], size=[4, 2], yaw=math.pi / 2)
    np.testing.assert_allclose(
        box.vertices(), [[2, 0], [2, 4], [0, 4], [0, 0]], atol=1e-15
    )


def test_solid_shapes_close_and_thin_ones_do_not(world):
    obstacles = world.obstacles()
    np.testing.assert_array_equal(obstacles.first, [0, 4, 10, 12])
    np.testing.assert_array_equal(obstacles.solid, [True, True, False])
    np.testing.assert_array_equal(obstacles.segments[9], [0, 3, 0, 0])
    np.testing.assert_array_equal(obstacles.segments[11], [6, 2, 8, 2])


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((2, -1), (2, 0)),
        ((3, 3), (3, 1)),
        ((2, 0.8), (2, 1)),
        ((-3, -4), (0, 0)),
    ],
)
def test_the_nearest_point_lies_on_the_outline(world, point, expected):
    nearest = nearest_points(world.obstacles(), point)[1]
    np.testing.assert_allclose(nearest, expected)


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_no_point_of_the_outline_is_nearer(x, y):
    obstacles = World(walls=[Polygon(points=L_SHAPE)]).obstacles()
    nearest = nearest_points(obstacles, [x, y])[0]
    start, end = obstacles.segments[:, :2], obstacles.segments[:, 2:]
    t = np.linspace(0, 1, 401)[:, None, None]
    distances = np.hypot(*(start + t * (end - start) - [x, y]).T)
    distance = math.hypot(*(nearest - [x, y]))
    assert distance <= distances.min() + 1e-12
    assert distance == pytest.approx(distances.min(), abs=0.006)


@pytest.mark.parametrize(
    ("point", "where"),
    [((2, -3), 0), ((0.5, 2), 1), ((3.5, 0.5), 1), ((2, 2), None)],
)
def test_only_solid_shapes_have_an_inside(world, point, where):
    result = inside(world.obstacles(), point)
    np.testing.assert_array_equal(result, np.arange(3) == where)


@given(st.floats(-50, 50))
def test_a_wrapped_angle_is_the_same_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1)


def test_half_a_turn_is_plus_pi():
    assert wrap_angle(-math.pi) == math.pi


def test_points_are_obstacles_of_their_own():
    obstacles = Obstacles.from_points([[1, 2], [3, 4]])
    nearest = nearest_points(obstacles, [0, 0])
    np.testing.assert_array_equal(nearest, [[1, 2], [3, 4]])
