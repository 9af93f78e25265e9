"""The scores of velocities: roll-outs and critics of DWB, by numba.

Poses are (x, y, yaw) in W; v is a speed in m/s and w a turn rate in rad/s.
`p` are parameters, at the places named here.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import REAL, VECTOR, jit, jit_as
from hunav_drake.systems.planning.costmap.footprint import outline_cost

# The critics in their order: the columns of scores after the total.
CRITICS = (
    "rotate_to_goal",
    "oscillation",
    "base_obstacle",
    "obstacle_footprint",
    "goal_align",
    "path_align",
    "path_dist",
    "goal_dist",
    "prefer_forward",
    "twirling",
)
(
    ROTATE_TO_GOAL,
    OSCILLATION,
    BASE_OBSTACLE,
    OBSTACLE_FOOTPRINT,
    GOAL_ALIGN,
    PATH_ALIGN,
    PATH_DIST,
    GOAL_DIST,
    PREFER_FORWARD,
    TWIRLING,
) = range(1, 11)

# Where the parameters are: the scales of the critics come first, at 1 to 10.
(
    SIM_TIME,
    LINEAR_GRANULARITY,
    ANGULAR_GRANULARITY,
    TIME_GRANULARITY,
    ACC_X,
    DECEL_X,
    ACC_THETA,
    DECEL_THETA,
    AT_ONCE,
    MAX_SPEED,
    MIN_SPEED,
    MIN_TURN,
    FORWARD_POINT,
    SLOWING_FACTOR,
    LOOKAHEAD_TIME,
    SUM_SCORES,
    PENALTY,
    STRAFE_X,
    STRAFE_THETA,
    THETA_SCALE,
    NUM_PARAMETERS,
) = range(11, 32)

# Small turns, by their series: exact but for the last bit.
_SMALL = 0.05


@jit
def toward(now, rise, fall, dt, target):
    """Returns a velocity moved towards a target; `fall` is negative."""
    if now < target:
        return min(target, now + rise * dt)
    return max(target, now + fall * dt)


@jit
def steps_of(v, w, p):
    """Returns in how many steps a velocity is rolled out."""
    if p[TIME_GRANULARITY] > 0:
        return max(1, int(math.ceil(p[SIM_TIME] / p[TIME_GRANULARITY])))
    far = abs(v) * p[SIM_TIME] / p[LINEAR_GRANULARITY]
    turned = abs(w) * p[SIM_TIME] / p[ANGULAR_GRANULARITY]
    return max(1, int(math.ceil(max(far, turned))))


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
def roll_out(state, v, w, p):
    """Returns the poses of one sample, shape (n, 3), the start first.

    `state` is (x, y, yaw, v, w) of the robot. The velocity goes towards the
    sample, each step begins in the old direction, and the last pose comes
    twice (`StandardTrajectoryGenerator`, with `include_last_point`).
    """
    count = steps_of(v, w, p)
    dt = p[SIM_TIME] / count
    x, y, yaw, now_v, now_w = state[0], state[1], state[2], state[3], state[4]
    poses = np.empty((count + 2, 3))
    for k in range(count + 1):
        poses[k, 0] = x
        poses[k, 1] = y
        poses[k, 2] = yaw
        if p[AT_ONCE] != 0:
            now_v = v
            now_w = w
        else:
            now_v = toward(now_v, p[ACC_X], p[DECEL_X], dt, v)
            now_w = toward(now_w, p[ACC_THETA], p[DECEL_THETA], dt, w)
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
        return v * v * p[SLOWING_FACTOR] + _yaw_error(yaw, goal_yaw)
    if v != 0:
        return math.inf
    return _yaw_error(yaw, goal_yaw)


@jit
def _forward_score(v, w, p):
    """Returns the score of PreferForward."""
    if v < 0:
        return p[PENALTY]
    if v < p[STRAFE_X] and abs(w) < p[STRAFE_THETA]:
        return p[PENALTY]
    return abs(w) * p[THETA_SCALE]


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
    """Scores all pairs of samples, and returns the number of the best.

    The best has the lowest total; of equal ones, the first counts. Each critic
    is scaled; those with scale 0 are not asked.

    Args:
        state: (x, y, yaw, v, w) of the robot.
        vs: The samples of the speed, ascending.
        ws: The samples of the turn rate, ascending.
        costs: Those of the map.
        ox: The origin of the map.
        oy: The same along the other axis.
        resolution: The side of a cell.
        distances: From the plan: see `path_distances`.
        targets: The cells (row, column) of GoalDist and of GoalAlign, and the
            yaw of the goal: 5 numbers.
        latches: What RotateToGoal does (0 nothing, 1 slow down, 2 turn), the
            signs that Oscillation allows for v and for w (0 for all), and
            whether PathAlign is on.
        polygon: The outline of the robot, shape (k, 2).
        p: The parameters.
        scores: Written: shape (len(vs) * len(ws), 11), the total and the
            scaled scores of the critics, row by row as v, then w ascend. The
            total is infinite if a critic forbids it, and that one's score;
            a pair that is no sample has infinite numbers only.

    Returns:
        The row of the best, or -1 if all are forbidden.
    """
    rows, columns = costs.shape
    inverse = 1.0 / resolution
    grid_scale = 0.5 * resolution
    on_grid = p[PATH_DIST] != 0 or p[GOAL_DIST] != 0
    mode = int(latches[0])
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
                v * v > p[MAX_SPEED] * p[MAX_SPEED] + 1e-5
                or (abs(v) < p[MIN_SPEED] and abs(w) < p[MIN_TURN])
                or (v == 0 and w == 0)
            ):
                out[:] = math.inf
                continue
            out[:] = 0.0
            if p[OSCILLATION] != 0 and (
                v * latches[1] < 0 or w * latches[2] < 0
            ):
                out[0] = math.inf
                out[OSCILLATION] = math.inf
                continue
            count = steps_of(v, w, p)
            dt = p[SIM_TIME] / count
            x = state[0]
            y = state[1]
            yaw = state[2]
            c = start_c
            s = start_s
            now_v = state[3]
            now_w = state[4]
            # The same as `roll_out`, but with the turns by a recurrence.
            step_c = 1.0
            step_s = 0.0
            steady = False
            if p[AT_ONCE] != 0:
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
                row = int(math.floor((y - oy) * inverse))
                column = int(math.floor((x - ox) * inverse))
                inside = 0 <= row < rows and 0 <= column < columns
                if p[BASE_OBSTACLE] != 0:
                    if not inside or costs[row, column] >= 253:
                        legal = BASE_OBSTACLE
                        break
                    cost = float(costs[row, column])
                    base = base + cost if p[SUM_SCORES] != 0 else cost
                elif not inside and on_grid:
                    legal = PATH_DIST
                    break
                if p[OBSTACLE_FOOTPRINT] != 0:
                    edge = outline_cost(
                        costs, ox, oy, resolution, x, y, yaw, polygon
                    )
                    if edge < 0 or edge >= 254:
                        legal = OBSTACLE_FOOTPRINT
                        break
                    if p[SUM_SCORES] != 0:
                        outline += edge
                    else:
                        outline = float(edge)
                if k * dt <= p[LOOKAHEAD_TIME]:
                    ahead_yaw = yaw
                if k == count:
                    break
                if not steady:
                    now_v = toward(now_v, p[ACC_X], p[DECEL_X], dt, v)
                    now_w = toward(now_w, p[ACC_THETA], p[DECEL_THETA], dt, w)
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
            if p[SUM_SCORES] != 0 and p[BASE_OBSTACLE] != 0:
                # The last pose comes twice.
                base += costs[row, column]
            if p[SUM_SCORES] != 0 and p[OBSTACLE_FOOTPRINT] != 0:
                outline += outline_cost(
                    costs, ox, oy, resolution, x, y, yaw, polygon
                )
            if p[ROTATE_TO_GOAL] != 0:
                last_yaw = ahead_yaw if p[LOOKAHEAD_TIME] >= 0 else yaw
                out[ROTATE_TO_GOAL] = p[ROTATE_TO_GOAL] * _rotate_score(
                    v, w, last_yaw, targets[4], state[3], mode, p
                )
            out[BASE_OBSTACLE] = p[BASE_OBSTACLE] * base
            out[OBSTACLE_FOOTPRINT] = p[OBSTACLE_FOOTPRINT] * outline
            if p[GOAL_ALIGN] != 0 or (p[PATH_ALIGN] != 0 and latches[3] != 0):
                fx = x + p[FORWARD_POINT] * c
                fy = y + p[FORWARD_POINT] * s
                i = int(math.floor((fy - oy) * inverse))
                j = int(math.floor((fx - ox) * inverse))
                if not (0 <= i < rows and 0 <= j < columns):
                    out[0] = math.inf
                    out[GOAL_ALIGN] = math.inf
                    continue
                away = abs(i - targets[2]) + abs(j - targets[3])
                out[GOAL_ALIGN] = p[GOAL_ALIGN] * grid_scale * away
                if latches[3] != 0:
                    near = distances[i, j]
                    out[PATH_ALIGN] = p[PATH_ALIGN] * grid_scale * near
            if p[PATH_DIST] != 0:
                near = distances[row, column]
                out[PATH_DIST] = p[PATH_DIST] * grid_scale * near
            if p[GOAL_DIST] != 0:
                away = abs(row - targets[0]) + abs(column - targets[1])
                out[GOAL_DIST] = p[GOAL_DIST] * grid_scale * away
            if p[PREFER_FORWARD] != 0:
                forward = _forward_score(v, w, p)
                out[PREFER_FORWARD] = p[PREFER_FORWARD] * forward
            out[TWIRLING] = p[TWIRLING] * abs(w)
            total = 0.0
            for k in range(1, len(out)):
                total += out[k]
            out[0] = total
            if total < least:
                least = total
                best = row_of
    return best
