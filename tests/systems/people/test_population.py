"""The people of a population, and how they are drawn."""

import dataclasses
import math

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy import stats
from scipy.spatial.distance import pdist
import shapely

from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.population import (
    PopulationError,
    draw_bodies,
    draw_population,
)
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
)
from hunav_drake.systems.world.obstacles import Obstacles

HALL = Area(rectangle=[0, 0, 20, 10])
# As large as half the hall.
TRIANGLE = Area(polygon=[[0, 0], [20, 0], [20, 10]])
NO_WALLS = Obstacles.from_shapes([], solid=[])
PILLAR = np.array([[8.0, 3.0], [12.0, 3.0], [12.0, 7.0], [8.0, 7.0]])
FENCE = np.array([[2.0, 5.0], [6.0, 8.0]])
WALLS = Obstacles.from_shapes([PILLAR, FENCE], solid=[True, False])


def cohort(number=10, **values):
    return CohortConfig(**{"number": number, "start": [HALL], **values})


def drawn(*cohorts, seed=0, obstacles=NO_WALLS, **options):
    config = PopulationConfig(seed=seed, cohorts=list(cohorts))
    return draw_population(config, obstacles, **options)


def starts(people):
    return np.array([human.pose[:2] for human in people])


def test_the_same_seed_draws_the_same_people():
    kind = cohort(goals=[HALL], group_sizes=[1, 1], behaviors={"regular": 1})
    assert drawn(kind, seed=5) == drawn(kind, seed=5)
    assert drawn(kind, seed=5) != drawn(kind, seed=6)


def test_more_people_change_nobody():
    few, many = (cohort(n, goals=[HALL]) for n in (10, 30))
    assert drawn(many)[:10] == drawn(few)


def test_another_cohort_changes_nobody():
    kind = cohort(name="guest", goals=[HALL], group_sizes=[1, 1])
    far = Area(rectangle=[50, 0, 60, 10])
    other = cohort(name="waiter", start=[far])
    alone = drawn(kind)
    assert drawn(kind, other)[:10] == alone
    assert drawn(other, kind)[10:] == alone


def test_cohorts_without_names_are_not_alike():
    first, second = np.split(starts(drawn(cohort(), cohort())), 2)
    assert not np.isclose(first, second).any()


def test_those_of_a_cohort_with_a_name_have_names():
    people = drawn(cohort(2, name="guest"), cohort(1))
    assert [human.name for human in people] == ["guest_1", "guest_2", ""]


@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**63 - 1),
    sizes=st.lists(st.floats(0.1, 1), min_size=1, max_size=4),
    radius=st.floats(0.25, 0.5),
    spacing=st.floats(0, 0.3),
)
def test_nobody_starts_in_anything(seed, sizes, radius, spacing):
    taken = np.array([[3.0, 3.0, 0.4], [15.0, 8.0, 1.0]])
    kind = cohort(
        40, group_sizes=sizes, radius=radius, spacing=spacing, goals=[HALL]
    )
    people = drawn(kind, cohort(5), seed=seed, obstacles=WALLS, taken=taken)
    points = starts(people)
    walls = shapely.union(shapely.Polygon(PILLAR), shapely.LineString(FENCE))
    radii = np.array([human.radius for human in people])
    to_walls = shapely.distance(walls, shapely.points(points))
    assert (to_walls >= radii).all()
    gaps = np.hypot(*(points[:, None] - taken[:, :2]).T) - taken[:, 2:]
    assert (gaps >= radii).all()
    bodies = np.array([human.contact_radius for human in people])
    first, second = np.triu_indices(len(people), 1)
    apart = pdist(points) - bodies[first] - bodies[second]
    least = np.where(second < 40, spacing, 0.1)
    assert (apart >= least - 1e-12).all()
    goals = np.array([human.goals[0] for human in people[:40]])
    assert (shapely.distance(walls, shapely.points(goals)) >= radius).all()


