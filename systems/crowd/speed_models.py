"""The common part of models in which people choose a direction, then a speed.

The speed keeps people apart: nobody walks faster in the chosen direction than
the gap to the next body allows. Compiled by numba.
"""

import math
from typing import Annotated

from numba import float64
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.common.layout import (
    OMEGA,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
)
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.crowd.motion_model import Array, MotionModel, Snapshot
from hunav_drake.systems.crowd.social_force import kernel
from hunav_drake.systems.crowd.social_force.compiled_forces import wrap
from hunav_drake.systems.crowd.surroundings import AT_X, AT_Y, TINY, TOUCH
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import runs_in

# A turn within this of a half turn goes to the right, in radians.
_TIE = 1e-9

# Speed below which a person starts to walk in any direction at once, in m/s.
_WALKING = 0.1

# Well below this speed people look to the goal rather than ahead, in m/s.
_LOOK = 0.3

# People look where they go, and walk slower sideways or back: the cosine from
# which on they walk no slower.
_BACKWARD = -0.5

# The time ahead in which nobody walks into a wall, in seconds.
_WALL_TIME = 0.25

# The number of passes over the walls of a corner.
_CORNER = 3


@jit
def _turned(ex, ey, ux, uy, reaction, most, time_step):
    """Returns a direction after a turn towards (ux, uy), of any length.

    The angle between them decays with the reaction time, at most at the rate
    `most`. A half turn is to the right.
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
    """Returns the direction of a person who walks, else the desired one."""
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

    A body is ahead if the person would touch it straight on. One at the same
    position is in no direction.
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
    """Returns a velocity without the part that leads into walls in a time."""
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

    (ux, uy) is that direction, of any length, `wish` the desired speed, in m/s,
    `rows` are the surroundings (see `look_around`), and `radius` is that with
    respect to walls, which count up to `sight`, in meters. `pace` has the
    fields of `SpeedModel`, and maybe more; `out` receives the total, as a row
    of `layout.FORCES`.
    """
    vx = state[VX]
    vy = state[VY]
    speed = math.hypot(vx, vy)
    length = math.hypot(ux, uy)
    # If directions nearly cancel each other, none is preferred.
    firm = min(length / pace.hesitation, 1.0) if pace.hesitation > 0 else 1.0
    ease = 1.0
    if speed >= _WALKING:
        ex, ey = _turned(
            *(vx / speed, vy / speed, ux, uy),
            *(pace.reaction_time, pace.turn_rate, step),
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

    change = pace.acceleration * step
    speed = max(vx * ex + vy * ey, 0.0)
    speed += min(max(target - speed, -change), change)
    most = max(_gap(rows, ex, ey), 0.0) / max(pace.time_gap, step)
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
    """Returns the states of n people one step later, with limited turn rates.

    Like `kernel.advance`; but people whom no command turns turn to their
    walking direction, and the slower they walk, the more to the goal. The angle
    decays with the time `reaction`, in seconds, at most at the rate `most`, in
    rad/s.
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


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class SpeedModel(MotionModel):
    """The common parameters of these models: how people take up a direction.

    The first two are l = 2 r and T of the papers; the others are not in the
    papers, whose people turn, start and stop at once.
    """

    uses_weights = "pushed"

    body_radius: Annotated[StrictFloat, within(0, 5, "m", low_open=True)] = 0.15
    """Largest radius of people with respect to each other and to walls (l / 2),
    in meters. The rest of a larger radius is comfort distance, which counts
    only to robots."""

    time_gap: Annotated[StrictFloat, within(0, 1e3, "s", low_open=True)] = 1.0
    """Time gap to a body ahead, which limits the speed (T), in seconds."""

    reaction_time: Time = 0.0
    """Time constant with which a walking person turns to a new direction (tau
    of the anticipation velocity model), in seconds."""

    hesitation: Share = 0.3
    """Length of the sum of directions below which people are slower, so that
    they do not tremble between directions. 0 is the value of the papers."""

    acceleration: Annotated[
        StrictFloat, within(0, 1e6, "m/s^2", low_open=True)
    ] = 4.0
    """Largest acceleration and deceleration by a person's own will, in m/s^2.
    For others, people stop as the gap demands."""

    turn_time: Time = 0.2
    """Time constant with which the body turns to the walking direction, in
    seconds."""

    turn_rate: Annotated[
        StrictFloat, within(0, 1e3, "rad/s", low_open=True)
    ] = 5.0
    """Largest rate at which the body and the direction turn, in rad/s."""

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
