"""Whom a tree steers, and what its nodes see of one instant."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.layout import (
    COMMAND_SIZE,
    STATE_SIZE,
    Command,
    RobotRole,
)

# The memory of every tree begins with what belongs to the person, not to a
# node: the number of the current goal in the person's list; as many as there
# are goals once none is left.
GOAL_INDEX = 0
PERSON_MEMORY = ("goal index",)

Row = list[float]


def _default_command(
    human: HumanConfig, goal: Sequence[float] | None
) -> tuple[float, ...]:
    """Returns the command to walk to a goal and do nothing else."""
    command = [0.0] * COMMAND_SIZE
    if goal is not None:
        command[Command.GOAL_X], command[Command.GOAL_Y] = goal
        command[Command.HAS_GOAL] = 1.0
    command[Command.GOAL_RADIUS] = human.goal_radius
    command[Command.DESIRED_SPEED] = human.desired_speed
    command[Command.MAX_SPEED] = human.speed_limit
    command[Command.ROBOT_ROLE] = float(RobotRole.PEDESTRIAN)
    command[Command.GROUP_ID] = float(human.group_id)
    return tuple(command)


@dataclass(frozen=True)
class Person:
    """What does not change about a person.

    Attributes:
        index: The row of the person in `human_states`.
        id: The number by which other programs know the person.
        goals: The points to walk to, in W, in meters.
        goal_radius: The distance at which one counts as reached, in meters.
        cyclic: Whether the first goal follows the last.
        time_step: The time between two ticks, in seconds.
        commands: For each goal, and for none, the command to walk to it and
            do nothing else: see `layout.Command`.
    """

    index: int
    id: int
    goals: tuple[tuple[float, float], ...]
    goal_radius: float
    cyclic: bool
    time_step: float
    commands: tuple[tuple[float, ...], ...]

    @classmethod
    def from_config(
        cls, human: HumanConfig, index: int, *, time_step: float
    ) -> Self:
        """Makes a person of its configuration.

        Args:
            human: The configuration.
            index: The row of the person in `human_states`.
            time_step: The time between two ticks, in seconds.
        """
        return cls(
            index=index,
            id=index + 1 if human.id is None else human.id,
            goals=tuple((x, y) for x, y in human.goals),
            goal_radius=human.goal_radius,
            cyclic=human.cyclic,
            time_step=time_step,
            commands=tuple(
                _default_command(human, goal) for goal in [*human.goals, None]
            ),
        )


class Moment:
    """One tick of one person: what leaves see, and what they decide.

    A leaf reads the rest and writes `command` and `behavior_status`.

    Attributes:
        person: Whose tick it is.
        command: What the person is going to do, laid out as `layout.Command`;
            before any leaf writes, to walk to the current goal.
        behavior_status: 1 while a reaction is active, else 0.
    """

    __slots__ = (
        "_human_states",
        "_memory",
        "_robot_states",
        "_robots",
        "_self",
        "behavior_status",
        "command",
        "person",
    )

    def __init__(
        self,
        person: Person,
        memory: list[float],
        human_states: NDArray[np.float64],
        robot_states: NDArray[np.float64],
    ) -> None:
        """Constructs a Moment.

        Args:
            person: Whose tick it is.
            memory: The memory of the tree; the tick changes it.
            human_states: Shape (7n,), see `hunav_drake.systems.layout`.
            robot_states: Shape (7m,), likewise.
        """
        self.person = person
        self.command = list(person.commands[int(memory[GOAL_INDEX])])
        self.behavior_status = 0
        self._memory = memory
        self._human_states = human_states
        self._robot_states = robot_states
        self._self: Row | None = None
        self._robots: list[Row] | None = None

    @property
    def state(self) -> Row:
        """The person's own row of `human_states`."""
        if self._self is None:
            first = STATE_SIZE * self.person.index
            self._self = self._human_states[first : first + STATE_SIZE].tolist()
        return self._self

    @property
    def humans(self) -> list[Row]:
        """The rows of `human_states`, in the order of the scenario."""
        rows: list[Row] = self._human_states.reshape(-1, STATE_SIZE).tolist()
        return rows

    @property
    def robots(self) -> list[Row]:
        """The rows of `robot_state`."""
        if self._robots is None:
            self._robots = self._robot_states.reshape(-1, STATE_SIZE).tolist()
        return self._robots

    @property
    def goal(self) -> tuple[float, float] | None:
        """The current goal in W, in meters; None once none is left."""
        index = int(self._memory[GOAL_INDEX])
        goals = self.person.goals
        return goals[index] if index < len(goals) else None

    def drop_goal(self) -> bool:
        """Goes on to the next goal, and makes it the goal of the command.

        Returns:
            Whether there was a goal to drop.
        """
        person = self.person
        index = int(self._memory[GOAL_INDEX])
        if index == len(person.goals):
            return False
        index += 1
        if person.cyclic and index == len(person.goals):
            index = 0
        self._memory[GOAL_INDEX] = float(index)
        following = person.commands[index]
        for i in (Command.GOAL_X, Command.GOAL_Y, Command.HAS_GOAL):
            self.command[i] = following[i]
        return True
