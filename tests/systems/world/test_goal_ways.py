"""Ways to goals are found piece by piece, and are those of a whole search."""

import functools

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.world import goal_ways, waypoints
from hunav_drake.systems.world.obstacles import Obstacles, inside
from hunav_drake.systems.world.routes import RouteMap
from hunav_drake.systems.world.visibility_graph import SQUEEZED, blocked
from tests.benchmarks.house import SIZE, house
from tests.systems.world.straight_ways import straight_ways

CLEARANCE = 0.3

ways_of = functools.lru_cache(maxsize=1)(straight_ways)


def seen(dut, p, points, clearance):
    """Which points (m, 2) are seen from p, shape (m,)."""
    starts = np.tile(np.asarray(p, dtype=float), (len(points), 1))
    return ~blocked(starts, points, clearance, dut.obstacles.table)


def lengths_to(dut, goal):
    """The lengths of the ways from all vertices to a goal, found at once."""
    m = len(dut.vertices)
    for clearance in (dut.sight, SQUEEZED * dut.sight):
        near = np.flatnonzero(seen(dut, goal, dut.vertices, clearance))
        if len(near):
            break
    legs = np.hypot(*(dut.vertices[near] - goal).T)
    ways = ways_of(dut)
    i, j = ways[:, :2].astype(np.int32).T
    graph = coo_array(
        (
            np.concatenate([ways[:, 2], legs]),
            (np.append(i, np.full(len(near), m)), np.append(j, near)),
        ),
        shape=(m + 1, m + 1),
    ).tocsr()
    return dijkstra(graph, directed=False, indices=m)[:m], clearance


def expected_waypoint(dut, p, goal):
    """The next waypoint, of all vertices and for this question alone."""
    if not seen(dut, p, np.array([goal]), dut.sight)[0]:
        lengths, last = lengths_to(dut, goal)
        if last != dut.sight and seen(dut, p, np.array([goal]), last)[0]:
            return goal
        legs = np.hypot(*(dut.vertices - p).T)

        def choice(clearance):
            found = -1
            in_sight = seen(dut, p, dut.vertices, clearance)
            ways = np.where(in_sight, legs + lengths, np.inf)
            for i in np.argsort(ways, kind="stable"):
                if ways[i] == np.inf or (
                    found >= 0 and ways[i] > ways[found] + 1e-9
                ):
                    break
                if found < 0 or legs[i] > legs[found]:
                    found = i
            return found

        best = choice(dut.sight)
        if best >= 0 and legs[best] < 2 * dut.sight:
            other = choice(waypoints._SLACK * dut.sight)
            if waypoints._turns_back(
                *p, *dut.vertices[best], *dut.vertices[other], dut.sight
            ):
                best = other
        if best < 0:
            best = choice(SQUEEZED * dut.sight)
        if best >= 0:
            return dut.vertices[best]
    return goal


def places(world, size, count, seed):
    """Places outside of solids, shape (about count, 2)."""
    p = np.random.default_rng(seed).uniform((0, 0), size, (count, 2))
    return p[~inside(world, p).any(axis=1)]


@pytest.mark.parametrize("segments", [200, 600])
def test_waypoints_are_those_of_a_search_through_the_whole_world(segments):
    world = house(segments)
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    goals = places(world, SIZE, 12, 1)
    turned = 0
    for p in places(world, SIZE, 40, 2):
        for goal in goals:
            expected = expected_waypoint(dut, p, goal)
            np.testing.assert_array_equal(dut.next_waypoint(p, goal), expected)
            turned += (expected != goal).any()
    assert turned > 200


@given(
    st.lists(
        st.tuples(*4 * [st.integers(-8, 8)]),
        min_size=1,
        max_size=8,
        unique=True,
    ),
    st.lists(st.tuples(*2 * [st.integers(-10, 10)]), min_size=2, max_size=6),
)
@settings(max_examples=40)
def test_equal_ways_are_told_apart_alike(rows, places):
    """In a grid of places, many ways have the same length."""
    boxes = [
        np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]) / 2
        for x, y, w, h in rows
        if w and h
    ]
    if not boxes:
        return
    world = Obstacles.from_shapes(boxes, solid=[True] * len(boxes))
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    free = np.array(places) / 2
    free = free[~inside(world, free).any(axis=1)]
    for p in free:
        for goal in free:
            if (p != goal).any() and len(dut.vertices):
                np.testing.assert_array_equal(
                    dut.next_waypoint(p, goal), expected_waypoint(dut, p, goal)
                )


def test_lengths_are_those_of_a_search_through_the_whole_world():
    world = house(600)
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    goals = places(world, SIZE, 8, 3)
    for p in places(world, SIZE, 30, 4):
        for goal in goals:
            dut.next_waypoint(p, goal)
    known = dut._goals(1024)
    count = 0
    for at in np.flatnonzero(known.used[:-1]):
        final = known.states[at] == goal_ways._FINAL
        lengths, _ = lengths_to(dut, known.places[at, :2])
        np.testing.assert_allclose(
            known.lengths[at, final], lengths[final], rtol=1e-14
        )
        count += final.sum()
    assert count > 1000


def test_a_near_goal_is_found_without_a_search_through_the_world():
    world = house(2000)
    dut = RouteMap.from_obstacles(world, clearance=CLEARANCE)
    goal = np.array([5.0, 4.0])
    assert (dut.next_waypoint([7.0, 4.2], goal) != goal).any()
    states = dut._goals(1024).states
    assert 0 < (states != goal_ways._UNTRIED).sum() < len(dut.vertices) / 4


def test_the_memory_has_room_for_the_goals_of_everybody():
    dut = RouteMap.from_obstacles(house(200), clearance=CLEARANCE)
    n = 3000
    command = np.zeros((n, COMMAND_SIZE))
    command[:, :2] = np.random.default_rng(5).uniform((0, 0), SIZE, (n, 2))
    command[:, Command.HAS_GOAL] = 1
    positions = np.random.default_rng(6).uniform((0, 0), SIZE, (n, 2))
    dut.guide(positions, command)
    (known,) = (dut._goals(size) for size in (8192,))
    before = known.states.copy()
    asked = known.used[-1]
    assert asked > 2000
    assert (known.used[:-1] > 0).sum() == asked
    dut.guide(positions, command)
    np.testing.assert_array_equal(known.states, before)
    assert known.used[-1] == 2 * asked


def test_a_goal_that_takes_the_place_of_another_changes_nothing(monkeypatch):
    dut = RouteMap.from_obstacles(house(200), clearance=CLEARANCE)
    small = RouteMap(dut.obstacles, dut.sight, dut.vertices)
    tiny = goal_ways.no_goals(len(dut.vertices), 2)
    object.__setattr__(small, "_goals", lambda _: tiny)
    goals = places(dut.obstacles, SIZE, 12, 7)
    for p in places(dut.obstacles, SIZE, 20, 8):
        for goal in goals:
            np.testing.assert_array_equal(
                small.next_waypoint(p, goal), dut.next_waypoint(p, goal)
            )
    assert np.isfinite(tiny.lengths).any()
