"""Detects failures of a planner that stop a trial."""

import traceback

import numpy as np
from pydrake.systems.framework import Context, Diagram, System

from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.planning.local_planner import LocalPlanner
from hunav_drake.systems.planning.planner_error import PlannerError, told


def PlannerErrorOf(
    error: Exception, diagram: Diagram, context: Context
) -> PlannerError | None:
    """Returns an exception of a trial as an error of its planner.

    It is None if the exception was raised elsewhere. The Context is that of
    the trial's diagram at the time of the exception.
    """
    if isinstance(error, PlannerError):
        return error
    parts = robot_parts(diagram.scenario)
    systems = [
        _parts(diagram.GetSubsystemByName(f"{it.prefix}planner"))
        for it in parts
    ]
    for frame, _ in traceback.walk_tb(error.__traceback__):
        this = frame.f_locals.get("self")
        for part, own in zip(parts, systems, strict=True):
            if any(this is system for system in own):
                reason = told(error, frame.f_code)
                name = name_of(part.scenario.planner)
                result = PlannerError(
                    name, context.get_time(), reason, part.name
                )
                result.__cause__ = error
                return result
    return None


def CheckCommand(diagram: Diagram, context: Context) -> None:
    """Checks the commands of planners that are user-defined systems.

    A `LocalPlanner` checks its commands itself.

    Raises:
        PlannerError: If a command is not finite.
    """
    for part in robot_parts(diagram.scenario):
        port = diagram.GetOutputPort(f"{part.prefix}velocity_command")
        command = port.Eval(context)
        if not np.isfinite(command).all():
            v, omega = command.tolist()
            raise PlannerError(
                name_of(part.scenario.planner),
                context.get_time(),
                f"its port velocity_command must give finite numbers, gives"
                f" ({v:g}, {omega:g})",
                part.name,
            )


def IsOwnSystem(diagram: Diagram) -> bool:
    """Returns whether a planner of a trial is a user-defined system."""
    return not all(
        isinstance(
            diagram.GetSubsystemByName(f"{it.prefix}planner"), LocalPlanner
        )
        for it in robot_parts(diagram.scenario)
    )


def _parts(system: System) -> list[System]:
    """Returns a system and all its subsystems."""
    if not isinstance(system, Diagram):
        return [system]
    parts = [_parts(part) for part in system.GetSystems()]
    return [system, *(part for some in parts for part in some)]
