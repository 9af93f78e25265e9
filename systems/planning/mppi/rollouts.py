"""Rollouts of a differential drive under sampled controls, by numba."""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit

# The weights of a quadratic fit to nine points, at its center (Savitzky and
# Golay 1964, table I).
SMOOTHING = (
    -21 / 231,
    14 / 231,
    39 / 231,
    54 / 231,
    59 / 231,
    54 / 231,
    39 / 231,
    14 / 231,
    -21 / 231,
)


@jit
def command_of(step, hold):
    """Returns the command of a step, if each command holds for `hold` steps.

    The first step has the previous command; `hold` 0 is one command per step.
    """
    return step if hold <= 1 else (step + hold - 1) // hold


@jit
def toward(now, wanted, most):
    """Returns a velocity moved towards another by at most `most`."""
    return min(max(wanted, now - most), now + most)


@jit
def roll_out(state, controls, p, poses, velocities):
    """Predicts the motion of the robot.

    In the first step it keeps its velocity; in step k it follows control k - 1
    within its accelerations. Each step moves along the heading at its
    beginning. `state` is (x, y, yaw, v, omega). `poses` gets rows (x, y, yaw)
    at the ends of the steps, `velocities` rows (v, omega) during them.
    """
    dt = p.dt
    x = state[0]
    y = state[1]
    yaw = state[2]
    v = state[3]
    omega = state[4]
    for k in range(len(controls)):
        if k > 0:
            v = toward(v, controls[k - 1, 0], p.acc_v * dt)
            omega = toward(omega, controls[k - 1, 1], p.acc_turn * dt)
        x += v * math.cos(yaw) * dt
        y += v * math.sin(yaw) * dt
        yaw += omega * dt
        poses[k, 0] = x
        poses[k, 1] = y
        poses[k, 2] = yaw
        velocities[k, 0] = v
        velocities[k, 1] = omega


@jit
def limit(controls, state, p):
    """Limits controls, in place, to what the robot can do.

    A command that holds for several steps is limited to what the robot can
    reach by their end.
    """
    hold = int(p.hold)
    dt = p.dt
    v = state[3]
    omega = state[4]
    for k in range(len(controls)):
        if k == 0 or command_of(k, hold) != command_of(k - 1, hold):
            reach = dt if k == 0 else dt * max(hold, 1)
            wanted = min(max(controls[k, 0], p.min_v), p.max_v)
            v = toward(v, wanted, p.acc_v * reach)
            wanted = min(max(controls[k, 1], -p.max_turn), p.max_turn)
            omega = toward(omega, wanted, p.acc_turn * reach)
        controls[k, 0] = v
        controls[k, 1] = omega


@jit
def smooth(controls, past):
    """Returns controls smoothed by a quadratic fit to nine at a time.

    `past` (4, 2) are the previous controls. The last of `controls` is repeated
    at the end.
    """
    n = len(controls)
    before = len(past)
    result = np.zeros_like(controls)
    for k in range(n):
        for j in range(9):
            i = min(k + j - 4, n - 1)
            for c in range(2):
                value = past[before + i, c] if i < 0 else controls[i, c]
                result[k, c] += SMOOTHING[j] * value
    return result


@jit
def held(controls, hold):
    """Returns controls averaged over the steps for which a command holds."""
    if hold <= 1:
        return controls
    result = np.empty_like(controls)
    for first in range(1 - hold, len(controls), hold):
        begin = max(first, 0)
        end = min(first + hold, len(controls))
        for c in range(2):
            total = 0.0
            for k in range(begin, end):
                total += controls[k, c]
            for k in range(begin, end):
                result[k, c] = total / (end - begin)
    return result
