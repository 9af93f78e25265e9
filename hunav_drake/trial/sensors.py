"""What a trial measures: its sensors, and what its planner sees."""

import dataclasses

from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.scenario.checks import first_lidar
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.ports import CheckPorts
from hunav_drake.systems.planning.planner import asked_scan_size
from hunav_drake.systems.scene import ScenePorts
from hunav_drake.systems.sensing.sensor_config import (
    LidarConfig,
    Rendering,
    SensingTask,
    name_sensors,
)
from hunav_drake.trial.wires import ConnectByName, Ports


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
