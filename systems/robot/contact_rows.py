"""Counts contacts between a robot and people, compiled by numba.

They are rows of `layout.Contact`.
"""

import math

import numba

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import (
    CONTACT_GAP,
    CONTACT_PAUSE,
    CONTACT_SIZE,
    Contact,
)

# Approach speeds that differ by less are equal, in m/s.
SPEED_RESOLUTION = 1e-6

# A row of memory is a row of `contacts`, then the time since the last touch, in
# seconds, and the recent approach speeds of the robot and of the person, in
# m/s.
SINCE, ROBOT_SPEED, PERSON_SPEED = range(CONTACT_SIZE, CONTACT_SIZE + 3)
MEMORY_SIZE = CONTACT_SIZE + 3


# The types of arrays that are written to, and of one truth per person.
_ROWS = numba.float64[:, ::1]
TRUTHS = numba.types.Array(numba.boolean, 1, "C", readonly=True)


@late_as(_ROWS, MATRIX, TRUTHS, MATRIX, VECTOR, MATRIX, REAL)
def count_contacts(memory, touching, forces, gaps, closing, duration):
    """Returns the memory of contacts, rows of `MEMORY_SIZE`, after a step.

    A new contact is attributed to the one who approached faster, or to both if
    they are equally fast (the rule of SEAN). The larger of the current and the
    recent speeds counts, because bodies are stopped, or pushed, in the step in
    which they touch. Moving away counts as at rest: so the one who grazes the
    other is charged at any approach speed, and if none approached (they
    overlapped at the start), both are. Each contact is attributed to at least
    one of the two.

    `touching` (n,) is for this step; `forces` (n, 2) are those of people on the
    robot in W, in newtons, (0, 2) if they are not computed; `gaps` (n,), in
    meters, and `closing` (2, n), the `closing_speeds`, are those at the start
    of the step; `duration` is its length, in seconds.
    """
    after = memory.copy()
    some = False
    for i in range(len(memory)):
        some = some or touching[i] or memory[i, Contact.LASTS] > 0
    if not some:
        return after
    for i in range(len(memory)):
        row = after[i]
        lasted = row[Contact.LASTS] > 0
        stays = touching[i] or (lasted and gaps[i] < CONTACT_GAP)
        row[SINCE] = 0.0 if stays else row[SINCE] + duration
        lasts = stays or (lasted and row[SINCE] < CONTACT_PAUSE)
        row[Contact.LASTS] = 1.0 if lasts else 0.0
        if touching[i] and not lasted:
            a = max(row[ROBOT_SPEED], closing[0, i], 0.0)
            b = max(row[PERSON_SPEED], closing[1, i], 0.0)
            row[Contact.BY_ROBOT] += a >= b - SPEED_RESOLUTION
            row[Contact.BY_PERSON] += b >= a - SPEED_RESOLUTION
            # (Both speeds of the same instant, as one may recede from the
            # other.)
            row[Contact.RELATIVE_SPEED] = max(
                closing[0, i] + closing[1, i],
                row[ROBOT_SPEED] + row[PERSON_SPEED],
                0.0,
            )
            row[Contact.PEAK_FORCE] = 0.0
        if len(forces):
            size = math.hypot(forces[i, 0], forces[i, 1])
            row[Contact.FORCE_X] = forces[i, 0]
            row[Contact.FORCE_Y] = forces[i, 1]
            if touching[i]:
                row[Contact.PEAK_FORCE] = max(row[Contact.PEAK_FORCE], size)
            row[Contact.IMPULSE] += size * duration
    return after
