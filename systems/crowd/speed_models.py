"""What models share in which people choose a direction, and then a speed.

The speed is what keeps people apart: nobody walks faster in the direction
chosen than the gap to the next body allows. Compiled by numba.
"""

import math
from typing import Annotated

from numba import float64
import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.common.layout import (
    COHERENCE_FORCE,
    FORCES_SIZE,
    GAZE_FORCE,
    GROUP_REPULSION_FORCE,
    OMEGA,
    RADIUS,
    ROBOT_REPULSION_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.crowd.motion_model import Array, MotionModel, Snapshot
from hunav_drake.systems.crowd.social_force import kernel
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    add_group_forces,
    add_robot_forces,
    wrap,
)
from hunav_drake.systems.people.parameters import K_GOAL, TAU
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import runs_in

# The fields of SpeedModel in order.
(
    BODY_RADIUS,
    TIME_GAP,
    REACTION_TIME,
    HESITATION,
    ACCELERATION,
    TURN_TIME,
    TURN_RATE,
) = range(7)

# What people see of one another and of robots: where it is and how it moves,
# the distance at which they touch, and how it would like to move.
AT_X, AT_Y, THEIR_VX, THEIR_VY, TOUCH, WISH_X, WISH_Y = range(7)

# Lengths that give no direction, in meters, or of directions added up.
TINY = 1e-9

# A turn that is a half one, to this, goes to the right, in radians.
_TIE = 1e-9

# Who is slower than this walks off in any direction at once, in m/s.
_WALKING = 0.1

# Who is much slower than this looks to the goal rather than ahead, in m/s.
_LOOK = 0.3

# Who walks sideways or back looks where they go, and is slower: the cosine
# from which on they are no slower.
_BACKWARD = -0.5

# The time ahead that nobody walks into a wall in, in seconds.
_WALL_TIME = 0.25

# How often the walls of a corner are looked at.
_CORNER = 3


@jit
def wishes(states, radii, command, parameters, robots, time_step):
    """Returns the velocities (n, 2) that people would like to have.

    They are those to the goals, and what the forces of the group and the
    robot's push add to them, where these and the goal's force balance.
    """
    n = len(states)
    wanted = np.zeros((n, 2))
    directions = np.zeros((n, 2))
    pulls = np.zeros((n, FORCES_SIZE))
    grouped = False
    for i in range(n):
        x = states[i, X]
        y = states[i, Y]
        gx = command[i, Command.GOAL_X] - x
        gy = command[i, Command.GOAL_Y] - y
        distance = math.hypot(gx, gy)
        if (
            command[i, Command.HAS_GOAL] != 0
            and distance > command[i, Command.GOAL_RADIUS]
        ):
            directions[i, 0] = gx / distance
            directions[i, 1] = gy / distance
            speed = min(command[i, Command.DESIRED_SPEED], distance / time_step)
            wanted[i] = speed * directions[i]
        if command[i, Command.ROBOT_REPULSION] != 0:
            add_robot_forces(
                *(x, y, states[i, VX], states[i, VY], radii[i], command[i]),
                *(parameters[i], robots, pulls[i]),
            )
        grouped = grouped or command[i, Command.GROUP_ID] >= 0
    if grouped:
        add_group_forces(directions, states, radii, command, parameters, pulls)
    for i in range(n):
        time = parameters[i, TAU] / max(parameters[i, K_GOAL], TINY)
        for c in range(2):
            wanted[i, c] += time * (
                pulls[i, GAZE_FORCE + c]
                + pulls[i, COHERENCE_FORCE + c]
                + pulls[i, GROUP_REPULSION_FORCE + c]
                + pulls[i, ROBOT_REPULSION_FORCE + c]
            )
        speed = math.hypot(wanted[i, 0], wanted[i, 1])
        if command[i, Command.HOLD] != 0:
            wanted[i] = 0.0
        elif speed > command[i, Command.MAX_SPEED]:
            wanted[i] *= command[i, Command.MAX_SPEED] / speed
    return wanted


