"""DWB's rollouts and critics, which score velocities, by numba.

Poses are (x, y, yaw) in W; v is a speed in m/s and w a turn rate in rad/s.
`p` are `Parameters`.
"""

from enum import IntEnum
import math
from typing import NamedTuple

import numba
import numpy as np

from hunav_drake.systems.common.kernels import REAL, VECTOR, jit, jit_as, reads
from hunav_drake.systems.planning.costmap.footprint import outline_cost


class Critic(IntEnum):
    """The columns of scores after the total, in the order of `CriticScales`."""

    ROTATE_TO_GOAL = 1
    OSCILLATION = 2
    BASE_OBSTACLE = 3
    OBSTACLE_FOOTPRINT = 4
    GOAL_ALIGN = 5
    PATH_ALIGN = 6
    PATH_DIST = 7
    GOAL_DIST = 8
    PREFER_FORWARD = 9
    TWIRLING = 10


class Parameters(NamedTuple):
    """The bounds of samples and the parameters of scores; all are floats.

    Speeds are in [low, high], in m/s, turn rates up to `turn`, in rad/s:
    `speeds` and `turns` samples, reached within `reach_time`, in seconds.
    `at_once` is 1 if a sample is held from the start on, else 0. The others are
    those of `DwbPlanner`, its critics and their weights; `time_granularity` is
    0 if it is None, and `sum_scores` 1 or 0.
    """

    low: float
    high: float
    turn: float
    reach_time: float
    speeds: float
    turns: float
    at_once: float
    sim_time: float
    linear_granularity: float
    angular_granularity: float
    time_granularity: float
    acc_lim_x: float
    decel_lim_x: float
    acc_lim_theta: float
    decel_lim_theta: float
    min_speed_xy: float
    min_speed_theta: float
    forward_point_distance: float
    slowing_factor: float
    lookahead_time: float
    sum_scores: float
    penalty: float
    strafe_x: float
    strafe_theta: float
    theta_scale: float
    rotate_to_goal: float
    oscillation: float
    base_obstacle: float
    obstacle_footprint: float
    goal_align: float
    path_align: float
    path_dist: float
    goal_dist: float
    prefer_forward: float
    twirling: float


parameters_in = reads(Parameters)


class Targets(NamedTuple):
    """The cells of GoalDist and (`ahead_`) GoalAlign, and the goal's yaw."""

    row: float
    column: float
    ahead_row: float
    ahead_column: float
    yaw: float


class Latches(NamedTuple):
    """The modes of critics that depend on their memory.

    `rotating` is that of RotateToGoal: 0 off, 1 slow down, 2 turn. Oscillation
    allows the signs `v_sign` and `w_sign`; 0 for both.
    """

    rotating: int
    v_sign: float
    w_sign: float
    path_align: bool


# Turns below this, in radians, use series, exact but for the last bit.
_SMALL = 0.05


@jit
def toward(now, rise, fall, dt, target):
    """Returns a velocity moved towards a target; `fall` is negative."""
    if now < target:
        return min(target, now + rise * dt)
    return max(target, now + fall * dt)


@jit
def steps_of(v, w, p):
    """Returns the number of steps of a rollout."""
    if p.time_granularity > 0:
        return max(1, math.ceil(p.sim_time / p.time_granularity))
    far = abs(v) * p.sim_time / p.linear_granularity
    turned = abs(w) * p.sim_time / p.angular_granularity
    return max(1, math.ceil(max(far, turned)))


@jit
def _turned(c, s, angle):
    """Returns the cosine and sine of a heading turned by an angle."""
    if abs(angle) < _SMALL:
        a2 = angle * angle
        ca = 1 - a2 * (0.5 - a2 * (1 / 24 - a2 * (1 / 720 - a2 / 40320)))
        sa = angle * (
            1 - a2 * (1 / 6 - a2 * (1 / 120 - a2 * (1 / 5040 - a2 / 362880)))
        )
    else:
        ca = math.cos(angle)
        sa = math.sin(angle)
    return c * ca - s * sa, s * ca + c * sa


