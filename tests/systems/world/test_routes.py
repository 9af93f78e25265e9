import itertools
import math

from hypothesis import assume, given, settings, strategies as st
import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap
from hunav_drake.systems.world.shapes import Box, Polygon, Polyline, World
from tests.systems.world.straight_ways import straight_ways

CLEARANCE = 0.3

# The length of a step of a walker, in meters.
STRIDE = 0.06


def thin_walls(*lines):
    return [Polyline(points=line) for line in lines]


def frame(width, height):
    """Four thick walls around a room from (0, 0) to (width, height)."""
    x, y = width / 2, height / 2
    return [
        Box(center=[x, -0.1], size=[width + 0.4, 0.2]),
        Box(center=[x, height + 0.1], size=[width + 0.4, 0.2]),
        Box(center=[-0.1, y], size=[0.2, height + 0.4]),
        Box(center=[width + 0.1, y], size=[0.2, height + 0.4]),
    ]


# name: walls, start, goal
WORLDS = {
    "inside a U": (
        thin_walls([[0, 2], [4, 2], [4, -2], [0, -2]]),
        (3.5, 0.3),
        (7, 0),
    ),
    "two rooms with a door": (
        [
            *frame(10, 6),
            Box(center=[5, 2], size=[0.2, 4]),
            Box(center=[5, 5.4], size=[0.2, 1.2]),
        ],
        (1, 1),
        (9, 1),
    ),
    "maze": (
        [
            *frame(9, 9),
            *thin_walls(
                [[1.5, 0], [1.5, 3]],
                [[1.5, 4.5], [1.5, 7.5]],
                [[3, 1.5], [3, 6]],
                [[3, 6], [1.5, 6]],
                [[3, 1.5], [4.5, 1.5]],
                [[6, 0], [6, 1.5]],
                [[4.5, 3], [4.5, 4.5]],
                [[4.5, 3], [7.5, 3]],
                [[7.5, 1.5], [7.5, 3]],
                [[6, 4.5], [9, 4.5]],
                [[4.5, 6], [6, 6]],
                [[4.5, 6], [4.5, 7.5]],
                [[3, 7.5], [4.5, 7.5]],
                [[3, 7.5], [3, 9]],
                [[7.5, 6], [7.5, 9]],
                [[6, 7.5], [6, 9]],
            ),
        ],
        (0.7, 0.7),
        (8.2, 8.2),
    ),
    "corner of a corridor": (
        thin_walls([[0, 0], [12, 0], [12, 12]], [[0, 2], [10, 2], [10, 12]]),
        (1, 1.2),
        (11, 11),
    ),
    "furniture": (
        [
            *frame(8, 6),
            Box(center=[2, 3], size=[1.2, 3.5], yaw=0.2),
            Box(center=[4.2, 1.2], size=[1.5, 1.5], yaw=0.8),
            Box(center=[4.5, 4], size=[0.8, 2.4]),
            Box(center=[4.9, 3], size=[1.6, 0.5]),
            Polygon(points=[[6.5, 1], [7, 2.5], [6.3, 4.6], [6.0, 2.4]]),
        ],
        (0.6, 3),
        (7.5, 2.6),
    ),
}


def make_map(walls, clearance=CLEARANCE):
    obstacles = World(walls=walls).obstacles()
    return RouteMap.from_obstacles(obstacles, clearance=clearance)


def lengths(dut):
    """The lengths of the shortest ways between the vertices."""
    m = len(dut.vertices)
    ways = straight_ways(dut)
    i, j = ways[:, :2].astype(np.int32).T
    graph = coo_array((ways[:, 2], (i, j)), shape=(m, m))
    return dijkstra(graph.tocsr(), directed=False)


def clearances(dut, points):
    obstacles = dut.obstacles
    points = np.asarray(points, dtype=float)
    d = nearest_points(obstacles, points) - points[:, None]
    return np.hypot(d[..., 0], d[..., 1]).min(axis=1, initial=np.inf)


def assert_same_points(points, expected):
    """Compares two sets of points, in any order."""
    in_order = [
        np.array(sorted(np.round(p, 9).tolist())) for p in (points, expected)
    ]
    np.testing.assert_allclose(*in_order, atol=1e-8)


def follow_route(dut, start, goal, *, steps=2000):
    """Returns the points of a walk that asks for the way at every step."""
    p = np.array(start, dtype=float)
    goal = np.asarray(goal, dtype=float)
    trace = [p]
    for _ in range(steps):
        ahead = dut.next_waypoint(p, goal) - p
        distance = math.hypot(*ahead)
        if distance == 0:
            break
        p = p + ahead * min(1.0, STRIDE / distance)
        trace.append(p)
        if (p == goal).all():
            break
    return np.array(trace)


