"""People of one motion model, simulated step by step in a Context."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.analysis import Simulator

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    STATE_SIZE,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.shapes import Box, World
from hunav_drake.validation.case import Setting

# The defaults of all cases, in s, m and m/s.
TIME_STEP = 0.05
RADIUS = 0.2
SPEED = 1.34

# The places of people who have left, far from each other, in meters.
_AWAY = 500.0
_APART = 5.0


class Walk(NamedTuple):
    """The states of people over time.

    Attributes:
        times: Shape (k,), in seconds.
        states: Shape (k, n, 7): rows of `human_states`.
        present: Shape (k, n): whether a person has not left. Other rows have
            no meaning.
    """

    times: Array
    states: Array
    present: Mask

    @property
    def x(self) -> Array:
        """The x of all, shape (k, n), in meters."""
        return self.states[..., X]

    @property
    def y(self) -> Array:
        """The y of all, shape (k, n), in meters."""
        return self.states[..., Y]

    def first_time(self, reached: Mask) -> Array:
        """Returns the first times at which `reached` (k, n) is true.

        The shape is (n,), in seconds; infinite for people without one.
        """
        reached = reached & self.present
        first = self.times[np.argmax(reached, axis=0)]
        return np.where(reached.any(axis=0), first, np.inf)

    def time_between(self, begun: Mask, done: Mask) -> Array:
        """Returns the times between two events (k, n): see `first_time`.

        The shape is (n,), in seconds; infinite for people without an event.
        """
        first, last = self.first_time(begun), self.first_time(done)
        happen = np.isfinite(first) & np.isfinite(last)
        times = np.full(first.shape, np.inf)
        times[happen] = last[happen] - first[happen]
        return times

    def velocities(self) -> Array:
        """Returns velocities from positions, shape (k - 1, n, 2), in m/s."""
        moved = np.diff(self.states[..., :2], axis=0)
        both = self.present[1:] & self.present[:-1]
        return np.where(both[..., None], moved / TIME_STEP, 0.0)


class Walkers:
    """People who walk to goals by the motion model of a setting.

    Their whole state is the Context of a `HumanCrowd`. The rows of `command`
    may be changed between steps.

    Attributes:
        command: Shape (n, COMMAND_SIZE): see `layout.Command`.
    """

    def __init__(
        self,
        setting: Setting,
        starts: ArrayLike,
        goals: ArrayLike,
        *,
        walls: Sequence[Box] = (),
        speeds: ArrayLike = SPEED,
        radii: ArrayLike = RADIUS,
        groups: ArrayLike = -1,
    ) -> None:
        """Constructs walkers who face their goals.

        Args:
            setting: The model and the options.
            starts: Shape (n, 2), in meters.
            goals: Shape (n, 2), or (2,) for one goal of all, in meters.
            walls: The walls.
            speeds: The desired speeds, in m/s.
            radii: The radii of bodies, in meters.
            groups: The numbers of groups; -1 for none.
        """
        p = np.asarray(starts, dtype=float).reshape(-1, 2)
        n = len(p)
        goal = np.broadcast_to(np.asarray(goals, dtype=float), (n, 2))
        radius = np.broadcast_to(np.asarray(radii, dtype=float), n)
        speed = np.broadcast_to(np.asarray(speeds, dtype=float), n)
        group = np.broadcast_to(np.asarray(groups), n)
        yaws = np.arctan2(*(goal - p).T[::-1])
        humans = [
            HumanConfig(
                pose=(float(p[i, 0]), float(p[i, 1]), float(yaws[i])),
                desired_speed=float(speed[i]),
                radius=float(radius[i]),
                group_id=int(group[i]),
            )
            for i in range(n)
        ]
        self._crowd = HumanCrowd(
            humans,
            obstacles=World(walls=list(walls)).obstacles(),
            config=CrowdConfig(model=MOTION_MODELS.make(setting.model)),
            num_robots=0,
            time_step=TIME_STEP,
            seed=setting.seed,
        )
        self._simulator = Simulator(self._crowd)
        self._steps = 0
        self.command = np.zeros((n, COMMAND_SIZE))
        self.command[:, :2] = goal
        self.command[:, Command.GOAL_RADIUS] = 0.3
        self.command[:, Command.HAS_GOAL] = 1.0
        self.command[:, Command.DESIRED_SPEED] = speed
        self.command[:, Command.MAX_SPEED] = speed
        self.command[:, Command.ROBOT_ROLE] = RobotRole.UNSEEN
        self.command[:, Command.GROUP_ID] = group
        self._here = np.ones(n, dtype=bool)

    @property
    def states(self) -> Array:
        """A copy of the rows of `human_states`, shape (n, 7)."""
        port = self._crowd.get_human_states_output_port()
        rows: Array = port.Eval(self._simulator.get_context())
        return rows.reshape(-1, STATE_SIZE).copy()

    @property
    def time(self) -> float:
        """The time of the walkers, in seconds."""
        return self._steps * TIME_STEP

    def set_states(self, states: Array) -> None:
        """Sets the states of people, shape (n, 7), rows of `human_states`."""
        self._crowd.SetStates(self._simulator.get_mutable_context(), states)

    def send_away(self, who: Mask) -> None:
        """Removes people: from now on they are far away and at rest."""
        rows = np.flatnonzero(who & self._here)
        if len(rows) == 0:
            return
        states = self.states
        states[rows, :6] = 0.0
        states[rows, X] = _AWAY + _APART * rows
        states[rows, Y] = _AWAY
        self.set_states(states)
        self.command[rows, Command.HAS_GOAL] = 0.0
        self.command[rows, Command.GROUP_ID] = -1
        self._here[rows] = False

    def step(self) -> None:
        """Moves all people by one time step."""
        self._crowd.get_commands_input_port().FixValue(
            self._simulator.get_mutable_context(), self.command.ravel()
        )
        # To the middle of a step, so that rounding skips no update.
        self._simulator.AdvanceTo((self._steps + 0.5) * TIME_STEP)
        self._steps += 1

    def walk(
        self,
        seconds: float,
        *,
        leave: Callable[[Array], Mask] | None = None,
        each: Callable[["Walkers"], None] | None = None,
        patience: float = np.inf,
    ) -> Walk:
        """Moves all people for some time, or until all have left.

        Args:
            seconds: The largest duration, in seconds.
            leave: Returns for rows (n, 7) of `human_states` who leaves.
            each: Called before each step; it may change commands.
            patience: The time without a departure that ends the walk, in
                seconds.
        """
        times, states, present = [], [], []
        last, count = self.time, self._here.sum()
        for _ in range(round(seconds / TIME_STEP) + 1):
            rows = self.states
            times.append(self.time)
            states.append(rows)
            present.append(self._here.copy())
            if leave is not None:
                self.send_away(leave(rows))
                if self._here.sum() < count:
                    last, count = self.time, self._here.sum()
                if count == 0 or self.time - last > patience:
                    break
            if each is not None:
                each(self)
            self.step()
        return Walk(np.array(times), np.array(states), np.array(present))
