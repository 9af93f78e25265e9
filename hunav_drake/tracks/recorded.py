"""The recorded people of a scenario, as their files have them."""

from collections.abc import Iterable
import dataclasses
import functools
import math
import os
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.people.human_config import STAND_IN, HumanConfig
from hunav_drake.systems.people.track_config import TrackConfig, TracksConfig
from hunav_drake.systems.people.track_groups import (
    nearest_others,
    walking_groups,
)
from hunav_drake.systems.people.tracks import WALKING, Track, Tracks, motion_at
from hunav_drake.tracks.files import ReadTracks

# The least radius of the body of a recorded person, in meters.
_SMALLEST_BODY = 0.1
# Times that differ by less are the same: in steps, and in seconds.
_SAME = 1e-9


def load_tracks(config: TracksConfig) -> Tracks:
    """Returns the tracks that a configuration names; the trial begins at 0 s.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not valid, or nobody is there.
    """
    status = os.stat(config.file)
    reading = _Reading(
        *(config.file, status.st_mtime_ns, status.st_size, status.st_ino),
        *(config.format, config.fps, config.unit, config.start),
        *(config.end, config.smooth),
    )
    return _load(reading)


class _Reading(NamedTuple):
    """All that tracks depend on: the state of a file, and options."""

    file: str
    changed: int
    size: int
    number: int
    format: str
    fps: float | None
    unit: str | None
    start: float
    end: float | None
    smooth: float | None


@functools.lru_cache(maxsize=8)
def _load(reading: _Reading) -> Tracks:
    file = reading.file
    start, end = reading.start, reading.end
    tracks = ReadTracks(
        file, reading.format, fps=reading.fps, unit=reading.unit
    ).split()
    within = tracks.between(start, math.inf if end is None else end)
    if not within.people:
        first = min(it.times[0] for it in tracks.people)
        last = max(it.times[-1] for it in tracks.people)
        until = "on" if end is None else f"to {end:g} s"
        raise ValueError(
            f"{file}: nobody is there from {start:g} s {until}; the recording"
            f" is from {first:g} to {last:g} s"
        )
    for it in within.people:
        if it.id < 0 or np.abs(it.positions).max() > MAX_COORDINATE:
            raise ValueError(
                f"{file}: person {it.id} cannot be replayed: the number must be"
                f" at least 0, and rows within {MAX_COORDINATE:g} m of the"
                " origin along x and y; see `hunav tracks` to shift them"
            )
    if reading.smooth is not None:
        within = within.smoothed(reading.smooth or None)
    return within


def present(
    tracks: Iterable[Track], time_step: float, duration: float
) -> list[Track]:
    """Returns those who are there at a step of a trial; times in seconds."""
    return [
        it
        for it in tracks
        if math.ceil(it.times[0] / time_step - _SAME) * time_step
        <= min(it.times[-1], duration) + _SAME
    ]


def track_of(config: TrackConfig) -> Track:
    """Returns the track of a person.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not valid, or has no such person.
    """
    people = {it.id: it for it in load_tracks(config).people}
    if config.id not in people:
        some = ", ".join(map(str, [*people][:10]))
        more = ", ..." if len(people) > 10 else ""
        raise ValueError(
            f"{config.file}: there is no person {config.id}; there are"
            f" {some}{more}"
        )
    return people[config.id]


def with_track(human: HumanConfig) -> HumanConfig:
    """Returns a person with pose, goal, speed and body of its recording.

    The radius of the body, unless it is given, is at most half of the least
    distance from any other recorded person, but 0.1 m or more: so nobody who
    was recorded overlaps others. A person without a track stays as it is.

    Raises: As `track_of`.
    """
    if human.track is None:
        return human
    track = track_of(human.track)
    motion = motion_at(track, track.times)
    speeds = np.hypot(*motion.velocities.T)
    walking = speeds[speeds > WALKING]
    (x, y), (goal_x, goal_y) = track.positions[[0, -1]].tolist()
    speed = float(walking.mean()) if len(walking) else 0.0
    room = _nearest(load_tracks(human.track))[track.id] / 2
    body = human.body_radius
    if body is None:
        body = min(human.contact_radius, max(room, _SMALLEST_BODY))
    return dataclasses.replace(
        human,
        pose=(x, y, float(motion.yaws[0])),
        goals=[(goal_x, goal_y)],
        desired_speed=min(speed, 10.0),
        max_speed=None,
        body_radius=body,
    )


def people_of(
    config: TracksConfig | None, first_group_id: int = 0
) -> list[HumanConfig]:
    """Returns all people of a file, named after their numbers in it.

    Args:
        config: The file; None for nobody.
        first_group_id: The number of the first group; the others follow.

    Raises: As `load_tracks`.
    """
    if config is None:
        return []
    tracks = load_tracks(config)
    options = {
        field.name: getattr(config, field.name)
        for field in dataclasses.fields(TracksConfig)
    }
    return [
        with_track(
            HumanConfig(
                name=f"recorded_{track.id}",
                pose=STAND_IN,
                cyclic=False,
                group_id=group if group < 0 else first_group_id + group,
                track=TrackConfig(**options, id=track.id),
            )
        )
        for track, group in zip(tracks.people, _groups(tracks), strict=True)
    ]


# (The tracks of a file are one object.)
_groups = functools.lru_cache(maxsize=8)(walking_groups)
_nearest = functools.lru_cache(maxsize=8)(nearest_others)
