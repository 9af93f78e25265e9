"""The figures of a report: plots as SVG inside a page."""

from collections.abc import Callable, Sequence
import io
import re
from typing import Any, NamedTuple
import warnings

from hunav_drake.report.plots.runs import Runs, recordings, robots_apart
from hunav_drake.report.plots.series import (
    plot_distance_to_people,
    plot_robot_speed,
)
from hunav_drake.report.plots.style import COLUMN, Axes
from hunav_drake.report.plots.trajectories import (
    plot_trajectories,
    trajectories_height,
)
from hunav_drake.report.plots.zones import plot_zones, zones_height


class ReportFigure(NamedTuple):
    """A plot and its caption.

    Attributes:
        caption: The caption, as text.
        svg: The plot as markup, in which Matplotlib has escaped all text.
    """

    caption: str
    svg: str


def make_figure(
    name: str,
    caption: str,
    size: tuple[float, float],
    draw: Callable[[Axes], object],
    *,
    layout: str = "constrained",
) -> ReportFigure:
    """Returns a plot as a part of a page.

    Args:
        name: A unique name on the page, of letters, digits and "-".
        caption: The caption, as text.
        size: Width and height, in inches.
        draw: Draws on the axes that it gets.
        layout: The layout of Matplotlib.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    import matplotlib.style

    # Text stays text, so the browser chooses fonts for any script. The salt
    # makes equal drawings equal files.
    settings = {"svg.fonttype": "none", "svg.hashsalt": name}
    # Styles of the caller, as for slides, are not those of the page.
    style = mpl.style.context(settings, after_reset=True)
    with style, warnings.catch_warnings():
        # The browser has the glyphs; only their size is unknown here.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        stream = io.StringIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        drawing = drawn(size, draw, layout)
        # (`savefig` would draw everything once more to lay it out.)
        canvas = FigureCanvasSVG(drawing)
        drawing.dpi = 72
        drawing.get_layout_engine().execute(drawing)
        drawing.set_layout_engine("none")
        canvas.print_svg(stream, metadata=nothing)
    return ReportFigure(caption, _inline(stream.getvalue(), name))


def drawn(
    size: tuple[float, float],
    draw: Callable[[Axes], object],
    layout: str = "constrained",
) -> Any:
    """Returns a figure of Matplotlib: see `make_figure`."""
    from matplotlib.figure import Figure

    from hunav_drake.report.plots.style import set_text_sizes

    drawing = Figure(figsize=size, layout=layout)
    ax = drawing.subplots()
    set_text_sizes(ax)
    draw(ax)
    return drawing


def run_figures(
    runs: Runs, key: str, captions: Sequence[str], height: float
) -> list[ReportFigure]:
    """Returns plots of trajectories, distance to people, speed and zones.

    Args:
        runs: One run, or several.
        key: The prefix of the figures' names.
        captions: The captions; with fewer captions, the last plots are omitted.
        height: The height of plots over time, in inches.
    """
    given = recordings(runs)
    count = len(robots_apart(given))
    # The legend of many robots needs room.
    height += 0.1 * (count - len(given))
    plots: list[tuple[str, Callable[..., object], float, str]] = [
        (
            "trajectories",
            plot_trajectories,
            trajectories_height(runs),
            "compressed",
        ),
        ("distance", plot_distance_to_people, height, "constrained"),
        ("speed", plot_robot_speed, height, "constrained"),
        ("zones", plot_zones, zones_height(count), "constrained"),
    ]
    return [
        make_figure(
            key + name,
            caption,
            (COLUMN, tall),
            # (mypy cannot infer the type of a lambda that has a default.)
            lambda ax, plot=plot: plot(runs, ax=ax),  # type: ignore[misc]
            layout=layout,
        )
        for (name, plot, tall, layout), caption in zip(
            plots, captions, strict=False
        )
    ]


def _inline(svg: str, name: str) -> str:
    """Returns an SVG to embed in a page, with unique ids."""
    svg = svg[svg.index("<svg") :].strip()
    # HTML needs no namespaces.
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg)
    # The ids of groups are not used, and would not be unique in the page.
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'href="#', f'href="#{name}-', svg)
    return svg.replace("url(#", f"url(#{name}-")
