"""What the walls of a world do to people, beside pushing them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.walls.keep_out import (
    keep_out_of_walls,
    wall_derivatives,
    wall_margins,
)
from hunav_drake.systems.crowd.walls.passages import ease
from hunav_drake.systems.people.parameters import K_OBSTACLE
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.routes import RouteMap, route_clearance

Array = NDArray[Any]


class Room:
    """Leads people around and between walls, and keeps them out of walls.

    Arrays may be of floats or of AutoDiffXd. Nothing here changes after the
    construction, but for what is remembered about goals asked for before.
    """

    def __init__(
        self,
        obstacles: Obstacles,
        radii: NDArray[np.float64],
        config: CrowdConfig,
        *,
        margin: float = 0.0,
    ) -> None:
        """Constructs a Room.

        Args:
            obstacles: The walls.
            radii: Shape (n,), those of the people, in meters.
            config: What it does, and how far walls are felt.
            margin: What the model of motion keeps between bodies and walls,
                in meters.
        """
        walled = len(obstacles) > 0 and len(radii) > 0
        self._obstacles = obstacles
        self._radii = radii
        self._margin = margin
        self._reach = (config.obstacle_range, config.max_obstacles)
        self._walls = (
            (wall_margins(radii), obstacles.table)
            if config.keep_out_of_walls and walled
            else None
        )
        self._routes = (
            RouteMap.from_obstacles(obstacles, clearance=route_clearance(radii))
            if config.route_planning and walled
            else None
        )

    def guide(self, states: Array, command: Array) -> Array:
        """Returns the commands (n, COMMAND_SIZE) with waypoints for goals."""
        if self._routes is None:
            return command
        if states.dtype != object:
            return self._routes.guide(states, command)
        values = _plain(command)
        guided = self._routes.guide(_plain(states), values)
        # A waypoint does not move when people or goals do.
        changed = guided != values
        command = command.copy()
        command[changed] = [AutoDiffXd(value) for value in guided[changed]]
        return command

    def ease(
        self, states: Array, command: Array, parameters: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Returns with what radii, and how hard, people feel the walls.

        Those of their own, unless ways are planned and somebody is in a
        narrow passage: see `passages.ease`. What is eased has no derivatives.

        Args:
            states: Shape (n, 6).
            command: Shape (n, COMMAND_SIZE).
            parameters: Shape (n, 13): the fields of SocialForceParameters.

        Returns:
            Shape (n, 2), in meters and m/s^2, read-only.
        """
        eased = np.empty((len(self._radii), 2))
        eased[:, 0] = self._radii
        eased[:, 1] = parameters[:, K_OBSTACLE]
        if self._routes is not None:
            if states.dtype == object:
                states, command = _plain(states), _plain(command)
            eased = ease(
                *(states, command, eased, parameters),
                *(self._margin, 2 * self._routes.sight),
                *(self._obstacles.table, *self._reach),
            )
        eased.setflags(write=False)
        return eased

    def keep_out(self, before: Array, after: Array) -> Array:
        """Returns the states (n, 6) after a step that enters no wall."""
        if self._walls is None:
            return after
        if after.dtype != object:
            kept: Array = keep_out_of_walls(before, after, *self._walls)
            return kept
        p, q = _plain(before), _plain(after)
        kept = keep_out_of_walls(p, q, *self._walls)
        slopes = wall_derivatives(p, q, *self._walls)
        result = after.copy()
        for i in np.flatnonzero((kept != q).any(axis=1)):
            both = ExtractGradient(np.hstack([before[i], after[i]]))
            result[i] = InitializeAutoDiff(
                kept[i][:, None], slopes[i] @ both
            ).ravel()
        return result

    def chain(self, derivatives: Array, before: Array, after: Array) -> None:
        """Makes derivatives of a step those of the step that is kept out.

        Args:
            derivatives: Shape (6n, 6n or more), by the states before, and
                more; changed in place.
            before: Shape (n, 6), the states.
            after: Shape (n, 6), where the step leads without walls.
        """
        if self._walls is None:
            return
        slopes = wall_derivatives(before, after, *self._walls)
        for i, slope in enumerate(slopes):
            own = slice(6 * i, 6 * i + 6)
            derivatives[own] = slope[:, 6:] @ derivatives[own]
            derivatives[own, own] += slope[:, :6]


def _plain(scalars: Array) -> NDArray[np.float64]:
    """Returns the values of scalars with derivatives, row by row."""
    return np.ascontiguousarray(ExtractValue(scalars))
