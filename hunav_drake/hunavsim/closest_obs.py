"""Obstacles that another simulator tells people one by one.

In HuNavSim, each agent of a request brings the points of obstacles near it,
`closest_obs`: it feels these, and no others.
"""

from collections.abc import Sequence
import dataclasses as dc
import functools

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram

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

Array = NDArray[np.float64]


class PeopleAtPoints:
    """Steps of people some of whom feel given points instead of the walls.

    All of a person's points push, however far they are; the walls do not, nor
    do they lead the person around or stop the person. What hides the robot
    from people are still the walls.
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
        """Takes a diagram of `MakeHumans` and what it was made of."""
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
        """Returns where all people are one step later.

        Args:
            context: Of the diagram; it is not changed.
            points: As `read_closest_obs` gives them; nobody has any by
                default.
            one_by_one: Whether nobody else has moved when a person does, also
                by the rules of HuNavSim.

        Returns:
            Shape (n, 6), rows (x, y, yaw, vx, vy, omega); None if that is what
            a step of the diagram gives.
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
        """Returns for each person a step of a crowd who feel the same."""
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
    """What `CrowdStep.look` takes."""

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
    """Returns the states after a step that all take from one snapshot.

    So everybody is moved by the own forces in each of the steps: bodies keep
    apart where they really are.
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

    Who reacts to the robot moves once those have whose turn it was before, by
    their own points, if not one by one; so all others stay while a person
    moves.
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
