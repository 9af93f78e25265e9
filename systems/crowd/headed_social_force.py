"""The headed social force model: people walk mainly along their heading.

Farina, Fontanelli, Garulli, Giannitrapani & Prattichizzo 2017, "Walking ahead:
the headed social force model".
"""

import math
from typing import Annotated, ClassVar

from numba import float64
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.common.layout import (
    GOAL_FORCE,
    OMEGA,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
)
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.crowd.motion_model import (
    Array,
    MotionModel,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.social_force import kernel
from hunav_drake.systems.crowd.social_force.compiled_forces import wrap
from hunav_drake.systems.crowd.social_force.model import SocialForceModel
from hunav_drake.systems.people.parameters import K_GOAL, TAU

# The model of the forces. (The model here does not derive from it: people move
# in another way, with other derivatives.)
_SOCIAL_FORCE = SocialForceModel()

# A turn within this of a half turn goes to the right, in radians.
_TIE = 1e-9


@jit
def _decay(rate, time):
    """Returns the integral of exp(-rate t) from 0 to `time`."""
    if rate * time < 1e-12:
        return time
    return -math.expm1(-rate * time) / rate


@jit
def _turn(error, omega, stiffness, damping, time):
    """Solves e'' = -stiffness e - damping e' with two real rates of decay.

    At first e' is omega. The square of the damping is at least 4 times the
    stiffness. Returns the change of e, and the final e'.
    """
    root = math.sqrt(max(damping * damping - 4 * stiffness, 0.0))
    fast = (damping + root) / 2
    slow = stiffness / fast if fast > 0 else 0.0
    # e = error exp(-slow t) + (omega + slow error) (exp(-slow t) -
    # exp(-fast t)) / (fast - slow)
    left = math.exp(-slow * time)
    shared = left * _decay(fast - slow, time)
    along = omega + slow * error
    change = -slow * error * _decay(slow, time) + along * shared
    rate = along * math.exp(-fast * time) - slow * (error + change)
    return change, rate


@jit
def _without_braking(fx, fy, x, y, command):
    """Returns the part of a force that turns a person at (x, y).

    It is zero without a goal. Of a force that points back from the goal, only
    the part across counts: people who slow down do not turn around.
    """
    gx = command[Command.GOAL_X] - x
    gy = command[Command.GOAL_Y] - y
    distance = math.sqrt(gx * gx + gy * gy)
    if (
        command[Command.HAS_GOAL] == 0
        or distance <= command[Command.GOAL_RADIUS]
    ):
        return 0.0, 0.0
    ex = gx / distance
    ey = gy / distance
    back = min(fx * ex + fy * ey, 0.0)
    return fx - back * ex, fy - back * ey


@jit_as(
    float64[:, ::1],
    *(MATRIX, MATRIX, MATRIX, MATRIX, REAL),
    *(REAL, REAL, REAL, REAL, REAL, REAL, REAL),
)
def headed_advance(
    states,
    forces,
    command,
    parameters,
    time_step,
    mass,
    k_orthogonal,
    k_damping,
    k_lambda,
    alpha,
    heading_share,
    stepping_speed,
):
    """Returns the states of n people one step later.

    In a step, the forces are constant, and the equations of the heading and of
    the sideways velocity are linear; they are solved exactly, so that no step
    is too long for them. The rest is semi-implicit Euler.

    The arguments, up to the time step in seconds, and the result are those of
    `kernel.advance`, with `parameters` of shape (n, 13), the fields of
    SocialForceParameters; the others are fields of HeadedSocialForceModel.
    """
    result = kernel.advance(states, forces, command, time_step)
    for i in range(len(states)):
        if command[i, Command.HOLD] != 0 or command[i, Command.TURN_RATE] > 0:
            continue
        yaw = states[i, YAW]
        c = math.cos(yaw)
        s = math.sin(yaw)
        goal_x = forces[i, GOAL_FORCE]
        goal_y = forces[i, GOAL_FORCE + 1]
        other_x = forces[i, TOTAL_FORCE] - goal_x
        other_y = forces[i, TOTAL_FORCE + 1] - goal_y

        forward = c * states[i, VX] + s * states[i, VY]
        forward += (
            c * forces[i, TOTAL_FORCE] + s * forces[i, TOTAL_FORCE + 1]
        ) * time_step
        side = c * states[i, VY] - s * states[i, VX]
        rate = k_damping / mass
        push = k_orthogonal * (c * other_y - s * other_x)
        side = side * math.exp(-rate * time_step)
        side += push * _decay(rate, time_step)

        pull_x, pull_y = _without_braking(
            goal_x + heading_share * other_x,
            goal_y + heading_share * other_y,
            *(states[i, X], states[i, Y], command[i]),
        )
        pull = math.sqrt(pull_x * pull_x + pull_y * pull_y)
        error = 0.0
        if pull > 0:
            error = wrap(yaw - math.atan2(pull_y, pull_x))
            if error < _TIE - math.pi:
                error += 2 * math.pi
        tau = parameters[i, TAU]
        speed = math.hypot(states[i, VX], states[i, VY])
        damped = max(pull, parameters[i, K_GOAL] / tau * speed)
        damping = (1 + alpha) * math.sqrt(k_lambda * mass * damped / alpha)
        damping = max(damping, 1 / tau)
        stiffness = k_lambda * mass * pull
        change, omega = _turn(
            error, states[i, OMEGA], stiffness, damping, time_step
        )

        speed = math.sqrt(forward * forward + side * side)
        cap = command[i, Command.MAX_SPEED]
        if speed > cap:
            forward = forward / speed * cap
            side = side / speed * cap
        yaw = wrap(yaw + change)
        c = math.cos(yaw)
        s = math.sin(yaw)
        vx = c * forward - s * side
        vy = s * forward + c * side
        speed = math.hypot(states[i, VX], states[i, VY])
        if speed < stepping_speed:
            # (The result so far is that of the social force model.)
            part = (speed / stepping_speed) ** 2
            vx = part * vx + (1 - part) * result[i, VX]
            vy = part * vy + (1 - part) * result[i, VY]
        result[i, X] = states[i, X] + vx * time_step
        result[i, Y] = states[i, Y] + vy * time_step
        result[i, YAW] = yaw
        result[i, VX] = vx
        result[i, VY] = vy
        result[i, OMEGA] = omega
    return result


@register_motion_model("headed_social_force")
@dataclass(kw_only=True, config=CONFIG)
class HeadedSocialForceModel(MotionModel):
    """The forces of the social force model, on bodies that have a front.

    With f0 the force of the goal and fe the sum of the others, u and w the
    velocities ahead and to the left, and theta the heading, the paper has

        m u' = (f0 + fe) . ahead
        m w' = k_o fe . left - k_d w
        I theta'' = -k_theta (theta - angle of f0) - k_omega theta'
        k_theta = I k_lambda |f0|
        k_omega = I (1 + alpha) sqrt(k_lambda |f0| / alpha)

    with forces in N. Here they are accelerations a = f / m. Divided by m and by
    I, the equations keep k_d / m, k_lambda m |a0| and
    (1 + alpha) sqrt(k_lambda m |a0| / alpha): the inertia drops out. The mass,
    which stays, is the same for all people.

    The model differs from the paper in the turning of the heading, and at low
    speed:

    - the heading turns by f0 + heading_share fe: the forces between people
      here are softer than the paper's, which keep bodies apart by contact.
      With f0 alone, the heading turns against them, and people who meet walk
      into each other;
    - only the part of that force without braking turns it: people who slow
      down do not turn around, and without a goal the heading is free;
    - its damping is at least that of |a0| = goal_factor |v| / relaxation_time,
      and at least 1 / relaxation_time: the paper's vanishes with f0, so that
      the heading of a person at the desired speed would swing;
    - slow people step sideways and back, as in a crowd: below the speed s the
      velocity is the paper's only by the share (|v| / s)^2, and for the rest
      that of the social force model.

    People whose body the command turns, and those who hold still, move as in
    the social force model.
    """

    mass: Annotated[StrictFloat, within(1, 1000, "kg")] = 75.0
    """Mass of a person (m), in kg; the paper draws it from 60 to 90."""

    k_orthogonal: Annotated[StrictFloat, within(0, 1e3)] = 1.0
    """Share of the forces of others that acts sideways (k_o)."""

    k_damping: Annotated[StrictFloat, within(0, 1e6, "kg/s")] = 500.0
    """Damping of the sideways velocity (k_d), in kg/s."""

    k_lambda: Annotated[StrictFloat, within(0, 1e3, "1/(kg m)")] = 0.3
    """Gain with which the heading follows the force of the goal, in
    1/(kg m)."""

    alpha: Annotated[StrictFloat, within(1e-3, 1e3)] = 3.0
    """Ratio of the two decay rates of the heading."""

    heading_share: Annotated[StrictFloat, within(0, 1)] = 1.0
    """Share of the forces of others in the force that turns the heading; 0 is
    the paper's."""

    stepping_speed: Annotated[StrictFloat, within(0, 10, "m/s")] = 1.0
    """Speed (s) below which people also step sideways and back, the more the
    slower they are, in m/s; 0 is the paper's."""

    time_gap: Annotated[StrictFloat, within(0, 10, "s")] = 0.8
    """Time gap that people keep to the person ahead, in seconds: see
    `SocialForceModel`."""

    speed_matching: Annotated[StrictFloat, within(0, 1)] = 0.35
    """Share of the speed of the person ahead that is added to the speed that
    the time gap allows: see `SocialForceModel`."""

    passing_speed: Annotated[StrictFloat, within(0, 10, "m/s")] = 0.3
    """Least speed that the time gap leaves people behind others who stand, in
    m/s: those who touch them walk around them: see
    `SocialForceModel`."""

    follows: ClassVar[bool] = True

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the social forces: see `MotionModel.forces`."""
        return _SOCIAL_FORCE.forces(snapshot)

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        states: Array = headed_advance(
            snapshot.states,
            forces,
            snapshot.command,
            snapshot.parameters,
            snapshot.time_step,
            self.mass,
            self.k_orthogonal,
            self.k_damping,
            self.k_lambda,
            self.alpha,
            self.heading_share,
            self.stepping_speed,
        )
        return states
