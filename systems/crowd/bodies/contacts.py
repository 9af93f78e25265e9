"""Finds which bodies may touch in a step, compiled by numba.

A contact keeps a person away from something along a normal:
n . (x_i - x_j) >= d, with x_j = 0 if the other is not a person. The normal is
that of the start of the step. For discs and for walls, whose distance is a
convex function of the position, this keeps more than the distance itself.
"""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit, jit_as
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.crowd.bodies.pairs import near_pairs
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import segments_in

# A person nearer to a wall than this stands on it, in meters: no way is out.
_ON_WALL = 1e-6

# The columns of a contact: the normal, the distance kept along it, the person,
# and the other: a person's number, WALL, or that of a robot, from ROBOT down.
WALL, ROBOT = -1, -2
NORMAL_X, NORMAL_Y, DISTANCE, PERSON, OTHER = range(5)


@jit
def _normal(dx, dy, ex, ey):
    """Returns the unit vector of (dx, dy); of (ex, ey), or x, if it is zero."""
    length = math.sqrt(dx * dx + dy * dy)
    if length < 1e-9:
        dx, dy = ex, ey
        length = math.sqrt(dx * dx + dy * dy)
    if length < 1e-9:
        return 1.0, 0.0
    return dx / length, dy / length


@jit
def _met_at(x, y, robot, time_step, robots_stop):
    """Returns the position of a robot that a person at (x, y) meets in a step.

    The robot moves at its present velocity to the end of the step; if bodies
    stop it, it comes no nearer by itself, but it may move away.
    """
    mx = robot[VX] * time_step
    my = robot[VY] * time_step
    if robots_stop:
        nx, ny = _normal(x - robot[X], y - robot[Y], 0.0, 0.0)
        nearer = max(mx * nx + my * ny, 0.0)
        mx -= nearer * nx
        my -= nearer * ny
    return robot[X] + mx, robot[Y] + my


@jit
def do_bodies_meet(after, bodies, robots, robots_stop, time_step, pairs):
    """Returns whether any body would overlap another at the end of a step.

    The arguments are those of `keep_apart`; the pairs include all people who
    could meet.
    """
    for i in range(len(after)):
        for k in range(len(robots)):
            rx, ry = _met_at(
                *(after[i, X], after[i, Y], robots[k], time_step, robots_stop)
            )
            dx = after[i, X] - rx
            dy = after[i, Y] - ry
            both = bodies[i] + robots[k, RADIUS]
            if dx * dx + dy * dy < both * both:
                return True
    for p in range(len(pairs)):
        i = pairs[p, 0]
        j = pairs[p, 1]
        dx = after[i, X] - after[j, X]
        dy = after[i, Y] - after[j, Y]
        both = bodies[i] + bodies[j]
        if dx * dx + dy * dy < both * both:
            return True
    return False


@jit_as(float64[::1], MATRIX, VECTOR, MATRIX)
def deepest(states, bodies, robots):
    """Returns the depth (n,) of the deepest other body in that of each person.

    It is in meters, and 0 for people without contact.
    """
    depths = np.zeros(len(states))
    pairs = near_pairs(states[:, X], states[:, Y], bodies)
    for p in range(len(pairs)):
        i = pairs[p, 0]
        j = pairs[p, 1]
        depth = (
            bodies[i]
            + bodies[j]
            - math.hypot(
                states[i, X] - states[j, X], states[i, Y] - states[j, Y]
            )
        )
        depths[i] = max(depths[i], depth)
        depths[j] = max(depths[j], depth)
    for i in range(len(states)):
        for k in range(len(robots)):
            depth = (
                bodies[i]
                + robots[k, RADIUS]
                - math.hypot(
                    states[i, X] - robots[k, X], states[i, Y] - robots[k, Y]
                )
            )
            depths[i] = max(depths[i], depth)
    return depths


@jit_as(float64[:, ::1], MATRIX, MATRIX, VECTOR, MATRIX, REAL)
def robot_touches(before, free, bodies, robots, time_step):
    """Returns the touches of people and robots if they were not kept apart.

    Robots move through the step at their present velocity. `free`, of shape
    (mn, 2), are the positions of people after the step without the pushes of
    each robot, in meters.

    Returns:
        Shape (mn, 2), for each robot the rows of people: its depth in the
        body, in meters, at least 0; and the speed at which the person
        approaches the place where the robot was, in m/s, negative for people
        who move away, and 0 for people who stand on it.
    """
    n = len(before)
    touches = np.zeros((len(free), 2))
    for row in range(len(free)):
        i = row % n
        k = row // n
        dx = before[i, X] - robots[k, X]
        dy = before[i, Y] - robots[k, Y]
        distance = math.hypot(dx, dy)
        if distance > 0:
            closing = (before[i, X] - free[row, X]) * dx
            closing += (before[i, Y] - free[row, Y]) * dy
            touches[row, 1] = closing / (distance * time_step)
        gap = math.hypot(
            free[row, X] - robots[k, X] - robots[k, VX] * time_step,
            free[row, Y] - robots[k, Y] - robots[k, VY] * time_step,
        )
        depth = bodies[i] + robots[k, RADIUS] - gap
        touches[row, 0] = max(depth, 0.0)
    return touches


