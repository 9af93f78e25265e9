"""What people show each other, and other people and places, in compiled leaves.

A leaf that uses this is registered with ``social=True``: its tree then has the
numbers of `SOCIAL_MEMORY`, and the system has ports for signals.
"""

import math

import numpy as np

from hunav_drake.systems.behavior.nodes.pointers import (
    integers_at,
    numbers_at,
    vector_at,
)
from hunav_drake.systems.behavior.nodes.port import UNSET
from hunav_drake.systems.behavior.nodes.tick import (
    SLOT_SIZE,
    aim,
    command_to,
    human_at,
    place_at,
    robot_at,
)
from hunav_drake.systems.behavior.nodes.tick_context import (
    ADDRESSEE,
    GOAL_PLACE,
    GROUP,
    NEEDS,
    SEAT,
    SEED,
    STOPPED,
    TICKS,
    TICKS_LEFT,
    UTTERANCE,
)
from hunav_drake.systems.common.kernels import jit_part
from hunav_drake.systems.common.layout import (
    MAX_PARTNERS,
    OUTSIDE,
    SIGNAL_SIZE,
    SILENT,
    Activity,
    Command,
    Hold,
    Posture,
    Signal,
)
from hunav_drake.systems.people.places import PLACE_TYPES
from hunav_drake.systems.world.ray_cast import ray_cast

# A row of lists of people: the number of the list, how many, and their rows.
LIST_SIZE = 2 + MAX_PARTNERS

# The time in which people sit down and stand up, in seconds, the least speed,
# in m/s, how near to the place beside a seat they stand again, and by how much
# farther than that place nobody is on the seat, in meters.
_MOVING, _SLOWEST, _UP, _OFF = 1.0, 0.2, 0.02, 0.5

# Whoever is this near to a seat when the trial begins sits on it, in meters.
AT_START = 0.3

# The rows of types of places on which people sit or lie.
SEAT_TYPES = tuple(PLACE_TYPES.index(it) for it in ("seat", "workplace", "bed"))

# The purposes of draws.
CHANCE, DURATION, CHOICE = 4, 5, 6

# Codes of a gaze: along the yaw, and at a point.
AHEAD, AT_POINT = -1.0, -2.0

# (Compiled code knows them as numbers.)
_GAZE, _X, _Y = int(Signal.GAZE), int(Signal.GAZE_X), int(Signal.GAZE_Y)
_STAND, _PLACED = float(Hold.STAND), float(Hold.PLACED)
_SITS = float(Activity.SIT)
_POSTURE, _STANDING = int(Signal.POSTURE), float(Posture.STANDING)
_SILENT = np.array(SILENT)
_SAID, _TO = int(Signal.UTTERANCE), int(Signal.TO)
_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_PLACE, _SLOT = int(Signal.PLACE), int(Signal.SLOT)
_MAX_SPEED = int(Command.MAX_SPEED)
_QUEUE = float(Activity.QUEUE)


@jit_part
def signal_of(tick, index):
    """Returns the row of `social_signals` of a person, or of a robot.

    It is from the tick before; robots come after the people.
    """
    return numbers_at(tick.signals + 8 * SIGNAL_SIZE * index)


@jit_part
def own_signal(tick):
    """Returns the person's row of `social_signals`, to be changed."""
    return numbers_at(tick.signal)


@jit_part
def social_memory(tick):
    """Returns the person's own numbers: see `SOCIAL_MEMORY`."""
    return numbers_at(tick.social)


@jit_part
def num_bodies(tick):
    """Returns the number of people and robots."""
    return tick.num_humans + tick.num_robots


@jit_part
def body_at(tick, index):
    """Returns the state of a person, or of a robot after the people."""
    if index < tick.num_humans:
        return human_at(tick, index)
    return robot_at(tick, index - tick.num_humans)


@jit_part
def is_clear(tick, one, other):
    """Returns whether no wall is between the centers of two bodies."""
    hiding = vector_at(tick.hiding, tick.hiding_size)
    return ray_cast(one.x, one.y, other.x, other.y, hiding) > 1


@jit_part
def row_of(tick, number):
    """Returns the row of the person with a number who is there, or -1."""
    ids = integers_at(tick.ids)
    for i in range(tick.num_humans):
        if ids[i] == number:
            return -1 if human_at(tick, i).x == OUTSIDE else i
    return -1


@jit_part
def number_of(tick, index):
    """Returns the number of a person, by the row; of a robot, -1."""
    return integers_at(tick.ids)[index] if index < tick.num_humans else -1


