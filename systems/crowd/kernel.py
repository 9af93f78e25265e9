"""One step of the social force model, compiled by numba.

The loops keep the order of operations of `lightsfm`, so that they give its
numbers to the last digits. What the formulas leave undefined has the value
that `social_force.py` states.
"""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.layout import (
    OMEGA,
    VX,
    VY,
    YAW,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.nearest import (
    INDICES,
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    jit,
    jit_as,
    nearest_on_segments,
)

# Numba reads plain integers of the module as constants.
_GOAL_X, _GOAL_Y = int(Command.GOAL_X), int(Command.GOAL_Y)
_GOAL_RADIUS, _HAS_GOAL = int(Command.GOAL_RADIUS), int(Command.HAS_GOAL)
_DESIRED_SPEED = int(Command.DESIRED_SPEED)
_MAX_SPEED = int(Command.MAX_SPEED)
_ROBOT_ROLE = int(Command.ROBOT_ROLE)
_ROBOT_REPULSION = int(Command.ROBOT_REPULSION)
_HOLD, _TURN_RATE = int(Command.HOLD), int(Command.TURN_RATE)
_YAW_TARGET, _GROUP_ID = int(Command.YAW_TARGET), int(Command.GROUP_ID)
_PEDESTRIAN = int(RobotRole.PEDESTRIAN)
_OBSTACLE = int(RobotRole.OBSTACLE)

# The columns of the parameters: the fields of SocialForceParameters in order.
(
    _K_GOAL,
    _TAU,
    _K_OBSTACLE,
    _SIGMA,
    _K_SOCIAL,
    _LAMBDA,
    _GAMMA,
    _N,
    _N_PRIME,
    _EPSILON,
    _K_GAZE,
    _K_COHERENCE,
    _K_REPULSION,
) = range(13)

# Angles smaller than this are rounding noise of an exact head-on encounter.
_THETA_ZERO = 1e-12

# The least distance to a robot's center that its extra push is computed for.
_REPULSION_FLOOR = 0.05

# A person slower than this keeps the yaw.
_YAW_SPEED = 1e-6


@jit
def _wrap(angle):
    """Returns the angle in (-pi, pi]."""
    if -math.pi < angle <= math.pi:
        return angle
    turned = angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)
    if turned <= -math.pi:
        return turned + 2 * math.pi
    return turned


@jit
def _pair_force(dx, dy, dvx, dvy, k):
    """Returns the social force of someone at (dx, dy) from here.

    (dvx, dvy) is the own velocity minus the other's, k the parameters.
    """
    r = math.sqrt(dx * dx + dy * dy)
    if r == 0:
        return 0.0, 0.0
    nx = dx / r
    ny = dy / r
    ix = k[_LAMBDA] * dvx + nx
    iy = k[_LAMBDA] * dvy + ny
    length = math.sqrt(ix * ix + iy * iy)
    if length == 0:
        return 0.0, 0.0
    tx = ix / length
    ty = iy / length
    b = k[_GAMMA] * length
    theta = math.atan2(tx * ny - ty * nx, tx * nx + ty * ny)
    theta = _wrap(theta + k[_EPSILON] * b)
    if abs(theta) < _THETA_ZERO:
        theta = 0.0
    decay = -r / b
    slowing = k[_N_PRIME] * b * theta
    turning = k[_N] * b * theta
    forward = -math.exp(decay - slowing * slowing)
    sideways = -np.sign(theta) * math.exp(decay - turning * turning)
    return (
        k[_K_SOCIAL] * (forward * tx - sideways * ty),
        k[_K_SOCIAL] * (forward * ty + sideways * tx),
    )


@jit
def _point_force(x, y, ox, oy, radius, k):
    """Returns the force of an obstacle's nearest point (ox, oy)."""
    dx = x - ox
    dy = y - oy
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0:
        return 0.0, 0.0
    strength = k[_K_OBSTACLE] * math.exp(-(distance - radius) / k[_SIGMA])
    return strength * (dx / distance), strength * (dy / distance)


