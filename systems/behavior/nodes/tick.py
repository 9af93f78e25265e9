"""The data of one tick of a person's tree, for compiled leaves.

A compiled leaf takes a `Tick`, its own numbers if it remembers any, and its
ports as numbers: a text of a Literal as its index, a boolean as 0 or 1.
"""

import math
from typing import get_type_hints

import numba
import numpy as np

from hunav_drake.systems.behavior.nodes.pointers import (
    numbers_at,
    record_at,
    vector_at,
)
from hunav_drake.systems.common.kernels import jit_inline
from hunav_drake.systems.common.layout import COMMAND_SIZE, STATE_FIELDS
from hunav_drake.systems.world.ray_cast import ray_cast


class Tick:
    """The fields of a tick; compiled code has a record of them.

    After the index comes the person's row of `human_states`, in W, then the
    behavior status and the command of the person, laid out as
    `layout.Command`: before any leaf writes, it is to walk to the current
    goal. Leaves write these two, and only read the rest. Arrays are addresses.
    """

    # The place of the person in `human_states`.
    index: int

    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    omega: float
    radius: float

    behavior_status: float
    goal_x: float
    goal_y: float
    goal_radius: float
    has_goal: float
    desired_speed: float
    max_speed: float
    robot_role: float
    robot_repulsion: float
    hold: float
    turn_rate: float
    yaw_target: float
    group_id: float

    # The index of the current goal, and of the robot to react to, or -1.
    goal: int
    noticed: int

    # Rows of all people, and of all robots: `STATE`.
    humans: int
    num_humans: int
    robots: int
    num_robots: int

    # The person: see `Person`. Its commands for each goal, and for none.
    commands: int
    num_goals: int
    cyclic: int
    reach: float
    body_radius: float
    time_step: float
    walls: int
    walls_size: int
    hiding: int
    hiding_size: int

    # The tree: see `Program`. Its memory and the status of its nodes.
    rows: int
    num_rows: int
    slots: int
    ports: int
    numbers: int
    steps: int
    halted: int
    num_halted: int
    memory: int
    statuses: int

    # The person's part of the memory of all; the memory at the start, if
    # people can be outside, else 0.
    first_slot: int
    num_slots: int
    initial: int

    # Numbers that last for the tick: of each node, of its ports, of scripts.
    scratch: int
    values: int
    stack: int
    # For each robot a number, for leaves; and rows of people who stand, see
    # `find_standing`.
    distances: int
    standing: int
    num_standing: int

    # Where the walk was interrupted, and why: see `walk`.
    person: int
    row: int
    slot: int
    code: int


_KINDS = get_type_hints(Tick)
TICK = np.dtype(
    [
        (name, np.float64 if kind is float else np.int64)
        for name, kind in _KINDS.items()
    ]
)
TICK_RECORD = numba.from_dtype(TICK)
STATE = np.dtype([(name, np.float64) for name in STATE_FIELDS])

# In a tick, the numbers before the state and before the command, and of all.
STATE_AT = list(_KINDS).index("x")
COMMAND_AT = list(_KINDS).index("goal_x")
TICK_SIZE = len(_KINDS)


@jit_inline
def human_at(tick, index):
    """Returns the state of one of the people: a record `STATE`."""
    return record_at(tick.humans, index, STATE)


@jit_inline
def robot_at(tick, index):
    """Returns the state of one of the robots: a record `STATE`."""
    return record_at(tick.robots, index, STATE)


@jit_inline
def command_to(tick, goal):
    """Returns the command to walk to a goal: see `Person.commands`."""
    return numbers_at(tick.commands + 8 * COMMAND_SIZE * goal)


@jit_inline
def has_goal(tick):
    """Returns whether there is a goal to walk to."""
    return tick.goal < tick.num_goals


@jit_inline
def goal_of(tick):
    """Returns the current goal in W, in meters; there must be one."""
    command = command_to(tick, tick.goal)
    return command[0], command[1]


@jit_inline
def next_goal(tick):
    """Goes on to the next goal, and makes it the goal of the command.

    Returns whether there was a goal to drop.
    """
    if not has_goal(tick):
        return False
    tick.goal += 1
    if tick.cyclic and tick.goal == tick.num_goals:
        tick.goal = 0
    command = command_to(tick, tick.goal)
    tick.goal_x = command[0]
    tick.goal_y = command[1]
    tick.has_goal = command[3]
    return True


@jit_inline
def robot_of(tick):
    """Returns the index of the robot to react to; -1 if there are no robots.

    It is the one that a condition has noticed last in this tick; if none has,
    the nearest one.
    """
    if tick.noticed >= 0:
        return tick.noticed
    if tick.num_robots < 2:
        return tick.num_robots - 1
    found, nearest = -1, math.inf
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        away = math.hypot(robot.x - tick.x, robot.y - tick.y)
        if away < nearest:
            found, nearest = i, away
    return found


@jit_inline
def standing_of(tick):
    """Returns rows of the people who stand: see `find_standing`."""
    rows = vector_at(tick.standing, 3 * tick.num_standing)
    return rows.reshape((tick.num_standing, 3))


@jit_inline
def walls_of(tick):
    """Returns `Obstacles.table` of what the person cannot walk through."""
    return vector_at(tick.walls, tick.walls_size)


@jit_inline
def sees(tick, x, y):
    """Returns whether nothing hides a point in W from the person."""
    hiding = vector_at(tick.hiding, tick.hiding_size)
    return ray_cast(tick.x, tick.y, x, y, hiding) > 1


@jit_inline
def cast_ray(tick, start, x, y):
    """Casts a ray along the floor, from the center of a body to a point in W.

    Returns the fraction of the ray at which it meets the first wall, in
    [0, 1]; infinity if it meets none.
    """
    return ray_cast(start.x, start.y, x, y, walls_of(tick))
