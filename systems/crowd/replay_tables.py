"""The recordings of people as arrays, for compiled code."""

from collections.abc import Sequence
import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.crowd.replay import KINDS, ROSTER_SIZE
from hunav_drake.systems.people.track_config import TrackConfig
from hunav_drake.systems.people.tracks import Track, motion_at


class Tables(NamedTuple):
    """The recordings of n people as arrays.

    Attributes:
        roster: Shape (n, 10): see `replay`; zeros for people without recording.
        knots: Shape (k,), the times of their rows, in seconds.
        curves: Shape (k, 8): from each knot on, the coefficients of the cubic
            of x, then y.
        yaws: The headings at the steps of a trial, in radians, continuous.
    """

    roster: Array
    knots: Array
    curves: Array
    yaws: Array


def make_tables(
    tracks: Sequence[Track | None],
    configs: Sequence[TrackConfig | None],
    time_step: float,
) -> Tables:
    """Returns the tables of n people, None for those without recording."""
    # Imported here, so that a crowd without recorded people does not load it.
    from scipy.interpolate import CubicSpline

    roster = np.zeros((len(tracks), ROSTER_SIZE))
    knots, curves, yaws = [np.zeros(0)], [np.zeros((0, 8))], [np.zeros(0)]
    for row, track, config in zip(roster, tracks, configs, strict=True):
        if track is None or config is None:
            continue
        times = track.times
        cubics = np.zeros((len(times), 2, 4))
        cubics[:, :, 3] = track.positions
        if len(times) > 1:
            ends = "not-a-knot" if len(times) > 3 else "natural"
            path = CubicSpline(times, track.positions, bc_type=ends)
            cubics[:-1] = np.moveaxis(path.c, 0, -1)
        first = math.floor(times[0] / time_step)
        last = math.ceil(times[-1] / time_step)
        steps = np.arange(first, last + 1)
        row[:] = (
            *(sum(map(len, knots)), len(times), times[0], times[-1]),
            *(sum(map(len, yaws)), len(steps), first),
            *(KINDS.index(config.mode), config.on, config.off),
        )
        knots.append(times)
        curves.append(cubics.reshape(-1, 8))
        yaws.append(np.unwrap(motion_at(track, steps * time_step).yaws))
    return Tables(
        roster, np.concatenate(knots), np.vstack(curves), np.concatenate(yaws)
    )