@jit
def _column(offset, width, count):
    """Returns which of `count` cells something is in, at least the nearest."""
    return min(max(int(offset / width), 0), count - 1)


@jit
def look_around(
    i, states, radii, command, robots, wanted, cells, body, reach, rows
):
    """Finds whom a person sees: people within reach, and the robots.

    Args:
        i: The number of the person.
        states: Shape (n, 6).
        radii: Shape (n,), in meters.
        command: Shape (n, COMMAND_SIZE).
        robots: Shape (m, 7).
        wanted: Shape (n, 2), from `wishes`, in m/s.
        cells: From `make_cells`.
        body: The largest radius that people have to each other, in meters. To
            robots they have their own.
        reach: People farther than this do not count, in meters.
        rows: Receives what is seen: see AT_X and those that follow. Room for
            all people and robots.

    Returns:
        How many there are.
    """
    order, x, y, begin, left, bottom, width, columns, lines = cells
    px = states[i, X]
    py = states[i, Y]
    count = 0
    first = _column(px - reach - left, width, columns)
    last = _column(px + reach - left, width, columns)
    lowest = _column(py - reach - bottom, width, lines)
    highest = _column(py + reach - bottom, width, lines)
    for b in range(lowest, highest + 1):
        cell = b * columns
        for s in range(begin[cell + first], begin[cell + last + 1]):
            dx = x[s] - px
            dy = y[s] - py
            j = order[s]
            if j == i or dx * dx + dy * dy > reach * reach:
                continue
            row = rows[count]
            row[AT_X] = dx
            row[AT_Y] = dy
            row[THEIR_VX] = states[j, VX]
            row[THEIR_VY] = states[j, VY]
            row[TOUCH] = min(radii[i], body) + min(radii[j], body)
            row[WISH_X] = wanted[j, 0]
            row[WISH_Y] = wanted[j, 1]
            count += 1
    role = int(command[i, Command.ROBOT_ROLE])
    if role == RobotRole.UNSEEN:
        return count
    for j in range(len(robots)):
        # What is taken for an obstacle is not expected to move.
        moves = 1.0 if role == RobotRole.PEDESTRIAN else 0.0
        row = rows[count]
        row[AT_X] = robots[j, X] - px
        row[AT_Y] = robots[j, Y] - py
        row[THEIR_VX] = moves * robots[j, VX]
        row[THEIR_VY] = moves * robots[j, VY]
        row[TOUCH] = radii[i] + robots[j, RADIUS]
        row[WISH_X] = row[THEIR_VX]
        row[WISH_Y] = row[THEIR_VY]
        count += 1
    return count


@jit
def _turned(ex, ey, ux, uy, reaction, most, time_step):
    """Returns a direction after a turn towards (ux, uy), of any length.

    The angle between them decays with the reaction time, at most at the rate
    `most`. Half a turn is one to the right.
    """
    if math.hypot(ux, uy) < TINY:
        return ex, ey
    angle = math.atan2(ex * uy - ey * ux, ex * ux + ey * uy)
    if angle > math.pi - _TIE:
        angle -= 2 * math.pi
    part = 1.0
    if reaction > 0:
        part = -math.expm1(-time_step / reaction)
    turn = min(max(part * angle, -most * time_step), most * time_step)
    c = math.cos(turn)
    s = math.sin(turn)
    return c * ex - s * ey, s * ex + c * ey


@jit
def direction_of(state, wx, wy):
    """Returns the direction of a person who walks, or else the one wanted."""
    speed = math.hypot(state[VX], state[VY])
    if speed >= _WALKING:
        return state[VX] / speed, state[VY] / speed
    length = math.hypot(wx, wy)
    if length > 0:
        return wx / length, wy / length
    return math.cos(state[YAW]), math.sin(state[YAW])


