"""People for any diagram."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
    System,
)
from pydrake.systems.primitives import Multiplexer

from hunav_drake.systems.behavior import (
    BehaviorTree,
    BehaviorTreeBank,
    LoadBehavior,
)
from hunav_drake.systems.crowd import CrowdConfig, HumanConfig, HumanCrowd
from hunav_drake.systems.crowd.weights import draw_weights
from hunav_drake.systems.obstacles import Obstacles

# More people than this share a bank of trees.
BANK_FROM = 20


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
    seed: int = 0,
    separate_trees: bool | None = None,
) -> Diagram:
    """Makes a diagram of people: their crowd, and a behavior tree for each.

    Args:
        humans: The people; there may be none.
        obstacles: The walls that they feel and cannot see through; none by
            default.
        config: How they take in the world.
        num_robots: How many robots they meet.
        time_step: The time between two steps, in seconds.
        seed: What the weights of people follow from whose `forces_mode` is
            a random one, >= 0.
        separate_trees: Whether each person's tree is a system of its own,
            or all are in one `BehaviorTreeBank`, which does the same and is
            faster for many; by default, from more than 20 people on.

    Returns:
        A diagram named "humans" of the systems "crowd", "behavior_0" ... and
        "behavior_status", or "crowd" and "behaviors", with the ports of
        `HumanPorts` by these names.

    Raises:
        BehaviorTreeError: If a behavior is not known, or faulty.
    """
    humans = draw_weights(humans, seed)
    if separate_trees is None:
        separate_trees = len(humans) <= BANK_FROM
    builder = DiagramBuilder()
    crowd = builder.AddNamedSystem(
        "crowd",
        HumanCrowd(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            one_command_port=not separate_trees,
            time_step=time_step,
        ),
    )
    options = {
        "num_robots": num_robots,
        "time_step": time_step,
        "obstacles": obstacles,
    }
    add = _AddTrees if separate_trees else _AddBank
    trees, status = add(builder, humans, crowd, options)
    builder.ExportOutput(crowd.get_human_states_output_port(), "human_states")
    builder.ExportOutput(status, "behavior_status")
    builder.ExportOutput(crowd.get_forces_output_port(), "forces")
    for system in trees:
        builder.Connect(
            crowd.get_human_states_output_port(),
            system.GetInputPort("human_states"),
        )
    if num_robots:
        builder.ExportInput(crowd.get_robot_state_input_port(), "robot_state")
        for system in trees:
            builder.ConnectInput(
                "robot_state", system.GetInputPort("robot_state")
            )
    diagram = builder.Build()
    diagram.set_name("humans")
    return diagram


def _AddTrees(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    crowd: HumanCrowd,
    options: dict[str, Any],
) -> tuple[list[System], OutputPort]:
    """Adds a tree for each person; returns them, and whose is active."""
    status = builder.AddNamedSystem(
        "behavior_status", Multiplexer([1] * len(humans))
    )
    trees = []
    for i, human in enumerate(humans):
        tree = builder.AddNamedSystem(
            f"behavior_{i}",
            BehaviorTree(
                LoadBehavior(human.behavior), human, i, len(humans), **options
            ),
        )
        builder.Connect(
            tree.GetOutputPort("command"), crowd.get_command_input_port(i)
        )
        builder.Connect(
            tree.GetOutputPort("behavior_status"), status.get_input_port(i)
        )
        trees.append(tree)
    return trees, status.get_output_port()


def _AddBank(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    crowd: HumanCrowd,
    options: dict[str, Any],
) -> tuple[list[System], OutputPort]:
    """Adds all trees in one system; returns it, and whose is active."""
    trees = [LoadBehavior(human.behavior) for human in humans]
    bank = builder.AddNamedSystem(
        "behaviors", BehaviorTreeBank(trees, humans, **options)
    )
    builder.Connect(
        bank.get_commands_output_port(), crowd.GetInputPort("commands")
    )
    return [bank], bank.get_behavior_status_output_port()


def AddHumans(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    *,
    obstacles: Obstacles | None = None,
    config: CrowdConfig | None = None,
    num_robots: int = 1,
    time_step: float = 0.05,
    seed: int = 0,
    separate_trees: bool | None = None,
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
            seed=seed,
            separate_trees=separate_trees,
        )
    )
    return HumanPorts(
        robot_state=diagram.GetInputPort("robot_state") if num_robots else None,
        human_states=diagram.GetOutputPort("human_states"),
        behavior_status=diagram.GetOutputPort("behavior_status"),
        forces=diagram.GetOutputPort("forces"),
    )
