"""Adapts the commands of people to walls, and to people and robots ahead.

People go around and between walls, apart from their group where it does not fit
through; they let others out of narrow passages, and walk past robots. All of
that is one call of compiled code.
"""

import copy
from typing import NamedTuple, Self

import numba
from numba import float64
import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit_as,
    reads,
    rows_of,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    MOTION_SIZE,
    STATE_SIZE,
    Command,
)
from hunav_drake.systems.crowd.bodies.passing_robots import pass_robots
from hunav_drake.systems.crowd.bodies.taking_turns import take_turns
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import is_within
from hunav_drake.systems.crowd.walls.parted_groups import (
    is_grouped,
    parted,
    walking_groups,
)
from hunav_drake.systems.crowd.walls.passages import ease
from hunav_drake.systems.people.parameters import K_OBSTACLE, NUM_PARAMETERS
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap
from hunav_drake.systems.world.waypoints import guided

# The routes where none are planned.
_NO_ROUTES = RouteMap(
    Obstacles.from_shapes([], solid=[]), 0.0, np.zeros((0, 2))
)


class _Rules(NamedTuple):
    """What people adapt to; all are numbers.

    Attributes:
        planned: Whether routes are planned: 1 or 0.
        turns: Whether people let others out of narrow passages: 1 or 0.
        parts: Whether groups part: 1 or 0.
        robot_gap: The gap to robots that people pass, in meters; 0 for none.
        behind: Whether robots that come from behind count, too: 1 or 0.
        margin: See `ease`, like the next ones.
        narrowest: In meters.
        reach: In meters.
        most: A number of walls.
        turning: Whether people ease up to the waypoint where the way is too
            narrow only beyond it: 1 or 0.
    """

    planned: float
    turns: float
    parts: float
    robot_gap: float
    behind: float
    margin: float
    narrowest: float
    reach: float
    most: float
    turning: float


_rules_in = reads(_Rules)


class Adaptation:
    """What people with given bodies in a given world adapt to.

    Nothing here changes after the construction, except the cached routes.
    """

    def __init__(
        self,
        radii: Array,
        bodies: Array,
        obstacles: Obstacles,
        config: CrowdConfig,
    ) -> None:
        """Constructs an Adaptation.

        Args:
            radii: Shape (n,), the radii of people, in meters.
            bodies: Shape (n,), the radii of their bodies, in meters.
            obstacles: The walls.
            config: The configuration of the crowd.
        """
        model = config.model
        kept = radii if model.keeps_radii else bodies
        self._sizes = np.column_stack([radii, bodies, kept])
        self._table = obstacles.table
        planned = (
            config.route_planning and len(obstacles) > 0 and len(radii) > 0
        )
        routes = _NO_ROUTES
        if planned:
            clearance = route_clearance(radii)
            routes = RouteMap.from_obstacles(obstacles, clearance=clearance)
        self._routes = routes.arguments(len(radii))
        rules = _Rules(
            planned=planned,
            turns=planned and config.keep_apart and config.keep_out_of_walls,
            parts=config.groups_part,
            robot_gap=config.robot_gap,
            behind=config.robots_behind,
            margin=getattr(model, "safety_margin", 0.0),
            narrowest=2 * routes.sight,
            reach=config.obstacle_range,
            most=config.max_obstacles,
            turning=config.walls_behind_doors,
        )
        self._rules = np.array(rules, dtype=float)
        self._planned = planned
        self._passes = config.robot_gap > 0

    def of(self, rows: NDArray[np.intp]) -> Self:
        """Returns the adaptation of some of the people."""
        part = copy.copy(self)
        part._sizes = self._sizes[rows]
        return part

    def is_idle(self, robots: Array) -> bool:
        """Returns whether there are no walls and robots to adapt to."""
        return not (self._planned or (self._passes and len(robots) > 0))

    def adapt(
        self, states: Array, command: Array, robots: Array, parameters: Array
    ) -> tuple[Array, Array]:
        """Returns commands, a vector, and `Snapshot.at_walls`, (n, 2).

        The second one has no rows if a number is so large that `limited` would
        change it. Goals are the next waypoints. People who walk elsewhere than
        their group, are separated from it, or go through a door alone are in no
        group: see `parted_groups`. The radii and factors of people at walls are
        their own, unless they are in a narrow passage, or let others pass.

        The arguments are vectors: rows of states (n, 6), of commands, of
        `robot_states`, and of the weights (n, 13).
        """
        adapted: tuple[Array, Array] = _adapted(
            *(states, command, robots, parameters, self._sizes),
            *(self._table, self._rules, *self._routes),
        )
        return adapted


@jit_as(
    numba.types.Tuple((float64[::1], float64[:, ::1])),
    *(VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, WALLS, VECTOR),
    *(REAL, MATRIX, numba.int32[:, ::1], numba.int32[::1]),
    *(float64[:, ::1], numba.int64[::1], float64[:, ::1], numba.int8[:, ::1]),
    *(numba.int64[:, ::1], numba.int32[:, ::1], WALLS),
)
def _adapted(
    states_of_all,
    commands,
    robot_states,
    weights,
    sizes,
    table,
    rules,
    clearance,
    vertices,
    seen,
    counts,
    places,
    used,
    lengths,
    known,
    cells,
    hiders,
    routed_table,
):
    """Returns the result of `Adaptation.adapt`.

    Rows of `sizes` are the radii of a person, of the body, and what is kept
    clear of others, in meters; `rules` are `_Rules`; the others are the
    arguments of `guided`.
    """
    p = _rules_in(rules)
    n = len(sizes)
    states = rows_of(states_of_all, MOTION_SIZE)
    command = rows_of(commands, COMMAND_SIZE)
    robots = rows_of(robot_states, STATE_SIZE)
    parameters = rows_of(weights, NUM_PARAMETERS)
    wanted = command.copy()
    if not (is_within(states) and is_within(command) and is_within(robots)):
        return wanted.ravel(), np.empty((0, 2))
    if p.planned != 0:
        led = guided(
            *(states, command, clearance, vertices, seen, counts),
            *(places, used, lengths, known, cells, hiders, routed_table),
        )
        if len(led) > 0:
            wanted = led
    felt = np.empty((n, 2))
    for i in range(n):
        felt[i, 0] = sizes[i, 0]
        felt[i, 1] = parameters[i, K_OBSTACLE]
    if is_grouped(command):
        if p.parts != 0:
            groups = walking_groups(states, command, wanted)
            for i in range(n):
                wanted[i, Command.GROUP_ID] = groups[i]
        if p.planned != 0:
            alone = parted(states, wanted, sizes[:, 0].copy(), table)
            for i in range(n):
                if alone[i]:
                    wanted[i, Command.GROUP_ID] = -1.0
    if p.planned != 0:
        felt = ease(
            *(states, wanted, felt, parameters, p.margin, p.narrowest),
            *(table, p.reach, int(p.most), p.turning != 0),
        )
    if p.turns != 0:
        wanted, felt = take_turns(
            states, sizes[:, 2].copy(), wanted, parameters, felt, table
        )
    if p.robot_gap > 0 and len(robots) > 0:
        wanted, felt = pass_robots(
            *(states, sizes[:, 1].copy(), wanted, command, parameters),
            *(robots, felt, table, p.robot_gap, p.behind),
        )
    return wanted.ravel(), felt
