import math

import numpy as np
import pytest
from scipy import ndimage

from hunav_drake.systems.planning.costmap import (
    inflate,
    inflation,
    inflation_costs,
)
from hunav_drake.systems.planning.costmap.footprint import (
    circle_footprint,
    footprint_cost,
    inscribed_radius,
)
from hunav_drake.systems.planning.costmap.raster import stamp_discs


def costs_at(distances, *, scaling, inscribed=0.275):
    """Returns the costs at distances of whole centimeters."""
    graded = inflation_costs(
        0.01,
        inscribed_radius=inscribed,
        inflation_radius=0.55,
        cost_scaling_factor=scaling,
    )
    return [int(graded[round(100 * d) ** 2]) for d in distances]


@pytest.mark.parametrize(
    ("scaling", "expected"),
    [(3.0, [233, 173, 128, 110]), (10.0, [196, 72, 26, 16])],
)
def test_cost_falls_with_the_distance(scaling, expected):
    """The values of costmap_2d's formula, to the integer."""
    assert costs_at([0.30, 0.40, 0.50, 0.55], scaling=scaling) == expected


def test_the_middle_is_lethal_and_what_is_near_inscribed():
    assert costs_at([0.0, 0.01, 0.27, 0.28], scaling=10.0) == [
        254,
        253,
        253,
        math.floor(252 * math.exp(-0.05)),
    ]


def test_nothing_is_inflated_beyond_the_radius():
    graded = inflation_costs(
        0.05,
        inscribed_radius=0.28,
        inflation_radius=0.55,
        cost_scaling_factor=3.0,
    )
    costs = np.zeros((41, 41), np.uint8)
    costs[20, 20] = 254
    result = inflate(costs, graded)
    i, j = np.indices(costs.shape) - 20
    d = 0.05 * np.hypot(i, j)
    np.testing.assert_array_equal(result > 0, d <= 0.55 + 1e-9)
    inside = (d > 0.28) & (d <= 0.55 + 1e-9)
    formula = np.floor(252 * np.exp(-3.0 * (d - 0.28)))
    np.testing.assert_array_equal(result[inside], formula[inside])


@pytest.mark.parametrize("resolution", [0.025, 0.04, 0.05, 0.06, 0.1, 0.3])
@pytest.mark.parametrize("radius", [0.15, 0.5, 0.55, 0.7])
def test_the_radius_is_in_whole_cells_rounded_up(resolution, radius):
    """As costmap_2d has it; the cost of all of them is that of the formula."""
    graded = inflation_costs(
        resolution,
        inscribed_radius=0.1,
        inflation_radius=radius,
        cost_scaling_factor=1.0,
    )
    cells = -(-round(1000 * radius) // round(1000 * resolution))
    costs = np.zeros((75, 75), np.uint8)
    costs[37, 37] = 254
    i, j = np.indices(costs.shape) - 37
    near = i * i + j * j <= cells * cells
    np.testing.assert_array_equal(inflate(costs, graded) > 0, near)
    # So it is for the discs of people, too.
    stamped = np.zeros_like(costs)
    middle = 37.5 * resolution
    disc = np.array([[middle, middle, 0.4 * resolution]])
    nowhere = np.array([0.0, 0.0, -1.0])
    stamp_discs(stamped, 0.0, 0.0, resolution, disc, nowhere, graded)
    np.testing.assert_array_equal(stamped, inflate(costs, graded))


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (7, 40), (40, 7)])
@pytest.mark.parametrize("share", [0.005, 0.1, 0.6])
@pytest.mark.parametrize("radius", [0.05, 0.35, 3.0])
@pytest.mark.parametrize("much", [0, 10**9])
def test_distances_are_those_of_scipy(shape, share, radius, much, monkeypatch):
    """Those of large maps, and of all others."""
    monkeypatch.setattr(inflation, "_MUCH", much)
    graded = inflation_costs(
        0.1,
        inscribed_radius=0.1,
        inflation_radius=radius,
        cost_scaling_factor=1.0,
    )
    lethal = np.random.default_rng(0).random(shape) < share
    lethal[-1, -1] = True
    squares = np.rint(ndimage.distance_transform_edt(~lethal) ** 2).astype(int)
    expected = np.append(graded, 0)[np.minimum(squares, len(graded))]
    costs = np.where(lethal, 254, 0).astype(np.uint8)
    np.testing.assert_array_equal(inflate(costs, graded), expected)


def test_unknown_cells_become_inscribed_or_stay():
    graded = inflation_costs(
        0.1, inscribed_radius=0.2, inflation_radius=0.5, cost_scaling_factor=1.0
    )
    costs = np.full((1, 6), 255, np.uint8)
    costs[0, 0] = 254
    assert inflate(costs, graded)[0].tolist() == [254, 253, 253, 255, 255, 255]


def test_costs_never_sink():
    graded = inflation_costs(
        0.1, inscribed_radius=0.1, inflation_radius=0.5, cost_scaling_factor=9.0
    )
    costs = np.full((1, 4), 200, np.uint8)
    costs[0, 0] = 254
    assert inflate(costs, graded)[0].tolist() == [254, 253, 200, 200]


def test_footprint_of_pmb2_has_the_radii_of_costmap_2d():
    corners = circle_footprint(0.275)
    assert corners.shape == (16, 2)
    assert inscribed_radius(0.275) == pytest.approx(0.2795, abs=5e-5)
    assert np.hypot(*corners.T).max() == pytest.approx(0.2891, abs=5e-5)


@pytest.mark.parametrize(("x", "expected"), [(1.0, 0), (1.6, 254), (0.1, -1)])
def test_footprint_touches_what_is_on_its_outline(x, expected):
    costs = np.zeros((40, 40), np.uint8)
    costs[:, 37] = 254  # From x = 1.85 on, the outline reaches to 1.885.
    footprint = circle_footprint(0.275)
    result = footprint_cost(costs, 0.0, 0.0, 0.05, x, 1.0, 0.3, footprint)
    assert result == expected
