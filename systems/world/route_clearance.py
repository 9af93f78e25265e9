"""The clearance of people's ways from walls, without the compiler."""

import numpy as np
from numpy.typing import ArrayLike

# A door that everybody passes is a little wider than twice this, in meters.
LARGEST_CLEARANCE = 0.3


def route_clearance(radii: ArrayLike) -> float:
    """Returns the clearance of the ways of people with some radii, in meters.

    It is the largest radius, but at most 0.3 m: doors of 0.7 m are ways for
    everybody, as they are in reality for people who turn sideways.
    """
    largest = np.asarray(radii, dtype=float).max(initial=0.0)
    return min(float(largest), LARGEST_CLEARANCE)
