from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.scene import Bounds
from hunav_drake.views import camera as mut

SIZE = (640, 360)
coordinates = st.floats(-100.0, 100.0)
lengths = st.floats(2.0, 60.0)


@given(coordinates, coordinates, lengths, lengths)
def test_overview_and_top_see_all_of_the_floor(x, y, width, depth):
    bounds = Bounds(x, y, x + width, y + depth)
    corners = np.array(
        [(u, v, 0.0) for u in (x, x + width) for v in (y, y + depth)]
    )
    for make in (mut.overview_camera, mut.top_camera):
        pixels, ahead = make(bounds, SIZE).Project(corners)
        assert np.all(ahead > 0)
        assert np.all(pixels > -1.0)
        assert np.all(pixels < np.array(SIZE) + 1.0)


def test_the_picture_is_not_mirrored():
    """Seen from above, +y is to the left of who looks along +x."""
    bounds = Bounds(-10.0, -4.0, 10.0, 4.0)
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    for make in (mut.overview_camera, mut.top_camera):
        pixels, _ = make(bounds, SIZE).Project(points)
        middle, x, y, z = pixels
        assert x[0] > middle[0]
        assert y[1] < middle[1]
        if make is mut.overview_camera:
            assert z[1] < middle[1]


def test_the_robot_that_is_followed_stays_in_the_middle():
    bounds = Bounds(-10.0, -4.0, 10.0, 4.0)
    for robot in (np.zeros(7), np.array([3.0, -2.0, 1.0, 0, 0, 0, 0.3])):
        dut = mut.follow_camera(bounds, robot, SIZE)
        (pixel,), _ = dut.Project(np.array([[*robot[:2], 0.4]]))
        assert pixel == pytest.approx([320.0, 180.0])


def test_the_depth_of_the_floor_is_that_of_its_points():
    dut = mut.overview_camera(Bounds(-5.0, -4.0, 5.0, 4.0), SIZE)
    points = np.array([[0.0, 0.0, 0.0], [3.0, -2.0, 0.0], [-4.0, 3.0, 0.0]])
    pixels, ahead = dut.Project(points)
    floor = dut.FloorDepth()
    for (u, v), depth in zip(pixels, ahead, strict=True):
        assert floor[int(v), int(u)] == pytest.approx(depth, rel=0.01)
    behind, _ = dut.Project(np.array([dut.X_WC @ np.array([0, 0, -1.0])]))
    assert np.isnan(behind).all()
