from fractions import Fraction
import math

from hypothesis import assume, given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.crowd.walls.keep_out import (
    keep_out_of_walls,
    wall_margins,
)
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)
from hunav_drake.systems.world.shapes import Box, Polygon, Polyline, World

MARGIN = 0.1
FLOOR = Obstacles.from_shapes([[[-50.0, 0.0], [50.0, 0.0]]], solid=[False])
TABLE = World(walls=[Box(center=[0, 0], size=[2, 1])]).obstacles()


def propose(start, displacement):
    """Returns the states of one person before and after a step."""
    before = np.zeros((1, 6))
    before[0, :2] = start
    after = before.copy()
    after[0, :2] += displacement
    return before, after


def step_into_walls(
    obstacles, start, displacement, *, velocity=None, margin=MARGIN
):
    """Returns the state of one person after a step that would enter walls."""
    before, after = propose(start, displacement)
    after[0, 2] = 0.3
    after[0, 3:5] = displacement if velocity is None else velocity
    after[0, 5] = 0.7
    return keep_out_of_walls(
        before, after, np.array([margin]), obstacles.table
    )[0]


def clearance(obstacles, p):
    distances = nearest_points(obstacles, p) - np.asarray(p, dtype=float)
    return np.hypot(distances[..., 0], distances[..., 1]).min(initial=np.inf)


def crosses_exactly(p, q, segment):
    """Returns, in rational numbers, whether p to q passes through a segment."""
    px, py, qx, qy, ax, ay, bx, by = (
        Fraction(float(v)) for v in [*p, *q, *segment]
    )

    def side(x0, y0, x1, y1, x, y):
        value = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
        return (value > 0) - (value < 0)

    return (
        side(px, py, qx, qy, ax, ay) * side(px, py, qx, qy, bx, by) < 0
        and side(ax, ay, bx, by, px, py) * side(ax, ay, bx, by, qx, qy) < 0
    )


def assert_stays_outside(obstacles, start, displacement):
    start = np.asarray(start, dtype=float)
    state = step_into_walls(obstacles, start, displacement)
    assert np.isfinite(state).all()
    assert not inside(obstacles, state[:2]).any()
    for segment in obstacles.segments:
        assert not crosses_exactly(start, state[:2], segment)
    assert (
        clearance(obstacles, state[:2])
        >= min(clearance(obstacles, start), MARGIN) - 1e-9
    )
    most = math.hypot(*displacement) * (1 + 1e-9) + 1e-12
    assert math.hypot(*(state[:2] - start)) <= most
    assert math.hypot(*state[3:5]) <= most
    return state


coordinates = st.floats(-4, 4)
points = st.tuples(coordinates, coordinates)
boxes = st.builds(
    lambda center, size, yaw: Box(center=center, size=size, yaw=yaw),
    points,
    st.tuples(st.floats(0.02, 3), st.floats(0.02, 3)),
    st.floats(-3, 3) | st.sampled_from([0.0, math.pi / 2]),
)


@st.composite
def stars(draw):
    """Simple polygons, convex or not, in either direction."""
    radii = draw(st.lists(st.floats(0.2, 2), min_size=3, max_size=8))
    turn = 2 * math.pi / len(radii) * draw(st.sampled_from([1, -1]))
    x, y = draw(points)
    return Polygon(
        points=[
            (x + r * math.cos(i * turn), y + r * math.sin(i * turn))
            for i, r in enumerate(radii)
        ]
    )


polylines = st.lists(points, min_size=2, max_size=5).map(
    lambda line: Polyline(points=line)
)
rooms = st.lists(boxes | stars() | polylines, min_size=1, max_size=6).map(
    lambda walls: World(walls=walls).obstacles()
)
displacements = st.builds(
    lambda length, angle: np.array(
        [length * math.cos(angle), length * math.sin(angle)]
    ),
    st.floats(0, 5) | st.floats(0, 0.2),
    st.floats(-math.pi, math.pi),
)


@given(rooms, points, displacements)
def test_a_step_ends_outside_of_walls(obstacles, start, displacement):
    assume(not inside(obstacles, start).any())
    assume(clearance(obstacles, start) > 1e-6)
    assert_stays_outside(obstacles, start, displacement)


