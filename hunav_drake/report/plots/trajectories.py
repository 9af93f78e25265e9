"""Trajectories of the robot and the people on the map."""

from collections.abc import Sequence
import math
from typing import Any, NamedTuple

import numpy as np
import shapely

from hunav_drake.report.plots.runs import Runs, recordings
from hunav_drake.report.plots.style import (
    COLUMN,
    PEOPLE,
    ROBOT,
    SMALL_SIZE,
    Axes,
    behavior_styles,
    legend_outside,
    line_styles,
    new_axes,
    robot_styles,
    shown,
    shown_apart,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, REACTIVE, X, Y
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.scene.plan_walls import draw_walls

# Round numbers for the time between marks, in seconds, and the approximate
# number of marks.
_INTERVALS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0)
_MARKS = 6

# With more people than this, colors show behaviors, not people.
_MANY = 6

# The maximum size of the map, in inches.
_MAP = np.array([0.85 * COLUMN, COLUMN])

# The distances of a label's middle from its point, in points, and their
# directions.
_REACH = np.array([7.0, 10.0])
_ANGLES = np.arange(8) * np.pi / 4 + np.pi / 2

# The size of a label, and of each of its characters but the first two, in
# points, and its least distances from other labels and from lines.
_LABEL, _CHARACTER = 6.0, 3.6
_LABEL_ROOM = 3.0
_LINE_ROOM = 0.5


class _Label(NamedTuple):
    """A text beside a point.

    Attributes:
        text: The text.
        place: The point (x, y), in the units of the axes.
        color: The color of the text.
    """

    text: str
    place: tuple[float, float]
    color: str


