"""Plot of the forces on people, seen from above."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.report.plots.style import (
    COLUMN,
    PALETTE,
    ROBOT,
    YELLOW,
    Axes,
    legend_outside,
    new_axes,
)
from hunav_drake.systems.common.layout import (
    FORCES,
    FORCES_SIZE,
    RADIUS,
    STATE_SIZE,
    YAW,
    X,
    Y,
)
from hunav_drake.systems.scene.plan_walls import draw_walls
from hunav_drake.systems.world.obstacles import Obstacles

_BLUE, _RED, _GREEN, _PURPLE, _ORANGE, _SKY = PALETTE[:6]
_BLACK = ROBOT
_COLORS: Mapping[str, str] = MappingProxyType(
    {
        "goal": _GREEN,
        "obstacle": _RED,
        "social": _BLUE,
        "group_gaze": YELLOW,
        "group_coherence": _ORANGE,
        "group_repulsion": _PURPLE,
        "robot_repulsion": _SKY,
        "total": _BLACK,
    }
)

# The size of the figure, in inches, large enough for the arrows.
_WIDTH, _HEIGHT = 2 * COLUMN, 1.4 * COLUMN

# Smaller forces are not drawn, in m/s^2: their arrows would be dots.
_LEAST_FORCE = 1e-3


def plot_forces(
    forces: ArrayLike,
    human_states: ArrayLike,
    *,
    robot_state: ArrayLike | None = None,
    obstacles: Obstacles | None = None,
    scale: float = 0.4,
    ax: Axes | None = None,
) -> Axes:
    """Draws people and the forces on them, seen from above.

    Each person is a disc with a nose in the direction of its heading. Each
    force is an arrow from the center of the disc; the thin black arrow is the
    sum. The legend names the forces that are not zero.

    Args:
        forces: The value of port ``forces``, shape (n, 16) or flat, in m/s^2.
        human_states: The value of port ``human_states``, shape (n, 7) or flat.
        robot_state: The value of port ``robot_state``, shape (m, 7) or flat.
        obstacles: The walls.
        scale: The length of an arrow of 1 m/s^2, in meters.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the arrays hold different numbers of people, or
            ``scale`` is not positive.
    """
    people = _rows(human_states, STATE_SIZE, "human_states")
    vectors = _rows(forces, FORCES_SIZE, "forces").reshape(-1, len(FORCES), 2)
    if len(people) != len(vectors):
        raise ValueError(
            f"forces must be for as many people as human_states:"
            f" {len(people)}, got {len(vectors)}"
        )
    if not scale > 0:
        raise ValueError(f"scale must be positive, got {scale}")
    ax = new_axes(ax, _HEIGHT, _WIDTH, layout="compressed")
    if obstacles is not None:
        draw_walls(ax, obstacles)
    _draw_discs(ax, people, color="0.75", name="person")
    if robot_state is not None:
        robots = _rows(robot_state, STATE_SIZE, "robot_state")
        _draw_discs(ax, robots, color="0.4", name="robot")
    for i, name in enumerate(FORCES):
        arrows = vectors[:, i]
        drawn = np.hypot(*arrows.T) > _LEAST_FORCE
        if drawn.any():
            _draw_arrows(ax, people[drawn], arrows[drawn] * scale, name)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.autoscale_view()
    legend_outside(ax, title=f"scale: 1 m/s² = {scale:g} m")
    return ax


def _rows(values: ArrayLike, width: int, name: str) -> Any:
    array = np.asarray(values, dtype=float)
    if array.size % width:
        raise ValueError(
            f"{name} must hold rows of {width} numbers, got shape {array.shape}"
        )
    return array.reshape(-1, width)


def _draw_discs(ax: Axes, rows: Any, *, color: str, name: str) -> None:
    from matplotlib.collections import LineCollection, PatchCollection
    from matplotlib.patches import Circle

    if len(rows) == 0:
        return
    discs = [Circle((row[X], row[Y]), row[RADIUS]) for row in rows]
    ax.add_collection(
        PatchCollection(
            discs, facecolor=color, edgecolor="0.2", alpha=0.5, zorder=1
        )
    )
    looks = np.stack([np.cos(rows[:, YAW]), np.sin(rows[:, YAW])], axis=-1)
    centers = rows[:, : Y + 1]
    radii = rows[:, RADIUS, None]
    noses = np.stack(
        [centers + 0.8 * radii * looks, centers + 1.25 * radii * looks], axis=1
    )
    ax.add_collection(
        LineCollection(noses, colors="0.2", linewidths=2.5, zorder=1.5)
    )
    # An empty line, for a disc in the legend.
    ax.plot([], [], "o", ms=6, mfc=color, mec="0.2", alpha=0.5, label=name)


def _draw_arrows(ax: Axes, rows: Any, arrows: Any, name: str) -> None:
    is_total = name == "total"
    ax.quiver(
        rows[:, X],
        rows[:, Y],
        arrows[:, 0],
        arrows[:, 1],
        angles="xy",
        scale_units="xy",
        scale=1.0,
        # In points, for any resolution of the figure.
        units="inches",
        width=(1.0 if is_total else 2.2) / 72,
        headwidth=5.0 if is_total else 3.0,
        color=_COLORS[name],
        # Light colors need an edge.
        edgecolor="0.35",
        linewidth=0.0 if is_total else 0.3,
        zorder=3 if is_total else 2,
        label=name.replace("_", " "),
    )
    # The limits of the axes do not include arrows by default.
    ax.update_datalim(rows[:, : Y + 1] + arrows)
