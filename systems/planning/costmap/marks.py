"""The marks of a lidar on a map, as a value in the Context."""

from typing import NamedTuple

import numpy as np

from hunav_drake.systems.world.maps.costs import Costs

_NO_MARKS: Costs = np.zeros((0, 0), dtype=np.uint8)
_NO_MARKS.setflags(write=False)


class Marks(NamedTuple):
    """The cells that a lidar has hit and not cleared since.

    Attributes:
        row: The first row of their `Region`.
        column: The first column.
        costs: Shape (rows, columns): 254 where marked, else 0; read-only.
    """

    row: int = 0
    column: int = 0
    costs: Costs = _NO_MARKS