@jit_as(numba.float64[:, ::1], VECTOR, REAL, REAL, VECTOR)
def roll_out(state, v, w, parameters):
    """Returns the predicted poses of a sample, shape (n, 3), with the start.

    `state` is (x, y, yaw, v, w) of the robot. The velocity changes towards the
    sample, each step moves along the old heading, and the last pose is repeated
    (`StandardTrajectoryGenerator`, with `include_last_point`).
    """
    p = parameters_in(parameters)
    count = steps_of(v, w, p)
    dt = p.sim_time / count
    x, y, yaw, now_v, now_w = state[0], state[1], state[2], state[3], state[4]
    poses = np.empty((count + 2, 3))
    for k in range(count + 1):
        poses[k, 0] = x
        poses[k, 1] = y
        poses[k, 2] = yaw
        if p.at_once != 0:
            now_v = v
            now_w = w
        else:
            now_v = toward(now_v, p.acc_lim_x, p.decel_lim_x, dt, v)
            now_w = toward(now_w, p.acc_lim_theta, p.decel_lim_theta, dt, w)
        x += now_v * math.cos(yaw) * dt
        y += now_v * math.sin(yaw) * dt
        yaw += now_w * dt
    poses[count + 1] = poses[count]
    return poses


@jit
def _yaw_error(yaw, goal):
    return abs((yaw - goal + math.pi) % (2 * math.pi) - math.pi)


@jit
def _rotate_score(v, w, yaw, goal_yaw, speed, mode, p):
    """Returns the score of RotateToGoal; infinite if it is illegal."""
    if mode == 0:
        return 0.0
    if mode == 1:
        if v * v >= speed * speed:
            return math.inf
        return v * v * p.slowing_factor + _yaw_error(yaw, goal_yaw)
    if v != 0:
        return math.inf
    return _yaw_error(yaw, goal_yaw)


@jit
def _forward_score(v, w, p):
    """Returns the score of PreferForward."""
    if v < 0:
        return p.penalty
    if v < p.strafe_x and abs(w) < p.strafe_theta:
        return p.penalty
    return abs(w) * p.theta_scale


