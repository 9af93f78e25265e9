"""What people notice of robots."""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves import IGNORED
from hunav_drake.systems.behavior.person import Moment
from hunav_drake.systems.behavior.registry import register_condition
from hunav_drake.systems.layout import VX, VY, YAW, X, Y
from hunav_drake.systems.schema import within

# People see a little more than what lies before them, in radians.
FIELD_OF_VIEW = 2 * (math.pi / 2 + 0.17)

# A robot slower than this is not coming, in m/s.
SLOW = 0.05

# How nearly opposite two headings are that meet head-on: within 60 degrees.
_OPPOSITE = -math.cos(math.pi / 3)

Distance = Annotated[float, within(0, 1e5, "m")]


def _sees_a_robot(
    moment: Moment, distance: float, field_of_view: float, occlusion: bool
) -> bool:
    state = moment.state
    for robot in moment.robots:
        dx, dy = robot[X] - state[X], robot[Y] - state[Y]
        if math.hypot(dx, dy) > distance:
            continue
        bearing = math.atan2(dy, dx) - state[YAW]
        if abs(math.remainder(bearing, 2 * math.pi)) > field_of_view / 2:
            continue
        if not occlusion or moment.clear_part(robot[X], robot[Y]) > 1:
            return True
    return False


@register_condition(
    "IsRobotVisible", memory={"ticks left": 0.0}, ignored=IGNORED
)
def is_robot_visible(
    moment: Moment,
    own: list[float],
    *,
    distance: Distance,
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
    occlusion: bool = True,
    memory: Annotated[float, within(0, 1e9, "s")] = 0.0,
) -> bool:
    """Holds if a robot's center is near, in view, and not behind a wall.

    Walls do not matter without `occlusion`. A person who loses sight of the
    robot keeps it in mind for the time of `memory`.
    """
    if _sees_a_robot(moment, distance, field_of_view, occlusion):
        own[0] = float(round(memory / moment.person.time_step))
        return True
    if own[0] == 0:
        return False
    own[0] -= 1
    return True


@register_condition("IsRobotApproaching", ignored=IGNORED)
def is_robot_approaching(
    moment: Moment,
    *,
    distance: Distance,
    width: Distance = 1.0,
    head_on: bool = False,
    occlusion: bool = True,
) -> bool:
    """Holds if a robot in motion is about to pass near the person.

    The person is ahead of it, at most `distance` along its course and `width`
    beside it. With `head_on`, the person faces it, too.
    """
    state = moment.state
    for robot in moment.robots:
        speed = math.hypot(robot[VX], robot[VY])
        if speed < SLOW:
            continue
        hx, hy = robot[VX] / speed, robot[VY] / speed
        rx, ry = state[X] - robot[X], state[Y] - robot[Y]
        if not 0 < rx * hx + ry * hy <= distance:
            continue
        if abs(hx * ry - hy * rx) > width:
            continue
        facing = hx * math.cos(state[YAW]) + hy * math.sin(state[YAW])
        if head_on and facing > _OPPOSITE:
            continue
        if not occlusion or moment.clear_part(robot[X], robot[Y]) > 1:
            return True
    return False
