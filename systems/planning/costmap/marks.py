"""The marks of a lidar on a map, as a value in the Context."""

from typing import NamedTuple

import numpy as np

from hunav_drake.systems.world.maps.costs import FREE, Costs, Region

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


def moved(marks: Marks, region: Region) -> Costs:
    """Returns a copy of the costs on another region; other cells are free."""
    result = np.full((region.rows, region.columns), FREE, dtype=np.uint8)
    rows, columns = marks.costs.shape
    up, left = region.row - marks.row, region.column - marks.column
    r0, r1 = max(up, 0), min(up + region.rows, rows)
    c0, c1 = max(left, 0), min(left + region.columns, columns)
    if r0 < r1 and c0 < c1:
        part = marks.costs[r0:r1, c0:c1]
        result[r0 - up : r1 - up, c0 - left : c1 - left] = part
    return result
