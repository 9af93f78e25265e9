"""How long behavior trees take: `python tests/benchmarks/bench_behavior.py`.

Prints microseconds per tick of a tree alone, and per person and step of the
systems in a diagram, beside a crowd that only reads the commands.
"""

import time
import timeit

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.systems.behavior import (
    BehaviorTree,
    LoadTree,
    ParseTree,
    Person,
)
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.layout import COMMAND_SIZE, STATE_SIZE

TIME_STEP = 0.05
HUMAN = HumanConfig(
    pose=(0.0, 0.0, 0.0), goals=[(50.0, 0.0), (0.0, 0.0)], cyclic=True
)
ROBOT = np.array([2.0, 1.0, 0, 0, 0, 0, 0.35])

# Ten nodes, all of which are ticked.
TEN_NODES = (
    "<root><BehaviorTree><Sequence>"
    + "<AlwaysSuccess/>" * 9
    + "</Sequence></BehaviorTree></root>"
)

# As the trees of the reactions are.
REACTION = """
<root BTCPP_format="4"><BehaviorTree ID="Reaction"><Fallback>
  <Sequence>
    <IsRobotVisible distance="4"/>
    <Inverter><TimeExpiredCondition seconds="40"/></Inverter>
    <RegularNav robot="unseen"/>
  </Sequence>
  <Sequence>
    <ForceSuccess>
      <Sequence><IsGoalReached/><UpdateGoal/></Sequence>
    </ForceSuccess>
    <RegularNav/>
  </Sequence>
</Fallback></BehaviorTree></root>
"""


class DummyCrowd(LeafSystem):
    """Reads the commands, moves all people by a little."""

    def __init__(self, n):
        super().__init__()
        self._commands = [
            self.DeclareVectorInputPort(f"command_{i}", COMMAND_SIZE)
            for i in range(n)
        ]
        self._state = self.DeclareDiscreteState(STATE_SIZE * n)
        self.DeclareStateOutputPort("human_states", self._state)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=TIME_STEP, offset_sec=0.0, update=self._Update
        )

    def _Update(self, context, discrete_state):
        for port in self._commands:
            port.Eval(context)
        x = context.get_discrete_state(self._state).value() + 0.001
        discrete_state.set_value(self._state, x)


def us_per_step(n, tree):
    """Returns the time of a step of n people; without trees if it is None."""
    builder = DiagramBuilder()
    crowd = builder.AddSystem(DummyCrowd(n))
    robot = builder.AddSystem(ConstantVectorSource(ROBOT))
    for i in range(n):
        if tree is None:
            system = builder.AddSystem(
                ConstantVectorSource(np.zeros(COMMAND_SIZE))
            )
        else:
            system = builder.AddNamedSystem(
                f"tree_{i}", BehaviorTree(tree, HUMAN, i, n)
            )
            builder.Connect(
                crowd.get_output_port(), system.get_human_states_input_port()
            )
            builder.Connect(
                robot.get_output_port(), system.get_robot_state_input_port()
            )
        builder.Connect(system.get_output_port(0), crowd.get_input_port(i))
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    steps = 200
    best = np.inf
    for i in range(1, 6):
        start = time.perf_counter()
        simulator.AdvanceTo(i * steps * TIME_STEP)
        best = min(best, time.perf_counter() - start)
    return best / steps * 1e6


def us_per_tick(tree):
    person = Person.from_config(HUMAN, 0, time_step=TIME_STEP)
    memory = tree.initial_memory(person)
    states = np.zeros(STATE_SIZE)
    number = 20_000
    return (
        min(
            timeit.repeat(
                lambda: tree.tick(person, memory, states, ROBOT),
                number=number,
                repeat=5,
            )
        )
        / number
        * 1e6
    )


def main():
    trees = {
        "ten nodes": ParseTree(TEN_NODES),
        "regular": LoadTree("regular"),
        "reaction": ParseTree(REACTION),
    }
    print("us per tick of a tree")
    for name, tree in trees.items():
        print(f"  {name:10s} {us_per_tick(tree):6.2f}")
    print("us per person and step of BehaviorTree in a diagram")
    for n in (5, 20, 50):
        base = us_per_step(n, None)
        for name in ("regular", "reaction"):
            cost = (us_per_step(n, trees[name]) - base) / n
            print(f"  n = {n:2d} {name:10s} {cost:6.2f}")


if __name__ == "__main__":
    main()
