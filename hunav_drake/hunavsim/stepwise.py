"""People that the caller moves step by step."""

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram

from hunav_drake.systems.common.layout import STATE_SIZE

Array = NDArray[np.float64]


class StepwiseHumans:
    """The diagram of `MakeHumans`, and what can be done to its Contexts.

    It keeps nothing itself: a Context is all that is known of the people.
    Rows are (x, y, yaw, vx, vy, omega, radius) in W, in SI units.
    """

    def __init__(
        self, diagram: Diagram, *, num_robots: int, time_step: float
    ) -> None:
        """Takes a diagram of `MakeHumans`, without separate trees.

        Args:
            diagram: The diagram.
            num_robots: How many robots it was made for.
            time_step: The time step it was made for, in seconds.
        """
        self._diagram = diagram
        self._crowd = diagram.GetSubsystemByName("crowd")
        self._behaviors = diagram.GetSubsystemByName("behaviors")
        self._num_robots = num_robots
        self._time_step = time_step

    def GetSeed(self, context: Context) -> int:
        """Returns the seed that drawn weights follow from."""
        own = self._crowd.GetMyContextFromRoot(context)
        seed: int = self._crowd.GetSeed(own)
        return seed

    def GetStates(self, context: Context) -> Array:
        """Returns the rows of all people, a copy of shape (n, 7)."""
        port = self._diagram.GetOutputPort("human_states")
        states: Array = port.Eval(context).reshape(-1, STATE_SIZE).copy()
        return states

    def SetStates(self, context: Context, states: Array) -> None:
        """Sets where people are, and how they move.

        Args:
            context: Changed.
            states: Shape (n, 7), rows of people; radii are not read.
        """
        own = self._crowd.GetMyMutableContextFromRoot(context)
        self._crowd.SetStates(own, states)

    def FixRobots(self, context: Context, robots: Array) -> None:
        """Sets where the robots are, of shape (m, 7)."""
        if self._num_robots:
            port = self._diagram.GetInputPort("robot_states")
            port.FixValue(context, robots.ravel())

    def AreRobotsKnown(self, context: Context) -> bool:
        """Returns whether it is known where all robots are."""
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
        """Returns a Context of everybody a step later, at the same time."""
        after = context.Clone()
        after.SetDiscreteState(
            self._diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        return after

    def StepAll(self, context: Context) -> None:
        """Moves everybody by one step."""
        context.SetDiscreteState(
            self._diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        context.SetTime(context.get_time() + self._time_step)

    def StepOne(self, context: Context, index: int, after: Context) -> None:
        """Moves one person; the others stay, and their trees are not ticked.

        Args:
            context: Changed; its time stays.
            index: The row of the person.
            after: What `CalcNext` gave: the person will be as there.
        """
        states = self.GetStates(context)
        states[index] = self.GetStates(after)[index]
        self.SetStates(context, states)
        trees = self._behaviors
        memory = trees.GetMemory(trees.GetMyContextFromRoot(after), index)
        trees.SetMemory(
            trees.GetMyMutableContextFromRoot(context), index, memory
        )
