"""Labels beside points, placed where they hide as little as possible."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import shapely

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
_LINE_ROOM = 3.5


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
    """Writes labels beside their points, away from drawn lines and each other.

    They are placed in the given order; those without room are left out. One
    unit of the axes is `scale` points long in the figure.
    """
    drawn = shapely.geometrycollections(
        [
            _shape(np.column_stack(it.get_data()) * scale)
            for it in ax.get_lines()
        ]
    )
    directions = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
    offsets = (_REACH[:, None, None] * directions).reshape(-1, 2)
    placed = [np.full(2, np.inf)]
    for label in labels:
        middles = np.asarray(label.place) * scale + offsets
        to_line = shapely.distance(shapely.points(middles), drawn)
        gaps = np.linalg.norm(middles - np.array(placed)[:, None], axis=2)
        to_label = gaps.min(axis=0)
        fits = (to_line > _LINE_ROOM) & (to_label > _LABEL_ROOM)
        if not fits.any():
            continue
        room = np.minimum(to_line, to_label)
        best = int(np.argmax(np.where(fits, np.minimum(room, 8.0), -1.0)))
        placed.append(middles[best])
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


def _shape(points: np.ndarray) -> shapely.Geometry:
    points = points[~np.isnan(points[:, 0])]
    return shapely.LineString(points if len(points) != 1 else [*points] * 2)
