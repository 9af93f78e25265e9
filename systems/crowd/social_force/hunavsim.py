"""One step of the social force model by the rules of HuNavSim, compiled.

HuNavSim calls the form of `lightsfm` that is for one agent at a time, and then
moves that agent. This keeps its order of operations, so that numbers are the
same bit for bit, and its rules where those of `kernel.py` differ:

- epsilon has no part in the social force, and theta counts however small;
- where the direction of an interaction is undefined, all of the social force
  is zero; people who stand on one another at different speeds push;
- the center of a group is summed from the person on, and a person without a
  direction to the goal has no gaze force;
- the push away from a robot is not bounded, and reverses inside the body;
- people who stop may keep their velocity, for others to see; people at rest
  look along x;
- people who react to the robot move one after the other, from the last row to
  the first: the forces on them are those once the people after them have moved;
- when they do not react, their time step has six decimals;
- a group has any number but -1.

HuNavSim keeps people in a hash table; the sums here go in its order, from the
last row to the first. Rows come in that order: see `hash_order`.
"""

import math

from numba import float64, void
import numpy as np

from hunav_drake.systems.common.kernels import (
    CHANGED,
    INTEGER,
    MATRIX,
    REAL,
    SNAPSHOT,
    VECTOR,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    GAZE_FORCE,
    GOAL_FORCE,
    OBSTACLE_FORCE,
    OMEGA,
    ROBOT_REPULSION_FORCE,
    SOCIAL_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    Hold,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    add_up,
    goal_force,
    group_force,
    point_force,
    wall_force,
    wrap,
)
from hunav_drake.systems.people.parameters import (
    GAMMA,
    K_OBSTACLE,
    K_SOCIAL,
    LAMBDA,
    N_PRIME,
    SIGMA,
    N,
)
from hunav_drake.systems.people.single_precision import bearing
from hunav_drake.systems.world.walls import opened

# Smaller distances to a robot count as this, in meters: forces are finite.
_NEAR = 1e-9


@jit
def _angle(x, y):
    """Returns the direction of a vector in (-pi, pi]; of (0, 0), 0."""
    return wrap(math.atan2(y, x))


@jit
def _pair_force(dx, dy, dvx, dvy, k):
    """Returns the social force of a person at (dx, dy), which may be NaN."""
    r = math.sqrt(dx * dx + dy * dy)
    nx = dx
    ny = dy
    if r > 0:
        nx = dx / r
        ny = dy / r
    ix = k[LAMBDA] * dvx + nx
    iy = k[LAMBDA] * dvy + ny
    length = math.sqrt(ix * ix + iy * iy)
    tx = ix / length
    ty = iy / length
    theta = wrap(_angle(nx, ny) - _angle(tx, ty))
    b = k[GAMMA] * length
    slowing = k[N_PRIME] * b * theta
    turning = k[N] * b * theta
    forward = -math.exp(-r / b - slowing * slowing)
    sideways = -np.sign(theta) * math.exp(-r / b - turning * turning)
    return (
        k[K_SOCIAL] * (forward * tx - sideways * ty),
        k[K_SOCIAL] * (forward * ty + sideways * tx),
    )


@jit
def _add_social_force(i, states, command, k, robots, out):
    """Adds the forces of all others, and of robots that are pedestrians."""
    fx = 0.0
    fy = 0.0
    # (Robots have the indices -1, -2, ...)
    last = 0
    if int(command[Command.ROBOT_ROLE]) == RobotRole.PEDESTRIAN:
        last = -len(robots)
    for j in range(len(states) - 1, last - 1, -1):
        if j == i:
            continue
        other = states[j] if j >= 0 else robots[-1 - j]
        gx, gy = _pair_force(
            other[X] - states[i, X],
            other[Y] - states[i, Y],
            states[i, VX] - other[VX],
            states[i, VY] - other[VY],
            k,
        )
        fx += gx
        fy += gy
    if math.isfinite(fx) and math.isfinite(fy):
        out[SOCIAL_FORCE] = fx
        out[SOCIAL_FORCE + 1] = fy


