"""The memory of MPPI between cycles."""

from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array

# The number of past commands that the smoothing uses.
PAST = 4

_NONE: Array = np.zeros((0, 2))
_NONE.setflags(write=False)
_STANDING: Array = np.zeros((PAST, 2))
_STANDING.setflags(write=False)


class MppiMemory(NamedTuple):
    """The last controls, and the cycle that the noise depends on.

    Attributes:
        controls: Shape (time_steps, 2), rows (v, omega), in m/s and rad/s;
            empty before the first cycle. Read-only.
        past: Shape (4, 2): the previous controls, the oldest first. Read-only.
        cycle: The number of past cycles.
    """

    controls: Array = _NONE
    past: Array = _STANDING
    cycle: int = 0
