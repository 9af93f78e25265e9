"""The end of a step of a crowd: bodies correct the proposed motion."""

import math
from typing import NamedTuple

from numba import float64, int64
from numba.types import NamedUniTuple, Tuple
import numpy as np

from hunav_drake.systems.common.kernels import (
    CHANGED,
    INTEGER,
    MATRIX,
    REAL,
    WALLS,
    jit_as,
)
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.crowd.bodies.contacts import robot_touches
from hunav_drake.systems.crowd.bodies.keep_apart import keep_apart
from hunav_drake.systems.crowd.bodies.rate_limits import limit_rates
from hunav_drake.systems.crowd.bodies.standing import stand
from hunav_drake.systems.crowd.walls.keep_out import keep_out_of_walls


class Options(NamedTuple):
    """The options of bodies; all are floats.

    Attributes:
        standing: Whether people stand where they want to: 1 or 0.
        keep_apart: Whether they are kept apart: 1 or 0.
        acceleration: The largest acceleration, in m/s^2; may be infinite.
        turn_rate: The largest turn rate, in rad/s; likewise.
        walled: Whether walls stop people: 1 or 0.
    """

    standing: float
    keep_apart: float
    acceleration: float
    turn_rate: float
    walled: float


@jit_as(float64[:, ::1], MATRIX, INTEGER)
def for_each_robot(states, robots):
    """Returns the positions (n, 2) of people once for each robot, (mn, 2)."""
    n = len(states)
    places = np.empty((robots * n, 2))
    for row in range(len(places)):
        places[row, X] = states[row % n, X]
        places[row, Y] = states[row % n, Y]
    return places


@late_as(
    Tuple((float64[:, ::1], float64[:, ::1])),
    *(MATRIX, CHANGED, MATRIX, MATRIX, CHANGED, MATRIX, MATRIX, WALLS),
    NamedUniTuple(float64, len(Options._fields), Options),
    *(REAL, INTEGER, int64[:, ::1], REAL),
)
def finish(
    before,
    after,
    forces,
    command,
    stances,
    robots,
    sizes,
    table,
    options,
    time_step,
    iterations,
    pairs,
    known,
):
    """Returns the states (n, 6) of n people at the end of a step.

    The second result is that of `robot_touches`. The arguments are those of
    `keep_apart`, but `after` may only be written to, and the stances change.

    People stand where they want to, change their velocity and heading at a
    limited rate, enter no wall, and overlap nobody. `Bodies` does the same in
    several calls, so that only what is needed is compiled, and also among
    robots that bodies stop.
    """
    is_limited = options.acceleration < math.inf or options.turn_rate < math.inf
    if options.standing != 0:
        stand(before, after, forces, command, stances, time_step)
    if is_limited or options.standing != 0:
        limit_rates(
            *(before, after, command),
            *(options.acceleration, options.turn_rate, time_step),
        )
    is_walled = options.walled != 0
    if is_walled:
        after = keep_out_of_walls(before, after, sizes[:, 1].copy(), table)
    free = for_each_robot(after, len(robots))
    if options.keep_apart != 0:
        is_moved = keep_apart(
            *(before, after, sizes, command, robots, table, is_walled),
            *(False, time_step, iterations, pairs, known, free),
        )
        if is_moved and is_walled:
            after = keep_out_of_walls(before, after, sizes[:, 1].copy(), table)
    bodies = sizes[:, 0].copy()
    return after, robot_touches(before, free, bodies, robots, time_step)
