"""The bodies of people: how they stand, turn, speed up and touch."""

from collections.abc import Sequence
import copy
import math
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from hunav_drake.systems.common.layout import (
    MOTION_SIZE,
    RADIUS,
    STATE_SIZE,
    YAW,
)
from hunav_drake.systems.crowd.bodies.contacts import deepest, robot_touches
from hunav_drake.systems.crowd.bodies.finish import Options, for_each_robot
from hunav_drake.systems.crowd.bodies.keep_apart import keep_apart, would_meet
from hunav_drake.systems.crowd.bodies.rate_limits import limit_rates
from hunav_drake.systems.crowd.bodies.standing import stand
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import lifted, plain
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.walls.keep_out import (
    keep_out_of_walls,
    wall_margins,
)
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[Any]

# The largest number of iterations of the pushes between bodies: in a step, and
# for its derivatives, which need more digits.
ITERATIONS, _MANY = 200, 20000

# The depth of a robot in a body at which the person gives way, if bodies stop
# robots, in meters. On the springs that move people in a plant this is 250 N.
_YIELDING_DEPTH = 0.0025

# `keep_apart` finds pairs itself.
_NO_PAIRS = np.empty((0, 2), np.int64)

# The half width of central differences, in meters, radians and SI units.
_DIFFERENCE = 1e-6


class _Slopes(NamedTuple):
    """The derivatives of the correction of a step by bodies.

    They are those of `rows`, k of n people (the others move as proposed), by
    their states before and proposed, (6k, 6k), and by the robots, (6k, 7m).
    """

    rows: NDArray[np.intp]
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    robots: NDArray[np.float64]