@jit
def _add_robot_forces(x, y, radius, command, k, robots, out):
    """Adds robots that are obstacles, and the push away from the nearest."""
    nearest = math.inf
    away_x = 0.0
    away_y = 0.0
    for j in range(len(robots)):
        if int(command[Command.ROBOT_ROLE]) == RobotRole.OBSTACLE:
            fx, fy = point_force(
                *(x, y, robots[j, X], robots[j, Y]), *(radius, k[K_OBSTACLE], k)
            )
            out[OBSTACLE_FORCE] += fx
            out[OBSTACLE_FORCE + 1] += fy
        dx = x - robots[j, X]
        dy = y - robots[j, Y]
        distance = math.sqrt(dx * dx + dy * dy)
        if 0 < distance < nearest:
            nearest = distance
            away_x = dx / distance
            away_y = dy / distance
    if command[Command.ROBOT_REPULSION] != 0 and nearest < math.inf:
        gap = nearest - radius
        if abs(gap) < _NEAR:
            gap = _NEAR
        # (The order of operations in which the gain is 20 sigma.)
        push = command[Command.ROBOT_REPULSION] / k[SIGMA] * (k[SIGMA] / gap)
        out[ROBOT_REPULSION_FORCE] = push * away_x
        out[ROBOT_REPULSION_FORCE + 1] = push * away_y


@jit
def _add_group_forces(i, ex, ey, states, radii, command, k, out):
    """Adds the three forces of the group that a person belongs to."""
    group = command[i, Command.GROUP_ID]
    if group == -1:
        return
    members = np.empty(len(states), np.int64)
    members[0] = i
    size = 1
    cx = states[i, X]
    cy = states[i, Y]
    for j in range(len(states) - 1, -1, -1):
        if j != i and command[j, Command.GROUP_ID] == group:
            members[size] = j
            size += 1
            cx += states[j, X]
            cy += states[j, Y]
    if size < 2:
        return
    group_force(
        *(i, members[:size], cx / size, cy / size, (ex, ey), states, radii, k),
        out[GAZE_FORCE:ROBOT_REPULSION_FORCE],
    )


@jit
def _add_forces(
    i, states, radii, command, parameters, robots, at_walls, walls, within, out
):
    """Writes all forces on a person into a row of zeros."""
    k = parameters[i]
    x = states[i, X]
    y = states[i, Y]
    reach, most = within
    out[GOAL_FORCE], out[GOAL_FORCE + 1], ex, ey = goal_force(
        x, y, states[i, VX], states[i, VY], command[i], k
    )
    if len(walls.solid) > 0:
        out[OBSTACLE_FORCE], out[OBSTACLE_FORCE + 1] = wall_force(
            *(x, y, at_walls[i, 0], at_walls[i, 1]), *(k, walls, reach, most)
        )
    _add_social_force(i, states, command[i], k, robots, out)
    _add_robot_forces(x, y, radii[i], command[i], k, robots, out)
    _add_group_forces(i, ex, ey, states, radii, command, k, out)
    add_up(out)


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER)
def social_forces(
    states, radii, command, parameters, robots, at_walls, table, reach, most
):
    """Returns the forces on n people; arguments as `kernel.social_forces`."""
    walls = opened(table)
    forces = np.zeros((len(states), FORCES_SIZE))
    # (A copy, like in `advance`: it is compiled for one type of states alone.)
    present = states.copy()
    for i in range(len(states)):
        _add_forces(
            *(i, present, radii, command, parameters, robots, at_walls),
            *(walls, (reach, most), forces[i]),
        )
    return forces


@jit
def _turned(state, command, time_step):
    """Returns the yaw after a turn towards the target of a command."""
    turn = wrap(command[Command.YAW_TARGET] - state[YAW])
    most = command[Command.TURN_RATE] * time_step
    return wrap(state[YAW] + min(max(turn, -most), most))


