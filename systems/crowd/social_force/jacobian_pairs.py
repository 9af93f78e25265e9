"""The derivatives of the forces between people, as vector instructions.

They are written out by hand, for the force of Moussaid et al. 2009, eqs. 4-6,
and computed like the forces of the fast kernel: many pairs at a time, and once
for both people of a pair if all have the same weights.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import VX, VY, Command, RobotRole, X, Y
from hunav_drake.systems.crowd.social_force.constants import (
    LEAST,
    SHORT,
    THETA_ZERO,
)
from hunav_drake.systems.crowd.social_force.elementary import (
    arctan2,
    exp_negative,
)
from hunav_drake.systems.crowd.social_force.fast_kernel import alike
from hunav_drake.systems.people.parameters import (
    EPSILON,
    GAMMA,
    K_SOCIAL,
    LAMBDA,
    N_PRIME,
    N,
)

# The rows of the people's states, and of the robots'.
STATE, ROBOT = 6, 7

# The number of pairs that are computed in one go, and of those in a vector.
_PAIRS = 64
_LANES = 8


@jit
def _pair_derivatives(k, pairs, count):
    """Computes the derivatives of the social forces of some pairs.

    `pairs` holds 12 parts of _PAIRS elements, one for each of `count` pairs.
    The first four are given: the offsets of the others (x, y), and the own
    velocity minus the other's (x, y). The next four get the 2 x 2 derivatives
    by the position, row by row, and the last four those by the velocity.
    """
    weight = k[LAMBDA]
    gamma = k[GAMMA]
    per_gamma = 1 / gamma
    tilt = k[EPSILON] * gamma
    # A loop over the remainder of the last vector would cost more.
    for c in range((count + _LANES - 1) // _LANES * _LANES):
        dx = pairs[c]
        dy = pairs[_PAIRS + c]
        square = dx * dx + dy * dy
        r = math.sqrt(square)
        per_r = 1 / (r if r > 0 else 1.0)
        nx = dx * per_r
        ny = dy * per_r
        ix = weight * pairs[2 * _PAIRS + c] + nx
        iy = weight * pairs[3 * _PAIRS + c] + ny
        square_i = ix * ix + iy * iy
        defined = (r > 0) & (square_i >= SHORT * SHORT)
        size = math.sqrt(square_i if defined else 1.0)
        per_size = 1 / size
        tx = ix * per_size
        ty = iy * per_size
        b = gamma * size
        per_b = per_size * per_gamma
        cross = tx * ny - ty * nx
        dot = tx * nx + ty * ny if defined else 1.0
        theta = arctan2(cross, dot) + tilt * size
        turns = math.ceil(theta * (0.5 / math.pi) - 0.5)
        theta = theta - turns * (2 * math.pi)
        theta = 0.0 if abs(theta) < THETA_ZERO else theta
        side = -1.0 if theta < 0 else 1.0
        side = 0.0 if theta == 0.0 else side
        decay = -r * per_b
        slow = k[N_PRIME] * b
        turn = k[N] * b
        slowing = slow * theta
        turning = turn * theta
        # The force is ahead * t + left * (t turned by 90 degrees).
        strength = k[K_SOCIAL] if defined & (r < LEAST * b) else 0.0
        ahead = -strength * exp_negative(decay - slowing * slowing)
        left = -strength * side * exp_negative(decay - turning * turning)

        # The logarithms of ahead and left, by b at constant theta, and by
        # theta.
        shrink = -decay * per_b
        ahead_b = shrink - 2 * slowing * k[N_PRIME] * theta
        left_b = shrink - 2 * turning * k[N] * theta
        ahead_theta = -2 * slowing * slow
        left_theta = -2 * turning * turn

        # The direction n turns when d moves across, by q = (-ny, nx) / r. Then
        # the interaction grows by -cross per unit, and t turns by dot / size.
        # When d grows, only r does.
        differentiable = 1.0 if square >= SHORT * SHORT else 0.0
        qx = -ny * per_r * differentiable
        qy = nx * per_r * differentiable
        b_q = -gamma * cross
        turn_q = dot * per_size
        theta_q = 1 - turn_q - tilt * cross
        along = ahead * (ahead_b * b_q + ahead_theta * theta_q) - left * turn_q
        across = left * (left_b * b_q + left_theta * theta_q) + ahead * turn_q
        fx = along * tx - across * ty
        fy = along * ty + across * tx
        gx = -per_b * (ahead * tx - left * ty) * differentiable
        gy = -per_b * (ahead * ty + left * tx) * differentiable
        pairs[4 * _PAIRS + c] = fx * qx + gx * nx
        pairs[5 * _PAIRS + c] = fx * qy + gx * ny
        pairs[6 * _PAIRS + c] = fy * qx + gy * nx
        pairs[7 * _PAIRS + c] = fy * qy + gy * ny

        # When the velocity moves along t, the interaction grows; when across,
        # t turns.
        b_t = gamma * weight
        theta_t = tilt * weight
        along = ahead * (ahead_b * b_t + ahead_theta * theta_t)
        across = left * (left_b * b_t + left_theta * theta_t)
        fx = along * tx - across * ty
        fy = along * ty + across * tx
        turn_t = weight * per_size
        along = -turn_t * (ahead * ahead_theta + left)
        across = turn_t * (ahead - left * left_theta)
        gx = along * tx - across * ty
        gy = along * ty + across * tx
        pairs[8 * _PAIRS + c] = fx * tx - gx * ty
        pairs[9 * _PAIRS + c] = fx * ty + gx * tx
        pairs[10 * _PAIRS + c] = fy * tx - gy * ty
        pairs[11 * _PAIRS + c] = fy * ty + gy * tx


@jit
def add_pairs(states, command, parameters, robots, result):
    """Adds the derivatives of the forces of people and of robots like them.

    The result, of shape (2n, c), is added to; the other arguments are those of
    `kernel.social_forces`.
    """
    n = len(states)
    same = alike(parameters)
    pairs = np.zeros(12 * _PAIRS)
    who = np.empty((2, _PAIRS), dtype=np.int64)
    count = 0
    for i in range(n):
        # With the same weights, the forces of two are opposite.
        first = i + 1 if same else 0
        last = n
        if int(command[i, Command.ROBOT_ROLE]) == RobotRole.PEDESTRIAN:
            last += len(robots)
        for j in range(first, last):
            if j == i:
                continue
            rows = states if j < n else robots
            row = j if j < n else j - n
            pairs[count] = rows[row, X] - states[i, X]
            pairs[_PAIRS + count] = rows[row, Y] - states[i, Y]
            pairs[2 * _PAIRS + count] = states[i, VX] - rows[row, VX]
            pairs[3 * _PAIRS + count] = states[i, VY] - rows[row, VY]
            who[0, count] = i
            who[1, count] = j
            count += 1
            if count == _PAIRS:
                _pair_derivatives(parameters[i], pairs, count)
                _add_pair_blocks(pairs, count, who, n, same, result)
                count = 0
        if count > 0 and (i == n - 1 or not same):
            _pair_derivatives(parameters[i], pairs, count)
            _add_pair_blocks(pairs, count, who, n, same, result)
            count = 0


@jit
def _add_pair_blocks(pairs, count, who, n, same, result):
    """Adds the results of `_pair_derivatives`."""
    robots = STATE * n
    for c in range(count):
        i = who[0, c]
        j = who[1, c]
        column = STATE * j if j < n else robots + ROBOT * (j - n)
        _add_pair_block(pairs, c, result, 2 * i, column)
        if same and j < n:
            _add_pair_block(pairs, c, result, 2 * j, STATE * i)


@jit
def _add_pair_block(pairs, c, result, row, column):
    for r in range(2):
        for d in range(2):
            by_place = pairs[(4 + 2 * r + d) * _PAIRS + c]
            by_velocity = pairs[(8 + 2 * r + d) * _PAIRS + c]
            result[row + r, column + X + d] += by_place
            result[row + r, column + VX + d] -= by_velocity
