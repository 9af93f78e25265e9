"""The tick context: the data that a tree's nodes read and write in a tick."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from types import MappingProxyType
from typing import Self

from hunav_drake.systems.behavior.nodes.port import UNSET
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    STATE_SIZE,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.people.human_config import LARGEST_BODY, HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.ray_cast import ray_cast

# The memory of every tree begins with the person's own number: the index of the
# current goal in the person's list, or the number of goals once none is left.
GOAL_INDEX = 0
PERSON_MEMORY = ("goal index",)

# The largest number of places that a person has as later goals.
MAX_PLACES = 16

# In a tree with social leaves, these follow: the number of ticks so far;
# whether the person is to stand until further notice; the group instead of the
# configured one, or `UNSET`; the slot on which the person sits or lies, 1 + its
# row, or 0; what the person says, to whom, and for how many
# ticks more; the seed of all chances; and places as goals: the present one,
# and those to come, each 1 + its row, or 0. Those after the person's own goals
# have a minus.
SOCIAL_MEMORY: Mapping[str, float] = MappingProxyType(
    {
        "ticks": 0.0,
        "stopped": 0.0,
        "group": UNSET,
        "seat": 0.0,
        "utterance": 0.0,
        "addressee": -1.0,
        "ticks to say it": 0.0,
        "seed, high": 0.0,
        "seed, low": 0.0,
        "place as goal": 0.0,
        **{f"later place {i}": 0.0 for i in range(1, MAX_PLACES + 1)},
    }
)
TICKS, STOPPED, GROUP, SEAT, UTTERANCE, ADDRESSEE, TICKS_LEFT, SEED = range(8)
GOAL_PLACE = SEED + 2
LATER_PLACES = GOAL_PLACE + 1

# Two numbers for each need that the tree names follow: its level, and by how
# much that sinks in a second.
NEEDS = len(SOCIAL_MEMORY)


def need_slots(need: str) -> tuple[str, str]:
    """Returns the names of the two numbers of a need in the memory."""
    return f"need {need}", f"need {need}, per second"


Row = list[float]

# The largest `behavior_status`.
MAX_BEHAVIOR_STATUS = 100


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
    """The constant properties of a person.

    Attributes:
        index: The row of the person in `human_states`.
        id: The number by which other programs know the person.
        goals: The points to walk to, in W, in meters.
        goal_radius: The distance at which one counts as reached, in meters.
        cyclic: Whether the first goal follows the last.
        time_step: The time between two ticks, in seconds.
        commands: For each goal, and for none, the command to walk to it and
            do nothing else: see `layout.Command`.
        walls: The obstacles that the person cannot walk through:
            `Obstacles.table`; None if there are none.
        hiding: The obstacles that the person cannot see through, likewise.
        body_radius: The radius of the body itself, in meters.
        ignores_invitations: Whether the person never joins others who ask.
        is_wheeled: Whether the person is in a wheelchair, and stays in it:
            beside seats and beds.
        needs: The level of each need at the start, and by how much it sinks in
            a second.
    """

    index: int
    id: int
    goals: tuple[tuple[float, float], ...]
    goal_radius: float
    cyclic: bool
    time_step: float
    commands: tuple[tuple[float, ...], ...]
    walls: Array | None = field(default=None, compare=False)
    hiding: Array | None = field(default=None, compare=False)
    body_radius: float = LARGEST_BODY
    ignores_invitations: bool = False
    is_wheeled: bool = False
    needs: Mapping[str, tuple[float, float]] = MappingProxyType({})

    @classmethod
    def from_config(
        cls,
        human: HumanConfig,
        index: int,
        *,
        id: int | None = None,
        time_step: float,
        obstacles: Obstacles | None = None,
        sight_obstacles: Obstacles | None = None,
    ) -> Self:
        """Makes a person from a configuration.

        Args:
            human: The configuration.
            index: The row of the person in `human_states`.
            id: The number of the person; by default that of the
                configuration, else ``index + 1``.
            time_step: The time between two ticks, in seconds.
            obstacles: The obstacles that the person cannot walk through; none
                by default.
            sight_obstacles: The obstacles that the person cannot see through;
                by default, ``obstacles``.
        """
        if sight_obstacles is None:
            sight_obstacles = obstacles
        if id is None:
            id = index + 1 if human.id is None else human.id
        return cls(
            index=index,
            id=id,
            goals=tuple((x, y) for x, y in human.goals),
            goal_radius=human.goal_radius,
            cyclic=bool(human.cyclic),
            time_step=time_step,
            commands=tuple(
                _default_command(human, goal) for goal in [*human.goals, None]
            ),
            walls=obstacles.table if obstacles else None,
            hiding=sight_obstacles.table if sight_obstacles else None,
            body_radius=human.contact_radius,
            ignores_invitations=human.invitations == "ignore",
            is_wheeled=human.figure.wheelchair,
            needs={
                name: (it.initial, it.rate) for name, it in human.needs.items()
            },
        )


def _rows(states: Array) -> list[Row]:
    """Returns the rows of `robot_states`."""
    flat: Row = states.tolist()
    # (Most often there is one.)
    if len(flat) == STATE_SIZE:
        return [flat]
    return [flat[i : i + STATE_SIZE] for i in range(0, len(flat), STATE_SIZE)]


class TickContext:
    """The data that leaves read and write in one tick of a person's tree.

    Leaves write `command` and `behavior_status`, and only read the rest.

    Attributes:
        person: The person whose tree is ticked.
        command: The person's command, laid out as `layout.Command`; before any
            leaf writes, it is to walk to the current goal.
        behavior_status: 0 while no reaction is active, else the state that
            it is in, up to `MAX_BEHAVIOR_STATUS`; most reactions have the one
            state 1.
        state: The person's own row of `human_states`.
        robots: The rows of `robot_states`.
        noticed: The index in `robots` of the one that a condition has noticed
            last in this tick, or -1.
    """

    __slots__ = (
        "_goal_place",
        "_human_states",
        "_is_social",
        "_memory",
        "_places",
        "behavior_status",
        "command",
        "noticed",
        "person",
        "robots",
        "state",
    )

    def __init__(
        self,
        person: Person,
        memory: list[float],
        human_states: Array,
        robot_states: Array,
        places: Sequence[Sequence[float]] | None = None,
    ) -> None:
        """Constructs a TickContext.

        Args:
            person: The person whose tree is ticked.
            memory: The memory of the tree; the tick changes it.
            human_states: Shape (7n,), see `common.layout`.
            robot_states: Shape (7m,), see `common.layout`.
            places: The position (x, y) of each place in W, in meters; None if
                the tree has no social leaves.
        """
        self.person = person
        self._places = places or ()
        self._is_social = places is not None
        self._goal_place = 0
        self.command = list(person.commands[int(memory[GOAL_INDEX])])
        self.behavior_status = 0
        self._memory = memory
        self._human_states = human_states
        # (Not properties: leaves read them many times in a tick.)
        first = STATE_SIZE * person.index
        self.state: Row = human_states[first : first + STATE_SIZE].tolist()
        self.robots: list[Row] = _rows(robot_states)
        self.noticed = -1

    def begin(
        self,
        memory: list[float],
        command: list[float],
        behavior_status: int,
        noticed: int,
        goal_place: int,
    ) -> None:
        """Takes what a leaf finds: what the nodes before it have written."""
        self._memory = memory
        self._goal_place = goal_place
        self.command = list(command)
        self.behavior_status = behavior_status
        self.noticed = noticed

    @property
    def humans(self) -> list[Row]:
        """The rows of `human_states`, in the order of the scenario."""
        rows: list[Row] = self._human_states.reshape(-1, STATE_SIZE).tolist()
        return rows

    @property
    def human_states(self) -> Array:
        """All of `human_states`, of shape (n, 7), not to be changed."""
        return self._human_states.reshape(-1, STATE_SIZE)

    @property
    def num_humans(self) -> int:
        """The number of rows of `human_states`."""
        return len(self._human_states) // STATE_SIZE

    @property
    def robot(self) -> Row | None:
        """The row of the robot to react to; None if there are no robots.

        It is the one that a condition has noticed last in this tick; if none
        has, the nearest one.
        """
        robots = self.robots
        if self.noticed >= 0:
            return robots[self.noticed]
        if len(robots) < 2:
            return robots[0] if robots else None
        x, y = self.state[X], self.state[Y]
        return min(robots, key=lambda row: math.hypot(row[X] - x, row[Y] - y))

    def notice(self, index: int) -> None:
        """Sets the robot to react to, by its index in `robots`."""
        self.noticed = range(len(self.robots))[index]

    def sees(self, x: float, y: float) -> bool:
        """Returns whether nothing hides a point from this person.

        Args:
            x: The x of the point in W, in meters.
            y: The y of the point in W, in meters.
        """
        walls = self.person.hiding
        if walls is None:
            return True
        part: float = ray_cast(self.state[X], self.state[Y], x, y, walls)
        return part > 1

    def cast_ray(
        self, x: float, y: float, start: Sequence[float] | None = None
    ) -> float:
        """Casts a ray to a point along the floor, where low things stop it.

        Args:
            x: The x of the point in W, in meters.
            y: The y of the point in W, in meters.
            start: The row of the person or robot where it starts; by default,
                this person's.

        Returns:
            The fraction of the ray at which it meets the first wall, in
            [0, 1]; infinity if it meets none.
        """
        walls = self.person.walls
        if walls is None:
            return math.inf
        if start is None:
            start = self.state
        part: float = ray_cast(start[X], start[Y], x, y, walls)
        return part

    @property
    def goal_place(self) -> int:
        """The place that is the current goal: 1 + its row, or 0."""
        return self._goal_place

    @property
    def goal(self) -> tuple[float, float] | None:
        """The current goal in W, in meters; None once none is left."""
        if self._goal_place:
            x, y = self._places[self._goal_place - 1]
            return x, y
        index = int(self._memory[GOAL_INDEX])
        goals = self.person.goals
        return goals[index] if index < len(goals) else None

    def go_to_next_goal(self) -> bool:
        """Goes on to the next goal, and makes it the goal of the command.

        Returns:
            Whether there was a goal to drop.
        """
        # (As `tick.next_goal`.)
        if self.goal is None:
            return False
        person = self.person
        index, count = int(self._memory[GOAL_INDEX]), len(person.goals)
        is_last = False
        if self._goal_place:
            self._goal_place = 0
        else:
            index += 1
            is_last = index == count
            if person.cyclic and is_last:
                index = 0
            self._memory[GOAL_INDEX] = float(index)
        if self._is_social:
            self._goal_place = self._later_place(is_last or index == count)
        following = person.commands[index]
        for i in (Command.GOAL_X, Command.GOAL_Y, Command.HAS_GOAL):
            self.command[i] = following[i]
        if self.goal is not None:
            self.command[Command.GOAL_X], self.command[Command.GOAL_Y] = (
                self.goal
            )
            self.command[Command.HAS_GOAL] = 1.0
        return True

    def _later_place(self, is_last: bool) -> int:
        """Takes the next of the places to come: see `tick.later_place`."""
        first = len(PERSON_MEMORY) + LATER_PLACES
        later = self._memory[first : first + MAX_PLACES]
        if is_last:
            later = [abs(it) for it in later]
        place = next((it for it in later if it > 0), 0.0)
        if place:
            later.remove(place)
            later.append(0.0)
        self._memory[first : first + MAX_PLACES] = later
        return int(place) if place <= len(self._places) else 0
