"""The shortest way of a disc around walls."""

import math

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra
import shapely

from hunav_drake.systems.evaluation.shortest_way import shortest_ways
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.visibility_graph import blocked

PI = math.pi


def ways(start, goal, r, *shapes, solid=True):
    """Returns the ways around shapes, all solid or all thin walls."""
    walls = Obstacles.from_shapes(shapes, solid=[solid] * len(shapes))
    return shortest_ways(
        np.array(start, dtype=float), np.array(goal, dtype=float), r, walls
    )


def length(*args, **kwargs):
    return ways(*args, **kwargs)[0].length


def box(x, y, width, height, yaw=0.0):
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width, height]
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([x, y]) + corners / 2 @ np.array([[c, s], [-s, c]])


def tangent(distance, r):
    """Returns the length of a tangent, and its angle to the center line."""
    return math.sqrt(distance**2 - r**2), math.asin(r / distance)


def test_around_a_point_it_has_two_tangents_and_an_arc():
    leg, angle = tangent(2, 0.3)
    both = ways((0, 0), (4, 0), 0.3, [(2, 0)], solid=False)
    assert len(both) == 2
    for way in both:
        assert way.length == pytest.approx(2 * leg + 0.3 * 2 * angle, abs=1e-12)
        assert way.turning == pytest.approx(2 * angle, abs=1e-12)
    assert {round(way.first_heading % (2 * PI), 9) for way in both} == {
        round(angle, 9),
        round(2 * PI - angle, 9),
    }


@pytest.mark.parametrize(("height", "expected"), [(2.0, 6.1599), (0.0, 4.0451)])
def test_around_the_end_of_a_thin_wall_it_has_one_arc(height, expected):
    distance = math.hypot(2, height)
    leg, angle = tangent(distance, 0.3)
    below = math.atan2(height, 2)
    (way,) = ways((0, 0), (4, 0), 0.3, [(2, -9), (2, height)], solid=False)
    turn = 2 * (below + angle)
    assert way.length == pytest.approx(2 * leg + 0.3 * turn, abs=1e-12)
    assert way.length == pytest.approx(expected, abs=1e-4)
    assert way.turning == pytest.approx(turn, abs=1e-12)


def test_around_a_box_it_has_two_arcs():
    r = 0.3
    leg, angle = tangent(math.hypot(1, 1), r)
    turn = PI / 4 + angle
    both = ways((0, 0), (4, 0), r, box(2, 0, 2, 2))
    assert len(both) == 2
    for way in both:
        expected = 2 * leg + 2 + 2 * r * turn
        assert way.length == pytest.approx(expected, abs=1e-12)
        assert way.turning == pytest.approx(2 * turn, abs=1e-12)


def test_between_corners_on_two_sides_it_goes_along_the_inner_tangent():
    r = 0.3
    shapes = [[(2, -9), (2, 1)], [(5, -1), (5, 9)]]
    (way,) = ways((0, 0), (7, 0), r, *shapes, solid=False)
    leg, angle = tangent(math.hypot(2, 1), r)
    up = math.atan2(1, 2) + angle
    between = math.hypot(3, 2)
    down = math.atan2(2, 3) + math.asin(2 * r / between)
    inner = math.sqrt(between**2 - (2 * r) ** 2)
    expected = 2 * leg + inner + 2 * r * (up + down)
    assert way.length == pytest.approx(expected, abs=1e-12)
    assert way.turning == pytest.approx(2 * (up + down), abs=1e-12)


def test_a_wall_that_it_does_not_touch_changes_nothing():
    corner = [(2, -9), (2, 2), (9, 2), (9, -9)]
    (alone,) = ways((0, 0), (4, 5), 0.5, corner)
    # Across from the corner, in the middle of the arc, a tip with just the room
    # for the disc between, and with less.
    middle = (alone.first_heading + alone.last_heading + PI) / 2
    away = np.array([math.cos(middle), math.sin(middle)])
    across = np.array([-away[1], away[0]])
    tip = np.array([(0, 0), away + across / 5, away - across / 5])
    for distance, same in ((1.001, True), (0.999, False)):
        beside = tip + (2, 2) + distance * away
        found = ways((0, 0), (4, 5), 0.5, corner, beside)
        assert (found == [alone]) == same