def test_people_start_evenly_in_their_areas():
    rest = Area(rectangle=[0, 10, 20, 15])
    points = starts(
        drawn(cohort(500, start=[TRIANGLE, rest], spacing=0.0), seed=2)
    )
    triangle = shapely.Polygon(TRIANGLE.polygon)
    whole = triangle.union(shapely.box(0, 10, 20, 15))
    assert shapely.intersects_xy(whole, points).all()
    # Both are equally large.
    assert np.mean(points[:, 1] > 10) == pytest.approx(0.5, abs=0.07)
    x = points[points[:, 1] > 10, 0]
    assert stats.kstest(x / 20, "uniform").pvalue > 0.01
    # In the triangle, more are where it is wide.
    x = points[points[:, 1] < 10, 0]
    assert stats.kstest((x / 20) ** 2, "uniform").pvalue > 0.01


def test_behaviors_are_drawn_by_their_weights():
    weights = {"regular": 3, "scared": 1, "curious": 0}
    hall = Area(rectangle=[0, 0, 100, 100])
    people = drawn(cohort(1000, start=[hall], behaviors=weights))
    names = [human.behavior for human in people]
    counts = [names.count(name) for name in weights]
    assert sum(counts) == 1000
    assert counts[2] == 0
    assert stats.chisquare(counts[:2], [750, 250]).pvalue > 0.01


def groups_of(people):
    groups = {}
    for human in people:
        if human.group_id >= 0:
            groups.setdefault(human.group_id, []).append(human)
    return list(groups.values())


def test_people_of_a_group_walk_together():
    hall = Area(rectangle=[0, 0, 60, 60])
    kind = cohort(
        600, start=[hall], group_sizes=[5, 0, 3, 2], goals=[hall, hall]
    )
    people = drawn(kind, first_group_id=7)
    groups = groups_of(people)
    assert [g[0].group_id for g in groups] == list(range(7, 7 + len(groups)))
    sizes = [len(group) for group in groups[:-1]]
    assert set(sizes) == {3, 4}
    alone = sum(human.group_id < 0 for human in people)
    counts = [alone, sizes.count(3), sizes.count(4)]
    expected = np.array([5, 3, 2]) / 10 * sum(counts)
    assert stats.chisquare(counts, expected).pvalue > 0.01
    own = draw_bodies(kind, 0).speeds
    for group in groups:
        first = people.index(group[0])
        slowest = min(own[first : first + len(group)])
        assert {human.desired_speed for human in group} == {slowest}
        assert all(human.goals == group[0].goals for human in group)
        offsets = starts(group) - starts(group)[0]
        # Two bodies, the spacing, and the reach of a group of four.
        assert np.hypot(*offsets.T).max() < 0.5 + 0.1 + 0.3 * math.sqrt(3)
    assert len({tuple(human.goals) for human in people}) == alone + len(groups)


def test_the_last_group_is_as_large_as_people_are_left():
    people = drawn(cohort(7, group_sizes=[0, 0, 1]))
    assert [human.group_id for human in people] == [0, 0, 0, 1, 1, 1, -1]


def test_goals_are_in_their_areas_in_order():
    right = Area(rectangle=[15, 0, 20, 10])
    exit_ = Area(point=[25, 5])
    for human in drawn(cohort(goals=[right, exit_, TRIANGLE])):
        (x, _), last, (u, v) = human.goals
        assert 15 <= x <= 20
        assert last == (25, 5)
        assert v <= u / 2


def test_goals_may_have_another_order_for_each():
    points = [Area(point=[x, 5]) for x in (25, 26, 27)]
    people = drawn(cohort(60, goals=points, shuffle_goals=True))
    orders = {tuple(x for x, _ in human.goals) for human in people}
    assert len(orders) == 6


def test_people_look_where_they_go():
    for human in drawn(cohort(goals=[HALL])):
        way = np.subtract(human.goals[0], human.pose[:2])
        yaw = human.pose[2]
        np.testing.assert_allclose(
            [np.cos(yaw), np.sin(yaw)], way / np.hypot(*way)
        )


