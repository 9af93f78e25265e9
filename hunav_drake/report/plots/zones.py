"""The time that the robot spends in each proxemic zone."""

from typing import NamedTuple

import numpy as np

from hunav_drake.report.plots.runs import Runs, recordings, robots_apart
from hunav_drake.report.plots.style import (
    SMALL_SIZE,
    Axes,
    label_rows,
    legend_outside,
    new_axes,
    note,
    shown_apart,
)
from hunav_drake.systems.evaluation.metrics.proxemics import (
    INTIMATE,
    PERSONAL,
    SOCIAL,
)
from hunav_drake.systems.evaluation.recording import Recording


class Zone(NamedTuple):
    """A proxemic zone around a person (Hall 1969).

    Attributes:
        name: Its name.
        low: Its inner limit, in meters from surface to surface.
        high: Its outer limit, in the same way.
        color: Its color in plots.
    """

    name: str
    low: float
    high: float
    color: str


ZONES = (
    Zone("intimate", 0.0, INTIMATE, "#d55e00"),
    Zone("personal", INTIMATE, PERSONAL, "#e69f00"),
    Zone("social", PERSONAL, SOCIAL, "#56b4e9"),
    Zone("public", SOCIAL, np.inf, "#d9d9d9"),
)

# The least width of a part of a bar with a number, in percent.
_NARROW = 9.0


def plot_zones(data: Runs, *, ax: Axes | None = None) -> Axes:
    """Draws the share of time in each proxemic zone of the closest person.

    Each run has a bar, and each of several robots. The rest to 100 % is the
    time without people.

    Args:
        data: One run, or several.
        ax: Where to draw; by default a new figure.

    Raises:
        TypeError: If the data are not runs.
    """
    runs = robots_apart(recordings(data))
    ax = new_axes(ax, zones_height(len(runs)))
    shares = np.array([zone_shares(run) for run in runs.values()])
    shares = shares.reshape(-1, len(ZONES))
    rows = np.arange(len(runs))
    starts = np.cumsum(shares, axis=1) - shares
    for zone, width, left in zip(ZONES, shares.T, starts.T, strict=True):
        bars = ax.barh(
            rows,
            width,
            left=left,
            height=0.75,
            color=zone.color,
            label=zone.name,
            edgecolor="white",
            lw=0.5,
        )
        ax.bar_label(
            bars,
            [f"{w:.0f} %" if w >= _NARROW else "" for w in width],
            label_type="center",
            fontsize=SMALL_SIZE,
        )
    if not shares.any():
        note(ax, "there are no people")
    ax.set(xlabel="share of time (%)", xlim=(0, 100))
    label_rows(ax, shown_apart(runs))
    legend_outside(ax, columns=4)
    return ax


def zones_height(num_runs: int) -> float:
    """Returns the height of the figure for a number of runs, in inches."""
    return 0.8 + 0.22 * max(1, num_runs)


def zone_shares(recording: Recording) -> list[float]:
    """Returns the share of samples in each of `ZONES`, in percent."""
    gap = recording.features.closest_gap
    return [
        100.0 * float(np.mean((zone.low <= gap) & (gap < zone.high)))
        for zone in ZONES
    ]
