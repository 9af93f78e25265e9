"""The blocks of a trial's diagram, each added by a separate function."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import TYPE_CHECKING
import zlib

from pydrake.systems.framework import (
    DiagramBuilder,
    InputPort,
    OutputPort,
    System,
)
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.scenario.checks import first_lidar, scan_fault
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.fleet import (
    RobotPart,
    robot_parts,
    robots_of,
    with_parts,
)
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.behavior.library import sayings_of
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.ports import CheckPorts
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation import Evaluator, EvaluatorConfig
from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
from hunav_drake.systems.people.figure_config import Figures, figure_rows
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.people.starts import draw_starts
from hunav_drake.systems.people.traffic import Traffic
from hunav_drake.systems.planning import PlanningTask
from hunav_drake.systems.planning.planner import asked_scan_size
from hunav_drake.systems.robot import DiscContacts, RobotTask
from hunav_drake.systems.robot.robot_config import MOUNT, RobotConfig
from hunav_drake.systems.robot.robots import AddPhysicalRobots, PhysicalRobot
from hunav_drake.systems.scene import AddScene, SceneInputs, ScenePorts
from hunav_drake.systems.scene.scene_config import COSTMAPS, Rays
from hunav_drake.systems.sensing.delay import AddDelay
from hunav_drake.systems.sensing.sensor_config import (
    LidarConfig,
    Rendering,
    SensingTask,
    name_sensors,
)
from hunav_drake.systems.sensing.sensor_parameters import Delayed
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import AddHumans, HumanPorts

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


EACH_STEP = "encounters"
"""The name of the system that records each time step, if there is one."""

# The number of the planner's perception and localization, beside sensors: their
# draws do not depend on the number of sensors.
_OF_PLANNER = 999

# Output ports by the names of the inputs that they are for; None for a port
# that the trial does not have.
Ports = Mapping[str, OutputPort | None]


def ConnectByName(
    builder: DiagramBuilder, ports: Ports, *systems: System
) -> None:
    """Connects ports to the inputs of systems that have the same names."""
    for system in systems:
        for name, port in ports.items():
            if port is not None and system.HasInputPort(name):
                builder.Connect(port, system.GetInputPort(name))


def with_prefix(ports: Ports, part: RobotPart) -> Ports:
    """Returns ports by their names in a trial, with that of their robot."""
    return {part.prefix + name: port for name, port in ports.items()}


def _port_of(system: System, name: str) -> OutputPort | None:
    return system.GetOutputPort(name) if system.HasOutputPort(name) else None


def with_planner_lidar(scenario: Scenario) -> Scenario:
    """Returns a scenario with a lidar for each planner that sees by it only.

    An added lidar is that of `sensors: [{type: lidar}]` with the period of the
    planner, so that each scan is taken when it is used.
    """
    parts = robot_parts(scenario)
    return with_parts(
        scenario,
        [it._replace(scenario=_with_lidar(it.scenario)) for it in parts],
    )


def _with_lidar(scenario: Scenario) -> Scenario:
    planner = scenario.planner
    if not planner.sees.by_lidar or first_lidar(scenario) is not None:
        return scenario
    lidar = LidarConfig(period=planner.period)
    if size := asked_scan_size(planner):
        lidar = dataclasses.replace(lidar, num_rays=size)
    return dataclasses.replace(scenario, sensors=[*scenario.sensors, lidar])


def AddPeople(
    builder: DiagramBuilder,
    scenario: Scenario,
    traffic: Traffic | None,
    *,
    may_leave: bool = False,
) -> HumanPorts:
    """Adds all people of a scenario to a builder, as "humans".

    `traffic` has the arrivals at sources and the departures at sinks; with
    `may_leave`, people can be left out without: see `LeaveOut`.
    """
    crowd, simulation = scenario.crowd, scenario.simulation
    robots = [part.scenario.robot for part in robot_parts(scenario)]
    if crowd.robots_stop is None:
        stop = any(robot.physical for robot in robots)
        crowd = dataclasses.replace(crowd, robots_stop=stop)
    return AddHumans(
        builder,
        scenario.humans,
        obstacles=scenario.world,
        config=crowd,
        num_robots=len(robots),
        time_step=simulation.time_step,
        start_jitter=simulation.start_jitter,
        seed=simulation.seed,
        places=scenario.places,
        traffic=traffic,
        may_leave=may_leave,
    )


@dataclasses.dataclass(frozen=True)
class RobotPorts:
    """The ports of a robot that `AddRobots` leaves to connect.

    Attributes:
        systems: The robot, and "contacts" if it does not count contacts itself.
        velocity_command: Input (v, omega), in m/s and rad/s.
        robot_state: State of the robot in W: see `layout`.
        contacts: A row of `layout.Contact` for each person.
        wall_contact: Such a row for the walls; None if it is unknown.
        feels_forces: Whether contact forces are computed.
    """

    systems: tuple[System, ...]
    velocity_command: InputPort
    robot_state: OutputPort
    contacts: OutputPort
    wall_contact: OutputPort | None
    feels_forces: bool


def AddRobots(
    builder: DiagramBuilder, parts: Sequence[RobotPart], obstacles: Obstacles
) -> list[RobotPorts]:
    """Adds the robots of a scenario to a builder, each as "robot".

    Those that are bodies of a plant are in one plant. For each other one,
    "contacts" counts its contacts with people.
    """
    scenario = parts[0].scenario
    humans, simulation = scenario.humans, scenario.simulation
    starts = draw_starts(humans, simulation.seed, simulation.start_jitter)
    configs = [part.scenario.robot for part in parts]

    def task_beside(others: Sequence[RobotConfig]) -> RobotTask:
        return RobotTask(
            time_step=simulation.time_step,
            obstacles=obstacles,
            humans=humans,
            human_starts=starts,
            robots=others,
        )

    physical = {
        f"{part.prefix}robot": part.scenario.robot
        for part in parts
        if isinstance(part.scenario.robot, PhysicalRobot)
    }
    bodies: dict[str, System] = {}
    if len(parts) > 1 and physical:
        others = [it for it in configs if not isinstance(it, PhysicalRobot)]
        added = AddPhysicalRobots(builder, physical, task_beside(others))
        bodies = dict(zip(physical, added, strict=True))
    ports = []
    for i, part in enumerate(parts):
        name = f"{part.prefix}robot"
        robot = bodies.get(name)
        if robot is None:
            task = task_beside(configs[:i] + configs[i + 1 :])
            robot = part.scenario.robot.AddToBuilder(builder, task, name=name)
        systems = [robot]
        feels_forces = robot.HasOutputPort("contacts")
        if not feels_forces:
            discs = DiscContacts(humans, time_step=simulation.time_step)
            name = f"{part.prefix}contacts"
            systems.append(builder.AddNamedSystem(name, discs))
        ports.append(
            RobotPorts(
                systems=tuple(systems),
                velocity_command=robot.GetInputPort("velocity_command"),
                robot_state=robot.GetOutputPort("robot_state"),
                contacts=systems[-1].GetOutputPort("contacts"),
                wall_contact=_port_of(robot, "wall_contact"),
                feels_forces=feels_forces,
            )
        )
    return ports


@dataclasses.dataclass(frozen=True)
class PlannerPorts:
    """The ports that `AddPlanner` leaves to connect.

    Attributes:
        system: The planner, whose inputs are connected by name.
        velocity_command: Output (v, omega), in m/s and rad/s.
        status: A `PlannerStatus`.
        path: The path that the planner follows.
        costmaps: The costmaps of a planner with maps, by name.
    """

    system: System
    velocity_command: OutputPort
    status: OutputPort
    path: OutputPort
    costmaps: Ports


def AddPlanner(
    builder: DiagramBuilder,
    part: RobotPart,
    obstacles: Obstacles,
    num_others: int = 0,
) -> PlannerPorts:
    """Adds the planner of a robot to a builder, as "planner".

    Besides people, it gets the rows of `num_others` other robots.

    Raises:
        ScenarioError: If the scenario lacks the scan that the planner needs.
    """
    scenario = part.scenario
    robot, planner = scenario.robot, scenario.planner
    by_lidar = planner.sees.by_lidar
    task = PlanningTask(
        limits=robot.limits,
        robot_radius=robot.radius,
        goal_tolerance=robot.goal_tolerance,
        goal_yaw_tolerance=robot.goal_yaw_tolerance,
        obstacles=obstacles,
        num_humans=0
        if by_lidar
        else len(scenario.humans) + num_others + planner.sees.num_false_rows,
        time_step=scenario.simulation.time_step,
        lidar=first_lidar(scenario),
        on_error="stop" if part.name else "raise",
        robot_name=part.name,
    )
    system = planner.AddToBuilder(builder, task, name=f"{part.prefix}planner")
    message = ""
    if system.HasInputPort("scan"):
        message = scan_fault(scenario, system.GetInputPort("scan").size())
    elif by_lidar:
        message = (
            f"the planner {name_of(planner)!r} has no input port scan, so it"
            " would see nobody; give it one, or sees: visible"
        )
    if message:
        fault = Fault("scenario", 0, "planner", message)
        raise ScenarioError("scenario", [fault])
    return PlannerPorts(
        system=system,
        velocity_command=system.GetOutputPort("velocity_command"),
        status=system.GetOutputPort("status"),
        path=system.GetOutputPort("path"),
        costmaps={name: _port_of(system, name) for name in COSTMAPS},
    )


def AddEvaluators(
    builder: DiagramBuilder,
    part: RobotPart,
    obstacles: Obstacles,
    feels_forces: bool,
) -> list[Evaluator]:
    """Adds the system that records a robot to a builder, as "evaluator".

    For exact encounters, "encounters" records each time step of the whole trial
    if the other one does not. `feels_forces` says whether contact forces are
    computed.
    """
    scenario = part.scenario
    robot, time_step = scenario.robot, scenario.simulation.time_step
    config = scenario.evaluator
    if part.name:
        # (Several robots reach their goals one after the other.)
        config = dataclasses.replace(config, stop_at_goal=False)
    configs = {"evaluator": config}
    if config.encounters and config.period > time_step:
        configs[EACH_STEP] = EvaluatorConfig(period=time_step)
    return [
        builder.AddNamedSystem(
            f"{part.prefix}{name}",
            Evaluator(
                scenario.humans,
                config=it,
                time_step=time_step,
                goal_tolerance=robot.goal_tolerance,
                goal_yaw_tolerance=robot.goal_yaw_tolerance,
                robot_max_speed=robot.limits.max_speed,
                obstacles=obstacles,
                feels_forces=feels_forces,
            ),
        )
        for name, it in configs.items()
    ]


def AddMonitor(builder: DiagramBuilder, part: RobotPart) -> TrialMonitor:
    """Adds the system that detects the end of a robot, as "monitor"."""
    robot, simulation = part.scenario.robot, part.scenario.simulation
    monitor: TrialMonitor = builder.AddNamedSystem(
        f"{part.prefix}monitor",
        TrialMonitor(
            goal_tolerance=robot.goal_tolerance,
            goal_yaw_tolerance=robot.goal_yaw_tolerance,
            stuck_time=simulation.stuck_time,
            stuck_distance=simulation.stuck_distance,
            time_step=simulation.time_step,
        ),
    )
    return monitor


def AddTrialScene(
    builder: DiagramBuilder,
    scenario: Scenario,
    meshcat: "Meshcat | None",
    *,
    is_social: bool,
    drawn: bool,
) -> ScenePorts:
    """Adds the scene of a trial to a builder, as "scene".

    `is_social` is whether people show each other what they do. A scene that
    is not `drawn` has geometry nevertheless if sensors or Meshcat may see it.
    """
    parts = robot_parts(scenario)
    seen = meshcat is not None or any(it.scenario.sensors for it in parts)
    rays = {}
    for part in parts:
        if lidar := first_lidar(part.scenario):
            x, y, yaw = lidar.pose
            rays[part.name] = Rays(
                yaw + lidar.angles(),
                (x, y),
                lidar.range_max,
                lidar.mount == "robot",
            )
    sayings = None
    if is_social:
        behaviors = (it.behavior for it in scenario.humans)
        sayings = sayings_of(behaviors, profile=scenario.crowd.profile)
    return AddScene(
        builder,
        scenario.world,
        scenario.humans,
        robots_of(scenario),
        time_step=scenario.simulation.time_step,
        meshcat=meshcat,
        config=scenario.scene,
        inputs=SceneInputs(
            scan_angles=rays, sayings=sayings, drawn=drawn or seen
        ),
    )


def AddGoal(builder: DiagramBuilder, part: RobotPart) -> OutputPort | None:
    """Adds the goal of a robot to a builder, as "goal", if there is one."""
    goal = part.scenario.robot.goal
    if goal is None:
        return None
    name = f"{part.prefix}goal"
    source = builder.AddNamedSystem(name, ConstantVectorSource(goal))
    return source.get_output_port()


def AddSensors(
    builder: DiagramBuilder, part: RobotPart, scene: ScenePorts, given: Ports
) -> dict[str, OutputPort]:
    """Adds the sensors of a robot to a builder.

    Each is a system named "sensor_" plus its name. Its inputs are connected to
    the `given` ports of the trial and to the scene, which cameras see.

    Returns:
        The outputs of the sensors. The first output of a name, such as "scan",
        has this name; the key of a later one is the name of its sensor, "_",
        and the name of the output.
    """
    scenario = part.scenario
    given = {**given, "query_object": scene.query_object}
    outputs: dict[str, OutputPort] = {}
    names = name_sensors(scenario.sensors)
    for i, (name, sensor) in enumerate(
        zip(names, scenario.sensors, strict=True)
    ):
        task = _sensing_task(part, given, i, _Rendering(scene, part))
        name_in_trial = f"{part.prefix}sensor_{name}"
        system = sensor.AddToBuilder(builder, task, name=name_in_trial)
        ConnectByName(builder, given, system)
        for k in range(system.num_output_ports()):
            port = system.get_output_port(k)
            key = port.get_name()
            outputs[f"{name}_{key}" if key in outputs else key] = port
    return outputs


def AddPerception(
    builder: DiagramBuilder, part: RobotPart, given: Ports, everything: Ports
) -> Ports:
    """Adds what the planner perceives of people, as "perception".

    Nothing is added if the planner sees everything, which are the ports
    `everything`, where they differ from those `given`.

    Returns:
        The ports for the planner: those `given`, with the perceived people.

    Raises:
        TypeError: If the system of a user-defined perception lacks a port.
    """
    sees = part.scenario.planner.sees
    name = f"{part.prefix}perception"
    if sees.by_lidar:
        nobody = builder.AddNamedSystem(name, ConstantVectorSource([]))
        return {**given, "human_states": nobody.get_output_port()}
    task = _sensing_task(part, given, _OF_PLANNER)
    system = sees.MakeSystem(task)
    if system is None:
        return {**given, **everything}
    CheckPorts(
        system,
        f"the perception {type(sees).__name__}",
        inputs={},
        outputs={
            "visible_people": STATE_SIZE
            * (task.num_humans + task.num_other_robots + sees.num_false_rows)
        },
    )
    builder.AddNamedSystem(name, system)
    names = (
        *("robot_state", "human_states"),
        *("other_robot_states", "social_signals"),
    )
    seen = {name: given[name] for name in names if name in given}
    ConnectByName(builder, seen, system)
    return {**given, "human_states": system.GetOutputPort("visible_people")}


def AddLocalization(
    builder: DiagramBuilder, part: RobotPart, given: Ports, seen: Ports
) -> Ports:
    """Adds what the planner knows of its robot's pose, as "localization".

    People are moved with the robot, and then delayed, if they are, by
    "perception_delay". Nothing is added if the pose is exact.

    Returns:
        The ports for the planner: those `seen` (see `AddPerception`), with the
        estimated pose also as "estimated_robot_state", if there is one.

    Raises:
        TypeError: If the system of a user-defined localization lacks a port.
    """
    planner = part.scenario.planner
    people = seen["human_states"]
    assert people is not None
    task = dataclasses.replace(
        _sensing_task(part, given, _OF_PLANNER),
        num_humans=people.size() // STATE_SIZE,
    )
    system = planner.localization.MakeSystem(task)
    if system is not None:
        sizes = {"robot_state": STATE_SIZE, "people": people.size()}
        sizes = {name: size for name, size in sizes.items() if size}
        CheckPorts(
            system,
            f"the localization {type(planner.localization).__name__}",
            inputs=sizes,
            outputs={f"estimated_{name}": sizes[name] for name in sizes},
        )
        builder.AddNamedSystem(f"{part.prefix}localization", system)
        ports = {"robot_state": given["robot_state"], "people": people}
        ConnectByName(builder, ports, system)
        people = _port_of(system, "estimated_people") or people
        estimate = system.GetOutputPort("estimated_robot_state")
        seen = {**seen, "estimated_robot_state": estimate}
        seen = {**seen, "robot_state": estimate}
    if isinstance(planner.sees, Delayed):
        people = AddDelay(
            builder,
            f"{part.prefix}perception_delay",
            *(people, planner.sees.delay, task.time_step),
        )
    return {**seen, "human_states": people}


def _sensing_task(
    part: RobotPart,
    given: Ports,
    number: int,
    rendering: Rendering | None = None,
) -> SensingTask:
    others = given.get("other_robot_states")
    return SensingTask(
        world=part.scenario.world,
        num_humans=len(part.scenario.humans),
        num_other_robots=others.size() // STATE_SIZE if others else 0,
        time_step=part.scenario.simulation.time_step,
        seed=part.scenario.simulation.seed,
        # (By name, so that the order of robots does not matter.)
        number=number + 1000 * zlib.crc32(part.name.encode()),
        rendering=rendering,
        figures=Figures(
            figure_rows([it.figure for it in part.scenario.humans]),
            lively=given.get("social_signals") is not None,
            ids=people_ids(part.scenario.humans),
        ),
    )


def _Rendering(scene: ScenePorts, part: RobotPart) -> Rendering:
    """Returns the scene of the trial's cameras and the frames they are on."""
    plant = scene.plant
    frames = {"world": scene.scene_graph.world_frame_id()}
    name = part.name or "robot"
    if plant.HasModelInstanceNamed(name):
        robot = plant.GetModelInstanceByName(name)
        carrier = plant.GetBodyIndices(robot)[0]
        if plant.HasBodyNamed(MOUNT, robot):
            carrier = plant.GetBodyByName(MOUNT, robot).index()
        frames["robot"] = plant.GetBodyFrameIdOrThrow(carrier)
    return Rendering(scene.scene_graph, frames)
