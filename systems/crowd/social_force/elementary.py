"""exp and atan2 as polynomials, for loops that the compiler vectorizes.

Calls of the C library keep a loop scalar. These two are free of branches and
calls, so that four or eight pairs of people are computed at a time. Their
errors are those of the polynomials, proved below, and of rounding.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from hunav_drake.systems.common.kernels import jit


@intrinsic
def fused(typing_context, a, b, c):
    """Returns a b + c, rounded once; all are of one type.

    The compiler never chooses this, nor the order of sums: it would choose
    differently for the copies of a function in each of its callers, and the
    copy that runs depends on what was read from disk.
    """

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return a(a, a, a), generate


@intrinsic
def _from_bits(typing_context, bits):
    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate


@intrinsic
def _to_bits(typing_context, number):
    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


# Adding it pushes the fraction out of a double and leaves the nearest integer
# in the low bits: 1.5 * 2^52.
_ROUND = 6755399441055744.0


@jit
def exp_negative(x):
    """Returns exp(x) for x <= 0; below -700, exp(-700), which is 1e-304.

    x = k ln 2 + r with |r| <= ln(2)/2 = 0.347, and exp(r) is its Taylor
    polynomial of degree 13. The rest of the series is at most
    exp(0.347) 0.347^14 / 14! < 6e-18, relative to exp(r) >= 0.707 less than
    9e-18; rounding adds about 2e-16.
    """
    x = max(x, -700.0)
    shifted = fused(x, 1.4426950408889634, _ROUND)
    k = shifted - _ROUND
    # ln 2 in two parts; the product with the first, of few digits, is exact.
    r = fused(k, -0.6931471803691238, x)
    r = fused(k, -1.9082149292705877e-10, r)
    p = 1.6059043836821613e-10
    p = fused(p, r, 2.08767569878681e-09)
    p = fused(p, r, 2.505210838544172e-08)
    p = fused(p, r, 2.755731922398589e-07)
    p = fused(p, r, 2.7557319223985893e-06)
    p = fused(p, r, 2.48015873015873e-05)
    p = fused(p, r, 0.0001984126984126984)
    p = fused(p, r, 0.001388888888888889)
    p = fused(p, r, 0.008333333333333333)
    p = fused(p, r, 0.041666666666666664)
    p = fused(p, r, 0.16666666666666666)
    p = fused(p, r, 0.5)
    p = fused(p, r, 1.0)
    p = fused(p, r, 1.0)
    return p * _from_bits((_to_bits(shifted) + 1023) << 52)


@jit
def arctan2(y, x):
    """Returns the angle of (x, y) in [-pi, pi], in radians; not both zero.

    The angle is reduced to atan(t) with |t| <= tan(pi/8) = 0.414, and
    atan(t) / t is a polynomial of degree 12 in u = t^2, that of Chebyshev's
    interpolation on [0, 0.1716]. atan(sqrt(u)) / sqrt(u) is analytic but for
    u <= -1; on the ellipse around the interval with the sum of half-axes 24
    it is at most 2.2, so the interpolation is off by at most
    4 * 2.2 * 24^-12 / 23 < 1.1e-17 (with the coefficients below, 3e-18);
    rounding adds about 4e-16.
    """
    across = abs(y)
    along = abs(x)
    low = min(along, across)
    high = max(along, across)
    # atan(q) = pi/4 + atan((q - 1) / (q + 1))
    far = low > 0.41421356237309503 * high
    t = (low - high if far else low) / (low + high if far else high)
    u = t * t
    p = 0.015019105731390647
    p = fused(p, u, -0.03329380565677479)
    p = fused(p, u, 0.04495470654871742)
    p = fused(p, u, -0.05216337885413155)
    p = fused(p, u, 0.0587668811240347)
    p = fused(p, u, -0.06666191325975075)
    p = fused(p, u, 0.0769228025738827)
    p = fused(p, u, -0.09090908028338957)
    p = fused(p, u, 0.1111111108473435)
    p = fused(p, u, -0.14285714285326503)
    p = fused(p, u, 0.19999999999997067)
    p = fused(p, u, -0.33333333333333326)
    angle = fused(t, u * p, t)
    angle = angle + (0.7853981633974483 if far else 0.0)
    angle = 1.5707963267948966 - angle if across > along else angle
    angle = 3.141592653589793 - angle if x < 0 else angle
    return -angle if y < 0 else angle
