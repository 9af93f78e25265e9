"""People for any diagram."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
)
from pydrake.systems.primitives import Multiplexer

from hunav_drake.systems.behavior import BehaviorTree, LoadTree
from hunav_drake.systems.crowd import CrowdConfig, HumanConfig, HumanCrowd
from hunav_drake.systems.obstacles import Obstacles


class HumanPorts(NamedTuple):
    """What `AddHumans` leaves to connect.

    Attributes:
        robot_state: Takes m rows (x, y, yaw, vx, vy, omega, radius) of the
            robots; None if there are none.
        human_states: Gives n such rows of the people, in W, in SI units.
        behavior_status: Gives, for each person, 0 while a reaction to the
            robot is not active, and 1 (or more) while it is.
        forces: Gives the forces on each person: see `layout.FORCES`.
    """

    robot_state: InputPort | None
    human_states: OutputPort
    behavior_status: OutputPort
    forces: OutputPort


def MakeHumans(
    humans: Sequence[HumanConfig],
    *,
    obstacles: Obstacles | None = None,
    config: CrowdConfig | None = None,
    num_robots: int = 1,
    time_step: float = 0.05,
) -> Diagram:
    """Makes a diagram of people: their crowd, and a behavior tree for each.

    Args:
        humans: The people; there may be none.
        obstacles: The walls that they feel; none by default.
        config: How they take in the world.
        num_robots: How many robots they meet.
        time_step: The time between two steps, in seconds.

    Returns:
        A diagram named "humans" of the systems "crowd", "behavior_0" ... and
        "behavior_status", with the ports of `HumanPorts` by these names.

    Raises:
        ValueError: If a behavior is not known.
    """
    builder = DiagramBuilder()
    crowd = builder.AddNamedSystem(
        "crowd",
        HumanCrowd(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
        ),
    )
    status = builder.AddNamedSystem(
        "behavior_status", Multiplexer([1] * len(humans))
    )
    robot_ports = [crowd.get_robot_state_input_port()] if num_robots else []
    for i, human in enumerate(humans):
        tree = builder.AddNamedSystem(
            f"behavior_{i}",
            BehaviorTree(
                LoadTree(human.behavior),
                human,
                i,
                len(humans),
                num_robots=num_robots,
                time_step=time_step,
            ),
        )
        builder.Connect(
            crowd.get_human_states_output_port(),
            tree.GetInputPort("human_states"),
        )
        builder.Connect(
            tree.GetOutputPort("command"), crowd.get_command_input_port(i)
        )
        builder.Connect(
            tree.GetOutputPort("behavior_status"), status.get_input_port(i)
        )
        if num_robots:
            robot_ports.append(tree.GetInputPort("robot_state"))
    for k, port in enumerate(robot_ports):
        if k == 0:
            builder.ExportInput(port, "robot_state")
        else:
            builder.ConnectInput("robot_state", port)
    builder.ExportOutput(crowd.get_human_states_output_port(), "human_states")
    builder.ExportOutput(status.get_output_port(), "behavior_status")
    builder.ExportOutput(crowd.get_forces_output_port(), "forces")
    diagram = builder.Build()
    diagram.set_name("humans")
    return diagram


def AddHumans(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    *,
    obstacles: Obstacles | None = None,
    config: CrowdConfig | None = None,
    num_robots: int = 1,
    time_step: float = 0.05,
) -> HumanPorts:
    """Adds people to a builder, as one system named "humans".

    See `MakeHumans` for the arguments.

    Returns:
        The ports; ``robot_state`` is left for the caller to connect.
    """
    diagram = builder.AddSystem(
        MakeHumans(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
        )
    )
    return HumanPorts(
        robot_state=diagram.GetInputPort("robot_state") if num_robots else None,
        human_states=diagram.GetOutputPort("human_states"),
        behavior_status=diagram.GetOutputPort("behavior_status"),
        forces=diagram.GetOutputPort("forces"),
    )
