"""Counts contacts between a robot and people, as rows of `layout.Contact`."""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
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


def count_contacts(
    memory: Array,
    touching: Mask,
    forces: Array | None,
    gaps: Array,
    closing: Array,
    duration: float,
) -> Array:
    """Returns the memory of contacts, rows of `MEMORY_SIZE`, after a step.

    A new contact is attributed to the one who approached faster, or to both if
    they are equally fast (the rule of SEAN). The larger of the current and the
    recent speeds counts, because bodies are stopped, or pushed, in the step in
    which they touch. Moving away counts as at rest: so the one who grazes the
    other is charged at any approach speed, and if none approached (they
    overlapped at the start), both are. Each contact is attributed to at least
    one of the two.

    `touching` (n,) is for this step; `forces` (n, 2) are those of people on the
    robot in W, in newtons, None if they are not computed; `gaps` (n,), in
    meters, and `closing` (2, n), the `closing_speeds`, are those at the start
    of the step; `duration` is its length, in seconds.
    """
    lasted = memory[:, Contact.LASTS] > 0
    if not (touching.any() or lasted.any()):
        return memory
    after = memory.copy()
    stay = touching | (lasted & (gaps < CONTACT_GAP))
    after[:, SINCE] = np.where(stay, 0.0, memory[:, SINCE] + duration)
    lasts = stay | (lasted & (after[:, SINCE] < CONTACT_PAUSE))
    after[:, Contact.LASTS] = lasts
    begins = touching & ~lasted
    if begins.any():
        late = memory[:, ROBOT_SPEED], memory[:, PERSON_SPEED]
        a, b = np.maximum(np.maximum(late, closing), 0.0)
        after[:, Contact.BY_ROBOT] += begins & (a >= b - SPEED_RESOLUTION)
        after[:, Contact.BY_PERSON] += begins & (b >= a - SPEED_RESOLUTION)
        # (Both speeds of the same instant, as one may recede from the other.)
        speed = np.maximum(closing[0] + closing[1], late[0] + late[1])
        after[begins, Contact.RELATIVE_SPEED] = np.maximum(speed, 0)[begins]
        after[begins, Contact.PEAK_FORCE] = 0.0
    if forces is not None:
        size = np.hypot(forces[:, 0], forces[:, 1])
        after[:, Contact.FORCE_X : Contact.FORCE_Y + 1] = forces
        after[:, Contact.PEAK_FORCE] = np.where(
            touching,
            np.maximum(after[:, Contact.PEAK_FORCE], size),
            after[:, Contact.PEAK_FORCE],
        )
        after[:, Contact.IMPULSE] += size * duration
    return after
