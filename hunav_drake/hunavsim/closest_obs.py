"""Obstacles that another simulator passes for each person.

In HuNavSim, each agent of a request has the points of obstacles near it,
`closest_obs`: only these act on it.
"""

from collections.abc import Sequence
import dataclasses as dc
import functools

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    MOTION_SIZE,
    STATE_SIZE,
    Command,
    Hold,
    RobotRole,
)
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.profile import complete_people
from hunav_drake.systems.world.obstacles import Obstacles


class PeopleAtPoints:
    """Steps of people with given points instead of walls for some of them.

    All points of a person exert forces, at any distance. For this person, the
    walls exert no force, are no obstacle to motion and are not planned around.
    Walls still hide the robot from all people.
    """

    def __init__(
        self,
        diagram: Diagram,
        humans: Sequence[HumanConfig],
        *,
        obstacles: Obstacles | None,
        config: CrowdConfig | None,
        time_step: float,
    ) -> None:
        """Takes a diagram of `MakeHumans` and its arguments."""
        config = config or CrowdConfig()
        self._crowd = diagram.GetSubsystemByName("crowd")
        self._humans = complete_people(humans, config.profile)
        self._walls = obstacles or Obstacles.from_points([])
        self._config = config
        self._time_step = time_step

    def CalcNext(
        self,
        context: Context,
        points: Sequence[Array | None] = (),
        *,
        one_by_one: bool = False,
    ) -> Array | None:
        """Returns the states of all people one step later.

        Args:
            context: A Context of the diagram; it is not changed.
            points: The result of `read_closest_obs`; by default, no points.
            one_by_one: Whether each person moves as if nobody else had moved
                before, also with the rules of HuNavSim.

        Returns:
            Shape (n, 6), rows (x, y, yaw, vx, vy, omega); None if a step of
            the diagram has the same result.
        """
        points = points or [None] * len(self._humans)
        in_turn = getattr(self._config.model, "kernel", "") == "hunavsim"
        if all(own is None for own in points) and not (in_turn and one_by_one):
            return None
        own = self._crowd.GetMyContextFromRoot(context)
        states, stances = (
            own.get_discrete_state(k).CopyToVector() for k in range(2)
        )
        commands = self._crowd.get_commands_input_port().Eval(own)
        robots = np.zeros((0, STATE_SIZE))
        if self._crowd.HasInputPort("robot_states"):
            robots = self._crowd.get_robot_states_input_port().Eval(own)
        now = _Now(
            states.reshape(-1, MOTION_SIZE),
            commands.reshape(-1, COMMAND_SIZE),
            robots.reshape(-1, STATE_SIZE),
            self._crowd.GetWeights(own),
        )
        steps = self._steps(points)
        stood = stances.reshape(len(points), -1)
        if in_turn:
            return _move_in_turn(steps, now, stood, one_by_one)
        return _move_at_once(steps, now, stood)

    def _steps(self, points: Sequence[Array | None]) -> list[CrowdStep]:
        """Returns the step of each person: a crowd at the same obstacles."""
        at_points = dc.replace(
            self._config,
            obstacle_range=MAX_COORDINATE,
            max_obstacles=0,
            keep_out_of_walls=False,
            route_planning=False,
        )
        return [
            self._among_walls
            if own is None
            else self._step(Obstacles.from_points(own), at_points)
            for own in points
        ]

    @functools.cached_property
    def _among_walls(self) -> CrowdStep:
        return self._step(self._walls, self._config)

    def _step(self, obstacles: Obstacles, config: CrowdConfig) -> CrowdStep:
        return CrowdStep(
            self._humans,
            obstacles=obstacles,
            config=config,
            time_step=self._time_step,
        )


@dc.dataclass(frozen=True)
class _Now:
    """The arguments of `CrowdStep.look`."""

    states: Array
    command: Array
    robots: Array
    parameters: Array

    def look(self, step: CrowdStep) -> Snapshot:
        return step.look(
            self.states, self.command, self.robots, self.parameters
        )


def _move_at_once(
    steps: Sequence[CrowdStep], now: _Now, stances: Array
) -> Array:
    """Returns the states after a step in which all move at once.

    In each person's step, all people move by their own forces, so that bodies
    keep apart at their real places.
    """
    looks = [now.look(step) for step in steps]
    forces = np.array(
        [
            step.forces(look)[i]
            for i, (step, look) in enumerate(zip(steps, looks, strict=True))
        ]
    )
    after = [
        step.advance(look, forces, stances).states[i]
        for i, (step, look) in enumerate(zip(steps, looks, strict=True))
    ]
    return np.array(after)


def _move_in_turn(
    steps: Sequence[CrowdStep], now: _Now, stances: Array, one_by_one: bool
) -> Array:
    """Returns the states after a step by HuNavSim's rules.

    A person who reacts to the robot sees those who moved before, unless people
    move one by one. All others stay while a person moves.
    """
    turns = now.look(steps[0]).turns
    rows = np.arange(len(steps)) if turns is None else turns
    after = now.states.copy()
    for i in rows[::-1]:
        role = now.command[i, Command.ROBOT_ROLE]
        in_turn = role == RobotRole.UNSEEN_IN_TURN and not one_by_one
        command = now.command.copy()
        others = np.arange(len(rows)) != i
        command[others, Command.HOLD] = Hold.STAY
        command[others, Command.TURN_RATE] = 0.0
        command[others, Command.ROBOT_ROLE] = RobotRole.UNSEEN
        moved = steps[i].take(
            after if in_turn else now.states,
            command,
            now.robots,
            now.parameters,
            stances,
        )
        after[i] = moved.states[i]
    return after
