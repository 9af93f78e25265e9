"""The footprint of a round robot, and its cost on a map."""

import functools
import math

import numba
import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import READ_CELLS

# How far costmap_2d moves each corner away from the center, in meters.
PADDING = 0.01
_CORNERS = 16


@functools.lru_cache(maxsize=32)
def circle_footprint(radius: float, padding: float = PADDING) -> Array:
    """Returns the polygon that represents a round robot, shape (16, 2).

    Each coordinate is moved away from 0 by the padding, as in costmap_2d's
    `makeFootprintFromRadius` and `padFootprint`. All in meters.
    """
    angles = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
    corners = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    # (Rounding leaves some zeros slightly off, so costmap_2d moves them, too.)
    corners += padding * np.sign(corners)
    corners.setflags(write=False)
    return corners


@functools.lru_cache(maxsize=32)
def inscribed_radius(radius: float, padding: float = PADDING) -> float:
    """Returns the inradius of that outline, in meters."""
    p = circle_footprint(radius, padding)
    q = np.roll(p, -1, axis=0)
    areas = np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
    return float((areas / np.hypot(*(q - p).T)).min())


@jit
def _line_cost(costs, row, column, to_row, to_column):
    """Returns the highest cost on a line (Bresenham); -1 off the map."""
    rows, columns = costs.shape
    d_row = abs(to_row - row)
    d_column = abs(to_column - column)
    step_row = 1 if to_row >= row else -1
    step_column = 1 if to_column >= column else -1
    error = d_column - d_row
    highest = 0
    while True:
        if not (0 <= row < rows and 0 <= column < columns):
            return -1
        highest = max(highest, int(costs[row, column]))
        if row == to_row and column == to_column:
            return highest
        twice = 2 * error
        if twice > -d_row:
            error -= d_row
            column += step_column
        if twice < d_column:
            error += d_column
            row += step_row


@jit
def outline_cost(costs, ox, oy, resolution, x, y, yaw, polygon):
    """Returns the highest cost on the outline of a robot at a pose.

    The cells are those on the edges of `polygon`, shape (k, 2), in the robot's
    frame. -1 if the outline leaves the map.
    """
    c = math.cos(yaw)
    s = math.sin(yaw)
    highest = 0
    last = len(polygon) - 1
    row = 0
    column = 0
    for k in range(-1, last + 1):
        corner = last if k < 0 else k
        px = x + c * polygon[corner, 0] - s * polygon[corner, 1]
        py = y + s * polygon[corner, 0] + c * polygon[corner, 1]
        to_row = math.floor((py - oy) / resolution)
        to_column = math.floor((px - ox) / resolution)
        if k >= 0:
            cost = _line_cost(costs, row, column, to_row, to_column)
            if cost < 0:
                return -1
            highest = max(highest, cost)
        row = to_row
        column = to_column
    return highest


@jit_as(numba.int64, READ_CELLS, REAL, REAL, REAL, REAL, REAL, REAL, MATRIX)
def footprint_cost(costs, ox, oy, resolution, x, y, yaw, polygon):
    """Returns the highest cost on the outline of a robot: `outline_cost`."""
    return outline_cost(costs, ox, oy, resolution, x, y, yaw, polygon)
