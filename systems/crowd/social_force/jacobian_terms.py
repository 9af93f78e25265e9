"""The derivatives of the terms of the social force model, compiled by numba.

They are those of `compiled_forces.py`, written out by hand. A term has a
derivative wherever its formula has one. Where it jumps or has a kink (another
wall becomes the nearest), it is that of the side that the kernel computes;
where the force is zero by definition (coincident people), so is the
derivative.
"""

import math

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import Command, RobotRole, X, Y
from hunav_drake.systems.crowd.social_force.constants import (
    MOST,
    REPULSION_FLOOR,
    SHORT,
)
from hunav_drake.systems.crowd.social_force.jacobian_pairs import ROBOT, STATE
from hunav_drake.systems.people.parameters import (
    K_COHERENCE,
    K_GAZE,
    K_OBSTACLE,
    K_REPULSION,
    SIGMA,
)
from hunav_drake.systems.world.nearest import shapes_within


@jit
def point_derivative(dx, dy, radius, factor, k, edge):
    """Returns the derivative of the force of an obstacle's nearest point.

    (dx, dy) is the person relative to that point, in meters, `factor` the
    obstacle factor, in m/s^2. With `edge`, the point moves along with the
    person, on an edge. The results are the elements xx, xy and yy of the
    symmetric 2 x 2 derivative.
    """
    distance = math.sqrt(dx * dx + dy * dy)
    if distance < SHORT:
        return 0.0, 0.0, 0.0
    ux = dx / distance
    uy = dy / distance
    exponent = (radius - distance) / k[SIGMA]
    steep = -1 / k[SIGMA]
    if exponent >= MOST:
        exponent = MOST
        steep = 0.0
    strength = factor * math.exp(exponent)
    away = strength * steep
    across = 0.0 if edge else strength / distance
    return (
        away * ux * ux + across * uy * uy,
        (away - across) * ux * uy,
        away * uy * uy + across * ux * ux,
    )


@jit
def wall_derivative(x, y, felt, k, walls, reach, most):
    """Returns the derivative of the sum over the walls: xx, xy, yy.

    `felt` is a row of `at_walls`: a radius and an obstacle factor.
    """
    xx = 0.0
    xy = 0.0
    yy = 0.0
    near = shapes_within(x, y, reach, most, walls)
    for i in range(len(near)):
        sx, sy, ex, ey = walls.segments[int(near[i, 3])]
        ax = ex - sx
        ay = ey - sy
        t = (x - sx) * ax + (y - sy) * ay
        length2 = ax * ax + ay * ay
        # The nearest point slides along, unless it is an end.
        edge = length2 > 0 and 0 <= t <= length2
        part = point_derivative(
            *(x - near[i, 0], y - near[i, 1], felt[0], felt[1], k, edge)
        )
        xx += part[0]
        xy += part[1]
        yy += part[2]
    return xx, xy, yy


@jit
def add_block(rows, column, xx, xy, yx, yy):
    """Adds a 2 x 2 block to the rows of a person's force."""
    rows[0, column] += xx
    rows[0, column + 1] += xy
    rows[1, column] += yx
    rows[1, column + 1] += yy


@jit
def add_robot_derivatives(i, states, radii, command, k, robots, rows, column):
    """Adds the derivatives by the robots, from a column on.

    Those of robots that count as people come with `jacobian_pairs.add_pairs`.
    """
    x = states[i, X]
    y = states[i, Y]
    nearest = math.inf
    who = -1
    for j in range(len(robots)):
        dx = robots[j, X] - x
        dy = robots[j, Y] - y
        if int(command[i, Command.ROBOT_ROLE]) == RobotRole.OBSTACLE:
            xx, xy, yy = point_derivative(
                -dx, -dy, radii[i], k[K_OBSTACLE], k, False
            )
            add_block(rows, column + ROBOT * j, -xx, -xy, -xy, -yy)
        distance = math.sqrt(dx * dx + dy * dy)
        if distance < nearest and distance > 0:
            nearest = distance
            who = j
    if who < 0 or nearest < SHORT or command[i, Command.ROBOT_REPULSION] == 0:
        return
    ux = (x - robots[who, X]) / nearest
    uy = (y - robots[who, Y]) / nearest
    gap = nearest - radii[i]
    push = command[i, Command.ROBOT_REPULSION] / max(gap, REPULSION_FLOOR)
    across = push / nearest
    away = -push / gap if gap >= REPULSION_FLOOR else 0.0
    xy = (away - across) * ux * uy
    add_block(
        rows,
        column + ROBOT * who,
        -(away * ux * ux + across * uy * uy),
        -xy,
        -xy,
        -(away * uy * uy + across * ux * ux),
    )


@jit
def add_group_derivatives(
    i, ex, ey, per_distance, states, radii, command, k, rows
):
    """Adds the derivatives of the group forces on person i.

    (ex, ey) is the direction of the goal, zero without one; per_distance is
    one over its distance. Returns the derivative by the own position, beyond
    minus the sum of those by the positions of the others: xx, xy, yx, yy.
    """
    group = command[i, Command.GROUP_ID]
    x = states[i, X]
    y = states[i, Y]
    members = 0
    cx = 0.0
    cy = 0.0
    for j in range(len(states)):
        if command[j, Command.GROUP_ID] == group:
            members += 1
            cx += states[j, X]
            cy += states[j, Y]
    if members < 2:
        return 0.0, 0.0, 0.0, 0.0
    cx /= members
    cy /= members

    dx = cx - x
    dy = cy - y
    distance = math.sqrt(dx * dx + dy * dy)
    soft = math.tanh(distance - (members - 1) / 2)
    pull = k[K_COHERENCE] / 2 * (soft + 1)
    steep = 0.0
    if distance >= SHORT:
        steep = k[K_COHERENCE] / 2 * (1 - soft * soft) / distance
    xx = (pull + steep * dx * dx) / members
    xy = steep * dx * dy / members
    yy = (pull + steep * dy * dy) / members

    others = 1 / (members - 1)
    dx = others * (members * cx - x) - x
    dy = others * (members * cy - y) - y
    along = ex * dx + ey * dy
    own = (0.0, 0.0, 0.0, 0.0)
    if along < 0:
        gaze = k[K_GAZE]
        xx += gaze * others * ex * ex
        xy += gaze * others * ex * ey
        yy += gaze * others * ey * ey
        # The heading turns, by (-ey, ex) over the distance.
        sx = -ey * (-gaze * per_distance)
        sy = ex * (-gaze * per_distance)
        across = ex * dy - ey * dx
        fx = across * ex - along * ey
        fy = across * ey + along * ex
        own = (fx * sx, fx * sy, fy * sx, fy * sy)

    for j in range(len(states)):
        if j != i and command[j, Command.GROUP_ID] == group:
            add_block(rows, STATE * j, xx, xy, xy, yy)
            dx = x - states[j, X]
            dy = y - states[j, Y]
            if math.sqrt(dx * dx + dy * dy) < radii[i] + radii[j]:
                push = k[K_REPULSION]
                add_block(rows, STATE * j, -push, 0.0, 0.0, -push)
    return own
