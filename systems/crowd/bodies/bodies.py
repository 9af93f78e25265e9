"""The bodies of people, which overlap neither each other nor robots."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.crowd.bodies.keep_apart import keep_apart
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.walls.keep_out import wall_margins
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[Any]

# How often pushes between bodies are improved at most, in a step.
_ITERATIONS = 200


class Bodies:
    """Keeps people's bodies apart, and off robots."""

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        obstacles: Obstacles,
        config: CrowdConfig,
    ) -> None:
        """Constructs Bodies.

        Args:
            humans: The people.
            obstacles: The walls.
            config: Whether bodies are kept apart, and walls stop people.
        """
        self._is_on = config.keep_apart and len(humans) > 0
        radii = np.array([human.radius for human in humans])
        self._sizes = np.column_stack(
            [[h.contact_radius for h in humans], wall_margins(radii)]
        )
        if not config.keep_out_of_walls:
            obstacles = Obstacles.from_shapes([], solid=[])
        self._table = obstacles.table

    def keep_apart(self, snapshot: Snapshot, after: Array) -> Array:
        """Returns the states (n, 6) after a step in which no bodies overlap."""
        if not self._is_on:
            return after
        apart: Array = keep_apart(
            snapshot.states,
            after,
            self._sizes,
            snapshot.command,
            snapshot.robots,
            self._table,
            snapshot.time_step,
            _ITERATIONS,
        )
        return apart
