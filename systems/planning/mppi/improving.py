"""One improvement of MPPI's controls: roll out, score, average, by numba."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import READ_CELLS
from hunav_drake.systems.planning.mppi import critics
from hunav_drake.systems.planning.mppi.parameters import (
    ALIGN_AHEAD,
    ALIGN_BLOCKED,
    ANGLE_LEAST,
    COLLISION_COST,
    CONSTRAINT,
    CONTROL,
    COST,
    FOLLOW_NEAR,
    GAMMA,
    GOAL,
    GOAL_ANGLE,
    GOAL_ANGLE_NEAR,
    GOAL_NEAR,
    HOLD,
    NUM_SCORES,
    PATH_ALIGN,
    PATH_ANGLE,
    PATH_FOLLOW,
    PATH_NEAR,
    PREFER_FORWARD,
    SOCIAL,
    STD_TURN,
    STD_V,
    TEMPERATURE,
)
from hunav_drake.systems.planning.mppi.rollouts import (
    command_of,
    held,
    limit,
    roll_out,
    smooth,
)

_CUBE = numba.types.Array(numba.float64, 3, "C", readonly=True)


@jit
def _switches(state, goal, path, free, reached, p):
    """Returns which critics have a say, shape (NUM_SCORES,)."""
    on = np.zeros(NUM_SCORES, dtype=np.bool_)
    for critic in range(1, CONTROL):
        on[critic] = p[critic] != 0
    to_goal = math.hypot(goal[0] - state[0], goal[1] - state[1])
    on[GOAL] &= to_goal < p[GOAL_NEAR]
    on[GOAL_ANGLE] &= to_goal < p[GOAL_ANGLE_NEAR]
    on[PATH_FOLLOW] &= to_goal >= p[FOLLOW_NEAR]
    for critic in (PATH_ALIGN, PATH_ANGLE, PREFER_FORWARD):
        on[critic] &= to_goal >= p[PATH_NEAR]
    blocked = 0
    for k in range(reached):
        blocked += not free[k]
    on[PATH_ALIGN] &= reached >= p[ALIGN_AHEAD]
    if blocked > 2 and blocked > p[ALIGN_BLOCKED] * reached:
        on[PATH_ALIGN] = False
    x, y = critics.angle_point(path, reached, p)
    bearing = math.atan2(y - state[1], x - state[0])
    turn = critics.angle_between(state[2], bearing)
    on[PATH_ANGLE] &= turn > p[ANGLE_LEAST]
    return on, to_goal


# (Its many arrays in three lines, not in nineteen.)
@jit
def _score(
    state, poses, velocities, goal, path, spacing, free, reached, on, to_goal,
    costs, ox, oy, resolution, polygon, humans, forces, p, out,
):  # fmt: skip
    """Writes the scaled scores of one rollout; whether it does not collide."""
    out[:] = 0.0
    if on[CONSTRAINT]:
        out[CONSTRAINT] = critics.constraint_score(velocities, p)
    collides = False
    if on[COST]:
        cost = critics.cost_score(
            poses, costs, ox, oy, resolution, polygon, to_goal, p
        )
        collides = cost == math.inf
        # As a part of the cost of something lethal.
        out[COST] = 0.0 if collides else cost / 254
    if on[GOAL]:
        out[GOAL] = critics.goal_score(poses, goal)
    if on[GOAL_ANGLE]:
        out[GOAL_ANGLE] = critics.goal_angle_score(poses, goal)
    if on[PATH_ALIGN]:
        out[PATH_ALIGN] = critics.path_align_score(
            state[0], state[1], poses, path, spacing, free, p
        )
    if on[PATH_FOLLOW]:
        out[PATH_FOLLOW] = critics.path_follow_score(
            poses, path, free, reached, p
        )
    if on[PATH_ANGLE]:
        x, y = critics.angle_point(path, reached, p)
        out[PATH_ANGLE] = critics.path_angle_score(poses, x, y)
    if on[PREFER_FORWARD]:
        out[PREFER_FORWARD] = critics.prefer_forward_score(velocities, p)
    if on[SOCIAL] and not collides:
        out[SOCIAL] = critics.social_score(poses, velocities, humans, forces, p)
    for critic in range(1, CONTROL):
        out[critic] *= p[critic]
    if collides:
        out[COST] = p[COLLISION_COST]
    return not collides


@jit
def average(sampled, totals, temperature):
    """Returns the mean of samples by how good they are.

    They weigh exp(-(total - least total) / temperature) (Williams et al. 2017,
    "Information theoretic MPC for model-based reinforcement learning", Alg. 2).

    Args:
        sampled: Shape (m, n, 2).
        totals: Shape (m,): the lower, the better.
        temperature: How much worse is worse by a factor of e.
    """
    least = totals.min()
    result = np.zeros(sampled.shape[1:])
    whole = 0.0
    for i in range(len(totals)):
        weight = math.exp(-(totals[i] - least) / temperature)
        # What is lighter is lost in rounding anyway.
        if weight > 1e-12:
            whole += weight
            for k in range(result.shape[0]):
                result[k, 0] += weight * sampled[i, k, 0]
                result[k, 1] += weight * sampled[i, k, 1]
    return result / whole


@jit_as(
    numba.types.Tuple(
        (
            *(numba.int64, numba.float64[:, ::1]),
            *(numba.float64[:, ::1], numba.float64[:, :, ::1]),
        )
    ),
    *(VECTOR, MATRIX, MATRIX, _CUBE, VECTOR, MATRIX, REAL),
    *(READ_CELLS, REAL, REAL, REAL, MATRIX, MATRIX, VECTOR, VECTOR),
)
def improve(
    state,
    controls,
    past,
    noise,
    goal,
    path,
    spacing,
    costs,
    ox,
    oy,
    resolution,
    polygon,
    humans,
    forces,
    p,
):
    """Samples controls around the last ones, and averages them.

    Args:
        state: (x, y, yaw, v, omega) of the robot.
        controls: Shape (n, 2), rows (v, omega): the last ones.
        past: Shape (4, 2): those before.
        noise: Shape (m, n, 2), standard normal: for m rollouts.
        goal: (x, y, yaw) of the end of the whole plan.
        path: Shape (k, 2), k > 0: the local plan, evenly spaced.
        spacing: The distance of its points, in meters.
        costs: Those of the local map.
        ox: The origin of the map.
        oy: The same along the other axis.
        resolution: The side of a cell.
        polygon: The outline of the robot, shape (j, 2).
        humans: Shape (i, 7): the rows of the people.
        forces: The parameters of the social force.
        p: The parameters.

    Returns:
        How many rollouts do not collide, the new controls, the scores, shape
        (m, 11) (the total, the scaled ones of the critics, and how far the
        controls are from the last ones), and the poses, shape (m, n, 3).
    """
    count = noise.shape[0]
    steps = noise.shape[1]
    sampled = np.empty((count, steps, 2))
    poses = np.empty((count, steps, 3))
    velocities = np.empty((count, steps, 2))
    ends = np.empty((count, 2))
    scores = np.empty((count, NUM_SCORES))
    hold = int(p[HOLD])
    for i in range(count):
        for k in range(steps):
            # The first control is on its way to the robot already.
            scale = 0.0 if k == 0 and hold > 0 else 1.0
            draw = command_of(k, hold)
            sampled[i, k, 0] = (
                controls[k, 0] + scale * p[STD_V] * noise[i, draw, 0]
            )
            sampled[i, k, 1] = (
                controls[k, 1] + scale * p[STD_TURN] * noise[i, draw, 1]
            )
        roll_out(state, sampled[i], p, poses[i], velocities[i])
        ends[i] = poses[i, -1, :2]
    reached = critics.furthest_reached(ends, path)
    free = critics.free_points(path, costs, ox, oy, resolution)
    on, to_goal = _switches(state, goal, path, free, reached, p)
    alive = 0
    for i in range(count):
        out = scores[i]
        alive += _score(
            *(state, poses[i], velocities[i], goal, path, spacing, free),
            *(reached, on, to_goal, costs, ox, oy, resolution, polygon),
            *(humans, forces, p, out),
        )
        along_v = 0.0
        along_turn = 0.0
        for k in range(steps):
            along_v += controls[k, 0] * (sampled[i, k, 0] - controls[k, 0])
            along_turn += controls[k, 1] * (sampled[i, k, 1] - controls[k, 1])
        out[CONTROL] = p[GAMMA] * (
            along_v / p[STD_V] ** 2 + along_turn / p[STD_TURN] ** 2
        )
        for critic in range(1, NUM_SCORES):
            out[0] += out[critic]
    new = average(sampled, scores[:, 0], p[TEMPERATURE])
    limit(new, state, p)
    new = held(smooth(new, past), hold)
    return alive, new, scores, poses