@jit
def _gap(rows, ex, ey):
    """Returns the least gap to a body ahead, in meters, or infinity.

    A body is ahead if it would be touched by one that moves on straight. One
    in the same place is in no direction.
    """
    gap = math.inf
    for a in range(len(rows)):
        dx = rows[a, AT_X]
        dy = rows[a, AT_Y]
        distance = math.hypot(dx, dy)
        if (
            distance >= TINY
            and dx * ex + dy * ey >= 0
            and abs(ex * dy - ey * dx) <= rows[a, TOUCH]
        ):
            gap = min(gap, distance - rows[a, TOUCH])
    return gap


@jit
def _off_walls(vx, vy, x, y, radius, time, walls, reach):
    """Returns a velocity without what leads into walls within a time."""
    speed = math.hypot(vx, vy)
    if len(walls.segments) == 0 or speed == 0:
        return vx, vy
    reach = min(reach, radius + speed * time)
    runs = runs_in(x - reach, y - reach, x + reach, y + reach, walls)
    for _ in range(_CORNER):
        changed = False
        for i in range(len(runs)):
            for s in range(walls.runs[runs[i], 0], walls.runs[runs[i], 1]):
                px, py, d2 = nearest_on_segments(x, y, walls.segments, s, s + 1)
                distance = math.sqrt(d2)
                if distance > reach or distance < TINY:
                    continue
                nx = (x - px) / distance
                ny = (y - py) / distance
                most = max(distance - radius, 0.0) / time
                into = -(vx * nx + vy * ny) - most
                if into > TINY * speed:
                    vx += into * nx
                    vy += into * ny
                    changed = True
        if not changed:
            break
    return vx, vy


@jit
def walk_on(
    state, command, wish, ux, uy, rows, radius, walls, sight, step, pace, out
):
    """Writes the acceleration of a person who has chosen a direction.

    Args:
        state: That of the person.
        command: That of the person.
        wish: The speed that the person would like to have, in m/s.
        ux: The x of the direction, of any length.
        uy: Its y.
        rows: What the person sees: see `look_around`.
        radius: The one that the person has to walls, in meters.
        walls: See `Walls`.
        sight: Walls farther than this do not count, in meters.
        step: The time step, in seconds.
        pace: Shape (7 or more,): the fields of `SpeedModel`.
        out: Receives the total: a row of `layout.FORCES`.
    """
    vx = state[VX]
    vy = state[VY]
    speed = math.hypot(vx, vy)
    length = math.hypot(ux, uy)
    # Of directions that nearly add up to nothing, none is meant.
    firm = min(length / pace[HESITATION], 1.0) if pace[HESITATION] > 0 else 1.0
    ease = 1.0
    if speed >= _WALKING:
        ex, ey = _turned(
            *(vx / speed, vy / speed, ux, uy),
            *(pace[REACTION_TIME], pace[TURN_RATE], step),
        )
        if length >= TINY:
            ease = (ex * ux + ey * uy) / length
    elif length >= TINY:
        ex = ux / length
        ey = uy / length
    else:
        ex = math.cos(state[YAW])
        ey = math.sin(state[YAW])
    if command[Command.TURN_RATE] == 0:
        facing = math.cos(state[YAW]) * ex + math.sin(state[YAW]) * ey
        ease = min(ease, max(facing, _BACKWARD))
    target = wish * (1 + ease) / 2

    change = pace[ACCELERATION] * step
    speed = max(vx * ex + vy * ey, 0.0)
    speed += min(max(target - speed, -change), change)
    most = max(_gap(rows, ex, ey), 0.0) / max(pace[TIME_GAP], step)
    if firm < 1 and wish > 0:
        most = firm * min(most, target)
    speed = min(speed, most)
    speed = min(speed, command[Command.MAX_SPEED])
    to_x, to_y = _off_walls(
        *(speed * ex, speed * ey, state[X], state[Y], radius),
        *(max(_WALL_TIME, step), walls, sight),
    )
    out[TOTAL_FORCE] = (to_x - vx) / step
    out[TOTAL_FORCE + 1] = (to_y - vy) / step


