"""DWB's rollouts and critics, which score velocities, by numba.

Poses are (x, y, yaw) in W; v is a speed in m/s and w a turn rate in rad/s.
`p` are `Parameters`.
"""

from enum import IntEnum
import math
from typing import NamedTuple

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    REAL,
    VECTOR,
    jit,
    jit_as,
    reads,
    unowned,
)
from hunav_drake.systems.planning.costmap.footprint import outline_cost
from hunav_drake.systems.planning.dwb.map_grid import distance_from


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
def _rotation(angle):
    """Returns the cosine and sine of an angle."""
    if abs(angle) >= _SMALL:
        return math.cos(angle), math.sin(angle)
    a2 = angle * angle
    c = 1 - a2 * (0.5 - a2 * (1 / 24 - a2 * (1 / 720 - a2 / 40320)))
    s = angle * (
        1 - a2 * (1 / 6 - a2 * (1 / 120 - a2 * (1 / 5040 - a2 / 362880)))
    )
    return c, s


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
def _predict_headings(state, w, count, dt, p, headings):
    """Predicts the headings of a turn rate, rows (cosine, sine, yaw).

    The same as in `roll_out`, but the turns are computed by a recurrence.
    """
    yaw = state[2]
    c = math.cos(yaw)
    s = math.sin(yaw)
    now = state[4] if p.at_once == 0 else w
    turn = math.nan
    step_c = 1.0
    step_s = 0.0
    for k in range(count + 1):
        headings[k, 0] = c
        headings[k, 1] = s
        headings[k, 2] = yaw
        now = toward(now, p.acc_lim_theta, p.decel_lim_theta, dt, w)
        if now * dt != turn:
            turn = now * dt
            step_c, step_s = _rotation(turn)
        turned = c * step_c - s * step_s
        s = s * step_c + c * step_s
        c = turned
        yaw += turn


@jit
def _end_of(state, v, count, dt, headings, p):
    """Returns the position (x, y) at which a speed along headings ends."""
    x = state[0]
    y = state[1]
    now = state[3] if p.at_once == 0 else v
    k = 0
    while k < count and now != v:
        now = toward(now, p.acc_lim_x, p.decel_lim_x, dt, v)
        x += now * headings[k, 0] * dt
        y += now * headings[k, 1] * dt
        k += 1
    for rest in range(k, count):
        x += v * headings[rest, 0] * dt
        y += v * headings[rest, 1] * dt
    return x, y


@jit
def _is_excluded(v, w, p):
    """Returns whether a pair is not among the samples."""
    return (
        v * v > p.high * p.high + 1e-5
        or (abs(v) < p.min_speed_xy and abs(w) < p.min_speed_theta)
        or (v == 0 and w == 0)
    )


@jit
def _score_end(x, y, heading, v, w, grid, cells, targets, latches, p, out):
    """Writes the scores that depend on the end of a trajectory."""
    costs, ox, oy, resolution = grid
    inverse = 1.0 / resolution
    grid_scale = 0.5 * resolution
    if p.goal_align != 0 or (p.path_align != 0 and latches.path_align):
        fx = x + p.forward_point_distance * heading[0]
        fy = y + p.forward_point_distance * heading[1]
        i = math.floor((fy - oy) * inverse)
        j = math.floor((fx - ox) * inverse)
        away = abs(i - targets.ahead_row) + abs(j - targets.ahead_column)
        out[Critic.GOAL_ALIGN] = p.goal_align * grid_scale * away
        if latches.path_align:
            near = distance_from(cells, i, j)
            out[Critic.PATH_ALIGN] = p.path_align * grid_scale * near
    i = math.floor((y - oy) * inverse)
    j = math.floor((x - ox) * inverse)
    if 0 <= i < costs.shape[0] and 0 <= j < costs.shape[1]:
        out[Critic.BASE_OBSTACLE] = p.base_obstacle * float(costs[i, j])
    if p.path_dist != 0:
        near = distance_from(cells, i, j)
        out[Critic.PATH_DIST] = p.path_dist * grid_scale * near
    if p.goal_dist != 0:
        away = abs(i - targets.row) + abs(j - targets.column)
        out[Critic.GOAL_DIST] = p.goal_dist * grid_scale * away
    if p.prefer_forward != 0:
        out[Critic.PREFER_FORWARD] = p.prefer_forward * _forward_score(v, w, p)
    out[Critic.TWIRLING] = p.twirling * abs(w)


@jit
def _reject(critic, out):
    """Writes the scores of a pair that a critic rejects; returns infinity."""
    out[:] = 0.0
    out[0] = math.inf
    out[critic] = math.inf
    return math.inf


@jit
def _total(out):
    """Returns the sum of the scores of the critics, in their order."""
    total = 0.0
    for k in range(1, len(out)):
        total += out[k]
    return total


