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

# What the legend tells, and of which cost.
_MEANING = {
    "cheap": 1,
    "dear": INSCRIBED - 1,
    "robot would touch": INSCRIBED,
    "occupied": LETHAL,
    "unknown": UNKNOWN,
}


def plot_costmap(
    costmap: Costmap, *, ax: Axes | None = None, legend: bool = False
) -> Axes:
    """Draws a costmap, as it lies in the world.

    Cells from cheap to dear are yellow to red, those where the robot would
    touch something purple, occupied ones near black, unknown ones grey. Free
    ones are clear: draw on axes with people, walls or a path as you like.

    Args:
        costmap: The map, as from the ports `local_costmap` and
            `global_costmap` of a planner.
        ax: Where to draw; by default a new figure.
        legend: Whether a legend tells the colors.

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
