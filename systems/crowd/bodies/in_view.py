"""Adapts the commands of people to the people and robots in their view.

People follow others, let others out of narrow passages, and pass robots.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.crowd.bodies.passing_robots import pass_robots
from hunav_drake.systems.crowd.bodies.taking_turns import take_turns
from hunav_drake.systems.crowd.bodies.time_gap import keep_time_gap
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import changed_to, plain
from hunav_drake.systems.world.obstacles import Obstacles

# Of floats, or of scalars with derivatives.
Array = NDArray[Any]


class InView:
    """Adapts the commands of people to those ahead of them.

    Arrays may be of floats, or of AutoDiffXd; changed values have no
    derivatives.

    Attributes:
        time_gap: The time gap to the person ahead, in seconds; 0 for none.
        speed_matching: The share of the speed of the person ahead that is
            added to the speed that the time gap allows.
        takes_turns: Whether people let others out of narrow passages: if
            bodies are kept apart and out of walls, and routes are planned.
    """

    def __init__(self, obstacles: Obstacles, config: CrowdConfig) -> None:
        """Constructs an InView."""
        model = config.model
        self.time_gap, self.speed_matching = (
            getattr(model, name) if model.follows else 0.0
            for name in ("time_gap", "speed_matching")
        )
        self._robot_gap = config.robot_gap
        self.takes_turns = (
            config.keep_apart
            and config.keep_out_of_walls
            and config.route_planning
            and len(obstacles) > 0
        )
        self._table = obstacles.table

    def passes(self, robots: Array) -> bool:
        """Returns whether there are robots for which people walk aside."""
        return self._robot_gap > 0 and len(robots) > 0

    def take_turns(
        self,
        states: Array,
        bodies: NDArray[np.float64],
        command: Array,
        parameters: NDArray[np.float64],
        eased: Array,
    ) -> tuple[Array, Array]:
        """Returns commands and `Snapshot.at_walls` at narrow passages.

        See `taking_turns.take_turns`.
        """
        if not self.takes_turns:
            return command, eased
        wanted = take_turns(
            *(plain(states), bodies, plain(command), parameters),
            *(eased, self._table),
        )
        return _told(command, *wanted)

    def follow(
        self,
        states: Array,
        bodies: NDArray[np.float64],
        command: Array,
        parameters: NDArray[np.float64],
        eased: Array,
    ) -> tuple[Array, Array]:
        """Returns commands and `Snapshot.at_walls` in view of other people.

        See `keep_time_gap`.
        """
        wanted = keep_time_gap(
            *(plain(states), bodies, plain(command), parameters, eased),
            *(self.time_gap, self.speed_matching),
        )
        return _told(command, *wanted)

    def pass_robots(
        self,
        states: Array,
        bodies: NDArray[np.float64],
        command: Array,
        goals: Array,
        parameters: NDArray[np.float64],
        robots: Array,
        eased: Array,
    ) -> tuple[Array, Array]:
        """Returns commands and `Snapshot.at_walls` in view of robots.

        See `pass_robots`.
        """
        wanted = pass_robots(
            *(plain(states), bodies, plain(command), plain(goals), parameters),
            *(plain(robots), eased, self._table, self._robot_gap),
        )
        return _told(command, *wanted)


def _told(
    command: Array, wanted: NDArray[np.float64], felt: NDArray[np.float64]
) -> tuple[Array, Array]:
    """Returns a command changed to the wanted one, and `felt`, read-only."""
    felt.setflags(write=False)
    return changed_to(command, wanted), felt
