"""The blocks of a trial's diagram, each added by a separate function."""

from collections.abc import Mapping
import dataclasses
from typing import TYPE_CHECKING

from pydrake.systems.framework import (
    DiagramBuilder,
    InputPort,
    OutputPort,
    System,
)
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.scenario.checks import first_lidar, scan_fault
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.ports import CheckPorts
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
from hunav_drake.systems.people.starts import draw_starts
from hunav_drake.systems.people.traffic import Traffic
from hunav_drake.systems.planning import PlanningTask
from hunav_drake.systems.planning.planner import asked_scan_size
from hunav_drake.systems.robot import DiscContacts, RobotTask
from hunav_drake.systems.scene import AddScene, ScenePorts
from hunav_drake.systems.scene.scene_config import COSTMAPS
from hunav_drake.systems.sensing.sensor_config import (
    LidarConfig,
    Rendering,
    SensingTask,
    name_sensors,
)
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import AddHumans, HumanPorts

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


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


def _port_of(system: System, name: str) -> OutputPort | None:
    return system.GetOutputPort(name) if system.HasOutputPort(name) else None


def with_planner_lidar(scenario: Scenario) -> Scenario:
    """Returns a scenario with a lidar, if its planner sees by lidar only.

    An added lidar is that of `sensors: [{type: lidar}]` with the period of the
    planner, so that each scan is taken when it is used.
    """
    planner = scenario.planner
    if not planner.sees.by_lidar or first_lidar(scenario) is not None:
        return scenario
    lidar = LidarConfig(period=planner.period)
    if size := asked_scan_size(planner):
        lidar = dataclasses.replace(lidar, num_rays=size)
    return dataclasses.replace(scenario, sensors=[*scenario.sensors, lidar])


def AddPeople(
    builder: DiagramBuilder, scenario: Scenario, traffic: Traffic | None
) -> HumanPorts:
    """Adds all people of a scenario to a builder, as "humans".

    `traffic` has the arrivals at sources and the departures at sinks.
    """
    crowd, simulation = scenario.crowd, scenario.simulation
    if crowd.robots_stop is None:
        crowd = dataclasses.replace(crowd, robots_stop=scenario.robot.physical)
    return AddHumans(
        builder,
        scenario.humans,
        obstacles=scenario.world,
        config=crowd,
        time_step=simulation.time_step,
        start_jitter=simulation.start_jitter,
        seed=simulation.seed,
        traffic=traffic,
    )


