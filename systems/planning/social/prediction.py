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
def _force_between(agents, i, j, k):
    """Returns the social force of agent j on agent i."""
    return pair_force(
        *(agents[0, j] - agents[0, i], agents[1, j] - agents[1, i]),
        *(agents[2, i] - agents[2, j], agents[3, i] - agents[3, j], k),
    )


@jit
def _predict_robot(robot, v, omega, p, way):
    """Writes rows (x, y, yaw, v, omega) of the robot: start and steps."""
    x, y, yaw, speed, turn = robot[0], robot[1], robot[2], robot[3], robot[4]
    for k in range(len(way)):
        way[k, 0] = x
        way[k, 1] = y
        way[k, 2] = yaw
        way[k, 3] = speed
        way[k, 4] = turn
        # It moves along its previous heading.
        speed = _toward(speed, v, p.max_trans_acc * p.dt)
        turn = _toward(turn, omega, p.max_rot_acc * p.dt)
        x += speed * math.cos(yaw) * p.dt
        y += speed * math.sin(yaw) * p.dt
        yaw += turn * p.dt


@jit
def _cost_without_people(way, goal, grid, polygon, p):
    """Returns the cost of a way of the robot without the social work."""
    costs, ox, oy, resolution = grid
    last = len(way) - 1
    footprints = 0.0
    for k in range(last):
        x, y, yaw = way[k, 0], way[k, 1], way[k, 2]
        cost = outline_cost(costs, ox, oy, resolution, x, y, yaw, polygon)
        if cost < 0 or cost >= _LETHAL:
            return math.inf
        footprints += cost / 255.0
    dx = goal[0] - way[last, 0]
    dy = goal[1] - way[last, 1]
    bearing = 0.0
    if dx != 0 or dy != 0:
        bearing = abs(wrap(math.atan2(dy, dx) - way[last, 2]))
    unused = abs(p.max_trans_vel - way[last, 3])
    return (
        p.velocity_weight * unused / p.max_trans_vel
        + p.distance_weight * (dx * dx + dy * dy)
        + p.angle_weight * bearing / math.pi
        + p.costmap_weight * footprints / p.steps
    )


@jit
def _place_robot(agents, state, odometry_yaw):
    """Writes the robot as the first of `agents` (see `_move_people`)."""
    # (NaN: the velocity is along the heading.)
    heading = state[2] if math.isnan(odometry_yaw) else odometry_yaw
    agents[0, 0] = state[0]
    agents[1, 0] = state[1]
    agents[2, 0] = state[3] * math.cos(heading)
    agents[3, 0] = state[3] * math.sin(heading)


@jit
def _forces_between_people(agents, forces, k):
    """Writes the social force (x, y) of each person j on each i."""
    for i in range(1, agents.shape[1]):
        for j in range(1, agents.shape[1]):
            if i != j:
                fx, fy = _force_between(agents, i, j, k)
                forces[i, j, 0], forces[i, j, 1] = fx, fy


@jit
def _move_people(now, then, forces, goals, points, p, k):
    """Predicts people one step on, with `forces` between them.

    `now` and `then` have rows x, y, vx, vy, and 1 once a goal is reached; the
    first column is the robot's.
    """
    x, y, vx, vy, arrived = now[0], now[1], now[2], now[3], now[4]
    for i in range(1, len(x)):
        fx, fy = _force_between(now, i, 0, k)
        for j in range(1, len(x)):
            if j != i:
                fx += forces[i, j, 0]
                fy += forces[i, j, 1]
        # People who have reached their goal have none from then on.
        reach = math.inf if arrived[i] != 0 else p.person_radius
        gx, gy = _desired_force(
            *(x[i], y[i], vx[i], vy[i], goals[i, 0], goals[i, 1]),
            *(reach, p.people_velocity, k),
        )
        wx, wy = _obstacle_force(x[i], y[i], p.person_radius, points, k)
        new_vx = vx[i] + (fx + gx + wx) * p.dt
        new_vy = vy[i] + (fy + gy + wy) * p.dt
        pace = math.sqrt(new_vx * new_vx + new_vy * new_vy)
        if pace > p.people_velocity:
            new_vx *= p.people_velocity / pace
            new_vy *= p.people_velocity / pace
        then[0, i] = x[i] + new_vx * p.dt
        then[1, i] = y[i] + new_vy * p.dt
        then[2, i] = new_vx
        then[3, i] = new_vy
        left = math.hypot(goals[i, 0] - then[0, i], goals[i, 1] - then[1, i])
        then[4, i] = arrived[i] != 0 or left <= p.person_radius


@jit
def _force_on_robot(agents, points, p, k):
    """Returns the magnitudes of the forces of people and obstacles, added."""
    fx = 0.0
    fy = 0.0
    for j in range(1, agents.shape[1]):
        gx, gy = _force_between(agents, 0, j, k)
        fx += gx
        fy += gy
    wx, wy = _obstacle_force(
        agents[0, 0], agents[1, 0], p.sfm_robot_radius, points, k
    )
    return math.sqrt(fx * fx + fy * fy) + math.sqrt(wx * wx + wy * wy)


