"""The next corner of the world to walk to, compiled by numba.

The arguments have the names and units of `walls.py`.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, WALLS, jit, unowned
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.common.sorting import heap_between, pop_least
from hunav_drake.systems.world.goal_ways import (
    BEYOND,
    Goals,
    Graph,
    known_goal,
    search,
    through,
)
from hunav_drake.systems.world.hidden import Hidden, is_hidden, remembered
from hunav_drake.systems.world.visibility_graph import SQUEEZED, sees
from hunav_drake.systems.world.walls import opened

# Ways whose lengths differ less are equal, in meters.
_SAME = 1e-9

# The part of the clearance with which ways lead on where they would turn back.
_SLACK = 0.8

# A person nearer to a vertex than this part of the clearance does not step
# aside to it.
_NEAR = 0.2


@jit
def _turns_back(x, y, vx, vy, ox, oy, clearance):
    """Returns whether one goes back to v before o, or, near v, aside to it.

    In a door that is barely wide enough, nobody should turn back for so little.
    """
    vx -= x
    vy -= y
    ox -= x
    oy -= y
    leg = math.hypot(vx, vy)
    along = vx * ox + vy * oy
    cosine = 0.0 if leg < _NEAR * clearance else -0.5
    return along < cosine * leg * math.hypot(ox, oy)


@jit
def _shortest_in_sight(x, y, clearance, view, graph, known, walls):
    """Returns the length of the shortest way by a vertex in sight of (x, y).

    It is infinite if none is known; `view` is the result of `through`.
    """
    legs, ways, _ = view
    shortest = math.inf
    # A near one is likely to be seen, and spares tests of many others.
    nearest = np.argmin(legs)
    if ways[nearest] < math.inf and not is_hidden(
        x, y, nearest, clearance, graph.vertices, known, walls
    ):
        shortest = ways[nearest]
    # Of the others with shorter ways, the first in sight is the one.
    heap = np.empty(len(ways), np.int64)
    places = np.empty(len(ways), np.int64)
    for count in range(heap_between(0.0, shortest, ways, heap, places), 0, -1):
        i = pop_least(ways, heap, places, count)
        if not is_hidden(x, y, i, clearance, graph.vertices, known, walls):
            return ways[i]
    return shortest


@jit
def _choice(x, y, clearance, view, at, sight, graph, goals, known, walls):
    """Returns the vertex in sight of (x, y) with the shortest way, or -1.

    The arguments are those of `search`.
    """
    if len(graph.vertices) == 0:
        return -1
    shortest = math.inf
    searched = True
    while searched:
        shortest = _shortest_in_sight(
            x, y, clearance, view, graph, known, walls
        )
        searched = search(
            *(x, y, clearance, shortest, view, at, sight),
            *(graph, goals, known, walls),
        )
    if shortest == math.inf:
        return -1
    legs, ways, _ = view
    heap = np.empty(len(ways), np.int64)
    places = np.empty(len(ways), np.int64)
    alike = heap_between(shortest, shortest + BEYOND, ways, heap, places)
    if alike == 1:
        return heap[0]
    choice = -1
    for count in range(alike, 0, -1):
        i = pop_least(ways, heap, places, count)
        if choice >= 0 and ways[i] > ways[choice] + _SAME:
            break
        # Of equal ways, the one with the farther waypoint: a person who
        # stands on a vertex looks on to the next.
        if (choice < 0 or legs[i] > legs[choice]) and not is_hidden(
            x, y, i, clearance, graph.vertices, known, walls
        ):
            choice = i
    return choice


@jit
def _waypoint(x, y, goal_x, goal_y, clearance, graph, goals, hidden, walls):
    """Returns the point to walk to next from (x, y), on the way to a goal.

    The goal itself is not in sight, with the clearance. The other arguments
    are those of `guided`.
    """
    at = known_goal(goal_x, goal_y, clearance, graph, goals, walls)
    _, _, place_x, place_y, last_clearance = goals.places[at]
    elsewhere = place_x != goal_x or place_y != goal_y
    if (elsewhere or last_clearance != clearance) and sees(
        x, y, place_x, place_y, last_clearance, walls
    ):
        # In front of the furniture that the goal is in, people lean towards
        # the goal, and come to rest there.
        if math.hypot(place_x - x, place_y - y) < 2 * clearance:
            return goal_x, goal_y
        return place_x, place_y
    known = remembered(x, y, hidden)
    vertices = graph.vertices
    view = through(x, y, at, graph, goals, known[2])
    rest = (view, at, clearance, graph, goals, known, walls)
    legs = view[0]
    choice = _choice(x, y, clearance, *rest)
    if choice >= 0 and legs[choice] < 2 * clearance:
        slack = _SLACK * clearance
        vx, vy = vertices[choice]
        other = _choice(x, y, slack, *rest)
        ox, oy = vertices[other]
        if _turns_back(x, y, vx, vy, ox, oy, clearance):
            choice = other
    if choice < 0:
        squeezed = SQUEEZED * clearance
        choice = _choice(x, y, squeezed, *rest)
    if choice < 0:
        return goal_x, goal_y
    return vertices[choice, 0], vertices[choice, 1]


@late_as(
    float64[:, ::1],
    *(MATRIX, MATRIX, REAL, MATRIX, numba.int32[:, ::1], numba.int32[::1]),
    *(float64[:, ::1], numba.int64[::1], float64[:, ::1], numba.int8[:, ::1]),
    *(numba.int64[:, ::1], numba.int32[:, ::1], WALLS),
)
def guided(
    positions,
    command,
    clearance,
    vertices,
    seen,
    counts,
    places,
    used,
    lengths,
    states,
    cells,
    hiders,
    table,
):
    """Returns commands with the next waypoints, if a goal is not seen.

    A waypoint that is not the goal has a radius of zero. Without anybody who
    has a goal, is not there, and does not see it, with the clearance, the
    result has no rows. Rows of positions are x, y, ..., in meters. After the
    clearance come the fields of `Graph`, `Goals` and `Hidden`, which are
    updated.
    """
    walls = opened(table)
    graph = Graph(unowned(vertices), unowned(seen), unowned(counts))
    goals = Goals(
        *(unowned(places), unowned(used), unowned(lengths), unowned(states))
    )
    hidden = Hidden(unowned(cells), unowned(hiders))
    result = np.empty((0, command.shape[1]))
    for i in range(len(positions)):
        x = positions[i, 0]
        y = positions[i, 1]
        goal_x = command[i, Command.GOAL_X]
        goal_y = command[i, Command.GOAL_Y]
        if (
            command[i, Command.HAS_GOAL] == 0
            or math.hypot(goal_x - x, goal_y - y)
            <= command[i, Command.GOAL_RADIUS]
            or sees(x, y, goal_x, goal_y, clearance, walls)
        ):
            continue
        if len(result) == 0:
            result = command.copy()
        next_x, next_y = _waypoint(
            *(x, y, goal_x, goal_y, clearance, graph, goals, hidden, walls)
        )
        if next_x != goal_x or next_y != goal_y:
            result[i, Command.GOAL_X] = next_x
            result[i, Command.GOAL_Y] = next_y
            result[i, Command.GOAL_RADIUS] = 0.0
    return result
