"""Samples and scores velocities for one cycle of DWB, by numba."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    jit_as,
)
from hunav_drake.systems.planning.costmap.raster import READ_CELLS
from hunav_drake.systems.planning.dwb.map_grid import path_cells
from hunav_drake.systems.planning.dwb.scoring import (
    Critic,
    Latches,
    Targets,
    parameters_in,
    score_samples,
)

_COLUMNS = 1 + len(Critic)


@jit_as(numba.float64[::1], REAL, REAL, REAL, REAL, REAL, INTEGER, REAL)
def velocity_samples(now, low, high, rise, fall, count, time):
    """Returns reachable velocities of one axis, ascending.

    They are `count` >= 2 evenly spaced ones in [low, high] that can be reached
    from `now` within `time`, in seconds, at rates `rise` and `fall` < 0 per
    second. 0 is added if they have both signs.
    """
    now = min(max(now, low), high)
    low = max(low, now + fall * time)
    high = min(high, now + rise * time)
    if high - low < 1e-5:
        return np.full(1, low)
    step = (high - low) / (count - 1)
    samples = np.empty(count + 1)
    size = 0
    for k in range(count):
        value = low + k * step
        if k == count - 1:
            value = high
        if size > 0 and samples[size - 1] < 0 < value:
            samples[size] = 0.0
            size += 1
        samples[size] = value
        size += 1
    return samples[:size]


@jit_as(
    numba.types.Tuple(
        (
            *(numba.int64, numba.float64[::1], numba.float64[::1]),
            numba.float64[:, ::1],
        )
    ),
    *(VECTOR, VECTOR, MATRIX, READ_CELLS, REAL, REAL, REAL),
    *(VECTOR, MATRIX, VECTOR, numba.boolean),
)
def weigh_samples(
    state,
    goal,
    plan,
    costs,
    ox,
    oy,
    resolution,
    latches,
    polygon,
    parameters,
    every,
):
    """Samples velocities and scores them: see `score_samples`.

    `goal` is the end (x, y, yaw) of the global plan; `plan` the local plan,
    shape (k, 3), k > 0. `latches` are the mode of RotateToGoal (0 off, 1 slow
    down, 2 turn), and the signs that Oscillation allows for v and for w (0 for
    both). `every` is whether to finish all scores.

    Returns:
        The row of the best (-1 if all are rejected, -2 if the plan is not on
        the map), the samples of v and of w, and the scores.
    """
    p = parameters_in(parameters)
    vs = velocity_samples(
        *(state[3], p.low, p.high, p.acc_lim_x, p.decel_lim_x),
        *(int(p.speeds), p.reach_time),
    )
    ws = velocity_samples(
        *(state[4], -p.turn, p.turn, p.acc_lim_theta, p.decel_lim_theta),
        *(int(p.turns), p.reach_time),
    )
    scores = np.full((len(vs) * len(ws), _COLUMNS), math.inf)
    end_x = plan[-1, 0]
    end_y = plan[-1, 1]
    cells = path_cells(costs, ox, oy, resolution, plan, end_x, end_y)
    if cells.shape[1] == 0:
        return -2, vs, ws, scores
    dx = goal[0] - state[0]
    dy = goal[1] - state[1]
    far = math.hypot(dx, dy)
    ahead = p.forward_point_distance
    if far > 0:
        end_x += ahead * dx / far
        end_y += ahead * dy / far
    aligned = path_cells(costs, ox, oy, resolution, plan, end_x, end_y)
    if aligned.shape[1] == 0:
        aligned = np.full((2, 1), -1)
    targets = Targets(
        *(float(cells[0, -1]), float(cells[1, -1])),
        *(float(aligned[0, -1]), float(aligned[1, -1])),
        goal[2],
    )
    # PathAlign is off at the goal.
    switches = Latches(int(latches[0]), latches[1], latches[2], far > ahead)
    best = score_samples(
        *(state, vs, ws, (costs, ox, oy, resolution), cells, targets),
        *(switches, polygon, p, every, scores),
    )
    return best, vs, ws, scores