@dataclasses.dataclass(frozen=True)
class RobotPorts:
    """The ports that `AddRobot` leaves to connect.

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


def AddRobot(
    builder: DiagramBuilder, scenario: Scenario, obstacles: Obstacles
) -> RobotPorts:
    """Adds the robot of a scenario to a builder, as "robot".

    Unless the robot is a body of a plant, "contacts" counts its contacts with
    people.
    """
    humans, simulation = scenario.humans, scenario.simulation
    starts = draw_starts(humans, simulation.seed, simulation.start_jitter)
    task = RobotTask(
        time_step=simulation.time_step,
        obstacles=obstacles,
        humans=humans,
        human_starts=starts,
    )
    robot = scenario.robot.AddToBuilder(builder, task)
    systems = [robot]
    feels_forces = robot.HasOutputPort("contacts")
    if not feels_forces:
        discs = DiscContacts(humans, time_step=simulation.time_step)
        systems.append(builder.AddNamedSystem("contacts", discs))
    return RobotPorts(
        systems=tuple(systems),
        velocity_command=robot.GetInputPort("velocity_command"),
        robot_state=robot.GetOutputPort("robot_state"),
        contacts=systems[-1].GetOutputPort("contacts"),
        wall_contact=_port_of(robot, "wall_contact"),
        feels_forces=feels_forces,
    )


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
    builder: DiagramBuilder, scenario: Scenario, obstacles: Obstacles
) -> PlannerPorts:
    """Adds the planner of a scenario to a builder, as "planner".

    Raises:
        ScenarioError: If the scenario lacks the scan that the planner needs.
    """
    robot, planner = scenario.robot, scenario.planner
    by_lidar = planner.sees.by_lidar
    task = PlanningTask(
        limits=robot.limits,
        robot_radius=robot.radius,
        goal_tolerance=robot.goal_tolerance,
        goal_yaw_tolerance=robot.goal_yaw_tolerance,
        obstacles=obstacles,
        num_humans=0 if by_lidar else len(scenario.humans),
        time_step=scenario.simulation.time_step,
        lidar=first_lidar(scenario),
    )
    system = planner.AddToBuilder(builder, task)
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


def AddEvaluator(
    builder: DiagramBuilder,
    scenario: Scenario,
    obstacles: Obstacles,
    feels_forces: bool,
) -> Evaluator:
    """Adds the system that records a trial to a builder, as "evaluator".

    `feels_forces` says whether contact forces are computed.
    """
    robot = scenario.robot
    evaluator: Evaluator = builder.AddNamedSystem(
        "evaluator",
        Evaluator(
            scenario.humans,
            config=scenario.evaluator,
            time_step=scenario.simulation.time_step,
            goal_tolerance=robot.goal_tolerance,
            goal_yaw_tolerance=robot.goal_yaw_tolerance,
            robot_max_speed=robot.limits.max_speed,
            obstacles=obstacles,
            feels_forces=feels_forces,
        ),
    )
    return evaluator


def AddMonitor(builder: DiagramBuilder, scenario: Scenario) -> TrialMonitor:
    """Adds the system that detects the end of a trial, as "monitor"."""
    robot, simulation = scenario.robot, scenario.simulation
    monitor: TrialMonitor = builder.AddNamedSystem(
        "monitor",
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
    builder: DiagramBuilder, scenario: Scenario, meshcat: "Meshcat | None"
) -> ScenePorts:
    """Adds the scene of a trial to a builder, as "scene"."""
    scan_angles = (
        sensor.pose[2] + sensor.angles()
        for sensor in scenario.sensors
        if isinstance(sensor, LidarConfig) and sensor.mount == "robot"
    )
    return AddScene(
        builder,
        scenario.world,
        scenario.humans,
        scenario.robot,
        time_step=scenario.simulation.time_step,
        meshcat=meshcat,
        config=scenario.scene,
        scan_angles=next(scan_angles, None),
    )


def AddGoal(builder: DiagramBuilder, scenario: Scenario) -> OutputPort | None:
    """Adds the goal of the robot to a builder, as "goal", if there is one."""
    if scenario.robot.goal is None:
        return None
    source = ConstantVectorSource(scenario.robot.goal)
    return builder.AddNamedSystem("goal", source).get_output_port()


def AddSensors(
    builder: DiagramBuilder, scenario: Scenario, scene: ScenePorts, given: Ports
) -> dict[str, OutputPort]:
    """Adds the sensors of a scenario to a builder.

    Each is a system named "sensor_" plus its name. Its inputs are connected to
    the `given` ports of the trial and to the scene, which cameras see.

    Returns:
        The outputs of the sensors. The first output of a name, such as "scan",
        has this name; the key of a later one is the name of its sensor, "_",
        and the name of the output.
    """
    given = {**given, "query_object": scene.query_object}
    outputs: dict[str, OutputPort] = {}
    names = name_sensors(scenario.sensors)
    for i, (name, sensor) in enumerate(
        zip(names, scenario.sensors, strict=True)
    ):
        task = _sensing_task(scenario, i, _Rendering(scene))
        system = sensor.AddToBuilder(builder, task, name=f"sensor_{name}")
        ConnectByName(builder, given, system)
        for k in range(system.num_output_ports()):
            port = system.get_output_port(k)
            key = port.get_name()
            outputs[f"{name}_{key}" if key in outputs else key] = port
    return outputs


def AddPerception(
    builder: DiagramBuilder, scenario: Scenario, given: Ports
) -> Ports:
    """Adds the planner's perception of people, as "perception".

    Nothing is added if the planner sees everything.

    Returns:
        The ports for the planner: those `given`, with the perceived people.

    Raises:
        TypeError: If the system of a user-defined perception lacks a port.
    """
    sees = scenario.planner.sees
    if sees.by_lidar:
        nobody = builder.AddNamedSystem("perception", ConstantVectorSource([]))
        return {**given, "human_states": nobody.get_output_port()}
    number = len(scenario.sensors)
    system = sees.MakeSystem(_sensing_task(scenario, number))
    if system is None:
        return given
    CheckPorts(
        system,
        f"the perception {type(sees).__name__}",
        inputs={},
        outputs={"visible_people": STATE_SIZE * len(scenario.humans)},
    )
    builder.AddNamedSystem("perception", system)
    seen = {name: given[name] for name in ("robot_state", "human_states")}
    ConnectByName(builder, seen, system)
    return {**given, "human_states": system.GetOutputPort("visible_people")}


def _sensing_task(
    scenario: Scenario, number: int, rendering: Rendering | None = None
) -> SensingTask:
    return SensingTask(
        world=scenario.world,
        num_humans=len(scenario.humans),
        time_step=scenario.simulation.time_step,
        seed=scenario.simulation.seed,
        number=number,
        rendering=rendering,
    )


def _Rendering(scene: ScenePorts) -> Rendering:
    """Returns the scene of the trial's cameras and the frames they are on."""
    plant = scene.plant
    frames = {"world": scene.scene_graph.world_frame_id()}
    if scene.robot_state is not None:
        robot = plant.GetModelInstanceByName("robot")
        base = plant.GetBodyIndices(robot)[0]
        frames["robot"] = plant.GetBodyFrameIdOrThrow(base)
    return Rendering(scene.scene_graph, frames)
