"""The terms of the social force model, compiled by numba.

They keep the order of operations of `lightsfm`, so that they give its numbers
bit for bit. Where the formulas are undefined, they have the values that
`numpy_forces.py` states.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import (
    COHERENCE_FORCE,
    GAZE_FORCE,
    GOAL_FORCE,
    GROUP_REPULSION_FORCE,
    OBSTACLE_FORCE,
    ROBOT_REPULSION_FORCE,
    SOCIAL_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.common.sorting import stable_order
from hunav_drake.systems.crowd.social_force.constants import (
    MOST,
    REPULSION_FLOOR,
    THETA_ZERO,
)
from hunav_drake.systems.people.parameters import (
    EPSILON,
    GAMMA,
    K_COHERENCE,
    K_GAZE,
    K_GOAL,
    K_OBSTACLE,
    K_REPULSION,
    K_SOCIAL,
    LAMBDA,
    N_PRIME,
    SIGMA,
    TAU,
    N,
)
from hunav_drake.systems.world.nearest import shapes_within


@jit
def wrap(angle):
    """Returns the angle in (-pi, pi]."""
    if -math.pi < angle <= math.pi:
        return angle
    turned = angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)
    if turned <= -math.pi:
        return turned + 2 * math.pi
    return turned


@jit
def goal_force(x, y, vx, vy, command, k):
    """Returns the pull towards the goal, (fx, fy), and the direction (ex, ey).

    k_d (v_desired e - v) / tau; without a goal, or at it, -v / tau. The
    direction is a unit vector, or zero.
    """
    gx = command[Command.GOAL_X] - x
    gy = command[Command.GOAL_Y] - y
    distance = math.sqrt(gx * gx + gy * gy)
    if (
        command[Command.HAS_GOAL] == 0
        or distance <= command[Command.GOAL_RADIUS]
    ):
        return -vx / k[TAU], -vy / k[TAU], 0.0, 0.0
    ex = gx / distance
    ey = gy / distance
    speed = command[Command.DESIRED_SPEED]
    return (
        k[K_GOAL] * (ex * speed - vx) / k[TAU],
        k[K_GOAL] * (ey * speed - vy) / k[TAU],
        ex,
        ey,
    )


@jit
def pair_force(dx, dy, dvx, dvy, k):
    """Returns the social force of a person at (dx, dy) from here.

    (dvx, dvy) is the own velocity minus the other's, k the parameters.
    """
    r = math.sqrt(dx * dx + dy * dy)
    if r == 0:
        return 0.0, 0.0
    nx = dx / r
    ny = dy / r
    ix = k[LAMBDA] * dvx + nx
    iy = k[LAMBDA] * dvy + ny
    length = math.sqrt(ix * ix + iy * iy)
    if length == 0:
        return 0.0, 0.0
    tx = ix / length
    ty = iy / length
    b = k[GAMMA] * length
    # Two calls of atan2, where one would do, are what makes it bit-identical.
    theta = wrap(math.atan2(ny, nx) - math.atan2(ty, tx))
    theta = wrap(theta + k[EPSILON] * b)
    if abs(theta) < THETA_ZERO:
        theta = 0.0
    decay = -r / b
    slowing = k[N_PRIME] * b * theta
    turning = k[N] * b * theta
    forward = -math.exp(decay - slowing * slowing)
    sideways = -np.sign(theta) * math.exp(decay - turning * turning)
    return (
        k[K_SOCIAL] * (forward * tx - sideways * ty),
        k[K_SOCIAL] * (forward * ty + sideways * tx),
    )


@jit
def point_force(x, y, ox, oy, radius, factor, k):
    """Returns the force of an obstacle's nearest point (ox, oy)."""
    dx = x - ox
    dy = y - oy
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0:
        return 0.0, 0.0
    depth = min(-(distance - radius) / k[SIGMA], MOST)
    strength = factor * math.exp(depth)
    return strength * (dx / distance), strength * (dy / distance)


@jit
def wall_force(x, y, radius, factor, k, walls, reach, most):
    """Returns the sum over the shapes within reach, or the nearest `most`."""
    fx = 0.0
    fy = 0.0
    if len(walls.solid) == 0:
        return fx, fy
    near = shapes_within(x, y, reach, most, walls)
    for i in range(len(near)):
        gx, gy = point_force(x, y, near[i, 0], near[i, 1], radius, factor, k)
        fx += gx
        fy += gy
    return fx, fy


