"""The costmap of a planner as a plot."""

from matplotlib.patches import Patch

from hunav_drake.report.plots.style import Axes, new_axes
from hunav_drake.systems.world.maps.cost_picture import (
    cost_colors,
    costmap_picture,
)
from hunav_drake.systems.world.maps.costs import (
    INSCRIBED,
    LETHAL,
    UNKNOWN,
    Costmap,
)

# The entries of the legend, and their costs.
_MEANING = {
    "low cost": 1,
    "high cost": INSCRIBED - 1,
    "robot in collision": INSCRIBED,
    "occupied": LETHAL,
    "unknown": UNKNOWN,
}


def plot_costmap(
    costmap: Costmap, *, ax: Axes | None = None, legend: bool = False
) -> Axes:
    """Draws a costmap in the world frame.

    Cells of low to high cost are yellow to red; cells in which the center of
    the robot would mean a collision are purple, occupied ones nearly black,
    unknown ones gray. Free cells are transparent, so the axes may also show
    people, walls or a path.

    Args:
        costmap: The map, as from the ports `local_costmap` and
            `global_costmap` of a planner.
        ax: Where to draw; by default a new figure.
        legend: Whether to draw a legend of the colors.

    Returns:
        The axes.
    """
    axes = new_axes(ax, 3.2, layout="compressed")
    rows, columns = costmap.costs.shape
    if not rows * columns:
        return axes
    x, y = costmap.origin
    r = costmap.resolution
    axes.imshow(
        costmap_picture(costmap).convert("RGBA"),
        extent=(x, x + columns * r, y, y + rows * r),
        interpolation="nearest",
    )
    axes.set(xlabel="x (m)", ylabel="y (m)")
    if legend:
        colors = cost_colors() / 255
        handles = [
            Patch(facecolor=colors[cost], label=meaning)
            for meaning, cost in _MEANING.items()
            if meaning != "unknown" or (costmap.costs == UNKNOWN).any()
        ]
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1))
    return axes
