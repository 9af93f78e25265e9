"""Adds people to any diagram."""

from collections.abc import Mapping, Sequence
from functools import partial
import numbers
from types import NoneType
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
)

from hunav_drake.systems.behavior import BehaviorTree, LoadBehaviors
from hunav_drake.systems.behavior.society import SocialOptions
from hunav_drake.systems.common.checks import check_kind
from hunav_drake.systems.common.ports import JoinPorts
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.furniture_places import with_furniture
from hunav_drake.systems.people.names import check_consistent
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.people.profile import complete_people
from hunav_drake.systems.people.traffic import Traffic
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from hunav_drake.tracks.recorded import track_of, with_track

# For more people than this, one system holds all trees.
MAX_SEPARATE_TREES = 10


# The outputs that not all people have.
_OPTIONAL_OUTPUTS = ("traffic", "robot_touches", "replay", "social_signals")


class HumanPorts(NamedTuple):
    """The ports that `AddHumans` leaves to connect.

    Attributes:
        robot_states: Input of m rows (x, y, yaw, vx, vy, omega, radius), one
            for each robot; None without robots.
        human_states: Output of n such rows, one for each person, in W, in SI
            units.
        behavior_status: For each person, 0 while no reaction is active, else
            the state of the reaction, usually 1.
        forces: The forces on each person: see `layout.FORCES`.
        traffic: The numbers of arrivals and departures: see `OpenCrowd`. None
            without traffic.
        robot_touches: How people and robots would collide if they were not
            kept apart: see `HumanCrowd`. None without robots.
        replay: How recorded people are replayed: see `RecordedPeople`. None
            without such people.
        labels: The label of each person in label images, if their figures
            were added to a SceneGraph.
        social_signals: What people show each other, n rows of `layout.Signal`;
            None if nobody's tree has social leaves.
        robot_signals: Input of m such rows, one for each robot; it may stay
            unconnected. None without robots or social leaves.
        crowd: The system that moves people: a `HumanCrowd`, or an `OpenCrowd`
            where people can come and go.
    """

    robot_states: InputPort | None
    human_states: OutputPort
    behavior_status: OutputPort
    forces: OutputPort
    traffic: OutputPort | None = None
    labels: tuple[int, ...] = ()
    robot_touches: OutputPort | None = None
    replay: OutputPort | None = None
    social_signals: OutputPort | None = None
    robot_signals: InputPort | None = None
    crowd: Any = None


class HumanOptions(TypedDict, total=False):
    """The options of `MakeHumans` and `AddHumans`, all by keyword."""

    # The walls, or the world with the walls, where people can see over low
    # objects; none by default.
    obstacles: Obstacles | World | None

    # The motion model of people, and how they perceive the world.
    config: CrowdConfig | None

    # The number of robots that they meet; 1 by default.
    num_robots: int

    # The time between two steps, in seconds; 0.05 by default.
    time_step: float

    # The largest random offset of a start along x and along y, in meters; 0 by
    # default.
    start_jitter: float

    # The seed of the default Context, in [0, 2^63), for drawn starts and
    # weights; 0 by default. `SetHumansSeed` sets another one in any Context.
    seed: int

    # As `CrowdConfig.separate_trees`, and instead of it if it is not None.
    separate_trees: bool | None

    # The places that their behaviors name, beside those that the furniture of
    # the world brings: see `with_furniture`.
    places: Sequence[Place]

    # Whether people can leave without sinks, by `TakeOut` of the crowd, or in
    # a trial by `LeaveOut`; false by default. While all are here, results are
    # the same.
    may_leave: bool

    # The people who arrive at sources and depart at sinks; by default, none.
    # `draw_with_traffic` draws both.
    traffic: Traffic | None


