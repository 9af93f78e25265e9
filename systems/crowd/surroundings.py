"""The desired velocities and surroundings of people, compiled by numba."""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import (
    COHERENCE_FORCE,
    FORCES_SIZE,
    GAZE_FORCE,
    GROUP_REPULSION_FORCE,
    RADIUS,
    ROBOT_REPULSION_FORCE,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd.orca.neighbors import cell_index
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    add_group_forces,
    add_robot_forces,
)
from hunav_drake.systems.people.parameters import K_GOAL, TAU

# The columns of the surroundings, of people and robots: offset, velocity, the
# distance at which they touch, and desired velocity.
AT_X, AT_Y, THEIR_VX, THEIR_VY, TOUCH, WISH_X, WISH_Y = range(7)

# Lengths that give no direction, in meters, or of sums of directions.
TINY = 1e-9


@jit
def goal_velocities(states, radii, command, parameters, robots, time_step):
    """Returns the velocities to the goals, and the other pulls on people.

    They have shape (n, 2), in m/s; and (n, FORCES_SIZE), in m/s^2: the forces
    of the group, and the robot's push.
    """
    n = len(states)
    wanted = np.zeros((n, 2))
    directions = np.zeros((n, 2))
    pulls = np.zeros((n, FORCES_SIZE))
    grouped = False
    for i in range(n):
        x = states[i, X]
        y = states[i, Y]
        gx = command[i, Command.GOAL_X] - x
        gy = command[i, Command.GOAL_Y] - y
        distance = math.hypot(gx, gy)
        if (
            command[i, Command.HAS_GOAL] != 0
            and distance > command[i, Command.GOAL_RADIUS]
        ):
            directions[i, 0] = gx / distance
            directions[i, 1] = gy / distance
            speed = min(command[i, Command.DESIRED_SPEED], distance / time_step)
            wanted[i] = speed * directions[i]
        if command[i, Command.ROBOT_REPULSION] != 0:
            add_robot_forces(
                *(x, y, states[i, VX], states[i, VY], radii[i], command[i]),
                *(parameters[i], robots, pulls[i]),
            )
        grouped = grouped or command[i, Command.GROUP_ID] >= 0
    if grouped:
        add_group_forces(directions, states, radii, command, parameters, pulls)
    return wanted, pulls


@jit
def wishes(states, radii, command, parameters, robots, time_step):
    """Returns the desired velocities (n, 2) of people.

    They are those to the goals, and those that the forces of the group and the
    robot's push add to them, where these and the goal's force balance.
    """
    n = len(states)
    wanted, pulls = goal_velocities(
        states, radii, command, parameters, robots, time_step
    )
    for i in range(n):
        time = parameters[i, TAU] / max(parameters[i, K_GOAL], TINY)
        for c in range(2):
            wanted[i, c] += time * (
                pulls[i, GAZE_FORCE + c]
                + pulls[i, COHERENCE_FORCE + c]
                + pulls[i, GROUP_REPULSION_FORCE + c]
                + pulls[i, ROBOT_REPULSION_FORCE + c]
            )
        speed = math.hypot(wanted[i, 0], wanted[i, 1])
        if command[i, Command.HOLD] != 0:
            wanted[i] = 0.0
        elif speed > command[i, Command.MAX_SPEED]:
            wanted[i] *= command[i, Command.MAX_SPEED] / speed
    return wanted


@jit
def look_around(
    i, states, radii, command, robots, wanted, cells, body, reach, rows
):
    """Writes the surroundings of a person: people within reach, and robots.

    Array `rows` receives them, and has room for all: see AT_X and following.
    Returns the number of rows written. `i` is the number of the person,
    `wanted` is from `wishes`, `cells` from `make_cells`. People have radii of
    at most `body` to each other, in meters, but their own to robots.
    """
    order, x, y, begin, left, bottom, width, columns, lines = cells
    px = states[i, X]
    py = states[i, Y]
    count = 0
    first = cell_index(px - reach - left, width, columns)
    last = cell_index(px + reach - left, width, columns)
    lowest = cell_index(py - reach - bottom, width, lines)
    highest = cell_index(py + reach - bottom, width, lines)
    for b in range(lowest, highest + 1):
        cell = b * columns
        for s in range(begin[cell + first], begin[cell + last + 1]):
            dx = x[s] - px
            dy = y[s] - py
            j = order[s]
            if j == i or dx * dx + dy * dy > reach * reach:
                continue
            row = rows[count]
            row[AT_X] = dx
            row[AT_Y] = dy
            row[THEIR_VX] = states[j, VX]
            row[THEIR_VY] = states[j, VY]
            row[TOUCH] = min(radii[i], body) + min(radii[j], body)
            row[WISH_X] = wanted[j, 0]
            row[WISH_Y] = wanted[j, 1]
            count += 1
    role = int(command[i, Command.ROBOT_ROLE])
    if role != RobotRole.PEDESTRIAN and role != RobotRole.OBSTACLE:
        return count
    for j in range(len(robots)):
        # An obstacle is not expected to move.
        moves = 1.0 if role == RobotRole.PEDESTRIAN else 0.0
        row = rows[count]
        row[AT_X] = robots[j, X] - px
        row[AT_Y] = robots[j, Y] - py
        row[THEIR_VX] = moves * robots[j, VX]
        row[THEIR_VY] = moves * robots[j, VY]
        row[TOUCH] = radii[i] + robots[j, RADIUS]
        row[WISH_X] = row[THEIR_VX]
        row[WISH_Y] = row[THEIR_VY]
        count += 1
    return count
