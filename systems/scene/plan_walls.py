"""Draws walls in a plot, seen from above."""

from typing import TYPE_CHECKING

from hunav_drake.systems.world.obstacles import Obstacles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL = "#b3b3b3"


def draw_walls(ax: "Axes", obstacles: Obstacles) -> None:
    """Draws thin walls as lines and solid obstacles as areas."""
    from matplotlib.collections import LineCollection, PolyCollection

    solid, thin = [], []
    for i in range(len(obstacles)):
        rows = obstacles.segments[obstacles.first[i] : obstacles.first[i + 1]]
        if obstacles.solid[i]:
            solid.append(rows[:, :2])
        else:
            thin += list(rows.reshape(-1, 2, 2))
    ax.add_collection(PolyCollection(solid, facecolors=WALL, zorder=0.5))
    ax.add_collection(
        LineCollection(
            thin, colors=WALL, linewidths=1.5, capstyle="round", zorder=0.5
        )
    )
