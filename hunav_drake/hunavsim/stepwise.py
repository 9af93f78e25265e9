"""People that the caller moves step by step."""

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE


class StepwiseHumans:
    """Operations on Contexts of a diagram of `MakeHumans`.

    It has no state: a Context holds the whole state of the people. Rows are
    (x, y, yaw, vx, vy, omega, radius) in W, in SI units.
    """

    def __init__(
        self, diagram: Diagram, *, num_robots: int, time_step: float
    ) -> None:
        """Takes a diagram of `MakeHumans` without separate trees.

        Number of robots and time step (s) are those that it was made with.
        """
        self._diagram = diagram
        self._crowd = diagram.GetSubsystemByName("crowd")
        self._behaviors = diagram.GetSubsystemByName("behaviors")
        self._num_robots = num_robots
        port = diagram.GetOutputPort("human_states")
        self._num_humans = port.size() // STATE_SIZE
        self._time_step = time_step

    def GetSeed(self, context: Context) -> int:
        """Returns the seed of drawn weights."""
        own = self._crowd.GetMyContextFromRoot(context)
        seed: int = self._crowd.GetSeed(own)
        return seed

    def GetStates(self, context: Context) -> Array:
        """Returns the rows of all people, a copy of shape (n, 7)."""
        port = self._diagram.GetOutputPort("human_states")
        states: Array = port.Eval(context).reshape(-1, STATE_SIZE).copy()
        return states

    def SetStates(self, context: Context, states: Array) -> None:
        """Sets the states of people, shape (n, 7); radii are not read."""
        own = self._crowd.GetMyMutableContextFromRoot(context)
        self._crowd.SetStates(own, states)

    def FixRobots(self, context: Context, robots: Array) -> None:
        """Sets the states of the robots, shape (m, 7)."""
        if self._num_robots:
            port = self._diagram.GetInputPort("robot_states")
            port.FixValue(context, robots.ravel())

    def AreRobotsKnown(self, context: Context) -> bool:
        """Returns whether the states of all robots are known."""
        if not self._num_robots:
            return True
        port = self._diagram.GetInputPort("robot_states")
        return bool(port.HasValue(context))

    def CalcBehaviorStatus(self, context: Context) -> NDArray[np.int64]:
        """Returns the behavior status of all people in the next step."""
        port = self._diagram.GetOutputPort("behavior_status")
        status: NDArray[np.int64] = port.Eval(context).astype(np.int64)
        return status

    def CalcNext(self, context: Context) -> Context:
        """Returns a Context one step later, with the time unchanged."""
        after = context.Clone()
        after.SetDiscreteState(
            self._diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        return after

    def StepAll(self, context: Context) -> None:
        """Moves all people by one step."""
        context.SetDiscreteState(
            self._diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        context.SetTime(context.get_time() + self._time_step)

    def FinishStep(self, context: Context, after: Context) -> None:
        """Ends a step in which all people went to their states in `after`."""
        context.SetDiscreteState(after.get_discrete_state())
        context.SetTime(context.get_time() + self._time_step)

    def StepOne(self, context: Context, index: int, after: Context) -> None:
        """Moves one person to its state in `after`, a result of `CalcNext`.

        Nothing else changes, not even the time.
        """
        # Rows of people: in the crowd, and what they show.
        for system, first in ((self._crowd, 0), (self._behaviors, 1)):
            own = system.GetMyMutableContextFromRoot(context)
            new = system.GetMyContextFromRoot(after)
            for k in range(first, own.num_discrete_state_groups()):
                rows = own.get_mutable_discrete_state(k).get_mutable_value()
                size = len(rows) // self._num_humans
                part = slice(index * size, (index + 1) * size)
                rows[part] = new.get_discrete_state(k).value()[part]
        trees = self._behaviors
        memory = trees.GetMemory(trees.GetMyContextFromRoot(after), index)
        trees.SetMemory(
            trees.GetMyMutableContextFromRoot(context), index, memory
        )
