"""Finds room to let a robot pass: functions on numbers and walls; compiled.

A robot is given by its `Drive`. All numbers are in W, in meters and m/s.
"""

import math
from typing import NamedTuple

from hunav_drake.systems.behavior.leaves.pacing import STANDING, speed_of
from hunav_drake.systems.behavior.leaves.robot_conditions import course
from hunav_drake.systems.behavior.nodes.tick import human_at, walls_of
from hunav_drake.systems.common.kernels import jit_part
from hunav_drake.systems.world.ray_cast import ray_cast

# The distance along the robot's way in which people look for room; its steps.
_BACK = 6.0
_STEP = 0.25

# The gap between the body and a wall: small, as people lean on walls to let
# somebody pass.
WALL_GAP = 0.03

# The tolerated lack of room.
_SLIGHT = 0.02

# A person less far beside the robot's way is on it.
_BESIDE = 0.1

# The gain of room for which people go to the other side, and the gain for which
# they go a meter farther.
_OTHER_SIDE = 0.1
_PER_METER = 0.1

# The least gap to a robot after crossing ahead of it.
_CROSSING = 0.5

# A spot is taken if somebody stands nearer to its center than this and the
# body's diameter.
_APART = 0.05

# The least gap between the bodies for squeezing past a robot that stands, the
# gap between the discs that is enough for it, and the distance behind the robot
# at which it is passed.
SQUEEZE = 0.05
_LEAST_PAST = 0.1
_BEHIND = 0.3

# People who walk away from a robot look this far for a free way, and take the
# straightest one of the second length, in steps of this angle.
_SIGHT = 3.0
_FREE = 1.0
_TURN = math.pi / 6


class Drive(NamedTuple):
    """The course of a robot, and the position of a person relative to it.

    Attributes:
        hx: The x of the course, a unit vector.
        hy: Its y.
        along: The distance of the person ahead of the robot.
        beside: The distance of the person to its left.
        both: The sum of the radii of both.
        speed: The speed of the robot.
    """

    hx: float
    hy: float
    along: float
    beside: float
    both: float
    speed: float


@jit_part
def drive_of(robot, body):
    """Returns the drive of a robot relative to a person; rows of `STATE`."""
    hx, hy = course(robot)
    rx, ry = body.x - robot.x, body.y - robot.y
    return Drive(
        hx,
        hy,
        rx * hx + ry * hy,
        hx * ry - hy * rx,
        robot.radius + body.radius,
        speed_of(robot),
    )


class Spot(NamedTuple):
    """A point to go back to, the spot aside from there, and its gap.

    Without a spot, the gap is minus infinity.
    """

    back_x: float
    back_y: float
    x: float
    y: float
    gap: float


NOWHERE = Spot(0.0, 0.0, 0.0, 0.0, -math.inf)


class Wanted(NamedTuple):
    """The requirements on a spot.

    Attributes:
        gap: The desired gap between the two discs as the robot passes.
        least: The least gap, unless less is desired.
        pace: The speed of the person.
        away: Spots nearer than this to the person do not count.
    """

    gap: float
    least: float
    pace: float
    away: float


@jit_part
def find_spot(tick, drive, wanted):
    """Returns the spot beside a robot's way to let it pass, if there is one.

    It is abreast of the person, or farther back along the way if that leaves
    more room: 0.1 m more of a gap is worth a meter. It is on the person's
    side, or on the other if that has more room and time is left to cross; if
    in doubt, on the robot's left, the right of a person who faces it. It is
    not taken by others who stand.
    """
    x, y = tick.x, tick.y
    gap = wanted.gap
    hx, hy = drive.hx, drive.hy
    near = -1.0 if drive.beside < -_BESIDE else 1.0
    least = min(wanted.least, gap) - _SLIGHT
    best, spot = -math.inf, NOWHERE
    back = 0.0
    while back <= _BACK:
        if back > 0 and free_way(tick, x, y, hx, hy, back, 0.0) < back:
            break
        px, py = x + back * hx, y + back * hy
        for side in (near, -near):
            way = max(drive.both + gap - side * drive.beside, 0.0)
            if side != near and not _can_cross(drive, back, way, wanted.pace):
                continue
            nx, ny = -side * hy, side * hx
            free = free_way(tick, px, py, nx, ny, way, tick.radius)
            room = side * drive.beside + free - drive.both
            sx, sy = px + free * nx, py + free * ny
            if (
                room < least
                or math.hypot(sx - x, sy - y) < wanted.away
                or _is_taken(tick, sx, sy)
            ):
                continue
            worth = min(room, gap) - _PER_METER * back
            worth -= _OTHER_SIDE if side != near else 0.0
            if worth > best:
                best, spot = worth, Spot(px, py, sx, sy, room)
        # (Nothing farther back can be better.)
        if best >= gap - _SLIGHT - _PER_METER * (back + _STEP):
            break
        back += _STEP
    return spot