@jit_as(float64[:, ::1], MATRIX, MATRIX, MATRIX, REAL, REAL, REAL)
def turning_advance(states, forces, command, time_step, reaction, most):
    """Returns where n people are one step later, who turn at a limited rate.

    Like `kernel.advance`; but people whom no command turns turn to where they
    walk, and the slower they do the more to the goal.

    Args:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega.
        forces: Shape (n, FORCES_SIZE); the last two columns count.
        command: Shape (n, COMMAND_SIZE).
        time_step: In seconds.
        reaction: The time in which the angle decays, in seconds.
        most: The largest turn rate, in rad/s.

    Returns:
        Shape (n, 6).
    """
    result = kernel.advance(states, forces, command, time_step)
    for i in range(len(states)):
        if command[i, Command.TURN_RATE] > 0 or command[i, Command.HOLD] != 0:
            continue
        yaw = states[i, YAW]
        ux = result[i, VX]
        uy = result[i, VY]
        gx = command[i, Command.GOAL_X] - states[i, X]
        gy = command[i, Command.GOAL_Y] - states[i, Y]
        distance = math.hypot(gx, gy)
        if (
            command[i, Command.HAS_GOAL] != 0
            and distance > command[i, Command.GOAL_RADIUS]
        ):
            ux += _LOOK * gx / distance
            uy += _LOOK * gy / distance
        elif math.hypot(ux, uy) < _WALKING:
            ux = 0.0
            uy = 0.0
        ex, ey = _turned(
            *(math.cos(yaw), math.sin(yaw), ux, uy, reaction, most, time_step)
        )
        turn = wrap(math.atan2(ey, ex) - yaw)
        result[i, YAW] = wrap(yaw + turn)
        result[i, OMEGA] = turn / time_step
    return result


Time = Annotated[StrictFloat, within(0, 1e3, "s")]
Share = Annotated[StrictFloat, within(0, 1e3)]


@dataclass(kw_only=True, config=CONFIG)
class SpeedModel(MotionModel):
    """What all of these models have: how people take up a direction.

    Attributes stand for what the papers call l = 2 r and T; what follows them
    is not in the papers, whose people turn, start and stop at once.
    """

    # The largest radius that people have to each other and to walls (l / 2),
    # in meters. Of a person whose own is larger, the rest is distance of
    # comfort: it counts to robots only.
    body_radius: Annotated[StrictFloat, within(0, 5, "m", low_open=True)] = 0.15

    # The speed is at most the gap ahead by this time (T), in seconds.
    time_gap: Annotated[StrictFloat, within(0, 1e3, "s", low_open=True)] = 1.0

    # The time in which somebody who walks turns to a new direction (tau of
    # the anticipation velocity model), in seconds.
    reaction_time: Time = 0.0

    # The length of the sum of directions below which people are slower: they
    # do not tremble where they are drawn to and fro. 0 is the papers'.
    hesitation: Share = 0.3

    # The most that people start and stop with of their own will, in m/s^2. For
    # others they stop as the gap has it.
    acceleration: Annotated[
        StrictFloat, within(0, 1e6, "m/s^2", low_open=True)
    ] = 4.0

    # The time in which the body turns to where a person walks, in seconds.
    turn_time: Time = 0.2

    # The largest rate at which the body and the way turn, in rad/s.
    turn_rate: Annotated[
        StrictFloat, within(0, 1e3, "rad/s", low_open=True)
    ] = 5.0

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        states: Array = turning_advance(
            snapshot.states,
            forces,
            snapshot.command,
            snapshot.time_step,
            self.turn_time,
            self.turn_rate,
        )
        return states
