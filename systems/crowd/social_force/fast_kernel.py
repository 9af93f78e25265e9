"""The forces between people, compiled to vector instructions.

Three things make it fast. exp and atan2 are polynomials, so that the loop over
pairs is vectorized. When all people have the same weights, a pair is computed
once, because the force of one on the other is the opposite. And in a crowd,
pairs whose force is negligible, which are most, are found by a bound that
needs neither exp nor atan2.

The bound: with d the vector between two people, r its length, u their relative
velocity, L = |lambda u + d/r|, B = gamma L and theta the angle between the
two, the force is at most sqrt(2) k_s exp(-q) with q = r/B + (m B theta)^2,
m = min(n, n'). As |theta| >= |sin theta|, and >= pi/2 where the cosine is
negative,

    q >= r/(gamma L) + (m gamma lambda)^2 |u x d|^2 / r^2,   or
    q >= r/(gamma L) + (m gamma L pi/2)^2.

epsilon turns theta by epsilon B, so that of the second term, a^2, the rest is
max(0, a - b)^2 with b = m epsilon B^2. For any delta in (0, 1) this is at least
(1 - delta) a^2 - (1/delta - 1) b^2, and L^2 <= 2 (1 + lambda^2 |u|^2).

A pair is skipped if this is above a limit that keeps the sum of all that a
person misses below the given error. Multiplied out, the test costs one square
root; it is done in single precision, with a margin for its rounding.
"""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.common.sorting import stable_order
from hunav_drake.systems.crowd.social_force.elementary import (
    arctan2,
    exp_negative,
    fused,
)
from hunav_drake.systems.people.parameters import (
    EPSILON,
    GAMMA,
    K_SOCIAL,
    LAMBDA,
    N_PRIME,
    N,
)

# The numbers of people from which on pairs are tested, and people are sorted
# into columns first. With fewer people, the test costs more than it saves.
SKIP_FROM = 48
SORT_FROM = 1500

# The number of pairs that are computed in one go: long loops suit vectors.
_BATCH = 512

# The width of a column, in meters.
_COLUMN = 12.0

_single = np.float32


@jit
def _pair_forces(k, dx, dy, ux, uy, count, fx, fy):
    """Writes the forces (fx, fy) of others at (dx, dy) from here.

    (ux, uy) is the own velocity minus the other's, k the own parameters.
    """
    lam = k[LAMBDA]
    gamma = k[GAMMA]
    n = k[N]
    n_prime = k[N_PRIME]
    epsilon = k[EPSILON]
    strength = k[K_SOCIAL]
    for j in range(count):
        r = math.sqrt(fused(dx[j], dx[j], dy[j] * dy[j]))
        per_r = 1.0 / (r if r > 0 else 1.0)
        nx = dx[j] * per_r
        ny = dy[j] * per_r
        ix = fused(lam, ux[j], nx)
        iy = fused(lam, uy[j], ny)
        length = math.sqrt(fused(ix, ix, iy * iy))
        defined = (r > 0) & (length > 0)
        length = length if defined else 1.0
        per_length = 1.0 / length
        tx = ix * per_length
        ty = iy * per_length
        b = gamma * length
        cosine = fused(tx, nx, ty * ny) if defined else 1.0
        theta = arctan2(tx * ny - ty * nx, cosine) + epsilon * b
        turns = np.ceil(theta * (0.5 / math.pi) - 0.5)
        theta = fused(turns, -2 * math.pi, theta)
        theta = 0.0 if abs(theta) < 1e-12 else theta
        decay = -r * per_length / gamma
        spread = b * theta
        slow = n_prime * spread
        turn = n * spread
        forward = -exp_negative(fused(-slow, slow, decay))
        sideways = exp_negative(fused(-turn, turn, decay))
        sideways = -sideways if theta > 0 else sideways
        sideways = 0.0 if theta == 0.0 else sideways
        scale = strength if defined else 0.0
        fx[j] = scale * (forward * tx - sideways * ty)
        fy[j] = scale * (forward * ty + sideways * tx)


@jit
def _sum(values, lo, hi):
    """Returns the sum of values lo..hi-1."""
    total = 0.0
    even = lo + (hi - lo) // 4 * 4
    a = b = c = d = 0.0
    for j in range(lo, even, 4):
        a += values[j]
        b += values[j + 1]
        c += values[j + 2]
        d += values[j + 3]
    for j in range(even, hi):
        total += values[j]
    return (a + b) + (c + d) + total


