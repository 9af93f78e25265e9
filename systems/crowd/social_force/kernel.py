"""One step of the social force model, compiled by numba.

`social_forces` is the reference: it gives the numbers of `lightsfm` bit for
bit. `fast_kernel.py` computes the forces between people faster, to the last
few digits.
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
    FORCES_SIZE,
    GOAL_FORCE,
    MOTION_SIZE,
    OBSTACLE_FORCE,
    OMEGA,
    SOCIAL_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
)
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    add_group_forces,
    add_robot_forces,
    add_up,
    goal_force,
    pair_force,
    wall_force,
    wrap,
)
from hunav_drake.systems.crowd.social_force.constants import YAW_SPEED
from hunav_drake.systems.crowd.social_force.fast_kernel import people_forces
from hunav_drake.systems.world.walls import opened

# The argument for forces of people that are not known.
NOT_GIVEN = np.zeros((0, 2))


@jit
def _all_forces(
    states,
    radii,
    command,
    parameters,
    robots,
    at_walls,
    table,
    reach,
    most,
    people,
):
    """Computes all forces; those of people unless they are given."""
    walls = opened(table)
    n = len(states)
    forces = np.zeros((n, FORCES_SIZE))
    directions = np.zeros((n, 2))
    grouped = False
    for i in range(n):
        k = parameters[i]
        out = forces[i]
        x = states[i, X]
        y = states[i, Y]
        vx = states[i, VX]
        vy = states[i, VY]

        (
            out[GOAL_FORCE],
            out[GOAL_FORCE + 1],
            directions[i, 0],
            directions[i, 1],
        ) = goal_force(x, y, vx, vy, command[i], k)
        # Without walls there is no call, which would pass six arrays.
        if len(walls.solid) > 0:
            out[OBSTACLE_FORCE], out[OBSTACLE_FORCE + 1] = wall_force(
                *(x, y, at_walls[i, 0], at_walls[i, 1]),
                *(k, walls, reach, most),
            )
        if len(people) == n:
            out[SOCIAL_FORCE] = people[i, 0]
            out[SOCIAL_FORCE + 1] = people[i, 1]
        else:
            for j in range(n):
                if j != i:
                    fx, fy = pair_force(
                        states[j, X] - x,
                        states[j, Y] - y,
                        vx - states[j, VX],
                        vy - states[j, VY],
                        k,
                    )
                    out[SOCIAL_FORCE] += fx
                    out[SOCIAL_FORCE + 1] += fy
        if len(robots) > 0:
            add_robot_forces(
                *(x, y, vx, vy, radii[i]), *(command[i], k, robots, out)
            )
        grouped = grouped or command[i, Command.GROUP_ID] >= 0

    if grouped:
        add_group_forces(directions, states, radii, command, parameters, forces)
    for i in range(n):
        add_up(forces[i])
    return forces


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER)
def social_forces(
    states, radii, command, parameters, robots, at_walls, table, reach, most
):
    """Returns the forces on n people, from one snapshot of all of them."""
    return _all_forces(
        *(states, radii, command, parameters, robots, at_walls),
        *(table, reach, most),
        NOT_GIVEN,
    )


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER, REAL)
def fast_social_forces(
    states,
    radii,
    command,
    parameters,
    robots,
    at_walls,
    table,
    reach,
    most,
    error,
):
    """Returns the forces like `social_forces`, but by `people_forces`.

    The last argument is the error of the latter.
    """
    people = people_forces(states, parameters, error)
    return _all_forces(
        *(states, radii, command, parameters, robots, at_walls),
        *(table, reach, most),
        people,
    )


@jit_as(float64[:, ::1], MATRIX, MATRIX, MATRIX, REAL)
def advance(states, forces, command, time_step):
    """Returns the states of n people one step later (semi-implicit Euler).

    Only the total of the forces counts. The yaw follows the velocity, unless
    the command turns it; a person who hardly moves keeps it.
    """
    result = np.empty((len(states), MOTION_SIZE))
    for i in range(len(states)):
        vx = states[i, VX] + forces[i, TOTAL_FORCE] * time_step
        vy = states[i, VY] + forces[i, TOTAL_FORCE + 1] * time_step
        if command[i, Command.HOLD] != 0:
            vx = 0.0
            vy = 0.0
        speed = math.sqrt(vx * vx + vy * vy)
        cap = command[i, Command.MAX_SPEED]
        if speed > cap:
            vx = vx / speed * cap
            vy = vy / speed * cap
            speed = cap
        yaw = states[i, YAW]
        if command[i, Command.TURN_RATE] > 0:
            turn = wrap(command[i, Command.YAW_TARGET] - yaw)
            most = command[i, Command.TURN_RATE] * time_step
            yaw = wrap(yaw + min(max(turn, -most), most))
        elif speed >= YAW_SPEED:
            yaw = math.atan2(vy, vx)
        result[i, X] = states[i, X] + vx * time_step
        result[i, Y] = states[i, Y] + vy * time_step
        result[i, YAW] = yaw
        result[i, VX] = vx
        result[i, VY] = vy
        result[i, OMEGA] = wrap(yaw - states[i, YAW]) / time_step
    return result
