"""The interface of motion models, and the register of models."""

from abc import ABC, abstractmethod
from collections.abc import Callable
import math
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.people.parameters import K_OBSTACLE
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[np.float64]


class Snapshot(NamedTuple):
    """The state of the world that a motion model sees in one step.

    Attributes:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega, in W, SI units.
        radii: Shape (n,), in meters.
        command: Shape (n, COMMAND_SIZE): see `layout.Command`.
        parameters: Shape (n, 13): the fields of SocialForceParameters.
        robots: Shape (m, 7): rows of `robot_states`.
        obstacles: The walls.
        obstacle_range: Walls farther than this exert no force, in meters.
        max_obstacles: The largest number of walls that exert forces; 0 for all
            in range.
        time_step: In seconds.
        eased: The value of `at_walls`; None without narrow passages.
        turns: Shape (n,): the rows of people in the order of the rules of
            HuNavSim, of whom the last moves first; None if the rows are in
            that order.
    """

    states: Array
    radii: Array
    command: Array
    parameters: Array
    robots: Array
    obstacles: Obstacles
    obstacle_range: float
    max_obstacles: int
    time_step: float
    eased: Array | None = None
    turns: NDArray[np.intp] | None = None

    @property
    def at_walls(self) -> Array:
        """The radii and obstacle factors of people with respect to walls.

        Shape (n, 2): the radius, in meters, and the obstacle factor, in m/s^2.
        They are those of `radii` and `parameters`, except for people who turn
        their shoulders in a narrow passage: see `passages.ease`. A model that
        uses `radii` instead keeps people out of narrow doors.
        """
        if self.eased is not None:
            return self.eased
        return np.column_stack([self.radii, self.parameters[:, K_OBSTACLE]])

    @property
    def as_arguments(self) -> tuple[Any, ...]:
        """The first arguments of kernels, from the states to the walls."""
        return (
            *(self.states, self.radii, self.command, self.parameters),
            *(self.robots, self.at_walls, self.obstacles.table),
            *(self.obstacle_range, self.max_obstacles),
        )


class MotionModel(ABC):
    """A model: a dataclass of parameters, and functions of arrays.

    Both functions must be pure, and must not change their arguments: most of
    those are read-only. A model that keeps a margin between bodies and walls
    has it, in meters, as an attribute `safety_margin`.

    Attributes:
        follows: Whether people are made to follow each other at the model's
            `time_gap`, in seconds, with its `speed_matching` and
            `passing_speed`: see `bodies.time_gap`. It is False for models that
            do so themselves.
        keeps_radii: Whether people keep their radii clear of each other, and
            not only their bodies, where they pass in a door.
        uses_weights: The people for whom the factors of goal, obstacles and
            other people count that `HumanConfig.forces_mode` draws: everybody
            ("all"), nobody ("none"), or people in groups and people pushed by
            a robot ("pushed").
    """

    follows: ClassVar[bool] = False
    keeps_radii: ClassVar[bool] = False
    uses_weights: ClassVar[Literal["all", "pushed", "none"]] = "all"

    @abstractmethod
    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces on the people, from one snapshot of all of them.

        Returns:
            Shape (n, FORCES_SIZE), in m/s^2: see `layout.FORCES`. The total
            counts; a model that is not made of forces leaves the others zero.
        """

    @abstractmethod
    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the states of the people after one step under forces.

        Returns:
            Shape (n, 6), like `snapshot.states`.
        """


# The models by name; each is the dataclass of its parameters.
MOTION_MODELS = Registry(
    "motion model",
    MotionModel,
    default="social_force",
    home={
        "anticipation_velocity": ".anticipation_velocity",
        "collision_free_speed": ".collision_free_speed",
        "headed_social_force": ".headed_social_force",
        "orca": ".orca.model",
        "social_force": ".social_force.model",
    },
)


def register_motion_model[T](name: str) -> Callable[[type[T]], type[T]]:
    """Returns a decorator that registers a model by a name.

    Raises:
        ValueError: If the name is taken.
        TypeError: If the class is no dataclass that derives from
            `MotionModel`, or lacks one of its functions.
    """
    return MOTION_MODELS.register(name)


def checked(
    array: ArrayLike, shape: tuple[int, int], model: str, function: str
) -> NDArray[Any]:
    """Returns the result of a model, as an array for Drake and walls.

    Args:
        array: The result.
        shape: The shape that it must have.
        model: The name of the model.
        function: The function of the model that returned it.

    Raises:
        ValueError: If it is not made of finite numbers, or has another shape.
    """
    fault, cause = "", None
    try:
        result = np.ascontiguousarray(array)
        if result.dtype not in (np.float64, object):
            result = result.astype(float)
    except (TypeError, ValueError) as error:
        fault, cause = f"numbers by {function}(): {error}", error
    else:
        # A sum is finite only if all are, unless they are beyond all use.
        if result.shape != shape:
            fault = (
                f"an array of shape {shape} by {function}(), got {result.shape}"
            )
        elif result.dtype != object and not math.isfinite(result.sum()):
            bad = int(np.flatnonzero(~np.isfinite(result).all(axis=1))[0])
            fault = (
                f"finite numbers by {function}(), got {result[bad].tolist()}"
                f" for humans[{bad}]"
            )
    if fault:
        wrong = ValueError(f"the motion model {model!r} must give {fault}")
        # (Of code of one's own: see `fault_of_user_code`.)
        wrong.add_note("correct the model")
        raise wrong from cause
    return result
