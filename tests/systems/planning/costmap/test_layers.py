from itertools import permutations

import numpy as np
import pytest

from hunav_drake.systems.planning.costmap import (
    ObstacleLayer,
    SocialLayer,
    Surroundings,
    costmap_from_obstacles,
    costmap_from_occupancy,
    inflate,
    inflation_costs,
    make_costs,
    social_parameters,
    static_map,
    walls_on,
)
from hunav_drake.systems.planning.costmap.obstacle_layer import person_discs
from hunav_drake.systems.world.maps.costs import region_around, region_of
from hunav_drake.systems.world.obstacles import Obstacles

GRADED = inflation_costs(
    0.05, inscribed_radius=0.28, inflation_radius=0.55, cost_scaling_factor=3.0
)
WALLS = Obstacles.from_shapes(
    [[(0, 0), (4, 0), (4, 4)], [(1, 2), (2, 2), (2, 3), (1, 3)]],
    solid=[False, True],
)
ROBOT = np.array([2.6, 1.4, 0, 0, 0, 0, 0.35])
HUMANS = np.array(
    [[3.2, 1.5, 0, 0.5, 0.2, 0, 0.4], [2.75, 1.5, 0, 0, 0, 0, 0.4]]
)


def surroundings(region, *, clearing=True):
    layer = ObstacleLayer()
    return Surroundings(
        walls=static_map(WALLS, region, GRADED),
        discs=person_discs(HUMANS, ROBOT, layer),
        humans=HUMANS,
        robot=np.array([*ROBOT[:2], 0.28 if clearing else -1.0]),
        graded=GRADED,
        social=social_parameters(SocialLayer()),
    )


def marked_by_hand(region):
    """Returns walls and people as they are, without inflation."""
    costs = walls_on(WALLS, region)
    x = region.origin[0] + (np.arange(region.columns) + 0.5) * 0.05
    y = region.origin[1] + (np.arange(region.rows) + 0.5) * 0.05
    x, y = np.meshgrid(x, y)
    free = np.hypot(x - ROBOT[0], y - ROBOT[1]) <= 0.28
    for human in HUMANS:
        disc = np.hypot(x - human[0], y - human[1]) <= 0.2
        costs[disc & ~free] = 254
    return costs


def test_the_fast_way_is_inflation_of_all_that_is_marked():
    region = region_of((-1, -1), (5, 5), 0.05)
    around = surroundings(region)
    made = make_costs(("static", "obstacle", "inflation"), region, around)
    by_hand = inflate(marked_by_hand(region), GRADED)
    np.testing.assert_array_equal(made, by_hand)
    assert (made == 254).sum() > 600


def test_order_of_layers_before_inflation_does_not_matter():
    region = region_of((-1, -1), (5, 5), 0.05)
    around = surroundings(region)
    results = [
        make_costs((*order, "inflation"), region, around)
        for order in permutations(("static", "obstacle"))
    ]
    np.testing.assert_array_equal(*results)


def test_social_layer_before_inflation_makes_people_solid():
    region = region_of((-1, -1), (5, 5), 0.05)
    around = surroundings(region)._replace(discs=np.zeros((0, 3)))
    after = make_costs(("obstacle", "inflation", "social"), region, around)
    before = make_costs(("obstacle", "social", "inflation"), region, around)
    assert (before >= after).all()
    # For standing people; within the robot's radius of an obstacle; or a cost.
    i, j = region.as_map(after).cell_at(2.75, 1.5)
    assert after[i, j] == before[i, j] == 254
    assert after[i, j + 4] < 253
    assert before[i, j + 4] == 253


def test_inflation_first_leaves_marks_bare():
    region = region_of((-1, -1), (5, 5), 0.05)
    made = make_costs(("inflation", "static"), region, surroundings(region))
    np.testing.assert_array_equal(made, walls_on(WALLS, region))


def test_a_window_is_a_part_of_the_whole_and_free_beyond():
    region = region_of((-1, -1), (5, 5), 0.05)
    around = surroundings(region)
    whole = make_costs(("static", "inflation"), region, around)
    window = region_around(4.3, 4.7, 2.0, 0.05)
    part = make_costs(("static", "inflation"), window, around)
    assert part.shape == (40, 40)
    inside = whole[window.row - region.row :, window.column - region.column :]
    np.testing.assert_array_equal(
        part[: inside.shape[0], : inside.shape[1]], inside
    )
    assert part[:, inside.shape[1] :].max() == 0


@pytest.mark.parametrize("x", np.arange(0, 0.2, 0.013))
def test_a_window_moves_by_whole_cells_with_the_robot_in_the_middle(x):
    region = region_around(x, -x, 4.0, 0.025)
    assert region.columns == 160
    assert region.origin[0] + 2.0 == pytest.approx(x, abs=0.0126)
    assert region.origin[1] + 2.0 == pytest.approx(-x, abs=0.0126)


def test_walls_leave_no_gap_and_are_where_they_are():
    wall = Obstacles.from_shapes([[(0.03, 0.02), (1.97, 0.71)]], solid=[False])
    costmap = costmap_from_obstacles(wall, (-1, -1, 3, 2), 0.05)
    along = np.linspace(0, 1, 5000)
    points = np.array([0.03, 0.02]) + along[:, None] * (1.94, 0.69)
    assert all(costmap.cost_at(x, y) == 254 for x, y in points)
    # As many cells as there are sides of cells on the way.
    crossed = 39 + 14 - 0 + 1 - 0
    assert (costmap.costs == 254).sum() == pytest.approx(crossed, abs=1)


def test_solids_are_filled():
    solid = Obstacles.from_shapes(
        [[(0, 0), (1, 0), (1, 1), (0.5, 0.2), (0, 1)]], solid=[True]
    )
    costmap = costmap_from_obstacles(solid, (-1, -1, 2, 2), 0.02)
    assert costmap.cost_at(0.5, 0.1) == 254
    assert costmap.cost_at(0.1, 0.5) == 254
    assert costmap.cost_at(0.5, 0.5) == 0
    # The area, and half a cell around it.
    area = (costmap.costs == 254).sum() * 0.02**2
    assert area == pytest.approx(0.6, abs=0.06)


def test_people_are_marked_in_range_only():
    far = HUMANS.copy()
    far[0, :2] = ROBOT[:2] + np.array([2.8, 0.0])
    layer = ObstacleLayer()
    assert len(person_discs(far, ROBOT, layer)) == 1
    assert len(person_discs(far, ROBOT, ObstacleLayer(marking_range=3.0))) == 2
    blind = ObstacleLayer(people_in_scan=False)
    assert len(person_discs(far, ROBOT, blind)) == 0


def test_occupancy_becomes_costs():
    occupancy = np.array([[0.0, 0.64, 0.65, 1.0, np.nan]])
    assert costmap_from_occupancy(occupancy).costs.tolist() == [
        [0, 0, 254, 254, 255]
    ]
    free = costmap_from_occupancy(occupancy, unknown_is_free=True)
    assert free.costs[0, 4] == 0


def test_a_map_that_is_too_large_is_told():
    with pytest.raises(ValueError, match=r"25000000 cells, got 0.001 m"):
        region_of((0, 0), (100, 100), 0.001)