@pytest.mark.parametrize(("gap", "passes"), [(0.599, False), (0.601, True)])
def test_a_gap_is_passed_by_a_disc_that_fits(gap, passes):
    shapes = [[(2, -5), (2, -gap / 2)], [(2, gap / 2), (2, 5)]]
    straight = length((0, 0), (4, 0), 0.3, *shapes, solid=False)
    assert (straight == pytest.approx(4)) == passes
    # So is one that lies askew.
    askew = length((0, 1), (4, -1), 0.3, *shapes, solid=False)
    assert (askew < 5) == passes


def test_it_leaves_a_wall_that_it_overlaps():
    # A wall that ends at the origin; the disc is nearer to it than it may be.
    # It goes straight to where the arc around the end begins.
    r = 0.3
    (way,) = ways((-1, 0.1), (-1, -0.1), r, [(-9, 0), (0, 0)], solid=False)
    leg, kink = math.hypot(1, r - 0.1), math.atan2(r - 0.1, 1)
    assert way.length == pytest.approx(2 * leg + r * PI, abs=1e-12)
    assert way.first_heading == pytest.approx(kink)
    assert way.turning == pytest.approx(PI + 2 * kink, abs=1e-12)
    # From inside of the circle it goes off at a right angle to the radius.
    (way,) = ways((-0.1, 0.1), (-0.1, -0.1), r, [(-9, 0), (0, 0)], solid=False)
    d = math.hypot(0.1, 0.1)
    out = math.acos(d / r)
    arc = 3 * PI / 2 - 2 * out
    expected = 2 * math.sqrt(r**2 - d**2) + r * arc
    assert way.length == pytest.approx(expected, abs=1e-12)
    assert way.turning == pytest.approx(arc + 2 * out, abs=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_to_overlap_a_wall_costs_no_more_than_to_leave_it(seed):
    _, goal, shapes = scene(seed)
    walls = shapely.union_all([shapely.Polygon(p) for p in shapes])
    ring = max(shapely.get_parts(walls.buffer(0.25)), key=shapely.area).exterior
    along = np.random.default_rng(seed).uniform(0, ring.length)
    line = shapely.shortest_line(ring.interpolate(along), walls)
    clear, wall = shapely.get_coordinates(line)
    inside, away = clear + 0.2 * (wall - clear), clear - 1e-6 * (wall - clear)
    (outside,) = ways(away, goal, 0.25, *shapes)
    for start, end in ((inside, goal), (goal, inside)):
        way = ways(start, end, 0.25, *shapes)[0]
        depth = math.dist(inside, away)
        assert abs(way.length - outside.length) <= depth + 1e-3


def test_it_does_not_leave_a_wall_through_it():
    """Beside a wall, the place that is clear may be behind it."""
    start, goal = (-1, 0.2), (0.4, 0.05)
    wedge = [(2, 0.5), (0, 0), (2, -0.5)]
    (way,) = ways(start, goal, 0.3, wedge, solid=False)
    # It goes around one arm, and comes to the goal on a straight leg.
    assert way.length > math.dist(start, wedge[0]) + math.dist(wedge[0], goal)
    assert way.length == pytest.approx(5.6091, abs=1e-4)
    # A slot, closed all around, in which nobody has room.
    slot = [(2, -1), (2.4, -1), (2.4, 1), (2, 1), (2, -1)]
    for x in (2.05, 2.2, 2.35):
        assert ways((0, 0), (x, 0), 0.3, slot, solid=False) == []


@pytest.mark.parametrize("clearance", [0.0, -1.0, math.nan])
def test_a_straight_way_needs_a_clearance(clearance):
    table = Obstacles.from_shapes([[(1, -1), (1, 1)]], solid=[False]).table
    p, q = np.array([[0.0, 0.0]]), np.array([[2.0, 0.0]])
    with pytest.raises(ValueError, match=r"clearance .* must be positive"):
        blocked(p, q, clearance, table)


PIECES = [
    ([(-1, 0), (0, 0), (0, 0.5), (0, 1.5), (-1, 1.5)],),
    (box(-0.5, 0.25, 1, 0.5), box(-0.5, 1.0, 1, 1)),
    (box(-0.5, 0.25, 1, 0.5), box(-0.5, 0.75, 1, 0.5), box(-0.5, 1.25, 1, 0.5)),
]


@pytest.mark.parametrize("pieces", PIECES, ids=len)
@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.0])
def test_a_wall_may_be_written_in_pieces(pieces, yaw):
    """The goal is nearer to the wall than the disc may be."""
    turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), 0]])
    turn[1, 1] = turn[0, 0]
    for x, start in ((0.26, -2.0), (0.4, -2.0), (-2.0, -1.0)):
        whole, parts = (
            ways((x, start) @ turn, (0.26, 1.4) @ turn, 0.5, *shapes)
            for shapes in (
                (box(-0.5, 0.75, 1, 1.5) @ turn,),
                [p @ turn for p in pieces],
            )
        )
        assert [(way.length, way.turning) for way in parts] == [
            pytest.approx((way.length, way.turning)) for way in whole
        ]


