"""SFW's prediction of people and robot, compiled by numba.

Symbols: a candidate is a pair (v, omega) that the robot's velocity changes to
over some steps, while people move by the social force model of lightsfm, in
which the robot is one of the agents. `p` are `Parameters`; `k` is a row of the
crowd's parameters (`people.parameters`).
"""

import math
from typing import NamedTuple

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
    reads,
)
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    pair_force,
    point_force,
    wrap,
)
from hunav_drake.systems.people.parameters import K_GOAL, K_OBSTACLE, SIGMA, TAU
from hunav_drake.systems.planning.costmap.footprint import outline_cost
from hunav_drake.systems.planning.costmap.raster import READ_CELLS
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.walls import opened


class Parameters(NamedTuple):
    """The parameters of prediction and costs; all are floats.

    There are `steps` of `dt` seconds. The others are those of `SfwPlanner`.
    """

    steps: float
    dt: float
    max_trans_acc: float
    max_rot_acc: float
    max_trans_vel: float
    people_velocity: float
    sfm_robot_radius: float
    person_radius: float
    naive_goal_time: float
    social_weight: float
    costmap_weight: float
    velocity_weight: float
    angle_weight: float
    distance_weight: float


_parameters_in = reads(Parameters)

# The footprint cost from which a robot collides.
_LETHAL = 254

# Obstacle forces below 10 exp(-14), about 1e-5 m/s^2, are neglected.
_DEEPEST = -14.0

# The distance at which the robot's force model has reached its carrot, in m.
_CARROT_RADIUS = 0.2


@jit
def _toward(value, target, most):
    """Returns a value moved towards another by at most `most`."""
    return value + min(max(target - value, -most), most)


@jit
def _obstacle_force(x, y, radius, points, k):
    """Returns the mean of the forces of obstacle points on an agent."""
    fx = 0.0
    fy = 0.0
    count = len(points)
    if count == 0:
        return fx, fy
    reach = radius - _DEEPEST * k[SIGMA]
    for i in range(count):
        dx = x - points[i, 0]
        dy = y - points[i, 1]
        if dx * dx + dy * dy >= reach * reach:
            continue
        gx, gy = point_force(
            x, y, points[i, 0], points[i, 1], radius, k[K_OBSTACLE], k
        )
        fx += gx
        fy += gy
    return fx / count, fy / count


@jit
def _desired_force(x, y, vx, vy, gx, gy, goal_radius, speed, k):
    """Returns the force towards a goal; at the goal, the force that stops."""
    dx = gx - x
    dy = gy - y
    d = math.sqrt(dx * dx + dy * dy)
    if d <= goal_radius:
        return -vx / k[TAU], -vy / k[TAU]
    return (
        k[K_GOAL] * (dx / d * speed - vx) / k[TAU],
        k[K_GOAL] * (dy / d * speed - vy) / k[TAU],
    )


@jit
def _social_force(i, x, y, vx, vy, k):
    """Returns the social force of all others on agent i (0: the robot)."""
    fx = 0.0
    fy = 0.0
    for j in range(len(x)):
        if j != i:
            gx, gy = pair_force(
                x[j] - x[i], y[j] - y[i], vx[i] - vx[j], vy[i] - vy[j], k
            )
            fx += gx
            fy += gy
    return fx, fy