@given(
    rooms,
    st.integers(0, 100),
    st.floats(0, 1),
    st.sampled_from([1e-5, 0.03, MARGIN]),
    st.sampled_from([-1, 1]),
    displacements,
)
def test_a_step_along_a_wall_ends_outside_of_walls(
    obstacles, which, where, gap, side, displacement
):
    """Starts beside a wall, so that most steps meet it."""
    x0, y0, x1, y1 = obstacles.segments[which % len(obstacles.segments)]
    assume(math.hypot(x1 - x0, y1 - y0) > 1e-3)
    normal = np.array([y0 - y1, x1 - x0]) / math.hypot(x1 - x0, y1 - y0)
    start = np.array([x0, y0]) + where * np.array([x1 - x0, y1 - y0])
    start = start + side * gap * normal
    assume(not inside(obstacles, start).any())
    assume(clearance(obstacles, start) > 0.5e-5)
    assert_stays_outside(obstacles, start, displacement)


@given(
    boxes,
    st.lists(boxes | polylines, max_size=4),
    st.tuples(st.floats(-0.99, 0.99), st.floats(-0.99, 0.99)),
    displacements,
)
def test_whoever_starts_inside_ends_outside(box, others, where, displacement):
    obstacles = World(walls=[box, *others]).obstacles()
    a, b, _, d = box.vertices()
    u, v = (np.array(where) + 1) / 2
    start = a + u * (b - a) + v * (d - a)
    assume(inside(obstacles, start).any())
    state = step_into_walls(obstacles, start, displacement)
    np.testing.assert_array_equal(state[[2, 3, 4, 5]], [0.3, 0, 0, 0.7])
    if (state[:2] == start).all():
        # Thin walls may shut the solid off.
        assert any(isinstance(wall, Polyline) for wall in others)
    else:
        assert not inside(obstacles, state[:2]).any()
        assert clearance(obstacles, state[:2]) > MARGIN / 17


@given(rooms, points, displacements, st.floats(-3, 3), st.booleans())
def test_a_moved_world_moves_the_same_way(
    obstacles, start, displacement, angle, mirrored
):
    assume(not inside(obstacles, start).any())
    assume(clearance(obstacles, start) > 1e-3)
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1, -1 if mirrored else 1])
    turned = Obstacles(
        segments=(obstacles.segments.reshape(-1, 2) @ matrix.T).reshape(-1, 4),
        first=obstacles.first,
        solid=obstacles.solid,
    )
    plain = step_into_walls(obstacles, start, displacement)
    # A step that just touches, or just misses, may differ by what it loses.
    nearby = step_into_walls(
        obstacles, start, displacement, margin=MARGIN - 1e-7
    )
    assume(np.allclose(plain, nearby, atol=1e-5))
    moved = step_into_walls(turned, matrix @ start, matrix @ displacement)
    np.testing.assert_allclose(moved[:2], matrix @ plain[:2], atol=1e-9)
    np.testing.assert_allclose(moved[3:5], matrix @ plain[3:5], atol=1e-9)


@given(rooms, points, displacements)
def test_whoever_meets_no_wall_moves_exactly_as_proposed(
    obstacles, start, displacement
):
    assume(not inside(obstacles, start).any())
    way = np.asarray(start) + np.linspace(0, 1, 101)[:, None] * displacement
    distances = nearest_points(obstacles, way) - way[:, None]
    least = np.hypot(*distances.T).min()
    # Between two of the points looked at it may be nearer.
    assume(least > MARGIN + math.hypot(*displacement) / 200)
    state = step_into_walls(obstacles, start, displacement)
    expected = [*(np.asarray(start) + displacement), 0.3, *displacement, 0.7]
    np.testing.assert_array_equal(state, expected)


def test_a_step_into_a_wall_ends_at_the_margin_and_slides():
    state = step_into_walls(FLOOR, [0, 1.1], [3, -2], velocity=[0.6, -0.4])
    np.testing.assert_allclose(state, [3, 0.1, 0.3, 0.6, 0, 0.7], atol=1e-12)


def test_a_step_straight_at_a_wall_stops_there():
    state = step_into_walls(FLOOR, [0, 1.1], [0, -2])
    np.testing.assert_allclose(state[:2], [0, 0.1], atol=1e-12)
    np.testing.assert_allclose(state[3:5], 0, atol=1e-12)


def test_a_corner_of_a_room_stops_both_components():
    room = Obstacles.from_shapes([[[0, 5], [0, 0], [5, 0]]], solid=[False])
    state = step_into_walls(room, [1, 2], [-4, -3])
    np.testing.assert_allclose(state[:2], [0.1, 0.1], atol=1e-12)
    np.testing.assert_allclose(state[3:5], 0, atol=1e-12)


