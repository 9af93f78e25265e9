"""Recorded trials, with all that is needed to show them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.runs.run_folders import RUNS, find_runs
from hunav_drake.scenario import LoadScenario, ScenarioError
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.population import draw_people
from hunav_drake.systems.behavior.library import sayings_of
from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    RADIUS,
    REACTIVE,
    REPLAYED,
    SILENT,
    STATE_SIZE,
    YAW,
    Signal,
    X,
    Y,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot import DifferentialDriveConfig
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.scene.overlays.reactions import is_calm
from hunav_drake.systems.scene.overlays.tags import calm_activities
from hunav_drake.systems.scene.scene_config import SceneConfig
from hunav_drake.systems.world.shapes import Polygon, Polyline, Wall, World

# The names of files of a run.
RECORDING, SCENARIO = "recording.npz", "scenario.yaml"


@dataclass(frozen=True, kw_only=True)
class RecordedTrial:
    """A recording with its world, people and robots.

    Attributes:
        recording: The recording.
        world: The world.
        humans: The people, in the order of the recording.
        robots: The robots by their names, in the order of the recording; the
            name of a single one is empty.
        scene: The options of the view.
        sayings: The texts that each person may say, if the recording has what
            people show each other: see `AddScene`.
    """

    recording: Recording
    world: World
    humans: list[HumanConfig]
    robots: dict[str, RobotConfig]
    scene: SceneConfig
    sayings: list[dict[float, str]] | None = None

    def Reacts(self, time: float) -> Mask:
        """Returns whether people react to the robot at a time (s), (n,).

        Recorded people do while the motion model moves them; those who sit,
        queue or talk do not.
        """
        status = self.recording.behavior_status
        reacts: Mask = self._Modes(time) == REACTIVE
        if status is not None:
            reacts |= np.asarray(status[self._Last(time)] != 0)
        return reacts & ~is_calm(self.Signals(time))

    def Activities(self, time: float) -> list[str]:
        """Returns what each person does at a time, in a word, if anything."""
        signals = self.recording.social_signals
        row = None if signals is None else self.Signals(time)
        return calm_activities(row, self.recording.num_humans)

    def Signals(self, time: float) -> Array:
        """Returns what people show at a time (s), (n, 22); silence if none."""
        signals = self.recording.social_signals
        if signals is None:
            return np.tile(SILENT, (self.recording.num_humans, 1))
        # (Before the first tick nobody has shown anything, not even that they
        # sit.)
        rows: Array = signals[max(self._Last(time), min(1, len(signals) - 1))]
        return rows

    def Says(self, time: float) -> list[str]:
        """Returns what each person says at a time, in seconds, if anything."""
        if self.sayings is None:
            return [""] * self.recording.num_humans
        said = self.Signals(time)[:, Signal.UTTERANCE].tolist()
        return [
            texts.get(code, "")
            for texts, code in zip(self.sayings, said, strict=True)
        ]

    def Follows(self, time: float) -> Mask:
        """Returns whether people follow their recording at a time, (n,)."""
        follows: Mask = self._Modes(time) == REPLAYED
        return follows

    def _Modes(self, time: float) -> Array:
        replay = self.recording.replay
        if replay is None:
            return np.zeros(self.recording.num_humans)
        modes: Array = replay[self._Last(time), :, 0]
        return modes

    def _Last(self, time: float) -> int:
        """Returns the last sample at a time, in seconds."""
        times = self.recording.times
        return max(int(np.searchsorted(times, time + 1e-9, "right")) - 1, 0)

    @property
    def duration(self) -> float:
        """The time from the first to the last sample, in seconds."""
        return float(self.recording.times[-1] - self.recording.times[0])

    def States(self, time: float) -> tuple[Array, Array]:
        """Returns the states at a time, interpolated between samples.

        Args:
            time: In seconds, on the clock of the recording.

        Returns:
            The states of the people (n, 7), NaN for absent people, and those
            of the robots (m, 7).
        """
        times = self.recording.times
        right = int(np.clip(np.searchsorted(times, time), 1, len(times) - 1))
        if len(times) == 1:
            right = 0
        left = max(right - 1, 0)
        span = times[right] - times[left]
        share = 0.0 if span == 0 else (time - times[left]) / span
        share = float(np.clip(share, 0.0, 1.0))
        both = []
        for rows in (self.recording.humans, self._robot_rows):
            a, b = rows[left], rows[right]
            state = a + share * (b - a)
            turn = (b[..., YAW] - a[..., YAW] + np.pi) % (2 * np.pi) - np.pi
            state[..., YAW] = a[..., YAW] + share * turn
            both.append(state)
        return both[0], both[1]

    @cached_property
    def _robot_rows(self) -> Array:
        rows = [it.robot for it in self.recording.robots]
        result: Array = np.stack(rows, axis=1)
        return result


def LoadRecordedTrial(path: str | Path) -> RecordedTrial:
    """Loads the recording of a run.

    Args:
        path: The folder of a run; a folder of results with one run; or a
            recording of another program in a format of `ReadRecording`, with
            the people and the robot of the recording, and default heights of
            walls.

    Raises:
        OSError: If a file cannot be read.
        ValueError: If there is no valid recording, or if there are several.
    """
    path = Path(path)
    file = recording_file(path) if path.is_dir() else path
    recording = ReadRecording(file)
    if not len(recording):
        raise ValueError(f"{file}: the recording is empty")
    scenario_file = file.with_name(SCENARIO)
    if file.name == RECORDING and scenario_file.exists():
        try:
            scenario = LoadScenario(filename=str(scenario_file))
        except ScenarioError as error:
            raise ValueError(
                f"{error}\n(it tells how the run looked; without it the run is"
                " drawn from its recording alone)"
            ) from error
        humans = draw_people(scenario)
        if len(humans) != recording.num_humans:
            humans = _people_of(recording)
        robots = robots_of(scenario)
        if [*robots] != [it.robot_name for it in recording.robots]:
            robots = _robots_of(recording)
        return RecordedTrial(
            recording=recording,
            world=scenario.world,
            humans=humans,
            robots=robots,
            scene=scenario.scene,
            sayings=None
            if recording.social_signals is None
            else sayings_of(
                (it.behavior for it in humans), profile=scenario.crowd.profile
            ),
        )
    return RecordedTrial(
        recording=recording,
        world=_world_of(recording),
        humans=_people_of(recording),
        robots=_robots_of(recording),
        scene=SceneConfig(),
    )


def recording_file(folder: Path) -> Path:
    """Returns the recording of a run, from its folder or that of results.

    Raises:
        ValueError: If there is none, or there are several.
    """
    if (folder / RECORDING).exists():
        return folder / RECORDING
    if (folder / "metadata.yaml").exists():
        # A bag of ROS 2 is its folder.
        return folder
    runs = list(find_runs(folder).values())
    if len(runs) == 1 and (runs[0] / RECORDING).exists():
        return runs[0] / RECORDING
    if runs:
        shown = ", ".join(str(run) for run in runs[:5])
        more = f" and {len(runs) - 5} more" if len(runs) > 5 else ""
        raise ValueError(
            f"{folder}: holds {len(runs)} runs; name one of them: {shown}{more}"
        )
    raise ValueError(
        f"{folder}: there is no recording: neither {RECORDING} nor a folder"
        f" {RUNS}; `hunav run SCENARIO --out {folder}` makes one"
    )


def _world_of(recording: Recording) -> World:
    obstacles = recording.obstacles
    walls: list[Wall] = []
    for i in range(len(obstacles)):
        rows = obstacles.segments[obstacles.first[i] : obstacles.first[i + 1]]
        if not len(rows):
            continue
        points = [(float(x), float(y)) for x, y in rows[:, :2]]
        if obstacles.solid[i] and len(points) > 2:
            walls.append(Polygon(points=points))
        else:
            end = (float(rows[-1, 2]), float(rows[-1, 3]))
            walls.append(Polyline(points=[*points, end]))
    return World(walls=walls)


def _people_of(recording: Recording) -> list[HumanConfig]:
    people = []
    for i in range(recording.num_humans):
        rows = recording.humans[:, i]
        known = rows[~np.isnan(rows[:, X])]
        row = known[0] if len(known) else np.zeros(STATE_SIZE)
        radius = float(np.clip(row[RADIUS], 0.1, 1.0))
        x, y = known[-1, [X, Y]] if len(known) else (0.0, 0.0)
        people.append(
            HumanConfig(
                name=recording.human_names[i],
                id=recording.human_ids[i],
                pose=_pose(row),
                goals=[(float(x), float(y))],
                radius=radius,
                behavior=recording.behaviors[i],
            )
        )
    return people


def _robots_of(recording: Recording) -> dict[str, RobotConfig]:
    return {it.robot_name: _robot_of(it) for it in recording.robots}


def _robot_of(recording: Recording) -> RobotConfig:
    first = recording.robot[0]
    radius = float(np.clip(first[RADIUS], 0.05, 2.0))
    return DifferentialDriveConfig(
        start=_pose(first), goal=recording.goal, radius=radius
    )


def _pose(state: Array) -> tuple[float, float, float]:
    return float(state[X]), float(state[Y]), float(state[YAW])