@jit
def _force_on_people(agents, p, k):
    """Returns the sum of the robot's forces; infinite if it touches anybody."""
    total = 0.0
    for i in range(1, agents.shape[1]):
        dx = agents[0, 0] - agents[0, i]
        dy = agents[1, 0] - agents[1, i]
        if dx * dx + dy * dy <= p.sfm_robot_radius * p.sfm_robot_radius:
            return math.inf
        fx, fy = _force_between(agents, i, 0, k)
        total += math.sqrt(fx * fx + fy * fy)
    return total


@jit
def _is_beaten(c, cost, best, least):
    """Returns whether a candidate of at least a cost is not the best."""
    return cost > least or (cost == least and c > best)


@jit
def _next_candidate(ways, last, results, is_done):
    """Returns a candidate that shares most steps with the last one, and these.

    Of several, it is the one with the lowest result; -1 if all are done.
    """
    found = -1
    most = -1
    for c in range(len(ways)):
        if is_done[c]:
            continue
        shared = 0
        is_same = last >= 0
        while is_same and shared < ways.shape[1] - 1:
            for k in range(ways.shape[2]):
                is_same &= ways[c, shared + 1, k] == ways[last, shared + 1, k]
            shared += is_same
        if shared > most or (shared == most and results[c] < results[found]):
            found = c
            most = shared
    return found, most


@jit_as(
    numba.float64[::1],
    *(VECTOR, MATRIX, MATRIX, MATRIX, MATRIX),
    *(READ_CELLS, REAL, REAL, REAL, MATRIX, REAL, VECTOR, VECTOR),
    numba.boolean,
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
    every,
):
    """Returns the costs of candidates; infinite where they are not valid.

    `robot` is (x, y, yaw, v, omega), candidates are rows (v, omega). `goals`
    (1 + n, 2) are the carrot and the goal of each person, `points` (m, 2) the
    obstacles; `costs`, (ox, oy) and `resolution` are those of the costmap,
    `polygon` (k, 2) is the footprint. `odometry_yaw` is the direction of the
    robot's velocity in the forces, in radians; NaN for its heading. Unless
    `every` is true, what costs more than the best has a part of its cost.

    People move alike for as long as the robot does, so candidates that begin
    alike come after each other, and share what is predicted until then.
    """
    p = _parameters_in(parameters)
    steps = int(p.steps)
    count = len(candidates)
    ways = np.empty((count, steps + 1, 5))
    results = np.empty(count)
    for c in range(count):
        _predict_robot(robot, candidates[c, 0], candidates[c, 1], p, ways[c])
        results[c] = _cost_without_people(
            ways[c], goals[0], (costs, ox, oy, resolution), polygon, p
        )
    is_done = results == math.inf
    # The start and each step of the candidate at hand: see `_move_people`.
    agents = np.zeros((steps + 1, 5, len(humans) + 1))
    for i in range(len(humans)):
        agents[0, 0, i + 1] = humans[i, X]
        agents[0, 1, i + 1] = humans[i, Y]
        agents[0, 2, i + 1] = humans[i, VX]
        agents[0, 3, i + 1] = humans[i, VY]
    forces = np.empty((steps, len(humans) + 1, len(humans) + 1, 2))
    on_robot = np.empty(steps)
    work = np.zeros(steps + 1)
    # The number of steps for which each is known.
    felt = 0
    paired = 0
    moved = 0
    worked = 0
    best = -1
    least = math.inf
    c, shared = _next_candidate(ways, -1, results, is_done)
    while c >= 0:
        felt = min(felt, shared + 1)
        paired = min(paired, shared + 2)
        moved = min(moved, shared + 1)
        worked = min(worked, shared)
        base = results[c]
        cost = base + p.social_weight * work[worked]
        while worked < steps and (
            every or not _is_beaten(c, cost, best, least)
        ):
            now = agents[worked]
            then = agents[worked + 1]
            _place_robot(now, ways[c, worked], odometry_yaw)
            if felt == worked:
                on_robot[worked] = _force_on_robot(now, points, p, k)
                felt += 1
            cost = base + p.social_weight * (work[worked] + on_robot[worked])
            if not every and _is_beaten(c, cost, best, least):
                break
            if moved == worked:
                if paired == worked:
                    _forces_between_people(now, forces[worked], k)
                    paired += 1
                _move_people(now, then, forces[worked], goals, points, p, k)
                moved += 1
            _place_robot(then, ways[c, worked + 1], odometry_yaw)
            on_people = _force_on_people(then, p, k)
            if on_people == math.inf:
                cost = math.inf
                break
            work[worked + 1] = work[worked] + (on_robot[worked] + on_people)
            worked += 1
            cost = base + p.social_weight * work[worked]
        results[c] = cost
        if not _is_beaten(c, cost, best, least):
            best = c
            least = cost
        is_done[c] = True
        c, shared = _next_candidate(ways, c, results, is_done)
    return results


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