def test_a_step_past_a_corner_of_a_table_goes_around_its_arc():
    state = step_into_walls(TABLE, [-3, 0.55], [4, 0])
    # It meets the arc around (-1, 0.5) at 0.05 m above the corner.
    normal = np.array([-math.sqrt(0.75), 0.5])
    contact = np.array([-1, 0.5]) + 0.1 * normal
    rest = np.array([1 - contact[0], 0])
    expected = contact + rest - rest @ normal * normal
    np.testing.assert_allclose(state[:2], expected, atol=1e-12)


@pytest.mark.parametrize("angle", [0.05, 0.3, 1.0, 1.5])
def test_a_wedge_stops_at_its_narrow_end(angle):
    wedge = [
        [5 * math.cos(angle / 2), 5 * math.sin(angle / 2)],
        [0, 0],
        [5 * math.cos(angle / 2), -5 * math.sin(angle / 2)],
    ]
    obstacles = Obstacles.from_shapes([wedge], solid=[False])
    state = step_into_walls(obstacles, [4.9, 0], [-9, 0.0])
    narrow = MARGIN / math.sin(angle / 2)
    np.testing.assert_allclose(state[:2], [narrow, 0], atol=1e-9)
    np.testing.assert_allclose(state[3:5], 0, atol=1e-9)
    assert_stays_outside(obstacles, [4.9, 0], [-9, 1.0])


@pytest.mark.parametrize("length", [1e3, 1e6])
def test_an_enormous_step_passes_no_thin_wall(length):
    state = step_into_walls(FLOOR, [3, 2], [0, -length])
    np.testing.assert_allclose(state[:2], [3, 0.1], atol=1e-6)
    box = [[-5, -5], [5, -5], [5, 5], [-5, 5], [-5, -5]]
    room = Obstacles.from_shapes([box], solid=[False])
    state = assert_stays_outside(room, [0, 0], [length, 0.37 * length])
    assert np.abs(state[:2]).max() <= 5


def test_a_point_is_a_disc_of_the_margin():
    post = Obstacles.from_points([[2.0, 0.0]])
    state = step_into_walls(post, [0, 0], [4, 0])
    np.testing.assert_allclose(state[:2], [1.9, 0], atol=1e-12)
    assert_stays_outside(post, [0, 0.02], [4, 0])


def test_whoever_is_near_a_wall_comes_no_nearer():
    state = step_into_walls(FLOOR, [0, 0.03], [1, -0.5])
    np.testing.assert_allclose(state[:2], [1, 0.03], atol=1e-12)
    away = step_into_walls(FLOOR, [0, 0.03], [1, 0.5])
    np.testing.assert_array_equal(away[:2], [1, 0.53])


def test_nobody_creeps_nearer_step_by_step():
    state = np.array([0, 0.1])
    for _ in range(1000):
        state = step_into_walls(FLOOR, state[:2], [0.01, -0.2])
    assert state[0] == pytest.approx(10)
    assert state[1] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("offset", [-0.1, 0.0, 0.1])
def test_a_narrow_door_lets_people_through(offset):
    """A door of 0.8 m, and a person as wide as that who turns sideways."""
    margin = wall_margins([0.4])[0]
    door = World(
        walls=[
            Box(center=[0, 2.4], size=[0.2, 4]),
            Box(center=[0, -2.4], size=[0.2, 4]),
        ]
    ).obstacles()
    state = step_into_walls(door, [-1, offset], [2, 0], margin=margin)
    np.testing.assert_array_equal(state[:2], [1, offset])