@jit
def score_samples(
    state,
    vs,
    ws,
    costs,
    ox,
    oy,
    resolution,
    distances,
    targets,
    latches,
    polygon,
    p,
    scores,
):
    """Scores all pairs of samples and returns the row of the best.

    The best has the lowest total; of equal ones, the first counts; -1 if all
    are rejected. Critics with weight 0 are not evaluated.

    `state` is (x, y, yaw, v, w) of the robot, `vs` and `ws` are the samples of
    speed and turn rate, ascending. `costs`, (ox, oy) and `resolution` are those
    of the map, `distances` are `path_distances`, and `polygon` is the
    footprint, shape (k, 2).

    `scores`, shape (len(vs) * len(ws), 11), gets the total and the weighted
    scores of the critics, in rows by ascending v, then w. Where a critic
    rejects a pair, the total and the critic's score are infinite; an excluded
    pair has a row of infinities.
    """
    rows, columns = costs.shape
    inverse = 1.0 / resolution
    grid_scale = 0.5 * resolution
    on_grid = p.path_dist != 0 or p.goal_dist != 0
    mode = latches.rotating
    start_c = math.cos(state[2])
    start_s = math.sin(state[2])
    best = -1
    least = math.inf
    row_of = -1
    for a in range(len(vs)):
        v = vs[a]
        for b in range(len(ws)):
            w = ws[b]
            row_of += 1
            out = scores[row_of]
            if (
                v * v > p.high * p.high + 1e-5
                or (abs(v) < p.min_speed_xy and abs(w) < p.min_speed_theta)
                or (v == 0 and w == 0)
            ):
                out[:] = math.inf
                continue
            out[:] = 0.0
            if p.oscillation != 0 and (
                v * latches.v_sign < 0 or w * latches.w_sign < 0
            ):
                out[0] = math.inf
                out[Critic.OSCILLATION] = math.inf
                continue
            count = steps_of(v, w, p)
            dt = p.sim_time / count
            x = state[0]
            y = state[1]
            yaw = state[2]
            c = start_c
            s = start_s
            now_v = state[3]
            now_w = state[4]
            # The same as `roll_out`, but the turns are computed by a
            # recurrence.
            step_c = 1.0
            step_s = 0.0
            steady = False
            if p.at_once != 0:
                now_v = v
                now_w = w
                steady = True
                step_c, step_s = _turned(1.0, 0.0, w * dt)
            legal = 0
            base = 0.0
            outline = 0.0
            ahead_yaw = yaw
            row = 0
            column = 0
            for k in range(count + 1):
                row = math.floor((y - oy) * inverse)
                column = math.floor((x - ox) * inverse)
                inside = 0 <= row < rows and 0 <= column < columns
                if p.base_obstacle != 0:
                    if not inside or costs[row, column] >= 253:
                        legal = Critic.BASE_OBSTACLE
                        break
                    cost = float(costs[row, column])
                    base = base + cost if p.sum_scores != 0 else cost
                elif not inside and on_grid:
                    legal = Critic.PATH_DIST
                    break
                if p.obstacle_footprint != 0:
                    edge = outline_cost(
                        costs, ox, oy, resolution, x, y, yaw, polygon
                    )
                    if edge < 0 or edge >= 254:
                        legal = Critic.OBSTACLE_FOOTPRINT
                        break
                    if p.sum_scores != 0:
                        outline += edge
                    else:
                        outline = float(edge)
                if k * dt <= p.lookahead_time:
                    ahead_yaw = yaw
                if k == count:
                    break
                if not steady:
                    now_v = toward(now_v, p.acc_lim_x, p.decel_lim_x, dt, v)
                    now_w = toward(
                        now_w, p.acc_lim_theta, p.decel_lim_theta, dt, w
                    )
                x += now_v * c * dt
                y += now_v * s * dt
                yaw += now_w * dt
                if steady:
                    turned = c * step_c - s * step_s
                    s = s * step_c + c * step_s
                    c = turned
                else:
                    c, s = _turned(c, s, now_w * dt)
                    if now_v == v and now_w == w:
                        steady = True
                        step_c, step_s = _turned(1.0, 0.0, w * dt)
            if legal != 0:
                out[0] = math.inf
                out[legal] = math.inf
                continue
            if p.sum_scores != 0 and p.base_obstacle != 0:
                # The last pose counts twice.
                base += costs[row, column]
            if p.sum_scores != 0 and p.obstacle_footprint != 0:
                outline += outline_cost(
                    costs, ox, oy, resolution, x, y, yaw, polygon
                )
            if p.rotate_to_goal != 0:
                last_yaw = ahead_yaw if p.lookahead_time >= 0 else yaw
                out[Critic.ROTATE_TO_GOAL] = p.rotate_to_goal * _rotate_score(
                    v, w, last_yaw, targets.yaw, state[3], mode, p
                )
            out[Critic.BASE_OBSTACLE] = p.base_obstacle * base
            out[Critic.OBSTACLE_FOOTPRINT] = p.obstacle_footprint * outline
            if p.goal_align != 0 or (p.path_align != 0 and latches.path_align):
                fx = x + p.forward_point_distance * c
                fy = y + p.forward_point_distance * s
                i = math.floor((fy - oy) * inverse)
                j = math.floor((fx - ox) * inverse)
                away = abs(i - targets.ahead_row) + abs(
                    j - targets.ahead_column
                )
                out[Critic.GOAL_ALIGN] = p.goal_align * grid_scale * away
                if latches.path_align:
                    # Manhattan distances continue beyond the map.
                    edge_i = min(max(i, 0), rows - 1)
                    edge_j = min(max(j, 0), columns - 1)
                    near = distances[edge_i, edge_j]
                    beyond = abs(i - edge_i) + abs(j - edge_j)
                    out[Critic.PATH_ALIGN] = (
                        p.path_align * grid_scale * (near + beyond)
                    )
            if p.path_dist != 0:
                near = distances[row, column]
                out[Critic.PATH_DIST] = p.path_dist * grid_scale * near
            if p.goal_dist != 0:
                away = abs(row - targets.row) + abs(column - targets.column)
                out[Critic.GOAL_DIST] = p.goal_dist * grid_scale * away
            if p.prefer_forward != 0:
                forward = _forward_score(v, w, p)
                out[Critic.PREFER_FORWARD] = p.prefer_forward * forward
            out[Critic.TWIRLING] = p.twirling * abs(w)
            total = 0.0
            for k in range(1, len(out)):
                total += out[k]
            out[0] = total
            if total < least:
                least = total
                best = row_of
    return best