@jit
def _score_way(state, v, w, grid, headings, polygon, p, out):
    """Adds the scores that depend on the whole trajectory.

    Returns the total; infinite if a critic rejects the pair.
    """
    costs, ox, oy, resolution = grid
    rows, columns = costs.shape
    inverse = 1.0 / resolution
    on_grid = p.path_dist != 0 or p.goal_dist != 0
    count = steps_of(v, w, p)
    dt = p.sim_time / count
    _predict_headings(state, w, count, dt, p, headings)
    x = state[0]
    y = state[1]
    now = state[3] if p.at_once == 0 else v
    base = 0.0
    outline = 0.0
    # With `sum_scores`, the last pose counts twice.
    for k in range(count + 2):
        at = min(k, count)
        row = math.floor((y - oy) * inverse)
        column = math.floor((x - ox) * inverse)
        inside = 0 <= row < rows and 0 <= column < columns
        if p.base_obstacle != 0:
            if not inside or costs[row, column] >= 253:
                return _reject(Critic.BASE_OBSTACLE, out)
            base += float(costs[row, column])
        elif not inside and on_grid:
            return _reject(Critic.PATH_DIST, out)
        if p.obstacle_footprint != 0:
            edge = outline_cost(
                costs, ox, oy, resolution, x, y, headings[at, 2], polygon
            )
            if edge < 0 or edge >= 254:
                return _reject(Critic.OBSTACLE_FOOTPRINT, out)
            last = float(edge)
            outline += last
        if k < count:
            now = toward(now, p.acc_lim_x, p.decel_lim_x, dt, v)
            x += now * headings[k, 0] * dt
            y += now * headings[k, 1] * dt
    if p.sum_scores != 0:
        out[Critic.BASE_OBSTACLE] = p.base_obstacle * base
        out[Critic.OBSTACLE_FOOTPRINT] = p.obstacle_footprint * outline
    elif p.obstacle_footprint != 0:
        out[Critic.OBSTACLE_FOOTPRINT] = p.obstacle_footprint * last
    out[0] = _total(out)
    return out[0]


@jit
def score_samples(
    state, vs, ws, grid, cells, targets, latches, polygon, p, every, scores
):
    """Scores pairs of samples and returns the row of the best.

    The best has the lowest total; of equal ones, the first counts; -1 if all
    are rejected. Critics with weight 0 are not evaluated.

    `state` is (x, y, yaw, v, w) of the robot, `vs` and `ws` are the samples of
    speed and turn rate, ascending. `grid` has the costs of the map, the x and y
    of its origin, and its resolution; `cells` are `path_cells`, and `polygon`
    is the footprint, shape (k, 2).

    `scores`, shape (len(vs) * len(ws), 11), gets the total and the weighted
    scores of the critics, in rows by ascending v, then w. Where a critic
    rejects a pair, the total and the critic's score are infinite; an excluded
    pair has a row of infinities. Unless `every` is true, the rows of pairs
    whose ends alone score more than the best are not finished.
    """
    fastest = max(abs(vs[0]), abs(vs[-1]))
    most = steps_of(fastest, max(abs(ws[0]), abs(ws[-1])), p)
    headings = np.empty((most + 1, 3))
    grid = (unowned(grid[0]), grid[1], grid[2], grid[3])
    cells = unowned(cells)
    state = unowned(state)
    scores = unowned(scores)
    # What the totals are at least: scores are not negative.
    bounds = np.full(len(scores), math.inf)
    for b in range(len(ws)):
        w = ws[b]
        count = 0
        for a in range(len(vs)):
            v = vs[a]
            steps = steps_of(v, w, p)
            if steps != count:
                # Speeds with as many steps share headings.
                count = steps
                dt = p.sim_time / count
                _predict_headings(state, w, count, dt, p, headings)
            place = a * len(ws) + b
            out = scores[place]
            if _is_excluded(v, w, p):
                out[:] = math.inf
                continue
            if p.oscillation != 0 and (
                v * latches.v_sign < 0 or w * latches.w_sign < 0
            ):
                _reject(Critic.OSCILLATION, out)
                continue
            out[:] = 0.0
            if p.rotate_to_goal != 0:
                last = count
                while 0 <= p.lookahead_time < last * dt:
                    last -= 1
                out[Critic.ROTATE_TO_GOAL] = p.rotate_to_goal * _rotate_score(
                    *(v, w, headings[last, 2], targets.yaw, state[3]),
                    *(latches.rotating, p),
                )
            x, y = _end_of(state, v, count, dt, headings, p)
            _score_end(
                *(x, y, headings[count], v, w, grid, cells, targets),
                *(latches, p, out),
            )
            bounds[place] = _total(out)
    if every:
        for place in range(len(scores)):
            if scores[place, 0] < math.inf:
                bounds[place] = _score_way(
                    *(state, vs[place // len(ws)], ws[place % len(ws)], grid),
                    *(headings, polygon, p, scores[place]),
                )
    best = -1
    least = math.inf
    while True:
        place = bounds.argmin()
        bound = bounds[place]
        if (
            bound > least
            or bound == math.inf
            or (bound == least and place > best)
        ):
            return best
        bounds[place] = math.inf
        total = _score_way(
            *(state, vs[place // len(ws)], ws[place % len(ws)], grid),
            *(headings, polygon, p, scores[place]),
        )
        if total < least or (total == least and place < best):
            least = total
            best = place
