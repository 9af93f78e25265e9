"""Leads people past robots, compiled by numba.

The forces of one more pedestrian let people graze a robot, which does not step
aside like a person. Therefore people whose way leads too close to a robot take
a lane past it, from a few meters on.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, WALLS, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import (
    RADIUS,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd.bodies.time_gap import DOUBT, SLIM, SOFT
from hunav_drake.systems.people.parameters import EPSILON
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.walls import opened, runs_in

# The largest distance of a robot for which people walk aside, from center to
# center, in meters.
_NOTICED = 3.0

# The time horizon for which people predict the motion of a robot, in seconds.
_HORIZON = 3.0

# Robots this fast across the way, in m/s, are preferably passed behind; the
# slower a robot is, the more on the right.
_CROSSING = 0.3

# The least gain of room to change sides, as a fraction of the desired room.
_WORTH = 0.1

# The gap between the body and a wall, in meters.
_WALL_GAP = 0.1

# People reach the lane after this part of the way to the robot, which counts as
# at least so long, in meters; and the sine of the steepest turn to it.
_PART, _LEAST = 0.5, 0.5
_STEEPEST = 0.9

# The columns of a robot: the time until a person is abreast of it, its distance
# to the left of the person's way then, the desired clearance, its speed to the
# left, and the distance that the person walks on until it is behind.
_TIME, _BESIDE, _CLEAR, _ACROSS, _PAST = range(5)


@jit
def _find(i, states, way, body, goal, robots, walls, gap, behind, rows):
    """Writes the robots on a person's way to `rows`; returns their number.

    The arguments are those of `pass_robots`, with the way (ex, ey, length,
    speed) to the next waypoint.
    """
    ex, ey, length, speed = way
    x = states[i, X]
    y = states[i, Y]
    count = 0
    for j in range(len(robots)):
        dx = robots[j, X] - x
        dy = robots[j, Y] - y
        if dx * dx + dy * dy > _NOTICED * _NOTICED:
            continue
        vx = robots[j, VX]
        vy = robots[j, VY]
        ahead = dx * ex + dy * ey
        closing = speed - (vx * ex + vy * ey)
        least = body + robots[j, RADIUS]
        overtakes = behind != 0 and closing < 0 and ahead < least
        if overtakes:
            # Soon beside each other; while they are, the time is now.
            if ahead + least < closing * _HORIZON:
                continue
            time = max(ahead / closing, 0.0)
        # Abreast before the waypoint, and ever.
        elif ahead <= 0 or ahead * speed >= closing * length:
            continue
        else:
            time = ahead / closing
        across = ex * vy - ey * vx
        expected = min(time, _HORIZON)
        clear = least + gap
        # The clearance is at most that at the goal, which could not be reached
        # otherwise; and nobody passes a robot that is on the goal.
        at_goal = math.hypot(
            robots[j, X] + expected * vx - goal[Command.GOAL_X],
            robots[j, Y] + expected * vy - goal[Command.GOAL_Y],
        )
        if at_goal < least:
            continue
        clear = min(clear, at_goal)
        if len(walls.solid) > 0:
            hidden = first_hit(x, y, robots[j, X], robots[j, Y], walls)
            if hidden <= 1:
                continue
        rows[count, _TIME] = time
        rows[count, _BESIDE] = ex * dy - ey * dx + expected * across
        # A crossing robot is nearest before or after it is abreast.
        rows[count, _CLEAR] = clear * min(math.hypot(1.0, across / closing), 2)
        rows[count, _ACROSS] = across
        rows[count, _PAST] = min(least * speed / abs(closing), _NOTICED)
        count += 1
    return count


@jit
def _room(x, y, ex, ey, begin, end, reach, walls):
    """Returns the distances of walls on the left and the right of a way.

    It leads from (x, y) in the direction (ex, ey). Only walls beside it between
    `begin` and `end`, on one side of it, and nearer than `reach` count.
    """
    left = reach
    right = reach
    px = x + begin * ex
    py = y + begin * ey
    qx = x + end * ex
    qy = y + end * ey
    for run in runs_in(
        *(min(px, qx) - reach, min(py, qy) - reach),
        *(max(px, qx) + reach, max(py, qy) + reach),
        walls,
    ):
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            ax = walls.segments[s, 0] - px
            ay = walls.segments[s, 1] - py
            bx = walls.segments[s, 2] - walls.segments[s, 0]
            by = walls.segments[s, 3] - walls.segments[s, 1]
            along = ax * ex + ay * ey
            beside = ex * ay - ey * ax
            on = bx * ex + by * ey
            off = ex * by - ey * bx
            first, last = 0.0, 1.0
            if on != 0:
                one = -along / on
                other = (end - begin - along) / on
                first = max(min(one, other), 0.0)
                last = min(max(one, other), 1.0)
            if first > last or (on == 0 and not 0 <= along <= end - begin):
                continue
            near = beside + first * off
            far = beside + last * off
            if min(near, far) >= 0:
                left = min(left, near, far)
            elif max(near, far) <= 0:
                right = min(right, -near, -far)
    return left, right


@jit
def _lane(rows, count, usual, left, right):
    """Returns the lane past robots: meters to the left of the way.

    It is the one nearest to the usual one among those with the most room.
    """
    lane = 0.0
    best = math.inf
    most = 0.0
    for pick in range(2):
        for k in range(2 * count):
            side = 1.0 - 2.0 * (k % 2)
            own = rows[k // 2, _BESIDE] + side * rows[k // 2, _CLEAR]
            own = min(max(own, -right), left)
            free = 1.0
            for j in range(count):
                off = abs(own - rows[j, _BESIDE])
                free = min(free, off / rows[j, _CLEAR])
            if pick == 0:
                most = max(most, free)
            elif free >= most - _WORTH and abs(own - usual) < best:
                best = abs(own - usual)
                lane = own
    return lane


@late_as(
    numba.types.UniTuple(float64[:, ::1], 2),
    *(
        MATRIX,
        VECTOR,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        WALLS,
        REAL,
        REAL,
    ),
)
def pass_robots(
    states,
    bodies,
    command,
    goals,
    parameters,
    robots,
    at_walls,
    table,
    gap,
    behind,
):
    """Returns commands and `at_walls` of people in view of robots.

    Only robots count that are 3 m away at most, ahead (or about to overtake, if
    `behind` is not 0), not behind a wall, and pedestrians to the person. If one
    that keeps its velocity would come nearer than `gap` (in meters) to the body
    of a person who walks straight on, the person's goal is turned aside, so
    that the gap is left: to the nearer side, to the right if in doubt, behind
    rather than ahead of a crossing robot, and where there is room. Meanwhile,
    no group pulls. `command` has waypoints for goals, `goals` the goals
    themselves.
    """
    wanted = command.copy()
    felt = at_walls.copy()
    walls = opened(table)
    rows = np.empty((len(robots), 5))
    for i in range(len(states)):
        if (
            int(command[i, Command.ROBOT_ROLE]) != RobotRole.PEDESTRIAN
            or command[i, Command.HAS_GOAL] == 0
            or command[i, Command.HOLD] != 0
        ):
            continue
        gx = command[i, Command.GOAL_X] - states[i, X]
        gy = command[i, Command.GOAL_Y] - states[i, Y]
        length = math.hypot(gx, gy)
        speed = min(
            command[i, Command.DESIRED_SPEED], command[i, Command.MAX_SPEED]
        )
        if length <= command[i, Command.GOAL_RADIUS] or speed <= 0:
            continue
        ex = gx / length
        ey = gy / length
        body = bodies[i]
        count = _find(
            *(i, states, (ex, ey, length, speed), body, goals[i]),
            *(robots, walls, gap, behind, rows),
        )
        # Of those in the way, the first one that the person meets.
        first = -1
        for j in range(count):
            if abs(rows[j, _BESIDE]) < rows[j, _CLEAR] and (
                first < 0 or rows[j, _TIME] < rows[first, _TIME]
            ):
                first = j
        if first < 0:
            continue
        way = speed * rows[first, _TIME]
        # While the two are beside each other. (Rows change below.)
        past = min(way + rows[first, _PAST] + body, length)
        turn = rows[first, _ACROSS] / _CROSSING
        turn = min(max(turn, -1.0), 1.0)
        turn += (1 - abs(turn)) * np.sign(parameters[i, EPSILON])
        usual = -DOUBT * turn
        # And those that are beside the first one then.
        clear = rows[first, _CLEAR]
        abreast = 0
        for j in range(count):
            if abs(speed * rows[j, _TIME] - way) < clear:
                rows[abreast] = rows[j]
                abreast += 1
        widest = 0.0
        for j in range(abreast):
            widest = max(widest, abs(rows[j, _BESIDE]) + rows[j, _CLEAR])
        off = body + _WALL_GAP
        left, right = _room(
            *(states[i, X], states[i, Y], ex, ey, way - body, past),
            *(widest + off, walls),
        )
        left -= off
        right -= off
        lane = _lane(rows, abreast, usual, max(left, 0.0), max(right, 0.0))
        s = lane / max(_PART * way, _LEAST)
        s = min(max(s, -_STEEPEST), _STEEPEST)
        c = math.sqrt(1 - s * s)
        wanted[i, Command.GOAL_X] = states[i, X] + c * gx - s * gy
        wanted[i, Command.GOAL_Y] = states[i, Y] + c * gy + s * gx
        wanted[i, Command.GROUP_ID] = -1.0
        if len(felt) > 0:
            felt[i, 0] = min(felt[i, 0], SLIM)
            felt[i, 1] *= SOFT
    return wanted, felt
