"""The data of one tick of a person's tree, for compiled leaves.

A compiled leaf takes a `Tick`, its own numbers if it remembers any, and its
ports as numbers: a text of a Literal as its index, a boolean as 0 or 1.
"""

import math
from typing import Any

import numba
import numpy as np

from hunav_drake.systems.behavior.nodes.pointers import (
    numbers_at,
    record_at,
    vector_at,
)
from hunav_drake.systems.behavior.nodes.tick_context import (
    LATER_PLACES,
    MAX_PLACES,
)
from hunav_drake.systems.common.kernels import jit_part, rows_of
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    STATE_FIELDS,
    STATE_SIZE,
    Command,
)
from hunav_drake.systems.world.ray_cast import ray_cast

# Compiled code has a record of these fields. After the index of the person come
# the row of `human_states`, in W, and the behavior status and the command, laid
# out as `layout.Command`: before any leaf writes, it is to walk to the current
# goal. Leaves write these two, and only read the rest. Arrays are addresses.
TICK_FIELDS = (
    *("index", *STATE_FIELDS, "behavior_status"),
    *(it.name.lower() for it in Command),
    # The index of the current goal, and of the robot to react to, or -1.
    *("goal", "noticed"),
    # Rows of all people, and of all robots: `STATE`.
    *("humans", "num_humans", "robots", "num_robots"),
    # The person: see `Person`. Its commands for each goal, and for none.
    *("commands", "num_goals", "cyclic", "reach", "body_radius", "time_step"),
    # Whether the person ignores invitations.
    "ignores",
    *("walls", "walls_size", "hiding", "hiding_size"),
    # The tree: see `Program`. Its memory and the status of its nodes.
    *("rows", "num_rows", "slots", "ports", "numbers", "steps"),
    *("halted", "num_halted", "memory", "statuses"),
    # The person's part of the memory of all; the memory at the start, if people
    # can be outside, else 0.
    *("first_slot", "num_slots", "initial"),
    # Numbers that last for the tick: of each node, of its ports, of scripts;
    # for each robot one, for leaves; and rows of people who stand, see
    # `find_standing`.
    *("scratch", "values", "stack", "distances", "standing", "num_standing"),
    # What people and robots show each other: rows of `layout.Signal` of all,
    # as they were in the tick before, or 0; and the row of this person. The
    # numbers of all people, and the person's own: `SOCIAL_MEMORY`, or 0.
    *("signals", "signal", "ids", "social"),
    # The place that is the current goal: 1 + its row, or 0. The number of needs
    # in the memory, after `SOCIAL_MEMORY`.
    *("goal_place", "num_needs"),
    # Rows of places and of their slots, and of lists of people; see `social`.
    *("places", "num_places", "slots_of_places", "num_place_slots"),
    *("lists", "num_lists"),
    # Where the walk was interrupted, and why: see `walk`.
    *("person", "row", "slot", "code"),
)
# The numbers of a place: the two by which it is named, its pose in W, the
# distance in a queue and the time, its type, and its slots: the row of the
# first, and how many; where people walk to in W; and the width of a door.
PLACE_SIZE = 13

# The numbers of a slot: its pose in W, where people stand before they use it,
# and the rows of the place, and of the slot in it.
SLOT_SIZE = 7

# In a tick, the numbers before the state and before the command, and of all.
STATE_AT, COMMAND_AT = 1, 1 + STATE_SIZE + 1
TICK_SIZE = len(TICK_FIELDS)
_REAL = {
    *TICK_FIELDS[STATE_AT : COMMAND_AT + COMMAND_SIZE],
    *("reach", "body_radius", "time_step"),
}

TICK = np.dtype(
    [(it, np.float64 if it in _REAL else np.int64) for it in TICK_FIELDS]
)
TICK_RECORD = numba.from_dtype(TICK)
STATE = np.dtype([(name, np.float64) for name in STATE_FIELDS])

# A record of it, in compiled code.
Tick = Any


@jit_part
def human_at(tick, index):
    """Returns the state of one of the people: a record `STATE`."""
    return record_at(tick.humans, index, STATE)


