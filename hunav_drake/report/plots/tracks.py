"""The paths of recorded people, from above."""

from hunav_drake.report.plots.style import (
    COLUMN,
    MUTED,
    Axes,
    line_styles,
    new_axes,
)
from hunav_drake.systems.people.tracks import Tracks

# With more paths than this, lines are thin and faint.
_MANY = 30


def plot_tracks(tracks: Tracks, *, ax: Axes | None = None) -> Axes:
    """Plots the paths of recorded people, with a dot where each begins.

    Args:
        tracks: The people.
        ax: The axes to draw on; by default, a new figure.

    Returns:
        The axes.
    """
    ax = new_axes(ax, COLUMN, 2 * COLUMN, layout="compressed")
    many = len(tracks.people) > _MANY
    for wall in tracks.walls:
        ax.plot(*wall.T, color=MUTED, lw=1.2, zorder=3)
    styles = line_styles(len(tracks.people))
    for it, style in zip(tracks.people, styles, strict=True):
        color = style["color"]
        faint = 0.45 if many else 0.9
        width = 0.6 if many else 1.2
        ax.plot(*it.positions.T, color=color, lw=width, alpha=faint)
        size = 6 if many else 14
        ax.scatter(*it.positions[0], s=size, color=color, zorder=2, lw=0)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return ax
