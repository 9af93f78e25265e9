"""The gait of people and the turning of wheels.

Views and lidars at the height of legs depend on it; the motion of people does
not. Compiled, because it runs once per step also when nobody looks.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import STATE_SIZE, VX, VY, YAW, X, Y
from hunav_drake.systems.people.figure_config import TALL, WHEELED

# The figure that walks, in meters: from hip to knee, from knee to sole, and
# from below the ankle back to the heel and forward to the ball of the foot.
THIGH = 0.42
SHIN = 0.46
HEEL = 0.06
TOE = 0.15

# Walking strides, two steps, grow with the square root of the speed (Grieve,
# "Gait patterns and the speed of walking", Biomed. Eng. 3, 1968): 1.4 m at
# 1.2 m/s. In m / sqrt(m/s).
STRIDE = 1.27

# Hip and knee of a person who sits, in radians, and the height of its hips
# above the floor; in a wheelchair all is higher, in meters.
SEATED = 1.38
SEAT = THIGH * math.cos(SEATED) + SHIN
FOOTREST = 0.08

# The time constant with which a person starts and stops stepping, in seconds.
# A person that stops at once still puts the feet together.
SETTLING_TIME = 0.2

# The columns of a person in the state: the phase of the stride in [0, 2 pi);
# the pace, which is the speed smoothed over SETTLING_TIME, negative backwards,
# in m/s; and the last position, x and y, in meters.
GAIT_SIZE = 4
PHASE, PACE, LAST_X, LAST_Y = range(GAIT_SIZE)

# The positions of a person's figure.
(
    BASE_X,
    BASE_Y,
    BASE_YAW,
    HIP_HEIGHT,
    LEFT_HIP,
    LEFT_KNEE,
    RIGHT_HIP,
    RIGHT_KNEE,
    LEFT_SHOULDER,
    RIGHT_SHOULDER,
) = range(10)
FIGURE_SIZE = 10

# The x and y of the figure of an absent person (with a row of NaN), in meters:
# out of every picture.
ABSENT = 1e4


def initial_gait(ids: ArrayLike) -> Array:
    """Returns the gait of n people who stand, shape (4n,).

    The phases are spread by the golden angle, so that people who set off
    together do not march in step. The last positions are `ABSENT`.

    Args:
        ids: The numbers of the people, shape (n,), from 1.
    """
    numbers = np.asarray(ids, dtype=float) - 1
    gait = np.zeros((len(numbers), GAIT_SIZE))
    gait[:, LAST_X:] = ABSENT
    gait[:, PHASE] = numbers * (math.pi * (3 - math.sqrt(5))) % (2 * math.pi)
    return gait.ravel()


@jit
def advance_gait(gait: Array, human_states: Array, time_step: float) -> Array:
    """Returns the gait (4n,) of people one step later.

    Their pace follows their velocity, but is no faster than they have moved:
    in the profile of HuNavSim, some people who stand keep their velocity.
    """
    result = gait.copy()
    blend = 1.0 - math.exp(-time_step / SETTLING_TIME)
    for i in range(gait.size // GAIT_SIZE):
        row = i * STATE_SIZE
        own = i * GAIT_SIZE
        x, y = human_states[row + X], human_states[row + Y]
        vx, vy = human_states[row + VX], human_states[row + VY]
        yaw = human_states[row + YAW]
        if math.isnan(x):
            result[own + PACE] = 0.0
            continue
        walked = math.hypot(x - gait[own + LAST_X], y - gait[own + LAST_Y])
        speed = min(math.hypot(vx, vy), walked / time_step)
        if vx * math.cos(yaw) + vy * math.sin(yaw) < 0.0:
            speed = -speed
        pace = gait[own + PACE]
        pace += blend * (speed - pace)
        # A stride of STRIDE sqrt(|pace|) at |pace| takes sqrt(|pace|) / STRIDE
        # strides per second.
        rate = math.copysign(math.sqrt(abs(pace)) / STRIDE, pace)
        phase = gait[own + PHASE] + 2.0 * math.pi * rate * time_step
        result[own + PHASE] = phase % (2.0 * math.pi)
        result[own + PACE] = pace
        result[own + LAST_X] = x
        result[own + LAST_Y] = y
    return result


@jit
def pose_figures(gait: Array, human_states: Array, bodies: Array) -> Array:
    """Returns the positions (n, 10) of the figures of all people.

    See the constants above; `bodies` are their `figure_rows`. Angles are
    positive forwards, those of knees when bent. People with rows of NaN stand
    at `ABSENT`.
    """
    n = gait.size // GAIT_SIZE
    result = np.empty((n, FIGURE_SIZE))
    for i in range(n):
        row = i * STATE_SIZE
        phase = gait[GAIT_SIZE * i + PHASE]
        pace = gait[GAIT_SIZE * i + PACE]
        # The foot on the floor stays where it is if the leg sweeps half a
        # stride while the body moves as far.
        stride = STRIDE * math.sqrt(abs(pace))
        tall = bodies[i, TALL]
        leg = tall * (THIGH + SHIN)
        swing = math.asin(min(stride / (4.0 * leg), 0.6))
        # The leg that swings forward bends, at the knee and a little at the
        # hip, so that its foot clears the floor.
        bend = 2.2 * swing * math.cos(phase)
        left_knee, right_knee = max(bend, 0.0), max(-bend, 0.0)
        sweep = swing * math.sin(phase)
        left_hip = sweep + 0.3 * left_knee
        right_hip = -sweep + 0.3 * right_knee
        q = result[i]
        q[BASE_X] = human_states[row + X]
        q[BASE_Y] = human_states[row + Y]
        q[BASE_YAW] = human_states[row + YAW]
        if math.isnan(q[BASE_X]):
            q[BASE_X], q[BASE_Y], q[BASE_YAW] = ABSENT, ABSENT, 0.0
        q[HIP_HEIGHT] = tall * max(
            reach(left_hip, left_knee), reach(right_hip, right_knee)
        )
        q[LEFT_SHOULDER], q[RIGHT_SHOULDER] = -0.8 * sweep, 0.8 * sweep
        if bodies[i, WHEELED] > 0.0:
            # Both hands push the wheels.
            left_hip = right_hip = SEATED
            left_knee = right_knee = seated_knee(tall)
            q[HIP_HEIGHT] = SEAT + FOOTREST
            q[LEFT_SHOULDER] = q[RIGHT_SHOULDER] = 0.7 * sweep - 0.15
        q[LEFT_HIP], q[LEFT_KNEE] = left_hip, left_knee
        q[RIGHT_HIP], q[RIGHT_KNEE] = right_hip, right_knee
    return result


@jit
def reach(hip: float, knee: float) -> float:
    """Returns the depth of the lower of heel and toe below the hip, in m."""
    shin = hip - knee
    foot = max(HEEL * math.sin(shin), -TOE * math.sin(shin))
    return THIGH * math.cos(hip) + SHIN * math.cos(shin) + foot


@jit
def seated_knee(tall: float) -> float:
    """Returns the angle of the knees of a person on a seat, in radians.

    Long shins are put forward, with the heels on the floor; short ones do not
    reach it.
    """
    if tall <= 1.0:
        return SEATED
    below = SEAT / tall - THIGH * math.cos(SEATED)
    ahead = math.atan2(HEEL, SHIN) + math.acos(below / math.hypot(HEEL, SHIN))
    return SEATED - ahead