@jit
def _wall_force(x, y, radius, k, segments, first, reach, most):
    """Returns the sum over the shapes within reach, or the nearest `most`."""
    shapes = len(first) - 1
    fx = 0.0
    fy = 0.0
    reach2 = reach * reach
    if most == 0 or most >= shapes:
        for i in range(shapes):
            ox, oy, d2 = nearest_on_segments(
                x, y, segments, first[i], first[i + 1]
            )
            if d2 <= reach2:
                gx, gy = _point_force(x, y, ox, oy, radius, k)
                fx += gx
                fy += gy
        return fx, fy
    points = np.empty((shapes, 3))
    for i in range(shapes):
        points[i] = nearest_on_segments(x, y, segments, first[i], first[i + 1])
    for _ in range(most):
        i = np.argmin(points[:, 2])
        if points[i, 2] > reach2:
            break
        gx, gy = _point_force(x, y, points[i, 0], points[i, 1], radius, k)
        fx += gx
        fy += gy
        points[i, 2] = math.inf
    return fx, fy


@jit
def _group_force(i, ex, ey, states, radii, command, k, out):
    """Writes the three group forces on person i into out (6)."""
    group = command[i, _GROUP_ID]
    out[:] = 0.0
    if group < 0:
        return
    members = 0
    cx = 0.0
    cy = 0.0
    for j in range(len(states)):
        if command[j, _GROUP_ID] == group:
            members += 1
            cx += states[j, X]
            cy += states[j, Y]
    if members < 2:
        return
    cx /= members
    cy /= members
    x = states[i, X]
    y = states[i, Y]

    others = 1 / (members - 1)
    dx = others * (members * cx - x) - x
    dy = others * (members * cy - y) - y
    along = ex * dx + ey * dy
    # Beyond 90 degrees from where the person heads. (The cosine decides.)
    if along < 0:
        out[0] = k[_K_GAZE] * (along * ex)
        out[1] = k[_K_GAZE] * (along * ey)

    dx = cx - x
    dy = cy - y
    distance = math.sqrt(dx * dx + dy * dy)
    softened = math.tanh(distance - (members - 1) / 2) + 1
    out[2] = dx * (k[_K_COHERENCE] * softened / 2)
    out[3] = dy * (k[_K_COHERENCE] * softened / 2)

    for j in range(len(states)):
        if j != i and command[j, _GROUP_ID] == group:
            dx = x - states[j, X]
            dy = y - states[j, Y]
            if math.sqrt(dx * dx + dy * dy) < radii[i] + radii[j]:
                out[4] += dx
                out[5] += dy
    out[4] *= k[_K_REPULSION]
    out[5] *= k[_K_REPULSION]