def length_of(trace):
    return np.hypot(*np.diff(trace, axis=0).T).sum()


def grid_length(dut, start, goal, clearance, spacing=0.1):
    """Returns the length of the shortest way on a fine grid with 32 moves.

    From the ends, it goes straight to the nearest points of the grid.
    """
    extent = np.vstack([dut.obstacles.segments.reshape(-1, 2), start, goal])
    low, high = extent.min(axis=0) - 1, extent.max(axis=0) + 1
    shape = tuple(np.ceil((high - low) / spacing).astype(int) + 1)
    i, j = np.indices(shape)
    points = low + spacing * np.stack([i, j], axis=-1)
    obstacles = dut.obstacles
    free = clearances(dut, points.reshape(-1, 2)) >= clearance
    free &= ~inside(obstacles, points.reshape(-1, 2)).any(axis=-1)
    free = free.reshape(shape)
    number = np.arange(free.size, dtype=np.int32).reshape(shape)
    rows, columns, lengths = [], [], []
    moves = [
        (a, b)
        for a, b in itertools.product(range(4), range(-3, 4))
        if math.gcd(a, b) == 1 and (a > 0 or b > 0)
    ]
    for a, b in moves:
        here = (slice(0, shape[0] - a), slice(max(0, -b), shape[1] - max(0, b)))
        there = (slice(a, shape[0]), slice(max(0, b), shape[1] + min(0, b)))
        both = free[here] & free[there]
        rows.append(number[here][both])
        columns.append(number[there][both])
        lengths.append(np.full(both.sum(), spacing * math.hypot(a, b)))
    graph = coo_array(
        (
            np.concatenate(lengths),
            (np.concatenate(rows), np.concatenate(columns)),
        ),
        shape=(free.size, free.size),
    ).tocsr()
    flat = points.reshape(-1, 2)
    ends = [
        np.argmin(np.where(free.ravel(), np.hypot(*(flat - end).T), np.inf))
        for end in (start, goal)
    ]
    on_grid = dijkstra(graph, directed=False, indices=ends[0])[ends[1]]
    return on_grid + sum(
        math.dist(flat[index], end)
        for index, end in zip(ends, (start, goal), strict=True)
    )


@pytest.fixture(scope="module", params=WORLDS)
def world(request):
    walls, start, goal = WORLDS[request.param]
    return make_map(walls), np.array(start), np.array(goal)


def test_a_walker_arrives_on_nearly_the_shortest_way(world):
    dut, start, goal = world
    trace = follow_route(dut, start, goal)
    np.testing.assert_array_equal(trace[-1], goal)
    shortest = grid_length(dut, start, goal, dut.sight)
    assert length_of(trace) <= 1.05 * shortest
    assert length_of(trace) > 1.2 * math.hypot(*(goal - start))


def test_a_walker_keeps_clear_of_the_walls(world):
    trace = follow_route(*world)
    assert clearances(world[0], trace).min() >= world[0].sight - 0.01


def test_a_walker_never_turns_back(world):
    steps = np.diff(follow_route(*world)[:-1], axis=0)
    directions = steps / np.hypot(*steps.T)[:, None]
    # A way around the end of a thin wall turns by half a turn in three.
    assert (directions[1:] * directions[:-1]).sum(axis=1).min() > -0.1


def test_the_way_back_is_as_long(world):
    dut, start, goal = world
    there = length_of(follow_route(dut, start, goal))
    assert length_of(follow_route(dut, goal, start)) == pytest.approx(
        there, abs=0.3
    )


@pytest.mark.parametrize("dt", [0.05, 0.2])
def test_a_walker_with_inertia_arrives_too(world, dt):
    """Accelerates to the waypoint as the social force model does."""
    dut, p, goal = world
    v = np.zeros(2)
    length = 0.0
    while math.hypot(*(goal - p)) > 0.3:
        ahead = dut.next_waypoint(p, goal) - p
        v = v + dt / 0.25 * (1.2 * ahead / math.hypot(*ahead) - v)
        p = p + v * dt
        length += math.hypot(*v) * dt
        assert length < 100
    assert length <= 1.1 * grid_length(dut, *world[1:], dut.sight)


