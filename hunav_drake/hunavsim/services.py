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
from hunav_drake.hunavsim.stepwise import Array, StepwiseHumans
from hunav_drake.systems.common.checks import check_kind
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from hunav_drake.trial.humans import MakeHumans
from hunav_drake.trial.seeds import SetHumansSeed

# A duration is a number of steps if it is within this part of a step of one:
# simulators keep their time in single precision, or add it up.
_TOLERANCE = 1e-4


class Agents(NamedTuple):
    """People as they are after a call.

    Attributes:
        states: Shape (n, 7), rows (x, y, yaw, vx, vy, omega, radius) in W, in
            SI units: see `common.layout`. Of one person, (7,).
        behavior_status: Shape (n,): 1 (or more) for people whose reaction to
            the robot was active in the last step, else 0. Of one person, ().
    """

    states: Array
    behavior_status: NDArray[np.int64]


_Given = tuple[bytes, bytes, bytes]


class _Round(NamedTuple):
    """A step of everybody that `move_agent` takes person by person.

    Attributes:
        given: What the other simulator said: the states of people and robots,
            and obstacles; None if nothing was said, but one person goes on
            alone.
        after: Everybody a step later.
        status: What they react to in it.
        moved: Whose step has been taken; changed.
    """

    given: _Given | None
    after: Context
    status: NDArray[np.int64]
    moved: set[int]


class AgentServices:
    """Moves people for a simulator that owns the world.

    The other simulator knows where everybody is: it passes that in, gets back
    where people go, moves its bodies there, and calls again. The calls are
    HuNavSim's four services, `compute_agents`, `compute_agent`, `move_agent`
    and `reset_agents`; unlike there, the first call moves people as any other
    does, and `reset_agents` resets behaviors, too.

        services = AgentServices(people, num_robots=1)
        states = services.agents.states
        while running:
            states, status = services.compute_agents(states, my_robot())
            states = my_simulator_moves(states)

    The people are the diagram of `MakeHumans`, so they move as in a trial.
    What they have in mind (their goal, a reaction) is kept in a Context, which
    can be saved and put back:

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
    ) -> None:
        """Constructs the services.

        Args:
            humans: The people; there may be none. Those without a number
                have 1, 2, ... in order, without those that are taken.
            obstacles: The walls that they feel, or the world that has them;
                none by default.
            config: How they move.
            num_robots: How many robots they meet.
            time_step: The length of a step, in seconds.
            seed: What drawn weights follow from, in [0, 2^63), until
                `reset_agents` is given another one.

        Raises:
            BehaviorTreeError: If a behavior is not known, or faulty.
            ValueError: If an argument is refused by `MakeHumans`, like two
                people with the same number.
            TypeError: If an argument is of another kind.
        """
        self._diagram = MakeHumans(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            seed=seed,
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
        # What is left to do of a step: a function of the Context and of what
        # was given, and so no state of its own.
        self._round: _Round | None = None

    @property
    def context(self) -> Context:
        """All that these services know; a clone of it can be put back.

        Raises:
            RuntimeError: If what is put back is of other people.
        """
        return self._context

    @context.setter
    def context(self, context: Context) -> None:
        self._diagram.ValidateContext(context)
        self._context = context.Clone()
        self._round = None

    @property
    def agents(self) -> Agents:
        """The people as they are known, with no reaction active."""
        status = np.zeros(len(self._ids), dtype=np.int64)
        return Agents(self._people.GetStates(self._context), status)

    def compute_agents(
        self,
        humans: ArrayLike,
        robot: ArrayLike | None = None,
        dt: float | None = None,
        closest_obs: ClosestObs | None = None,
    ) -> Agents:
        """Returns where all people are `dt` later.

        Args:
            humans: Where they are now, and how they move, in the form of
                `Agents.states` of everybody. The radii are not read: they are
                those of the configurations.
            robot: The robots, rows of the same form; they stay as given for
                the time of the call. It can be left out if there are none.
            dt: How much time passes, in seconds: a whole number of steps; one
                step by default.
            closest_obs: For each person the points of obstacles near it, rows
                (x, y) in W, in meters, as in HuNavSim's messages; in this call
                the person feels all of these, and no walls. None for who feels
                the walls, as all do by default. What hides the robot from
                people are the walls in any case.

        Raises:
            ValueError: If an array does not have that shape or is not finite,
                or if `dt` is not such a number.
            TypeError: If `dt` is not a number at all, or if a leaf of one's
                own does not return what it must.
            BehaviorTreeError: If a leaf of one's own raises an error, or
                writes what cannot be; people are then where the step before
                has brought them.
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
        """Returns where one person is `dt` later, going by what is known.

        What is known is what the last call was given, and what came of it.
        The others stay where they are.

        Args:
            agent_id: The number of the person.
            dt: As for `compute_agents`.

        Raises:
            ValueError: If nobody has that number, no call has told where the
                robots are, or `dt` is not a whole number of steps; else, all
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
        """Returns where one person is `dt` later, if all are as given.

        The others stay where they are, and their trees are not ticked. To move
        all people in this way, pass the same states for each of them: the
        order does not matter then, and everybody's step is computed once.

        Args:
            humans: As for `compute_agents`.
            robot: The robots, as for `compute_agents`.
            agent_id: The number of the person.
            dt: As for `compute_agents`.
            closest_obs: As for `compute_agents`.

        Raises:
            ValueError: If nobody has that number; else, all errors are those
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
        """Makes people start again with their first goals, and no reactions.

        Args:
            humans: Where they start, as for `compute_agents`; by default at
                rest at the poses of their configurations.
            robot: The robots, if they are already known.
            seed: What drawn weights follow from; by default as before.

        Returns:
            The people as they start.

        Raises:
            ValueError: If an array does not have its shape or is not finite,
                or if the seed is not a whole number in [0, 2^63).
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
        """Returns what the other simulator says, as rows."""
        given: ArrayLike = [] if robot is None else robot
        return (
            read_rows(humans, len(self._ids), "humans"),
            read_rows(given, self._num_robots, "robot"),
        )

    def _receive(self, context: Context, states: Array, robots: Array) -> None:
        """Takes over what the other simulator says."""
        self._round = None
        self._people.FixRobots(context, robots)
        self._people.SetStates(context, states)

    def _put(self, context: Context, rows: Array | None) -> None:
        """Sets where people are, if it is said."""
        if rows is not None:
            self._people.SetStates(context, rows)

    def _begin(
        self, given: _Given | None, points: Sequence[Array | None]
    ) -> _Round:
        """Returns the step of everybody that is to be taken one by one."""
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
        """Moves one person by some steps, as if all were moved."""
        status = np.int64(0)
        for _ in range(steps):
            now = self._round
            if now is None or index in now.moved:
                now = self._begin(None, points)
                self._round = None
            now.moved.add(index)
            self._people.StepOne(self._context, index, now.after)
            status = now.status[index]
        states = self._people.GetStates(self._context)
        return Agents(states[index], np.asarray(status))