@jit
def predict(
    robot, v, omega, humans, goals, points, grid, polygon, odometry_yaw, p, k
):
    """Returns the cost of a candidate; infinite if it is not valid.

    `robot` is (x, y, yaw, v, omega), `v` and `omega` are the candidate. `goals`
    (1 + n, 2) are the carrot and the goal of each person, `points` (m, 2) the
    obstacles, `grid` the costs, the x and y of the origin, and the resolution
    of the costmap, `polygon` (k, 2) the footprint. `odometry_yaw` is the
    direction of the robot's velocity in the forces, in radians; NaN for its
    heading.
    """
    costs, ox, oy, resolution = grid
    n = len(humans)
    x = np.empty(n + 1)
    y = np.empty(n + 1)
    vx = np.empty(n + 1)
    vy = np.empty(n + 1)
    rx, ry, yaw, speed, turn = robot
    x[0] = rx
    y[0] = ry
    for i in range(n):
        x[i + 1] = humans[i, X]
        y[i + 1] = humans[i, Y]
        vx[i + 1] = humans[i, VX]
        vy[i + 1] = humans[i, VY]
    # (NaN: the velocity is along the heading.)
    heading = yaw if math.isnan(odometry_yaw) else odometry_yaw
    vx[0] = speed * math.cos(heading)
    vy[0] = speed * math.sin(heading)
    dt = p.dt
    work = 0.0
    footprints = 0.0
    ax = np.empty(n + 1)
    ay = np.empty(n + 1)
    # People who have reached their goal have none from then on.
    arrived = np.zeros(n + 1, np.bool_)
    for _ in range(int(p.steps)):
        cost = outline_cost(costs, ox, oy, resolution, rx, ry, yaw, polygon)
        if cost < 0 or cost >= _LETHAL:
            return math.inf
        footprints += cost / 255.0
        # The forces are those before the agents move.
        social_x, social_y = _social_force(0, x, y, vx, vy, k)
        wall_x, wall_y = _obstacle_force(
            x[0], y[0], p.sfm_robot_radius, points, k
        )
        on_robot = math.sqrt(social_x * social_x + social_y * social_y)
        on_robot += math.sqrt(wall_x * wall_x + wall_y * wall_y)
        for i in range(1, n + 1):
            fx, fy = _social_force(i, x, y, vx, vy, k)
            reach = math.inf if arrived[i] else p.person_radius
            gx, gy = _desired_force(
                *(x[i], y[i], vx[i], vy[i], goals[i, 0], goals[i, 1]),
                *(reach, p.people_velocity, k),
            )
            wx, wy = _obstacle_force(x[i], y[i], p.person_radius, points, k)
            ax[i] = fx + gx + wx
            ay[i] = fy + gy + wy
        for i in range(1, n + 1):
            vx[i] += ax[i] * dt
            vy[i] += ay[i] * dt
            pace = math.sqrt(vx[i] * vx[i] + vy[i] * vy[i])
            if pace > p.people_velocity:
                vx[i] *= p.people_velocity / pace
                vy[i] *= p.people_velocity / pace
            x[i] += vx[i] * dt
            y[i] += vy[i] * dt
            left = math.hypot(goals[i, 0] - x[i], goals[i, 1] - y[i])
            arrived[i] = arrived[i] or left <= p.person_radius
        # The robot moves along its previous heading.
        speed = _toward(speed, v, p.max_trans_acc * dt)
        turn = _toward(turn, omega, p.max_rot_acc * dt)
        rx += speed * math.cos(yaw) * dt
        ry += speed * math.sin(yaw) * dt
        yaw += turn * dt
        x[0] = rx
        y[0] = ry
        heading = yaw if math.isnan(odometry_yaw) else odometry_yaw
        vx[0] = speed * math.cos(heading)
        vy[0] = speed * math.sin(heading)
        on_people = 0.0
        for i in range(1, n + 1):
            dx = rx - x[i]
            dy = ry - y[i]
            if dx * dx + dy * dy <= p.sfm_robot_radius * p.sfm_robot_radius:
                return math.inf
            fx, fy = pair_force(dx, dy, vx[i] - vx[0], vy[i] - vy[0], k)
            on_people += math.sqrt(fx * fx + fy * fy)
        work += on_robot + on_people
    dx = goals[0, 0] - rx
    dy = goals[0, 1] - ry
    bearing = 0.0
    if dx != 0 or dy != 0:
        bearing = abs(wrap(math.atan2(dy, dx) - yaw))
    return (
        p.velocity_weight * abs(p.max_trans_vel - speed) / p.max_trans_vel
        + p.distance_weight * (dx * dx + dy * dy)
        + p.angle_weight * bearing / math.pi
        + p.costmap_weight * footprints / p.steps
        + p.social_weight * work
    )


@jit_as(
    numba.float64[::1],
    *(VECTOR, MATRIX, MATRIX, MATRIX, MATRIX),
    *(READ_CELLS, REAL, REAL, REAL, MATRIX, REAL, VECTOR, VECTOR),
)
def candidate_costs(
    robot,
    candidates,
    humans,
    goals,
    points,
    costs,
    ox,
    oy,
    resolution,
    polygon,
    odometry_yaw,
    parameters,
    k,
):
    """Returns the costs of candidates, rows (v, omega): see `predict`."""
    p = _parameters_in(parameters)
    result = np.empty(len(candidates))
    state = (robot[0], robot[1], robot[2], robot[3], robot[4])
    grid = (costs, ox, oy, resolution)
    for c in range(len(candidates)):
        result[c] = predict(
            *(state, candidates[c, 0], candidates[c, 1], humans, goals),
            *(points, grid, polygon, odometry_yaw, p, k),
        )
    return result


@jit_as(numba.float64[:, ::1], REAL, REAL, REAL, INTEGER, WALLS)
def wall_points(x, y, reach, rays, table):
    """Returns the first hits of walls by rays from a point, shape (m, 2).

    There are `rays` rays, evenly in all directions, of length `reach`, in
    meters; rays without a hit give no point. `table` is `Obstacles.table`.
    """
    walls = opened(table)
    points = np.empty((rays, 2))
    count = 0
    for i in range(rays):
        angle = 2 * math.pi * i / rays
        dx = reach * math.cos(angle)
        dy = reach * math.sin(angle)
        part = first_hit(x, y, x + dx, y + dy, walls)
        if part < math.inf:
            points[count, 0] = x + part * dx
            points[count, 1] = y + part * dy
            count += 1
    return points[:count].copy()