@jit
def _move(state, force, command, time_step, out):
    """Writes the state of a person one step later; `out` may be `state`."""
    hold = int(command[Command.HOLD])
    vx = state[VX]
    vy = state[VY]
    # (In single precision, pi is beyond pi.)
    yaw = wrap(state[YAW])
    omega = state[OMEGA]
    x = state[X]
    y = state[Y]
    if hold == Hold.STAND:
        vx = 0.0
        vy = 0.0
    elif hold == Hold.WALK:
        vx += force[TOTAL_FORCE] * time_step
        vy += force[TOTAL_FORCE + 1] * time_step
        speed = math.sqrt(vx * vx + vy * vy)
        cap = command[Command.MAX_SPEED]
        if speed > cap:
            vx = vx / speed * cap
            vy = vy / speed * cap
        yaw = _angle(vx, vy)
        omega = wrap(yaw - state[YAW]) / time_step
        x += vx * time_step
        y += vy * time_step
    if command[Command.TURN_RATE] > 0:
        yaw = _turned(state, command, time_step)
    if hold == Hold.STAND:
        omega = wrap(yaw - state[YAW]) / time_step
    out[X] = x
    out[Y] = y
    out[YAW] = yaw
    out[VX] = vx
    out[VY] = vy
    out[OMEGA] = omega


@jit
def _look_at_robot(robots, distance, out):
    """Turns a person who has moved to the nearest robot within a distance."""
    nearest = math.inf
    yaw = out[YAW]
    for j in range(len(robots)):
        dx = np.float32(robots[j, X]) - np.float32(out[X])
        dy = np.float32(robots[j, Y]) - np.float32(out[Y])
        away = np.sqrt(dx * dx + dy * dy)
        if away <= distance and away < nearest:
            nearest = away
            turn = bearing(dx, dy, yaw)
            out[YAW] = wrap(yaw + turn)


@jit_as(void, CHANGED, MATRIX, VECTOR, MATRIX, MATRIX, REAL)
def add_pushes(forces, states, radii, parameters, robots, radius):
    """Adds the forces of robots as obstacles of a radius to forces, in place.

    The arrays are those of `social_forces`, and its result.
    """
    for j in range(len(robots)):
        for i in range(len(states)):
            k = parameters[i]
            push = point_force(
                *(states[i, X], states[i, Y], robots[j, X], robots[j, Y]),
                *(radii[i] + radius, k[K_OBSTACLE], k),
            )
            for c in range(2):
                forces[i, OBSTACLE_FORCE + c] += push[c]
                forces[i, TOTAL_FORCE + c] += push[c]


@jit_as(float64[:, ::1], *SNAPSHOT, INTEGER, MATRIX, REAL)
def advance(
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
    """Returns the states of n people one step later, shape (n, 6).

    The yaw follows the velocity, and is 0 at rest. People who turn while
    walking have the turn rate of the walk. The first nine arguments are those
    of `social_forces`; then come its result, and the time step in seconds.
    """
    walls = opened(table)
    # Subtrees receive it as text.
    rounded_step = math.floor(time_step * 1e6 + 0.5) / 1e6
    # People who have moved already have their next states; the others do not.
    result = states.copy()
    force = np.zeros(FORCES_SIZE)
    for i in range(len(states) - 1, -1, -1):
        role = int(command[i, Command.ROBOT_ROLE])
        if role == RobotRole.UNSEEN_IN_TURN:
            for c in range(FORCES_SIZE):
                force[c] = 0.0
            _add_forces(
                *(i, result, radii, command, parameters, robots, at_walls),
                *(walls, (reach, most), force),
            )
        else:
            for c in range(FORCES_SIZE):
                force[c] = forces[i, c]
        step = rounded_step if role == RobotRole.UNSEEN else time_step
        _move(states[i], force, command[i], step, result[i])
        looks = command[i, Command.TURN_RATE] == 0
        if role == RobotRole.UNSEEN_IN_TURN and looks:
            _look_at_robot(robots, command[i, Command.YAW_TARGET], result[i])
        # (In HuNavSim's messages, the yaw is in single precision.)
        result[i, YAW] = np.float32(result[i, YAW])
    return result
