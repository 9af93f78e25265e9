"""The costs that people have around them, compiled by numba."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import CELLS

# The turn to a person's right that the original takes, in radians.
_RIGHT = 1.57

# Where the parameters of `add_people` are.
AMPLITUDE, CUTOFF, STILL, FRONT, SIDE, REAR, REAR_SIDE = range(7)
RIGHT, RIGHT_SIDE, SPEED_FACTOR, USE_RIGHT = range(7, 11)
STANDING_SPEED = 0.1


@jit
def _reach(x, p):
    """Returns where a Gaussian of a variance falls below the cutoff."""
    return math.sqrt(2 * x * math.log(p[AMPLITUDE] / p[CUTOFF]))


@jit_as(numba.void, CELLS, REAL, REAL, REAL, MATRIX, VECTOR)
def add_people(costs, ox, oy, resolution, people, p):
    """Writes the costs of people where they are above those that are there.

    Unknown cells stay so. `people` has shape (n, 4), rows (x, y, vx, vy).
    """
    if p[CUTOFF] >= p[AMPLITUDE]:
        return
    rows, columns = costs.shape
    most = math.log(p[AMPLITUDE] / p[CUTOFF]) * (1 + 1e-9)
    for i in range(len(people)):
        x, y, vx, vy = people[i]
        speed = math.hypot(vx, vy)
        still = speed < STANDING_SPEED
        front = p[FRONT] * (1 + speed * p[SPEED_FACTOR])
        c = 1.0
        s = 0.0
        cr = 0.0
        sr = -1.0
        # What the costs come to along x and y, to either side.
        if still:
            reach = _reach(p[STILL], p)
            x0 = y0 = -reach
            x1 = y1 = reach
        else:
            c = vx / speed
            s = vy / speed
            turn = math.atan2(vy, vx) - _RIGHT
            cr = math.cos(turn)
            sr = math.sin(turn)
            wide = max(p[REAR], p[REAR_SIDE])
            if p[USE_RIGHT] != 0:
                wide = max(wide, p[RIGHT], p[RIGHT_SIDE])
            reach = _reach(wide, p)
            # Half an ellipse ahead, and a disc.
            far = _reach(front, p)
            side = _reach(p[SIDE], p)
            ex = math.hypot(far * c, side * s)
            ey = math.hypot(far * s, side * c)
            x0 = -max(reach, ex if c < 0 else side * abs(s))
            x1 = max(reach, ex if c > 0 else side * abs(s))
            y0 = -max(reach, ey if s < 0 else side * abs(c))
            y1 = max(reach, ey if s > 0 else side * abs(c))
        low = max(0, math.floor((y + y0 - oy) / resolution))
        high = min(rows - 1, math.floor((y + y1 - oy) / resolution))
        left = max(0, math.floor((x + x0 - ox) / resolution))
        right = min(columns - 1, math.floor((x + x1 - ox) / resolution))
        for row in range(low, high + 1):
            dy = oy + (row + 0.5) * resolution - y
            for column in range(left, right + 1):
                dx = ox + (column + 0.5) * resolution - x
                if still:
                    q = (dx * dx + dy * dy) / (2 * p[STILL])
                else:
                    u = c * dx + s * dy
                    w = c * dy - s * dx
                    if u > 0:
                        q = u * u / (2 * front) + w * w / (2 * p[SIDE])
                    else:
                        q = u * u / (2 * p[REAR]) + w * w / (2 * p[REAR_SIDE])
                    u = cr * dx + sr * dy
                    if p[USE_RIGHT] != 0 and u > 0:
                        w = cr * dy - sr * dx
                        q = min(
                            q,
                            u * u / (2 * p[RIGHT])
                            + w * w / (2 * p[RIGHT_SIDE]),
                        )
                if q > most:
                    continue
                value = p[AMPLITUDE] * math.exp(-q)
                old = costs[row, column]
                if value >= p[CUTOFF] and old != 255 and value > old:
                    costs[row, column] = np.uint8(min(math.floor(value), 254))
