"""Counts contacts between a robot and people, as rows of `layout.Contact`."""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    CONTACT_GAP,
    CONTACT_PAUSE,
    CONTACT_SIZE,
    Contact,
)
from hunav_drake.systems.robot.discs import closing_speeds, gaps

# Speeds of approach that differ by less are equal, in m/s.
SPEED_RESOLUTION = 1e-6

# A row of memory is a row of `contacts`, then the time since the last touch,
# in seconds, and the speeds at which the robot and the person have closed in
# on each other of late, in m/s.
SINCE, ROBOT_SPEED, PERSON_SPEED = range(CONTACT_SIZE, CONTACT_SIZE + 3)
MEMORY_SIZE = CONTACT_SIZE + 3


def remember_speeds(memory: Array, robot: Array, humans: Array) -> None:
    """Writes how fast robot and people close in now, for contacts to come.

    Args:
        memory: Shape (n, MEMORY_SIZE), changed.
        robot: As for `closing_speeds`.
        humans: See there.
    """
    memory[:, ROBOT_SPEED], memory[:, PERSON_SPEED] = closing_speeds(
        robot, humans
    )


def count_contacts(
    memory: Array,
    touching: Mask,
    forces: Array | None,
    robot: Array,
    humans: Array,
    bodies: Array,
    duration: float,
) -> Array:
    """Returns the memory of contacts at the end of a step.

    Where a contact begins, it is charged to who closed in faster, or to both
    if they are equally fast (the rule of SEAN), but to nobody who did not
    close in. What counts is the larger of the speeds now and those that
    `remember_speeds` wrote: bodies are stopped, or pushed, in the very step in
    which they touch.

    Args:
        memory: Shape (n, MEMORY_SIZE), at the start of the step.
        touching: Shape (n,): who touches the robot in this step.
        forces: Shape (n, 2): the forces of people on the robot in W, in
            newtons; None where nothing computes them.
        robot: Shape (7,), a row of ``robot_state`` at the start of the step.
        humans: Shape (n, 6) or more columns, rows of ``human_states`` then.
        bodies: Shape (n,), the radii of their bodies, in meters.
        duration: The length of the step, in seconds.

    Returns:
        Shape (n, MEMORY_SIZE).
    """
    lasted = memory[:, Contact.LASTS] > 0
    if not (touching.any() or lasted.any()):
        return memory
    after = memory.copy()
    stay = touching | (lasted & (gaps(robot, humans, bodies) < CONTACT_GAP))
    after[:, SINCE] = np.where(stay, 0.0, memory[:, SINCE] + duration)
    lasts = stay | (lasted & (after[:, SINCE] < CONTACT_PAUSE))
    after[:, Contact.LASTS] = lasts
    begins = touching & ~lasted
    if begins.any():
        now = closing_speeds(robot, humans)
        a = np.maximum(memory[:, ROBOT_SPEED], now[0])
        b = np.maximum(memory[:, PERSON_SPEED], now[1])
        least = SPEED_RESOLUTION
        after[:, Contact.BY_ROBOT] += begins & (a > least) & (a >= b - least)
        after[:, Contact.BY_PERSON] += begins & (b > least) & (b >= a - least)
        # (Both speeds of one instant, as one may step back from the other.)
        closing = np.maximum(
            now[0] + now[1], memory[:, ROBOT_SPEED] + memory[:, PERSON_SPEED]
        )
        after[begins, Contact.RELATIVE_SPEED] = np.maximum(closing, 0)[begins]
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
