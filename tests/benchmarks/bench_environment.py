"""How many steps of a learning environment a second of processor time has.

A step is 0.1 s, two steps of people and robot: a velocity command in, the
states of robot and people out. Without walls and evaluator.
"""

import time

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.robot import DifferentialDrive, DifferentialDriveConfig

PERIOD = 0.1
STEPS = 2000


def environment(people: int, separate: bool | None) -> Diagram:
    """Returns people who walk to and fro in a hall, and a robot.

    Args:
        people: Their number; 0.1 a square meter.
        separate: Whether each tree is a system.
    """
    random = np.random.default_rng(0)
    half = np.sqrt(people / 0.1) / 2
    humans = [
        HumanConfig(
            pose=[*random.uniform(-half, half, 2).tolist(), 0.0],
            goals=random.uniform(-half, half, (4, 2)).tolist(),
            cyclic=True,
        )
        for _ in range(people)
    ]
    builder = DiagramBuilder()
    robot = builder.AddSystem(DifferentialDrive(DifferentialDriveConfig()))
    added = AddHumans(builder, humans, separate_trees=separate)
    builder.Connect(robot.get_robot_state_output_port(), added.robot_states)
    builder.ExportInput(robot.get_velocity_command_input_port(), "action")
    builder.ExportOutput(robot.get_robot_state_output_port(), "robot")
    builder.ExportOutput(added.human_states, "people")
    return builder.Build()


def time_steps(diagram: Diagram) -> tuple[float, float]:
    """Returns steps a second, and the seconds of a new Context."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.0, 0.0])
    simulator.Initialize()
    actions = np.random.default_rng(1).uniform(-0.5, 0.5, (STEPS, 2))
    total = 0.0
    started = time.process_time()
    for k in range(STEPS):
        diagram.get_input_port().FixValue(context, actions[k])
        simulator.AdvanceTo((k + 1) * PERIOD)
        for port in range(2):
            total += diagram.get_output_port(port).Eval(context)[0]
    steps = STEPS / (time.process_time() - started)
    assert np.isfinite(total)
    started = time.process_time()
    for _ in range(100):
        diagram.CreateDefaultContext()
    return steps, (time.process_time() - started) / 100


def main() -> None:
    """Prints the table."""
    print("people  trees          steps a second  reset ms")
    for people in (5, 20):
        for separate in (True, False):
            diagram = environment(people, separate)
            time_steps(diagram)
            steps, reset = max(time_steps(diagram) for _ in range(3))
            kind = "one system each" if separate else "one system"
            print(f"{people:6}  {kind:15}{steps:14.0f}  {1e3 * reset:8.2f}")


if __name__ == "__main__":
    main()
