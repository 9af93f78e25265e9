"""The planner in the diagram of a trial, and what it sees."""

import dataclasses

from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.scenario.checks import first_lidar, scan_fault
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.ports import CheckPorts
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.planning import PlanningTask
from hunav_drake.systems.planning.planner import asked_scan_size
from hunav_drake.systems.sensing.sensor_config import LidarConfig, SensingTask
from hunav_drake.systems.world.obstacles import Obstacles


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


def AddPlanner(
    builder: DiagramBuilder, scenario: Scenario, obstacles: Obstacles
) -> System:
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
    return system


def AddPerception(
    builder: DiagramBuilder, scenario: Scenario, given: dict[str, OutputPort]
) -> dict[str, OutputPort]:
    """Adds what stands between people and planner, as "perception".

    Nothing is added where the planner sees everything.

    Args:
        builder: Where the trial is.
        scenario: Says what the planner sees.
        given: The ports of the trial by the names of the inputs that they are
            for.

    Returns:
        The ports that are for the planner, by the names of its inputs.

    Raises:
        TypeError: If a perception of one's own makes a system without its
            ports.
    """
    sees = scenario.planner.sees
    if sees.by_lidar:
        nobody = builder.AddNamedSystem("perception", ConstantVectorSource([]))
        return {**given, "human_states": nobody.get_output_port()}
    humans = given["human_states"]
    task = SensingTask(
        world=scenario.world,
        num_humans=len(scenario.humans),
        time_step=scenario.simulation.time_step,
        seed=scenario.simulation.seed,
        number=len(scenario.sensors),
    )
    system = sees.MakeSystem(task)
    if system is None:
        return given
    CheckPorts(
        system,
        f"the perception {type(sees).__name__}",
        inputs={},
        outputs={"visible_people": humans.size()},
    )
    builder.AddNamedSystem("perception", system)
    for name in ("robot_state", "human_states"):
        if system.HasInputPort(name):
            builder.Connect(given[name], system.GetInputPort(name))
    return {**given, "human_states": system.GetOutputPort("visible_people")}
