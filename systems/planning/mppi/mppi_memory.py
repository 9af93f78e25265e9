"""What MPPI remembers from one cycle to the next."""

from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array

# How many past commands the smoothing looks at.
PAST = 4

_NONE: Array = np.zeros((0, 2))
_NONE.setflags(write=False)
_STANDING: Array = np.zeros((PAST, 2))
_STANDING.setflags(write=False)


class MppiMemory(NamedTuple):
    """The best controls so far, and what the noise follows from.

    Attributes:
        controls: Shape (time_steps, 2), rows (v, omega), in m/s and rad/s;
            empty before the first cycle. Read-only.
        past: Shape (4, 2): the controls before these, the oldest first.
            Read-only.
        cycle: How many cycles there were, which the noise depends on.
    """

    controls: Array = _NONE
    past: Array = _STANDING
    cycle: int = 0
