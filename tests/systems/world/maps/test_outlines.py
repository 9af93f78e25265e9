import math

from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pytest
from scipy import ndimage
import shapely

from hunav_drake.systems.world.maps import outlines as module
from hunav_drake.systems.world.maps.outlines import outlines

SQUARE = np.ones((3, 3))

grids = arrays(bool, st.tuples(st.integers(1, 14), st.integers(1, 14)))


@st.composite
def rooms(draw):
    """Grids as robots make them: thick lines, turned, with noise."""
    size = 60
    y, x = np.mgrid[:size, :size] + 0.5
    grid = np.zeros((size, size), dtype=bool)
    for _ in range(draw(st.integers(1, 4))):
        angle = draw(st.floats(0, math.pi))
        a, b = draw(st.floats(5, 55)), draw(st.floats(5, 55))
        across = np.abs((x - a) * math.sin(angle) - (y - b) * math.cos(angle))
        along = np.abs((x - a) * math.cos(angle) + (y - b) * math.sin(angle))
        grid |= (across < draw(st.floats(0.6, 3))) & (
            along < draw(st.floats(1, 30))
        )
    flips = draw(st.lists(st.integers(0, size**2 - 1), max_size=20))
    grid.ravel()[flips] ^= True
    return grid


def polygons_of(grid):
    found = outlines(grid)
    polygons = [shapely.Polygon(it) for it in found]
    assert all(it.is_valid for it in polygons)
    assert all(it.exterior.is_ccw for it in polygons)
    return polygons, shapely.union_all(polygons)


def check(grid):
    polygons, union = polygons_of(grid)
    # The pieces of a solid do not overlap.
    total = sum(it.area for it in polygons)
    assert total == pytest.approx(union.area, abs=0.3)
    rows, columns = np.nonzero(grid)
    assert shapely.contains_xy(union, columns + 0.5, rows + 0.5).all()
    # Cells that have no occupied one beside them.
    far = ~ndimage.binary_dilation(np.pad(grid, 2), SQUARE)
    rows, columns = np.nonzero(far)
    assert not shapely.intersects_xy(union, columns - 1.5, rows - 1.5).any()
    # Added or lost area lies along the sides of cells.
    cells = shapely.union_all(
        shapely.box(
            *(np.nonzero(grid)[k] for k in (1, 0)),
            *(np.nonzero(grid)[k] + 1 for k in (1, 0)),
        )
    )
    assert abs(union.area - cells.area) <= 0.4 * cells.length
    if grid.any():
        # No wall is moved by more than a corner of a cell, cut off or filled.
        gap = shapely.hausdorff_distance(union.boundary, cells.boundary)
        assert gap < 0.8
    return polygons, union


@given(grids)
def test_any_cells_are_outlined(grid):
    check(grid)


@given(rooms())
def test_walls_are_outlined(grid):
    polygons, union = check(grid)
    solids = ndimage.label(grid, SQUARE)[1]
    holes = ndimage.label(~np.pad(grid, 1))[1] - 1
    # A piece for each solid, and a few more for holes, and where walls touch
    # by a corner only.
    assert len(polygons) <= solids + 3 * (holes + 1)
    # In the whole, as much is added as is cut off.
    assert union.area == pytest.approx(grid.sum(), rel=0.25, abs=4)


def test_rectangles_are_kept_as_they_are():
    grid = np.zeros((20, 30), dtype=bool)
    grid[2:5, 3:20] = True
    grid[8:18, 22:25] = True
    _, union = polygons_of(grid)
    expected = shapely.union_all(
        [shapely.box(3, 2, 20, 5), shapely.box(22, 8, 25, 18)]
    )
    assert union.symmetric_difference(expected).area == pytest.approx(0)


@pytest.mark.parametrize("slope", [1.0, 0.5, 0.1, 0.37])
def test_a_slanted_wall_has_no_stairs(slope):
    y, x = np.mgrid[:120, :120] + 0.5
    off = y - 10 - slope * x
    half = 3 * math.hypot(1, slope)
    (polygon,), _ = polygons_of(np.abs(off) < half)
    corners = np.array(polygon.exterior.coords)
    # Of the two corners of each step, on two sides of the wall.
    stairs = 4 * slope * 118
    assert len(corners) <= max(14, 0.4 * stairs)
    # The long sides run along the wall.
    ends = (corners[:, 0] < 12) | (corners[:, 0] > 108)
    ends |= corners[:, 1] > 108
    away = np.abs(corners[:, 1] - 10 - slope * corners[:, 0]) - half
    assert np.abs(away[~ends] / math.hypot(1, slope)).max(initial=0) < 0.7


def test_a_room_is_cut_into_pieces_around_its_hole():
    grid = np.ones((20, 30), dtype=bool)
    grid[2:-2, 2:-2] = False
    polygons, union = polygons_of(grid)
    assert len(polygons) == 2
    assert union.area == pytest.approx(20 * 30 - 16 * 26)
    assert not union.contains(shapely.Point(15, 10))


def test_cells_that_touch_by_a_corner_are_one_wall():
    (polygon,), _ = polygons_of(np.eye(12, dtype=bool))
    assert polygon.is_valid
    assert len(polygon.exterior.coords) <= 8


def test_no_cells_have_no_outline():
    assert outlines(np.zeros((5, 4), dtype=bool)) == []


def test_noise_without_end_is_refused(monkeypatch):
    monkeypatch.setattr(module, "MAX_SIDES", 100)
    noise = np.indices((20, 20)).sum(axis=0) % 2 == 0
    with pytest.raises(ValueError, match="at most 100 sides, got 800"):
        outlines(noise)


def test_rectangles_of_cells_stay_as_they_are():
    """As most noise is."""
    grid = np.zeros((9, 12), dtype=bool)
    grid[1, 2] = grid[4:7, 5:7] = True
    found = sorted(ring.tolist() for ring in outlines(grid))
    expected = [
        [[2, 1], [3, 1], [3, 2], [2, 2]],
        [[5, 4], [7, 4], [7, 7], [5, 7]],
    ]
    for ring, corners in zip(found, expected, strict=True):
        assert {*map(tuple, ring)} == {*map(tuple, corners)}
        assert shapely.Polygon(ring).exterior.is_ccw
