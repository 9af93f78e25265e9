"""HuNavSim's services, for other simulators."""

from collections.abc import Sequence
import numbers
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context

from hunav_drake.hunavsim.closest_obs import PeopleAtPoints
from hunav_drake.hunavsim.requests import (
    ClosestObs,
    points_key,
    read_closest_obs,
    read_rows,
)
from hunav_drake.hunavsim.stepwise import StepwiseHumans
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_kind
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from hunav_drake.trial.humans import MakeHumans
from hunav_drake.trial.seeds import SetHumansSeed

# The tolerance of a duration, in steps: simulators keep their time in single
# precision, or add it up.
_TOLERANCE = 1e-4


class Agents(NamedTuple):
    """The people after a call.

    Attributes:
        states: Shape (n, 7), rows (x, y, yaw, vx, vy, omega, radius) in W, in
            SI units: see `common.layout`. Shape (7,) for one person.
        behavior_status: Shape (n,): 1 (or more) for people whose reaction to
            the robot was active in the last step, else 0. Shape () for one
            person.
    """

    states: Array
    behavior_status: NDArray[np.int64]


_Given = tuple[bytes, bytes, bytes]


class _Round(NamedTuple):
    """A step of all people that `move_agent` takes person by person.

    Attributes:
        given: The input of the other simulator: states of people and robots,
            and obstacles; None if one person continues without input.
        after: The Context one step later.
        status: The behavior status of all people in the step.
        moved: The indices of people who took the step; changed.
    """

    given: _Given | None
    after: Context
    status: NDArray[np.int64]
    moved: set[int]