def test_two_walls_nearer_than_the_margin_can_be_walked_between():
    gap = Obstacles.from_shapes(
        [[[-5, 0.05], [5, 0.05]], [[-5, -0.05], [5, -0.05]]], solid=[False] * 2
    )
    state = step_into_walls(gap, [0, 0], [1, 0.5])
    np.testing.assert_allclose(state[:2], [1, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("start", "expected"),
    [((0.3, 0.4), (0.3, 0.6)), ((-0.9, 0.1), (-1.1, 0.1))],
)
def test_somebody_inside_is_put_out_by_the_nearest_way(start, expected):
    state = step_into_walls(TABLE, start, [0.02, 0.01])
    np.testing.assert_allclose(state[:2], expected, atol=1e-12)
    np.testing.assert_array_equal(state[3:5], 0)


def test_the_direction_of_the_step_decides_between_equal_ways_out():
    for dy in (-0.1, 0.1):
        state = step_into_walls(TABLE, [0.2, 0], [0.05, dy])
        np.testing.assert_allclose(
            state[:2], [0.2, math.copysign(0.6, dy)], atol=1e-12
        )


def test_the_way_out_of_overlapping_tables_is_not_into_the_other():
    world = World(
        walls=[
            Box(center=[0, 0], size=[2, 1]),
            Box(center=[0, 0.75], size=[2, 1]),
        ]
    )
    state = step_into_walls(world.obstacles(), [0, 0.3], [0.1, 0])
    np.testing.assert_allclose(state[:2], [0, -0.6], atol=1e-12)


def test_the_way_out_of_a_cupboard_is_not_through_the_wall_behind():
    world = World(
        walls=[
            Box(center=[0, 0], size=[2, 1]),
            Polyline(points=[[-5, 0.52], [5, 0.52]]),
        ]
    )
    state = step_into_walls(world.obstacles(), [0, 0.4], [0, 0.1])
    # There is no room for the margin between the two, but for a little.
    assert 0.5 < state[1] < 0.52
    walled = World(
        walls=[
            Box(center=[0, 0], size=[2, 1]),
            Polyline(points=[[-5, 0.5], [5, 0.5]]),
        ]
    )
    state = step_into_walls(walled.obstacles(), [0, 0.4], [0, 0.1])
    assert state[1] < 0.5


@pytest.mark.parametrize("dy", [-0.1, 0.1])
def test_somebody_on_a_thin_wall_leaves_it_where_they_want_to(dy):
    state = step_into_walls(FLOOR, [1, 0], [0.05, dy])
    np.testing.assert_allclose(
        state[:2], [1, math.copysign(0.1, dy)], atol=1e-12
    )


def test_somebody_on_the_outline_of_a_table_leaves_it():
    state = step_into_walls(TABLE, [0.3, 0.5], [0, -0.3])
    np.testing.assert_allclose(state[:2], [0.3, 0.6], atol=1e-12)


def test_somebody_on_a_point_leaves_it():
    post = Obstacles.from_points([[2.0, 0.0]])
    for displacement in ([0, 0], [0, -0.3]):
        state = step_into_walls(post, [2, 0], displacement)
        assert clearance(post, state[:2]) == pytest.approx(0.1)


def test_somebody_with_no_way_out_stays_at_rest():
    """A table fills a box of thin walls exactly."""
    outline = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    obstacles = Obstacles.from_shapes(
        [outline, [*outline, outline[0]]], solid=[True, False]
    )
    state = step_into_walls(obstacles, [0.2, 0.3], [3, 0])
    np.testing.assert_array_equal(state, [0.2, 0.3, 0.3, 0, 0, 0.7])


def test_the_wall_on_the_way_of_the_slide_stops_it():
    """A post between the start and the end of the slide."""
    obstacles = Obstacles.from_shapes(
        [[[-5, 0], [5, 0]], [[0.5, 0.55], [0.5, 0.55]]], solid=[False] * 2
    )
    assert_stays_outside(obstacles, [0, 1], [1, -3])


def test_people_are_independent():
    rng = np.random.default_rng(5)
    before = np.zeros((40, 6))
    before[:, :2] = rng.uniform(-2, 2, (40, 2))
    after = before + rng.normal(size=(40, 6))
    walls = TABLE.table
    margins = np.linspace(0.01, 0.1, 40)
    together = keep_out_of_walls(before, after, margins, walls)
    for i in range(40):
        alone = keep_out_of_walls(
            before[i : i + 1], after[i : i + 1], margins[i : i + 1], walls
        )
        np.testing.assert_array_equal(together[i], alone[0])


def test_without_walls_or_people_nothing_happens():
    nothing = Obstacles.from_shapes([], solid=[])
    walls = nothing.table
    after = np.arange(12.0).reshape(2, 6)
    result = keep_out_of_walls(np.zeros((2, 6)), after, np.full(2, 0.1), walls)
    np.testing.assert_array_equal(result, after)
    assert keep_out_of_walls(
        np.zeros((0, 6)), np.zeros((0, 6)), np.zeros(0), walls
    ).shape == (0, 6)


def test_margins_follow_the_body_up_to_that_of_a_door():
    np.testing.assert_allclose(
        wall_margins([1e-4, 0.05, 0.25, 5.0]), [0.01, 0.04, 0.24, 0.29]
    )