def MakeHumans(
    humans: Sequence[HumanConfig], **options: Unpack[HumanOptions]
) -> Diagram:
    """Makes a diagram of people: their crowd, and a behavior tree for each.

    Args:
        humans: The people; there may be none. People without a name or a
            number get free ones: see `people_names`.
        options: See `HumanOptions`.

    Returns:
        A diagram named "humans" of the systems "crowd" and "behaviors", or
        "crowd", "behavior_0" ..., and "commands", "behavior_status" and, with
        social leaves, "signals", which join their outputs, with the ports of
        `HumanPorts` by these names; "decisions", `HumanDecisions`, if the
        configuration has some; and "recorded", `RecordedPeople`, if people have
        a `track`.

    Raises:
        BehaviorTreeError: If a behavior is unknown or faulty.
        OSError: If a file of recorded people cannot be read.
        ValueError: If an argument is out of its range, if two people have the
            same name or number, or if a person's `max_speed` is below the
            `desired_speed`.
        TypeError: If an argument has the wrong type.
    """
    _check_arguments(humans, options)
    obstacles = options.get("obstacles")
    num_robots = options.get("num_robots", 1)
    time_step = options.get("time_step", 0.05)
    separate_trees = options.get("separate_trees")
    hiding = world = None
    if isinstance(obstacles, World):
        world = obstacles
        hiding = obstacles.sight_obstacles()
        obstacles = obstacles.obstacles()
    # Completed first, so that crowd and trees have the same numbers.
    config = options.get("config") or CrowdConfig()
    tracks = [None if it.track is None else track_of(it.track) for it in humans]
    humans = complete_people(
        [with_track(human) for human in humans], config.profile
    )
    check_consistent(humans)
    if separate_trees is None:
        separate_trees = config.separate_trees
    if separate_trees is None:
        separate_trees = len(humans) <= MAX_SEPARATE_TREES
    builder = DiagramBuilder()
    traffic = options.get("traffic")
    make_crowd: Any = HumanCrowd
    make_tree = BehaviorTree
    recorded = None
    if any(tracks):
        # Imported here, as below: rarely used, and slow to load.
        from hunav_drake.systems.crowd.recorded_people import RecordedPeople

        recorded = RecordedPeople(
            tracks, humans, num_robots=num_robots, time_step=time_step
        )
    may_leave = bool(options.get("may_leave")) and len(humans) > 0
    if traffic is not None or recorded is not None or may_leave:
        from hunav_drake.systems.behavior.open_behavior_tree import (
            OpenBehaviorTree,
        )
        from hunav_drake.systems.crowd.open_crowd import OpenCrowd

        first = None if recorded is None else recorded.StartRows()
        make_crowd = partial(OpenCrowd, traffic=traffic, tracks=first)
        make_tree = OpenBehaviorTree
    crowd = builder.AddNamedSystem(
        "crowd",
        make_crowd(
            humans,
            obstacles=obstacles,
            config=config,
            num_robots=num_robots,
            time_step=time_step,
            start_jitter=options.get("start_jitter", 0.0),
            seed=options.get("seed", 0),
        ),
    )
    trees = LoadBehaviors(
        (it.behavior for it in humans), profile=config.profile
    )
    is_social = any(it.is_social for it in trees)
    places = options.get("places", ())
    if is_social and world is not None:
        places = with_furniture(places, world)
    everybody = range(len(humans))
    rows_of = {"behaviors": [*everybody]}
    if separate_trees:
        rows_of = {f"behavior_{i}": [i] for i in everybody}
    systems = [
        builder.AddNamedSystem(
            name,
            make_tree(
                [trees[i] for i in rows],
                humans,
                indices=rows,
                num_robots=num_robots,
                time_step=time_step,
                obstacles=obstacles,
                sight_obstacles=hiding,
                social=SocialOptions(
                    places=places,
                    signals=is_social,
                    seed=options.get("seed", 0),
                ),
            ),
        )
        for name, rows in rows_of.items()
    ]
    states = crowd.GetOutputPort("human_states")
    for system in systems:
        builder.Connect(states, system.GetInputPort("human_states"))
    commands, status = (
        JoinPorts(builder, name, [it.GetOutputPort(name) for it in systems])
        for name in ("commands", "behavior_status")
    )
    if is_social:
        signals = JoinPorts(
            builder, "signals", [it.GetOutputPort("signals") for it in systems]
        )
        for system in systems:
            builder.Connect(signals, system.GetInputPort("social_signals"))
        builder.ExportOutput(signals, "social_signals")
    if config.decisions is not None and humans:
        from hunav_drake.systems.crowd.human_decisions import HumanDecisions

        decisions = builder.AddNamedSystem(
            "decisions",
            HumanDecisions(
                humans,
                config.decisions,
                obstacles=obstacles if config.route_planning else None,
                time_step=time_step,
                seed=options.get("seed", 0),
            ),
        )
        builder.Connect(states, decisions.GetInputPort("human_states"))
        builder.Connect(commands, decisions.GetInputPort("commands"))
        commands = decisions.GetOutputPort("commands")
    users = [*systems]
    if recorded is not None:
        builder.AddNamedSystem("recorded", recorded)
        builder.Connect(states, recorded.GetInputPort("human_states"))
        builder.Connect(commands, recorded.GetInputPort("commands"))
        commands = recorded.GetOutputPort("commands")
        tracks_port = recorded.GetOutputPort("tracks")
        builder.Connect(tracks_port, crowd.GetInputPort("tracks"))
        builder.ExportOutput(recorded.GetOutputPort("replay"), "replay")
        users.append(recorded)
    builder.Connect(commands, crowd.GetInputPort("commands"))
    builder.ExportOutput(states, "human_states")
    builder.ExportOutput(status, "behavior_status")
    names = ["forces", "robot_touches"]
    names += [] if traffic is None else ["traffic"]
    for name in names:
        if crowd.HasOutputPort(name):
            builder.ExportOutput(crowd.GetOutputPort(name), name)
    if num_robots:
        builder.ExportInput(crowd.GetInputPort("robot_states"), "robot_states")
        for system in users:
            builder.ConnectInput(
                "robot_states", system.GetInputPort("robot_states")
            )
    if num_robots and is_social:
        first, *others = (it.GetInputPort("robot_signals") for it in systems)
        builder.ExportInput(first, "robot_signals")
        for port in others:
            builder.ConnectInput("robot_signals", port)
    diagram = builder.Build()
    diagram.set_name("humans")
    return diagram