class AgentServices:
    """Moves people for a simulator that owns the world.

    The other simulator passes all states, gets the new states of people, moves
    its bodies there, and calls again. The calls are HuNavSim's four services,
    `compute_agents`, `compute_agent`, `move_agent` and `reset_agents`. Unlike
    in HuNavSim, the first call moves people as any other does, and
    `reset_agents` resets behaviors, too.

        services = AgentServices(people, num_robots=1)
        states = services.agents.states
        while running:
            states, status = services.compute_agents(states, my_robot())
            states = my_simulator_moves(states)

    The people are the diagram of `MakeHumans`, so they move as in a trial.
    Their memory (goal, reaction) is in a Context, which can be saved and
    restored:

        saved = services.context.Clone()
        ...
        services.context = saved
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        *,
        obstacles: Obstacles | World | None = None,
        config: CrowdConfig | None = None,
        num_robots: int = 1,
        time_step: float = 0.05,
        seed: int = 0,
        places: Sequence[Place] = (),
    ) -> None:
        """Constructs the services.

        Args:
            humans: The people; there may be none. People without a number
                get the next free one of 1, 2, ...
            obstacles: The walls, or the world with the walls; none by default.
            config: The motion model of people, and their perception.
            num_robots: The number of robots.
            time_step: The length of a step, in seconds.
            seed: The seed of drawn weights, in [0, 2^63), until
                `reset_agents` gets another one.
            places: The places that behaviors name, besides the furniture of
                the world.

        Raises:
            BehaviorTreeError: If a behavior is unknown or faulty.
            ValueError: If `MakeHumans` refuses an argument, such as two people
                with the same number.
            TypeError: If an argument has the wrong type.
        """
        self._diagram = MakeHumans(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            seed=seed,
            places=places,
            separate_trees=False,
        )
        self._people = StepwiseHumans(
            self._diagram, num_robots=num_robots, time_step=time_step
        )
        self._at_points = PeopleAtPoints(
            self._diagram,
            humans,
            obstacles=(
                obstacles.obstacles()
                if isinstance(obstacles, World)
                else obstacles
            ),
            config=config,
            time_step=time_step,
        )
        self._ids = people_ids(humans)
        self._num_robots = num_robots
        self._time_step = time_step
        self._context = self._diagram.CreateDefaultContext()
        # The rest of a step: a function of the Context and of the input, and
        # therefore no further state.
        self._round: _Round | None = None

    @property
    def context(self) -> Context:
        """The whole state of these services; it can be set to a clone.

        Raises:
            RuntimeError: If a Context of other people is set.
        """
        return self._context

    @context.setter
    def context(self, context: Context) -> None:
        self._diagram.ValidateContext(context)
        self._context = context.Clone()
        self._round = None

    @property
    def agents(self) -> Agents:
        """The current people, with behavior status 0."""
        status = np.zeros(len(self._ids), dtype=np.int64)
        return Agents(self._people.GetStates(self._context), status)

    def compute_agents(
        self,
        humans: ArrayLike,
        robot: ArrayLike | None = None,
        dt: float | None = None,
        closest_obs: ClosestObs | None = None,
    ) -> Agents:
        """Moves all people by a time `dt`, and returns them.

        Args:
            humans: The current states of all people, in the form of
                `Agents.states`. Radii are not read: those of the
                configurations apply.
            robot: The states of the robots in the same form, constant during
                the call. It can be omitted without robots.
            dt: The time, in seconds, a multiple of the time step; by default,
                one step.
            closest_obs: For each person, the points of obstacles nearby, rows
                (x, y) in W, in meters, as in HuNavSim's messages. In this call,
                all these points act on the person, and no walls. None for a
                person on whom the walls act, the default for all. Walls hide
                the robot in either case.

        Raises:
            ValueError: If an array has another shape or is not finite, or if
                `dt` is not a multiple of the time step.
            TypeError: If `dt` is not a number, or if a user-defined leaf
                returns a wrong type.
            BehaviorTreeError: If a user-defined leaf raises an error or writes
                an invalid value; people then have the states of the previous
                step.
        """
        steps = self._count_steps(dt)
        context = self._context
        points = read_closest_obs(closest_obs, len(self._ids))
        self._receive(context, *self._read(humans, robot))
        for _ in range(steps):
            status = self._people.CalcBehaviorStatus(context)
            rows = self._at_points.CalcNext(context, points)
            self._people.StepAll(context)
            self._put(context, rows)
        return Agents(self._people.GetStates(context), status)

    def compute_agent(self, agent_id: int, dt: float | None = None) -> Agents:
        """Moves one person by a time `dt` from the current states.

        These are the input and the result of the last call, and those of all
        people after `move_agent` of each. The other people do not move.

        Args:
            agent_id: The number of the person.
            dt: As for `compute_agents`.

        Raises:
            ValueError: If nobody has that number, no call has passed the
                robots, or `dt` is not a multiple of the time step; all other
                errors are those of `compute_agents`.
        """
        index = self._index(agent_id)
        steps = self._count_steps(dt)
        if not self._people.AreRobotsKnown(self._context):
            raise ValueError(
                "robot: it is not known yet where the robots are: pass them to"
                " reset_agents or to another call first"
            )
        self._round = None
        return self._step_one(index, steps)

    def move_agent(
        self,
        humans: ArrayLike,
        robot: ArrayLike | None,
        agent_id: int,
        dt: float | None = None,
        closest_obs: ClosestObs | None = None,
    ) -> Agents:
        """Moves one person by a time `dt` from given states of all.

        The other people do not move, and their trees are not ticked. To move
        all people, pass the same states in the call for each of them: then the
        order does not matter, the step of all is computed only once, and after
        the last of them time has gone on, as after `compute_agents`.

        Args:
            humans: As for `compute_agents`.
            robot: The robots, as for `compute_agents`.
            agent_id: The number of the person.
            dt: As for `compute_agents`.
            closest_obs: As for `compute_agents`.

        Raises:
            ValueError: If nobody has that number; all other errors are those
                of `compute_agents`.
        """
        index = self._index(agent_id)
        steps = self._count_steps(dt)
        points = read_closest_obs(closest_obs, len(self._ids))
        states, robots = self._read(humans, robot)
        given = (states.tobytes(), robots.tobytes(), points_key(points))
        old = self._round
        if old is None or old.given != given or index in old.moved:
            self._receive(self._context, states, robots)
            self._round = self._begin(given, points)
        else:
            self._people.SetStates(self._context, states)
        return self._step_one(index, steps, points)

    def reset_agents(
        self,
        humans: ArrayLike | None = None,
        robot: ArrayLike | None = None,
        seed: int | None = None,
    ) -> Agents:
        """Restarts people with their first goals, and without reactions.

        Args:
            humans: The states at the start, as for `compute_agents`; by
                default, at rest at the poses of their configurations.
            robot: The robots, if already known.
            seed: The seed of drawn weights; by default, the current one.

        Returns:
            The people at the start.

        Raises:
            ValueError: If an array has another shape or is not finite, or if
                the seed is not a whole number in [0, 2^63).
        """
        if seed is None:
            seed = self._people.GetSeed(self._context)
        context = self._diagram.CreateDefaultContext()
        SetHumansSeed(self._diagram, context, seed)
        start = self._people.GetStates(context) if humans is None else humans
        if robot is None:
            states = read_rows(start, len(self._ids), "humans")
            self._people.SetStates(context, states)
        else:
            self._receive(context, *self._read(start, robot))
        self._context = context
        self._round = None
        return self.agents

    def _count_steps(self, dt: float | None) -> int:
        if dt is None:
            return 1
        check_kind("dt", dt, numbers.Real, "a number, in seconds")
        steps = dt / self._time_step
        count = round(steps) if np.isfinite(steps) else 0
        if count < 1 or abs(steps - count) > _TOLERANCE:
            raise ValueError(
                "dt must be a positive whole number of steps of"
                f" {self._time_step:g} s, got {dt:g} s; a smaller time_step of"
                " the services allows finer ones"
            )
        return count

    def _index(self, agent_id: int) -> int:
        try:
            return self._ids.index(agent_id)
        except ValueError:
            known = ", ".join(map(str, self._ids[:20])) or "none"
            raise ValueError(
                f"nobody has the number {agent_id}; there are: {known}"
            ) from None

    def _read(
        self, humans: ArrayLike, robot: ArrayLike | None
    ) -> tuple[Array, Array]:
        """Returns the given states of people and robots as rows."""
        given: ArrayLike = [] if robot is None else robot
        return (
            read_rows(humans, len(self._ids), "humans"),
            read_rows(given, self._num_robots, "robot"),
        )

    def _receive(self, context: Context, states: Array, robots: Array) -> None:
        """Sets the given states in a Context."""
        self._round = None
        self._people.FixRobots(context, robots)
        self._people.SetStates(context, states)

    def _put(self, context: Context, rows: Array | None) -> None:
        """Sets the states of people, if given."""
        if rows is not None:
            self._people.SetStates(context, rows)

    def _begin(
        self, given: _Given | None, points: Sequence[Array | None]
    ) -> _Round:
        """Returns a step of all people, to be taken one by one."""
        after = self._people.CalcNext(self._context)
        self._put(
            after,
            self._at_points.CalcNext(self._context, points, one_by_one=True),
        )
        return _Round(
            given=given,
            after=after,
            status=self._people.CalcBehaviorStatus(self._context),
            moved=set(),
        )

    def _step_one(
        self, index: int, steps: int, points: Sequence[Array | None] = ()
    ) -> Agents:
        """Moves one person by some steps as if all moved."""
        status = np.int64(0)
        for _ in range(steps):
            now = self._round
            if now is None or index in now.moved:
                now = self._begin(None, points)
                self._round = None
            now.moved.add(index)
            self._people.StepOne(self._context, index, now.after)
            if len(now.moved) == len(self._ids):
                self._people.FinishStep(self._context, now.after)
            status = now.status[index]
        states = self._people.GetStates(self._context)
        return Agents(states[index], np.asarray(status))
