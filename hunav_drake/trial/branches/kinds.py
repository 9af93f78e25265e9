"""The kinds of branches: what is different from an instant on."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import json
import math
from typing import Any
import warnings

from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario import LoadScenario, SaveScenario
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.planning.planner import PLANNERS
from hunav_drake.trial.leaving import (
    LeaveOut,
    SetRobotCommand,
    ShiftRobot,
    StopRobot,
    TakeRobotAway,
    robot_part,
)


@dataclass(frozen=True, kw_only=True)
class Branch:
    """What is different in a branch: here nothing.

    A kind of branch changes the scenario, the Context at the instant, or both.
    """

    def overrides(self, scenario: Scenario) -> list[str]:
        """Returns the changes of the scenario, as for `LoadScenario`.

        Raises:
            ValueError: If the branch does not fit the scenario.
        """
        return []

    def Apply(self, diagram: Diagram, context: Context) -> None:
        """Changes the Context at the instant, of the changed scenario.

        Raises:
            ValueError: If that is not possible.
        """

    def robots_left(self, scenario: Scenario) -> list[str]:
        """Returns the names of the robots that are there."""
        return list(robots_of(scenario))

    def may_leave(self) -> bool:
        """Returns whether it takes people out: see `MakeTrialDiagram`."""
        return False


@dataclass(frozen=True)
class WithPlanner(Branch):
    """A robot goes on with another planner, which sees as the one before.

    Attributes:
        planner: The name of the planner.
        parameters: Its parameters, as in a scenario.
        robot: The name of the robot; by default, the first one.
    """

    planner: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    robot: str = ""

    def overrides(self, scenario: Scenario) -> list[str]:
        """Returns the change of the planner.

        Raises:
            ValueError: If there is no planner of that name.
        """
        _, part = robot_part(scenario, self.robot)
        name: Any = self.planner
        if isinstance(name, str) and ":" not in name and name not in PLANNERS:
            raise ValueError(
                f"there is no planner {shown(name)};"
                f" {suggestion(name, list(PLANNERS))}"
            )
        before = plain(part.scenario.planner)
        kept = {
            key: before[key]
            for key in ("sees", "localization")
            if isinstance(before, dict) and key in before
        }
        return [
            _planner(
                scenario,
                self.robot,
                {"type": self.planner, **kept, **plain(dict(self.parameters))},
            )
        ]


@dataclass(frozen=True)
class RobotStands(Branch):
    """A robot brakes within its limits, and then stands.

    Attributes:
        robot: The name of the robot; by default, the first one.
        at_once: Whether it stands at once, without braking.
    """

    robot: str = ""
    at_once: bool = False

    def overrides(self, scenario: Scenario) -> list[str]:
        """Returns the change of the planner."""
        return [_standing(scenario, self.robot)]

    def Apply(self, diagram: Diagram, context: Context) -> None:
        """Takes back the last command, and the speed if `at_once`."""
        SetRobotCommand(diagram, context, [0.0, 0.0], self.robot)
        if self.at_once:
            StopRobot(diagram, context, self.robot)


@dataclass(frozen=True)
class RobotShifted(Branch):
    """A robot is a little aside, and drives on.

    Attributes:
        by: How far, in meters, along the diagonal between x and y.
        robot: The name of the robot; by default, the first one.
    """

    by: float
    robot: str = ""

    def Apply(self, diagram: Diagram, context: Context) -> None:
        """Moves the robot."""
        part = self.by * math.sqrt(0.5)
        ShiftRobot(diagram, context, [part, part], self.robot)


@dataclass(frozen=True)
class Without(Branch):
    """Some people and robots are no longer there.

    Attributes:
        people: The names of people.
        robots: The names of robots; an empty one is that of the first.
    """

    people: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()

    def overrides(self, scenario: Scenario) -> list[str]:
        """Returns the changes of the planners: far away, others may fail."""
        return [_standing(scenario, robot) for robot in self.robots]

    def Apply(self, diagram: Diagram, context: Context) -> None:
        """Takes the people and robots away."""
        LeaveOut(diagram, context, *self.people)
        for robot in self.robots:
            SetRobotCommand(diagram, context, [0.0, 0.0], robot)
            TakeRobotAway(diagram, context, robot)

    def robots_left(self, scenario: Scenario) -> list[str]:
        """Returns the names of the robots that are there."""
        gone = [robot_part(scenario, it)[1].name for it in self.robots]
        return [it for it in robots_of(scenario) if it not in gone]

    def may_leave(self) -> bool:
        """Returns whether it takes people out."""
        return bool(self.people)


def RobotGone(robot: str = "") -> Branch:
    """Returns the branch without a robot, by default the first one."""
    return Without(robots=(robot,))


def WithoutPerson(name: str) -> Branch:
    """Returns the branch without a person."""
    return Without(people=(name,))


@dataclass(frozen=True)
class WithSettings(Branch):
    """The scenario has other settings, as those of `--set`.

    People, robot, goal, evaluator and time step must stay as they are: see
    `TransferContext`. So must seed, duration and start jitter.

    Attributes:
        changes: Texts of a path, an equals sign and a value, as
            "crowd.robot_gap=0.2".
    """

    changes: tuple[str, ...]

    def overrides(self, scenario: Scenario) -> list[str]:
        """Returns the changes."""
        return list(self.changes)


# Settings of the simulation that a branch cannot have, and why.
_KEPT = {
    "seed": "a branch goes on with the draws of the trial; run a trial with"
    " that seed",
    "duration": "`until` is the end of all branches",
    "start_jitter": "it moves people at the start of a trial",
}


def changed_scenario(scenario: Scenario, branch: Branch) -> Scenario:
    """Returns the scenario of a branch.

    Raises:
        ScenarioError: If it cannot be simulated.
        ValueError: If the branch does not fit the scenario.
    """
    overrides = branch.overrides(scenario)
    if not overrides:
        return scenario
    with warnings.catch_warnings():
        # Doubts were told when the scenario itself was loaded.
        warnings.simplefilter("ignore", UserWarning)
        changed = LoadScenario(data=SaveScenario(scenario), overrides=overrides)
    for key, why in _KEPT.items():
        was, now = (getattr(it.simulation, key) for it in (scenario, changed))
        if was != now:
            raise ValueError(f"simulation.{key}={now} has no effect: {why}")
    return changed


def _standing(scenario: Scenario, robot: str) -> str:
    """Returns the override by which a robot stands."""
    # (The period by default is no multiple of each time step.)
    period = scenario.simulation.time_step
    return _planner(scenario, robot, {"type": "stand", "period": period})


def _planner(scenario: Scenario, robot: str, choice: Any) -> str:
    """Returns the override of the planner of a robot."""
    index, _ = robot_part(scenario, robot)
    path = f"robots[{index}].planner" if scenario.robots else "planner"
    # (JSON is YAML, too.)
    return f"{path}={json.dumps(choice)}"
