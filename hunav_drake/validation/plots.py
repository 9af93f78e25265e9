"""Plots of measured quantities of motion models."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hunav_drake.report.plots.style import (
    LABEL_SIZE,
    MUTED,
    PALETTE,
    legend_outside,
    line_styles,
    new_axes,
)
from hunav_drake.systems.scene.plan_walls import WALL
from hunav_drake.validation.diagrams import TOLERANCE
from hunav_drake.validation.doors import FLOW_BAND
from hunav_drake.validation.measures import weidmann

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The quantities of a case by the name of the model.
Measured = Mapping[str, Mapping[str, Any]]

_MARKERS = "osD^vP*X"


def plot_speeds(measured: Measured, *, ax: "Axes | None" = None) -> "Axes":
    """Draws the speeds of the case `fundamental_diagram` and Weidmann's."""
    ax = new_axes(ax, 2.6)
    density = np.linspace(0.3, 3.4, 200)
    speed = weidmann(density)
    ax.fill_between(
        density,
        speed - TOLERANCE,
        speed + TOLERANCE,
        color=WALL,
        alpha=0.5,
        lw=0,
        label=f"Weidmann ± {TOLERANCE:g} m/s",
    )
    ax.plot(density, speed, color=MUTED, lw=1, label="Weidmann")
    _lines(ax, measured, "density", "speed")
    ax.set(
        xlabel="density (persons/m²)",
        ylabel="mean speed (m/s)",
        ylim=(0, 1.5),
        xlim=(0.3, 3.4),
    )
    legend_outside(ax, 2)
    return ax


def plot_door_flow(measured: Measured, *, ax: "Axes | None" = None) -> "Axes":
    """Draws the specific flows of the case `door_flow` by width."""
    ax = new_axes(ax, 2.6)
    low, high = FLOW_BAND
    ax.axhspan(
        *(low, high),
        color=WALL,
        alpha=0.5,
        lw=0,
        label=f"people, {low:g} to {high:g}",
    )
    _lines(ax, measured, "width", "flow")
    ax.set(xlabel="width of the door (m)", ylabel="flow (persons/(m s))")
    ax.set_ylim(bottom=0)
    legend_outside(ax, 2)
    return ax


def plot_counterflow(measured: Measured, *, ax: "Axes | None" = None) -> "Axes":
    """Draws the times of the case `counterflow` by the oncoming people.

    A cross near the upper edge shows that not all people cross.
    """
    ax = new_axes(ax, 2.6)
    _lines(ax, measured, "against", "time")
    ax.set(
        xlabel="people who come against them", ylabel="the last has crossed (s)"
    )
    ax.set_ylim(bottom=0)
    legend_outside(ax, 2)
    return ax


def _lines(ax: "Axes", measured: Measured, x: str, y: str) -> None:
    """Draws a line for each model, and crosses for infinite values."""
    styles = line_styles(len(measured))
    for k, (model, numbers) in enumerate(measured.items()):
        values = np.asarray(numbers[y], dtype=float)
        known = np.isfinite(values)
        at = np.asarray(numbers[x], dtype=float)
        marker = _MARKERS[k % len(_MARKERS)]
        ax.plot(
            at[known],
            values[known],
            marker=marker,
            ms=3.5,
            lw=1.2,
            label=model,
            **styles[k],
        )
        ax.plot(
            at[~known],
            # Lower for each model, so that none hides another.
            np.full((~known).sum(), 1 - 0.05 * k),
            "x",
            color=styles[k]["color"],
            transform=ax.get_xaxis_transform(),
            clip_on=False,
        )


def lanes_height(count: int) -> float:
    """Returns the height of `plot_lanes` for some models, in inches."""
    return 0.5 + 0.75 * count


def plot_lanes(measured: Measured, *, ax: "Axes | None" = None) -> "Axes":
    """Draws the people of the case `lanes`, a corridor for each model."""
    ax = new_axes(ax, lanes_height(len(measured)))
    for k, (model, numbers) in enumerate(measured.items()):
        _corridor(ax, model, numbers, -5.0 * k)
    ax.set(
        xlim=(-0.5, 38.5),
        ylim=(-5.0 * len(measured) + 1, 5.6),
        xlabel="m",
        yticks=[],
        aspect="equal",
    )
    ax.spines["left"].set_visible(False)
    return ax


def _corridor(
    ax: "Axes", model: str, numbers: Mapping[str, Any], bottom: float
) -> None:
    x, y = np.asarray(numbers["x"]), np.asarray(numbers["y"])
    half = len(x) // 2
    for height in (bottom, bottom + 3.0):
        ax.plot([0, 38], [height, height], color=WALL, lw=1.5)
    for own, color, marker in (
        (slice(0, half), PALETTE[0], ">"),
        (slice(half, None), PALETTE[1], "<"),
    ):
        within = (x[own] > 0) & (x[own] < 38)
        ax.plot(
            *(x[own][within], bottom + y[own][within]),
            ls="none",
            marker=marker,
            ms=3.5,
            mew=0,
            color=color,
        )
    ax.text(
        0,
        bottom + 3.3,
        f"{model}: order {numbers['order']:.2f}",
        fontsize=LABEL_SIZE,
        va="bottom",
        parse_math=False,
    )


class ValidationPlot(NamedTuple):
    """A plot of one case.

    Attributes:
        case: The name of the case.
        draw: Draws the quantities by model on given axes.
        caption: The caption.
        height: The height of the figure for a number of models, in inches.
        layout: The layout of Matplotlib.
    """

    case: str
    draw: Callable[..., "Axes"]
    caption: str
    height: Callable[[int], float] = lambda count: 2.6 + 0.15 * (count // 2)
    layout: str = "constrained"


PLOTS = (
    ValidationPlot(
        "fundamental_diagram",
        plot_speeds,
        "Mean speed of people with desired speeds of N(1.34, 0.26) m/s by"
        " density, and that of Weidmann 1993.",
    ),
    ValidationPlot(
        "door_flow",
        plot_door_flow,
        "Specific flow of doors by width, and the range measured with people.",
    ),
    ValidationPlot(
        "counterflow",
        plot_counterflow,
        "Time at which the last person has crossed a corridor, by the number of"
        " oncoming people. A cross: not all cross.",
    ),
    ValidationPlot(
        "lanes",
        plot_lanes,
        "Two crowds that pass each other, at half time, and the order of their"
        " lanes over the whole time.",
        lanes_height,
        "compressed",
    ),
)
