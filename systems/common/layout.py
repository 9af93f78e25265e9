"""The layout of the vectors that the systems exchange.

Everything is in SI units and radians, in the world frame W. `n` people come
in the order of the scenario; the vectors of several people are their rows,
one after the other.
"""

from enum import IntEnum
from typing import Any

from hunav_drake.systems.common.field_docs import explain

X, Y, YAW, VX, VY, OMEGA, RADIUS = range(7)
STATE_FIELDS = ("x", "y", "yaw", "vx", "vy", "omega", "radius")
"""A row of `human_states` and of `robot_states`: the pose in W, the velocity of
the center expressed in W, the turn rate, and the radius of the body's disc."""

STATE_SIZE = len(STATE_FIELDS)

# The part of it in the state of a crowd: all but the radius.
MOTION_SIZE = RADIUS

OUTSIDE = 1e6
"""The x and y of people who are not here, in meters.

People come in at sources and leave at sinks (see `people.traffic`); vectors
have rows for them also while they are outside, and rows of people whom a robot
does not see. Such a row of `human_states` is at rest at (OUTSIDE, OUTSIDE),
with yaw and radius 0: farther away than any coordinate that a scenario may
have, so that distances need no special case, and finite, unlike NaN, which
would spread. Only recordings have rows of NaN.
"""


def is_outside(states: Any) -> Any:
    """Returns who is outside, shape (...), from rows (..., 6 or 7)."""
    return states[..., X] == OUTSIDE


@explain
class RobotRole(IntEnum):
    """The role of the robots in the forces on a person."""

    UNSEEN = 0
    """The robot does not act on the person."""

    PEDESTRIAN = 1
    """The robot acts on the person like another person."""

    OBSTACLE = 2
    """The robot acts on the person like a wall."""

    UNSEEN_IN_TURN = 3
    """Unseen; and with HuNavSim's rules, the forces on the person are those
    after the people listed later have moved."""


@explain
class Hold(IntEnum):
    """Whether a person walks."""

    WALK = 0
    """Walks."""

    STAND = 1
    """Stands still: the velocity becomes zero at once."""

    STAY = 2
    """Stays in place with the velocity that others see, like people who stop in
    HuNavSim; with all other motion models, stands still."""

    PLACED = 3
    """Moves straight to the goal at the desired speed, whatever is there, and
    turns to the desired yaw: sits down, sits, stands up. Others make way."""


@explain
class Command(IntEnum):
    """The elements of a `command` to a person.

    The behavior tree decides them; the crowd obeys.
    """

    GOAL_X = 0
    """X of the point to walk to, in W, in meters."""

    GOAL_Y = 1
    """Y of the point to walk to, in W, in meters."""

    GOAL_RADIUS = 2
    """Distance at which that point counts as reached, in meters."""

    HAS_GOAL = 3
    """1 if there is a goal; 0 lets the person come to rest."""

    DESIRED_SPEED = 4
    """Desired speed, in m/s."""

    MAX_SPEED = 5
    """Speed limit, in m/s."""

    ROBOT_ROLE = 6
    """Role of the robots in the forces: a RobotRole."""

    ROBOT_REPULSION = 7
    """Gain k of an extra push away from the nearest robot, in m^2/s^2: k /
    max(d - R, 0.05 m) at center distance d, for a person of radius R."""

    HOLD = 8
    """Whether the person walks: a Hold."""

    TURN_RATE = 9
    """Largest turn rate towards YAW_TARGET, in rad/s; 0 leaves the yaw to
    follow the velocity."""

    YAW_TARGET = 10
    """Heading to turn to, in W, in radians. With a turn rate of 0 and the role
    UNSEEN_IN_TURN, it is a distance in meters instead: within it of a robot
    after the step, the person looks at that robot at once."""

    GROUP_ID = 11
    """Present group of the person, or -1: see `group_id` of HumanConfig."""


COMMAND_SIZE = len(Command)


@explain
class Signal(IntEnum):
    """The elements of a row of `social_signals`: what a person shows others.

    Others are told by row codes: the row of a person, n plus the row of a
    robot, or -1 for nobody and everybody.
    """

    UTTERANCE = 0
    """What the person says: 0 nothing, else a `text_code`."""

    TO = 1
    """Row code of the one it is said to."""

    GESTURE = 2
    """Gesture: a Gesture."""

    GAZE = 3
    """Row code of the one looked at; -1 along the yaw; -2 at the point of the
    gaze."""

    GAZE_X = 4
    """X of the point of the gaze, in W, in meters."""

    GAZE_Y = 5
    """Y of the point of the gaze, in W, in meters."""

    ACTIVITY = 6
    """What the person does: an Activity, or a number from 100 of your own."""

    PLACE = 7
    """Row of the place that the person claims, from 0, or -1."""

    SLOT = 8
    """Number of the slot of it, or -1."""

    SINCE = 9
    """Tick in which this activity began."""

    HOST = 10
    """Row of the host of the person's circle or group, or -1."""

    OPEN = 11
    """Offer of a host: 0 none, 1 to the partners, 2 to everybody."""

    CENTER_X = 12
    """X of a host's circle, or of the goal of its walk, in W, in meters."""

    CENTER_Y = 13
    """Y of a host's circle, or of the goal of its walk, in W, in meters."""

    ANGLE = 14
    """Direction of the first place of a host's circle, in W, in radians."""

    PARTNER_1 = 15
    """Row of the first person invited, or -1."""

    PARTNER_2 = 16
    """Row of the second person invited, or -1."""

    PARTNER_3 = 17
    """Row of the third person invited, or -1."""

    PARTNER_4 = 18
    """Row of the fourth person invited, or -1."""

    PARTNER_5 = 19
    """Row of the fifth person invited, or -1."""

    PARTNER_6 = 20
    """Row of the sixth person invited, or -1."""

    POSTURE = 21
    """Posture: a Posture."""