class Bodies:
    """Limits the motion of people in a step to what bodies allow.

    People who want to stand do, velocities and headings change gradually, and
    nobody enters a wall or another body. Arrays may be of floats or of
    AutoDiffXd. Nothing here changes after the construction.

    Attributes:
        radii: Shape (n,), the radii of the bodies, in meters; read-only.
        sizes: Shape (n, 2): see `finish`.
        options: See there, too.
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        obstacles: Obstacles,
        config: CrowdConfig,
    ) -> None:
        """Constructs Bodies."""
        self.radii = np.array([human.contact_radius for human in humans])
        self.radii.setflags(write=False)
        self.sizes = np.column_stack([self.radii, wall_margins(self.radii)])
        self._is_walled = config.keep_out_of_walls and len(obstacles) > 0
        self._table = obstacles.table
        acceleration, turn_rate = (
            math.inf if limit is None else limit
            for limit in (config.max_acceleration, config.max_turn_rate)
        )
        self.options = Options(
            standing=float(config.standing),
            keep_apart=float(config.keep_apart),
            acceleration=acceleration,
            turn_rate=turn_rate,
            walled=float(self._is_walled),
        )
        self._robots_stop = bool(config.robots_stop)
        is_limited = math.isfinite(min(acceleration, turn_rate))
        self._is_on = len(humans) > 0 and (
            config.standing
            or config.keep_apart
            or self._is_walled
            or is_limited
        )

    def of(self, rows: NDArray[np.intp]) -> Self:
        """Returns the bodies of some of the people."""
        part = copy.copy(self)
        part.radii = self.radii[rows]
        part.radii.setflags(write=False)
        part.sizes = self.sizes[rows]
        return part

    def finish(
        self, snapshot: Snapshot, forces: Array, after: Array, stances: Array
    ) -> tuple[Array, Array, NDArray[np.float64]]:
        """Returns the states and stances of people at the end of a step.

        Args:
            snapshot: The state of the world at its start.
            forces: Shape (n, FORCES_SIZE).
            after: Shape (n, 6), the states that the motion model proposes.
            stances: Shape (n, 3): see `standing`.

        Returns:
            The states, shape (n, 6), the stances, and the touches of robots,
            shape (mn, 2): see `robot_touches`. Only the states have
            derivatives, in which forces count as constant for people who
            stand.
        """
        if after.dtype != object:
            return self._finish(snapshot, forces, after, stances)
        values = _plain_snapshot(snapshot)
        arguments = values, plain(forces), plain(after), plain(stances)
        states, held, touches = self._finish(*arguments)
        if not self._is_on:
            return after, stances, touches
        slopes = self._slopes(*arguments)
        result = after.copy()
        if len(slopes.rows) > 0:
            inputs = np.concatenate(
                [
                    snapshot.states[slopes.rows].ravel(),
                    after[slopes.rows].ravel(),
                    snapshot.robots.ravel(),
                ]
            )
            gradient = np.einsum(
                "ij,jk->ik",
                np.hstack([slopes.before, slopes.after, slopes.robots]),
                ExtractGradient(inputs),
            )
            column = states[slopes.rows].reshape(-1, 1)
            result[slopes.rows] = InitializeAutoDiff(column, gradient).reshape(
                -1, MOTION_SIZE
            )
        return result, lifted(held), touches

    def overlaps(
        self, states: NDArray[np.float64], robots: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Returns the depths of other bodies in people's: see `deepest`."""
        depths: NDArray[np.float64] = deepest(states, self.radii, robots)
        return depths

    def chain(
        self,
        derivatives: Array,
        snapshot: Snapshot,
        forces: Array,
        after: Array,
        stances: Array,
    ) -> None:
        """Makes derivatives of the proposed step those of the finished one.

        They have the shape (6n, 6n + 7m), by the states before and those of the
        robots, and change in place. The other arguments are those of `finish`.
        """
        if not self._is_on:
            return
        slopes = self._slopes(snapshot, forces, after, stances)
        own = (
            MOTION_SIZE * slopes.rows[:, None] + np.arange(MOTION_SIZE)
        ).ravel()
        derivatives[own] = np.einsum(
            "ij,jk->ik", slopes.after, derivatives[own]
        )
        derivatives[np.ix_(own, own)] += slopes.before
        derivatives[own, snapshot.states.size :] += slopes.robots

    def _finish(
        self,
        snapshot: Snapshot,
        forces: Array,
        after: Array,
        stances: Array,
        iterations: int = ITERATIONS,
    ) -> tuple[Array, Array, NDArray[np.float64]]:
        # Like `finish`, but only the functions needed here are compiled.
        before, command = snapshot.states, snapshot.command
        time_step = snapshot.time_step
        robots = self._as_met(snapshot.robots)
        options = self.options
        stances = stances.copy()
        after = after.copy()
        if options.standing:
            stand(before, after, forces, command, stances, time_step)
        limits = options.acceleration, options.turn_rate
        if options.standing or min(limits) < math.inf:
            limit_rates(before, after, command, *limits, time_step)
        margins = self.sizes[:, 1].copy()
        if self._is_walled:
            after = keep_out_of_walls(before, after, margins, self._table)
        free = for_each_robot(after, len(robots))
        if options.keep_apart and would_meet(
            before, after, self.sizes, robots, self._robots_stop, time_step
        ):
            keep_apart(
                *(before, after, self.sizes, command, robots, self._table),
                *(self._is_walled, self._robots_stop, time_step, iterations),
                *(_NO_PAIRS, -1.0, free),
            )
            if self._is_walled:
                after = keep_out_of_walls(before, after, margins, self._table)
        return (
            after,
            stances,
            robot_touches(before, free, self.radii, robots, time_step),
        )

    def _as_met(self, robots: Array) -> Array:
        """Returns the robots (m, 7) that people make way for in a step."""
        if not self._robots_stop:
            return robots
        # Nobody gives way before a push.
        met = robots.copy()
        met[:, RADIUS] = np.maximum(met[:, RADIUS] - _YIELDING_DEPTH, 0.0)
        return met

    def _slopes(
        self, snapshot: Snapshot, forces: Array, after: Array, stances: Array
    ) -> _Slopes:
        """Returns the derivatives of `finish`, by central differences.

        They are good to 1e-7 between the steps where the result has a kink.
        """
        finished, *_ = self._finish(snapshot, forces, after, stances, _MANY)
        rows = np.flatnonzero((finished != after).any(axis=1))
        inputs = [snapshot.states.copy(), after.copy(), snapshot.robots.copy()]

        def columns(which: int, people: Array, size: int) -> Array:
            """Returns the derivatives by rows of one of the inputs."""
            result = np.empty((MOTION_SIZE * len(rows), len(people) * size))
            for at, (i, c) in enumerate(np.ndindex(len(people), size)):
                place = (people[i], c)
                kept = inputs[which][place]
                ends = []
                for change in (-_DIFFERENCE, _DIFFERENCE):
                    inputs[which][place] = kept + change
                    states, moved, robots = inputs
                    end, *_ = self._finish(
                        snapshot._replace(states=states, robots=robots),
                        *(forces, moved, stances, _MANY),
                    )
                    ends.append(end[rows])
                inputs[which][place] = kept
                slope = ends[1] - ends[0]
                slope[:, YAW] = (
                    np.remainder(slope[:, YAW] + math.pi, 2 * math.pi) - math.pi
                )
                result[:, at] = (slope / (2 * _DIFFERENCE)).ravel()
            return result

        return _Slopes(
            rows,
            columns(0, rows, MOTION_SIZE),
            columns(1, rows, MOTION_SIZE),
            columns(2, np.arange(len(snapshot.robots)), STATE_SIZE),
        )


def _plain_snapshot(snapshot: Snapshot) -> Snapshot:
    """Returns a snapshot without derivatives."""
    return snapshot._replace(
        states=plain(snapshot.states),
        command=plain(snapshot.command),
        robots=plain(snapshot.robots),
    )