@jit_part
def comes_first(tick, index, away, found, nearest):
    """Returns whether a body is nearer than the one found, if any.

    Of two who are equally near, it is the one with the lower number.
    """
    if away != nearest:
        return away < nearest
    return found >= 0 and number_of(tick, index) < number_of(tick, found)


@jit_part
def notice(tick, index):
    """Makes a body, if it is a robot, the one to react to."""
    if index >= tick.num_humans:
        tick.noticed = index - tick.num_humans


@jit_part
def is_before(tick, index, since, number):
    """Returns whether what a body does began before something else.

    Of two who begin at once, the one with the lower number is the first.
    """
    begun = signal_of(tick, index)[_SINCE]
    return begun < since or (begun == since and number_of(tick, index) < number)


@jit_part
def place_of(tick, code):
    """Returns the row of a place, by its `place_code`, or -1."""
    for i in range(tick.num_places):
        row = place_at(tick, i)
        if row[0] == code or row[1] == code:
            return i
    return -1


@jit_part
def pose_of(tick, place):
    """Returns the pose (x, y, yaw) of a place in W."""
    row = place_at(tick, place)
    return row[2], row[3], row[4]


@jit_part
def people_in(tick, code):
    """Returns the rows of several people, given the value of a port.

    That is the number of a person or of a list: see `people_code`.
    """
    found = np.empty(MAX_PARTNERS, np.int64)
    count = 0
    if code >= 0:
        row = row_of(tick, code)
        if row >= 0:
            found[0] = row
            count = 1
        return found[:count]
    for i in range(tick.num_lists):
        people = numbers_at(tick.lists + 8 * LIST_SIZE * i)
        if people[0] == code:
            count = int(people[1])
            for k in range(count):
                found[k] = np.int64(people[2 + k])
            break
    return found[:count]


@jit_part
def give_result(tick, slot, value):
    """Sets the entry of a result, by the value of its port."""
    if slot >= 0:
        numbers_at(tick.memory)[np.int64(slot)] = value


@jit_part
def say(tick, utterance, addressee, ticks):
    """Says something for a number of ticks, this one included."""
    memory = social_memory(tick)
    memory[UTTERANCE] = utterance
    memory[ADDRESSEE] = addressee
    memory[TICKS_LEFT] = ticks - 1
    own = own_signal(tick)
    own[_SAID] = utterance
    own[_TO] = addressee


@jit_part
def look_at(tick, target, x, y):
    """Shows a gaze: at a row code, or `AT_POINT`."""
    own = own_signal(tick)
    own[_GAZE] = target
    own[_X] = x
    own[_Y] = y


@jit_part
def show_activity(tick, activity, place, slot, begins=False):
    """Shows an activity, perhaps at a place, since the tick it began.

    What was shown in the tick before goes on, unless it `begins` anew.
    """
    own, before = own_signal(tick), signal_of(tick, tick.index)
    own[_ACTIVITY] = activity
    own[_PLACE] = place
    own[_SLOT] = slot
    is_same = before[_PLACE] == place and before[_SLOT] == slot
    goes_on = before[_ACTIVITY] == activity and is_same and not begins
    own[_SINCE] = before[_SINCE] if goes_on else ticks_of(tick)


@jit_part
def queue_length(tick, code):
    """Returns how many others are in the queue at a place, by its code."""
    place = place_of(tick, code)
    count = 0
    for i in range(num_bodies(tick)):
        signal = signal_of(tick, i)
        is_in = signal[_ACTIVITY] == _QUEUE and signal[_PLACE] == place
        count += i != tick.index and is_in
    return count


@jit_part
def ticks_of(tick):
    """Returns the number of ticks of the tree before this one."""
    return social_memory(tick)[TICKS] if tick.social != 0 else 0.0


@jit_part
def mixed(number):
    """Returns 64 bits mixed from 64 others: SplitMix64."""
    number = number + np.uint64(0x9E3779B97F4A7C15)
    number = (number ^ (number >> np.uint64(30))) * np.uint64(
        0xBF58476D1CE4E5B9
    )
    number = (number ^ (number >> np.uint64(27))) * np.uint64(
        0x94D049BB133111EB
    )
    return number ^ (number >> np.uint64(31))


@jit_part
def uniform(high, low, person, purpose, node, step):
    """Returns a number in [0, 1) that follows from the arguments alone.

    Args:
        high: The upper half of the seed: see `seed_to_halves`.
        low: The lower half.
        person: The number of the person.
        purpose: What it is drawn for.
        node: The row of the leaf.
        step: The tick.
    """
    bits = np.uint64(high) * np.uint64(2**32) + np.uint64(low)
    bits = mixed(bits)
    for each in (person, purpose, node, np.int64(step)):
        bits = mixed(bits ^ np.uint64(each))
    return np.float64(bits >> np.uint64(11)) / 2.0**53