@pytest.mark.parametrize("width", [0.7, 0.8, 1.0])
def test_a_way_leads_through_doors_from_70_cm(width):
    clearance = route_clearance([0.25, 0.4])
    dut = make_map(
        [
            *frame(8, 4),
            Box(center=[4, 0.75], size=[0.2, 1.5]),
            Box(center=[4, 2.75 + width / 2], size=[0.2, 2.5 - width]),
        ],
        clearance,
    )
    for goal in ([6, 0.5], [6, 3.5], [4.5, 0.4], [6, 1.5 + width / 2]):
        trace = follow_route(dut, [1, 1], goal)
        np.testing.assert_array_equal(trace[-1], goal)
        through = trace[np.abs(trace[:, 0] - 4) < 0.1, 1]
        assert (through > 1.5 + 0.25).all()
        assert (through < 1.5 + width - 0.25).all()


def test_a_door_narrower_than_the_body_is_no_way():
    dut = make_map(
        [
            Box(center=[4, -5.2], size=[0.2, 10]),
            Box(center=[4, 5.2], size=[0.2, 10]),
        ]
    )
    waypoint = dut.next_waypoint([1, 0], [7, 0.0])
    assert abs(waypoint[1]) > 9


def test_a_way_leads_diagonally_between_two_corners():
    """A gap of 0.62 m that has no room for the usual points of a bend."""
    gap = 0.62 / math.sqrt(2)
    dut = make_map(
        [
            Box(center=[-10, -10], size=[20, 20]),
            Box(center=[10 + gap, 10 + gap], size=[20, 20]),
        ]
    )
    trace = follow_route(dut, [-3, 1], [1, -3])
    np.testing.assert_array_equal(trace[-1], [1, -3])


def test_the_goal_itself_is_the_waypoint_where_the_way_is_free():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    goal = np.array([4.0, 1.0 + CLEARANCE])
    np.testing.assert_array_equal(
        dut.next_waypoint([-4, 1 + CLEARANCE], goal), goal
    )


def test_the_straight_way_is_as_wide_as_the_body():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    y = 1 + 0.9 * dut.sight
    waypoint = dut.next_waypoint([-4, y], [4, y])
    np.testing.assert_allclose(waypoint, [-1.3, 1.3])


def test_the_next_corner_comes_in_sight_before_one_is_reached():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    p = np.array([-0.5, 1.3])
    np.testing.assert_allclose(dut.next_waypoint(p, [0, -3]), [-1.3, 1.3])
    p = np.array([-1.29, 1.3])
    np.testing.assert_allclose(dut.next_waypoint(p, [0, -3]), [-1.3, -1.3])
    p = np.array([-1.3, 1.3])
    np.testing.assert_allclose(dut.next_waypoint(p, [0, -3]), [-1.3, -1.3])


@pytest.mark.parametrize("gap", [1e-3, 0.1, 0.25])
def test_people_and_goals_beside_walls_have_ways(gap):
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    trace = follow_route(dut, [0.2, 1 + gap], [-0.1, -1 - gap])
    np.testing.assert_array_equal(trace[-1], [-0.1, -1 - gap])
    # The way past the two corners on the right is the shorter one.
    corners = np.array([[0.2, 1 + gap], [1.3, 1.3], [1.3, -1.3], trace[-1]])
    assert length_of(trace) <= length_of(corners) + STRIDE


def test_a_goal_inside_furniture_is_approached_from_the_nearest_side():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    goal = np.array([0.7, 0.1])
    # From behind: around the corner, then in front of the nearest side.
    assert dut.next_waypoint([-3, 0], goal)[0] == pytest.approx(-1.3)
    place = np.array([1 + dut.sight, 0.1])
    np.testing.assert_allclose(dut.next_waypoint([3, 1.5], goal), place)
    # There, people lean on it.
    np.testing.assert_array_equal(dut.next_waypoint(place, goal), goal)


def test_a_goal_inside_furniture_is_not_approached_through_the_wall():
    dut = make_map([*frame(6, 6), Box(center=[3, 5.6], size=[2, 0.8])])
    # The wall's other side is nearer than the front of the cupboard.
    waypoint = dut.next_waypoint([1, 1], [3, 5.7])
    np.testing.assert_allclose(waypoint, [3, 5.2 - dut.sight])


def test_a_goal_without_a_way_is_walked_to_straight():
    dut = make_map(frame(6, 6))
    np.testing.assert_array_equal(dut.next_waypoint([3, 3], [9, 3]), [9, 3])
    # Also from inside a solid.
    np.testing.assert_array_equal(dut.next_waypoint([-0.1, 1], [9, 3]), [9, 3])


