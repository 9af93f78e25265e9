"""The lengths of the ways from the corners of the world to goals, compiled.

They are found from the goal on, those first that lead to the one who asks, and
no more than the answer needs (A*). What is found is remembered for each goal.
That saves time, and never changes a result: a length that is final is that of
the shortest way, with the bits of a search through the whole world.

The arguments have the names and units of `walls.py`.
"""

import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.sorting import heap_between, pop_least, rise
from hunav_drake.systems.world.hidden import HIDDEN, is_hidden
from hunav_drake.systems.world.sweep import is_free, nearest_free
from hunav_drake.systems.world.visibility_graph import (
    SQUEEZED,
    no_hiders,
    seen_from,
    sees_past,
)

# Ways that are longer than the shortest one in sight by this are of no use, in
# meters. It is more than rounding, and than ways that count as equal differ.
BEYOND = 1e-6

# A search goes on to bounds of the least one times this, and then begins anew.
_WIDER = 1.1

# What is known of the way from a vertex: not whether the straight one to the
# goal is free; the length of one that may not be the shortest; of the shortest.
_UNTRIED, _OPEN, _FINAL = 0, 1, 2

# The number of vertices seen from one that are remembered, and what stands for
# their number if they are not.
_MOST_SEEN = 512
_UNKNOWN, _MANY = -1, -2

# The number of places in the memory where a goal may be.
_TRIED = 16


class Graph(NamedTuple):
    """The vertices of a map, and which see each other, once it is needed.

    Attributes:
        vertices: Shape (m, 2), in meters.
        seen: Shape (m, k): the vertices that each one sees, as far as known.
        counts: Shape (m,): their number; _UNKNOWN, or _MANY if there are more
            than k, which are found anew each time.
    """

    vertices: np.ndarray
    seen: np.ndarray
    counts: np.ndarray


class Goals(NamedTuple):
    """What is known of the ways to goals.

    Attributes:
        places: Shape (c, 5): rows of the goal (x, y), the place (x, y) to go
            to, which is outside of solids, and the clearance of the last leg;
            in meters.
        used: Shape (c + 1,): when each goal was last asked for, 0 for none.
            The last element is the clock: it counts what was asked.
        lengths: Shape (c, m): the lengths of the ways from vertices, in meters;
            infinite if none is known.
        states: Shape (c, m): _UNTRIED, _OPEN or _FINAL.
    """

    places: np.ndarray
    used: np.ndarray
    lengths: np.ndarray
    states: np.ndarray


def no_ways(vertices: Array) -> Graph:
    """Returns the graph of some vertices of which nothing is known."""
    m = len(vertices)
    # (Pages that nobody writes to take no memory.)
    return Graph(
        vertices,
        np.zeros((m, min(m, _MOST_SEEN)), dtype=np.int32),
        np.full(m, _UNKNOWN, dtype=np.int32),
    )


def no_goals(vertices: int, places: int) -> Goals:
    """Returns an empty memory for a number of goals."""
    return Goals(
        np.zeros((places, 5)),
        np.zeros(places + 1, dtype=np.int64),
        np.zeros((places, vertices)),
        np.zeros((places, vertices), dtype=np.int8),
    )


@jit
def known_goal(x, y, clearance, graph, goals, walls):
    """Returns the place of a goal (x, y) in the memory.

    A new one takes the place that was not used for longest.
    """
    count = len(goals.places)
    home = (math.floor(1e3 * x) * 7919 + math.floor(1e3 * y) * 104729) % count
    goals.used[count] += 1
    oldest = home
    for k in range(min(_TRIED, count)):
        at = (home + k) % count
        if goals.used[at] == 0:
            oldest = at
            break
        if goals.places[at, 0] == x and goals.places[at, 1] == y:
            goals.used[at] = goals.used[count]
            return at
        if goals.used[at] < goals.used[oldest]:
            oldest = at
    goals.used[oldest] = goals.used[count]
    px = x
    py = y
    if not is_free(x, y, 0.0, walls):
        px, py, _ = nearest_free(x, y, 0.0, 0.0, clearance, walls)
    goals.lengths[oldest][:] = math.inf
    goals.states[oldest][:] = _UNTRIED
    place = goals.places[oldest]
    place[0] = x
    place[1] = y
    place[2] = px
    place[3] = py
    place[4] = clearance
    if not _sees_any(px, py, clearance, graph, walls):
        place[4] = SQUEEZED * clearance
    return oldest


@jit
def _distances(x, y, points):
    """Returns the distances (m,) of points (m, 2) from (x, y), to rounding."""
    away = np.empty(len(points))
    for i in range(len(points)):
        dx = points[i, 0] - x
        dy = points[i, 1] - y
        away[i] = math.sqrt(dx * dx + dy * dy)
    return away


