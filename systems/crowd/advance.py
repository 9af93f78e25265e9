"""What models of motion that choose velocities, or give forces, share."""

from collections.abc import Callable
import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.social_force import kernel


def advance_people(snapshot: Snapshot, forces: NDArray[Any]) -> Array:
    """Returns where forces bring people in one step, if they obey.

    They keep the speed limit, stand still and turn as their commands say: see
    `layout.Command`. A model of motion may have this for its ``advance``.

    Args:
        snapshot: How things stand.
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
    """Returns what the kernel of a model that chooses velocities gives.

    Args:
        kernel: Takes a snapshot part by part, and the fields of the model.
        snapshot: How things stand.
        model: A dataclass of numbers.

    Returns:
        Shape (n, FORCES_SIZE), in m/s^2: the total, and zeros.
    """
    return kernel(
        snapshot.states,
        snapshot.radii,
        snapshot.command,
        snapshot.parameters,
        snapshot.robots,
        snapshot.at_walls,
        snapshot.obstacles.table,
        snapshot.obstacle_range,
        snapshot.time_step,
        np.array(dataclasses.astuple(model), dtype=float),
    )
