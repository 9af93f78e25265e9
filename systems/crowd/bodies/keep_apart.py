"""Keeps bodies apart at the end of a step, compiled by numba.

The positions that a step proposes are replaced by the nearest ones (in the sum
of squares of all displacements) at which no body overlaps another and nobody
enters a wall: the discrete contact model of Maury and Venel 2011. That is the
projection on a convex set. Its one solution does not depend on the order of
people, and changes no more than the proposal does: nobody trembles, and nothing
gains energy.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    CHANGED,
    INTEGER,
    MATRIX,
    REAL,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import VX, VY, Command, X, Y
from hunav_drake.systems.crowd.bodies.contacts import (
    DISTANCE,
    NORMAL_X,
    NORMAL_Y,
    OTHER,
    PERSON,
    ROBOT,
    do_bodies_meet,
    find_contacts,
)
from hunav_drake.systems.crowd.bodies.pairs import covered, near_pairs
from hunav_drake.systems.world.walls import opened

# The compliance of contacts: the share of the displacement by which they move
# people that is left as overlap. It distributes overlap where there is no room.
_GIVE = 1e-3

# People who overlap others by more than this at the start of a step are put
# beside them at rest, in meters.
_DEEP = 0.01

# Pushes that change by less than this are final, in meters.
_TOLERANCE = 1e-5

# The distances by which people may be moved from their proposed positions, in
# meters: contacts are searched within the first; if anybody is moved farther,
# within the next.
_SLACKS = (0.05, 0.3, 2.0)


@jit
def _apply(pushes, contacts, places, moved):
    """Writes the positions after pushes, one per contact, in meters."""
    for i in range(len(places)):
        moved[i, 0] = places[i, 0]
        moved[i, 1] = places[i, 1]
    for c in range(len(contacts)):
        i = int(contacts[c, PERSON])
        j = int(contacts[c, OTHER])
        px = pushes[c] * contacts[c, NORMAL_X]
        py = pushes[c] * contacts[c, NORMAL_Y]
        moved[i, 0] += px
        moved[i, 1] += py
        if j >= 0:
            moved[j, 0] -= px
            moved[j, 1] -= py


@jit
def project(contacts, places, iterations):
    """Returns the positions nearest to given ones that keep all contacts.

    The dual problem is solved by accelerated projected gradients (Mazhar,
    Heyn, Negrut and Tasora 2015), scaled by the number of contacts of each
    person, in at most `iterations`. All pushes change at once, so their order
    has no effect. Contacts (c, 5) are those of `find_contacts`. The results are
    the positions (n, 2), and the push of each contact (c,), in meters.
    """
    count = len(contacts)
    degree = np.zeros(len(places))
    for c in range(count):
        degree[int(contacts[c, PERSON])] += 1
        if contacts[c, OTHER] >= 0:
            degree[int(contacts[c, OTHER])] += 1
    scale = np.empty(count)
    for c in range(count):
        scale[c] = degree[int(contacts[c, PERSON])] + _GIVE
        if contacts[c, OTHER] >= 0:
            scale[c] += degree[int(contacts[c, OTHER])]
    pushes = np.zeros(count)
    ahead = np.zeros(count)
    moved = places.copy()
    momentum = 1.0
    for _ in range(iterations):
        change = 0.0
        agreement = 0.0
        following = np.empty(count)
        for c in range(count):
            # The violation of the contact, in meters; negative if it is kept.
            i = int(contacts[c, PERSON])
            j = int(contacts[c, OTHER])
            dx = moved[i, 0]
            dy = moved[i, 1]
            if j >= 0:
                dx -= moved[j, 0]
                dy -= moved[j, 1]
            violation = contacts[c, DISTANCE] - (
                contacts[c, NORMAL_X] * dx + contacts[c, NORMAL_Y] * dy
            )
            step = (violation - _GIVE * ahead[c]) / scale[c]
            following[c] = max(ahead[c] + step, 0.0)
            difference = following[c] - pushes[c]
            change = max(change, abs(difference), abs(following[c] - ahead[c]))
            agreement += (ahead[c] - following[c]) * difference
        # (The momentum starts anew where it leads uphill.)
        if agreement > 0:
            momentum = 1.0
        before = momentum
        momentum = (1 + math.sqrt(1 + 4 * momentum * momentum)) / 2
        for c in range(count):
            ahead[c] = following[c] + (before - 1) / momentum * (
                following[c] - pushes[c]
            )
            pushes[c] = following[c]
        _apply(ahead, contacts, places, moved)
        if change < _TOLERANCE:
            break
    _apply(pushes, contacts, places, moved)
    return moved, pushes


@jit
def _deep(before, bodies, pairs):
    """Returns for each body whether it overlaps another at the start."""
    deep = np.zeros(len(before), np.bool_)
    for p in range(len(pairs)):
        i = pairs[p, 0]
        j = pairs[p, 1]
        dx = before[i, X] - before[j, X]
        dy = before[i, Y] - before[j, Y]
        both = bodies[i] + bodies[j] - _DEEP
        if both > 0 and dx * dx + dy * dy < both * both:
            deep[i] = True
            deep[j] = True
    return deep


@jit_as(numba.boolean, MATRIX, MATRIX, MATRIX, MATRIX, numba.boolean, REAL)
def would_meet(before, after, sizes, robots, robots_stop, time_step):
    """Returns whether `keep_apart` would move anybody; arguments as there."""
    bodies = sizes[:, 0].copy()
    known = covered(_longest(before, after) + _SLACKS[0])
    pairs = near_pairs(before[:, X], before[:, Y], bodies + known)
    return do_bodies_meet(after, bodies, robots, robots_stop, time_step, pairs)


@jit
def _longest(before, after):
    """Returns the largest displacement of a person, in meters."""
    longest = 0.0
    for i in range(len(after)):
        dx = after[i, X] - before[i, X]
        dy = after[i, Y] - before[i, Y]
        longest = max(longest, math.sqrt(dx * dx + dy * dy))
    return longest


# The types of the arguments of `keep_apart`.
_ARGUMENTS = (
    *(MATRIX, CHANGED, MATRIX, MATRIX, MATRIX, WALLS, numba.boolean),
    *(numba.boolean, REAL, INTEGER, numba.int64[:, ::1], REAL, CHANGED),
)


@late_as(numba.boolean, *_ARGUMENTS)
def keep_apart(
    before,
    after,
    sizes,
    command,
    robots,
    table,
    is_walled,
    robots_stop,
    time_step,
    iterations,
    pairs,
    known,
    free,
):
    """Moves people at the end of a step so that no bodies overlap.

    Robots move on at their present velocity or, if bodies stop them, come no
    nearer; people give way. Velocities change with the positions, but nobody
    gets faster by that than both the proposal and the own speed limit. People
    who touch nobody move as proposed.

    `after` are the states proposed, outside of walls; they change to those in
    which no bodies overlap. `sizes` (n, 2) are the radius of each body, and the
    distance that its center keeps from walls (see `wall_margins`), in meters.
    The flags are whether walls stop people, and whether people stop robots.
    `pairs` (p, 2) are all people whose bodies were less than 2 `known` apart
    before, in meters, in the order of `near_pairs`, and maybe others; none are
    known if that is negative. `free` (mn, 2) are for each robot the positions
    proposed, in meters; they change to those without the pushes of that robot,
    but with all others. Returns whether anybody was moved.
    """
    bodies = sizes[:, 0].copy()
    longest = _longest(before, after)
    if known < covered(longest + _SLACKS[0]):
        known = covered(longest + _SLACKS[0])
        pairs = near_pairs(before[:, X], before[:, Y], bodies + known)
    if not do_bodies_meet(after, bodies, robots, robots_stop, time_step, pairs):
        return False
    _part(
        *(before, after, sizes, command, robots, table, is_walled),
        *(robots_stop, time_step, iterations, pairs, known, free, longest),
    )
    return True


@late_as(numba.void, *_ARGUMENTS, REAL)
def _part(
    before,
    after,
    sizes,
    command,
    robots,
    table,
    is_walled,
    robots_stop,
    time_step,
    iterations,
    pairs,
    known,
    free,
    longest,
):
    """Parts bodies that meet: see `keep_apart`.

    `longest` is the largest displacement that is proposed, in meters.
    """
    walls = opened(table)
    bodies = sizes[:, 0].copy()
    margins = sizes[:, 1].copy()
    proposed = after[:, : Y + 1].copy()
    for slack in _SLACKS:
        if known < covered(longest + slack):
            known = covered(longest + slack)
            pairs = near_pairs(before[:, X], before[:, Y], bodies + known)
        contacts = find_contacts(
            *(before, after, bodies, margins, robots, walls, is_walled),
            *(robots_stop, time_step, slack, pairs),
        )
        places, pushes = project(contacts, proposed, iterations)
        farthest = 0.0
        for i in range(len(places)):
            dx = places[i, X] - proposed[i, X]
            dy = places[i, Y] - proposed[i, Y]
            farthest = max(farthest, dx * dx + dy * dy)
        if farthest <= slack * slack:
            break
    n = len(after)
    for row in range(len(free)):
        free[row, X] = places[row % n, X]
        free[row, Y] = places[row % n, Y]
    for c in range(len(contacts)):
        if contacts[c, OTHER] <= ROBOT and pushes[c] > 0:
            k = ROBOT - int(contacts[c, OTHER])
            row = k * n + int(contacts[c, PERSON])
            free[row, X] -= pushes[c] * contacts[c, NORMAL_X]
            free[row, Y] -= pushes[c] * contacts[c, NORMAL_Y]
    deep = _deep(before, bodies, pairs)
    for i in range(len(after)):
        dx = places[i, X] - proposed[i, X]
        dy = places[i, Y] - proposed[i, Y]
        if dx == 0 and dy == 0:
            continue
        after[i, X] = places[i, X]
        after[i, Y] = places[i, Y]
        speed = math.sqrt(after[i, VX] ** 2 + after[i, VY] ** 2)
        vx = after[i, VX] + dx / time_step
        vy = after[i, VY] + dy / time_step
        most = max(speed, command[i, Command.MAX_SPEED])
        if deep[i]:
            most = 0.0
        faster = math.sqrt(vx * vx + vy * vy)
        if faster > most:
            vx *= most / faster
            vy *= most / faster
        after[i, VX] = vx
        after[i, VY] = vy
