"""The rules that velocities must obey, to avoid discs and walls.

A rule is a row (nx, ny, b): velocities v with n . v >= b are allowed.
"""

import math

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import runs_in

# Velocities, in m/s, and distances, in m, that give no direction.
_TINY = 1e-9


@jit
def avoid_disc(rule, ex, ey, own, vx, vy, reach, share, horizon, recovery):
    """Writes the rule (nx, ny, b) to avoid a disc; returns whether it exists.

    The disc is at (ex, ey) from the person, whose velocity relative to it is
    (vx, vy). The person does a share of the avoiding. They must not touch
    within the horizon; if they touch already, they separate in the recovery
    time. There is no rule for a disc at the same position and velocity.
    """
    d2 = ex * ex + ey * ey
    apart = d2 > reach * reach
    time = horizon if apart else recovery
    # From the center of the disc that cuts off the cone of velocities.
    wx = vx - ex / time
    wy = vy - ey / time
    w = math.hypot(wx, wy)
    ahead = wx * ex + wy * ey
    cap = ahead < 0 and ahead * ahead > reach * reach * w * w
    if cap or not apart:
        if w < _TINY:
            return False
        nx = wx / w
        ny = wy / w
        change = reach / time - w
    else:
        leg = math.sqrt(d2 - reach * reach)
        if ex * wy - ey * wx > 0:
            nx = -(ex * reach + ey * leg) / d2
            ny = (ex * leg - ey * reach) / d2
        else:
            nx = (ey * leg - ex * reach) / d2
            ny = -(ex * leg + ey * reach) / d2
        change = -(nx * vx + ny * vy)
    rule[0] = nx
    rule[1] = ny
    rule[2] = nx * own[0] + ny * own[1] + share * change
    return True


@jit
def avoid_walls(rules, x, y, reach, speed, walls, sight, horizon, step):
    """Writes the rules by which a person avoids walls; returns their number.

    Each segment lies behind the line through its point nearest to the person,
    whose approach to that line is limited. Standing is allowed. A person who
    touches a wall comes off it in a step.
    """
    sight = min(sight, reach + speed * horizon)
    edge = sight + 1e-12 * (abs(x) + abs(y) + sight)
    runs = runs_in(x - edge, y - edge, x + edge, y + edge, walls)
    count = 0
    for i in range(len(runs)):
        for s in range(walls.runs[runs[i], 0], walls.runs[runs[i], 1]):
            px, py, d2 = nearest_on_segments(x, y, walls.segments, s, s + 1)
            if d2 > sight * sight:
                continue
            distance = math.sqrt(d2)
            if distance < _TINY:
                continue
            gap = distance - reach
            rules[count, 0] = (x - px) / distance
            rules[count, 1] = (y - py) / distance
            rules[count, 2] = -gap / (horizon if gap > 0 else step)
            count += 1
    return count
