"""One step of a crowd on arrays: the computation of `HumanCrowd`, no ports."""

from collections.abc import Callable, Sequence
import copy
import dataclasses
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Mask
from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    MOTION_SIZE,
    RADIUS,
    STATE_SIZE,
    TOUCH_SIZE,
    VX,
    VY,
    Command,
    Hold,
    X,
    Y,
)
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.crowd.bodies import hunavsim_step, whole_step
from hunav_drake.systems.crowd.bodies.adaptation import Adaptation
from hunav_drake.systems.crowd.bodies.bodies import ITERATIONS, Bodies
from hunav_drake.systems.crowd.bodies.contacts import robot_touches
from hunav_drake.systems.crowd.bodies.finish import for_each_robot
from hunav_drake.systems.crowd.bodies.time_gap import keep_time_gap
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import changed_to, limited, plain
from hunav_drake.systems.crowd.motion_model import (
    MotionModel,
    Snapshot,
    checked,
)
from hunav_drake.systems.crowd.placed import any_placed, keep_placed, place
from hunav_drake.systems.crowd.social_force.hash_order import hash_order
from hunav_drake.systems.crowd.social_force.model import SocialForceModel
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.world.obstacles import Obstacles

# Of floats, or of scalars with derivatives.
Array = NDArray[Any]

# The argument for people with their own radii and weights at walls.
_OWN = np.zeros((0, 2))
_OWN.setflags(write=False)


class CrowdJacobian(NamedTuple):
    """The derivatives of the next discrete state of a `HumanCrowd`.

    A row is for an element of that state, (x, y, yaw, vx, vy, omega) of each
    person. Where the step has a jump or a kink, the derivatives are those of
    the side that it takes. The reactions of people to those ahead of them (the
    time gap) or in narrow passages, and to robots that they pass, count as
    constant. So do the radii and factors of people at walls, which near doors
    under 1 m, with route planning, is an approximation: there, the derivative
    of v_x by x may be 0.3 where that of the step is 0. Without route planning,
    time gap and robot gap they are exact.

    Attributes:
        states: Shape (6n, 6n): by the present state, in the same order.
        robots: Shape (6n, 7m): by port ``robot_states``.
    """

    states: NDArray[np.float64]
    robots: NDArray[np.float64]


class Stepped(NamedTuple):
    """The result of a step of a crowd.

    Attributes:
        states: Shape (n, 6), the states of the people.
        stances: Shape (n, 3): see `standing`.
        touches: Shape (mn, 2), the touches of robots in the step if people and
            robots were not kept apart: see `robot_touches`. Without
            derivatives.
    """

    states: Array
    stances: Array
    touches: NDArray[np.float64]


