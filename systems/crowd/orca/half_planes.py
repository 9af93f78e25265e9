"""The best velocity under linear rules, compiled by numba.

A rule is a row (nx, ny, b) with a unit normal n: it allows the velocities v
with n.v >= b. The velocity nearest to the desired one, within a speed limit and
all rules, is found by adding one rule after the other; if no velocity obeys
all, one is found with the least largest offence (van den Berg, Guy, Lin &
Manocha 2011, section 5). The rules come in a fixed order: nothing is drawn at
random, and the result, being unique, does not depend on the order.
"""

import math

from hunav_drake.systems.common.kernels import jit

# Velocities that differ by less are the same, in m/s.
_TINY = 1e-11

# Rules whose directions differ by less are parallel, in radians.
_PARALLEL = 1e-9

# Rules that cannot all be obeyed are relaxed by this more than necessary, in
# m/s, so that the allowed velocities are not a point but a small area, in which
# the choice is well defined.
_SLACK = 1e-3


@jit
def _on_rule(rules, i, speed, tx, ty, farthest):
    """Returns whether a velocity on rule i obeys those before; the best one."""
    nx = rules[i, 0]
    ny = rules[i, 1]
    b = rules[i, 2]
    if abs(b) > speed + _TINY:
        return False, 0.0, 0.0
    hi = math.sqrt(max(speed * speed - b * b, 0.0))
    lo = -hi
    for j in range(i):
        slope = rules[j, 1] * nx - rules[j, 0] * ny
        needed = rules[j, 2] - b * (rules[j, 0] * nx + rules[j, 1] * ny)
        if abs(slope) < _PARALLEL:
            if needed > _TINY:
                return False, 0.0, 0.0
        elif slope > 0:
            lo = max(lo, needed / slope)
        else:
            hi = min(hi, needed / slope)
        if lo > hi + _TINY:
            return False, 0.0, 0.0
    t = ty * nx - tx * ny
    if farthest:
        t = math.copysign(math.inf, t)
    t = min(max(t, lo), hi)
    return True, b * nx - t * ny, b * ny + t * nx


@jit
def _best(rules, count, speed, tx, ty, farthest):
    """Returns the velocity nearest to (tx, ty), or farthest in its direction.

    The first result is the number of the first `count` rules that it obeys:
    all of them unless they contradict each other.
    """
    vx = tx
    vy = ty
    if farthest:
        vx *= speed
        vy *= speed
    for i in range(count):
        if rules[i, 0] * vx + rules[i, 1] * vy < rules[i, 2] - _TINY:
            found, wx, wy = _on_rule(rules, i, speed, tx, ty, farthest)
            if not found:
                return i, vx, vy
            vx = wx
            vy = wy
    return count, vx, vy


@jit
def _least_offence(rules, hard, count, begin, speed, vx, vy, scratch):
    """Returns the least largest offence, >= 0 in m/s, and the velocity with it.

    It is a linear program of three variables: the velocity, and the relaxation
    of all rules from `hard` on. (vx, vy) obeys the rules before `begin`.
    """
    offence = 0.0
    for i in range(begin, count):
        nx = rules[i, 0]
        ny = rules[i, 1]
        if rules[i, 2] - (nx * vx + ny * vy) <= offence:
            continue
        # Rule i is now the one most offended, and is to be so the least.
        for j in range(hard):
            for c in range(3):
                scratch[j, c] = rules[j, c]
        size = hard
        for j in range(hard, i):
            dx = rules[j, 0] - nx
            dy = rules[j, 1] - ny
            length = math.sqrt(dx * dx + dy * dy)
            if length > _PARALLEL:
                scratch[size, 0] = dx / length
                scratch[size, 1] = dy / length
                scratch[size, 2] = (rules[j, 2] - rules[i, 2]) / length
                size += 1
        done, wx, wy = _best(scratch, size, speed, nx, ny, True)
        if done == size:
            vx = wx
            vy = wy
        offence = max(offence, rules[i, 2] - (nx * vx + ny * vy))
    return offence, vx, vy


@jit
def best_velocity(rules, hard, count, speed, tx, ty, scratch):
    """Returns the velocity nearest to a desired one under some rules, in m/s.

    Rules that no velocity obeys are relaxed, all by the same: first the `hard`
    ones, which come first, among themselves, then the others under these. The
    first `count` of `rules` (>= count, 3) count; those that are relaxed are
    changed. (tx, ty) is the desired velocity, no faster than `speed`, in m/s;
    `scratch` is room for as many rules.
    """
    done, vx, vy = _best(rules, count, speed, tx, ty, False)
    for stage in range(2):
        low = 0 if stage == 0 else hard
        high = hard if stage == 0 else count
        if done >= high:
            continue
        offence, vx, vy = _least_offence(
            rules, low, high, max(done, low), speed, vx, vy, scratch
        )
        offence += min(_SLACK, offence / 8)
        for i in range(low, high):
            rules[i, 2] -= offence
        done, wx, wy = _best(rules, count, speed, tx, ty, False)
        # The rules before `high` can be obeyed now, but for rounding.
        if done >= high:
            vx = wx
            vy = wy
    return vx, vy
