"""Distributions of what recorded and predicted people do."""

from collections.abc import Mapping
import io
from typing import Any

import numpy as np

from hunav_drake.report.plots.style import (
    COLUMN,
    SMALL_SIZE,
    Axes,
    line_styles,
    set_text_sizes,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.validation.recorded import Sample, speeds_by_density

_LABELS = {
    "nearest": "distance to the nearest person (m)",
    "speeds": "speed (m/s)",
    "accelerations": "acceleration (m/s²)",
    "collisions": "time to collision (s)",
}

# People farther than that have nothing to do with each other, in meters.
_FARTHEST = 4.0


def draw_samples(real: Sample, made: Mapping[str, Sample]) -> str:
    """Returns a picture (SVG) of four distributions and of speeds by density.

    The recording is black; `made` are the samples by the name of the model.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    # Equal drawings give equal files.
    with mpl.rc_context({"svg.hashsalt": "recorded"}):
        drawing = Figure(figsize=(3 * COLUMN, 1.7 * COLUMN))
        drawing.set_layout_engine("constrained")
        styles = line_styles(len(made))
        *axes, by_density, unused = drawing.subplots(2, 3).flat
        unused.remove()
        for ax, (name, label) in zip(axes, _LABELS.items(), strict=True):
            for (model, sample), style in zip(
                made.items(), styles, strict=True
            ):
                _draw(ax, getattr(sample, name), label=model, lw=1, **style)
            whole = getattr(real, name)
            _draw(ax, whole, label="recording", lw=1.8, color="black")
            high = float(np.quantile(whole, 0.98)) if len(whole) else 1.0
            high = min(high, _FARTHEST) if name == "nearest" else high
            ax.set(xlabel=label, ylabel="share", xlim=(0, 1.15 * high))
            ax.set_ylim(0, 1)
            set_text_sizes(ax)
        for (model, sample), style in zip(made.items(), styles, strict=True):
            by_density.plot(
                *speeds_by_density(sample), label=model, lw=1, **style
            )
        by_density.plot(*speeds_by_density(real), lw=1.8, color="black")
        by_density.set(
            xlabel="local density (persons/m²)", ylabel="speed (m/s)"
        )
        by_density.set_ylim(bottom=0)
        set_text_sizes(by_density)
        handles, labels = ax.get_legend_handles_labels()
        drawing.legend(
            handles,
            labels,
            loc="outside upper center",
            ncols=3,
            fontsize=SMALL_SIZE,
            frameon=False,
        )
        stream = io.StringIO()
        drawing.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def _draw(ax: Axes, values: Array, **style: Any) -> None:
    if len(values):
        ax.ecdf(values, **style)
    else:
        ax.plot([], [], **style)
