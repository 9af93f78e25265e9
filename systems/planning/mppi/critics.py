"""The critics of MPPI, each for one rollout, compiled by numba.

They are those of nav2_mppi_controller, reimplemented from its manual with power
1, and one for people. `poses` has shape (n, 3), rows (x, y, yaw) at the ends of
the steps; `path` has shape (k, 2), evenly spaced points of the local plan; `p`
are `Parameters`.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import pair_force
from hunav_drake.systems.people.parameters import GAMMA, LAMBDA
from hunav_drake.systems.planning.costmap.footprint import outline_cost

_INSCRIBED = 253
_LETHAL = 254

# Forces below exp(-5), 0.7 %, of the largest are neglected.
_FAINT = 5.0


@jit
def angle_between(a, b):
    """Returns the absolute angle between two headings, in radians."""
    return abs((a - b + math.pi) % (2 * math.pi) - math.pi)


@jit
def constraint_score(velocities, p):
    """Returns the excess of the velocity over its bounds, summed over time."""
    total = 0.0
    for k in range(len(velocities)):
        v = velocities[k, 0]
        omega = abs(velocities[k, 1])
        total += max(v - p.max_v, 0.0) + max(p.min_v - v, 0.0)
        total += max(omega - p.max_turn, 0.0)
    return total * p.dt


@jit
def cell_cost(costs, ox, oy, inverse, x, y):
    """Returns the cost at a point; 255 off the map."""
    row = math.floor((y - oy) * inverse)
    column = math.floor((x - ox) * inverse)
    if 0 <= row < costs.shape[0] and 0 <= column < costs.shape[1]:
        return int(costs[row, column])
    return 255


@jit
def cost_score(poses, costs, ox, oy, resolution, polygon, to_goal, p):
    """Returns the mean cost along the trajectory; infinite for a collision.

    Near the goal, only critical costs count.
    """
    inverse = 1.0 / resolution
    every = int(p.cost_step)
    graded = to_goal > p.near_goal_distance
    total = 0.0
    count = 0
    for k in range(0, len(poses), every):
        count += 1
        cost = cell_cost(costs, ox, oy, inverse, poses[k, 0], poses[k, 1])
        if cost >= _LETHAL:
            return math.inf
        if p.consider_footprint != 0:
            if cost > 0:
                edge = outline_cost(
                    *(costs, ox, oy, resolution),
                    *(poses[k, 0], poses[k, 1], poses[k, 2], polygon),
                )
                if edge < 0 or edge >= _LETHAL:
                    return math.inf
            if cost >= _INSCRIBED:
                total += p.critical_cost
                continue
        elif cost >= _INSCRIBED:
            return math.inf
        if graded:
            total += cost
    return total / count


@jit
def goal_score(poses, goal):
    """Returns the mean distance from the goal (x, y, yaw), in meters."""
    total = 0.0
    for k in range(len(poses)):
        dx = poses[k, 0] - goal[0]
        dy = poses[k, 1] - goal[1]
        total += math.sqrt(dx * dx + dy * dy)
    return total / len(poses)


@jit
def goal_angle_score(poses, goal):
    """Returns the mean angle between the heading and that of the goal."""
    total = 0.0
    for k in range(len(poses)):
        total += angle_between(poses[k, 2], goal[2])
    return total / len(poses)


@jit
def path_align_score(start_x, start_y, poses, path, spacing, free, p):
    """Returns the mean distance from the plan at equal path length.

    The plan's points are `spacing` apart, in meters; only those count that are
    `free`. The robot starts at (start_x, start_y).
    """
    every = int(p.path_align_step)
    x = start_x
    y = start_y
    way = 0.0
    total = 0.0
    count = 0
    for k in range(every - 1, len(poses), every):
        dx = poses[k, 0] - x
        dy = poses[k, 1] - y
        way += math.sqrt(dx * dx + dy * dy)
        x = poses[k, 0]
        y = poses[k, 1]
        i = min(int(way / spacing + 0.5), len(path) - 1)
        if free[i]:
            count += 1
            total += math.sqrt((path[i, 0] - x) ** 2 + (path[i, 1] - y) ** 2)
    return total / count if count > 0 else 0.0


@jit
def path_follow_score(poses, path, free, reached, p):
    """Returns the distance from the end to a point beyond those reached."""
    last = len(path) - 1
    i = min(reached + int(p.path_follow_offset), last)
    while i < last and not free[i]:
        i += 1
    dx = poses[-1, 0] - path[i, 0]
    dy = poses[-1, 1] - path[i, 1]
    return math.sqrt(dx * dx + dy * dy)


@jit
def angle_point(path, reached, p):
    """Returns the point (x, y) ahead that PathAngle faces."""
    i = min(reached + int(p.path_angle_offset), len(path) - 1)
    return path[i, 0], path[i, 1]


@jit
def path_angle_score(poses, x, y):
    """Returns the mean angle between the heading and a point (x, y)."""
    total = 0.0
    for k in range(len(poses)):
        to = math.atan2(y - poses[k, 1], x - poses[k, 0])
        total += angle_between(poses[k, 2], to)
    return total / len(poses)


@jit
def prefer_forward_score(velocities, p):
    """Returns the distance driven backwards, in meters."""
    total = 0.0
    for k in range(len(velocities)):
        total += max(-velocities[k, 0], 0.0)
    return total * p.dt


@jit
def social_score(poses, velocities, humans, forces, p):
    """Returns the mean social work along the trajectory, in m/s^2.

    Social work is the magnitude of the social force of all people on the robot
    plus the magnitudes of the robot's forces on each of them; people keep their
    velocity. (As in Perez-Higueras et al. 2014 and in the social force window
    planner.) The two forces of a pair are opposite. `velocities` has rows (v,
    omega), `humans` the current rows of the people, `forces` the parameters of
    the social force.
    """
    every = int(p.social_step)
    total = 0.0
    count = 0
    for k in range(every - 1, len(poses), every):
        count += 1
        time = (k + 1) * p.dt
        vx = velocities[k, 0] * math.cos(poses[k, 2])
        vy = velocities[k, 0] * math.sin(poses[k, 2])
        on_x = 0.0
        on_y = 0.0
        for i in range(len(humans)):
            dx = humans[i, X] + humans[i, VX] * time - poses[k, 0]
            dy = humans[i, Y] + humans[i, VY] * time - poses[k, 1]
            r = math.sqrt(dx * dx + dy * dy)
            dvx = vx - humans[i, VX]
            dvy = vy - humans[i, VY]
            if r > 0:
                # The decay length of `pair_force`, in a faster form.
                ix = forces[LAMBDA] * dvx + dx / r
                iy = forces[LAMBDA] * dvy + dy / r
                b = forces[GAMMA] * math.sqrt(ix * ix + iy * iy)
                if r > _FAINT * b:
                    continue
            fx, fy = pair_force(dx, dy, dvx, dvy, forces)
            on_x += fx
            on_y += fy
            total += math.sqrt(fx * fx + fy * fy)
        total += math.sqrt(on_x * on_x + on_y * on_y)
    return total / count if count > 0 else 0.0


@jit
def furthest_reached(ends, path):
    """Returns the index of the furthest path point nearest to any end."""
    result = 0
    for i in range(len(ends)):
        nearest = 0
        least = math.inf
        for k in range(len(path)):
            dx = path[k, 0] - ends[i, 0]
            dy = path[k, 1] - ends[i, 1]
            d2 = dx * dx + dy * dy
            if d2 < least:
                least = d2
                nearest = k
        result = max(result, nearest)
    return result


@jit
def free_points(path, costs, ox, oy, resolution):
    """Returns for each point of the plan whether it is free."""
    result = np.empty(len(path), dtype=np.bool_)
    for k in range(len(path)):
        cost = cell_cost(
            costs, ox, oy, 1.0 / resolution, path[k, 0], path[k, 1]
        )
        # (Points beyond the map count as free.)
        result[k] = cost < _INSCRIBED or cost == 255
    return result
