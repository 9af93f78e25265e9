"""People with small trees on an empty floor, step by step."""

from collections.abc import Iterator, Sequence
import math
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake import HumanConfig, MakeHumans
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
    Signal,
)
from hunav_drake.systems.people.places import Place

DT = 0.05
# What people do whose own nodes fail: they walk from goal to goal.
WALK = (
    "<Sequence><Inverter><IsGoalReached/></Inverter><RegularNav/></Sequence>"
    "<UpdateGoal/>"
)
STAND = "<StopAndWaitTimerAction wait_duration='1000'/>"


def tree(nodes: str, rest: str = WALK) -> str:
    """Returns a tree of nodes, and what comes when they fail."""
    return (
        '<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree ID="T">'
        f"<ReactiveFallback>{nodes}{rest}</ReactiveFallback></BehaviorTree>"
        "</root>"
    )


def someone(x, y, yaw=0.0, nodes="", rest=WALK, **more: Any) -> HumanConfig:
    """Returns a person who ticks some nodes."""
    return HumanConfig(pose=(x, y, yaw), behavior=tree(nodes, rest), **more)


class Stage:
    """People, and perhaps a robot, ticked one step at a time.

    Attributes:
        states: Shape (n, 7), of people in the present step.
        signals: Shape (n, 22): what they have shown in the step before.
    """

    def __init__(
        self,
        people: Sequence[HumanConfig],
        *,
        places: Sequence[Place] = (),
        robot: Any = None,
        **options: Any,
    ) -> None:
        """`robot` returns the states (7m,) of robots at a time, if any."""
        count = 0 if robot is None else len(robot(0.0)) // STATE_SIZE
        self.diagram = MakeHumans(
            people, places=places, num_robots=count, **options
        )
        self._robot = robot
        self._simulator = Simulator(self.diagram)
        self.context = self._simulator.get_mutable_context()
        self.k = -1
        self._put_robot()
        self._simulator.Initialize()
        self.k = 0

    def _put_robot(self) -> None:
        if self._robot is not None:
            state = self._robot(max(self.k, 0) * DT)
            port = self.diagram.GetInputPort("robot_states")
            port.FixValue(self.context, state)

    def step(self) -> None:
        """Goes on by one step."""
        self.k += 1
        self._put_robot()
        self._simulator.AdvanceTo(self.k * DT)

    def run(self, seconds: float) -> Iterator[float]:
        """Goes on, and yields the time after each step."""
        for _ in range(round(seconds / DT)):
            self.step()
            yield self.k * DT

    def _eval(self, name: str, size: int) -> np.ndarray:
        value = self.diagram.GetOutputPort(name).Eval(self.context)
        return value.reshape(-1, size)

    @property
    def states(self) -> np.ndarray:
        return self._eval("human_states", STATE_SIZE)

    @property
    def robot(self) -> np.ndarray:
        return self._robot(self.k * DT)

    @property
    def signals(self) -> np.ndarray:
        return self._eval("social_signals", SIGNAL_SIZE)

    def signal(self, index: int, which: Signal) -> float:
        return self.signals[index, which]

    def _trees(self, index: int):
        """Returns the system that ticks a person's tree."""
        name = f"behavior_{index}"
        if not self.diagram.HasSubsystemNamed(name):
            name = "behaviors"
        return self.diagram.GetSubsystemByName(name)

    def command(self, index: int) -> np.ndarray:
        """Returns the command of a person: see `layout.Command`."""
        system = self._trees(index)
        commands = system.GetOutputPort("commands").Eval(
            system.GetMyContextFromRoot(self.context)
        )
        rows = commands.reshape(-1, COMMAND_SIZE)
        return rows[index if len(rows) > 1 else 0]

    def statuses(self, index: int) -> dict[str, int]:
        """Returns the status of a person's nodes in this tick, by name."""
        system = self._trees(index)
        values = system.EvalNodeStatus(
            system.GetMyContextFromRoot(self.context), index
        )
        trees = system.trees()
        nodes = trees[index if len(trees) > 1 else 0].nodes
        return {
            node.name: int(value)
            for node, value in zip(nodes, values, strict=True)
        }

    def distance(self, i: int, j: int) -> float:
        (x, y), (u, v) = self.states[[i, j], :2]
        return math.hypot(u - x, v - y)


def robot_at(x, y, yaw=0.0, speed=0.0):
    """Returns a robot that drives straight ahead."""
    c, s = math.cos(yaw), math.sin(yaw)

    def state(t: float) -> list[float]:
        go = speed * t
        return [x + go * c, y + go * s, yaw, speed * c, speed * s, 0.0, 0.3]

    return state