def test_points_stop_no_way():
    obstacles = Obstacles.from_points([[0, 0], [1, 0.1]])
    dut = RouteMap.from_obstacles(obstacles)
    assert len(dut.vertices) == len(dut.obstacles.segments) == 0
    np.testing.assert_array_equal(dut.next_waypoint([-3, 0], [3, 0]), [3, 0])


def test_points_among_walls_stop_no_way():
    box = Box(center=[0, 0], size=[2, 2]).vertices()
    line = [[5.0, -1.0], [5.0, -1.0], [5.0, 1.0]]
    obstacles = Obstacles.from_shapes(
        [[[-2, 0.0]], box, [[-2.1, 0.3]], line],
        solid=[False, True, False, False],
    )
    dut = RouteMap.from_obstacles(obstacles, clearance=CLEARANCE)
    plain = make_map(
        [Box(center=[0, 0], size=[2, 2]), *thin_walls([[5, -1], [5, 1]])]
    )
    np.testing.assert_allclose(dut.vertices, plain.vertices)
    np.testing.assert_allclose(lengths(dut), lengths(plain))


def test_corners_buried_in_another_wall_are_no_waypoints():
    dut = make_map(
        [Box(center=[2, 0], size=[4, 1]), Box(center=[4, 0], size=[1, 4])]
    )
    expected = [[-0.3, y] for y in (-0.8, 0.8)]
    expected += [[x, y] for x in (3.2, 4.8) for y in (-2.3, 2.3)]
    assert_same_points(dut.vertices, expected)


@pytest.mark.parametrize("clockwise", [False, True])
def test_only_convex_corners_of_a_solid_are_waypoints(clockwise):
    points = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [0, 3]]
    dut = make_map([Polygon(points=points[:: -1 if clockwise else 1])])
    assert len(dut.vertices) == 5
    assert not (np.hypot(*(dut.vertices - [1, 1]).T) < 0.5).any()


def test_a_thin_wall_is_walked_around_at_its_bends_and_ends():
    dut = make_map(thin_walls([[0, 0], [4, 0], [4, 3]]))
    expected = [
        *([-0.3, 0.3], [-0.3, -0.3], [4.3, -0.3]),
        *([3.7, 3.3], [4.3, 3.3]),
    ]
    assert_same_points(dut.vertices, expected)


def test_lengths_are_those_of_the_shortest_ways():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    np.testing.assert_allclose(
        np.sort(lengths(dut), axis=1), [[0, 2.6, 2.6, 5.2]] * 4
    )


def test_people_asked_for_together_get_the_same_waypoints():
    walls = WORLDS["furniture"][0]
    dut = make_map(walls)
    rng = np.random.default_rng(3)
    positions = rng.uniform(0, 8, (50, 2))
    goals = rng.uniform(0, 6, (50, 2))
    command = np.zeros((50, COMMAND_SIZE))
    command[:, :2] = goals
    command[:, Command.HAS_GOAL] = 1
    together = dut.guide(positions, command)[:, :2]
    assert ((together != goals).any(axis=1)).sum() > 10
    for i in range(50):
        fresh = (
            RouteMap(dut.obstacles, dut.sight, dut.vertices) if i < 3 else dut
        )
        np.testing.assert_array_equal(
            fresh.next_waypoint(positions[i], goals[i]), together[i]
        )


def test_many_goals_change_nothing():
    """The memory of goals is bounded, and is no state."""
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    first = dut.next_waypoint([-3, 0], [3, 0.5])
    goals = np.column_stack([np.full(3000, 3.0), np.linspace(-0.5, 0.5, 3000)])
    for goal in goals:
        dut.next_waypoint([-3, 0], goal)
    assert dut._goals.cache_info().currsize == 1
    np.testing.assert_array_equal(dut.next_waypoint([-3, 0], [3, 0.5]), first)


def test_guided_people_do_not_stop_at_waypoints():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    command = np.tile(np.arange(COMMAND_SIZE) + 0.5, (5, 1))
    command[:, Command.GOAL_RADIUS] = 0.4
    command[:, :2] = [[3, 0], [3, 0], [0, 3], [1.2, 0], [0, 0.9]]
    command[1, Command.HAS_GOAL] = 0
    states = np.zeros((5, 6))
    states[:, :2] = [[-3, 0.1], [-3, 0.1], [-3, 0.1], [1.5, 0], [0, 1.2]]
    before = command.copy()
    result = dut.guide(states, command)
    np.testing.assert_array_equal(command, before)
    # A waypoint; no goal; the goal is in sight; nearly; arrived.
    expected = before.copy()
    expected[0, :3] = -1.3, 1.3, 0
    np.testing.assert_allclose(result, expected)


