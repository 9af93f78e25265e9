"""Adds people to any diagram."""

from collections.abc import Sequence
import numbers
from types import NoneType
from typing import Any, NamedTuple

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
)
from pydrake.systems.primitives import Multiplexer

from hunav_drake.systems.behavior import BehaviorTree, LoadBehaviors
from hunav_drake.systems.common.checks import check_kind
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.names import check_consistent, name_people
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World

# The trees of more people than this are in one system.
MAX_SEPARATE_TREES = 20


class HumanPorts(NamedTuple):
    """What `AddHumans` leaves to connect.

    Attributes:
        robot_state: Takes m rows (x, y, yaw, vx, vy, omega, radius) of the
            robots; None if there are none.
        human_states: Gives n such rows of the people, in W, in SI units.
        behavior_status: Gives, for each person, 0 while no reaction is
            active, else the state that it is in, most often 1.
        forces: Gives the forces on each person: see `layout.FORCES`.
    """

    robot_state: InputPort | None
    human_states: OutputPort
    behavior_status: OutputPort
    forces: OutputPort


def MakeHumans(
    humans: Sequence[HumanConfig],
    *,
    obstacles: Obstacles | World | None = None,
    config: CrowdConfig | None = None,
    num_robots: int = 1,
    time_step: float = 0.05,
    start_jitter: float = 0.0,
    seed: int = 0,
    separate_trees: bool | None = None,
) -> Diagram:
    """Makes a diagram of people: their crowd, and a behavior tree for each.

    Args:
        humans: The people; there may be none. Those without a name or a number
            are given some that are free: see `name_people`.
        obstacles: The walls that they feel and cannot see through, or the
            world that has them; none by default.
        config: How they take in the world.
        num_robots: How many robots they meet.
        time_step: The time between two steps, in seconds.
        start_jitter: How far x and y of a start are at most from those of the
            configuration, in meters; the seed draws by how much.
        seed: The seed of the default Context, in [0, 2^63). What is drawn of
            starts and weights follows from it; `SetHumansSeed` sets another
            one in any Context.
        separate_trees: Whether each person's tree is a system of its own,
            or one `BehaviorTree` ticks all, which does the same and is faster
            for many; by default, up to 20 people have systems of their own.

    Returns:
        A diagram named "humans" of the systems "crowd" and "behaviors", or
        "crowd", "behavior_0" ..., and "commands" and "behavior_status" that
        join what these give, with the ports of `HumanPorts` by these names.

    Raises:
        BehaviorTreeError: If a behavior is not known, or faulty.
        ValueError: If an argument is out of its range, if two people have the
            same name or number, or if somebody's `max_speed` is below the
            `desired_speed`.
        TypeError: If an argument is of another kind.
    """
    _check_arguments(humans, obstacles, config, num_robots, time_step)
    if isinstance(obstacles, World):
        obstacles = obstacles.obstacles()
    # Before anything is made of them: crowd and trees know the same numbers.
    humans = name_people(humans)
    check_consistent(humans)
    if separate_trees is None:
        separate_trees = len(humans) <= MAX_SEPARATE_TREES
    builder = DiagramBuilder()
    crowd = builder.AddNamedSystem(
        "crowd",
        HumanCrowd(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            start_jitter=start_jitter,
            seed=seed,
        ),
    )
    trees = LoadBehaviors(human.behavior for human in humans)
    everybody = range(len(humans))
    rows_of = {"behaviors": [*everybody]}
    if separate_trees:
        rows_of = {f"behavior_{i}": [i] for i in everybody}
    systems = [
        builder.AddNamedSystem(
            name,
            BehaviorTree(
                [trees[i] for i in rows],
                humans,
                indices=rows,
                num_robots=num_robots,
                time_step=time_step,
                obstacles=obstacles,
            ),
        )
        for name, rows in rows_of.items()
    ]
    builder.Connect(
        _Join(builder, "commands", systems), crowd.get_commands_input_port()
    )
    status = _Join(builder, "behavior_status", systems)
    builder.ExportOutput(crowd.get_human_states_output_port(), "human_states")
    builder.ExportOutput(status, "behavior_status")
    builder.ExportOutput(crowd.get_forces_output_port(), "forces")
    for system in systems:
        builder.Connect(
            crowd.get_human_states_output_port(),
            system.GetInputPort("human_states"),
        )
    if num_robots:
        builder.ExportInput(crowd.get_robot_state_input_port(), "robot_state")
        for system in systems:
            builder.ConnectInput(
                "robot_state", system.GetInputPort("robot_state")
            )
    diagram = builder.Build()
    diagram.set_name("humans")
    return diagram