@jit
def _mark(person, bound, x, y, vx, vy, lo, hi, marks):
    """Marks those of people lo..hi-1 whose force may not be negligible."""
    xi, yi, vxi, vyi = person
    lam, gamma2, behind, aside, turned, limit = bound
    for j in range(lo, hi):
        dx = _single(x[j] - xi)
        dy = _single(y[j] - yi)
        ux = _single(vxi - vx[j])
        uy = _single(vyi - vy[j])
        r2 = fused(dx, dx, dy * dy)
        u2 = fused(ux, ux, uy * uy)
        lam_r = lam * _single(math.sqrt(r2))
        du = fused(dx, ux, dy * uy)
        cross = fused(dx, uy, -dy * ux)
        # (L r)^2, and r times the cosine.
        length2 = fused(lam_r, fused(lam_r, u2, du + du), r2)
        ahead = fused(lam_r, du, r2)
        second = (
            behind * length2 if ahead < _single(0) else aside * cross * cross
        )
        fast = fused(lam * lam, u2, _single(1))
        left = fused(turned * fast * fast, r2, fused(limit, r2, -second))
        # A comparison with an overflowed number is false, and keeps the pair.
        far = left * left * gamma2 * length2 < r2 * r2 * r2 * r2
        skip = (left < _single(0)) | far
        marks[j - lo] = np.uint8(0) if skip else np.uint8(1)


@jit
def _bound(k, limit):
    """Returns the constants of `_mark`, with a margin for single precision."""
    m = min(k[N], k[N_PRIME])
    m2 = m * m * k[GAMMA] * k[GAMMA]
    delta = 0.02 if k[EPSILON] != 0 else 0.0
    turned = 0.0
    if delta > 0:
        b = k[EPSILON] * k[GAMMA]
        turned = 4 * m2 * b * b * (1 / delta - 1)
    keep = 0.9999 * (1 - delta)
    return (
        _single(k[LAMBDA]),
        _single(k[GAMMA] * k[GAMMA] * 1.0001),
        _single(m2 * (math.pi / 2) ** 2 * keep),
        _single(m2 * k[LAMBDA] ** 2 * keep),
        _single(turned * 1.0001),
        _single(limit * 1.0001 + 1e-3),
    )


@jit
def _limit(k, n, error):
    """Returns the exponent from which on the forces of n people are negligible.

    Their sum is then less than the error.
    """
    if error <= 0 or n < SKIP_FROM or k[K_SOCIAL] <= 0:
        return math.inf
    return max(math.log(n * math.sqrt(2.0) * k[K_SOCIAL] / error), 1.0)


@jit
def _few(states, k, result):
    """Writes the forces on a few people with equal weights, all pairs at once.

    (The arrays are separate: no compiler sees that rows of one do not overlap.)
    """
    n = len(states)
    size = n * (n - 1) // 2
    dx = np.empty(size)
    dy = np.empty(size)
    ux = np.empty(size)
    uy = np.empty(size)
    fx = np.empty(size)
    fy = np.empty(size)
    count = 0
    for i in range(n):
        for j in range(i + 1, n):
            dx[count] = states[j, 0] - states[i, 0]
            dy[count] = states[j, 1] - states[i, 1]
            ux[count] = states[i, 3] - states[j, 3]
            uy[count] = states[i, 4] - states[j, 4]
            count += 1
    _pair_forces(k, dx, dy, ux, uy, count, fx, fy)
    count = 0
    for i in range(n):
        for j in range(i + 1, n):
            result[i, 0] += fx[count]
            result[i, 1] += fy[count]
            result[j, 0] -= fx[count]
            result[j, 1] -= fy[count]
            count += 1


@jit
def alike(parameters):
    """Returns whether all people have the same weights for each other."""
    for i in range(1, len(parameters)):
        for c in range(K_SOCIAL, EPSILON + 1):
            if parameters[i, c] != parameters[0, c]:
                return False
    return True


@jit
def _columns(x, y):
    """Returns the order of people in columns of the plane, and their begins."""
    n = len(x)
    left = x.min()
    # No more columns than people, however far apart they are.
    width = max(_COLUMN, (x.max() - left) / n)
    column = np.empty(n, np.int64)
    for i in range(n):
        column[i] = math.floor((x[i] - left) / width)
    begin = np.zeros(column.max() + 2, np.int64)
    for c in column:
        begin[c + 1] += 1
    for c in range(1, len(begin)):
        begin[c] += begin[c - 1]
    order = np.empty(n, np.int64)
    filled = begin.copy()
    for i in stable_order(y):
        order[filled[column[i]]] = i
        filled[column[i]] += 1
    return order, begin, left, width


