"""The sensors in the diagram of a trial."""

from pydrake.systems.framework import DiagramBuilder, OutputPort

from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.scene import ScenePorts
from hunav_drake.systems.sensing.sensor_config import (
    Rendering,
    SensingTask,
    name_sensors,
)


def AddSensors(
    builder: DiagramBuilder,
    scenario: Scenario,
    scene: ScenePorts,
    given: dict[str, OutputPort],
) -> dict[str, OutputPort]:
    """Adds the sensors of a scenario to a builder.

    Each is a system named "sensor_" and its name, with all its inputs
    connected.

    Args:
        builder: Where the trial is.
        scenario: Says which sensors there are.
        scene: What cameras see.
        given: The ports of the trial by the names of the inputs that they are
            for.

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
        task = SensingTask(
            world=scenario.world,
            num_humans=len(scenario.humans),
            time_step=scenario.simulation.time_step,
            seed=scenario.simulation.seed,
            number=i,
            rendering=_Rendering(scene),
        )
        system = sensor.AddToBuilder(builder, task, name=f"sensor_{name}")
        for port_name, port in given.items():
            if system.HasInputPort(port_name):
                builder.Connect(port, system.GetInputPort(port_name))
        for k in range(system.num_output_ports()):
            port = system.get_output_port(k)
            key = port.get_name()
            outputs[f"{name}_{key}" if key in outputs else key] = port
    return outputs


def _Rendering(scene: ScenePorts) -> Rendering:
    """Returns what cameras of a trial see, and what carries them."""
    plant = scene.plant
    frames = {"world": scene.scene_graph.world_frame_id()}
    if scene.robot_state is not None:
        robot = plant.GetModelInstanceByName("robot")
        base = plant.GetBodyIndices(robot)[0]
        frames["robot"] = plant.GetBodyFrameIdOrThrow(base)
    return Rendering(scene.scene_graph, frames)
