"""The forces of the social force model, as NumPy functions of arrays.

Every function broadcasts over leading dimensions; vectors have shape
(..., 2). Positions in meters, velocities in m/s, both in W; the forces are
accelerations, in m/s^2. No finite input gives a NaN: each function says what
it gives where the formula has no value.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.crowd.parameters import SocialForceParameters

Array = NDArray[np.float64]

# Angles smaller than this are rounding noise of an exact head-on encounter.
THETA_ZERO = 1e-12


def pair_force(
    p_from: ArrayLike,
    p_to: ArrayLike,
    v_from: ArrayLike,
    v_to: ArrayLike,
    parameters: SocialForceParameters,
) -> Array:
    """Returns the social force on one pedestrian from another.

    Moussaid et al. 2009, eqs. 4-6, as `lightsfm` has it. The radii do not
    enter.

    Args:
        p_from: Where the pedestrian is that feels the force.
        p_to: Where the other one is.
        v_from: The velocity of the one that feels the force.
        v_to: The velocity of the other.
        parameters: The weights of the one that feels the force.

    Returns:
        The force; zero where the two coincide, or where their relative
        velocity cancels the direction between them.
    """
    d = np.asarray(p_to, dtype=float) - np.asarray(p_from, dtype=float)
    dv = np.asarray(v_from, dtype=float) - np.asarray(v_to, dtype=float)
    r = _norm(d)
    n = d / np.where(r > 0, r, 1.0)[..., None]
    interaction = parameters.lambda_importance * dv + n
    length = _norm(interaction)
    defined = (r > 0) & (length > 0)
    length = np.where(defined, length, 1.0)
    t = interaction / length[..., None]
    b = parameters.gamma * length
    cross = t[..., 0] * n[..., 1] - t[..., 1] * n[..., 0]
    dot = t[..., 0] * n[..., 0] + t[..., 1] * n[..., 1]
    theta = np.arctan2(cross, dot) + parameters.epsilon * b
    theta = theta - 2 * np.pi * np.ceil(theta / (2 * np.pi) - 0.5)
    theta = np.where(np.abs(theta) < THETA_ZERO, 0.0, theta)
    slow = -np.exp(-r / b - (parameters.n_prime * b * theta) ** 2)
    turn = -np.sign(theta) * np.exp(-r / b - (parameters.n * b * theta) ** 2)
    strength = np.where(defined, parameters.social_factor, 0.0)
    left = np.stack([-t[..., 1], t[..., 0]], axis=-1)
    force: Array = strength[..., None] * (
        slow[..., None] * t + turn[..., None] * left
    )
    return force


def obstacle_force(
    p: ArrayLike,
    p_wall: ArrayLike,
    radius: ArrayLike,
    parameters: SocialForceParameters,
) -> Array:
    """Returns the force of the nearest point of one wall on a pedestrian.

    Helbing & Molnar 1995, eq. 4 in its exponential form.

    Args:
        p: Where the pedestrian is.
        p_wall: The nearest point of the wall.
        radius: The radius of the pedestrian, in meters.
        parameters: The weights of the pedestrian.

    Returns:
        The force; zero for a pedestrian on that very point.
    """
    d = np.asarray(p, dtype=float) - np.asarray(p_wall, dtype=float)
    distance = _norm(d)
    away = d / np.where(distance > 0, distance, 1.0)[..., None]
    depth = np.asarray(radius, dtype=float) - distance
    strength = parameters.obstacle_factor * np.exp(
        depth / parameters.obstacle_sigma
    )
    force: Array = np.asarray(strength)[..., None] * away
    return force


def _norm(vector: Array) -> Array:
    # Not hypot: like the kernel's, this is zero for coincident points only to
    # within 1e-160 m.
    length: Array = np.sqrt(vector[..., 0] ** 2 + vector[..., 1] ** 2)
    return length
