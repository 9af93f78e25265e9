"""The forces of the social force model, as NumPy functions of arrays.

Every function broadcasts, and takes and returns the x and y of vectors
separately. Positions in meters, velocities in m/s, both in W; the forces are
accelerations, in m/s^2. No finite input gives a NaN: each function states its
value where the formula has none.

The arrays may be of floats, or of scalars that carry derivatives, as Drake's
`AutoDiffXd`: arrays of objects that know `exp()`, `sqrt()`, `arctan2()` and
`value()`. Where a formula has a value but no derivative, that is zero.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.crowd.social_force.constants import (
    LEAST,
    MOST,
    SHORT,
    THETA_ZERO,
)
from hunav_drake.systems.people.parameters import SocialForceParameters

# Of floats, or of scalars with derivatives.
Array = NDArray[Any]

# The weights of one person, or arrays of them by the same names.
Parameters = SocialForceParameters | SimpleNamespace


def goal_force(
    dx: Array,
    dy: Array,
    velocity: tuple[Array, Array],
    speed: Array,
    radius: Array,
    parameters: Parameters,
) -> tuple[list[Array], tuple[Array, Array]]:
    """Returns the pull towards the goal, and the direction there.

    Helbing & Molnar 1995, eq. 2: k_d (v_desired e - v) / tau; -v / tau within
    the goal's radius, which is infinite without a goal. The goal is (dx, dy)
    from here; `speed` is the desired one.
    """
    k = parameters
    distance, ex, ey = direction(dx, dy)
    walks = distance > radius
    ex, ey = choose(walks, ex, 0.0), choose(walks, ey, 0.0)
    factor = np.where(walks, k.goal_factor, 1.0)
    force = [
        factor * (e * speed - v) / k.relaxation_time
        for e, v in zip((ex, ey), velocity, strict=True)
    ]
    return force, (ex, ey)


def pair_force(
    dx: Array, dy: Array, dvx: Array, dvy: Array, parameters: Parameters
) -> tuple[Array, Array]:
    """Returns the social force of another person, (dx, dy) from here.

    Moussaid et al. 2009, eqs. 4-6, as `lightsfm` has it. (dvx, dvy) is the own
    velocity minus the other's; the radii do not enter. It is zero where the two
    coincide, or where (dvx, dvy) cancels the direction between them.
    """
    k = parameters
    r, nx, ny = direction(dx, dy)
    size, tx, ty = direction(
        k.lambda_importance * dvx + nx, k.lambda_importance * dvy + ny
    )
    defined = (r > 0) & (size > 0)
    b = k.gamma * size
    theta = np.arctan2(
        choose(defined, tx * ny - ty * nx, 0.0),
        choose(defined, tx * nx + ty * ny, 1.0),
    )
    theta = wrap(theta + k.epsilon * b)
    theta = choose(abs(theta) >= THETA_ZERO, theta, 0.0)
    return _pair_force(r, tx, ty, b, theta, defined, k)


def hunavsim_pair_force(
    dx: Array, dy: Array, dvx: Array, dvy: Array, parameters: Parameters
) -> tuple[Array, Array]:
    """Returns the social force as the evaluator of HuNavSim computes it.

    The angle between the direction to the other and that of the interaction is
    computed with the arguments of one arctangent swapped (`sfm.py` of
    hunav_evaluator, since 2023-03), so it depends on the orientation of the
    world. The arguments are those of `pair_force`, without epsilon.
    """
    k = parameters
    r, nx, ny = direction(dx, dy)
    size, tx, ty = direction(
        k.lambda_importance * dvx + nx, k.lambda_importance * dvy + ny
    )
    theta = wrap(np.arctan2(ny, nx) - np.arctan2(tx, ty))
    defined = (r > 0) & (size > 0)
    return _pair_force(r, tx, ty, k.gamma * size, theta, defined, k)


def _pair_force(
    r: Array,
    tx: Array,
    ty: Array,
    b: Array,
    theta: Array,
    defined: Any,
    k: Parameters,
) -> tuple[Array, Array]:
    """Returns the force from the angle and the range of an interaction."""
    felt = defined & (r < LEAST * b)
    decay = -choose(felt, r, LEAST) / choose(felt, b, 1.0)
    slowing = k.n_prime * b * theta
    turning = k.n * b * theta
    strength = np.where(felt, k.social_factor, 0.0)
    ahead = -np.exp(decay - slowing * slowing)
    left = -np.sign(theta) * np.exp(decay - turning * turning)
    return (
        strength * (ahead * tx - left * ty),
        strength * (ahead * ty + left * tx),
    )


def obstacle_force(
    dx: Array, dy: Array, radius: ArrayLike, parameters: Parameters
) -> tuple[Array, Array]:
    """Returns the force of the nearest point of one wall, (dx, dy) to here.

    Helbing & Molnar 1995, eq. 4 in its exponential form; zero on that very
    point.
    """
    distance, nx, ny = direction(dx, dy)
    depth = as_scalars(radius) - distance
    exponent = depth / parameters.obstacle_sigma
    exponent = choose(exponent < MOST, exponent, MOST)
    strength = parameters.obstacle_factor * np.exp(exponent)
    return strength * nx, strength * ny


def as_scalars(array: ArrayLike) -> Array:
    """Returns an array of floats, or of the scalars with derivatives in it."""
    result = np.asarray(array)
    return result if result.dtype == object else result.astype(float)


def values(array: Array) -> NDArray[np.float64]:
    """Returns the plain numbers of an array."""
    if array.dtype != object:
        return array
    return np.array([s.value() for s in array.flat], float).reshape(array.shape)


def choose(mask: Array, array: Array, otherwise: float) -> Array:
    """Returns the array where the mask is true, and a constant elsewhere.

    Unlike that of `numpy.where`, the constant is a scalar of the same type.
    """
    if array.dtype == object and array.size:
        return np.where(mask, array, type(array.flat[0])(otherwise))
    return np.where(mask, array, otherwise)


def direction(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Returns the length of vectors, and the vectors of length one along them.

    A vector without length (less than about 1e-162) has direction zero.
    """
    square = x * x + y * y
    if square.dtype == object:
        differentiable = square >= SHORT**2
        x, y, square = (
            np.where(differentiable, part, _constants(part))
            for part in (x, y, square)
        )
    somewhere = square > 0
    # Not hypot: the kernel's has the same limit.
    length = np.sqrt(choose(somewhere, square, 1.0))
    return length * somewhere, x / length * somewhere, y / length * somewhere


def wrap(angle: Array) -> Array:
    """Returns the angles in (-pi, pi], in radians."""
    turned = angle - 2 * np.pi * np.floor(angle / (2 * np.pi) + 0.5)
    turned = np.where(turned <= -np.pi, turned + 2 * np.pi, turned)
    inside = (angle > -np.pi) & (angle <= np.pi)
    return np.where(inside, angle, turned)


def _constants(array: Array) -> Array:
    """Returns scalars of the same type and value, without derivatives."""
    constants = [type(s)(s.value()) for s in array.flat]
    result = np.empty(array.shape, dtype=object)
    result.flat = constants
    return result
