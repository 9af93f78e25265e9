"""A whole step by the rules of HuNavSim in one call of compiled code.

It does what `CrowdStep` does part by part, with the same bits, for people who
keep to no other rules: see `is_of_hunavsim`.
"""

import math
from typing import NamedTuple, TypeGuard

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    VECTOR,
    WALLS,
    jit_as,
    reads,
    unowned,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    MOTION_SIZE,
    STATE_SIZE,
    VX,
    VY,
    Command,
    Hold,
)
from hunav_drake.systems.crowd.bodies.contacts import robot_touches
from hunav_drake.systems.crowd.bodies.finish import for_each_robot
from hunav_drake.systems.crowd.bodies.standing import STANCE_SIZE
from hunav_drake.systems.crowd.bodies.whole_step import joined
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import is_within
from hunav_drake.systems.crowd.motion_model import MotionModel
from hunav_drake.systems.crowd.social_force.hunavsim import (
    advance,
    social_forces,
)
from hunav_drake.systems.crowd.social_force.model import SocialForceModel
from hunav_drake.systems.people.parameters import K_OBSTACLE, NUM_PARAMETERS


class Numbers(NamedTuple):
    """The constants of a trial, before the rows of people in their turn.

    Attributes:
        reach: Walls farther than this exert no force, in meters.
        most: The largest number of walls that exert forces; 0 for all.
        time_step: In seconds.
        measured: Whether people who stop have no velocity: 1 or 0.
    """

    reach: float
    most: float
    time_step: float
    measured: float


_numbers_in = reads(Numbers)


def is_of_hunavsim(
    model: MotionModel, config: CrowdConfig
) -> TypeGuard[SocialForceModel]:
    """Returns whether a crowd has the rules of HuNavSim, and no others."""
    return (
        type(model) is SocialForceModel
        and model.kernel == "hunavsim"
        and not (
            model.time_gap
            or model.robot_obstacle_radius
            or config.keep_out_of_walls
            or config.route_planning
            or config.keep_apart
            or config.robots_stop
            or config.groups_part
            or config.robot_gap
            or config.standing
            or config.max_acceleration is not None
            or config.max_turn_rate is not None
        )
    )


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, WALLS, VECTOR),
)
def hunavsim_step(
    states_of_all,
    commands,
    stances,
    robot_states,
    weights,
    eased,
    sizes,
    table,
    numbers,
):
    """Returns the result of a step of n people: see `whole_step`.

    The arguments are those there, with other `numbers`: `Numbers`, and the rows
    of people in their turn (n,); `eased` has no rows.
    """
    p = _numbers_in(numbers)
    n = len(sizes)
    states = unowned(states_of_all).reshape((n, MOTION_SIZE))
    command = unowned(commands).reshape((n, COMMAND_SIZE))
    parameters = unowned(weights).reshape((n, NUM_PARAMETERS))
    m = len(robot_states) // STATE_SIZE
    robots = unowned(robot_states).reshape((m, STATE_SIZE))
    nothing = np.empty(0)
    if not (is_within(states) and is_within(command) and is_within(robots)):
        return nothing
    before = np.empty((n, MOTION_SIZE))
    wanted = np.empty((n, COMMAND_SIZE))
    own = np.empty((n, NUM_PARAMETERS))
    radii = np.empty(n)
    felt = np.empty((n, 2))
    for k in range(n):
        i = int(numbers[len(numbers) - n + k])
        before[k] = states[i]
        wanted[k] = command[i]
        own[k] = parameters[i]
        radii[k] = sizes[i, 2]
        felt[k, 0] = sizes[i, 2]
        felt[k, 1] = parameters[i, K_OBSTACLE]
    forces = social_forces(
        *(before, radii, wanted, own, robots, felt, table),
        *(p.reach, int(p.most)),
    )
    moved = advance(
        *(before, radii, wanted, own, robots, felt, table),
        *(p.reach, int(p.most), forces, p.time_step),
    )
    after = np.empty((n, MOTION_SIZE))
    total = 0.0
    for k in range(n):
        i = int(numbers[len(numbers) - n + k])
        after[i] = moved[k]
        for c in range(forces.shape[1]):
            total += forces[k, c]
        if p.measured != 0 and int(command[i, Command.HOLD]) == Hold.STAY:
            after[i, VX] = 0.0
            after[i, VY] = 0.0
        for c in range(after.shape[1]):
            total += after[i, c]
    if not math.isfinite(total):
        return nothing
    touches = robot_touches(
        states,
        for_each_robot(after, m),
        sizes[:, 0].copy(),
        robots,
        p.time_step,
    )
    stance = np.empty((n, STANCE_SIZE))
    for i in range(n):
        for c in range(STANCE_SIZE):
            stance[i, c] = stances[STANCE_SIZE * i + c]
    return joined(after, stance, touches)
