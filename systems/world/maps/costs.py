"""Costmaps: the costs of cells, as in Nav2's costmap_2d."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Costs = NDArray[np.uint8]

# The costs of the center of the robot in a cell.
FREE = 0
# The robot touches an obstacle at any heading.
INSCRIBED = 253
# The cell is occupied.
LETHAL = 254
UNKNOWN = 255

# The largest number of cells of a map: its distances take 200 MB.
MOST_CELLS = 25_000_000


class Costmap(NamedTuple):
    """Costs on a grid with axes along those of W.

    Attributes:
        costs: Shape (rows, columns), of type uint8: 0 free, 1 to 252 graded,
            253 inscribed, 254 lethal, 255 unknown. Rows go up along y.
        origin: The lower left corner (x, y) of cell [0, 0], in W, in meters.
        resolution: The side of a cell, in meters.
    """

    costs: Costs
    origin: tuple[float, float]
    resolution: float

    def cell_at(self, x: float, y: float) -> tuple[int, int]:
        """Returns the cell (row, column) of a point in W.

        It need not be on the map.
        """
        return (
            math.floor((y - self.origin[1]) / self.resolution),
            math.floor((x - self.origin[0]) / self.resolution),
        )

    def center_of(self, row: int, column: int) -> tuple[float, float]:
        """Returns the center (x, y) of a cell, in W, in meters."""
        return (
            self.origin[0] + (column + 0.5) * self.resolution,
            self.origin[1] + (row + 0.5) * self.resolution,
        )

    def cost_at(self, x: float, y: float) -> int:
        """Returns the cost at a point in W; 255 off the map."""
        row, column = self.cell_at(x, y)
        rows, columns = self.costs.shape
        if 0 <= row < rows and 0 <= column < columns:
            return int(self.costs[row, column])
        return UNKNOWN


_NO_COSTS: Costs = np.zeros((0, 0), dtype=np.uint8)
_NO_COSTS.setflags(write=False)

# A map without cells, for systems without a map.
NO_MAP = Costmap(_NO_COSTS, (0.0, 0.0), 1.0)


class Region(NamedTuple):
    """A part of the lattice that all maps of one resolution share.

    The center of cell (i, j) of the lattice is at ``resolution * (j, i)``, in
    W. So maps of one resolution are parts of each other, and those that move
    with a robot move by whole cells. Paths on a map that is twice as coarse lie
    on centers of cells, not on edges, where rounding would choose the side.

    Attributes:
        row: The first row.
        column: The first column.
        rows: The number of rows.
        columns: The number of columns.
        resolution: The side of a cell, in meters.
    """

    row: int
    column: int
    rows: int
    columns: int
    resolution: float

    @property
    def origin(self) -> tuple[float, float]:
        """The lower left corner (x, y), in W, in meters."""
        return (
            (self.column - 0.5) * self.resolution,
            (self.row - 0.5) * self.resolution,
        )

    def as_map(self, costs: Costs) -> Costmap:
        """Returns costs on this region as a map."""
        return Costmap(costs, self.origin, self.resolution)


def region_around(x: float, y: float, side: float, resolution: float) -> Region:
    """Returns a square region centered on a point in W, to half a cell.

    The sides of the square and of a cell are in meters.
    """
    cells = max(1, round(side / resolution))
    half = 0.5 * cells * resolution
    return Region(
        math.floor((y - half) / resolution + 1.0),
        math.floor((x - half) / resolution + 1.0),
        cells,
        cells,
        resolution,
    )


def region_of(
    low: tuple[float, float],
    high: tuple[float, float],
    resolution: float,
    *,
    most: float = MOST_CELLS,
) -> Region:
    """Returns the smallest region that covers a rectangle.

    Args:
        low: The lower left corner (x, y), in W, in meters.
        high: The upper right corner.
        resolution: The side of a cell, in meters.
        most: The largest number of cells.

    Raises:
        ValueError: If it has more, by default than 25 million.
    """
    column, row = (math.floor(c / resolution + 0.5 + 1e-9) for c in low)
    columns = math.ceil(high[0] / resolution + 0.5 - 1e-9) - column
    rows = math.ceil(high[1] / resolution + 0.5 - 1e-9) - row
    columns, rows = max(columns, 1), max(rows, 1)
    if columns * rows > most:
        least = resolution * math.sqrt(columns * rows / most)
        least = math.ceil(1000 * least) / 1000
        raise ValueError(
            f"a resolution must give at most {most:.0f} cells, got"
            f" {resolution:g} m, which gives {rows} x {columns}; take a coarser"
            f" one, {least:g} m at least, or a smaller world"
        )
    return Region(row, column, rows, columns, resolution)