@jit
def _sees_any(x, y, clearance, graph, walls):
    """Returns whether (x, y) sees a vertex."""
    away = _distances(x, y, graph.vertices)
    heap = np.empty(len(away), np.int64)
    places = np.empty(len(away), np.int64)
    hiders = no_hiders()
    # Mostly the nearest one is seen.
    least = np.min(away) if len(away) > 0 else 0.0
    lower = 0.0
    for upper in (np.nextafter(least, math.inf), math.inf):
        for count in range(
            heap_between(lower, upper, away, heap, places), 0, -1
        ):
            v = pop_least(away, heap, places, count)
            vx = graph.vertices[v, 0]
            vy = graph.vertices[v, 1]
            if sees_past(x, y, vx, vy, clearance, walls, hiders):
                return True
        lower = upper
    return False


@jit
def through(x, y, at, graph, goals, hiders):
    """Returns the lengths of the ways from (x, y) to a goal by each vertex.

    `at` is the place of the goal in the memory, and `hiders` are those of the
    vertices from there: see `remembered`.

    They are three arrays, in meters: the distances of the vertices; the lengths
    of the ways by those whose own are final, and which are not known to be
    hidden; and lower bounds, to rounding, for those whose own are not. Other
    ways and bounds are infinite.
    """
    vertices = graph.vertices
    lengths = goals.lengths[at]
    states = goals.states[at]
    m = len(vertices)
    ways = np.full(m, np.inf)
    bounds = np.full(m, np.inf)
    legs = _distances(x, y, vertices)
    away = _distances(goals.places[at, 2], goals.places[at, 3], vertices)
    for v in range(m):
        if states[v] == _UNTRIED:
            bounds[v] = legs[v] + away[v]
        elif states[v] == _OPEN:
            bounds[v] = legs[v] + lengths[v]
        elif hiders[v] != HIDDEN:
            legs[v] = math.hypot(vertices[v, 0] - x, vertices[v, 1] - y)
            ways[v] = legs[v] + lengths[v]
    return legs, ways, bounds


@jit
def search(
    x, y, clearance, shortest, view, at, sight, graph, goals, known, walls
):
    """Makes final some of what a shorter way than the one known may go by.

    Arrays `view` are from `through`, and change. `shortest` is the length of
    the shortest way by a vertex in sight, infinite if none is known; `at` is
    the place of the goal in the memory; `sight` is the clearance of the ways
    between vertices; `known` is the result of `remembered`.
    Returns whether there was any.
    """
    legs, ways, bounds = view
    m = len(bounds)
    heap = np.empty(m, np.int64)
    places = np.empty(m, np.int64)
    # (A heap of all vertices takes longer to make than to use.)
    limit = min(shortest + BEYOND, _WIDER * np.min(bounds) + BEYOND)
    count = heap_between(0.0, limit, bounds, heap, places)
    if count == 0:
        return False
    _, _, px, py, last = goals.places[at]
    lengths = goals.lengths[at]
    states = goals.states[at]
    hiders = no_hiders()
    room = np.empty(m, np.int32)
    while count > 0 and bounds[heap[0]] < limit:
        v = pop_least(bounds, heap, places, count)
        count -= 1
        vx = graph.vertices[v, 0]
        vy = graph.vertices[v, 1]
        if states[v] == _UNTRIED:
            states[v] = _OPEN
            if sees_past(px, py, vx, vy, last, walls, hiders):
                lengths[v] = min(lengths[v], math.hypot(px - vx, py - vy))
            bounds[v] = legs[v] + lengths[v]
            if lengths[v] < math.inf:
                count = rise(bounds, heap, places, v, count)
            continue
        states[v] = _FINAL
        bounds[v] = math.inf
        if known[2][v] != HIDDEN:
            legs[v] = math.hypot(vx - x, vy - y)
            ways[v] = legs[v] + lengths[v]
            if ways[v] < shortest and not is_hidden(
                x, y, v, clearance, graph.vertices, known, walls
            ):
                shortest = ways[v]
                limit = min(limit, shortest + BEYOND)
        for u in _seen_from(v, sight, graph, walls, room):
            length = lengths[v] + math.hypot(
                *(vx - graph.vertices[u, 0], vy - graph.vertices[u, 1])
            )
            if length >= lengths[u]:
                continue
            lengths[u] = length
            if states[u] != _UNTRIED:
                states[u] = _OPEN
                ways[u] = math.inf
                bounds[u] = legs[u] + length
                count = rise(bounds, heap, places, u, count)
    return True


@jit
def _seen_from(v, clearance, graph, walls, room):
    """Returns the vertices that a vertex sees; `room` (m,) may be needed."""
    count = graph.counts[v]
    if count < 0:
        known = count == _UNKNOWN
        count = seen_from(v, graph.vertices, clearance, walls, room)
        if count > graph.seen.shape[1]:
            graph.counts[v] = _MANY
            return room[:count]
        if known:
            graph.counts[v] = count
            for k in range(count):
                graph.seen[v, k] = room[k]
    return graph.seen[v, :count]
