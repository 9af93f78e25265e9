"""Measures of walks."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.validation.places import Area
from hunav_drake.validation.walkers import TIME_STEP, Walk

# Weidmann 1993, "Transporttechnik der Fußgänger", eq. 6: free speed in m/s,
# a constant and the jam density, both in persons/m^2.
_FREE, _GAMMA, _JAM = 1.34, 1.913, 5.4

# The distance of centers below which people touch, in meters; bodies of the
# radius of all cases are then pressed together.
CONTACT = 0.45

# The averaging time of accelerations, in seconds.
_SMOOTH = 0.2

# The width of strips for lanes, in meters.
_STRIP = 0.2

STANDARD_GRAVITY = 9.80665


def weidmann(density: ArrayLike) -> Array:
    """Returns the speed of people by Weidmann 1993, in m/s.

    Densities are positive, in persons/m^2; the speed is 0 from 5.4 on.
    """
    rho = np.asarray(density, dtype=float)
    return _FREE * -np.expm1(-_GAMMA * np.maximum(1 / rho - 1 / _JAM, 0.0))


def flow_rate(passages: Array, low: float = 0.2, high: float = 0.8) -> float:
    """Returns the flow of the middle part of a queue, in persons/s.

    Args:
        passages: The time of each passage, in seconds; infinite for people who
            never pass.
        low: The fraction of people before the measurement begins.
        high: The fraction of people at its end.

    Returns:
        The flow. If not all of this part pass, it is that of the people who
        do; 0 if fewer than two do.
    """
    n = len(passages)
    times = np.sort(passages)[math.floor(low * n) : math.ceil(high * n)]
    times = times[np.isfinite(times)]
    if len(times) < 2 or times[-1] <= times[0]:
        return 0.0
    return float((len(times) - 1) / (times[-1] - times[0]))


def peak_density(walk: Walk, area: Area, seconds: float = 1.0) -> float:
    """Returns the largest density in an area, in persons/m^2.

    Densities are averaged over a time in seconds.
    """
    counts = (area.holds(walk.states) & walk.present).sum(axis=1) / area.size
    window = min(len(counts), round(seconds / TIME_STEP))
    return float(sliding_window_view(counts, window).mean(axis=1).max())


def lane_order(states: Array, to_right: Mask) -> float:
    """Returns the order parameter of lanes along x, from 0 to 1.

    It is the mean over strips 0.2 m wide of ((n_L - n_R) / (n_L + n_R))^2.

    Args:
        states: Shape (n, 2 or more), starting with x and y; n is at least 1.
        to_right: Shape (n,), whether a person walks along x.
    """
    strips = np.floor(states[:, 1] / _STRIP).astype(int)
    strips -= strips.min()
    sides = np.where(to_right, 1.0, -1.0)
    counts = np.bincount(strips)
    sums = np.bincount(strips, weights=sides)
    taken = counts > 0
    return float(np.mean((sums[taken] / counts[taken]) ** 2))


def touches(positions: Array, distance: float = CONTACT) -> int:
    """Returns the number of contacts that begin between two people.

    Positions have the shape (k, n, 2); people touch if their centers are
    closer than `distance`. All are in meters.
    """
    first, second = np.triu_indices(positions.shape[1], k=1)
    count = 0
    before = np.ones(len(first), dtype=bool)
    for rows in positions:
        near = np.hypot(*(rows[first] - rows[second]).T) < distance
        count += int((near & ~before).sum())
        before = near
    return count


def peak_acceleration(walk: Walk) -> float:
    """Returns the largest acceleration, averaged over 0.2 s, in m/s^2."""
    # From velocities, so that a jump in position does not count twice.
    velocities = walk.states[..., 3:5]
    window = round(_SMOOTH / TIME_STEP)
    change = velocities[window:] - velocities[:-window]
    return float(np.hypot(change[..., 0], change[..., 1]).max() / _SMOOTH)


def nearest_centers(walk: Walk) -> float:
    """Returns the least distance of two centers, in meters."""
    first, second = np.triu_indices(walk.states.shape[1], k=1)
    apart = walk.states[:, first, :2] - walk.states[:, second, :2]
    return float(np.hypot(apart[..., 0], apart[..., 1]).min())
