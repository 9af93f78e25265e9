"""How figures of people sit, look aside and gesture, by what they show.

Only what is drawn depends on it; bodies stay upright discs.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import (
    SIGNAL_SIZE,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    Activity,
    Gesture,
    Posture,
    Signal,
    X,
    Y,
)
from hunav_drake.systems.people.figure_config import TALL, WHEELED
from hunav_drake.systems.people.gait import (
    FIGURE_SIZE,
    HIP_HEIGHT,
    LEFT_HIP,
    LEFT_KNEE,
    LEFT_SHOULDER,
    RIGHT_HIP,
    RIGHT_KNEE,
    RIGHT_SHOULDER,
    SEAT,
    SEATED,
    reach,
    seated_knee,
)

# The further positions of a figure that shows what people do: the pitch of the
# trunk, the yaw of the head, and the angles of the elbows.
LEAN, HEAD, LEFT_ELBOW, RIGHT_ELBOW = range(FIGURE_SIZE, FIGURE_SIZE + 4)
LIVELY_SIZE = FIGURE_SIZE + 4

# The columns of a person in the state: how far it sits and lies, each in
# [0, 1]; the yaw of the head, in radians; how far its arms do what it does
# instead of swinging; the angles of shoulders and elbows then; and the time of
# its gestures, in seconds.
SITS, LIES, LOOKS, BUSY, ARMS = 0, 1, 2, 3, 4
TIME = ARMS + 4
MANNER_SIZE = TIME + 1

# The angle of an elbow at rest, in radians.
_REST = 0.4

# The height of the hips of a person who lies, in meters.
_BED = 0.66

# Rates: of sitting down, in 1/s, of the head and of the arms, in rad/s; and how
# far the head turns, in radians.
_DOWN, _TURN, _MOVE, _ASIDE = 1.0, 4.0, 5.0, 1.2

# Whoever is slower has arrived, in m/s.
_STILL = 0.1

# How long gestures repeat, in seconds: a common multiple of their periods.
_REPEAT = 60.0

_ACTIVITY, _SAID = int(Signal.ACTIVITY), int(Signal.UTTERANCE)
_GESTURE, _POSTURE = int(Signal.GESTURE), int(Signal.POSTURE)
_GAZE, _GAZE_X = int(Signal.GAZE), int(Signal.GAZE_X)
_GAZE_Y = int(Signal.GAZE_Y)
_TALKS, _USES = float(Activity.CONVERSATION), float(Activity.USE)
_WAVE, _POINT = float(Gesture.WAVE), float(Gesture.POINT)
_BECKON, _FIRST = float(Gesture.BECKON), float(Gesture.YOU_FIRST)
_SEAT, _LYING = float(Posture.SEATED), float(Posture.LYING)


def initial_manners(ids: ArrayLike) -> Array:
    """Returns the state of n people who stand, shape (9n,).

    `ids` are the numbers of the people, shape (n,), from 1.
    """
    numbers = np.asarray(ids, dtype=float) - 1
    manners = np.zeros((len(numbers), MANNER_SIZE))
    manners[:, ARMS + 2 : TIME] = _REST
    # (Those who talk do not gesture in step.)
    manners[:, TIME] = numbers * 7.3 % _REPEAT
    return manners.ravel()


@jit
def advance_manners(
    manners: Array,
    signals: Array,
    human_states: Array,
    robot_states: Array,
    time_step: float,
) -> Array:
    """Returns the state (9n,) of people one step later.

    `signals` are n rows of `layout.Signal`; states are rows (x, y, yaw, ...).
    """
    result = manners.copy()
    n = manners.size // MANNER_SIZE
    for i in range(n):
        own = result[i * MANNER_SIZE : (i + 1) * MANNER_SIZE]
        signal = signals[i * SIGNAL_SIZE : (i + 1) * SIGNAL_SIZE]
        state = human_states[i * STATE_SIZE : (i + 1) * STATE_SIZE]
        own[TIME] = (own[TIME] + time_step) % _REPEAT
        sits = 1.0 if signal[_POSTURE] == _SEAT else 0.0
        lies = 1.0 if signal[_POSTURE] == _LYING else 0.0
        down = _DOWN * time_step
        own[SITS] = _nearer(own[SITS], sits, down)
        own[LIES] = _nearer(own[LIES], lies, down)
        look = _look(signal, state, human_states, robot_states)
        own[LOOKS] = _nearer(own[LOOKS], look, _TURN * time_step)
        is_still = math.hypot(state[VX], state[VY]) < _STILL
        is_busy, left, right, left_elbow, right_elbow = _arms(
            signal, own[TIME], is_still
        )
        move = _MOVE * time_step
        own[BUSY] = _nearer(own[BUSY], 1.0 if is_busy else 0.0, move)
        own[ARMS] = _nearer(own[ARMS], left, move)
        own[ARMS + 1] = _nearer(own[ARMS + 1], right, move)
        own[ARMS + 2] = _nearer(own[ARMS + 2], left_elbow, move)
        own[ARMS + 3] = _nearer(own[ARMS + 3], right_elbow, move)
    return result


@jit
def hold_figures(figures: Array, manners: Array, bodies: Array) -> Array:
    """Returns the positions (n, 14) of lively figures, given walking ones.

    `bodies` are their `figure_rows`.
    """
    n = len(figures)
    result = np.zeros((n, LIVELY_SIZE))
    for i in range(n):
        own = manners[i * MANNER_SIZE : (i + 1) * MANNER_SIZE]
        q = result[i]
        q[:FIGURE_SIZE] = figures[i]
        # (Slowly at first and at last.)
        sits = own[SITS] ** 2 * (3.0 - 2.0 * own[SITS])
        lies = own[LIES] ** 2 * (3.0 - 2.0 * own[LIES])
        if bodies[i, WHEELED] > 0.0:
            sits = lies = 0.0
        walks = 1.0 - max(sits, lies)
        tall = bodies[i, TALL]
        bent = seated_knee(tall)
        for hip, knee in ((LEFT_HIP, LEFT_KNEE), (RIGHT_HIP, RIGHT_KNEE)):
            q[hip] = walks * q[hip] + sits * SEATED
            q[knee] = walks * q[knee] + sits * bent
        height = q[HIP_HEIGHT]
        if bodies[i, WHEELED] == 0.0:
            height = tall * max(
                reach(q[LEFT_HIP], q[LEFT_KNEE]),
                reach(q[RIGHT_HIP], q[RIGHT_KNEE]),
            )
            # (On a seat, however long the legs are.)
            height += sits * (SEAT - tall * reach(SEATED, bent))
        q[HIP_HEIGHT] = (1.0 - lies) * height + lies * _BED
        # Who sits down bows, above the hips; who lies is on the back.
        bow = 0.5 * math.sin(math.pi * sits)
        q[LEAN] = bow - lies * math.pi / 2
        q[LEFT_HIP] += bow
        q[RIGHT_HIP] += bow
        q[HEAD] = own[LOOKS]
        busy = own[BUSY] * (1.0 - lies)
        swing = (1.0 - busy) * walks
        q[LEFT_SHOULDER] = swing * q[LEFT_SHOULDER] + busy * own[ARMS]
        q[RIGHT_SHOULDER] = swing * q[RIGHT_SHOULDER] + busy * own[ARMS + 1]
        # (The arms of who lies rest on the bed.)
        rest = (1.0 - busy) * (1.0 - lies) * _REST
        q[LEFT_ELBOW] = rest + busy * own[ARMS + 2]
        q[RIGHT_ELBOW] = rest + busy * own[ARMS + 3]
    return result


@jit
def _nearer(value: float, target: float, step: float) -> float:
    """Returns a value moved to a target, by a step at most."""
    return value + min(max(target - value, -step), step)


@jit
def _look(
    signal: Array, state: Array, human_states: Array, robot_states: Array
) -> float:
    """Returns the yaw of the head relative to the body, in radians."""
    gaze = int(signal[_GAZE])
    if gaze == -1:
        return 0.0
    x, y = signal[_GAZE_X], signal[_GAZE_Y]
    n = human_states.size // STATE_SIZE
    if 0 <= gaze < n:
        x = human_states[gaze * STATE_SIZE + X]
        y = human_states[gaze * STATE_SIZE + Y]
    elif gaze >= n and (gaze - n) < robot_states.size // STATE_SIZE:
        x = robot_states[(gaze - n) * STATE_SIZE + X]
        y = robot_states[(gaze - n) * STATE_SIZE + Y]
    dx, dy = x - state[X], y - state[Y]
    if math.isnan(dx) or dx * dx + dy * dy < 1e-6:
        return 0.0
    turn = math.atan2(dy, dx) - state[YAW]
    turn = math.atan2(math.sin(turn), math.cos(turn))
    return min(max(turn, -_ASIDE), _ASIDE)


@jit
def _arms(
    signal: Array, time: float, is_still: bool
) -> tuple[bool, float, float, float, float]:
    """Returns whether the arms do something, and the angles that they have.

    These are those of the left and the right shoulder and elbow, in radians.
    """
    sits = signal[_POSTURE] == _SEAT
    # Hands on the thighs, or hanging.
    left, right, left_elbow, right_elbow = 0.0, 0.0, _REST, _REST
    if sits:
        left, right, left_elbow, right_elbow = 0.3, 0.3, 0.7, 0.7
    is_busy = sits
    gesture = signal[_GESTURE]
    beat = math.sin(2.0 * math.pi * 1.5 * time)
    slow = math.sin(2.0 * math.pi * 0.6 * time)
    if gesture == _WAVE:
        return True, left, 2.4 + 0.15 * beat, left_elbow, 0.7 + 0.5 * beat
    if gesture == _POINT:
        return True, left, 1.45, left_elbow, 0.1
    if gesture == _BECKON:
        return True, left, 0.7, left_elbow, 1.4 + 0.5 * beat
    if gesture == _FIRST:
        return True, left, 0.9, left_elbow, 0.5 + 0.2 * slow
    talks = signal[_ACTIVITY] == _TALKS and (
        math.sin(2.0 * math.pi * time / 7.5) > 0.0
    )
    if talks or signal[_SAID] != 0.0:
        low = 0.35 + 0.15 * slow
        return True, low, 0.5 + 0.2 * slow, 1.1 - 0.3 * slow, 1.3 + 0.3 * beat
    if signal[_ACTIVITY] == _USES and is_still:
        if sits:
            # Hands on a desk.
            typing = 0.05 * beat
            return True, 0.55, 0.55, 1.05 + typing, 1.05 - typing
        # Something in the hand, looked at.
        return True, left, 0.35, left_elbow, 1.5 + 0.1 * slow
    return is_busy, left, right, left_elbow, right_elbow