@jit_part
def _can_cross(drive, back, way, pace):
    """Returns whether a person can cross before a robot comes."""
    if drive.speed == 0:
        return True
    driven = drive.speed * (back + way) / max(pace, 1e-3)
    return drive.along + back - driven > drive.both + _CROSSING


@jit_part
def _is_taken(tick, x, y):
    """Returns whether another stands where the person is to stand."""
    apart = 2 * tick.body_radius + _APART
    for i in range(tick.num_humans):
        it = human_at(tick, i)
        stands = i != tick.index and speed_of(it) < STANDING
        if stands and math.hypot(x - it.x, y - it.y) < apart:
            return True
    return False


@jit_part
def free_way(tick, x, y, dx, dy, way, beside):
    """Returns the length of a straight way that is free for the body, in m.

    It leads from (x, y) in the direction (dx, dy), a unit vector, over the
    length `way`; `beside` must be free on either side of its middle.
    """
    if way <= 0:
        return 0.0
    off = tick.body_radius + WALL_GAP
    reach = way + off
    free = way
    for shift in (0.0, beside, -beside):
        sx, sy = x - shift * dy, y + shift * dx
        end_x, end_y = sx + reach * dx, sy + reach * dy
        part = ray_cast(sx, sy, end_x, end_y, walls_of(tick))
        free = min(free, reach * part - off)
        if beside == 0:
            break
    return max(free, 0.0)


@jit_part
def way_off(tick, drive):
    """Returns a way off from a robot: a direction, and its free length.

    It is straight on along the robot's way; if that is blocked, to the side by
    the least angle; and if all are blocked, straight on as far as possible.
    """
    first = 1.0 if drive.beside >= 0 else -1.0
    straight = 0.0
    for k in range(7):
        # 0, and 30, 60 and 90 degrees to either side.
        turn = first * ((k + 1) // 2) * _TURN * (1.0 if k % 2 else -1.0)
        c, s = math.cos(turn), math.sin(turn)
        dx, dy = c * drive.hx - s * drive.hy, s * drive.hx + c * drive.hy
        free = free_way(tick, tick.x, tick.y, dx, dy, _SIGHT, tick.body_radius)
        if free >= _FREE:
            return dx, dy, free
        if k == 0:
            straight = free
    return drive.hx, drive.hy, straight


@jit_part
def way_past(tick, drive):
    """Returns the way past a robot that stands, if bodies fit.

    It leads to the wall, on the side with more room, and along it to behind
    the robot.
    """
    hx, hy = drive.hx, drive.hy
    behind = drive.along + drive.both + _BEHIND
    radius = drive.both - tick.radius
    best, spot = SQUEEZE, NOWHERE
    near = -1.0 if drive.beside < -_BESIDE else 1.0
    for side in (near, -near):
        way = max(drive.both + _LEAST_PAST - side * drive.beside, 0.0)
        nx, ny = -side * hy, side * hx
        x, y = tick.x, tick.y
        free = free_way(tick, x, y, nx, ny, way, 0.0)
        room = side * drive.beside + free - radius - tick.body_radius
        x, y = x + free * nx, y + free * ny
        far = free_way(tick, x, y, -hx, -hy, behind, 0.0)
        if room > best and far >= behind:
            best = room + _SLIGHT
            spot = Spot(x, y, x - behind * hx, y - behind * hy, room)
    return spot
