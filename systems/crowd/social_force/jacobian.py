"""The derivatives of one step of the social force model, compiled by numba.

They are those of the results of `kernel.py`, by the rows of `human_states`
without the radii, and of `robot_states`: a column for each element of the n
rows (x, y, yaw, vx, vy, omega), then one for each of the m rows (x, y, yaw,
vx, vy, omega, radius). See `jacobian_terms.py` for where there is none.
"""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    SNAPSHOT,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import (
    OMEGA,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
)
from hunav_drake.systems.crowd.social_force.compiled_forces import wrap
from hunav_drake.systems.crowd.social_force.constants import SHORT, YAW_SPEED
from hunav_drake.systems.crowd.social_force.jacobian_pairs import (
    ROBOT,
    STATE,
    add_pairs,
)
from hunav_drake.systems.crowd.social_force.jacobian_terms import (
    add_block,
    add_group_derivatives,
    add_robot_derivatives,
    wall_derivative,
)
from hunav_drake.systems.people.parameters import K_GOAL, TAU
from hunav_drake.systems.world.walls import opened


@jit
def _own(i, states, radii, felt, command, k, walls, reach, most, robots, rows):
    """Adds the derivatives by the own state, after those by the others."""
    n = len(states)
    x = states[i, X]
    y = states[i, Y]
    ex = 0.0
    ey = 0.0
    per_distance = 0.0
    damping = -1 / k[TAU]
    gx = command[i, Command.GOAL_X] - x
    gy = command[i, Command.GOAL_Y] - y
    distance = math.sqrt(gx * gx + gy * gy)
    if (
        command[i, Command.HAS_GOAL] != 0
        and distance > command[i, Command.GOAL_RADIUS]
    ):
        ex = gx / distance
        ey = gy / distance
        damping = -k[K_GOAL] / k[TAU]
        if distance >= SHORT:
            per_distance = 1 / distance
    turn = damping * command[i, Command.DESIRED_SPEED] * per_distance
    xx, xy, yy = wall_derivative(x, y, felt, k, walls, reach, most)
    xx += turn * ey * ey
    xy -= turn * ex * ey
    yy += turn * ex * ex
    yx = xy
    if command[i, Command.GROUP_ID] >= 0:
        own = add_group_derivatives(
            i, ex, ey, per_distance, states, radii, command, k, rows
        )
        xx += own[0]
        xy += own[1]
        yx += own[2]
        yy += own[3]
    vxx = damping
    vxy = 0.0
    vyx = 0.0
    vyy = damping
    for j in range(n + len(robots)):
        c = STATE * j if j < n else STATE * n + ROBOT * (j - n)
        if j != i:
            xx -= rows[0, c]
            xy -= rows[0, c + 1]
            yx -= rows[1, c]
            yy -= rows[1, c + 1]
            vxx -= rows[0, c + VX]
            vxy -= rows[0, c + VY]
            vyx -= rows[1, c + VX]
            vyy -= rows[1, c + VY]
    add_block(rows, STATE * i, xx, xy, yx, yy)
    add_block(rows, STATE * i + VX, vxx, vxy, vyx, vyy)


@jit
def _step(i, states, forces, command, time_step, rows, out, own):
    """Writes the derivatives of a person's next state from those of the force.

    `rows` (2, c) are the latter, `out` (6, c); `own` is the column of the own
    x.
    """
    vx = states[i, VX] + forces[i, TOTAL_FORCE] * time_step
    vy = states[i, VY] + forces[i, TOTAL_FORCE + 1] * time_step
    keep = 0.0 if command[i, Command.HOLD] != 0 else 1.0
    vx *= keep
    vy *= keep
    mxx = keep
    mxy = 0.0
    myy = keep
    speed = math.sqrt(vx * vx + vy * vy)
    cap = command[i, Command.MAX_SPEED]
    if speed > cap:
        ux = vx / speed
        uy = vy / speed
        ratio = cap / speed
        mxx = ratio * uy * uy
        mxy = -ratio * ux * uy
        myy = ratio * ux * ux
        vx = ux * cap
        vy = uy * cap
        speed = cap
    yaw_x = 0.0
    yaw_y = 0.0
    yaw_yaw = 1.0
    if command[i, Command.TURN_RATE] > 0:
        turn = wrap(command[i, Command.YAW_TARGET] - states[i, YAW])
        if abs(turn) <= command[i, Command.TURN_RATE] * time_step:
            yaw_yaw = 0.0
    elif speed >= YAW_SPEED:
        yaw_x = -vy / (speed * speed)
        yaw_y = vx / (speed * speed)
        yaw_yaw = 0.0
    rows[0, own + VX] += 1 / time_step
    rows[1, own + VY] += 1 / time_step
    for c in range(rows.shape[1]):
        fx = rows[0, c] * time_step
        fy = rows[1, c] * time_step
        gx = mxx * fx + mxy * fy
        gy = mxy * fx + myy * fy
        yaw = yaw_x * gx + yaw_y * gy
        out[X, c] = gx * time_step
        out[Y, c] = gy * time_step
        out[YAW, c] = yaw
        out[VX, c] = gx
        out[VY, c] = gy
        out[OMEGA, c] = yaw / time_step
    out[X, own + X] += 1.0
    out[Y, own + Y] += 1.0
    out[YAW, own + YAW] += yaw_yaw
    out[OMEGA, own + YAW] += (yaw_yaw - 1) / time_step


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER)
def force_jacobian(
    states, radii, command, parameters, robots, at_walls, table, reach, most
):
    """Returns the derivatives of the total forces on n people.

    The arguments are those of `kernel.social_forces`. A row for each x and y of
    the forces makes the shape (2n, 6n + 7m): see the module for the columns.
    """
    walls = opened(table)
    n = len(states)
    result = np.zeros((2 * n, STATE * n + ROBOT * len(robots)))
    add_pairs(states, command, parameters, robots, result)
    for i in range(n):
        rows = result[2 * i : 2 * i + 2]
        k = parameters[i]
        add_robot_derivatives(
            i, states, radii, command, k, robots, rows, STATE * n
        )
        _own(
            *(i, states, radii, at_walls[i], command, k),
            *(walls, reach, most, robots, rows),
        )
    return result


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER, MATRIX, REAL)
def step_jacobian(
    states,
    radii,
    command,
    parameters,
    robots,
    at_walls,
    table,
    reach,
    most,
    forces,
    time_step,
):
    """Returns the derivatives of the next states of n people: (6n, 6n + 7m).

    The first nine arguments are those of `kernel.social_forces`; then come the
    forces that it gives, and the time step in seconds. A row is for an element
    of the next states; see the module for the columns.
    """
    n = len(states)
    rows = force_jacobian(
        *(states, radii, command, parameters, robots, at_walls),
        *(table, reach, most),
    )
    result = np.empty((STATE * n, rows.shape[1]))
    for i in range(n):
        _step(
            i,
            states,
            forces,
            command,
            time_step,
            rows[2 * i : 2 * i + 2],
            result[STATE * i : STATE * (i + 1)],
            STATE * i,
        )
    return result
