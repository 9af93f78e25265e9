"""Plots over time: distance to people, and robot speed."""

import numpy as np

from hunav_drake.report.plots.approaches import NEAR, find_approaches, spans
from hunav_drake.report.plots.runs import Runs, recordings, robots_apart
from hunav_drake.report.plots.style import (
    SMALL_SIZE,
    Axes,
    legend_outside,
    line_styles,
    new_axes,
    note,
    robot_styles,
    shown_apart,
)
from hunav_drake.report.plots.zones import ZONES
from hunav_drake.systems.evaluation.recording import Recording

_HEIGHT = 2.3

# The least distance between two written numbers, as a share of the time.
_CROWDED = 0.14

# The margin below the closest approach, as a share of the axes: for a mark, and
# for a mark with a number below it.
_MARK_ROOM = 0.04
_LABEL_ROOM = 0.17


def plot_distance_to_people(
    data: Runs, *, near: float = NEAR, ax: Axes | None = None
) -> Axes:
    """Draws the distance to the closest person over time.

    The distance is the gap between the surfaces of the robot and the person,
    as in Fig. 5 of Perez-Higueras et al., "HuNavSim", 2023. The bands are the
    proxemic zones of Hall 1969. A triangle marks the closest point of each
    approach (see `find_approaches`), with the distance for a single run.

    Args:
        data: One run, or several, with one line for each, and for each of
            several robots.
        near: The largest gap of an approach, in meters.
        ax: Where to draw; by default a new figure.

    Raises:
        TypeError: If the data are not runs.
        ValueError: If `near` is not positive.
    """
    runs = robots_apart(recordings(data))
    ax = new_axes(ax, _HEIGHT)
    for zone in ZONES:
        if np.isfinite(zone.high):
            ax.axhspan(
                zone.low,
                zone.high,
                color=zone.color,
                alpha=0.3,
                lw=0,
                label=zone.name,
            )
    ax.plot([], [], "v", ms=4.5, color="0.3", label="closest")
    top, lowest = 0.0, np.inf
    for (name, run), label, style in zip(
        runs.items(), shown_apart(runs), _styles(runs), strict=True
    ):
        gap = run.features.closest_gap
        ax.plot(run.times, gap, lw=1.2, label=label or None, **style)
        if np.isfinite(gap).any():
            top = max(top, float(np.nanmax(gap)))
            gaps = _mark_minima(ax, run, near, style["color"], written=not name)
            lowest = min([lowest, *gaps])
    if top == 0.0 and not any(r.features.present.any() for r in runs.values()):
        note(ax, "there are no people")
    _set_time_axis(ax, runs)
    top = max(1.5, 1.05 * top)
    # Marks and numbers must not overlap the axis.
    bottom = min(
        0.0, lowest - (_LABEL_ROOM if "" in runs else _MARK_ROOM) * top
    )
    ax.set(ylabel="distance to closest person (m)", ylim=(bottom, top))
    if bottom < 0:
        ax.axhline(0.0, color="0.6", lw=0.5, zorder=1)
        ax.set_yticks([t for t in ax.get_yticks() if 0 <= t <= top])
    legend_outside(ax, columns=4)
    return ax