@jit_as(
    float64[:, ::1],
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, INDICES),
    *(REAL, INTEGER),
)
def social_forces(
    states, radii, command, parameters, robots, segments, first, reach, most
):
    """Returns the forces on n people, from one snapshot of all of them.

    Args:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega.
        radii: Shape (n,), in meters.
        command: Shape (n, COMMAND_SIZE).
        parameters: Shape (n, 13): the fields of SocialForceParameters.
        robots: Shape (m, 7): rows of `robot_state`.
        segments: Shape (s, 4): see Obstacles.
        first: Shape (k + 1,): see Obstacles.
        reach: Shapes farther than this are not felt, in meters.
        most: How many shapes are felt at most; 0 for all within reach.

    Returns:
        Shape (n, FORCES_SIZE), in m/s^2.
    """
    n = len(states)
    forces = np.zeros((n, 16))
    for i in range(n):
        k = parameters[i]
        out = forces[i]
        x = states[i, X]
        y = states[i, Y]
        vx = states[i, VX]
        vy = states[i, VY]

        ex = 0.0
        ey = 0.0
        gx = command[i, _GOAL_X] - x
        gy = command[i, _GOAL_Y] - y
        distance = math.sqrt(gx * gx + gy * gy)
        if command[i, _HAS_GOAL] != 0 and distance > command[i, _GOAL_RADIUS]:
            ex = gx / distance
            ey = gy / distance
            speed = command[i, _DESIRED_SPEED]
            out[0] = k[_K_GOAL] * (ex * speed - vx) / k[_TAU]
            out[1] = k[_K_GOAL] * (ey * speed - vy) / k[_TAU]
        else:
            out[0] = -vx / k[_TAU]
            out[1] = -vy / k[_TAU]

        out[2], out[3] = _wall_force(
            x, y, radii[i], k, segments, first, reach, most
        )
        for j in range(n):
            if j != i:
                fx, fy = _pair_force(
                    states[j, X] - x,
                    states[j, Y] - y,
                    vx - states[j, VX],
                    vy - states[j, VY],
                    k,
                )
                out[4] += fx
                out[5] += fy

        nearest = math.inf
        away_x = 0.0
        away_y = 0.0
        for j in range(len(robots)):
            dx = robots[j, X] - x
            dy = robots[j, Y] - y
            if command[i, _ROBOT_ROLE] == _PEDESTRIAN:
                fx, fy = _pair_force(
                    dx, dy, vx - robots[j, VX], vy - robots[j, VY], k
                )
                out[4] += fx
                out[5] += fy
            elif command[i, _ROBOT_ROLE] == _OBSTACLE:
                fx, fy = _point_force(
                    x, y, robots[j, X], robots[j, Y], radii[i], k
                )
                out[2] += fx
                out[3] += fy
            distance = math.sqrt(dx * dx + dy * dy)
            if distance < nearest and distance > 0:
                nearest = distance
                away_x = -dx / distance
                away_y = -dy / distance
        if command[i, _ROBOT_REPULSION] != 0 and nearest < math.inf:
            push = command[i, _ROBOT_REPULSION] / max(
                nearest - radii[i], _REPULSION_FLOOR
            )
            out[12] = push * away_x
            out[13] = push * away_y

        _group_force(i, ex, ey, states, radii, command, k, out[6:12])
        for c in range(2):
            group = out[6 + c] + out[8 + c] + out[10 + c]
            out[14 + c] = out[c] + out[4 + c] + out[2 + c] + group + out[12 + c]
    return forces


@jit_as(float64[:, ::1], MATRIX, MATRIX, MATRIX, REAL)
def advance(states, forces, command, time_step):
    """Returns where n people are one step later (semi-implicit Euler).

    Args:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega.
        forces: Shape (n, FORCES_SIZE); the last two columns count.
        command: Shape (n, COMMAND_SIZE).
        time_step: In seconds.

    Returns:
        Shape (n, 6). The yaw follows the velocity, unless the command turns
        it; a person who hardly moves keeps it.
    """
    result = np.empty((len(states), 6))
    for i in range(len(states)):
        vx = states[i, VX] + forces[i, 14] * time_step
        vy = states[i, VY] + forces[i, 15] * time_step
        if command[i, _HOLD] != 0:
            vx = 0.0
            vy = 0.0
        speed = math.sqrt(vx * vx + vy * vy)
        cap = command[i, _MAX_SPEED]
        if speed > cap:
            vx = vx / speed * cap
            vy = vy / speed * cap
            speed = cap
        yaw = states[i, YAW]
        if command[i, _TURN_RATE] > 0:
            turn = _wrap(command[i, _YAW_TARGET] - yaw)
            most = command[i, _TURN_RATE] * time_step
            yaw = _wrap(yaw + min(max(turn, -most), most))
        elif speed >= _YAW_SPEED:
            yaw = math.atan2(vy, vx)
        result[i, X] = states[i, X] + vx * time_step
        result[i, Y] = states[i, Y] + vy * time_step
        result[i, YAW] = yaw
        result[i, VX] = vx
        result[i, VY] = vy
        result[i, OMEGA] = _wrap(yaw - states[i, YAW]) / time_step
    return result
