"""Functions that motion models of velocities or of forces share."""

from collections.abc import Callable
import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.social_force import kernel


def advance_people(snapshot: Snapshot, forces: NDArray[Any]) -> Array:
    """Returns the states of people after one step under forces.

    Their commands give speed limits, standing still and turns: see
    `layout.Command`. A motion model may use this as its ``advance``.

    Args:
        snapshot: The present state of the world.
        forces: Shape (n, FORCES_SIZE): see `layout.FORCES`; the total counts.

    Returns:
        Shape (n, 6), like ``snapshot.states``.
    """
    states: Array = kernel.advance(
        np.ascontiguousarray(snapshot.states, dtype=float),
        np.ascontiguousarray(forces, dtype=float),
        snapshot.command,
        snapshot.time_step,
    )
    return states


def chosen_accelerations(
    kernel: Callable[..., NDArray[np.float64]], snapshot: Snapshot, model: Any
) -> NDArray[np.float64]:
    """Returns the accelerations that the kernel of a velocity model gives.

    It takes a snapshot part by part, and the fields of the model, which are
    numbers. The shape is (n, FORCES_SIZE), in m/s^2: the total, and zeros.
    """
    return kernel(
        *snapshot.as_arguments[:-1],
        snapshot.time_step,
        np.array(dataclasses.astuple(model), dtype=float),
    )
