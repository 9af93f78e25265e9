"""The checked arrays of a recorded trial."""

from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    REPLAY_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
)
from hunav_drake.systems.evaluation.recording_checks import (
    LARGEST,
    check_increasing,
    check_numbers,
    check_states,
    checked_array,
    checked_goal,
    checked_path,
    per_human,
)
from hunav_drake.systems.world.obstacles import Obstacles


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RecordedArrays:
    """The fields of a `Recording`; see there."""

    times: Array
    robot: Array
    humans: Array
    behavior_status: NDArray[np.int64] | None = None
    human_names: tuple[str, ...] = ()
    human_ids: tuple[int, ...] = ()
    behaviors: tuple[str, ...] = ()
    group_ids: tuple[int, ...] = ()
    goal: tuple[float, float, float] | None = None
    goal_tolerance: float = 0.2
    goal_yaw_tolerance: float = math.pi
    robot_max_speed: float | None = None
    obstacles: Obstacles = field(
        default_factory=lambda: Obstacles.from_points([])
    )
    walls_known: bool = True
    nearest_walls: Array | None = None
    reference_path: Array | None = None
    contacts: Array | None = None
    wall_contact: Array | None = None
    contact_forces_known: bool = False
    hunavsim_forces: bool = False
    told_velocities: Array | None = None
    replay: Array | None = None
    social_signals: Array | None = None
    doors: Array | None = None
    robot_name: str = ""
    end_time: float | None = None
    others: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        times = checked_array("times", self.times, (None,))
        samples = len(times)
        if not samples:
            raise ValueError("recording.times: needs at least one sample")
        check_increasing("times", times)
        robot = checked_array("robot", self.robot, (samples, STATE_SIZE))
        humans = checked_array(
            "humans", self.humans, (samples, None, STATE_SIZE)
        )
        n = humans.shape[1]
        check_states(robot, humans)
        status: Any = self.behavior_status
        if status is None:
            status = np.zeros((samples, n))
        status = checked_array("behavior_status", status, (samples, n))
        check_numbers("behavior_status", status, whole=True)
        status = status.astype(np.int64)
        status.setflags(write=False)
        optional = {
            "nearest_walls": (samples, n + 1, None, 2),
            "told_velocities": (samples, n + 1, 2),
            "contacts": (samples, n, CONTACT_SIZE),
            "wall_contact": (samples, CONTACT_SIZE),
            "replay": (samples, n, REPLAY_SIZE),
            "social_signals": (samples, n, SIGNAL_SIZE),
            "doors": (None, 2),
        }
        for name, shape in optional.items():
            if getattr(self, name) is not None:
                array = checked_array(name, getattr(self, name), shape)
                given = array
                if name == "nearest_walls":
                    given = array[~np.isnan(array).all(axis=-1)]
                elif name == "told_velocities":
                    given = array[~np.isnan(array)]
                check_numbers(name, given)
                self._set(**{name: array})
        if self.reference_path is not None:
            self._set(reference_path=checked_path(self.reference_path))
        self._set(
            times=times,
            robot=robot,
            humans=humans,
            behavior_status=status,
            goal=checked_goal(self.goal),
        )
        for name, default in (
            ("human_names", [f"human_{i + 1}" for i in range(n)]),
            ("human_ids", list(range(1, n + 1))),
            ("behaviors", ["regular"] * n),
            ("group_ids", [-1] * n),
        ):
            self._set(**{name: per_human(name, getattr(self, name), default)})
        for name in ("goal_tolerance", "goal_yaw_tolerance", "robot_max_speed"):
            if getattr(self, name) is None and name == "robot_max_speed":
                continue
            number = float(checked_array(name, getattr(self, name), ()))
            if not 0 < number <= LARGEST:
                raise ValueError(
                    f"recording.{name}: must be positive, and at most"
                    f" {LARGEST:g}, got {number}"
                )
            self._set(**{name: number})

        if self.end_time is not None:
            end_time = checked_array("end_time", self.end_time, ())
            check_numbers("end_time", end_time)
            self._set(end_time=float(end_time))
        if any(not np.array_equal(it.times, times) for it in self.others):
            raise ValueError(
                "recording.others: must have the same times as the first robot"
            )

    def _set(self, **values: Any) -> None:
        # As frozen dataclasses fill in their fields.
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """Returns the number of samples, N + 1."""
        return len(self.times)

    @property
    def num_humans(self) -> int:
        """The number of people, n."""
        return int(self.humans.shape[1])

    @property
    def near_walls_known(self) -> bool:
        """Whether at least the walls near the robot and people are known."""
        return self.walls_known or self.nearest_walls is not None