def test_those_without_goals_look_anywhere():
    yaws = [human.pose[2] for human in drawn(cohort(100))]
    scaled = (np.array(yaws) + np.pi) / (2 * np.pi)
    assert stats.kstest(scaled, "uniform").pvalue > 0.01


def test_what_a_cohort_says_is_so_of_all():
    said = {
        "radius": 0.5,
        "cyclic": True,
        "goal_radius": 0.7,
        "forces_mode": "random_normal",
        "body_radius": [0.3, 0.3],
    }
    for human in drawn(cohort(3, **said)):
        got = {k: getattr(human, k) for k in said}
        assert got == {**said, "body_radius": 0.3}


def test_bodies_are_drawn_between_two_radii():
    radii = draw_bodies(cohort(2000), 0).radii
    assert stats.kstest((radii - 0.2) / 0.05, "uniform").pvalue > 0.01


def test_no_room_is_told_of_each_cohort():
    closet = Area(rectangle=[0, 0, 1, 1])
    inside = Area(rectangle=[8.2, 3.2, 11.8, 6.8])
    with pytest.raises(PopulationError) as info:
        drawn(
            cohort(20, start=[closet]),
            cohort(3, start=[inside]),
            cohort(5),
            cohort(1, goals=[HALL, inside]),
            cohort(1, goals=[Area(point=[10, 5])]),
            obstacles=WALLS,
        )
    places = [fault[:3] for fault in info.value.faults]
    assert places == [
        (0, "start", None),
        (1, "start", None),
        (3, "goals", 1),
        (4, "goals", 0),
    ]
    first, second, third, fourth = str(info.value).splitlines()
    assert "cohorts[0].start: has room for " in first
    assert "of 20 people" in first
    assert "has room for 0 of 3 people" in second
    assert third.startswith("cohorts[3].goals[1]: has no place 0.35 m from")
    assert fourth == "cohorts[4].goals[0]: is inside a wall; move it"


def test_a_cohort_without_room_leaves_others_theirs():
    closet = Area(rectangle=[0, 0, 2, 2])
    with pytest.raises(PopulationError) as info:
        drawn(cohort(30, start=[closet]), cohort(3, start=[closet]))
    assert [fault.cohort for fault in info.value.faults] == [0]


def test_nobody_is_drawn_of_no_number():
    assert drawn(cohort(0), cohort(0, group_sizes=[0, 1])) == []


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"behaviors": {"regular": 0}}, "must have a weight above 0"),
        ({"group_sizes": []}, "at least 1"),
        ({"body_radius": [0.3, 0.2]}, "least and a largest radius, got 0.3"),
        ({"radius": 0.2}, "radius must be at least that of the largest body"),
        ({"start": [{"point": [0, 0]}]}, "a rectangle or a polygon, got a"),
        ({"start": [{}]}, "one of rectangle, polygon and point"),
        ({"start": [{"rectangle": [0, 0, 0, 1]}]}, "x_min < x_max"),
        (
            {"start": [{"polygon": [[0, 0], [1, 1], [1, 0], [0, 1]]}]},
            "must enclose an area, and not cross itself",
        ),
        ({"speed": {"mean": 1, "deviation": 0.4}}, "must be in .0, 10. m/s"),
        ({"ages": [{"low": 30, "high": 20}]}, "high must be at least low"),
        ({"ages": [{"low": 2, "high": 20}]}, "must be in .3, 80. years"),
    ],
)
def test_what_cannot_be_drawn_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        cohort(**values)


def test_two_cohorts_of_one_name_are_refused():
    twins = [cohort(name="guest"), cohort(3, name="guest")]
    with pytest.raises(ValueError, match="have the name 'guest'"):
        PopulationConfig(cohorts=twins)


def test_a_cohort_can_be_changed():
    kind = dataclasses.replace(cohort(), number=3)
    assert len(drawn(kind)) == 3