def _mark_minima(
    ax: Axes, run: Recording, near: float, color: str, *, written: bool
) -> list[float]:
    """Marks the closest point of each approach, and returns the gaps."""
    from matplotlib.patheffects import withStroke

    closest = run.features.closest_gap
    # If two people are near at once, only the closer one is on the line.
    points = sorted(
        (e.time, e.gap)
        for e in find_approaches(run, near=near)
        if e.gap <= closest[np.searchsorted(run.times, e.time)]
    )
    gaps = [gap for _, gap in points]
    if not points:
        return gaps
    ax.plot(
        *zip(*points, strict=True),
        ls="",
        marker="v",
        ms=4.5,
        color=color,
        clip_on=False,
        zorder=4,
        gid="minima",
    )
    if not written:
        return gaps
    last = -np.inf
    span = run.times[-1] - run.times[0]
    for time, gap in points:
        # At the edges, it would be on other numbers.
        middle = np.clip(
            time,
            run.times[0] + 0.5 * _CROWDED * span,
            run.times[-1] - 0.5 * _CROWDED * span,
        )
        if middle - last >= _CROWDED * span:
            ax.annotate(
                f"{gap:.2f} m",
                (middle, gap),
                # The line has a minimum here, so there is room below.
                xytext=(0, -4),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize=SMALL_SIZE,
                zorder=5,
                path_effects=[withStroke(linewidth=2.5, foreground="white")],
            )
            last = middle
    return gaps


def plot_robot_speed(
    data: Runs, *, near: float = NEAR, ax: Axes | None = None
) -> Axes:
    """Draws the forward speed of the robot over time.

    Times with a person near are shaded, as in Fig. 6 of Perez-Higueras et al.,
    "HuNavSim", 2023. With several runs, strips below the lines mark these
    times, in the color of each run.

    Args:
        data: One run, or several, with one line for each, and for each of
            several robots.
        near: The gap below which a person is near, surface to surface, in
            meters.
        ax: Where to draw; by default a new figure.

    Raises:
        TypeError: If the data are not runs.
        ValueError: If `near` is not positive.
    """
    if not near > 0:
        raise ValueError(f"near must be positive, got {near}")
    runs = robots_apart(recordings(data))
    ax = new_axes(ax, _HEIGHT)
    speeds = [run.features.forward_speed for run in runs.values()]
    low = min([0.0, *(float(s.min()) for s in speeds)])
    high = max([0.1, *(float(s.max()) for s in speeds)])
    styles = _styles(runs)
    labels = shown_apart(runs)
    label: str | None = f"person within {near:g} m"
    for i, (name, run) in enumerate(runs.items()):
        label_of_run = labels[i] or None
        ax.plot(run.times, speeds[i], lw=1.2, label=label_of_run, **styles[i])
        when = spans(run, run.features.closest_gap < near)
        if name:
            # Strips of the same height in a row under the lowest speed.
            strip = 0.05 * (high - low)
            bottom = low - (1.5 * i + 2) * strip
            ax.broken_barh(
                [(a, b - a) for a, b in when],
                (bottom, strip),
                color=styles[i]["color"],
                lw=0,
                gid="near",
            )
        else:
            for start, end in when:
                ax.axvspan(
                    start, end, color="0.8", lw=0, label=label, gid="near"
                )
                label = None
    _set_time_axis(ax, runs)
    ax.set(ylabel="robot speed (m/s)")
    room = 0.05 * (high - low)
    strips = (1.5 * len(runs) + 1.5) * room if "" not in runs else 0.0
    ax.set_ylim(low - strips - (room if low < 0 else 0.0), high + room)
    if strips:
        ax.axhline(low - room / 2, color="0.8", lw=0.5)
        # The strips are not speeds: an extra tick labels them.
        ticks = [t for t in ax.get_yticks() if low <= t <= high + room]
        ax.set_yticks(
            [low - (strips + room) / 2, *ticks],
            [f"< {near:g} m", *(f"{round(t, 9):g}" for t in ticks)],
        )
    legend_outside(ax)
    return ax


def _styles(runs: dict[str, Recording]) -> list[dict[str, str]]:
    """Returns the style of each run, or of each robot of a single one."""
    if all(name == run.robot_name for name, run in runs.items()):
        return robot_styles(len(runs))
    return line_styles(len(runs))


def _set_time_axis(ax: Axes, runs: dict[str, Recording]) -> None:
    ax.set_xlabel("time (s)")
    if runs:
        start = min(run.times[0] for run in runs.values())
        end = max(run.times[-1] for run in runs.values())
        if end > start:
            ax.set_xlim(start, end)
