"""Labels beside points, placed where they hide as little as possible."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hunav_drake.plots.style import SMALL_SIZE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# How far the middle of a label is from its point, in points: 8 directions,
# near and less near.
_REACH = np.array([7.0, 10.0])
_ANGLES = np.arange(8) * np.pi / 4 + np.pi / 2

# A label is left out with a label or a line nearer to its middle than this, in
# points.
_LABEL_ROOM = 9.0
_LINE_ROOM = 4.0


class Label(NamedTuple):
    """A text beside a point.

    Attributes:
        text: The text.
        place: The point (x, y), in the units of the axes.
        color: The color of the text.
    """

    text: str
    place: tuple[float, float]
    color: str


def place_labels(ax: "Axes", labels: Sequence[Label], *, scale: float) -> None:
    """Writes labels beside their points, away from lines and each other.

    Labels are placed in the given order; those without room are left out.

    Args:
        ax: The axes, with all lines drawn.
        labels: The labels.
        scale: The length of one unit of the axes, in points of the figure.
    """
    lines = [np.column_stack(line.get_data()) for line in ax.get_lines()]
    lines = [_dense(line * scale) for line in lines if len(line)]
    drawn = np.concatenate([np.zeros((0, 2)), *lines])
    directions = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
    offsets = (_REACH[:, None, None] * directions).reshape(-1, 2)
    placed = np.zeros((0, 2))
    for label in labels:
        middles = np.asarray(label.place) * scale + offsets
        to_line = _distance(middles, drawn)
        to_label = _distance(middles, placed)
        fits = (to_line > _LINE_ROOM) & (to_label > _LABEL_ROOM)
        if not fits.any():
            continue
        room = np.minimum(to_line, to_label)
        best = int(np.argmax(np.where(fits, np.minimum(room, 8.0), -1.0)))
        placed = np.vstack([placed, middles[best]])
        ax.annotate(
            label.text,
            label.place,
            xytext=offsets[best],
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=SMALL_SIZE - 1,
            color=label.color,
            annotation_clip=True,
            zorder=5,
        )


def _dense(line: np.ndarray) -> np.ndarray:
    """Returns points of a line no farther apart than a label is high."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    parts = [line]
    for i in np.flatnonzero(steps > 3.0):
        at = np.linspace(0.0, 1.0, int(steps[i] / 3.0) + 2)[1:-1, None]
        parts.append(line[i] + at * (line[i + 1] - line[i]))
    points = np.concatenate(parts)
    # Many samples of a person who stands are one point.
    points = np.unique(np.round(points), axis=0)
    return points[~np.isnan(points[:, 0])]


def _distance(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Returns the distance of each place to the nearest of the others."""
    if not len(others):
        return np.full(len(places), np.inf)
    gaps = np.hypot(*(places[:, None] - others).transpose(2, 0, 1))
    nearest: np.ndarray = gaps.min(axis=1)
    return nearest
