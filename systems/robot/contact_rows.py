"""Counts contacts between a robot and people, as rows of `layout.Contact`."""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    CONTACT_GAP,
    CONTACT_PAUSE,
    CONTACT_SIZE,
    Contact,
)

# Speeds of approach that differ by less are equal, in m/s.
SPEED_RESOLUTION = 1e-6

# A row of memory is a row of `contacts`, then the time since the last touch,
# in seconds, and the speeds at which the robot and the person have closed in
# on each other of late, in m/s.
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
    """Returns the memory of contacts at the end of a step.

    Where a contact begins, it is charged to who closed in faster, or to both
    if they are equally fast (the rule of SEAN). What counts is the larger of
    the speeds now and those of late: bodies are stopped, or pushed, in the very
    step in which they touch. Who goes away counts as at rest: so who grazes
    the other is charged, however slowly the two closed in, and of two who did
    not (they stood in each other at the start), both are. Each contact is
    charged to somebody.

    Args:
        memory: Shape (n, MEMORY_SIZE), at the start of the step.
        touching: Shape (n,): who touches the robot in this step.
        forces: Shape (n, 2): the forces of people on the robot in W, in
            newtons; None where nothing computes them.
        gaps: Shape (n,), from the robot's disc to the bodies at the start of
            the step, in meters.
        closing: Shape (2, n), how fast robot and people then close in on each
            other, in m/s: see `closing_speeds`.
        duration: The length of the step, in seconds.

    Returns:
        Shape (n, MEMORY_SIZE).
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
        # (Both speeds of one instant, as one may step back from the other.)
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