@jit
def add_group_forces(directions, states, radii, command, parameters, forces):
    """Writes the three group forces on everybody into the rows of forces."""
    order = stable_order(command[:, Command.GROUP_ID].copy())
    hi = 0
    while hi < len(order):
        lo = hi
        group = command[order[lo], Command.GROUP_ID]
        while hi < len(order) and command[order[hi], Command.GROUP_ID] == group:
            hi += 1
        if group < 0 or hi - lo < 2:
            continue
        cx = 0.0
        cy = 0.0
        for a in range(lo, hi):
            cx += states[order[a], X]
            cy += states[order[a], Y]
        cx /= hi - lo
        cy /= hi - lo
        for a in range(lo, hi):
            i = order[a]
            group_force(
                i,
                order[lo:hi],
                cx,
                cy,
                directions[i],
                states,
                radii,
                parameters[i],
                forces[i, GAZE_FORCE:ROBOT_REPULSION_FORCE],
            )


@jit
def group_force(i, members, cx, cy, direction, states, radii, k, out):
    """Writes the three forces of a group centered at (cx, cy) on person i."""
    x = states[i, X]
    y = states[i, Y]
    ex = direction[0]
    ey = direction[1]
    size = len(members)

    others = 1 / (size - 1)
    dx = others * (size * cx - x) - x
    dy = others * (size * cy - y) - y
    along = ex * dx + ey * dy
    # Beyond 90 degrees from where the person heads. (The cosine decides.)
    if along < 0:
        back = along / (ex * ex + ey * ey)
        out[0] = back * ex * k[K_GAZE]
        out[1] = back * ey * k[K_GAZE]

    dx = cx - x
    dy = cy - y
    distance = math.sqrt(dx * dx + dy * dy)
    softened = math.tanh(distance - (size - 1) / 2) + 1
    out[2] = dx * (k[K_COHERENCE] * softened / 2)
    out[3] = dy * (k[K_COHERENCE] * softened / 2)

    for j in members:
        if j != i:
            dx = x - states[j, X]
            dy = y - states[j, Y]
            if math.sqrt(dx * dx + dy * dy) < radii[i] + radii[j]:
                out[4] += dx
                out[5] += dy
    out[4] *= k[K_REPULSION]
    out[5] *= k[K_REPULSION]


@jit
def add_up(out):
    """Writes the total of a row of forces."""
    for c in range(2):
        group = (
            out[GAZE_FORCE + c]
            + out[COHERENCE_FORCE + c]
            + out[GROUP_REPULSION_FORCE + c]
        )
        out[TOTAL_FORCE + c] = (
            out[GOAL_FORCE + c]
            + out[SOCIAL_FORCE + c]
            + out[OBSTACLE_FORCE + c]
            + group
            + out[ROBOT_REPULSION_FORCE + c]
        )


@jit
def add_robot_forces(x, y, vx, vy, radius, command, k, robots, out):
    """Adds the forces of the robots, in the role that the command gives."""
    nearest = math.inf
    away_x = 0.0
    away_y = 0.0
    for j in range(len(robots)):
        dx = robots[j, X] - x
        dy = robots[j, Y] - y
        if int(command[Command.ROBOT_ROLE]) == RobotRole.PEDESTRIAN:
            fx, fy = pair_force(
                dx, dy, vx - robots[j, VX], vy - robots[j, VY], k
            )
            out[SOCIAL_FORCE] += fx
            out[SOCIAL_FORCE + 1] += fy
        elif int(command[Command.ROBOT_ROLE]) == RobotRole.OBSTACLE:
            fx, fy = point_force(
                *(x, y, robots[j, X], robots[j, Y]), *(radius, k[K_OBSTACLE], k)
            )
            out[OBSTACLE_FORCE] += fx
            out[OBSTACLE_FORCE + 1] += fy
        distance = math.sqrt(dx * dx + dy * dy)
        if distance < nearest and distance > 0:
            nearest = distance
            away_x = -dx / distance
            away_y = -dy / distance
    if command[Command.ROBOT_REPULSION] != 0 and nearest < math.inf:
        push = command[Command.ROBOT_REPULSION] / max(
            nearest - radius, REPULSION_FLOOR
        )
        out[ROBOT_REPULSION_FORCE] = push * away_x
        out[ROBOT_REPULSION_FORCE + 1] = push * away_y