class CrowdStep:
    """The steps of people with given bodies in a given room.

    A step is `look`, `forces`, `advance`; `take` is all three. Arrays may be
    of floats, or all of AutoDiffXd. Nothing here changes after the
    construction, except the cached routes of the room.

    Attributes:
        radii: Shape (n,), the radii of the people, in meters; read-only.
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        *,
        obstacles: Obstacles,
        config: CrowdConfig,
        time_step: float,
        with_derivatives: bool = False,
    ) -> None:
        """Constructs a CrowdStep; with derivatives, arrays are of AutoDiffXd.

        Raises:
            ValueError: If derivatives are asked for, and the model of
                ``config`` has none.
        """
        model = config.model
        self._name = name_of(model)
        self._model = (
            _differentiable(model, self._name) if with_derivatives else model
        )
        self._obstacles = obstacles
        self._obstacle_range = config.obstacle_range
        self._max_obstacles = config.max_obstacles
        self._time_step = time_step
        self.radii = np.array([human.radius for human in humans])
        # Models of users get these, too.
        self.radii.setflags(write=False)
        self._turns = _turns(humans, model)
        self._bodies = Bodies(humans, obstacles, config)
        self._time_gap, self._speed_matching, self._passing_speed = (
            getattr(model, name) if model.follows else 0.0
            for name in ("time_gap", "speed_matching", "passing_speed")
        )
        self._adaptation = Adaptation(
            self.radii, self._bodies.radii, obstacles, config
        )
        self._compiled = None if with_derivatives else self._in_one(config)

    def _in_one(
        self, config: CrowdConfig
    ) -> tuple[Callable[..., Array], Array, Array, Array] | None:
        """Returns the compiled step, and its last arguments, if there is one.

        That is `whole_step` or `hunavsim_step`.
        """
        model = config.model
        # (Robots that bodies stop have smaller radii to bodies.)
        if type(model) is not SocialForceModel or config.robots_stop:
            return None
        numbers = whole_step.Numbers(
            *self._bodies.options,
            parts=config.groups_part,
            reach=self._obstacle_range,
            most=self._max_obstacles,
            error=model.error_bound,
            time_gap=self._time_gap,
            matching=self._speed_matching,
            passing=self._passing_speed,
            time_step=self._time_step,
            iterations=ITERATIONS,
        )
        sizes = np.column_stack([self._bodies.sizes, self.radii])
        if model.kernel == "fast":
            step = whole_step.whole_step
            constants = np.array(numbers, dtype=float)
        elif model.kernel == "hunavsim":
            step = hunavsim_step.hunavsim_step
            rules = hunavsim_step.Rules(
                pushing=model.robot_obstacle_radius,
                measured=model.measured_velocities,
            )
            turns = (
                np.arange(len(sizes)) if self._turns is None else self._turns
            )
            constants = np.concatenate([numbers, rules, turns]).astype(float)
        else:
            return None
        return step, sizes, self._obstacles.table, constants

    def take(
        self,
        states: Array,
        command: Array,
        robots: Array,
        parameters: NDArray[np.float64],
        stances: Array,
    ) -> Stepped:
        """Returns the result of a step: see `look` and `advance`."""
        if states.dtype != object:
            taken = self.take_compiled(
                *(states.ravel(), command.ravel(), robots.ravel()),
                *(parameters.ravel(), stances.ravel()),
            )
            if taken is not None:
                ends = [states.size, states.size + stances.size]
                parts = np.split(taken, ends)
                return Stepped(
                    parts[0].reshape(states.shape),
                    parts[1].reshape(stances.shape),
                    parts[2].reshape(-1, TOUCH_SIZE),
                )
        snapshot = self.look(states, command, robots, parameters)
        return self.advance(snapshot, self.forces(snapshot), stances)

    def take_compiled(
        self,
        states: NDArray[np.float64],
        command: NDArray[np.float64],
        robots: NDArray[np.float64],
        parameters: NDArray[np.float64],
        stances: NDArray[np.float64],
    ) -> NDArray[np.float64] | None:
        """Returns the result of `take`, faster; None if there is none.

        The arguments are vectors with the rows of those there; the result is
        one with the rows of the fields of `Stepped`.
        """
        if self._compiled is None:
            return None
        eased = _OWN
        if not self._adaptation.is_idle(robots):
            given = command
            command, eased = self._adaptation.adapt(
                states, command, robots, parameters
            )
            keep_placed(command, given)
            if not len(eased):
                return None
        step, *constants = self._compiled
        result = step(
            *(states, command, stances, robots, parameters, eased), *constants
        )
        return result if len(result) else None

    def of(self, rows: NDArray[np.intp]) -> Self:
        """Returns the step of some of the people, in the same room.

        Args:
            rows: Their rows, in the order of their arrays.
        """
        part = copy.copy(self)
        part.radii = self.radii[rows]
        part.radii.setflags(write=False)
        if self._turns is not None:
            # The remaining ones, in the same order.
            part._turns = np.argsort(np.argsort(self._turns)[rows])
        part._bodies = self._bodies.of(rows)
        part._adaptation = self._adaptation.of(rows)
        part._compiled = None
        return part

    def look(
        self,
        states: Array,
        command: Array,
        robots: Array,
        parameters: NDArray[np.float64],
    ) -> Snapshot:
        """Returns the snapshot from which people decide how to move on.

        The parameters are floats, read-only. See `systems.crowd` for shapes.
        """
        states = limited(states)
        robots = limited(robots)
        command = limited(command)
        values = plain(states)
        wanted, eased = self._adaptation.adapt(
            *(values.ravel(), plain(command).ravel()),
            *(plain(robots).ravel(), parameters.ravel()),
        )
        keep_placed(wanted, plain(command).ravel())
        wanted = wanted.reshape(command.shape)
        if self._time_gap > 0:
            wanted, eased = keep_time_gap(
                *(values, self._bodies.radii, wanted, parameters, eased),
                *(self._time_gap, self._speed_matching, self._passing_speed),
            )
            keep_placed(wanted.ravel(), plain(command).ravel())
        eased.setflags(write=False)
        # (A waypoint does not move when people or goals do.)
        command = changed_to(command, wanted)
        return Snapshot(
            states=states,
            radii=self.radii,
            command=command,
            parameters=parameters,
            robots=robots,
            obstacles=self._obstacles,
            obstacle_range=self._obstacle_range,
            max_obstacles=self._max_obstacles,
            time_step=self._time_step,
            eased=eased,
            turns=self._turns,
        )

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces (n, FORCES_SIZE) on the people, in m/s^2.

        Raises:
            ValueError: If the model returns something else.
        """
        return checked(
            self._model.forces(snapshot),
            (len(snapshot.states), FORCES_SIZE),
            self._name,
            "forces",
        )

    def advance(
        self, snapshot: Snapshot, forces: Array, stances: Array
    ) -> Stepped:
        """Returns the result of a step under forces, corrected by bodies.

        Nothing acts on people who are placed (`Hold.PLACED`).

        Raises:
            ValueError: If the model returns something else, or somebody is
                placed and derivatives are asked for.
        """
        if snapshot.command.dtype == object:
            _check_nobody_is_placed(snapshot)
        elif any_placed(snapshot.command.ravel()):
            nobody = np.zeros(len(snapshot.states), dtype=np.bool_)
            nexts = np.zeros((0, STATE_SIZE))
            return self.advance_others(snapshot, forces, stances, nobody, nexts)
        return Stepped(
            *self._bodies.finish(
                snapshot, forces, self._move(snapshot, forces), stances
            )
        )

    def advance_others(
        self,
        snapshot: Snapshot,
        forces: Array,
        stances: Array,
        given: Mask,
        nexts: Array,
    ) -> Stepped:
        """Returns the result of a step in which some people's states are given.

        Nothing acts on those, nor on people who are placed (`Hold.PLACED`). The
        others make way for them as for robots, whom they cannot push. Nothing
        has derivatives.

        Args:
            snapshot: As in `advance`.
            forces: As there; those on people with given states do not matter.
            stances: As there.
            given: Shape (n,), whether the state at the end of the step is
                given. Others of that step may be outside before.
            nexts: Shape (k, 7), rows of `human_states` with the radii of the
                bodies: all people whose states are given and who are there at
                the end of the step, also who come in.
        """
        time_step, robots = self._time_step, snapshot.robots
        n, m = len(given), len(robots)
        after, stances = snapshot.states.copy(), stances.copy()
        touches = np.zeros((m, n, TOUCH_SIZE))
        placed = np.flatnonzero(
            ~given & (snapshot.command[:, Command.HOLD] == Hold.PLACED)
        )
        if len(placed):
            people = np.column_stack([after[:, : Y + 1], self._bodies.radii])
            bodies = np.vstack([people, robots[:, [X, Y, RADIUS]]])
            after = place(after, snapshot.command, bodies, time_step)
            rows = after[placed], self._bodies.radii[placed]
            nexts = np.vstack([nexts, np.column_stack(rows)])
            given = given.copy()
            given[placed] = True
            touches[:, placed] = self.of(placed).touches(
                snapshot.states[placed], after[placed], robots
            )
        free = np.flatnonzero(~given)
        stances[given] = 0.0
        if len(free):
            moving = nexts.copy()
            moving[:, : Y + 1] -= time_step * nexts[:, [VX, VY]]
            part = snapshot._replace(
                states=snapshot.states[free],
                radii=snapshot.radii[free],
                command=snapshot.command[free],
                robots=np.vstack([robots, moving]),
            )
            after[free], stances[free], touched = self._bodies.of(free).finish(
                part,
                forces[free],
                self._move(snapshot, forces)[free],
                stances[free],
            )
            touched = touched[: m * len(free)]
            touches[:, free] = touched.reshape(m, len(free), TOUCH_SIZE)
        return Stepped(after, stances, touches.reshape(-1, TOUCH_SIZE))

    def touches(
        self, before: Array, after: Array, robots: Array
    ) -> NDArray[np.float64]:
        """Returns the touches (m, n, 2) of people whom nobody pushes."""
        touches: NDArray[np.float64] = robot_touches(
            *(before, for_each_robot(after, len(robots)), self._bodies.radii),
            *(robots, self._time_step),
        )
        return touches.reshape(len(robots), len(before), TOUCH_SIZE)

    def overlaps(self, states: Array, robots: Array) -> Array:
        """Returns the depths (n,) of other bodies in people's, in meters.

        They are 0 for people without contact, and have no derivatives.
        """
        return self._bodies.overlaps(plain(states), plain(robots))

    def check_derivatives(self) -> None:
        """Checks that the model of motion has derivatives.

        Raises:
            ValueError: If it has none.
        """
        _differentiable(self._model, self._name)

    def jacobian(
        self, snapshot: Snapshot, forces: Array, stances: Array
    ) -> CrowdJacobian:
        """Returns the derivatives of `advance`, from the formulas.

        They are those of the social force model: see `check_derivatives`. All
        arrays are of floats.

        Raises:
            ValueError: If somebody is placed.
        """
        _check_nobody_is_placed(snapshot)
        # This is rarely needed, and takes a moment to load.
        from hunav_drake.systems.crowd.social_force.jacobian import (
            step_jacobian,
        )

        derivatives = step_jacobian(
            *snapshot.as_arguments, forces, snapshot.time_step
        )
        moved = self._move(snapshot, forces)
        self._bodies.chain(derivatives, snapshot, forces, moved, stances)
        size = snapshot.states.size
        return CrowdJacobian(derivatives[:, :size], derivatives[:, size:])

    def _move(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the states after the forces, not corrected by bodies."""
        return checked(
            self._model.advance(snapshot, forces),
            (len(snapshot.states), MOTION_SIZE),
            self._name,
            "advance",
        )


def _check_nobody_is_placed(snapshot: Snapshot) -> None:
    """Checks that there are derivatives.

    Raises:
        ValueError: If there are none, because somebody is placed.
    """
    placed = np.flatnonzero(
        plain(snapshot.command)[:, Command.HOLD] == Hold.PLACED
    )
    if len(placed):
        raise ValueError(
            "the step of people who sit, lie, sit down or stand up has no"
            f" derivatives; these are in the rows {placed.tolist()}; use an"
            " instant at which nobody does"
        )


def _turns(
    humans: Sequence[HumanConfig], model: MotionModel
) -> NDArray[np.intp] | None:
    """Returns the order of people: see `Snapshot.turns`."""
    if getattr(model, "kernel", "") != "hunavsim":
        return None
    rows = hash_order(people_ids(humans))[::-1]
    return None if (rows == np.arange(len(rows))).all() else rows


def _differentiable(model: MotionModel, name: str) -> MotionModel:
    """Returns the form of a model that takes scalars with derivatives.

    Raises:
        ValueError: If it has none.
    """
    if not isinstance(model, SocialForceModel):
        raise ValueError(
            "derivatives of a crowd need the motion model 'social_force';"
            f" {name!r} has none"
        )
    if model.kernel == "hunavsim":
        raise ValueError(
            "derivatives of a crowd need a kernel of the social force model"
            " other than 'hunavsim', whose rules jump"
        )
    return dataclasses.replace(model, kernel="numpy")
