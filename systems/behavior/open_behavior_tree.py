"""The BehaviorTree of people who come and go."""

from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context

from hunav_drake.systems.behavior.behavior_tree import BehaviorTree
from hunav_drake.systems.behavior.nodes.node import NodeStatus
from hunav_drake.systems.behavior.tree import Outcome
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE, is_outside
from hunav_drake.systems.people.standing import Standing


class OpenBehaviorTree(BehaviorTree):
    """A `BehaviorTree` that does not tick the trees of people outside.

    .. pydrake_system::

        name: OpenBehaviorTree
        input_ports:
        - human_states
        - robot_states
        output_ports:
        - commands
        - behavior_status
        - node_status

    It differs from a `BehaviorTree` for people who are outside (see
    `layout.OUTSIDE`): their commands are to go nowhere, their other outputs
    are 0, and their memories are as at the start, so that people who come in
    begin anew.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        """Constructs an OpenBehaviorTree, like a `BehaviorTree`."""
        super().__init__(*args, **options)
        self._outcomes_outside = [
            Outcome(
                node_status=NodeStatus.SKIPPED,
                command=list(person.commands[-1]),
                behavior_status=0,
                memory=tree.initial_memory(person),
            )
            for tree, person, _ in self._ticked
        ]
        self._rows = [person.index for person in self._people]

    def _AreOutside(self, states: Array) -> list[bool]:
        """Returns, for each person that is ticked, whether it is outside."""
        rows = states.reshape(-1, STATE_SIZE)[self._rows]
        result: list[bool] = np.asarray(is_outside(rows)).tolist()
        return result

    def _CalcTick(self, context: Context, value: AbstractValue) -> None:
        memory, states, robots = self._EvalInputs(context)
        standing = Standing(states)
        value.set_value(
            [
                outcome
                if is_out
                else tree.tick(person, memory[own], states, robots, standing)
                for (tree, person, own), outcome, is_out in zip(
                    self._ticked,
                    self._outcomes_outside,
                    self._AreOutside(states),
                    strict=True,
                )
            ]
        )

    def _CalcNodeStatus(self, context: Context, output: BasicVector) -> None:
        memory, states, robots = self._EvalInputs(context)
        status: list[int] = []
        for (tree, person, own), is_out in zip(
            self._ticked, self._AreOutside(states), strict=True
        ):
            if is_out:
                status += [0] * len(tree.nodes)
            else:
                status += tree.trace(person, memory[own], states, robots)[1]
        output.SetFromVector(status)