SIGNAL_SIZE = len(Signal)

# The elements of a signal that tell whom it is about, by row codes.
WHO: tuple[Signal, ...] = (
    *(Signal.TO, Signal.GAZE, Signal.HOST),
    *map(Signal, range(Signal.PARTNER_1, Signal.PARTNER_6 + 1)),
)

SILENT = tuple(
    -1.0
    if it in (Signal.TO, Signal.GAZE, Signal.PLACE, Signal.SLOT, Signal.HOST)
    or Signal.PARTNER_1 <= it <= Signal.PARTNER_6
    else 0.0
    for it in Signal
)
"""A row of `social_signals` of a person who shows nothing."""

# The largest number of people that a host can name.
MAX_PARTNERS = Signal.PARTNER_6 - Signal.PARTNER_1 + 1


@explain
class Gesture(IntEnum):
    """The gestures of people and robots."""

    NONE = 0
    """None."""

    WAVE = 1
    """Waves."""

    POINT = 2
    """Points."""

    BECKON = 3
    """Beckons."""

    NOD = 4
    """Nods."""

    YOU_FIRST = 5
    """Lets another one go first."""


@explain
class Activity(IntEnum):
    """What a person does, as others see it."""

    NONE = 0
    """Walks, or stands."""

    CONVERSATION = 1
    """Talks in a circle."""

    QUEUE = 2
    """Stands in a queue."""

    USE = 3
    """Uses a thing at a place."""

    SIT = 4
    """Sits."""

    FOLLOW = 5
    """Follows somebody."""

    ACCOMPANY = 6
    """Walks beside a robot."""

    BLOCK = 7
    """Blocks the way."""

    WATCH = 8
    """Looks at a screen."""

    GIVE_WAY = 9
    """Gives way."""

    GROUP_WALK = 10
    """Walks with a group."""

    WAIT = 11
    """Waits."""

    FLEE = 12
    """Keeps away from a robot."""


@explain
class Posture(IntEnum):
    """How a person holds the body."""

    STANDING = 0
    """Stands or walks."""

    SEATED = 1
    """Sits."""

    LYING = 2
    """Lies."""


FORCES = (
    "goal",
    "obstacle",
    "social",
    "group_gaze",
    "group_coherence",
    "group_repulsion",
    "robot_repulsion",
    "total",
)
"""The accelerations in a row of `forces`, each a pair (x, y) in W, in m/s^2.

- `goal`: towards the desired velocity.
- `obstacle`: from walls, and from robots in that role.
- `social`: from other people, and from robots that are pedestrians.
- `group_gaze`: deceleration that keeps the others of the group in view.
- `group_coherence`: to the middle of the group.
- `group_repulsion`: from others of the group who are too near.
- `robot_repulsion`: from the nearest robot, if the behavior demands it.
- `total`: the sum, which moves the person.
"""

FORCES_SIZE = 2 * len(FORCES)

# The index of each pair in a row.
(
    GOAL_FORCE,
    OBSTACLE_FORCE,
    SOCIAL_FORCE,
    GAZE_FORCE,
    COHERENCE_FORCE,
    GROUP_REPULSION_FORCE,
    ROBOT_REPULSION_FORCE,
    TOTAL_FORCE,
) = range(0, FORCES_SIZE, 2)


TOUCH_SIZE = 2
"""A row of `robot_touches` is (depth, speed), in meters and m/s: the depth of a
robot and a person in each other at the end of the step that begins now if they
were not kept apart, and the speed at which the person approaches."""


@explain
class Contact(IntEnum):
    """The elements of a row of `contacts`: the robot and one person.

    A contact begins when they touch, or would if they were not kept apart, and
    ends once they have not, and were `CONTACT_GAP` apart, for `CONTACT_PAUSE`.
    All but the first three elements keep their values until the next contact.
    """

    LASTS = 0
    """1 while a contact lasts, else 0."""

    FORCE_X = 1
    """Present force on the robot along x of W, in newtons: the mean over the
    last step of the system that computes it; 0 where forces are not
    computed."""

    FORCE_Y = 2
    """Present force on the robot along y of W, in newtons; as above."""

    PEAK_FORCE = 3
    """Largest horizontal force in this contact, or in the last one, in newtons;
    in the records of an evaluator, the largest in any contact that has lasted
    since the recording began."""

    IMPULSE = 4
    """Magnitude of the force, integrated from the start of the trial, in N s.
    """

    RELATIVE_SPEED = 5
    """Closing speed of the two at the begin of this contact, or of the last
    one, in m/s."""

    BY_ROBOT = 6
    """Number of contacts that the robot began by running into the person."""

    BY_PERSON = 7
    """Number of contacts that the person began by running into the robot."""


CONTACT_SIZE = len(Contact)

REPLAY_SIZE = 3
"""A row of `replay` of a person is (mode, distance at equal time, distance at
equal phase): the mode is 0 for a person who is not recorded or not here,
`REPLAYED` for one who follows its recording, and `REACTIVE` for one who walks
by the motion model; the distances are those from the recording now, and from
its nearest place, in meters, -1 where there is none."""

REPLAYED, REACTIVE = 1.0, 2.0

CONTACT_PAUSE = 0.25
"""The time apart after which a contact is over, in seconds."""

CONTACT_GAP = 0.02
"""The least gap to be apart, from robot's disc to person's body, in meters."""
