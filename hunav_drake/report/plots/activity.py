"""Timeline of people's reactions to the robot."""

import numpy as np

from hunav_drake.report.plots.approaches import spans
from hunav_drake.report.plots.runs import Run, recordings
from hunav_drake.report.plots.style import (
    Axes,
    behavior_styles,
    label_rows,
    legend_outside,
    new_axes,
    note,
    shown,
    shown_apart,
)
from hunav_drake.systems.scene.overlays.reactions import who_reacts


def plot_behavior_activity(data: Run, *, ax: Axes | None = None) -> Axes:
    """Draws a timeline of people's reactions to the robot.

    Each person has a row: gray while the person is present, and in the color
    of the behavior while the person reacts.

    Args:
        data: One run.
        ax: Where to draw; by default a new figure.

    Raises:
        TypeError: If the data are not exactly one run.
    """
    runs = recordings(data)
    if len(runs) != 1:
        raise TypeError(f"needs one run, got {len(runs)}")
    (run,) = runs.values()
    n = run.num_humans
    ax = new_axes(ax, activity_height(n))
    styles = behavior_styles(run.behaviors)
    colors = {name: style["color"] for name, style in styles.items()}
    active = who_reacts(np.asarray(run.behavior_status), run.social_signals)
    for i in range(n):
        present = run.features.present[:, i]
        for flags, color, height in (
            (present, "#e0e0e0", 0.3),
            (present & active[:, i], colors[run.behaviors[i]], 0.75),
        ):
            ax.broken_barh(
                [(start, end - start) for start, end in spans(run, flags)],
                (i - height / 2, height),
                color=color,
                lw=0,
            )
    for behavior, color in colors.items():
        ax.plot(
            [],
            [],
            lw=5,
            solid_capstyle="butt",
            color=color,
            label=shown(behavior),
        )
    if not n:
        note(ax, "there are no people")
    ax.set(xlabel="time (s)")
    label_rows(ax, shown_apart(run.human_names))
    if len(run) > 1:
        ax.set_xlim(run.times[0], run.times[-1])
    legend_outside(ax, columns=4)
    return ax


def activity_height(num_humans: int) -> float:
    """Returns the height of the figure for a number of people, in inches."""
    return 0.85 + 0.2 * max(2, num_humans)
