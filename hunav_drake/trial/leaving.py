"""Takes people and robots out of a trial, and drives a robot from outside."""

from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, Diagram, System

from hunav_drake.scenario.fleet import RobotPart, robot_parts
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.layout import OUTSIDE
from hunav_drake.systems.common.suggest import did_you_mean, shown
from hunav_drake.systems.crowd.open_crowd import OpenCrowd
from hunav_drake.systems.people.names import people_names
from hunav_drake.trial.seeds import CheckIsTrial

# The name by which the only robot of a trial may be called, too.
ONLY_ROBOT = "robot"


def robot_part(scenario: Scenario, name: str = "") -> tuple[int, RobotPart]:
    """Returns the index and the part of a robot; by default, of the first.

    Raises:
        ValueError: If there is no such robot.
    """
    parts = robot_parts(scenario)
    names = [part.name or ONLY_ROBOT for part in parts]
    if name and name not in names:
        raise ValueError(
            f"there is no robot {shown(name)}{did_you_mean(name, names)};"
            f" valid: {', '.join(names)}"
        )
    index = names.index(name) if name else 0
    return index, parts[index]


def _called(part: RobotPart) -> str:
    return f"the robot {part.name}".rstrip()


def why_nobody_leaves(scenario: Scenario) -> str:
    """Returns why nobody can be left out of a trial; empty if they can."""
    for part in robot_parts(scenario):
        if part.scenario.robot.physical:
            return (
                f"nobody can be left out: {_called(part)} is physical, and"
                " needs people who are there from the start to the end; take"
                " robot.type=differential_drive"
            )
    return ""


def LeaveOut(diagram: Diagram, context: Context, *names: str) -> None:
    """Takes people out of a trial: from now on, they are not there.

    For all others it is as if they had gone at this instant, like people who
    leave at a sink: they exert no forces, nobody sees them, groups and circles
    go on without them. Their rows remain; recordings have rows of NaN.

    Args:
        diagram: From `MakeTrialDiagram` with `may_leave`.
        context: Its root Context, changed.
        names: The names of the people.

    Raises:
        ValueError: If there is no such person, if it follows a recording, if a
            robot is physical, or if people of this diagram may not leave.
    """
    CheckIsTrial(diagram)
    if not names:
        return
    known = people_names(diagram.humans)
    for name in names:
        if name not in known:
            raise ValueError(
                f"there is no person {shown(name)}{did_you_mean(name, known)};"
                f" valid: {', '.join(known)}"
            )
        if diagram.humans[known.index(name)].track is not None:
            raise ValueError(
                f"{shown(name)} follows a recording, and cannot be left out;"
                " leave the person out of the scenario"
            )
    if why := why_nobody_leaves(diagram.scenario):
        raise ValueError(why)
    humans = diagram.GetSubsystemByName("humans")
    crowd = humans.GetSubsystemByName("crowd")
    if not isinstance(crowd, OpenCrowd):
        raise ValueError(
            "people of this diagram may not leave; make it by"
            " MakeTrialDiagram(scenario, may_leave=True), and take the state"
            " over with TransferContext"
        )
    own = crowd.GetMyMutableContextFromRoot(context)
    crowd.TakeOut(own, [known.index(name) for name in names])


def TakeRobotAway(diagram: Diagram, context: Context, robot: str = "") -> None:
    """Takes a robot out of a trial: it stands out of reach of everybody.

    It is then at rest at (1e6, 1e6) m. Its planner should be `stand`: others
    may fail so far from the map.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: Its root Context, changed.
        robot: The name of the robot; by default, the first one.

    Raises:
        ValueError: If there is no such robot, or it is physical, or one of your
            own without a method `SetPose`.
    """
    _PlaceRobot(diagram, context, robot, [OUTSIDE, OUTSIDE, 0.0])


def StopRobot(diagram: Diagram, context: Context, robot: str = "") -> None:
    """Stops a robot at once, where it is: see `TakeRobotAway`."""
    _, part = robot_part(diagram.scenario, robot)
    port = diagram.GetOutputPort(f"{part.prefix}robot_state")
    _PlaceRobot(diagram, context, robot, port.Eval(context)[:3])


def ShiftRobot(
    diagram: Diagram, context: Context, offset: ArrayLike, robot: str = ""
) -> None:
    """Moves a robot by (x, y) in W, in meters, at its speed.

    Raises:
        ValueError: If there is no such robot, or it is physical, or one of your
            own without a method `Shift`.
    """
    _Move(diagram, context, robot, "Shift", offset)


def _PlaceRobot(
    diagram: Diagram, context: Context, robot: str, pose: ArrayLike
) -> None:
    _Move(diagram, context, robot, "SetPose", pose)


def _Move(
    diagram: Diagram, context: Context, robot: str, how: str, to: ArrayLike
) -> None:
    """Calls a method of a robot's system."""
    CheckIsTrial(diagram)
    _, part = robot_part(diagram.scenario, robot)
    system = diagram.GetSubsystemByName(f"{part.prefix}robot")
    if not hasattr(system, how):
        instead = (
            "do not ask for the growth of differences"
            if how == "Shift"
            else "let it brake and stand, and compare with the branch 'same'"
            " (--reference same)"
        )
        raise ValueError(
            f"{_called(part)} cannot be moved at once: it is"
            f" physical, or its system lacks {how}(context, ...); {instead}, or"
            " take robot.type=differential_drive"
        )
    getattr(system, how)(system.GetMyMutableContextFromRoot(context), to)


def SetRobotCommand(
    diagram: Diagram, context: Context, command: ArrayLike, robot: str = ""
) -> None:
    """Sets the command that a robot holds from now on.

    Its planner is `external`, which holds the command until the next one; with
    other planners, it holds until their next decision.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: Its root Context, changed.
        command: (v, omega), in m/s and rad/s.
        robot: The name of the robot; by default, the first one.

    Raises:
        ValueError: If there is no such robot, its planner takes no command, or
            the command is not two finite numbers.
    """
    CheckIsTrial(diagram)
    _, part = robot_part(diagram.scenario, robot)
    planner: System = diagram.GetSubsystemByName(f"{part.prefix}planner")
    if not hasattr(planner, "SetCommand"):
        raise ValueError(
            f"the planner of {_called(part)} takes no command;"
            " take the planner external"
        )
    planner.SetCommand(planner.GetMyMutableContextFromRoot(context), command)