@jit_part
def draw(tick, purpose):
    """Returns the number in [0, 1) that a leaf draws in this tick."""
    memory = social_memory(tick)
    person = number_of(tick, tick.index)
    high, low = memory[SEED], memory[SEED + 1]
    return uniform(high, low, person, purpose, tick.row, memory[TICKS])


@jit_part
def begin_signal(tick, is_outside):
    """Begins the row of a person: silent, or going on to say something."""
    own = own_signal(tick)
    for i in range(SIGNAL_SIZE):
        own[i] = _SILENT[i]
    if tick.social == 0 or is_outside:
        return
    memory = social_memory(tick)
    if memory[TICKS_LEFT] > 0:
        memory[TICKS_LEFT] -= 1
        own[_SAID] = memory[UTTERANCE]
        own[_TO] = memory[ADDRESSEE]
    for i in range(tick.num_needs):
        level, rate = memory[NEEDS + 2 * i], memory[NEEDS + 2 * i + 1]
        memory[NEEDS + 2 * i] = max(level - rate * tick.time_step, 0.0)
    if memory[GROUP] != UNSET:
        tick.group_id = memory[GROUP]
    if 1 <= memory[SEAT] <= tick.num_place_slots and _is_off_seat(tick):
        memory[SEAT] = 0.0
    place = memory[GOAL_PLACE]
    if 1 <= place <= tick.num_places:
        tick.goal_place = np.int64(place)
        aim(tick)


@jit_part
def end_signal(tick):
    """Ends the tick of a person who has social leaves."""
    if tick.social == 0:
        return
    memory = social_memory(tick)
    memory[TICKS] += 1
    memory[GOAL_PLACE] = tick.goal_place
    if memory[STOPPED] != 0:
        tick.hold = _STAND
        tick.turn_rate = 0.0
    if memory[TICKS] == 1 and memory[SEAT] == 0:
        memory[SEAT] = _seat_at(tick)
    if 1 <= memory[SEAT] <= tick.num_place_slots:
        _sit(tick, memory)


@jit_part
def _seat_at(tick):
    """Returns the seat at which a person is, from 1; 0 if there is none.

    Whoever is on a seat at the start and does not use it stands up.
    """
    for row in range(tick.num_place_slots):
        x, y, _, _, _, place, _ = slot_at(tick, row)
        away = math.hypot(x - tick.x, y - tick.y)
        kind = place_at(tick, np.int64(place))[7]
        if away < AT_START and np.int64(kind) in SEAT_TYPES:
            return row + 1.0
    return 0.0


@jit_part
def _is_off_seat(tick):
    """Returns whether a person is far from its seat.

    So it is if it was put elsewhere, or follows a recording.
    """
    seat = slot_at(tick, np.int64(social_memory(tick)[SEAT]) - 1)
    x, y, ax, ay = seat[0], seat[1], seat[3], seat[4]
    way = math.hypot(ax - x, ay - y)
    return math.hypot(x - tick.x, y - tick.y) > way + _OFF


@jit_part
def _sit(tick, memory):
    """Keeps a person on its seat, or stands it up if nothing keeps it there.

    So nobody who is interrupted is left inside of furniture.
    """
    slot = np.int64(memory[SEAT]) - 1
    own, before = own_signal(tick), signal_of(tick, tick.index)
    sx, sy, yaw, ax, ay, place, number = slot_at(tick, slot)
    x, y = sx, sy
    if own[_POSTURE] == _STANDING:
        if math.hypot(ax - tick.x, ay - tick.y) < _UP:
            memory[SEAT] = 0.0
            return
        x, y = ax, ay
        if own[_PLACE] < 0:
            # (The seat is not free yet.)
            if own[_ACTIVITY] == 0:
                own[_ACTIVITY] = _SITS
            own[_PLACE] = place
            own[_SLOT] = number
            own[_SINCE] = before[_SINCE]
    tick.hold = _PLACED
    tick.goal_x = x
    tick.goal_y = y
    tick.has_goal = 1.0
    speed = max(math.hypot(ax - sx, ay - sy) / _MOVING, _SLOWEST)
    own_most = command_to(tick, tick.num_goals)[_MAX_SPEED]
    tick.desired_speed = min(speed, own_most)
    tick.yaw_target = yaw
    tick.turn_rate = math.pi


@jit_part
def slot_at(tick, row):
    """Returns the numbers of a slot, by its row: see `SLOT_SIZE`."""
    it = numbers_at(tick.slots_of_places + 8 * SLOT_SIZE * row)
    return it[0], it[1], it[2], it[3], it[4], it[5], it[6]
