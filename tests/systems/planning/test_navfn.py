import math
import re

import numpy as np
import pytest

from hunav_drake.systems.planning.costmap import inflate, inflation_costs
from hunav_drake.systems.planning.global_planner import plan_path
from hunav_drake.systems.planning.global_planner.navfn_kernel import (
    navfn_potential,
)
from hunav_drake.systems.world.maps.costs import Costmap


def free_map(rows=41, columns=61, resolution=0.1):
    return Costmap(
        np.zeros((rows, columns), np.uint8), (-1.0, -2.0), resolution
    )


def potential(costs, start, goal, *, allow_unknown=True):
    return navfn_potential(costs, *start, *goal, allow_unknown)


def test_a_free_cell_costs_50_and_a_diagonal_its_approximation():
    costs = free_map().costs
    result = potential(costs, (20, 20), (20, 50))
    np.testing.assert_allclose(result[20, 20:41], 50.0 * np.arange(21))
    assert result[21, 21] == pytest.approx(50 + 50 * 0.7040)
    # Of the cell above two to the right: neighbors 100 and 85.2.
    q = (100 - 85.2) / 50
    assert result[21, 22] == pytest.approx(
        85.2 + 50 * (-0.2301 * q * q + 0.5307 * q + 0.7040), rel=1e-6
    )


@pytest.mark.parametrize(
    ("cost", "weight"),
    [(0, 50), (1, 50), (2, 51), (100, 130), (200, 210), (252, 251)],
)
def test_cells_cost_50_and_four_fifths(cost, weight):
    costs = np.full((5, 30), cost, np.uint8)
    result = potential(costs, (2, 2), (2, 27))
    assert result[2, 3] == weight
    assert result[2, 12] == 10 * weight


def test_unknown_cells_are_dear_or_blocked():
    costs = np.full((5, 30), 255, np.uint8)
    assert potential(costs, (2, 2), (2, 27))[2, 3] == 253
    blocked = potential(costs, (2, 2), (2, 27), allow_unknown=False)
    assert math.isinf(blocked[2, 3])


def test_inscribed_cells_and_the_border_are_blocked():
    costs = free_map().costs.copy()
    costs[:, 30] = 253
    result = potential(costs, (20, 20), (20, 50))
    assert np.isinf(result[:, 30:]).all()
    assert np.isinf(result[0]).all()
    assert np.isfinite(result[1, 1:30]).all()


def test_potential_is_what_its_neighbors_give():
    """It solves NavFn's equation in every cell, whatever the order."""
    rng = np.random.default_rng(1)
    costs = rng.integers(0, 253, (40, 60)).astype(np.uint8)
    costs[rng.random((40, 60)) < 0.2] = 254
    costs[20, 5] = 254  # The robot's own cell is free all the same.
    result = potential(costs, (20, 5), (1, 58))
    weights = np.floor(50 + 0.8 * costs.astype(float))
    for i in range(1, 39):
        for j in range(1, 59):
            if (i, j) == (20, 5) or costs[i, j] >= 253:
                continue
            a = min(result[i - 1, j], result[i + 1, j])
            b = min(result[i, j - 1], result[i, j + 1])
            if not min(a, b) < result[1, 58]:
                continue
            h, low, apart = weights[i, j], min(a, b), abs(a - b)
            q = apart / h
            step = -0.2301 * q * q + 0.5307 * q + 0.7040 if q < 1 else 1.0
            # (Where the polynomial is above 1, the lower value stays.)
            over = result[i, j] - (low + h * step)
            assert -0.0047 * h - 0.01 < over < 0.01