@jit
def find_contacts(
    before,
    after,
    bodies,
    margins,
    robots,
    walls,
    is_walled,
    robots_stop,
    time_step,
    slack,
    pairs,
):
    """Returns the contacts (c, 5) of people with people, robots and walls.

    Contacts with walls are only those of people near others. The arguments are
    those of `keep_apart`, and the largest distance by which people may be moved
    from their proposed positions, in meters; the pairs include all people who
    could touch then. See the columns above.
    """
    n = len(before)
    reach = np.empty(n)
    near = np.zeros(n, np.bool_)
    for i in range(n):
        dx = after[i, X] - before[i, X]
        dy = after[i, Y] - before[i, Y]
        reach[i] = bodies[i] + math.sqrt(dx * dx + dy * dy) + slack
    contacts = np.empty((len(pairs) + n * len(robots), 5))
    count = 0
    for p in range(len(pairs)):
        i = pairs[p, 0]
        j = pairs[p, 1]
        dx = before[i, X] - before[j, X]
        dy = before[i, Y] - before[j, Y]
        both = reach[i] + reach[j]
        if dx * dx + dy * dy >= both * both:
            continue
        contacts[count, NORMAL_X], contacts[count, NORMAL_Y] = _normal(
            dx, dy, after[i, X] - after[j, X], after[i, Y] - after[j, Y]
        )
        contacts[count, DISTANCE] = bodies[i] + bodies[j]
        contacts[count, PERSON] = i
        contacts[count, OTHER] = j
        near[i] = True
        near[j] = True
        count += 1
    for i in range(n):
        for k in range(len(robots)):
            rx, ry = _met_at(
                *(before[i, X], before[i, Y], robots[k]),
                *(time_step, robots_stop),
            )
            dx = before[i, X] - rx
            dy = before[i, Y] - ry
            both = bodies[i] + robots[k, RADIUS]
            if math.sqrt(dx * dx + dy * dy) < reach[i] + robots[k, RADIUS]:
                nx, ny = _normal(dx, dy, after[i, X] - rx, after[i, Y] - ry)
                contacts[count, NORMAL_X] = nx
                contacts[count, NORMAL_Y] = ny
                contacts[count, DISTANCE] = both + nx * rx + ny * ry
                contacts[count, PERSON] = i
                contacts[count, OTHER] = ROBOT - k
                near[i] = True
                count += 1
    contacts = contacts[:count]
    if is_walled:
        for i in range(n):
            if near[i]:
                contacts = _joined(
                    contacts, _walls_near(i, before, margins, reach, walls)
                )
    return contacts


@jit
def _joined(contacts, more):
    """Returns two arrays of contacts as one."""
    result = np.empty((len(contacts) + len(more), 5))
    for i in range(len(result)):
        for c in range(5):
            if i < len(contacts):
                result[i, c] = contacts[i, c]
            else:
                result[i, c] = more[i - len(contacts), c]
    return result


@jit
def _walls_near(i, before, margins, reach, walls):
    """Returns the contacts (c, 5) of person `i` with walls."""
    x = before[i, X]
    y = before[i, Y]
    far = margins[i] + reach[i]
    near = segments_in(x - far, y - far, x + far, y + far, walls)
    contacts = np.empty((len(near), 5))
    count = 0
    for s in near:
        px, py, d2 = nearest_on_segments(x, y, walls.segments, s, s + 1)
        distance = math.sqrt(d2)
        if not _ON_WALL < distance < far:
            continue
        nx = (x - px) / distance
        ny = (y - py) / distance
        contacts[count, NORMAL_X] = nx
        contacts[count, NORMAL_Y] = ny
        contacts[count, DISTANCE] = (
            min(margins[i], distance) + nx * px + ny * py
        )
        contacts[count, PERSON] = i
        contacts[count, OTHER] = WALL
        count += 1
    return contacts[:count]
