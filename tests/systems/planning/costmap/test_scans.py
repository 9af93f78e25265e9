import math

import numpy as np

from hunav_drake.systems.planning.costmap.marks import Marks, moved
from hunav_drake.systems.planning.costmap.obstacle_layer import (
    free_disc,
    scan_ends,
    see,
)
from hunav_drake.systems.sensing import LidarConfig
from hunav_drake.systems.world.maps.costs import region_around

# Ahead, left, back, right.
FOUR = LidarConfig(
    num_rays=4,
    field_of_view=1.5 * math.pi,
    pose=(0.0, 0.0, 0.75 * math.pi),
    range_max=10.0,
)
# Up to where rays clear, and below which they mark.
RANGES = (3.0, 2.5)


def see_once(marks, ranges, *, x=0.0, y=0.0):
    pose = np.array([x, y, 0.0])
    region = region_around(x, y, 6.0, 0.1)
    ends = scan_ends(FOUR, np.array(ranges), pose)
    return see(marks, region, ends, (x, y), RANGES), region


def cost(marks, region, x, y):
    return region.as_map(marks.costs).cost_at(x, y)


def test_rays_go_where_the_lidar_tells():
    pose = np.array([1.0, 2.0, math.pi / 2])
    lidar = LidarConfig(
        num_rays=3, field_of_view=math.pi, pose=(0.2, 0, 0), range_max=25.0
    )
    ends = scan_ends(lidar, np.array([1.0, 2.0, math.inf]), pose)
    np.testing.assert_allclose(
        ends, [[2.0, 2.2, 1], [1.0, 4.2, 2], [-24.0, 2.2, 25]], atol=1e-12
    )


def test_ends_are_marked_within_range_only():
    marks, region = see_once(Marks(), [1.05, 2.45, 2.55, 8.0])
    assert cost(marks, region, 1.05, 0.0) == 254
    assert cost(marks, region, 0.0, 2.45) == 254
    assert cost(marks, region, -2.55, 0.0) == 0
    assert (marks.costs == 254).sum() == 2


def test_only_a_ray_that_passes_clears_a_mark():
    marks, _ = see_once(Marks(), [1.05, 1.05, 1.05, 1.05])
    again, region = see_once(marks, [2.05, math.inf, 0.85, 1.05])
    assert cost(again, region, 1.05, 0.0) == 0
    assert cost(again, region, 2.05, 0.0) == 254
    assert cost(again, region, 0.0, 1.05) == 0
    # In its shadow nothing is known, so it stays.
    assert cost(again, region, -1.05, 0.0) == 254


def test_marks_move_with_the_window_by_whole_cells():
    marks, _ = see_once(Marks(), [1.05] * 4)
    near, region = see_once(marks, [1.45, 0.35, 0.35, 0.35], x=0.4)
    assert cost(near, region, 1.05, 0.0) == 0
    assert cost(near, region, 1.85, 0.0) == 254
    far = region_around(50.0, 0.0, 6.0, 0.1)
    assert moved(near, far).max() == 0


def test_nothing_is_marked_inside_of_the_robot():
    region = region_around(0.0, 0.0, 2.0, 0.1)
    costs = np.full((20, 20), 254, np.uint8)
    free_disc(costs, region, np.array([0.3, 0.0, 0.4]))
    costmap = region.as_map(costs)
    assert costmap.cost_at(0.3, 0.0) == 0
    assert costmap.cost_at(-0.05, 0.05) == 0
    assert costmap.cost_at(-0.25, 0.05) == 254
    # Partly, or wholly, off the map.
    free_disc(costs, region, np.array([1.0, 1.0, 0.4]))
    free_disc(costs, region, np.array([5.0, -5.0, 0.4]))
    assert costmap.cost_at(0.95, 0.95) == 0