@jit_as(float64[:, ::1], MATRIX, MATRIX, REAL)
def people_forces(states, parameters, error):
    """Returns the social force (n, 2) of all other people on each, in m/s^2.

    States and parameters are those of `kernel.social_forces`. The sum of the
    neglected forces is less than the error for each person; 0 neglects none.
    """
    n = len(states)
    result = np.zeros((n, 2))
    if n < 2:
        return result
    uniform = alike(parameters)
    if uniform and n < SKIP_FROM:
        _few(states, parameters[0], result)
        return result
    sorted_up = n >= SORT_FROM and error > 0
    if sorted_up:
        order, begin, left, width = _columns(
            states[:, 0].copy(), states[:, 1].copy()
        )
    else:
        order = np.arange(n)
        begin = np.array([0, n])
        left = 0.0
        width = math.inf
    x = np.empty(n)
    y = np.empty(n)
    vx = np.empty(n)
    vy = np.empty(n)
    fastest = 0.0
    for a in range(n):
        i = order[a]
        x[a] = states[i, 0]
        y[a] = states[i, 1]
        vx[a] = states[i, 3]
        vy[a] = states[i, 4]
        fastest = max(fastest, math.hypot(states[i, 3], states[i, 4]))

    # A batch of pairs: of several people, one after the other.
    dx = np.empty(_BATCH + n)
    dy = np.empty(_BATCH + n)
    ux = np.empty(_BATCH + n)
    uy = np.empty(_BATCH + n)
    fx = np.empty(_BATCH + n)
    fy = np.empty(_BATCH + n)
    partner = np.empty(_BATCH + n + 8, np.int64)
    stop = np.zeros(n, np.int64)
    marks = np.zeros((n // 8 + 1) * 8, np.uint8)
    words = marks.view(np.uint64)
    force_x = np.zeros(n)
    force_y = np.zeros(n)
    columns = len(begin) - 1
    own = 0
    count = 0
    done = 0
    for a in range(n):
        while a >= begin[own + 1]:
            own += 1
        k = parameters[order[a]]
        limit = _limit(k, n, error)
        person = (x[a], y[a], vx[a], vy[a])
        reach = math.inf
        if sorted_up:
            speed = math.hypot(vx[a], vy[a]) + fastest
            reach = limit * k[GAMMA] * (1.0 + k[LAMBDA] * speed)
        first = count
        for c in range(own if uniform else 0, columns):
            lo = begin[c]
            hi = begin[c + 1]
            if sorted_up:
                edge = left + c * width
                gap = max(edge - x[a], x[a] - (edge + width), 0.0)
                if gap > reach:
                    if c > own:
                        break
                    continue
                across = math.sqrt(max(reach * reach - gap * gap, 0.0))
                hi = lo + np.searchsorted(y[lo:hi], y[a] + across, "right")
                lo = lo + np.searchsorted(y[lo:hi], y[a] - across)
            if uniform and c == own:
                lo = max(lo, a + 1)
            size = hi - lo
            if size <= 0:
                continue
            if limit == math.inf:
                for j in range(lo, hi):
                    partner[count] = j
                    count += j != a
                continue
            _mark(person, _bound(k, limit), x, y, vx, vy, lo, hi, marks)
            if lo <= a < hi:
                marks[a - lo] = 0
            used = (size + 7) // 8
            marks[size : used * 8] = 0
            for w in range(used):
                if words[w] != 0:
                    for b in range(8 * w, 8 * w + 8):
                        partner[count] = lo + b
                        count += marks[b]
        for b in range(first, count):
            j = partner[b]
            dx[b] = x[j] - x[a]
            dy[b] = y[j] - y[a]
            ux[b] = vx[a] - vx[j]
            uy[b] = vy[a] - vy[j]
        stop[a] = count
        if count >= _BATCH or a == n - 1 or not uniform:
            _pair_forces(k, dx, dy, ux, uy, count, fx, fy)
            first = 0
            for i in range(done, a + 1):
                force_x[i] += _sum(fx, first, stop[i])
                force_y[i] += _sum(fy, first, stop[i])
                first = stop[i]
            if uniform:
                for b in range(count):
                    force_x[partner[b]] -= fx[b]
                    force_y[partner[b]] -= fy[b]
            count = 0
            done = a + 1
    for a in range(n):
        result[order[a], 0] = force_x[a]
        result[order[a], 1] = force_y[a]
    return result
