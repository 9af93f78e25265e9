"""The blocks of a trial's diagram, each added by a function of its own."""

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
    """Returns a scenario that has a lidar if its planner sees by one.

    What is added is as `sensors: [{type: lidar}]`, but with the period of the
    planner, so that each scan is of the instant when it is used.
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
    """Adds the people of a scenario to a builder, as "humans".

    Args:
        builder: Where the trial is.
        scenario: Lists all of them.
        traffic: Who of them comes in at a source, and leaves at a sink.
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
    """What `AddRobot` leaves to connect.

    Attributes:
        systems: The robot, and "contacts" if it does not count them itself.
        velocity_command: Takes (v, omega), in m/s and rad/s.
        robot_state: Gives the row of the robot in W: see `layout`.
        contacts: Gives a row of `layout.Contact` for each person.
        wall_contact: Gives one for the walls; None if it is not known.
        feels_forces: Whether the forces of contacts are computed.
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

    Unless it is a body of a plant, "contacts" counts where it and people
    touch.

    Args:
        builder: Where the trial is.
        scenario: Says which robot, and lists the people.
        obstacles: The walls.
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
    """What `AddPlanner` leaves to connect.

    Attributes:
        system: The planner, whose inputs are connected by their names.
        velocity_command: Gives (v, omega), in m/s and rad/s.
        status: Gives a `PlannerStatus`.
        path: Gives what the planner means to follow.
        costmaps: Give what a planner with maps knows, by their names.
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

    Args:
        builder: Where the trial is.
        scenario: Says which planner, and has the lidar that it needs.
        obstacles: The walls.

    Raises:
        ScenarioError: If it needs another scan than there is.
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
    """Adds what records a trial to a builder, as "evaluator".

    Args:
        builder: Where the trial is.
        scenario: Says what is recorded, and lists the people.
        obstacles: The walls.
        feels_forces: Whether the forces of contacts are computed.
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
    """Adds what detects the end of a trial to a builder, as "monitor"."""
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

    Each is a system named "sensor_" and its name, with all its inputs
    connected.

    Args:
        builder: Where the trial is.
        scenario: Says which sensors there are.
        scene: What cameras see.
        given: The ports of the trial.

    Returns:
        What the sensors measure: the outputs of the first sensor that has an
        output of a name, such as "scan", by this name; those of all further
        ones by the name of the sensor, "_", and the name of the output.
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
    """Adds what stands between people and planner, as "perception".

    Nothing is added where the planner sees everything.

    Args:
        builder: Where the trial is.
        scenario: Says what the planner sees.
        given: The ports of the trial.

    Returns:
        The ports that are for the planner.

    Raises:
        TypeError: If a perception of one's own makes a system without its
            ports.
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
    """Returns what cameras of a trial see, and what carries them."""
    plant = scene.plant
    frames = {"world": scene.scene_graph.world_frame_id()}
    if scene.robot_state is not None:
        robot = plant.GetModelInstanceByName("robot")
        base = plant.GetBodyIndices(robot)[0]
        frames["robot"] = plant.GetBodyFrameIdOrThrow(base)
    return Rendering(scene.scene_graph, frames)