@pytest.mark.parametrize("angle", np.linspace(-3.1, 3.1, 25))
def test_walls_are_joined_whichever_way_their_pieces_lead(angle):
    along = np.array([math.cos(angle), math.sin(angle)])
    pieces = [[0 * along, along], [2 * along, along]]
    (wall,) = Obstacles.from_shapes(pieces, solid=[False] * 2).joined.segments
    assert math.dist(wall[:2], wall[2:]) == pytest.approx(2.0)


def test_walls_are_joined_where_they_go_straight_on():
    ends = [(0, 0), (1, 0)], [(2.5, 0), (1, 0)], [(1, 0), (1, 3)], [(4, 4)]
    walls = Obstacles.from_shapes([*ends, *ends], solid=[False] * 8).joined
    assert walls.segments.tolist() == [
        [0, 0, 2.5, 0],
        [1, 0, 1, 3],
        [4, 4, 4, 4],
    ]
    assert len(Obstacles.from_points([]).joined) == 0


def test_there_is_none_out_of_a_room_or_a_solid():
    room = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    assert ways((0, 0), (4, 0), 0.3, room, solid=False) == []
    assert ways((0, 0), (4, 0), 0.3, box(0, 0, 2, 2)) == []
    assert ways((4, 0), (0, 0), 0.3, box(0, 0, 2, 2)) == []


def buffered(start, goal, r, polygons):
    """Returns the length of the shortest way past shapely's wider shapes.

    It is found in the visibility graph of the many corners that stand for the
    arcs, so it is too long by little.
    """
    shapes = [shapely.Polygon(p) for p in polygons]
    wide = shapely.union_all([s.buffer(r, quad_segs=24) for s in shapes])
    points = np.vstack([[start, goal], shapely.get_coordinates(wide)])
    i, j = np.triu_indices(len(points), 1)
    lines = shapely.linestrings(np.stack([points[i], points[j]], axis=1))
    inner = wide.buffer(-1e-6)
    shapely.prepare(inner)
    free = ~shapely.intersects(inner, lines)
    d = np.zeros((len(points), len(points)))
    d[i[free], j[free]] = np.hypot(*(points[i[free]] - points[j[free]]).T)
    return float(dijkstra(d, directed=False, indices=0)[1])


def scene(seed):
    """Returns boxes between two places, in random directions."""
    rng = np.random.default_rng(seed)
    shapes = [
        box(*rng.uniform([-3, -3], [3, 3]), *rng.uniform(0.3, 2, 2), yaw)
        for yaw in rng.uniform(0, PI, 5)
    ]
    return (-5.0, rng.uniform(-2, 2)), (5.0, rng.uniform(-2, 2)), shapes


@pytest.mark.parametrize("seed", range(8))
def test_it_is_as_long_as_around_wider_shapes(seed):
    start, goal, shapes = scene(seed)
    found = length(start, goal, 0.25, *shapes)
    expected = buffered(start, goal, 0.25, shapes)
    assert found == pytest.approx(expected, rel=1e-3)


@settings(max_examples=30)
@given(
    st.integers(0, 2**32),
    st.floats(0, 2 * PI),
    st.booleans(),
    st.floats(-100, 100),
)
def test_it_is_the_same_turned_mirrored_and_back(seed, yaw, mirrored, shift):
    start, goal, shapes = scene(seed)
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, s], [-s, c]])
    if mirrored:
        turn = np.array([[1, 0], [0, -1]]) @ turn
    move = [np.array(p) @ turn + shift for p in (start, goal, *shapes)]
    (way,) = ways(start, goal, 0.25, *shapes)
    (moved,) = ways(move[0], move[1], 0.25, *move[2:])
    (back,) = ways(goal, start, 0.25, *shapes)
    assert moved.length == pytest.approx(way.length, abs=1e-9)
    assert moved.turning == pytest.approx(way.turning, abs=1e-6)
    assert back.length == pytest.approx(way.length, abs=1e-9)
    assert math.remainder(
        back.first_heading - way.last_heading - PI, 2 * PI
    ) == pytest.approx(0, abs=1e-6)
