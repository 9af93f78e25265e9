"""Lets people follow others and give way to them, compiled by numba.

Forces alone let a crowd walk at full speed at any density. Therefore people
keep a time gap to the person ahead, and step aside for oncoming people in
their lane: away from them, and if in doubt to the right.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit, jit_as
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import VX, VY, Command, X, Y
from hunav_drake.systems.crowd.bodies.pairs import near_pairs
from hunav_drake.systems.people.parameters import EPSILON

# Half the width of the lane ahead, in sums of the radii of two bodies.
LANE = 0.7

# The least speed behind others who walk, in m/s.
SLOWEST = 0.02

# People whose directions differ by more than 120 degrees meet head-on.
_OPPOSITE = -0.5

# The distance from which on people step aside, in meters, and the largest
# angle, in radians.
_PASSING = 2.0
_SIDESTEP = 0.8

# An oncoming person off to one side by less than this is passed on the right,
# in meters; on the left with a negative epsilon, the tie-breaker of the social
# force.
DOUBT = 0.3

# A person who passes somebody has this radius at walls, in meters, and this
# share of their force.
SLIM, SOFT = 0.12, 0.2


@jit
def _look_ahead(
    pairs, states, ways, bodies, time_gap, matching, passing, wanted, room
):
    """Adapts both people of each pair to each other.

    Array `wanted` receives the desired speeds, and `room` the gap to an
    oncoming person, and the offset of that person to the left.
    """
    for p in range(len(pairs)):
        for turn in range(2):
            i = pairs[p, turn]
            j = pairs[p, 1 - turn]
            ex = ways[i, 0]
            ey = ways[i, 1]
            dx = states[j, X] - states[i, X]
            dy = states[j, Y] - states[i, Y]
            both = bodies[i] + bodies[j]
            if dx * ex + dy * ey <= 0 or abs(dx * ey - dy * ex) >= LANE * both:
                continue
            gap = max(math.sqrt(dx * dx + dy * dy) - both, 0.0)
            if ex * ways[j, 0] + ey * ways[j, 1] < _OPPOSITE:
                if gap < room[i, 0]:
                    room[i, 0] = gap
                    room[i, 1] = ex * dy - ey * dx
                continue
            along = states[j, VX] * ex + states[j, VY] * ey
            stands = ways[j, 0] == 0 and ways[j, 1] == 0
            least = passing if stands else SLOWEST
            speed = max(gap / time_gap + matching * max(along, 0.0), least)
            wanted[i, Command.DESIRED_SPEED] = min(
                wanted[i, Command.DESIRED_SPEED], speed
            )


@late_as(
    numba.types.Tuple((*(float64[:, ::1],) * 2, numba.int64[:, ::1], float64)),
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, REAL, REAL, REAL),
)
def follow(
    states, bodies, command, parameters, at_walls, time_gap, matching, passing
):
    """Returns the result of `keep_time_gap`, and the pairs that it examined.

    They are all pairs of people whose bodies are less than twice a distance
    apart; that distance, in meters, is the last result.
    """
    n = len(states)
    wanted = command.copy()
    felt = at_walls.copy()
    ways = np.zeros((n, 2))
    reach = np.empty(n)
    room = np.full((n, 2), _PASSING)
    fastest = 0.0
    for i in range(n):
        gx = command[i, Command.GOAL_X] - states[i, X]
        gy = command[i, Command.GOAL_Y] - states[i, Y]
        far = math.sqrt(gx * gx + gy * gy)
        if (
            command[i, Command.HAS_GOAL] != 0
            and far > command[i, Command.GOAL_RADIUS]
        ):
            ways[i, 0] = gx / far
            ways[i, 1] = gy / far
        fastest = max(fastest, command[i, Command.DESIRED_SPEED])
    ahead = max(fastest * time_gap, _PASSING) / 2
    for i in range(n):
        reach[i] = bodies[i] + ahead
    pairs = near_pairs(states[:, X], states[:, Y], reach)
    _look_ahead(
        *(pairs, states, ways, bodies),
        *(time_gap, matching, passing, wanted, room),
    )
    for i in range(n):
        if room[i, 0] < _PASSING:
            doubt = DOUBT * np.sign(parameters[i, EPSILON])
            side = np.sign(room[i, 1] + doubt)
            turn = side * _SIDESTEP * (1 - room[i, 0] / _PASSING)
            gx = command[i, Command.GOAL_X] - states[i, X]
            gy = command[i, Command.GOAL_Y] - states[i, Y]
            c = math.cos(turn)
            s = math.sin(turn)
            wanted[i, Command.GOAL_X] = states[i, X] + c * gx + s * gy
            wanted[i, Command.GOAL_Y] = states[i, Y] + c * gy - s * gx
            felt[i, 0] = min(felt[i, 0], SLIM)
            felt[i, 1] *= SOFT
    return wanted, felt, pairs, ahead


@jit_as(
    numba.types.UniTuple(float64[:, ::1], 2),
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, REAL, REAL, REAL),
)
def keep_time_gap(
    states, bodies, command, parameters, at_walls, time_gap, matching, passing
):
    """Returns commands and `at_walls` of people in view of others.

    The desired speed is at most gap / time_gap + matching v, with the gap
    between the bodies and the speed v of the nearest person ahead in the own
    lane who is not oncoming. An oncoming person is passed: the goal is turned
    aside, mostly to the right, and the shoulders are turned, so that walls
    push less. The time gap is above 0, in seconds. Behind who has nowhere to
    go, the desired speed stays at least `passing`, in m/s, so that people whose
    bodies touch get around.
    """
    wanted, felt, _, _ = follow(
        *(states, bodies, command, parameters, at_walls),
        *(time_gap, matching, passing),
    )
    return wanted, felt
