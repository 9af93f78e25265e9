import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.ray_cast import ray_cast


def thin_wall_table(*segments):
    shapes = np.array(segments).reshape(-1, 2, 2)
    return Obstacles.from_shapes(shapes, solid=[False] * len(shapes)).table


WALL = thin_wall_table([2.0, -1.0, 2.0, 1.0])
coordinate = st.floats(-10, 10)
point = st.tuples(coordinate, coordinate)


@pytest.mark.parametrize(
    ("goal", "part"),
    [
        ((4.0, 0.0), 0.5),
        ((8.0, 0.0), 0.25),
        ((4.0, 1.9), 0.5),
        ((4.0, 2.1), math.inf),
        ((1.9, 0.0), math.inf),
        ((-4.0, 0.0), math.inf),
        ((0.0, 0.0), math.inf),
    ],
)
def test_wall_stops_the_lines_that_cross_it(goal, part):
    assert ray_cast(0.0, 0.0, *goal, WALL) == pytest.approx(part)


def test_first_of_several_walls_counts():
    walls = thin_wall_table([3.0, -1, 3, 1], [1.0, -1, 1, 1], [2.0, -1, 2, 1])
    assert ray_cast(0.0, 0.0, 4.0, 0.0, walls) == 0.25


def test_no_line_slips_through_the_joint_of_two_walls():
    walls = thin_wall_table([2.0, -1, 2, 0], [2.0, 0, 2, 1])
    for gx, gy in ((4.0, 0.0), (2.5, 0.0)):
        assert ray_cast(0.0, 0.0, gx, gy, walls) <= 1
        assert ray_cast(gx, gy, 0.0, 0.0, walls) <= 1


def test_without_walls_everything_is_seen():
    assert ray_cast(0.0, 0.0, 9.0, 9.0, thin_wall_table()) == math.inf


@given(point, point)
def test_line_into_a_solid_meets_its_outline(inner, outer):
    inner = np.array(inner) / 10.5
    outer = np.array(outer)
    if np.abs(outer).max() <= 1:
        outer = outer + 3.0
    box = Obstacles.from_shapes(
        [[[-1, -1], [1, -1], [1, 1], [-1, 1]]], solid=[True]
    ).table
    assert ray_cast(*inner, *outer, box) <= 1
    assert ray_cast(*outer, *inner, box) <= 1


@given(point, point, point, point)
def test_both_ways_end_at_the_same_wall(p, q, a, b):
    wall = thin_wall_table([*a, *b])
    forth = ray_cast(*p, *q, wall)
    back = ray_cast(*q, *p, wall)
    # If a line only touches a wall, rounding decides.
    if math.isfinite(forth) and math.isfinite(back):
        assert forth + back == pytest.approx(1, abs=1e-6)
