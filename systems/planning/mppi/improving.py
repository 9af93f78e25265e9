"""One iteration of MPPI: roll out, score and average, by numba."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    jit,
    jit_as,
    reads,
)
from hunav_drake.systems.planning.costmap.raster import READ_CELLS
from hunav_drake.systems.planning.mppi import critics
from hunav_drake.systems.planning.mppi.parameters import (
    NUM_SCORES,
    Critic,
    Parameters,
)
from hunav_drake.systems.planning.mppi.rollouts import (
    command_of,
    held,
    limit,
    roll_out,
    smooth,
)

_CONTROL = int(Critic.CONTROL)

_parameters_in = reads(Parameters)

_CUBE = numba.types.Array(numba.float64, 3, "C", readonly=True)


@jit
def _switches(state, goal, path, free, reached, weights, p):
    """Returns which critics are on, by `Critic`, and the goal distance."""
    on = np.zeros(NUM_SCORES, dtype=np.bool_)
    for critic in range(1, _CONTROL):
        on[critic] = weights[critic] != 0
    to_goal = math.hypot(goal[0] - state[0], goal[1] - state[1])
    on[Critic.GOAL] &= to_goal < p.goal_threshold
    on[Critic.GOAL_ANGLE] &= to_goal < p.goal_angle_threshold
    on[Critic.PATH_FOLLOW] &= to_goal >= p.path_follow_threshold
    is_far = to_goal >= p.path_threshold
    on[Critic.PATH_ALIGN] &= is_far
    on[Critic.PATH_ANGLE] &= is_far
    on[Critic.PREFER_FORWARD] &= is_far
    blocked = 0
    for k in range(reached):
        blocked += not free[k]
    on[Critic.PATH_ALIGN] &= reached >= p.path_align_offset
    if blocked > 2 and blocked > p.max_path_occupancy_ratio * reached:
        on[Critic.PATH_ALIGN] = False
    x, y = critics.angle_point(path, reached, p)
    bearing = math.atan2(y - state[1], x - state[0])
    turn = critics.angle_between(state[2], bearing)
    on[Critic.PATH_ANGLE] &= turn > p.max_angle_to_furthest
    return on, to_goal


# (Three lines of arguments instead of twenty.)
@jit
def _score(
    state, poses, velocities, goal, path, spacing, free, reached, on, to_goal,
    costs, ox, oy, resolution, polygon, humans, forces, weights, p, out,
):  # fmt: skip
    """Writes the scores of a rollout; returns whether it is collision-free."""
    out[:] = 0.0
    if on[Critic.CONSTRAINT]:
        out[Critic.CONSTRAINT] = critics.constraint_score(velocities, p)
    collides = False
    if on[Critic.COST]:
        cost = critics.cost_score(
            poses, costs, ox, oy, resolution, polygon, to_goal, p
        )
        collides = cost == math.inf
        # As a fraction of the lethal cost.
        out[Critic.COST] = 0.0 if collides else cost / 254
    if on[Critic.GOAL]:
        out[Critic.GOAL] = critics.goal_score(poses, goal)
    if on[Critic.GOAL_ANGLE]:
        out[Critic.GOAL_ANGLE] = critics.goal_angle_score(poses, goal)
    if on[Critic.PATH_ALIGN]:
        out[Critic.PATH_ALIGN] = critics.path_align_score(
            state[0], state[1], poses, path, spacing, free, p
        )
    if on[Critic.PATH_FOLLOW]:
        out[Critic.PATH_FOLLOW] = critics.path_follow_score(
            poses, path, free, reached, p
        )
    if on[Critic.PATH_ANGLE]:
        x, y = critics.angle_point(path, reached, p)
        out[Critic.PATH_ANGLE] = critics.path_angle_score(poses, x, y)
    if on[Critic.PREFER_FORWARD]:
        out[Critic.PREFER_FORWARD] = critics.prefer_forward_score(velocities, p)
    if on[Critic.SOCIAL] and not collides:
        out[Critic.SOCIAL] = critics.social_score(
            poses, velocities, humans, forces, p
        )
    for critic in range(1, _CONTROL):
        out[critic] *= weights[critic]
    if collides:
        out[Critic.COST] = p.collision_cost
    return not collides


@jit
def average(sampled, totals, temperature):
    """Returns the mean of samples (m, n, 2), weighted by totals (m,).

    The weights are exp(-(total - least total) / temperature) (Williams et al.
    2017, "Information theoretic MPC for model-based reinforcement learning",
    Alg. 2).
    """
    least = totals[0]
    for i in range(1, len(totals)):
        least = min(least, totals[i])
    result = np.zeros(sampled.shape[1:])
    whole = 0.0
    for i in range(len(totals)):
        weight = math.exp(-(totals[i] - least) / temperature)
        # Smaller weights are lost in rounding.
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
    *(READ_CELLS, REAL, REAL, REAL, MATRIX, MATRIX, VECTOR),
    *(VECTOR, VECTOR),
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
    weights,
    parameters,
):
    """Samples controls around the last ones and averages them.

    `state` is (x, y, yaw, v, omega) of the robot; `controls` (n, 2) are the
    last ones and `past` (4, 2) those before them, rows (v, omega); `noise` (m,
    n, 2) is standard normal, for m rollouts. `goal` is the end (x, y, yaw) of
    the global plan; `path` (k, 2), k > 0, are points of the local plan,
    `spacing` apart, in meters. `costs`, (ox, oy) and `resolution` are those of
    the local costmap; `polygon` (j, 2) is the footprint; `humans` are the rows
    of the people; `forces` are the parameters of the social force, `weights`
    (11,) those of the critics, by `Critic`.

    Returns:
        The number of collision-free rollouts, the new controls, the scores,
        shape (m, 11) (the total, the weighted ones of the critics, and the
        deviation from the last controls), and the poses, shape (m, n, 3).
    """
    p = _parameters_in(parameters)
    count = noise.shape[0]
    steps = noise.shape[1]
    sampled = np.empty((count, steps, 2))
    poses = np.empty((count, steps, 3))
    velocities = np.empty((count, steps, 2))
    ends = np.empty((count, 2))
    scores = np.empty((count, NUM_SCORES))
    hold = int(p.hold)
    for i in range(count):
        for k in range(steps):
            # The first control has already been sent to the robot.
            scale = 0.0 if k == 0 and hold > 0 else 1.0
            draw = command_of(k, hold)
            sampled[i, k, 0] = (
                controls[k, 0] + scale * p.std_v * noise[i, draw, 0]
            )
            sampled[i, k, 1] = (
                controls[k, 1] + scale * p.std_turn * noise[i, draw, 1]
            )
        roll_out(state, sampled[i], p, poses[i], velocities[i])
        ends[i, 0], ends[i, 1] = poses[i, -1, 0], poses[i, -1, 1]
    reached = critics.furthest_reached(ends, path)
    free = critics.free_points(path, costs, ox, oy, resolution)
    on, to_goal = _switches(state, goal, path, free, reached, weights, p)
    alive = 0
    for i in range(count):
        out = scores[i]
        alive += _score(
            *(state, poses[i], velocities[i], goal, path, spacing, free),
            *(reached, on, to_goal, costs, ox, oy, resolution, polygon),
            *(humans, forces, weights, p, out),
        )
        along_v = 0.0
        along_turn = 0.0
        for k in range(steps):
            along_v += controls[k, 0] * (sampled[i, k, 0] - controls[k, 0])
            along_turn += controls[k, 1] * (sampled[i, k, 1] - controls[k, 1])
        out[Critic.CONTROL] = p.gamma * (
            along_v / p.std_v**2 + along_turn / p.std_turn**2
        )
        for critic in range(1, NUM_SCORES):
            out[0] += out[critic]
    new = average(sampled, scores[:, 0], p.temperature)
    limit(new, state, p)
    new = held(smooth(new, past), hold)
    return alive, new, scores, poses
