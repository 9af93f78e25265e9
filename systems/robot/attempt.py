"""Tries a robot model before a trial depends on it."""

from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.models.reading import refuse_planes
from hunav_drake.systems.robot.drives import DRIVES
from hunav_drake.systems.robot.plant_robot import body_reach
from hunav_drake.systems.robot.robot_config import RobotTask
from hunav_drake.systems.robot.robots import UrdfRobot
from hunav_drake.systems.world.obstacles import Obstacles

# The time step and the duration, in seconds, and a speed and a turn rate.
_STEP, _DURATION, _COMMAND = 0.05, 0.1, (0.1, 0.1)


def try_robot(
    file: str,
    packages: dict[str, str],
    base: str,
    drive: dict[str, Any],
    arguments: dict[str, str] | None = None,
) -> None:
    """Drives a robot (see `UrdfRobot`) alone on a floor for two steps.

    Raises:
        ModelFault: If it cannot be driven.
        RuntimeError: If Drake cannot simulate it.
    """
    config = UrdfRobot(
        file=file,
        packages=packages,
        base=base,
        drive=DRIVES.make(drive),
        arguments=arguments or {},
    )
    body_reach(config.GetModel(), config.GetDrive())
    builder = DiagramBuilder()
    nothing = Obstacles.from_shapes([], solid=[])
    robot = config.AddToBuilder(
        builder, RobotTask(time_step=_STEP, obstacles=nothing)
    )
    builder.ExportInput(robot.GetInputPort("velocity_command"))
    diagram = builder.Build()
    refuse_planes(diagram.GetSubsystemByName("scene_graph"))
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, _COMMAND)
    simulator.AdvanceTo(_DURATION)
    plant = diagram.GetSubsystemByName("plant")
    state = plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(context))
    if not np.isfinite(state).all():
        raise ModelFault(
            ("file",),
            f"moves to infinity in its first {_DURATION:g} s; are its masses,"
            " inertias and places of realistic size?",
        )
