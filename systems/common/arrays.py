"""The types of arrays."""

import numpy as np
from numpy.typing import NDArray

# Of numbers, and of booleans.
Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
