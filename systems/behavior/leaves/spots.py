"""Finds room to let a robot pass: functions on numbers and walls.

Walls are `Obstacles.table`, or None if there are none. A robot is given by its
`Drive`. All numbers are in W, in meters and m/s.
"""

import math
from typing import NamedTuple

from hunav_drake.systems.behavior.leaves.robot_conditions import course
from hunav_drake.systems.behavior.nodes.tick_context import Row
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
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


def drive_of(robot: Row, state: Row) -> Drive:
    """Returns the drive of a robot relative to a person; rows of states."""
    hx, hy = course(robot)
    rx, ry = state[X] - robot[X], state[Y] - robot[Y]
    return Drive(
        hx,
        hy,
        rx * hx + ry * hy,
        hx * ry - hy * rx,
        robot[RADIUS] + state[RADIUS],
        math.hypot(robot[VX], robot[VY]),
    )


class Spot(NamedTuple):
    """A point to go back to, the spot aside from there, and its gap."""

    back_x: float
    back_y: float
    x: float
    y: float
    gap: float


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


def find_spot(
    state: Row,
    body: float,
    drive: Drive,
    wanted: Wanted,
    others: list[tuple[float, float]],
    walls: Array | None,
) -> Spot | None:
    """Returns the spot beside a robot's way to let it pass; None if nowhere.

    It is abreast of the person, or farther back along the way if that leaves
    more room: 0.1 m more of a gap is worth a meter. It is on the person's
    side, or on the other if that has more room and time is left to cross; if
    in doubt, on the robot's left, the right of a person who faces it. It is
    not taken by others who stand. `body` is the radius of the body itself.
    """
    x, y, radius = state[X], state[Y], state[RADIUS]
    gap, least, pace, away = wanted
    hx, hy = drive.hx, drive.hy
    near = -1.0 if drive.beside < -_BESIDE else 1.0
    least = min(least, gap) - _SLIGHT
    best, spot = -math.inf, None
    back = 0.0
    while back <= _BACK:
        if back and free_way(walls, x, y, hx, hy, back, body, 0.0) < back:
            break
        px, py = x + back * hx, y + back * hy
        for side in (near, -near):
            way = max(drive.both + gap - side * drive.beside, 0.0)
            if side != near and not _can_cross(drive, back, way, pace):
                continue
            nx, ny = -side * hy, side * hx
            free = free_way(walls, px, py, nx, ny, way, body, radius)
            room = side * drive.beside + free - drive.both
            sx, sy = px + free * nx, py + free * ny
            if (
                room < least
                or math.hypot(sx - x, sy - y) < away
                or _is_taken(sx, sy, body, others)
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


def _can_cross(drive: Drive, back: float, way: float, pace: float) -> bool:
    """Returns whether a person can cross before a robot comes."""
    if drive.speed == 0:
        return True
    driven = drive.speed * (back + way) / max(pace, 1e-3)
    return drive.along + back - driven > drive.both + _CROSSING


def _is_taken(
    x: float, y: float, body: float, others: list[tuple[float, float]]
) -> bool:
    """Returns whether somebody stands where a body is to stand."""
    apart = 2 * body + _APART
    return any(math.hypot(x - ox, y - oy) < apart for ox, oy in others)


def free_way(
    walls: Array | None,
    x: float,
    y: float,
    dx: float,
    dy: float,
    way: float,
    body: float,
    beside: float,
) -> float:
    """Returns the length of a straight way that is free for a body, in meters.

    It leads from (x, y) in the direction (dx, dy), a unit vector, over the
    length `way`. `body` is the radius of the body, and `beside` must be free on
    either side of its middle.
    """
    if walls is None or way <= 0:
        return max(way, 0.0)
    off = body + WALL_GAP
    reach = way + off
    free = way
    for shift in (0.0, beside, -beside) if beside else (0.0,):
        sx, sy = x - shift * dy, y + shift * dx
        part = ray_cast(sx, sy, sx + reach * dx, sy + reach * dy, walls)
        free = min(free, reach * part - off)
    return max(free, 0.0)


def way_off(
    state: Row, body: float, drive: Drive, walls: Array | None
) -> tuple[float, float, float]:
    """Returns a way off from a robot: a direction, and its free length.

    It is straight on along the robot's way; if that is blocked, to the side by
    the least angle; and if all are blocked, straight on as far as possible.
    """
    first = 1.0 if drive.beside >= 0 else -1.0
    ways = []
    for k in range(7):
        # 0, and 30, 60 and 90 degrees to either side.
        turn = first * ((k + 1) // 2) * _TURN * (1.0 if k % 2 else -1.0)
        c, s = math.cos(turn), math.sin(turn)
        dx, dy = c * drive.hx - s * drive.hy, s * drive.hx + c * drive.hy
        free = free_way(walls, state[X], state[Y], dx, dy, _SIGHT, body, body)
        if free >= _FREE:
            return dx, dy, free
        ways.append((dx, dy, free))
    return ways[0]


def way_past(
    state: Row, body: float, drive: Drive, walls: Array | None
) -> Spot | None:
    """Returns the way past a robot that stands; None if bodies do not fit.

    It leads to the wall, on the side with more room, and along it to behind
    the robot. The arguments are those of `find_spot`.
    """
    hx, hy = drive.hx, drive.hy
    behind = drive.along + drive.both + _BEHIND
    radius = drive.both - state[RADIUS]
    best, spot = SQUEEZE, None
    near = -1.0 if drive.beside < -_BESIDE else 1.0
    for side in (near, -near):
        way = max(drive.both + _LEAST_PAST - side * drive.beside, 0.0)
        nx, ny = -side * hy, side * hx
        x, y = state[X], state[Y]
        free = free_way(walls, x, y, nx, ny, way, body, 0.0)
        room = side * drive.beside + free - radius - body
        x, y = x + free * nx, y + free * ny
        far = free_way(walls, x, y, -hx, -hy, behind, body, 0.0)
        if room > best and far >= behind:
            best = room + _SLIGHT
            spot = Spot(x, y, x - behind * hx, y - behind * hy, room)
    return spot