@jit_part
def robot_at(tick, index):
    """Returns the state of one of the robots: a record `STATE`."""
    return record_at(tick.robots, index, STATE)


@jit_part
def command_to(tick, goal):
    """Returns the command to walk to a goal: see `Person.commands`."""
    return numbers_at(tick.commands + 8 * COMMAND_SIZE * goal)


@jit_part
def place_at(tick, row):
    """Returns the numbers of a place, by its row: see `PLACE_SIZE`."""
    return numbers_at(tick.places + 8 * PLACE_SIZE * row)


@jit_part
def way_to(tick, row):
    """Returns where people walk to who only want to get to a place, in W."""
    place = place_at(tick, row)
    return place[10], place[11]


@jit_part
def has_goal(tick):
    """Returns whether there is a goal to walk to."""
    return tick.goal < tick.num_goals or tick.goal_place > 0


@jit_part
def goal_of(tick):
    """Returns the current goal in W, in meters; there must be one."""
    if tick.goal_place > 0:
        return way_to(tick, tick.goal_place - 1)
    command = command_to(tick, tick.goal)
    return command[0], command[1]


@jit_part
def next_goal(tick):
    """Goes on to the next goal, and makes it the goal of the command.

    Returns whether there was a goal to drop.
    """
    if not has_goal(tick):
        return False
    is_last = False
    if tick.goal_place > 0:
        tick.goal_place = 0
    else:
        tick.goal += 1
        is_last = tick.goal == tick.num_goals
        if tick.cyclic and is_last:
            tick.goal = 0
    if tick.social != 0:
        tick.goal_place = later_place(
            tick, is_last or tick.goal == tick.num_goals
        )
    aim(tick)
    return True


@jit_part
def aim(tick):
    """Makes the current goal that of the command."""
    if tick.goal_place > 0:
        tick.goal_x, tick.goal_y = goal_of(tick)
        tick.has_goal = 1.0
        return
    command = command_to(tick, tick.goal)
    tick.goal_x = command[0]
    tick.goal_y = command[1]
    tick.has_goal = command[3]


@jit_part
def later_place(tick, is_last):
    """Takes the next of the places to come: 1 + its row, or 0.

    Those after the person's own goals count from when it `is_last`.
    """
    later = numbers_at(tick.social + 8 * LATER_PLACES)
    if is_last:
        for i in range(MAX_PLACES):
            later[i] = abs(later[i])
    for i in range(MAX_PLACES):
        if later[i] > 0:
            place = np.int64(later[i])
            for k in range(i, MAX_PLACES - 1):
                later[k] = later[k + 1]
            later[MAX_PLACES - 1] = 0.0
            # (The memory may be of a trial with other places.)
            return place if 1 <= place <= tick.num_places else 0
    return 0


@jit_part
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


@jit_part
def kept_robot(tick, own, at):
    """Returns the index of the robot that an action goes on with, or -1.

    It is that of its first tick, one of the numbers of the action, unless a
    condition notices another; for what follows, it is noticed.
    """
    if tick.noticed < 0 and 0 < own[at] <= tick.num_robots:
        tick.noticed = np.int64(own[at]) - 1
    tick.noticed = robot_of(tick)
    own[at] = tick.noticed + 1.0
    return tick.noticed


@jit_part
def standing_of(tick):
    """Returns rows of the people who stand: see `find_standing`."""
    return rows_of(vector_at(tick.standing, 3 * tick.num_standing), 3)


@jit_part
def walls_of(tick):
    """Returns `Obstacles.table` of what the person cannot walk through."""
    return vector_at(tick.walls, tick.walls_size)


@jit_part
def sees(tick, x, y):
    """Returns whether nothing hides a point in W from the person."""
    hiding = vector_at(tick.hiding, tick.hiding_size)
    return ray_cast(tick.x, tick.y, x, y, hiding) > 1


@jit_part
def cast_ray(tick, start, x, y):
    """Casts a ray along the floor, from the center of a body to a point in W.

    Returns the fraction of the ray at which it meets the first wall, in
    [0, 1]; infinity if it meets none.
    """
    return ray_cast(start.x, start.y, x, y, walls_of(tick))
