"""Optimal reciprocal collision avoidance: people choose velocities, not forces.

van den Berg, Guy, Lin & Manocha 2011, "Reciprocal n-body collision avoidance".
Nobody chooses a velocity at which two bodies would touch within a time horizon
if the other kept its velocity, and each of a pair does half of the avoiding.
"""

import math
from typing import Annotated, ClassVar

from numba import float64
import numpy as np
from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.kernels import (
    REAL,
    SNAPSHOT,
    VECTOR,
    jit,
    jit_as,
    reads,
)
from hunav_drake.systems.common.layout import (
    COHERENCE_FORCE,
    FORCES_SIZE,
    GAZE_FORCE,
    GROUP_REPULSION_FORCE,
    RADIUS,
    ROBOT_REPULSION_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    PositiveLength,
    within,
)
from hunav_drake.systems.crowd.advance import chosen_accelerations
from hunav_drake.systems.crowd.motion_model import (
    Array,
    MotionModel,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.orca.half_planes import best_velocity
from hunav_drake.systems.crowd.orca.neighbors import find_neighbors, make_cells
from hunav_drake.systems.crowd.orca.queues import (
    go_side_by_side,
    is_walking,
    share_in_queue,
)
from hunav_drake.systems.crowd.orca.rules import avoid_disc, avoid_walls
from hunav_drake.systems.crowd.social_force import kernel
from hunav_drake.systems.crowd.surroundings import goal_velocities
from hunav_drake.systems.world.walls import opened

Time = Annotated[StrictFloat, within(0, 1e3, "s", low_open=True)]


@jit
def _wanted(states, radii, command, parameters, robots, time_step, relaxation):
    """Returns the velocities that people would take if they were alone."""
    n = len(states)
    wanted, pulls = goal_velocities(
        states, radii, command, parameters, robots, time_step
    )
    part = -math.expm1(-time_step / relaxation)
    for i in range(n):
        for c in range(2):
            pull = (
                pulls[i, GAZE_FORCE + c]
                + pulls[i, COHERENCE_FORCE + c]
                + pulls[i, GROUP_REPULSION_FORCE + c]
                + pulls[i, ROBOT_REPULSION_FORCE + c]
            )
            v = states[i, VX + c]
            wanted[i, c] = v + part * (wanted[i, c] - v + relaxation * pull)
        speed = math.hypot(wanted[i, 0], wanted[i, 1])
        if speed > command[i, Command.MAX_SPEED]:
            wanted[i] *= command[i, Command.MAX_SPEED] / speed
    return wanted


@jit_as(float64[:, ::1], *SNAPSHOT, REAL, VECTOR)
def orca_accelerations(
    states,
    radii,
    command,
    parameters,
    robots,
    at_walls,
    table,
    sight,
    step,
    model,
):
    """Returns the accelerations to the velocities that n people choose.

    The arguments are those of `kernel.social_forces`, but walls count up to
    `sight` meters, `step` is the time step in seconds, and `model`, of shape
    (10,), has the fields of OrcaModel.

    Returns:
        Shape (n, FORCES_SIZE), in m/s^2: the total, and zeros.
    """
    p = _model_in(model)
    walls = opened(table)
    n = len(states)
    forces = np.zeros((n, FORCES_SIZE))
    if n == 0:
        return forces
    wanted = _wanted(
        states, radii, command, parameters, robots, step, p.relaxation_time
    )
    cells = make_cells(states[:, X].copy(), states[:, Y].copy())
    most = int(p.max_neighbors)
    far = p.neighbor_distance
    margin = p.safety_margin
    body = p.body_radius
    recovery = max(p.recovery_time, step)
    cosine = math.cos(p.epsilon)
    sine = math.sin(p.epsilon)
    nearest = np.empty(most)
    found = np.empty(n, np.int64)
    shares = np.empty(n)
    rules = np.empty((len(walls.segments) + n + len(robots), 3))
    scratch = np.empty(rules.shape)
    walks = np.empty(n, np.bool_)
    for i in range(n):
        walks[i] = is_walking(states[i], command[i])
    for i in range(n):
        x = states[i, X]
        y = states[i, Y]
        own = states[i, VX : VY + 1]
        cap = command[i, Command.MAX_SPEED]
        if command[i, Command.HOLD] != 0:
            forces[i, TOTAL_FORCE] = -own[0] / step
            forces[i, TOTAL_FORCE + 1] = -own[1] / step
            continue
        neighbors = find_neighbors(i, x, y, cells, far, most, nearest, found)
        felt = at_walls[i, 0]
        for a in range(neighbors):
            j = found[a]
            shares[a] = -1.0
            if walks[i] and walks[j]:
                both = (states[i], command[i], states[j], command[j])
                shares[a] = share_in_queue(*both, p.queue_distance)
                if shares[a] >= 0:
                    felt = min(felt, body)
        hard = avoid_walls(
            *(rules, x, y, felt + margin, cap, walls),
            *(sight, p.wall_horizon, step),
        )
        count = hard
        for a in range(neighbors + len(robots)):
            share = 0.5
            apart_in = step
            if a < neighbors:
                j = found[a]
                other = states[j]
                reach = radii[i] + radii[j] + margin
                vx = other[VX]
                vy = other[VY]
                if shares[a] >= 0:
                    share = shares[a]
                    reach = min(radii[i], body) + min(radii[j], body)
                elif (
                    walks[i]
                    and walks[j]
                    and go_side_by_side(
                        states[i], command[i], other, command[j]
                    )
                ):
                    apart_in = recovery
                if command[j, Command.HOLD] != 0:
                    # A person who holds still leaves it all to the others.
                    share = 1.0
                    vx = 0.0
                    vy = 0.0
            else:
                other = robots[a - neighbors]
                reach = radii[i] + other[RADIUS] + margin
                vx = other[VX]
                vy = other[VY]
                role = int(command[i, Command.ROBOT_ROLE])
                if role == RobotRole.OBSTACLE:
                    share = 1.0
                elif role != RobotRole.PEDESTRIAN:
                    continue
            dx = other[X] - x
            dy = other[Y] - y
            if dx * dx + dy * dy > far * far:
                continue
            # Seen a little to the left, so that people pass on the right.
            ex = cosine * dx - sine * dy
            ey = sine * dx + cosine * dy
            count += avoid_disc(
                *(rules[count], ex, ey, own, own[0] - vx, own[1] - vy),
                *(reach, share, p.time_horizon, apart_in),
            )
        vx, vy = best_velocity(
            *(rules, hard, count, cap, wanted[i, 0], wanted[i, 1]), scratch
        )
        forces[i, TOTAL_FORCE] = (vx - own[0]) / step
        forces[i, TOTAL_FORCE + 1] = (vy - own[1]) / step
    return forces


@register_motion_model("orca")
@dataclass(kw_only=True, config=CONFIG)
class OrcaModel(MotionModel):
    """People choose the best velocity that keeps clear of the others.

    van den Berg, Guy, Lin & Manocha 2011. A velocity must keep a person clear
    of walls for `wall_horizon`, and of the nearest people and robots for
    `time_horizon`; the one nearest to the desired velocity is taken. If there
    is none, the rules of people are relaxed before those of walls: see
    `half_planes`.

    A robot in the role of a pedestrian is expected to do its half of the
    avoiding. One in the role of an obstacle, and people who hold still, are
    not: the others do all.

    People approach the desired velocity with `relaxation_time`, under the
    forces of the group and of the robot's push, which are those of the social
    force model.

    People who go to the same place, or through the same door, queue, which is
    not in the paper: they keep only their bodies apart, and from walls, and the
    nearer person goes first (as in Curtis, Zafar, Gutub & Manocha 2013, "Right
    of way"). All others share the avoiding by halves. Without it
    (`queue_distance` 0) crowds arch in front of doors of 1 m. Even so, few
    people of 0.35 m pass doors of 0.8 m.

    All walls within `obstacle_range` count: `max_obstacles` has no effect. A
    wall does not move people on its very point, nor does a person at the same
    position and velocity.
    """

    uses_weights = "none"

    keeps_radii: ClassVar[bool] = True

    neighbor_distance: PositiveLength = 10.0
    """Distance beyond which people and robots are not avoided, in meters."""

    max_neighbors: Annotated[Integer, Field(ge=1, le=1000)] = 10
    """Largest number of people to avoid, nearest first; more if equally far."""

    time_horizon: Time = 3.0
    """Time horizon in which people must not touch others (tau), in seconds."""

    wall_horizon: Time = 1.0
    """Time horizon in which people must not touch a wall, in seconds."""

    safety_margin: Annotated[StrictFloat, within(0, 10, "m")] = 0.05
    """Clearance of bodies from other bodies and from walls, in meters."""

    relaxation_time: Time = 0.25
    """Time constant with which the desired velocity is approached, in seconds.
    A short one gives the paper's model, where people start and stop at once."""

    epsilon: Annotated[StrictFloat, within(-1, 1, "rad")] = 0.05
    """Angle by which people see others displaced to the left, in radians. It
    breaks the tie of an exact head-on encounter, where both would brake to a
    stop: to the right; if negative, to the left."""

    body_radius: PositiveLength = 0.25
    """Largest radius of people in a queue with respect to each other, and to
    walls, in meters: the rest of a larger radius is comfort distance."""

    recovery_time: Annotated[StrictFloat, within(0, 1e3, "s")] = 0.25
    """Time in which people separate who walk the same way nearer to each other
    than they like, as out of a door, in seconds; at least a time step, which is
    the paper's, and that of all others."""

    queue_distance: Annotated[StrictFloat, within(0, 100, "m")] = 1.2
    """Distance between the next waypoints, or goals, of two people, or from one
    to the other's way, below which they queue, in meters; 0 is the paper's
    form."""

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the accelerations, as totals: see `MotionModel.forces`."""
        return chosen_accelerations(orca_accelerations, snapshot, self)

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        states: Array = kernel.advance(
            snapshot.states, forces, snapshot.command, snapshot.time_step
        )
        return states


_model_in = reads(OrcaModel)