def test_commands_stay_as_they_are_where_all_ways_are_free():
    dut = make_map([Box(center=[0, 0], size=[2, 2])])
    command = np.zeros((2, COMMAND_SIZE))
    command[:, :4] = 4, -3, 0.3, 1
    assert dut.guide(np.full((2, 6), 3.0), command) is command


def test_without_walls_every_way_is_straight():
    dut = RouteMap.from_obstacles(Obstacles.from_shapes([], solid=[]))
    goals = np.arange(6.0).reshape(3, 2)
    for goal in goals:
        np.testing.assert_array_equal(dut.next_waypoint([0, 0], goal), goal)
    nobody = np.zeros((0, COMMAND_SIZE))
    assert dut.guide(np.zeros((0, 2)), nobody) is nobody


def test_the_clearance_follows_the_largest_radius_up_to_30_cm():
    assert route_clearance([0.2, 0.25]) == 0.25
    assert route_clearance([0.2, 0.4]) == 0.3


@pytest.mark.parametrize("clearance", [0.0, -1.0, math.nan, math.inf])
def test_a_clearance_that_is_not_positive_is_refused(clearance):
    with pytest.raises(ValueError, match="clearance must be positive"):
        make_map([], clearance)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_moved_world_has_the_same_ways(mirrored):
    walls, start, goal = WORLDS["furniture"]
    obstacles = World(walls=walls).obstacles()
    c, s = math.cos(0.7), math.sin(0.7)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1, -1 if mirrored else 1])
    turned = Obstacles(
        segments=(obstacles.segments.reshape(-1, 2) @ matrix.T).reshape(-1, 4),
        first=obstacles.first,
        solid=obstacles.solid,
    )
    plain = RouteMap.from_obstacles(obstacles, clearance=CLEARANCE)
    moved = RouteMap.from_obstacles(turned, clearance=CLEARANCE)
    for p in follow_route(plain, start, goal)[::10]:
        np.testing.assert_allclose(
            moved.next_waypoint(matrix @ p, matrix @ goal),
            matrix @ plain.next_waypoint(p, goal),
            atol=1e-9,
        )


points = st.tuples(st.floats(0, 6), st.floats(0, 6))
furniture = st.lists(
    st.builds(
        lambda center, size, yaw: Box(center=center, size=size, yaw=yaw),
        points,
        st.tuples(st.floats(0.1, 3), st.floats(0.1, 2)),
        st.floats(-2, 2) | st.just(0.0),
    )
    | st.lists(points, min_size=2, max_size=4).map(
        lambda line: Polyline(points=line)
    ),
    min_size=1,
    max_size=6,
)


@settings(max_examples=40)
@given(furniture, points, points)
def test_a_walker_arrives_in_any_room(walls, start, goal):
    dut = make_map(walls)
    obstacles = dut.obstacles
    ends = np.array([start, goal])
    assume(not inside(obstacles, ends).any())
    assume((clearances(dut, ends) > CLEARANCE).all())
    assume(math.hypot(*(ends[1] - ends[0])) > 0.5)
    # With a little more room than needed, for the grid is coarse.
    shortest = grid_length(dut, *ends, CLEARANCE + 0.06)
    assume(np.isfinite(shortest))
    trace = follow_route(dut, start, goal)
    np.testing.assert_array_equal(trace[-1], goal)
    assert length_of(trace) <= 1.03 * shortest + 0.15


@pytest.mark.slow
def test_many_close_corners_lead_around_as_few_do():
    """Four hundred around a post, a millimetre from each other."""
    angles = 2 * np.pi * np.arange(400) / 400
    ring = 0.07 * np.column_stack([np.cos(angles), np.sin(angles)])
    few = RouteMap.from_obstacles(
        Obstacles.from_shapes([ring[::40]], solid=[True]), clearance=CLEARANCE
    )
    dut = RouteMap.from_obstacles(
        Obstacles.from_shapes([ring], solid=[True]), clearance=CLEARANCE
    )
    assert len(dut.vertices) == 400
    for goal in ([1.0, 0.2], [-1.0, 0.1]):
        one = dut.next_waypoint([-goal[0], 0.0], goal)
        other = few.next_waypoint([-goal[0], 0.0], goal)
        assert one == pytest.approx(other, abs=0.1)
