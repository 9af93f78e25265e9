"""Motion models judged by recorded people.

A window of a recording is 3.2 s of the past and 4.8 s of the future, the usual
protocol for ETH and UCY. A model starts from the past of all people who are
there throughout, and predicts their future. It is told where each goes: either
truly (the end of the window, and the mean speed to there), which judges how
people walk, or only ahead (straight on, with the velocity of the last step, as
constant velocity does), which judges whether avoiding others is worth anything.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
import math
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np
from pydrake.systems.analysis import Simulator
from scipy.spatial.distance import cdist
from scipy.stats import ks_2samp

from hunav_drake.runs.intervals import mean_interval
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    STATE_SIZE,
    Command,
    X,
    Y,
)
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.parameters import PARAMETERS
from hunav_drake.systems.people.tracks import Tracks
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.tracks.files import ReadTracks

# Seconds between two samples; how many are past (with the present one), and
# how many are to be predicted.
STEP, PAST, FUTURE = 0.4, 8, 12

# The time step of the models, in seconds, a part of STEP.
_TIME_STEP = 0.1
# The radius of people, in meters: a disc of the 0.113 m^2 (in summer 0.1, in
# winter 0.125) that an adult takes from above (Predtechenskii and Milinskii
# 1978) has 0.19 m (0.18, 0.2). In the cases of `hunav validate` it is the same.
# Bodies nearer than twice that overlap.
BODY = 0.2
# Who is slower has no goal, in m/s.
_STANDS = 0.15
# How much faster than they want people can walk; and at least so fast, in m/s.
_FASTER, _LEAST_MAX = 1.3, 0.3
# Goals are moved on by so much, in meters, so that nobody slows down there.
_BEYOND = 3.0
# Straight on, the goal is so far ahead, in seconds of walking.
_AHEAD = 20.0
# Only pairs that are nearer count for times to collision, in meters and s.
_NEAR, _SOON = 5.0, 5.0
# The local density is that of others who are nearer, in meters; the width of
# its steps, in persons/m^2, and the least number of samples in one.
_AROUND, _WIDTH, _ENOUGH = 2.0, 0.25, 20

Goal = Literal["true", "ahead"]
Predict = Callable[[Array, Goal], Array]


class Sample(NamedTuple):
    """What people do, whoever they are: all in one heap.

    Attributes:
        nearest: The distances to the nearest person, in meters.
        speeds: In m/s.
        densities: Of others within 2 m, for each speed, in persons/m^2.
        accelerations: Their sizes, in m/s^2.
        collisions: The times to collision up to 5 s, in seconds.
    """

    nearest: Array
    speeds: Array
    densities: Array
    accelerations: Array
    collisions: Array


class Score(NamedTuple):
    """How well a model predicts the people of a recording.

    Attributes:
        scene: The name of the recording.
        model: The name of the model.
        goal: What the model is told: see `Goal`.
        people: The number of predicted paths.
        ade: The mean distance from the recording, in meters, and the limits of
            its confidence interval of 95 %.
        fde: The same of the distance at the end.
        overlap: The share of persons and samples whose body overlaps another.
        nearest: How different the distances to the nearest person are from the
            recording: the Kolmogorov-Smirnov statistic, in [0, 1]. The next
            ones are so, too.
        speeds: Of speeds.
        accelerations: Of the sizes of accelerations.
        collisions: Of times to collision up to 5 s.
        by_density: How far the mean speed at a local density is from the
            recorded one, the mean over densities, in m/s: see
            `speeds_by_density`.
        sample: What the predicted people do.
    """

    scene: str
    model: str
    goal: Goal
    people: int
    ade: tuple[float, float, float]
    fde: tuple[float, float, float]
    overlap: float
    nearest: float
    speeds: float
    accelerations: float
    collisions: float
    by_density: float
    sample: Sample


def windows_of(tracks: Tracks, stride: int = FUTURE) -> Iterator[Array]:
    """Yields the people who are there throughout each window.

    Args:
        tracks: The recording.
        stride: The number of samples from one window to the next.

    Yields:
        Shape (n, PAST + FUTURE, 2), n > 0, in meters.
    """
    people = tracks.split().resampled(STEP).people
    if not people:
        return
    first = min(round(it.times[0] / STEP) for it in people)
    last = max(round(it.times[-1] / STEP) for it in people)
    places = np.full((len(people), last - first + 1, 2), np.nan)
    for row, it in zip(places, people, strict=True):
        begin = round(it.times[0] / STEP) - first
        row[begin : begin + len(it.times)] = it.positions
    size = PAST + FUTURE
    for begin in range(0, places.shape[1] - size + 1, stride):
        window = places[:, begin : begin + size]
        throughout = np.isfinite(window).all(axis=(1, 2))
        if throughout.any():
            yield window[throughout]


def read_windows(file: Path) -> list[Array]:
    """Returns the windows of a file of tracks.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not valid, or nobody is there for a window.
    """
    windows = list(windows_of(ReadTracks(file)))
    if not windows:
        raise ValueError(
            f"{file}: nobody is there for {(PAST + FUTURE) * STEP:g} s, as it"
            " takes; record longer, or see `hunav tracks` for its rate"
        )
    return windows


def constant_velocity(window: Array, goal: Goal) -> Array:
    """Predicts that all go on as in the last step; shape (n, FUTURE, 2).

    With the true goal, they walk straight there.
    """
    now = window[:, PAST - 1]
    step = now - window[:, PAST - 2]
    if goal == "true":
        step = (window[:, -1] - now) / FUTURE
    steps = np.arange(1, FUTURE + 1)[:, None]
    result: Array = now[:, None] + step[:, None] * steps
    return result


class CrowdPrediction:
    """Predicts people by a `HumanCrowd`."""

    def __init__(
        self,
        config: CrowdConfig,
        weights: Mapping[str, float] | None = None,
        obstacles: Obstacles | None = None,
        radius: float = BODY,
    ) -> None:
        """Constructs a CrowdPrediction.

        Args:
            config: The motion model, and how people perceive the world.
            weights: Names of `people.parameters.PARAMETERS`, and their values
                for everybody; by default, those of people.
            obstacles: The walls; none by default.
            radius: That of people, in meters.
        """
        self._obstacles = obstacles
        self._radius = radius
        self._config = config
        self._weights = weights or {}

    def __call__(self, window: Array, goal: Goal) -> Array:
        """Predicts the future of a window, shape (n, FUTURE, 2)."""
        return self.prepare(window, goal)(self._weights)

    def prepare(
        self, window: Array, goal: Goal
    ) -> Callable[[Mapping[str, float]], Array]:
        """Returns the function that predicts a window with some weights."""
        now = window[:, PAST - 1]
        velocity = (now - window[:, PAST - 2]) / STEP
        speed = np.hypot(*velocity.T)
        end = now + _AHEAD * velocity
        if goal == "true":
            way = window[:, -1] - now
            left = np.hypot(*way.T)
            speed = left / (FUTURE * STEP)
            far = left[:, None] > 1e-9
            ahead = np.divide(
                way, left[:, None], out=np.zeros_like(way), where=far
            )
            end = window[:, -1] + _BEYOND * ahead
        most = np.maximum(_FASTER * speed, _LEAST_MAX)
        commands = np.zeros((len(now), COMMAND_SIZE))
        commands[:, [Command.GOAL_X, Command.GOAL_Y]] = end
        commands[:, Command.GOAL_RADIUS] = 0.05
        commands[:, Command.HAS_GOAL] = speed > _STANDS
        commands[:, Command.DESIRED_SPEED] = speed
        commands[:, Command.MAX_SPEED] = most
        commands[:, Command.GROUP_ID] = -1.0
        people = [
            HumanConfig(
                pose=(x, y, 0.0),
                desired_speed=float(v),
                max_speed=float(m),
                radius=self._radius,
            )
            for (x, y), v, m in zip(now.tolist(), speed, most, strict=True)
        ]
        crowd = HumanCrowd(
            people,
            config=self._config,
            num_robots=0,
            time_step=_TIME_STEP,
            obstacles=self._obstacles,
        )
        context = crowd.CreateDefaultContext()
        crowd.get_commands_input_port().FixValue(context, commands.ravel())
        yaw = np.arctan2(velocity[:, 1], velocity[:, 0])
        crowd.SetStates(
            context, np.column_stack([now, yaw, velocity, np.zeros(len(now))])
        )
        whole = crowd.GetWeights(context)

        def roll(weights: Mapping[str, float]) -> Array:
            own = whole.copy()
            for name, value in weights.items():
                own[:, PARAMETERS.index(name)] = value
            crowd.SetWeights(context, own)
            simulator = Simulator(crowd, context.Clone())
            places = []
            for k in range(1, FUTURE + 1):
                simulator.AdvanceTo(k * STEP)
                states = port.Eval(simulator.get_context())
                places.append(states.reshape(-1, STATE_SIZE)[:, [X, Y]])
            return np.stack(places, axis=1)

        port = crowd.get_human_states_output_port()
        return roll


def _sample(window: Array, future: Array) -> Sample:
    """Returns what the people of a window do in a future, (n, FUTURE, 2)."""
    path = np.concatenate([window[:, PAST - 2 : PAST], future], axis=1)
    velocities = np.diff(path, axis=1) / STEP
    changes = np.diff(velocities, axis=1) / STEP
    nearest, collisions = [np.zeros(0)], [np.zeros(0)]
    densities = np.zeros(future.shape[:2])
    for k in range(FUTURE if len(window) > 1 else 0):
        here, moving = future[:, k], velocities[:, k + 1]
        away = cdist(here, here)
        np.fill_diagonal(away, np.inf)
        nearest.append(away.min(axis=1))
        around = (away < _AROUND).sum(axis=1)
        densities[:, k] = around / (np.pi * _AROUND**2)
        a, b = np.nonzero(np.triu(away < _NEAR))
        times = _times_to_collision(here[b] - here[a], moving[b] - moving[a])
        collisions.append(times[times <= _SOON])
    return Sample(
        np.concatenate(nearest),
        np.hypot(*velocities[:, 1:].reshape(-1, 2).T),
        densities.ravel(),
        np.hypot(*changes.reshape(-1, 2).T),
        np.concatenate(collisions),
    )


def _times_to_collision(offset: Array, velocity: Array) -> Array:
    """Returns when discs of BODY touch if they go on; infinite if never."""
    a = (velocity**2).sum(axis=1)
    b = (offset * velocity).sum(axis=1)
    c = (offset**2).sum(axis=1) - (2 * BODY) ** 2
    inside = b * b - a * c
    meets = (b < 0) & (inside >= 0) & (c > 0)
    times: Array = np.full(len(offset), np.inf)
    root = np.sqrt(inside[meets])
    times[meets] = (-b[meets] - root) / a[meets]
    return times


def judge_recorded(
    scene: str,
    windows: Sequence[Array],
    models: Mapping[str, Predict],
    goals: Sequence[Goal] = ("true", "ahead"),
) -> list[Score]:
    """Scores models on the windows of a recording.

    Args:
        scene: Its name.
        windows: Those of `windows_of`.
        models: The models by name.
        goals: What the models are told.
    """
    for goal in goals:
        check_choice("goals", goal, get_args(Goal))
    real = sample_of(windows)
    scores = []
    for goal in goals:
        for name, predict in models.items():
            futures = [predict(window, goal) for window in windows]
            errors = np.concatenate(
                [
                    np.hypot(*np.moveaxis(future - window[:, PAST:], 2, 0))
                    for future, window in zip(futures, windows, strict=True)
                ]
            )
            mean, final = errors.mean(axis=1), errors[:, -1]
            made = _joined(list(map(_sample, windows, futures)))
            scores.append(
                Score(
                    *(scene, name, goal, len(errors)),
                    (float(mean.mean()), *mean_interval(mean)),
                    (float(final.mean()), *mean_interval(final)),
                    _overlap(made),
                    _difference(made.nearest, real.nearest),
                    _difference(made.speeds, real.speeds),
                    _difference(made.accelerations, real.accelerations),
                    _difference(made.collisions, real.collisions),
                    _off_by_density(made, real),
                    made,
                )
            )
    return scores


def _joined(samples: list[Sample]) -> Sample:
    return Sample(*map(np.concatenate, zip(*samples, strict=True)))


def _overlap(sample: Sample) -> float:
    # (Who is alone has no nearest, but a speed.)
    near = np.count_nonzero(sample.nearest < 2 * BODY)
    return near / len(sample.speeds) if len(sample.speeds) else 0.0


def _difference(one: Array, other: Array) -> float:
    """Returns the Kolmogorov-Smirnov statistic; NaN without any values."""
    if not len(one) or not len(other):
        return float("nan")
    return float(ks_2samp(one, other).statistic)


def speeds_by_density(sample: Sample) -> tuple[Array, Array]:
    """Returns local densities, in persons/m^2, and mean speeds there, in m/s.

    Densities are the middles of steps of 0.25 persons/m^2; those with less than
    20 samples have the mean speed NaN.
    """
    step = (sample.densities / _WIDTH).astype(int)
    counts = np.bincount(step)
    means: Array = np.full(len(counts), np.nan)
    sums: Array = np.bincount(step, weights=sample.speeds)
    enough = counts >= _ENOUGH
    means[enough] = sums[enough] / counts[enough]
    middles = _WIDTH * (np.arange(len(counts), dtype=np.float64) + 0.5)
    return middles, means


def _off_by_density(one: Sample, other: Sample) -> float:
    """Returns `Score.by_density`; NaN without any common density."""
    means = [speeds_by_density(it)[1] for it in (one, other)]
    common = min(map(len, means))
    off = np.abs(means[0][:common] - means[1][:common])
    off = off[np.isfinite(off)]
    return float(off.mean()) if len(off) else math.nan


def sample_of(windows: Sequence[Array]) -> Sample:
    """Returns what the people of a recording do in the predicted time."""
    return _joined([_sample(it, it[:, PAST:]) for it in windows])


def recorded_overlap(windows: Sequence[Array]) -> float:
    """Returns the share of overlapping bodies in a recording: see `Score`."""
    return _overlap(sample_of(windows))