def plot_trajectories(
    data: Runs, *, mark_every: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draws the trajectories of the robots and the people on the map.

    Discs show the start positions in true size, and the star is the goal. Dots
    mark equal time steps, with the time in seconds. With several runs each
    robot has a color, and the people of the first run are thin gray lines. In
    a single run each person has a color, and each of several robots; with more
    than six people each behavior has one, and names are at the start positions
    if there is room. Thick lines are recorded people whom the motion model
    moves.

    Args:
        data: One run, or several.
        mark_every: The time between dots, in seconds; by default chosen for
            about six dots.
        ax: Where to draw; by default a new figure.

    Raises:
        TypeError: If the data are not runs.
        ValueError: If `mark_every` is not positive.
    """
    if mark_every is not None and not mark_every > 0:
        raise ValueError(f"mark_every must be positive, got {mark_every}")
    runs = recordings(data)
    low, high, scale, tall = _frame(list(runs.values()))
    ax = new_axes(ax, trajectories_height(data), layout="compressed")
    longest = max((r.times[-1] - r.times[0] for r in runs.values()), default=0)
    every = mark_every or _interval(float(longest))
    labels: list[_Label] = []
    names = shown_apart(runs)
    for i, ((name, run), style) in enumerate(
        zip(runs.items(), line_styles(len(runs)), strict=True)
    ):
        draw_walls(ax, run.obstacles)
        if name:
            for k, it in enumerate(run.robots):
                label = None if k else names[i]
                _draw_path(ax, it.robot, label=label, lw=1.4, **style)
                part = it.until_end()
                labels += _mark_times(
                    ax, part.times, part.robot, every, color=style["color"]
                )
            for person in range(0 if i else run.num_humans):
                states = run.humans[:, person]
                _draw_path(ax, states, color=PEOPLE, lw=0.7, zorder=1)
        else:
            labels += _draw_run(ax, run, every)
        several = robot_styles(len(run.robots)) if run.others else []
        for k, it in enumerate(run.robots):
            if it.goal is not None:
                face = "white" if name or not several else several[k]["color"]
                star = {"ms": 9, "mfc": face, "mec": "black", "mew": 0.8}
                ax.plot(*it.goal[:2], "*", **star)
    ax.plot([], [], "o", ms=3, color="0.4", label=f"every {every:g} s")
    ax.set(
        xlabel="x (m)",
        ylabel="y (m)",
        aspect="equal",
        xlim=(low[0], high[0]),
        ylim=(low[1], high[1]),
    )
    _place_labels(ax, labels, scale=72.0 * scale)
    # The map is in the middle of the figure, with numbers on its left.
    room = 36.0 * (COLUMN + scale * float(high[0] - low[0])) - 18.0
    legend_outside(ax, columns=4, beside=tall, room=room)
    return ax


def trajectories_height(data: Runs) -> float:
    """Returns the height of a figure for `plot_trajectories`, in inches."""
    low, high, scale, tall = _frame(list(recordings(data).values()))
    return scale * float(high[1] - low[1]) + (0.5 if tall else 0.8)


def _draw_run(ax: Axes, run: Recording, every: float) -> list[_Label]:
    """Draws a single run, with a color for each person or behavior."""
    labels: list[_Label] = []
    styles = robot_styles(len(run.robots))
    robots = shown_apart(it.robot_name or "robot" for it in run.robots)
    for it, name, style in zip(run.robots, robots, styles, strict=True):
        _draw_start(ax, it.robot, style["color"])
        _draw_path(ax, it.robot, lw=1.8, label=name, zorder=3, **style)
        # (It stands where it ended.)
        part = it.until_end()
        labels += _mark_times(
            ax, part.times, part.robot, every, color=style["color"]
        )
    many = run.num_humans > _MANY
    keys = run.behaviors if many else run.human_names
    names = list(dict.fromkeys(keys)) if many else list(keys)
    styles = (
        list(behavior_styles(names).values())
        if many
        else line_styles(len(names))
    )
    labels_of = shown_apart(names)
    named: set[int] = set()
    for i in range(run.num_humans):
        k = names.index(keys[i]) if many else i
        style = styles[k]
        label = None if k in named else labels_of[k]
        named.add(k)
        states = run.humans[:, i]
        _draw_path(ax, states, lw=1.0, label=label, **style)
        _draw_start(ax, states, style["color"])
        marks = _mark_times(
            ax, run.times, states, every, color=style["color"], small=True
        )
        labels += _name(run, i, style["color"]) if many else marks
    _draw_handed_over(ax, run)
    return labels


def _draw_handed_over(ax: Axes, run: Recording) -> None:
    """Draws where the motion model moves recorded people."""
    if run.replay is None:
        return
    reacts = run.replay[..., 0] == REACTIVE
    own: dict[str, Any] = {"color": ROBOT, "lw": 3.5, "alpha": 0.35}
    for k, i in enumerate(np.flatnonzero(reacts.any(axis=0))):
        states = np.where(reacts[:, [i]], run.humans[:, i], np.nan)
        label = None if k else "handed over"
        _draw_path(ax, states, label=label, zorder=1.5, **own)


def _name(run: Recording, person: int, color: str) -> list[_Label]:
    """Returns the name of a person as a label at the start position."""
    there = np.flatnonzero(run.features.present[:, person])
    if not there.size:
        return []
    x, y = run.humans[there[0], person, [X, Y]]
    name = shown(run.human_names[person])
    return [_Label(name, (float(x), float(y)), color)]


def _draw_path(ax: Axes, states: Array, **options: Any) -> None:
    ax.plot(states[:, X], states[:, Y], solid_capstyle="round", **options)


def _draw_start(ax: Axes, states: Array, color: str) -> None:
    from matplotlib.patches import Circle

    there = np.flatnonzero(~np.isnan(states[:, X]))
    if there.size:
        x, y, radius = states[there[0], [X, Y, RADIUS]]
        ax.add_patch(Circle((x, y), radius, color=color, alpha=0.25, lw=0))


def _mark_times(
    ax: Axes,
    times: Array,
    states: Array,
    every: float,
    *,
    color: str,
    small: bool = False,
) -> list[_Label]:
    """Draws the time marks of one trajectory, and returns their labels."""
    first = math.ceil(times[0] / every - 1e-9)
    last = math.floor(times[-1] / every + 1e-9)
    when = np.arange(first, last + 1) * every
    # The nearest sample; absent people have no mark.
    after = np.clip(np.searchsorted(times, when), 1, max(len(times) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(times) - 1)
    nearer = times[after] - when < when - times[before]
    index = np.where(nearer, after, before)
    places = states[index][:, [X, Y]]
    there = ~np.isnan(places[:, 0])
    ax.plot(
        *places[there].T,
        ls="",
        marker="o",
        ms=2.5 if small else 3.5,
        color=color,
        zorder=4,
        gid="marks",
    )
    return [
        _Label(f"{time:.12g}", (float(x), float(y)), color)
        for time, (x, y) in zip(when[there], places[there], strict=True)
    ]


def _interval(duration: float) -> float:
    """Returns the time between marks for a trial of some seconds."""
    return min(
        _INTERVALS,
        key=lambda t: abs(math.log(max(duration, 1e-9) / t / _MARKS)),
    )


def _frame(runs: list[Recording]) -> tuple[Array, Array, float, bool]:
    """Returns the limits and the scale of the map.

    They are the lower left and the upper right corner, in meters; the scale, in
    inches per meter; and whether it is tall, with the legend beside it.
    """
    low, high = _bounds(runs)
    size = high - low
    return low, high, float((_MAP / size).min()), size[1] > 1.2 * size[0]


def _bounds(runs: list[Recording]) -> tuple[Array, Array]:
    """Returns the corners of the map with a margin, in meters."""
    points = [np.zeros((0, 2))]
    for run in runs:
        rows = [it.robot for it in run.robots]
        for states in (*rows, run.humans.reshape(-1, run.humans.shape[-1])):
            center, radius = states[:, : Y + 1], states[:, RADIUS, None]
            points += [center - radius, center + radius]
        points.append(run.obstacles.segments.reshape(-1, 2))
        goals = [it.goal[:2] for it in run.robots if it.goal is not None]
        points.append(np.array(goals).reshape(-1, 2))
    everything = np.concatenate(points)
    everything = everything[~np.isnan(everything[:, 0])]
    if not len(everything):
        everything = np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = max(0.2, 0.03 * float((high - low).max()))
    return low - margin, high + margin


def _place_labels(ax: Axes, labels: Sequence[_Label], *, scale: float) -> None:
    """Writes labels near their points, away from lines and other labels.

    They are placed in order; labels without room are omitted. One unit of the
    axes is `scale` points long in the figure.
    """
    drawn = shapely.geometrycollections(
        [
            _shape(np.column_stack(it.get_data()) * scale)
            for it in ax.get_lines()
        ]
    )
    directions = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
    offsets = (_REACH[:, None, None] * directions).reshape(-1, 2)
    placed: list[shapely.Geometry] = []
    for label in labels:
        # Longer labels begin or end beside their points.
        longer = 0.5 * _CHARACTER * max(0, len(label.text) - 2)
        aside = offsets + longer * np.sign(offsets.round(3)) * [1, 0]
        middles = np.asarray(label.place) * scale + aside
        half = [0.5 * _LABEL + longer, 0.5 * _LABEL]
        boxes = shapely.box(*(middles - half).T, *(middles + half).T)
        to_line = shapely.distance(boxes, drawn)
        gaps = [shapely.distance(boxes, it) for it in placed]
        to_label = np.min([np.full(len(boxes), np.inf), *gaps], axis=0)
        fits = (to_line > _LINE_ROOM) & (to_label > _LABEL_ROOM)
        if not fits.any():
            continue
        room = np.minimum(to_line, to_label).clip(max=5.0).round(1)
        best = int(np.argmax(np.where(fits, room, -1.0)))
        placed.append(boxes[best])
        ax.annotate(
            label.text,
            label.place,
            xytext=aside[best],
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=SMALL_SIZE - 1,
            color=label.color,
            annotation_clip=True,
            parse_math=False,
            zorder=5,
        )


def _shape(points: np.ndarray) -> shapely.Geometry:
    points = points[~np.isnan(points[:, 0])]
    return shapely.LineString(points if len(points) != 1 else [*points] * 2)
