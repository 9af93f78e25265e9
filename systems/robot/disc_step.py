"""A step of a kinematic robot, compiled by numba."""

import math

from numba import boolean, float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
    reads,
    rows_of,
)
from hunav_drake.systems.common.layout import (
    MOTION_SIZE,
    RADIUS,
    STATE_SIZE,
    Contact,
    X,
    Y,
)
from hunav_drake.systems.crowd.walls.keep_out import keep_out_of_walls
from hunav_drake.systems.robot.contact_rows import count_contacts
from hunav_drake.systems.robot.robot_config import RobotLimits
from hunav_drake.systems.world.nearest import nearest_on_walls

# Lengths up to this are by rounding, in meters.
_SAME = 1e-12

# The numbers of a state (x, y, yaw, v, omega), and of the state after a step
# with the velocity (vx, vy) that walls took away.
STATE, STATE_AND_LOST = 5, 7

_limits_in = reads(RobotLimits)


@jit
def _approach(value, wanted, low, high, most):
    """Returns a value moved towards a clipped target by at most `most`."""
    change = min(max(wanted, low), high) - value
    return value + min(max(change, -most), most)


@jit_as(float64[::1], VECTOR, VECTOR, VECTOR, REAL)
def next_velocity(velocity, wanted, limits, dt):
    """Returns (v, omega) after a step towards a command, within limits.

    The limits are the numbers of a `RobotLimits`; all in SI units and radians.
    """
    most = _limits_in(limits)
    result = np.empty(2)
    result[0] = _approach(
        *(velocity[0], wanted[0], -most.max_reverse_speed, most.max_speed),
        most.max_acceleration * dt,
    )
    result[1] = _approach(
        *(velocity[1], wanted[1], -most.max_turn_rate, most.max_turn_rate),
        most.max_turn_acceleration * dt,
    )
    return result


@jit
def _wrap_angle(angle):
    """Returns the same direction in (-pi, pi], in radians."""
    rest = np.fmod(angle, 2 * math.pi)
    if rest > math.pi:
        return rest - 2 * math.pi
    return rest + 2 * math.pi if rest <= -math.pi else rest


@jit
def _beyond(x, y, to_x, to_y, radius, others, k):
    """Returns by how much a step takes more than half of the gap to a robot.

    This is in meters, at most 0 for a step that does not; then follows the
    direction to the robot, a unit vector. Its row is at `k`. As all robots
    take half at most, their discs never overlap.
    """
    dx, dy = others[k + X] - x, others[k + Y] - y
    away = math.hypot(dx, dy)
    if away == 0:
        return 0.0, 0.0, 0.0
    ux, uy = dx / away, dy / away
    free = max(away - radius - others[k + RADIUS], 0.0) / 2
    return (to_x - x) * ux + (to_y - y) * uy - free, ux, uy


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, REAL, REAL, REAL, boolean, VECTOR, WALLS),
    VECTOR,
)
def drive_disc(
    state, wanted, limits, dt, margin, radius, walls_stop, memory, table, others
):
    """Drives an exact arc, as far as walls and other robots allow.

    Args:
        state: (x, y, yaw, v, omega), with the speed v of the wheels.
        wanted: The command (v, omega).
        limits: those of a `RobotLimits`.
        dt: The duration of the step, in seconds.
        margin: The distance that the center keeps from walls, in meters.
        radius: That of the disc, in meters.
        walls_stop: Whether walls stop it.
        memory: A row of `contact_rows`, for all walls together.
        table: The walls.
        others: The states of other robots, rows of a state, one after the
            other.

    Returns:
        The state after the step; the velocity (vx, vy) in W that walls and
        other robots took away; and the row after the step.
    """
    result = np.empty(STATE_AND_LOST + len(memory))
    x, y, yaw = state[0], state[1], state[2]
    v, omega = next_velocity(state[3:], wanted, limits, dt)
    turn = omega * dt
    # The chord of the arc: its length is that of the arc times sin(turn/2) /
    # (turn/2), and it points along the heading at half the turn.
    half = turn / 2
    chord = v * dt * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    before = np.zeros((1, MOTION_SIZE))
    after = np.zeros((1, MOTION_SIZE))
    before[0, X], before[0, Y] = x, y
    after[0, X] = x + chord * math.cos(yaw + half)
    after[0, Y] = y + chord * math.sin(yaw + half)
    yaw = _wrap_angle(yaw + turn)
    held = False
    for k in range(0, 2 * len(others), STATE_SIZE):
        # (Twice, as one robot may move it towards another.)
        past, ux, uy = _beyond(
            x, y, after[0, X], after[0, Y], radius, others, k % len(others)
        )
        if past > 0:
            held = True
            after[0, X] -= past * ux
            after[0, Y] -= past * uy
    place = keep_out_of_walls(before, after, np.array([margin]), table)
    lost_x, lost_y = after[0, X] - place[0, X], after[0, Y] - place[0, Y]
    stopped = lost_x != 0 or lost_y != 0
    contact = rows_of(memory, len(memory))
    if stopped or memory[Contact.LASTS]:
        wall = nearest_on_walls(np.array([[x, y]]), table)
        gap = math.hypot(x - wall[0, X], y - wall[0, Y]) - radius
        # The speed into the wall, at any distance from it.
        speed = lost_x * (after[0, X] - x) + lost_y * (after[0, Y] - y)
        speed /= max(math.hypot(lost_x, lost_y), 1e-12) * dt
        contact = count_contacts(
            contact,
            np.array([stopped]),
            np.empty((0, 2)),
            np.array([gap]),
            np.array([[max(speed, 0.0)], [0.0]]),
            dt,
        )
    for k in range(len(memory)):
        result[STATE_AND_LOST + k] = contact[0, k]
    result[STATE:STATE_AND_LOST] = 0.0
    end = place[0] if walls_stop and stopped else after[0]
    for k in range(0, len(others), STATE_SIZE):
        past, _, _ = _beyond(x, y, end[X], end[Y], radius, others, k)
        if past > _SAME:
            held = True
            end = before[0]
    if held or (walls_stop and stopped):
        moved_x, moved_y = end[X] - x, end[Y] - y
        result[STATE] = v * math.cos(yaw)
        result[STATE + 1] = v * math.sin(yaw)
        # (A robot that is moved out of a wall is at rest.)
        if math.hypot(moved_x, moved_y) <= abs(chord) * (1 + 1e-9):
            result[STATE] -= moved_x / dt
            result[STATE + 1] -= moved_y / dt
    result[0], result[1], result[2] = end[X], end[Y], yaw
    result[3], result[4] = v, omega
    return result
