"""Detects failures of a planner that stop a trial."""

import traceback

import numpy as np
from pydrake.systems.framework import Context, Diagram, System

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
    systems = _parts(diagram.GetSubsystemByName("planner"))
    for frame, _ in traceback.walk_tb(error.__traceback__):
        this = frame.f_locals.get("self")
        if any(this is system for system in systems):
            reason = told(error, frame.f_code)
            name = name_of(diagram.scenario.planner)
            result = PlannerError(name, context.get_time(), reason)
            result.__cause__ = error
            return result
    return None


def CheckCommand(diagram: Diagram, context: Context) -> None:
    """Checks the command of a planner that is a user-defined system.

    A `LocalPlanner` checks its commands itself.

    Raises:
        PlannerError: If the command is not finite.
    """
    command = diagram.GetOutputPort("velocity_command").Eval(context)
    if not np.isfinite(command).all():
        v, omega = command.tolist()
        raise PlannerError(
            name_of(diagram.scenario.planner),
            context.get_time(),
            f"its port velocity_command must give finite numbers, gives"
            f" ({v:g}, {omega:g})",
        )


def IsOwnSystem(diagram: Diagram) -> bool:
    """Returns whether the planner of a trial is a user-defined system."""
    planner = diagram.GetSubsystemByName("planner")
    return not isinstance(planner, LocalPlanner)


def _parts(system: System) -> list[System]:
    """Returns a system and all its subsystems."""
    if not isinstance(system, Diagram):
        return [system]
    parts = [_parts(part) for part in system.GetSystems()]
    return [system, *(part for some in parts for part in some)]
