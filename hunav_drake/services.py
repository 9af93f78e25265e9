"""People for another simulator: HuNavSim's services as calls."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context

from hunav_drake.humans import MakeHumans
from hunav_drake.systems.crowd import CrowdConfig, HumanConfig
from hunav_drake.systems.layout import STATE_SIZE
from hunav_drake.systems.obstacles import Obstacles

Array = NDArray[np.float64]

# A duration is a number of steps if it is within this part of a step of one:
# simulators keep their time in single precision, or add it up.
_TOLERANCE = 1e-4


class Agents(NamedTuple):
    """People as they are after a call.

    Attributes:
        states: Shape (n, 7), rows (x, y, yaw, vx, vy, omega, radius) in W, in
            SI units: see `hunav_drake.systems.layout`. Of one person, (7,).
        behavior_status: Shape (n,): 1 (or more) for people whose reaction to
            the robot was active in the last step, else 0. Of one person, ().
    """

    states: Array
    behavior_status: NDArray[np.int64]


class AgentServices:
    """Moves people for a simulator that owns the world.

    The other simulator knows where everybody is: it passes that in, gets back
    where people go, moves its bodies there, and calls again. The calls are
    HuNavSim's four services, `compute_agents`, `compute_agent`, `move_agent`
    and `reset_agents`; unlike there, the first call moves people as any other
    does, and `reset_agents` resets behaviors, too.

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
        obstacles: Obstacles | None = None,
        config: CrowdConfig | None = None,
        num_robots: int = 1,
        time_step: float = 0.05,
        seed: int = 0,
    ) -> None:
        """Constructs the services.

        Args:
            humans: The people; there may be none. Those without a number
                have 1, 2, ... by their places.
            obstacles: The walls that they feel; none by default.
            config: How they move.
            num_robots: How many robots they meet.
            time_step: The length of a step, in seconds.
            seed: What drawn weights follow from: see `MakeHumans`.

        Raises:
            ValueError: If two people have the same number, or if an argument
                is refused by `MakeHumans`.
        """
        self._ids = [
            i + 1 if human.id is None else human.id
            for i, human in enumerate(humans)
        ]
        for i, human_id in enumerate(self._ids):
            if human_id in self._ids[:i]:
                raise ValueError(f"two people have the number {human_id}")
        self._diagram = MakeHumans(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            seed=seed,
            separate_trees=True,
        )
        self._crowd = self._diagram.GetSubsystemByName("crowd")
        self._trees = [
            self._diagram.GetSubsystemByName(f"behavior_{i}")
            for i in range(len(humans))
        ]
        self._num_robots = num_robots
        self._time_step = time_step
        self._context = self._diagram.CreateDefaultContext()

    @property
    def context(self) -> Context:
        """All that these services know; a clone of it can be put back."""
        return self._context

    @context.setter
    def context(self, context: Context) -> None:
        self._diagram.ValidateContext(context)
        self._context = context.Clone()

    @property
    def agents(self) -> Agents:
        """The people as they are known, with no reaction active."""
        status = np.zeros(len(self._ids), dtype=np.int64)
        return Agents(self._states(self._context), status)

    def compute_agents(
        self,
        humans: ArrayLike,
        robot: ArrayLike | None = None,
        dt: float | None = None,
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

        Raises:
            ValueError: If an array does not have that shape or is not finite,
                or if `dt` is not such a number.
        """
        steps = self._count_steps(dt)
        self._receive(self._context, humans, robot)
        status = self.agents.behavior_status
        for _ in range(steps):
            status = self._step()
        return Agents(self._states(self._context), status)

    def compute_agent(self, agent_id: int, dt: float | None = None) -> Agents:
        """Returns where one person is `dt` later, going by what is known.

        What is known is what the last call was given, and what came of it.
        The others stay where they are.

        Args:
            agent_id: The number of the person.
            dt: As for `compute_agents`.

        Raises:
            ValueError: If nobody has that number, no call has told where the
                robots are, or `dt` is not a whole number of steps.
        """
        index = self._index(agent_id)
        steps = self._count_steps(dt)
        self._check_robots_are_known()
        status = np.int64(0)
        for _ in range(steps):
            status = self._step_one(index)
        return Agents(self._states(self._context)[index], np.asarray(status))

    def move_agent(
        self,
        humans: ArrayLike,
        robot: ArrayLike | None,
        agent_id: int,
        dt: float | None = None,
    ) -> Agents:
        """Returns where one person is `dt` later, if all are as given.

        The others stay where they are, and have no thoughts meanwhile. To move
        all people in this way, pass the same states for each of them: the
        order does not matter then.

        Args:
            humans: As for `compute_agents`.
            robot: Likewise.
            agent_id: The number of the person.
            dt: As for `compute_agents`.

        Raises:
            ValueError: As `compute_agents`, and if nobody has that number.
        """
        self._index(agent_id)
        self._count_steps(dt)
        self._receive(self._context, humans, robot)
        return self.compute_agent(agent_id, dt)

    def reset_agents(
        self, humans: ArrayLike | None = None, robot: ArrayLike | None = None
    ) -> Agents:
        """Makes people start again with their first goals, and no reactions.

        Args:
            humans: Where they start, as for `compute_agents`; by default at
                rest at the poses of their configurations.
            robot: The robots, if they are already known.

        Returns:
            The people as they start.

        Raises:
            ValueError: If an array does not have its shape or is not finite.
        """
        context = self._diagram.CreateDefaultContext()
        start = self._states(context) if humans is None else humans
        self._receive(context, start, robot, robot_needed=False)
        self._context = context
        return self.agents

    def _count_steps(self, dt: float | None) -> int:
        if dt is None:
            return 1
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
            numbers = ", ".join(map(str, self._ids[:20])) or "none"
            raise ValueError(
                f"nobody has the number {agent_id}; there are: {numbers}"
            ) from None

    def _check_robots_are_known(self) -> None:
        if self._num_robots == 0:
            return
        port = self._diagram.GetInputPort("robot_state")
        if not port.HasValue(self._context):
            raise ValueError(
                "robot: it is not known yet where the robots are: pass them to"
                " reset_agents or to another call first"
            )

    def _receive(
        self,
        context: Context,
        humans: ArrayLike,
        robot: ArrayLike | None,
        *,
        robot_needed: bool = True,
    ) -> None:
        """Takes over what the other simulator says."""
        states = _rows(humans, len(self._ids), "humans")
        if robot is not None or robot_needed:
            given: ArrayLike = [] if robot is None else robot
            robots = _rows(given, self._num_robots, "robot")
            if self._num_robots:
                port = self._diagram.GetInputPort("robot_state")
                port.FixValue(context, robots.ravel())
        crowd_context = self._crowd.GetMyMutableContextFromRoot(context)
        crowd_context.SetDiscreteState(0, states[:, :6].ravel())

    def _states(self, context: Context) -> Array:
        port = self._diagram.GetOutputPort("human_states")
        states: Array = port.Eval(context).reshape(-1, STATE_SIZE).copy()
        return states

    def _step(self) -> NDArray[np.int64]:
        """Moves everybody by one step; returns what they reacted to in it."""
        context = self._context
        port = self._diagram.GetOutputPort("behavior_status")
        status: NDArray[np.int64] = port.Eval(context).astype(np.int64)
        context.SetDiscreteState(
            self._diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        context.SetTime(context.get_time() + self._time_step)
        return status

    def _step_one(self, index: int) -> np.int64:
        """Moves one person by one step, as if all were moved."""
        tree = self._trees[index]
        crowd_context = self._crowd.GetMyMutableContextFromRoot(self._context)
        tree_context = tree.GetMyMutableContextFromRoot(self._context)
        port = tree.GetOutputPort("behavior_status")
        status = np.int64(port.Eval(tree_context)[0])
        memory = tree.EvalUniquePeriodicDiscreteUpdate(tree_context)
        moved = self._crowd.EvalUniquePeriodicDiscreteUpdate(crowd_context)
        rows = self._states(self._context)[:, :6]
        rows[index] = moved.value(0).reshape(-1, 6)[index]
        crowd_context.SetDiscreteState(0, rows.ravel())
        tree_context.SetDiscreteState(memory)
        return status


def _rows(values: Any, count: int, name: str) -> Array:
    rows = np.asarray(values, dtype=float)
    if rows.size != count * STATE_SIZE or (
        rows.ndim > 1 and rows.shape[-1] != STATE_SIZE
    ):
        raise ValueError(
            f"{name} must hold {count} rows (x, y, yaw, vx, vy, omega,"
            f" radius), got shape {rows.shape}"
        )
    rows = rows.reshape(-1, STATE_SIZE)
    if not np.isfinite(rows).all():
        first = rows[~np.isfinite(rows).all(axis=1)][0]
        raise ValueError(f"{name} must be finite, got the row {first.tolist()}")
    return rows
