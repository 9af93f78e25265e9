"""The LeafSystem of people's random decisions."""

from collections.abc import Sequence
import math

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    STATE_SIZE,
    Command,
    Hold,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.common.random_streams import Purpose, draw_normal
from hunav_drake.systems.common.sampling import Sampling
from hunav_drake.systems.crowd.decisions_config import DecisionsConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap

# Where a wall is in the way of a turned goal, one this far beyond the goal
# radius is tried, in meters.
_AHEAD = 2.0

_GOAL = slice(Command.GOAL_X, Command.GOAL_Y + 1)


class HumanDecisions(Sampling, LeafSystem):
    """Turns the ways of people by random angles.

    .. pydrake_system::

        name: HumanDecisions
        input_ports:
        - human_states
        - commands
        output_ports:
        - commands
        - headings

    It stands between the behaviors of people and their crowd, so that a trial
    goes on differently with another seed, also from the middle. Ports
    ``human_states`` and ``commands`` take n rows as those of a `HumanCrowd`.
    Output ``commands`` gives the same n commands, with the goals of people who
    walk turned about their positions by the angles of port ``headings``, n
    numbers in radians, counterclockwise. Nothing else changes: people without a
    goal, or at their goal, who hold still, are placed (seats) or are outside
    keep their commands.

    Every ``config.period``, beginning at time 0, each person decides on an
    angle: `rho` times the one before plus sqrt(1 - rho^2) times a draw from the
    normal distribution of deviation `sigma_heading`, which is then the
    deviation of the angles, too. Draws follow from the seed, the person's
    number and the number of the decision alone.

    With routes, the way that is turned leads to the next waypoint around walls.
    If a wall is in the way of the turned goal, the goal is on the same ray, 2 m
    beyond the goal radius at most; if one is in the way of that, too, the
    person keeps to the way of its behavior. So angles lead nobody to another
    room.

    For the state see `Sampling`: a sample holds the angles. The seed is a
    parameter of the Context: after `SetSeed`, the trial is the same until the
    next decision, and then another one.
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        config: DecisionsConfig | None = None,
        *,
        obstacles: Obstacles | None = None,
        time_step: float = 0.05,
        seed: int = 0,
    ) -> None:
        """Constructs HumanDecisions.

        Args:
            humans: The people, in the order of the ports.
            config: The period and the size of decisions.
            obstacles: The walls around which people plan their routes; none if
                they plan none.
            time_step: The time between two steps, in seconds.
            seed: The seed of the default Context, in [0, 2^63).

        Raises:
            ValueError: If the seed is not such a number, or the period not a
                multiple of ``time_step``.
        """
        super().__init__()
        config = config or DecisionsConfig()
        self._ids = people_ids(humans)
        self._rho = config.rho
        self._sigma = config.sigma_heading
        self._redraws = [
            (math.ceil(time / config.period - 1e-6), branch)
            for time, branch in config.redraws
        ]
        self._routes = None
        if obstacles is not None and len(obstacles) and humans:
            clearance = route_clearance([human.radius for human in humans])
            self._routes = RouteMap.from_obstacles(
                obstacles, clearance=clearance
            )
        n = len(humans)
        self._human_states = self.DeclareVectorInputPort(
            "human_states", n * STATE_SIZE
        )
        self._commands = self.DeclareVectorInputPort(
            "commands", n * COMMAND_SIZE
        )
        self._DeclareSampling(
            np.zeros(n),
            period=config.period,
            time_step=time_step,
            seed=seed,
            number=0,
        )
        follows = {*(self.xd_ticket(), self.pn_ticket(), self.time_ticket())}
        self._samples = self.DeclareVectorOutputPort(
            "headings", n, self._CalcSample, prerequisites_of_calc=follows
        )
        self.DeclareVectorOutputPort(
            "commands",
            n * COMMAND_SIZE,
            self._CalcCommands,
            prerequisites_of_calc={*follows, self.all_input_ports_ticket()},
        )

    def _Measure(self, context: Context, held: Array, number: int) -> Array:
        branch = 0
        for first, redrawn in self._redraws:
            if first <= number:
                branch = redrawn
        draws = draw_normal(
            self.GetSeed(context),
            self._ids,
            Purpose.DECISION,
            1,
            step=number,
            branch=branch,
        ).ravel()
        if held[-1] < 0:
            return self._sigma * draws
        news = self._sigma * math.sqrt(1 - self._rho**2)
        return self._rho * held[:-1] + news * draws

    def _CalcCommands(self, context: Context, output: BasicVector) -> None:
        states = self._human_states.Eval(context).reshape(-1, STATE_SIZE)
        command = self._commands.Eval(context).reshape(-1, COMMAND_SIZE)
        angles = self._samples.Eval(context)
        output.SetFromVector(self._Turn(states, command, angles).ravel())

    def _Turn(self, states: Array, command: Array, angles: Array) -> Array:
        """Returns the commands with turned goals."""
        result: Array = command.copy()
        led = command
        if self._routes is not None:
            led = self._routes.guide(states, command)
        positions = states[:, X : Y + 1]
        ways = led[:, _GOAL] - positions
        lengths = np.hypot(ways[:, 0], ways[:, 1])
        radii = command[:, Command.GOAL_RADIUS]
        left = np.hypot(*(command[:, _GOAL] - positions).T)
        walk = (command[:, Command.HAS_GOAL] == 1) & (left > radii)
        walk &= (command[:, Command.HOLD] == Hold.WALK) & (lengths > radii)
        walk &= ~is_outside(states) & (angles != 0)
        cosines, sines = np.cos(angles), np.sin(angles)
        turned = np.column_stack(
            [
                cosines * ways[:, 0] - sines * ways[:, 1],
                sines * ways[:, 0] + cosines * ways[:, 1],
            ]
        )
        for reach in (np.inf, _AHEAD):
            if not walk.any():
                break
            near = np.minimum(1.0, (radii + reach) / np.maximum(lengths, 1e-9))
            goals = positions + near[:, None] * turned
            result[walk, _GOAL] = goals[walk]
            hidden = walk & self._AreHidden(states, result)
            result[hidden, _GOAL] = command[hidden, _GOAL]
            walk = hidden
        return result

    def _AreHidden(self, states: Array, command: Array) -> Mask:
        """Returns whose goals are not seen: shape (n,)."""
        if self._routes is None:
            return np.zeros(len(command), dtype=np.bool_)
        led = self._routes.guide(states, command)
        hidden: Mask = (led[:, _GOAL] != command[:, _GOAL]).any(axis=1)
        return hidden
