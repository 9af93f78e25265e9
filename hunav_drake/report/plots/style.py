"""Colors, sizes, figures, legends and labels of all plots."""

from collections.abc import Iterable, Sequence
from itertools import cycle, islice
import math
from typing import TYPE_CHECKING

from hunav_drake.systems.behavior.profiles import BEHAVIORS
from hunav_drake.systems.scene.palette import accent

if TYPE_CHECKING:
    import matplotlib.axes


# Matplotlib takes long to load, so it is loaded for drawing only.
type Axes = matplotlib.axes.Axes

# The width of a column of a paper, in inches.
COLUMN = 3.4

# The sizes of text, in points.
LABEL_SIZE = 8.0
SMALL_SIZE = 7.0

# The colors of Okabe & Ito 2008, which color-blind people can distinguish, and
# two of Tol 2021. Yellow lines are hard to see on white, and black is the
# robot.
YELLOW = "#f0e442"
PALETTE = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
    "#882255",
    "#999933",
)
ROBOT = "#000000"
PEOPLE = "#8c8c8c"
MUTED = "#555555"

# The maximum length of a label.
_LONGEST = 18

# After the last color, lines have the first color with other dashes.
DASHES = ("-", "--", ":", "-.")


def line_styles(count: int) -> list[dict[str, str]]:
    """Returns the color and dashes of each of some lines."""
    styles = ({"color": c, "ls": d} for d in cycle(DASHES) for c in PALETTE)
    return list(islice(styles, count))


def robot_styles(count: int) -> list[dict[str, str]]:
    """Returns the color and dashes of each of several robots.

    A single one is black; several have their colors in films.
    """
    if count == 1:
        return [{"color": ROBOT, "ls": "-"}]
    colors = [accent(k) for k in range(count)]
    rows = [(c.r(), c.g(), c.b()) for c in colors]
    codes = ["#" + bytes(round(255 * x) for x in row).hex() for row in rows]
    return [{"color": code, "ls": "-"} for code in codes]


def behavior_styles(behaviors: Iterable[str]) -> dict[str, dict[str, str]]:
    """Returns the color and dashes of each behavior, by its name.

    A behavior of this package has the same color in every plot. Behaviors of
    users get the remaining colors.
    """
    names = list(dict.fromkeys(behaviors))
    fixed = dict(zip(BEHAVIORS, line_styles(len(BEHAVIORS)), strict=True))
    taken = [fixed[name] for name in names if name in fixed]
    left = (
        style
        for style in line_styles(len(names) + len(taken))
        if style not in taken
    )
    return {name: fixed.get(name) or next(left) for name in names}


def new_axes(
    ax: Axes | None,
    height: float,
    width: float = COLUMN,
    layout: str = "constrained",
) -> Axes:
    """Returns the axes to draw on: the caller's, or those of a new figure.

    Sizes are in inches; the layout is "compressed" if the axes have a fixed
    aspect.
    """
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    _, ax = plt.subplots(figsize=(width, height), layout=layout)
    set_text_sizes(ax)
    return ax


def set_text_sizes(ax: Axes) -> None:
    """Sets text sizes for a column, and hides unnecessary lines."""
    ax.tick_params(labelsize=SMALL_SIZE)
    for axis in (ax.xaxis, ax.yaxis):
        axis.label.set_size(LABEL_SIZE)
    ax.spines[["top", "right"]].set_visible(False)


def legend_outside(
    ax: Axes,
    columns: int = 3,
    *,
    beside: bool = False,
    title: str | None = None,
    room: float = math.inf,
) -> None:
    """Draws the legend above the axes, or `beside` them.

    Above, it has up to `columns` columns, if there is room: at most as many
    points as given.
    """
    handles, labels = ax.get_legend_handles_labels()
    if not handles:
        return
    columns = 1 if beside else _fitting(ax, labels, columns, room)
    # Matplotlib fills columns; this order fills rows.
    order = [i for c in range(columns) for i in range(c, len(handles), columns)]
    legend = ax.legend(
        [handles[i] for i in order],
        [labels[i] for i in order],
        loc="upper left" if beside else "lower left",
        bbox_to_anchor=(1.0, 1.0) if beside else (0.0, 1.0),
        borderaxespad=0.2,
        ncols=columns,
        fontsize=SMALL_SIZE,
        title=title,
        title_fontsize=SMALL_SIZE,
        alignment="left",
        frameon=False,
        handlelength=1.4,
        handletextpad=0.5,
        columnspacing=1.0,
    )
    # A dollar sign in a name does not mean mathematics.
    for text in legend.get_texts():
        text.set_parse_math(False)


def _fitting(ax: Axes, labels: list[str], columns: int, room: float) -> int:
    """Returns the number of columns of a legend that fit above axes."""
    # Estimates in points: a letter is a little wider than half its height, and
    # the handle and the gap are as wide as six letters.
    letter = 0.57 * SMALL_SIZE
    whole = 72.0 * ax.figure.bbox.width / ax.figure.dpi
    # Names to the left reduce the width of the axes.
    names = [len(tick.get_text()) for tick in ax.get_yticklabels()]
    room = min(
        room,
        1.2 * whole * ax.get_position().width,
        whole - letter * max(names, default=0) - 5.0,
    )
    widths = [letter * (len(label) + 6) for label in labels]
    for count in range(min(columns, len(labels)), 1, -1):
        if sum(max(widths[c::count]) for c in range(count)) <= room:
            return count
    return 1


def shown(name: str, longest: int = _LONGEST) -> str:
    """Returns a name as a short label that Matplotlib does not hide."""
    if len(name) > longest:
        # Names mostly differ at their ends: "a.speed=1" and "a.speed=2".
        half = longest // 2
        name = f"{name[: half - 1]}\u2026{name[-half:]}"
    # Legends omit labels that start with an underscore.
    return f" {name}" if name.startswith("_") else name


def shown_apart(names: Iterable[str]) -> list[str]:
    """Returns names as labels that are as short as differing ones can be."""
    names = list(names)
    longest = max(map(len, names), default=0)
    for length in range(_LONGEST, max(longest, _LONGEST) + 8, 8):
        labels = [shown(it, length) for it in names]
        if len({*labels}) == len({*names}):
            break
    return labels


def label_rows(ax: Axes, labels: Sequence[str]) -> None:
    """Writes a label beside each row of axes, the first at the top."""
    ax.set(yticks=range(len(labels)), ylim=(max(len(labels), 1) - 0.5, -0.5))
    ax.set_yticklabels(labels, fontsize=SMALL_SIZE, parse_math=False)
    ax.tick_params(axis="y", length=0)


def note(ax: Axes, text: str) -> None:
    """Writes the reason into empty axes."""
    ax.text(
        0.5,
        0.5,
        text,
        transform=ax.transAxes,
        ha="center",
        va="center",
        fontsize=LABEL_SIZE,
        color=MUTED,
    )
