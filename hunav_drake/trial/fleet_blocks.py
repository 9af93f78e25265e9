"""The blocks that only a trial with several robots has."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import Demultiplexer

from hunav_drake.scenario.error import Fault, ScenarioError, shown
from hunav_drake.scenario.fleet import RobotPart
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.ports import JoinPorts
from hunav_drake.systems.evaluation.fleet_monitor import FleetMonitor
from hunav_drake.systems.planning.planner import PlannerStatus
from hunav_drake.systems.robot.robots import PhysicalRobot
from hunav_drake.systems.scene import ScenePorts
from hunav_drake.trial.blocks import AddSensors, PlannerPorts, Ports, RobotPorts


def SplitPort(
    builder: DiagramBuilder, name: str, port: OutputPort | None, number: int
) -> list[OutputPort | None]:
    """Returns equal parts of a port, from a system `name`."""
    if port is None or number == 1 or not port.size():
        return [port] * number
    size = port.size() // number
    parts = builder.AddNamedSystem(name, Demultiplexer([size] * number))
    builder.Connect(port, parts.get_input_port())
    return [parts.get_output_port(i) for i in range(number)]


def RefuseClash(outputs: Ports, more: Ports) -> None:
    """Checks that outputs of a trial have names of their own.

    Raises:
        ScenarioError: If two have the same name.
    """
    for name in outputs.keys() & more.keys():
        message = (
            f"two outputs of the trial would be called {shown(name)}: give one"
            " of the robots, or a sensor, another name"
        )
        fault = Fault("scenario", 0, "robots", message)
        raise ScenarioError("scenario", [fault])


class Surroundings(NamedTuple):
    """What is around a robot.

    Attributes:
        others: The port "other_robot_states", for sensors and the robot.
        seen: The port "human_states" of a planner that sees everything: people,
            then the other robots.
        bodies: The port "human_states" of the bodies of a plant: people, then
            the kinematic robots.
    """

    others: Ports
    seen: Ports
    bodies: Ports


def AddSurroundings(
    builder: DiagramBuilder,
    parts: Sequence[RobotPart],
    robots: Sequence[RobotPorts],
    human_states: OutputPort,
) -> list[Surroundings]:
    """Adds what joins the states around each robot to a builder.

    Nothing is added for a single robot.
    """
    if len(parts) == 1:
        return [Surroundings({}, {}, {})]
    states = [robot.robot_state for robot in robots]
    kinematic = [
        robot.robot_state
        for part, robot in zip(parts, robots, strict=True)
        if not isinstance(part.scenario.robot, PhysicalRobot)
    ]
    result = []
    for i, (part, robot) in enumerate(zip(parts, robots, strict=True)):
        prefix = part.prefix
        others = JoinPorts(
            builder, f"{prefix}other_robot_states", states[:i] + states[i + 1 :]
        )
        seen = JoinPorts(builder, f"{prefix}seen", [human_states, others])
        bodies = {}
        if robot.systems[0].HasOutputPort("desired_people_state"):
            bodies["human_states"] = JoinPorts(
                builder, "bodies", [human_states, *kinematic]
            )
        result.append(
            Surroundings(
                {"other_robot_states": others}, {"human_states": seen}, bodies
            )
        )
    return result


def AddFleet(
    builder: DiagramBuilder,
    scenario: Scenario,
    parts: Sequence[RobotPart],
    monitors: Sequence[System],
    planners: Sequence[PlannerPorts],
    scene: ScenePorts,
    human_states: OutputPort,
    robot_states: OutputPort,
) -> dict[str, OutputPort]:
    """Adds what detects the end of several robots, and sensors of the world.

    They are "monitor" and "sensor_" plus a name. The ports are the
    states of all people, and of all robots.

    Returns:
        Their outputs by name.
    """
    monitor = builder.AddNamedSystem(
        "monitor",
        FleetMonitor(
            [part.scenario.robot.goal is not None for part in parts],
            planner_error=PlannerStatus.ERROR,
            time_step=scenario.simulation.time_step,
        ),
    )
    for name, ports in (
        ("statuses", [it.GetOutputPort("trial_status") for it in monitors]),
        ("planner_statuses", [it.status for it in planners]),
    ):
        joined = JoinPorts(builder, name, ports)
        builder.Connect(joined, monitor.GetInputPort(name))
    outputs = {
        name: monitor.GetOutputPort(name)
        for name in ("trial_status", "robot_ends")
    }
    if scenario.sensors:
        given = {
            "human_states": human_states,
            "other_robot_states": robot_states,
        }
        fixed = RobotPart("", scenario)
        outputs |= AddSensors(builder, fixed, scene, given)
    return outputs
