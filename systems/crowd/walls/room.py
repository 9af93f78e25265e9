"""The routes of people among the walls of a world, and their radii at walls."""

import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import changed_to, plain
from hunav_drake.systems.crowd.walls.parted_groups import parted, walking_groups
from hunav_drake.systems.crowd.walls.passages import ease
from hunav_drake.systems.people.parameters import K_OBSTACLE
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap

Array = NDArray[Any]


class Room:
    """Leads people around and between walls.

    Arrays may be of floats or of AutoDiffXd. Nothing here changes after the
    construction, except the cached routes.
    """

    def __init__(
        self,
        obstacles: Obstacles,
        radii: NDArray[np.float64],
        config: CrowdConfig,
        *,
        margin: float = 0.0,
    ) -> None:
        """Constructs a Room; `margin` is the model's wall clearance, in m."""
        walled = len(obstacles) > 0 and len(radii) > 0
        self._obstacles = obstacles
        self._radii = radii
        self._margin = margin
        self._groups_part = config.groups_part
        self._reach = (config.obstacle_range, config.max_obstacles)
        self._routes = (
            RouteMap.from_obstacles(obstacles, clearance=route_clearance(radii))
            if config.route_planning and walled
            else None
        )

    def of(self, rows: NDArray[np.intp]) -> Self:
        """Returns the room for some of the people."""
        part = copy.copy(self)
        part._radii = self._radii[rows]
        return part

    def guide(self, states: Array, command: Array) -> Array:
        """Returns the commands of people, adapted to the walls.

        Their goals are the next waypoints. People who walk elsewhere than
        their group, are separated from it, or go through a door alone are in
        no group: see `parted_groups`.
        """
        values = plain(command)
        grouped = bool((values[:, Command.GROUP_ID] >= 0).any())
        if self._routes is None and not (grouped and self._groups_part):
            return command
        guided = self._guide(plain(states), values, grouped)
        # (A waypoint does not move when people or goals do.)
        return changed_to(command, guided)

    def _guide(self, states: Array, command: Array, grouped: bool) -> Array:
        guided = command
        if self._routes is not None:
            guided = self._routes.guide(states, command)
        if not grouped:
            return guided
        guided = guided.copy()
        if self._groups_part:
            guided[:, Command.GROUP_ID] = walking_groups(
                states, command, guided
            )
        if self._routes is not None:
            alone = parted(states, guided, self._radii, self._obstacles.table)
            guided[alone, Command.GROUP_ID] = -1
        return guided

    @property
    def leads(self) -> bool:
        """Whether routes are planned: else `ease` has no effect."""
        return self._routes is not None

    def ease(
        self, states: Array, command: Array, parameters: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Returns the radii and obstacle factors of people at walls, (n, 2).

        They are their own, unless routes are planned and a person is in a
        narrow passage: see `passages.ease`. They are read-only, and have no
        derivatives.
        """
        eased = np.empty((len(self._radii), 2))
        eased[:, 0] = self._radii
        eased[:, 1] = parameters[:, K_OBSTACLE]
        if self._routes is not None:
            if states.dtype == object:
                states, command = plain(states), plain(command)
            eased = ease(
                *(states, command, eased, parameters),
                *(self._margin, 2 * self._routes.sight),
                *(self._obstacles.table, *self._reach),
            )
        eased.setflags(write=False)
        return eased
