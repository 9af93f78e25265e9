"""Timeline of the social situations of a robot."""

import numpy as np

from hunav_drake.report.plots.runs import Run, recordings
from hunav_drake.report.plots.style import (
    Axes,
    label_rows,
    legend_outside,
    new_axes,
    shown_apart,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situations import FindSituations

# The colors of labels: paths, groups, people who are about the robot, rest.
COLORS = {
    "cross_path": "#d55e00",
    "down_path": "#0072b2",
    "in_o_space": "#882255",
    "join_group": "#009e73",
    "leave_group": "#999933",
    "blocked": "#cc79a7",
    "at_door": "#e69f00",
    "at_queue": "#f0e442",
    "accompanied": "#56b4e9",
    "standing": "#8c8c8c",
    "other": "#bdbdbd",
    "empty": "#ececec",
}


def marks_of(
    run: Recording, robot: str = ""
) -> list[tuple[str, float, float, str]]:
    """Returns the times in which a robot's primary label stays the same.

    Each has the label, begin and end in seconds, and its color.
    """
    found = FindSituations(run, robot=robot)
    new = found.primary[1:] != found.primary[:-1]
    first = np.concatenate([[0], np.flatnonzero(new) + 1])
    edges = found.edges[[*first, -1]].tolist()
    return [
        (label.replace("_", " "), begin, end, COLORS[label])
        for label, begin, end in zip(
            found.primary[first].tolist(), edges, edges[1:], strict=False
        )
    ]


def plot_situations(data: Run, *, ax: Axes | None = None) -> Axes:
    """Draws a timeline of the primary situations of the robot.

    Each of several robots has a row. The legend has the shares of the time,
    of all robots together.

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
    robots = [it.robot_name for it in run.robots]
    ax = new_axes(ax, situations_height(len(robots)))
    marks = [
        (i, *it) for i, of in enumerate(robots) for it in marks_of(run, of)
    ]
    times = dict.fromkeys(COLORS.values(), 0.0)
    names = {}
    for i, label, begin, end, color in marks:
        ax.broken_barh(
            [(begin, end - begin)], (i - 0.375, 0.75), color=color, lw=0
        )
        times[color] += end - begin
        names[color] = label
    total = sum(times.values()) or 1.0
    for color, label in names.items():
        text = f"{label} {100 * times[color] / total:.0f} %"
        ax.plot([], [], lw=5, solid_capstyle="butt", color=color, label=text)
    ax.set(xlabel="time (s)")
    label_rows(ax, shown_apart(robots))
    if len(run) > 1:
        ax.set_xlim(run.times[0], run.times[-1])
    legend_outside(ax, columns=3)
    return ax


def situations_height(num_robots: int) -> float:
    """Returns the height of the figure for a number of robots, in inches."""
    return 1.05 + 0.2 * max(1, num_robots)