def _check_arguments(
    humans: Any, obstacles: Any, config: Any, num_robots: Any, time_step: Any
) -> None:
    """Checks of what kind the arguments of `MakeHumans` are.

    Raises:
        TypeError: If one is of another kind.
    """
    known = (Obstacles, World, NoneType)
    check_kind("obstacles", obstacles, known, "Obstacles or a World")
    check_kind("config", config, (CrowdConfig, NoneType), "a CrowdConfig")
    check_kind("num_robots", num_robots, numbers.Integral, "a whole number")
    check_kind("time_step", time_step, numbers.Real, "a number")
    check_kind("humans", humans, Sequence, "a sequence")
    for i, human in enumerate(humans):
        check_kind(f"humans[{i}]", human, HumanConfig, "a HumanConfig")


def _Join(
    builder: DiagramBuilder, name: str, systems: Sequence[BehaviorTree]
) -> OutputPort:
    """Returns one port with what all systems give at the port of a name."""
    ports: list[OutputPort] = [it.GetOutputPort(name) for it in systems]
    if len(ports) == 1:
        return ports[0]
    joined = builder.AddNamedSystem(
        name, Multiplexer([p.size() for p in ports])
    )
    for i, port in enumerate(ports):
        builder.Connect(port, joined.get_input_port(i))
    return joined.get_output_port()


def AddHumans(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    *,
    obstacles: Obstacles | World | None = None,
    config: CrowdConfig | None = None,
    num_robots: int = 1,
    time_step: float = 0.05,
    start_jitter: float = 0.0,
    seed: int = 0,
    separate_trees: bool | None = None,
    name: str = "humans",
) -> HumanPorts:
    """Adds people to a builder, as one system.

    Two robots, say of a plant with `AddBodyState`, meet them so:

        people = AddHumans(
            builder, [HumanConfig(pose=[0, 0, 0])], num_robots=2
        )
        robots = builder.AddSystem(Multiplexer([STATE_SIZE, STATE_SIZE]))
        for i, robot in enumerate(states_of_my_robots):
            builder.Connect(robot, robots.get_input_port(i))
        builder.Connect(robots.get_output_port(), people.robot_state)

    A diagram with behavior trees in it does not convert to AutoDiffXd; a
    `HumanCrowd` alone does.

    Args:
        builder: Where they are added.
        humans: The people; there may be none.
        obstacles: The walls that they feel and cannot see through, or the
            world that has them; none by default.
        config: How they take in the world.
        num_robots: How many robots they meet.
        time_step: The time between two steps, in seconds.
        start_jitter: How far starts are off at most: see `MakeHumans`.
        seed: The seed of the default Context: see `MakeHumans`.
        separate_trees: Whether each tree is a system: see `MakeHumans`.
        name: What the system is called; each in a diagram has its own name.

    Returns:
        The ports of the new system: ``robot_state``, left for the caller to
        connect, takes the robots; ``human_states`` gives where people are,
        ``behavior_status`` who reacts, ``forces`` what moves them. See
        `HumanPorts` for their layouts.

    Raises:
        BehaviorTreeError: If a behavior is not known, or faulty.
        ValueError: As `MakeHumans`, and if the name is taken.
        TypeError: If an argument is of another kind.
    """
    # Drake would end the process when the diagram is built.
    if builder.HasSubsystemNamed(name):
        raise ValueError(
            f"the diagram has a system named {name!r} already: give these"
            " people another name, as in AddHumans(..., name='more_humans')"
        )
    diagram = builder.AddNamedSystem(
        name,
        MakeHumans(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            start_jitter=start_jitter,
            seed=seed,
            separate_trees=separate_trees,
        ),
    )
    return HumanPorts(
        robot_state=diagram.GetInputPort("robot_state") if num_robots else None,
        human_states=diagram.GetOutputPort("human_states"),
        behavior_status=diagram.GetOutputPort("behavior_status"),
        forces=diagram.GetOutputPort("forces"),
    )