def _check_arguments(humans: Any, options: Mapping[str, Any]) -> None:
    """Raises a TypeError for a wrong type or an unknown option."""
    kinds: dict[str, tuple[Any, str]] = {
        "obstacles": ((Obstacles, World, NoneType), "Obstacles or a World"),
        "config": ((CrowdConfig, NoneType), "a CrowdConfig"),
        "num_robots": (numbers.Integral, "a whole number"),
        "time_step": (numbers.Real, "a number"),
        "start_jitter": (numbers.Real, "a number"),
        "traffic": ((Traffic, NoneType), "a Traffic"),
        "places": (Sequence, "a sequence"),
    }
    known = HumanOptions.__annotations__
    for name, value in options.items():
        if name not in known:
            raise TypeError(
                f"{name!r} is no option of people{did_you_mean(name, known)}"
                f" (there are: {', '.join(known)})"
            )
        if name in kinds:
            check_kind(name, value, *kinds[name])
        elif name in ("separate_trees", "may_leave") and not (
            value is None or isinstance(value, bool | np.bool_)
        ):
            raise TypeError(f"{name} must be True or False, got {value!r:.80}")
    for i, place in enumerate(options.get("places", ())):
        check_kind(f"places[{i}]", place, Place, "a Place")
    check_kind("humans", humans, Sequence, "a sequence")
    for i, human in enumerate(humans):
        check_kind(f"humans[{i}]", human, HumanConfig, "a HumanConfig")


def AddHumans(
    builder: DiagramBuilder,
    humans: Sequence[HumanConfig],
    *,
    name: str = "humans",
    scene_graph: Any = None,
    **options: Unpack[HumanOptions],
) -> HumanPorts:
    """Adds people to a builder, as one system.

    They meet two robots, for instance of a plant with `AddBodyState`, so:

        people = AddHumans(
            builder, [HumanConfig(pose=[0, 0, 0])], num_robots=2
        )
        robots = builder.AddSystem(Multiplexer([STATE_SIZE, STATE_SIZE]))
        for i, robot in enumerate(states_of_my_robots):
            builder.Connect(robot, robots.get_input_port(i))
        builder.Connect(robots.get_output_port(), people.robot_states)

    With ``scene_graph``, their figures walk in your SceneGraph, where your
    cameras and visualizers see them:

        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
        people = AddHumans(builder, humans, scene_graph=scene_graph)

    A diagram with behavior trees does not convert to AutoDiffXd; a
    `HumanCrowd` alone does.

    Args:
        builder: The builder.
        humans: The people; there may be none.
        name: The name of the system, unique in the diagram.
        scene_graph: A SceneGraph of the same builder that gets figures of the
            people, from a system named `name` plus "_figures". Plants do not
            collide with them.
        options: See `HumanOptions`.

    Returns:
        The ports of the new system. The caller connects the input
        ``robot_states``; ``human_states``, ``behavior_status`` and ``forces``
        are outputs. See `HumanPorts` for their layouts.

    Raises:
        BehaviorTreeError: If a behavior is unknown or faulty.
        ValueError: As in `MakeHumans`, and if the name is taken or the
            SceneGraph is in another builder.
        TypeError: If an argument has the wrong type.
    """
    # Drake would end the process when the diagram is built.
    if builder.HasSubsystemNamed(name):
        raise ValueError(
            f"the diagram has a system named {name!r} already: give these"
            " people another name, as in AddHumans(..., name='more_humans')"
        )
    if scene_graph is not None:
        # Imported here: people alone do not need geometry.
        from hunav_drake.systems.scene.figures import AddFigures, check_place

        check_place(builder, scene_graph, f"{name}_figures")
    diagram = builder.AddNamedSystem(name, MakeHumans(humans, **options))
    labels: tuple[int, ...] = ()
    if scene_graph is not None:
        figures = AddFigures(
            builder,
            scene_graph,
            humans,
            time_step=options.get("time_step", 0.05),
            name=f"{name}_figures",
            lively=diagram.HasOutputPort("social_signals"),
        )
        if figures.social_signals is not None:
            builder.Connect(
                diagram.GetOutputPort("social_signals"), figures.social_signals
            )
        builder.Connect(
            diagram.GetOutputPort("human_states"), figures.human_states
        )
        labels = figures.labels
    return HumanPorts(
        **{
            name: diagram.GetInputPort(name)
            if diagram.HasInputPort(name)
            else None
            for name in ("robot_states", "robot_signals")
        },
        human_states=diagram.GetOutputPort("human_states"),
        behavior_status=diagram.GetOutputPort("behavior_status"),
        forces=diagram.GetOutputPort("forces"),
        labels=labels,
        crowd=diagram.GetSubsystemByName("crowd"),
        **{
            name: diagram.GetOutputPort(name)
            for name in _OPTIONAL_OUTPUTS
            if diagram.HasOutputPort(name)
        },
    )
