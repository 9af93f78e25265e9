"""Lets members of a group go on without the others, compiled by numba.

People of a group pull each other to their center. If they walk to different
places, or if some have arrived, that holds all of them in between. In front of
a door that is too narrow for two, it holds both beside it; and behind a wall it
pulls into the wall. For that time, they go as if they were alone, or with those
who have the same way.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, VECTOR, WALLS, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import Command, X, Y
from hunav_drake.systems.crowd.walls.beside import (
    passage_width,
    places_ahead,
    walls_beside,
    way_ahead,
)
from hunav_drake.systems.world.visibility_graph import sees
from hunav_drake.systems.world.walls import opened

# A person this near to a wall is not behind it, in meters.
_TOUCH = 0.01

# People walk together if their goals are this near to each other, in meters
# (the pull of those who stand at theirs lets the others come to theirs), or if
# their directions differ by less than 60 degrees and they are this near to each
# other, in meters.
_SAME_PLACE = 1.0
_SAME_WAY = 0.5
_NEAR = 3.0

# The numbers of groups from here on belong to no configuration.
_NEW_GROUPS = 2.0**31


@jit
def _root(roots, i):
    """Returns the first person of those who walk with a person."""
    while roots[i] != i:
        i = roots[i]
    return i


@jit
def is_grouped(command):
    """Returns whether anybody (n, COMMAND_SIZE) is in a group."""
    grouped = False
    for i in range(len(command)):
        grouped = grouped or command[i, Command.GROUP_ID] >= 0
    return grouped


@late_as(float64[::1], MATRIX, MATRIX, MATRIX)
def walking_groups(positions, command, guided):
    """Returns the groups (n,) of people who walk together: >= 0, or -1 alone.

    Members of a group walk together if they go to the same place, or are near
    each other and go in the same direction, also by way of other members.
    People who stand go nowhere. The first person of a group and those who walk
    along keep its number. Rows of positions are x, y, ..., in meters; `guided`
    are the commands with waypoints for goals.
    """
    n = len(positions)
    result = command[:, Command.GROUP_ID].copy()
    ends = np.empty((n, 2))
    ways = np.zeros((n, 2))
    roots = np.arange(n)
    for i in range(n):
        if result[i] < 0:
            continue
        for c in range(2):
            ends[i, c] = positions[i, X + c]
        dx = guided[i, Command.GOAL_X] - positions[i, X]
        dy = guided[i, Command.GOAL_Y] - positions[i, Y]
        far = math.hypot(dx, dy)
        if (
            guided[i, Command.HAS_GOAL] != 0
            and far > guided[i, Command.GOAL_RADIUS]
        ):
            ends[i, 0] = command[i, Command.GOAL_X]
            ends[i, 1] = command[i, Command.GOAL_Y]
            ways[i, 0] = dx / far
            ways[i, 1] = dy / far
        for j in range(i):
            if result[j] != result[i]:
                continue
            gap = math.hypot(
                positions[i, X] - positions[j, X],
                positions[i, Y] - positions[j, Y],
            )
            apart = math.hypot(ends[i, 0] - ends[j, 0], ends[i, 1] - ends[j, 1])
            along = ways[i, 0] * ways[j, 0] + ways[i, 1] * ways[j, 1]
            if apart <= _SAME_PLACE or (gap <= _NEAR and along >= _SAME_WAY):
                a = _root(roots, i)
                b = _root(roots, j)
                roots[max(a, b)] = min(a, b)
    groups = result.copy()
    for i in range(n):
        if groups[i] < 0:
            continue
        root = _root(roots, i)
        alone = True
        first = True
        for j in range(n):
            if j != i and groups[j] == groups[i]:
                alone = alone and _root(roots, j) != root
                first = first and j >= root
        if alone:
            result[i] = -1.0
        elif not first:
            result[i] = _NEW_GROUPS + root
    return result


@late_as(numba.boolean[::1], MATRIX, MATRIX, VECTOR, WALLS)
def parted(positions, command, radii, table):
    """Returns for each person (n,) whether walls separate it from its group.

    A wall is between them and the center of the group, or their way is, within
    the next 1.5 m, narrower than they and the widest other one abreast. Rows of
    positions are x, y, ..., in meters; commands have waypoints for goals.
    """
    walls = opened(table)
    n = len(positions)
    result = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        group = command[i, Command.GROUP_ID]
        if group < 0:
            continue
        cx = 0.0
        cy = 0.0
        count = 0
        widest = 0.0
        for j in range(n):
            if command[j, Command.GROUP_ID] == group:
                cx += positions[j, X]
                cy += positions[j, Y]
                count += 1
                if j != i:
                    widest = max(widest, radii[j])
        if count < 2:
            continue
        x = positions[i, X]
        y = positions[i, Y]
        if not sees(x, y, cx / count, cy / count, _TOUCH, walls):
            result[i] = True
            continue
        goes, ex, ey, ahead, _ = way_ahead(x, y, command[i])
        if goes:
            px, py = places_ahead(x, y, ex, ey, ahead)
            beside = walls_beside(x, y, ex, ey, ahead, walls)
            width = passage_width(px, py, ex, ey, beside, walls)
            result[i] = width < 2 * (radii[i] + widest)
    return result
