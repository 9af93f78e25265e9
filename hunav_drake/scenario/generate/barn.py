"""The worlds of the BARN Challenge, read from a folder of the user."""

from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.scenario.generate.kind import (
    Draft,
    ScenarioKind,
    register_kind,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.schema import CONFIG, BodyRadius, Integer
from hunav_drake.systems.evaluation.metrics.contacts import contacts_with_walls
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.robot.robot_config import RobotLimits
from hunav_drake.systems.world.shapes import Disc, World

# The task: start and goal (x, y) in W, the distance from it that is enough, in
# meters, the time limit, in seconds, and the robot's speed, in m/s.
_START, _GOAL, _NEAR, _TIME, _SPEED = (
    (-2.25, 3.0),
    (-2.25, 13.0),
    1.0,
    100.0,
    2.0,
)

# Cell (i, j) of a path file is at CELL * (i, j) + CORNER, in meters.
_CELL, _CORNER = 0.15, (-4.575, 5.075)

# The time of a run counts once the robot has moved so far, in meters.
_MOVED = 0.1

# Where people start and walk, if there are any: before and behind the field.
_AREAS = [(-4.0, 1.5, -0.5, 4.5), (-4.0, 10.5, -0.5, 13.5)]


@register_kind("barn")
@dataclass(kw_only=True, config=CONFIG)
class Barn(ScenarioKind):
    """Worlds of the BARN Challenge: the seed is the number of the world."""

    is_drawn: ClassVar[bool] = False

    folder: StrictStr = ""
    """Folder with world_0.world, world_1.world, ..., and path_files beside
    them."""

    people: Annotated[Integer, Field(ge=0, le=1000)] = 0

    robot_radius: BodyRadius = 0.264
    """Radius of the robot's disc, in meters; by default that of a disc with the
    area of a Jackal of 0.508 m by 0.43 m."""

    def draw(self, seed: int, random: np.random.Generator) -> Draft:
        """Reads a world.

        Raises:
            ValueError: If a file is missing or damaged.
        """
        del random
        columns = read_columns(self._file(f"world_{seed}.world"))
        length = self.path_length(seed)
        limits = RobotLimits(
            max_speed=_SPEED,
            max_acceleration=20.0,
            max_turn_rate=4.0,
            max_turn_acceleration=25.0,
        )
        return Draft(
            World(
                walls=[
                    Disc(center=(x, y), radius=r)
                    for x, y, r in columns.tolist()
                ]
            ),
            self.robot(_START, _GOAL, goal_tolerance=_NEAR, limits=limits),
            _AREAS,
            _TIME,
            f"World {seed} of the BARN Challenge, with {len(columns)} columns;"
            f" its path has {length:.2f} m.",
        )

    def files(self) -> list[Path]:
        """Returns the files of all worlds, and those of their paths."""
        names = "world_*.world", "path_files/path_*.npy"
        return [it for name in names for it in Path(self.folder).glob(name)]

    def path_length(self, seed: int) -> float:
        """Returns the length of a world's path, from start to goal, in m.

        Raises:
            ValueError: If its file is missing or damaged.
        """
        file = self._file(f"path_files/path_{seed}.npy")
        try:
            with file.open("rb") as opened:
                cells = np.lib.format.read_array(opened, allow_pickle=False)
        except (OSError, ValueError, EOFError, MemoryError) as error:
            raise ValueError(f"{file}: is not a path: {error}") from error
        if (
            cells.ndim != 2
            or cells.shape[1] != 2
            or cells.dtype.kind not in "iuf"
            or not np.isfinite(cells).all()
        ):
            raise ValueError(
                f"{file}: must have finite numbers of shape (k, 2), got"
                f" {cells.dtype} of shape {cells.shape}"
            )
        path = np.vstack([_START, _CELL * cells + _CORNER, _GOAL])
        return float(np.hypot(*np.diff(path, axis=0).T).sum())

    def numbers(self, recording: Recording, seed: int) -> dict[str, float]:
        """Returns the score of a trial, as `barn_score`."""
        time = time_to_goal(recording)
        return {"barn_score": barn_score(time, self.path_length(seed))}

    def _file(self, name: str) -> Path:
        if not self.folder:
            raise ValueError(
                "barn: give the folder of its worlds, with world_0.world, ...:"
                " --worlds FOLDER, or `folder`"
            )
        path = Path(self.folder, name)
        if not path.is_file():
            raise ValueError(
                f"{path}: there is no such file; --worlds (or `folder`) must"
                " name the folder with world_0.world, ..., and with"
                " path_files/path_0.npy, ..."
            )
        return path


def read_columns(file: Path) -> Array:
    """Returns the upright cylinders of a world.

    Returns:
        Shape (k, 3), rows (x, y, radius) in W, in meters.

    Raises:
        ValueError: If the file is damaged, or has no cylinder.
    """
    # Imported here: most scenarios have no such world.
    from pydrake.geometry import Cylinder

    from hunav_drake.systems.common.models.gazebo import read_gazebo

    try:
        parts = read_gazebo(file).collisions
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error
    rows = [
        (*part.X_WG.translation()[:2], part.shape.radius())
        for part in parts
        if isinstance(part.shape, Cylinder)
    ]
    if not rows:
        raise ValueError(f"{file}: has no models with cylinders")
    return np.array(rows)


def time_to_goal(recording: Recording) -> float:
    """Returns when the robot is first near its goal, in seconds.

    Time counts from the first sample at which it has moved 0.1 m. It is
    infinite if it never is, or touches a wall; NaN if that is not known, as of
    physical robots.
    """
    touches: Any = contacts_with_walls(recording)
    at_goal = recording.features.at_goal
    moved = np.hypot(*(recording.robot[:, :2] - recording.robot[0, :2]).T)
    if touches[0] > 0 or not at_goal.any():
        return np.inf
    if np.isnan(touches[0]):
        return np.nan
    begin, end = int((moved >= _MOVED).argmax()), int(at_goal.argmax())
    return float(recording.times[end] - recording.times[begin])


def barn_score(time: float, length: float) -> float:
    """Returns the score of the BARN Challenge: T / clip(t, 2 T, 8 T).

    T is the time for a path of `length` meters at 2 m/s, t the robot's `time`,
    in seconds; infinite, for a failure, gives 0, and NaN gives NaN. (2022, the
    least was 4 T.)
    """
    if np.isinf(time):
        return 0.0
    least = length / _SPEED
    return float(least / np.clip(time, 2 * least, 8 * least))
