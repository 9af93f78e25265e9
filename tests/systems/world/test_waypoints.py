"""The hiders of corners are remembered, and never change people's ways."""

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.world import goal_ways, hidden, visibility_graph
from hunav_drake.systems.world.obstacles import Obstacles, inside
from hunav_drake.systems.world.routes import RouteMap
from tests.benchmarks.house import SIZE, house
from tests.systems.world.straight_ways import straight_ways

CLEARANCE = 0.3


@pytest.fixture(scope="module")
def world():
    return house(500)


def places(world, count, seed):
    """Places in the house, also in furniture and beside walls."""
    rng = np.random.default_rng(seed)
    return rng.uniform((0, 0), SIZE, (count, 2))


def unremembered(dut, p, goal):
    """The next waypoint, of a memory that knows nothing."""
    fresh = RouteMap(dut.obstacles, dut.sight, dut.vertices)
    return fresh.next_waypoint(p, goal)


@pytest.mark.slow
def test_what_is_remembered_changes_no_waypoint(world):
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    goals = places(world, 4, 1)
    walkers = places(world, 25, 2)
    rng = np.random.default_rng(3)
    for _ in range(6):
        walkers = walkers + rng.uniform(-0.15, 0.15, walkers.shape)
        for p in walkers:
            for goal in goals:
                np.testing.assert_array_equal(
                    dut.next_waypoint(p, goal), unremembered(dut, p, goal)
                )


def test_what_is_remembered_as_hidden_is_seen_from_nowhere_in_the_cell(world):
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    for p in places(world, 60, 4):
        dut.next_waypoint(p, (0.5, 0.5))
    cells, hiders = dut._hidden
    rng = np.random.default_rng(5)
    known = np.argwhere(hiders < 0)
    assert len(known) > 1000
    for place, vertex in known[rng.choice(len(known), 300)]:
        size = hidden._CELL
        starts = (cells[place] + rng.uniform(0, 1, (10, 2))) * size
        goals = np.tile(dut.vertices[vertex], (len(starts), 1))
        # Not even with hardly any clearance.
        assert visibility_graph.blocked(starts, goals, 1e-6, world.table).all()


def test_many_short_segments_hide_like_a_long_one():
    """As of a map of cells: none of them hides a corner from a whole cell."""
    x = np.linspace(-2, 2, 81)
    below, above = np.column_stack([x, 0 * x]), np.column_stack([x, 0 * x + 1])
    wall = np.concatenate([below, above[::-1]])
    world = Obstacles.from_shapes([wall], solid=[True])
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    dut.next_waypoint((0.1, -1.0), (0.4, 2.0))
    hiders = dut._hidden.hiders
    assert (hiders < 0).any()
    assert not (hiders > 0).any()


def test_the_memory_forgets_cells_and_stays_right(world, monkeypatch):
    """A memory of three cells, of which each takes the place of others."""
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    monkeypatch.setattr(hidden, "_MOST", 3 * len(dut.vertices))
    small = RouteMap(dut.obstacles, dut.sight, dut.vertices)
    assert len(small._hidden.cells) == 3
    for p in places(world, 60, 6):
        np.testing.assert_array_equal(
            small.next_waypoint(p, (15.0, 10.5)),
            dut.next_waypoint(p, (15.0, 10.5)),
        )


@given(
    st.lists(
        st.tuples(*4 * [st.floats(-4, 4)]), min_size=1, max_size=6, unique=True
    ),
    st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
)
@settings(max_examples=40)
def test_ways_are_those_that_vertices_see(rows, goal):
    boxes = [
        np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
        for x, y, w, h in np.round(rows, 3)
        if abs(w) > 0.1 and abs(h) > 0.1
    ]
    if not boxes:
        return
    world = Obstacles.from_shapes(boxes, solid=[True] * len(boxes))
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    for p in places(world, 4, 0) / 3 - 3:
        dut.next_waypoint(p, goal)
    assert_ways_are_right(dut)
    if not inside(world, np.array([goal])).any():
        np.testing.assert_array_equal(dut.next_waypoint(goal, goal), goal)


def test_ways_between_many_vertices_are_those_that_they_see(world):
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    for p in places(world, 40, 8):
        dut.next_waypoint(p, (15.0, 10.5))
    assert assert_ways_are_right(dut) > len(dut.vertices) / 2


def assert_ways_are_right(dut):
    """Compares what is known of vertices; returns the number of these."""
    m = len(dut.vertices)
    sees = np.zeros((m, m), dtype=bool)
    i, j = straight_ways(dut)[:, :2].astype(int).T
    sees[i, j] = sees[j, i] = True
    graph = dut._graph
    (known,) = (graph.counts >= 0).nonzero()
    for v in known:
        (expected,) = sees[v].nonzero()
        np.testing.assert_array_equal(
            graph.seen[v, : graph.counts[v]], expected
        )
    return len(known)


def test_vertices_that_see_very_many_lead_the_same_way(world, monkeypatch):
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    monkeypatch.setattr(goal_ways, "_MOST_SEEN", 3)
    small = RouteMap(dut.obstacles, dut.sight, dut.vertices)
    for p in places(world, 40, 9):
        np.testing.assert_array_equal(
            small.next_waypoint(p, (15.0, 10.5)),
            dut.next_waypoint(p, (15.0, 10.5)),
        )
    assert (small._graph.counts == goal_ways._MANY).any()
