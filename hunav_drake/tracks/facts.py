"""What is in the tracks of recorded people, in numbers."""

import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.people.tracks import (
    LONGEST_GAP,
    WALKING,
    Tracks,
    motion_at,
)

# People who are nearer are neighbors, in meters.
_NEAR = 5.0


class TracksFacts(NamedTuple):
    """Numbers that describe tracks.

    Attributes:
        people: The number of people.
        rows: The number of rows.
        period: The most common time between two rows of a person, in seconds.
        start: The time of the first row, in seconds.
        end: The time of the last row, in seconds.
        low: The least x and y, in meters.
        high: The largest x and y, in meters.
        present: The mean number of people over time.
        most: The largest number of people at a time.
        stay: The median time from a person's first row to the last, in seconds.
        speeds: The 5th, 50th and 95th percentile of the speeds of people who
            walk, in m/s.
        standing: The share of rows in which people stand (below 0.2 m/s).
        area: The number of squares of 1 m that anybody is in, in m^2.
        density: The mean number of people in such a square that somebody is in,
            and its eight neighbors, per m^2.
        nearest: The median distance to the nearest other person, within 5 m, in
            meters.
        noise: The estimated standard deviation of a coordinate, in meters: see
            `Tracks.noise`.
    """

    people: int
    rows: int
    period: float
    start: float
    end: float
    low: tuple[float, float]
    high: tuple[float, float]
    present: float
    most: int
    stay: float
    speeds: tuple[float, float, float]
    standing: float
    area: int
    density: float
    nearest: float
    noise: float


def describe_tracks(tracks: Tracks) -> TracksFacts:
    """Returns the facts about tracks of at least one person."""
    people = tracks.people
    times = np.concatenate([it.times for it in people])
    places = np.concatenate([it.positions for it in people])
    smooth = tracks.smoothed()
    velocities = np.concatenate(
        [motion_at(it, it.times).velocities for it in smooth.people]
    )
    speeds = np.hypot(*velocities.T)
    walking = speeds[speeds > WALKING]
    period = tracks.period
    most, nearest, density = _at_each_time(tracks)
    start, end = float(times.min()), float(times.max())
    # (Who is seen seldom is there in between.)
    there = tracks.split(max(LONGEST_GAP, 1.5 * period)).people
    stays = sum(it.times[-1] - it.times[0] for it in there)
    cells = np.unique(np.floor(places).astype(int), axis=0)
    return TracksFacts(
        people=len(people),
        rows=len(times),
        period=period,
        start=start,
        end=end,
        low=_pair(places.min(axis=0)),
        high=_pair(places.max(axis=0)),
        present=float(stays) / (end - start) if end > start else float(most),
        most=most,
        stay=float(np.median([it.times[-1] - it.times[0] for it in people])),
        speeds=_percentiles(walking),
        standing=float(np.mean(speeds <= WALKING)),
        area=len(cells),
        density=density,
        nearest=nearest,
        noise=tracks.noise,
    )


def _pair(values: Array) -> tuple[float, float]:
    x, y = values.tolist()
    return x, y


def _percentiles(values: Array) -> tuple[float, float, float]:
    if not len(values):
        return math.nan, math.nan, math.nan
    low, middle, high = np.percentile(values, [5, 50, 95]).tolist()
    return low, middle, high


def _at_each_time(tracks: Tracks) -> tuple[int, float, float]:
    """Returns how many people are there at most, how near, and how dense.

    The times are those of all rows; between the own ones, people follow cubic
    splines.
    """
    from scipy.spatial import cKDTree

    people = tracks.split().people
    ticks = np.unique(np.concatenate([it.times for it in people]))
    shared = [
        ticks[(it.times[0] <= ticks) & (ticks <= it.times[-1])] for it in people
    ]
    places = np.vstack(
        [
            motion_at(it, own).positions
            for it, own in zip(people, shared, strict=True)
        ]
    )
    whens = np.concatenate(shared)
    order = np.argsort(whens, kind="stable")
    ends = np.searchsorted(whens[order], ticks, side="right")
    most, nearest, around = 0, [], []
    for here in np.split(places[order], ends[:-1]):
        most = max(most, len(here))
        away = cKDTree(here).query(here, k=2)[0][:, 1]
        nearest += away[away <= _NEAR].tolist()
        cells = np.floor(here)
        apart = np.abs(cells[:, None] - cells[None]).max(axis=-1)
        around += ((apart <= 1).sum(axis=1) / 9.0).tolist()
    middle = float(np.median(nearest)) if nearest else math.nan
    return most, middle, float(np.mean(around))


def tracks_text(facts: TracksFacts) -> str:
    """Returns the facts as lines for a terminal."""

    def number(value: float, digits: int = 2) -> str:
        return "-" if math.isnan(value) else f"{value:.{digits}f}"

    rate = "" if math.isnan(facts.period) else f", every {facts.period:g} s"
    (left, bottom), (right, top) = facts.low, facts.high
    slow, middle, fast = map(number, facts.speeds)
    lines = {
        "people": f"{facts.people}",
        "rows": f"{facts.rows}{rate}",
        "time": f"{facts.start:.1f} to {facts.end:.1f} s",
        "place": f"x {left:.1f} to {right:.1f} m, y {bottom:.1f} to"
        f" {top:.1f} m; {facts.area} m² are walked on",
        "at a time": f"{facts.present:.1f} people in the mean, {facts.most} at"
        " most",
        "a person stays": f"{facts.stay:.1f} s (median)",
        "walking speed": f"{middle} m/s (median; 5 to 95 %: {slow} to {fast})",
        "standing": f"{100 * facts.standing:.0f} % of rows",
        "density": f"{number(facts.density)} people/m² around a person",
        "nearest person": f"{number(facts.nearest)} m away (median within 5 m)",
        "noise": f"{1000 * facts.noise:.0f} mm (estimated standard deviation)",
    }
    return "\n".join(f"{name:15} {text}" for name, text in lines.items())
