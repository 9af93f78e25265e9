"""Branches of a trial: ways on the map, and delays over time."""

from typing import Any

import numpy as np

from hunav_drake.report.plots.style import (
    COLUMN,
    Axes,
    legend_outside,
    line_styles,
    new_axes,
    shown_apart,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.scene.plan_walls import draw_walls
from hunav_drake.trial.branches.run import SAME, Branches


def plot_branches(branches: Branches, *, ax: Axes | None = None) -> Axes:
    """Draws the ways of robots and people in each branch on the map.

    Args:
        branches: The branches; each has a color.
        ax: Where to draw; by default a new figure.
    """
    ax = new_axes(ax, 3.4, layout="compressed")
    recording = branches[SAME].recording
    draw_walls(ax, recording.obstacles)
    styles = line_styles(len(branches.futures))
    labels = shown_apart(branches.futures)
    for k, future in enumerate(branches.futures.values()):
        # The first ones are drawn last, on top.
        style: dict[str, Any] = {**styles[k], "zorder": 2 + 0.5 / (1 + k)}
        for robot in future.robots.values():
            ax.plot(*robot[:, [X, Y]].T, lw=1.8, **style)
        for i in range(len(branches.human_names)):
            ax.plot(*future.humans[:, i, [X, Y]].T, lw=0.8, **style)
        ax.plot([], [], lw=1.8, label=labels[k], **style)
    same = branches.futures[SAME]
    first = [*(it[0] for it in same.robots.values()), *same.humans[0]]
    places = np.array(first)[:, [X, Y]].T
    ax.plot(*places, "o", ms=3, color="0.3", zorder=4)
    for it in recording.robots:
        if it.goal is not None:
            ax.plot(*it.goal[:2], "*", ms=9, mfc="white", mec="black", mew=0.8)
    low, high = _frame(branches)
    ax.set(
        xlabel="x (m)",
        ylabel="y (m)",
        aspect="equal",
        xlim=(low[0], high[0]),
        ylim=(low[1], high[1]),
    )
    legend_outside(ax, columns=3)
    return ax


def branches_height(branches: Branches) -> float:
    """Returns the height of a figure for `plot_branches`, in inches."""
    low, high = _frame(branches)
    width, height = high - low
    return float(min(0.85 * COLUMN * height / width, 1.3 * COLUMN)) + 0.8


def _frame(branches: Branches) -> tuple[Array, Array]:
    """Returns the corners of the map, with a margin, in meters."""
    points = [
        rows[..., [X, Y]].reshape(-1, 2)
        for future in branches.futures.values()
        for rows in (future.humans, *future.robots.values())
    ]
    robots = branches[SAME].recording.robots
    goals = [it.goal[:2] for it in robots if it.goal is not None]
    every = np.concatenate([*points, np.reshape(goals, (-1, 2))])
    low, high = np.nanmin(every, axis=0), np.nanmax(every, axis=0)
    margin = 0.6 + 0.03 * float((high - low).max())
    return low - margin, high + margin


def plot_delays(branches: Branches, *, ax: Axes | None = None) -> Axes:
    """Draws how late people are in each branch, summed, over time.

    Args:
        branches: The branches; each has a color, but for the reference.
        ax: Where to draw; by default a new figure.
    """
    ax = new_axes(ax, 2.2)
    styles = line_styles(len(branches.futures))
    labels = shown_apart(branches.futures)
    for name, label, style in zip(
        branches.futures, labels, styles, strict=True
    ):
        if name != branches.reference:
            late = branches.delays(name).sum(axis=1, min_count=1)
            ax.plot(late, lw=1.2, label=label, **style)
    ax.set(xlabel="time (s)", ylabel="delay (s)")
    legend_outside(ax, columns=3)
    return ax