@pytest.mark.parametrize("goal", [(4.05, 0.05), (2.05, 1.55), (3.45, -1.35)])
def test_a_free_way_is_straight(goal):
    found = plan_path(free_map(), (0.05, 0.05), (*goal, 1.2))
    assert found.fault == ""
    assert found.misses == 0
    np.testing.assert_allclose(found.poses[0, :2], (0.05, 0.05), atol=1e-9)
    np.testing.assert_allclose(found.poses[-1], (*goal, 1.2), atol=1e-9)
    length = np.hypot(*np.diff(found.poses[:, :2], axis=0).T).sum()
    assert length < 1.04 * math.dist(goal, (0.05, 0.05)) + 0.1
    dx, dy = goal[0] - 0.05, goal[1] - 0.05
    off = (found.poses[:, 0] - 0.05) * dy - (found.poses[:, 1] - 0.05) * dx
    assert np.abs(off).max() / math.hypot(dx, dy) < 0.15


def walled_map():
    """Returns a map with a wall, a door at the upper end, and a closet."""
    costs = np.zeros((40, 60), np.uint8)
    costs[:30, 30] = 254
    costs[5:12, 45] = costs[5:12, 51] = costs[5, 45:52] = 254
    costs[11, 45:52] = 254
    return Costmap(costs, (0.0, 0.0), 0.1)


def test_the_way_leads_around_walls_and_is_smoothed_by_option():
    graded = inflation_costs(
        0.1, inscribed_radius=0.3, inflation_radius=0.9, cost_scaling_factor=3.0
    )
    costmap = walled_map()
    costmap = costmap._replace(costs=inflate(costmap.costs, graded))
    sharp = plan_path(costmap, (1.05, 1.05), (5.05, 2.05))
    smooth = plan_path(
        costmap, (1.05, 1.05), (5.05, 2.05), smoothing="gaussian"
    )
    turns = []
    for found in (sharp, smooth):
        poses = found.poses
        assert max(costmap.cost_at(x, y) for x, y, _ in poses) < 253
        assert poses[:, 1].max() > 3.0
        np.testing.assert_allclose(poses[0, :2], (1.05, 1.05))
        np.testing.assert_allclose(poses[-1, :2], (5.05, 2.05))
        turns.append(np.abs(np.diff(np.unwrap(poses[:, 2]))).max())
    assert turns[1] < 0.8 * turns[0]


def test_costs_move_the_way_away():
    costmap = free_map()
    costmap.costs[15:26, 25:36] = 200
    around = plan_path(costmap, (-0.45, 0.05), (4.55, 0.05)).poses
    assert np.abs(around[:, 1]).max() > 0.5


@pytest.mark.parametrize(
    ("start", "goal", "words"),
    [
        ((9, 1), (5, 2), r"the start \(9.00, 1.00\) is off the map"),
        ((1, 1), (5, -2), r"the goal \(5.00, -2.00\) is off the map"),
        ((1, 1), (4.85, 0.85), r"no path from \(1.00, 1.00\) to the goal"),
        ((1, 1), (4.85, 1.15), r"goal .* is in an obstacle, and no place"),
    ],
)
def test_why_there_is_no_way(start, goal, words):
    costmap = walled_map()
    costmap.costs[6:11, 46:51] = 0
    found = plan_path(costmap, start, goal, tolerance=0.05)
    assert found.poses.shape == (0, 3)

    assert re.search(words, found.fault)


def test_a_start_in_an_obstacle_is_told():
    costmap = walled_map()
    costmap.costs[:, 10:20] = 254
    found = plan_path(costmap, (1.55, 1.05), (5.05, 2.05))
    assert "the start (1.55, 1.05) is in an obstacle" in found.fault


def test_the_nearest_place_stands_in_for_a_goal_in_an_obstacle():
    found = plan_path(walled_map(), (1.05, 1.05), (3.05, 1.05, 0.0))
    assert found.fault == ""
    np.testing.assert_allclose(found.poses[-1, :2], (2.95, 1.05))
    assert found.misses == pytest.approx(0.1)


def test_the_first_cell_may_be_blocked():
    costmap = free_map()
    costmap.costs[20, 10] = 254
    assert plan_path(costmap, (0.05, 0.05), (3, 0)).fault == ""
