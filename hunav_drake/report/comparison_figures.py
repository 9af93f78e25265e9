"""Figures that compare planners: for pages, and as files for a paper."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from hunav_drake.report.figures import drawn
from hunav_drake.report.plots.comparison import (
    comparison_height,
    distribution_height,
    plot_comparison,
    plot_differences,
    plot_distribution,
)
from hunav_drake.report.plots.style import COLUMN, Axes, shown
from hunav_drake.runs.comparison.captions import runs_caption
from hunav_drake.runs.comparison.latex import escaped
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.runs.settings import contenders, with_names
from hunav_drake.runs.statistics import TIMES, check_columns, is_rate
from hunav_drake.systems.common.files import atomic_write, file_name_part
from hunav_drake.systems.common.suggest import shown as quoted, suggestion
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.trial.metric_facts import HEADLINE
from hunav_drake.trial.result import TrialResult

FORMATS = ("pdf", "svg", "png")

# The resolution of pictures, in dots per inch.
_DPI = 300


class ComparisonFigure(NamedTuple):
    """A figure that compares the planners in one scenario.

    Attributes:
        name: The end of its file name.
        caption: What is drawn, as sentences.
        size: Width and height, in inches.
        draw: Draws on the axes that it gets.
    """

    name: str
    caption: str
    size: tuple[float, float]
    draw: Callable[[Axes], object]


def comparison_figures(
    runs: pd.DataFrame, metric: str
) -> Iterator[ComparisonFigure]:
    """Yields the figures of a metric that tell something.

    They are means with intervals; for several planners, differences on equal
    seeds; and for metrics that are no rates, the distribution.

    Args:
        runs: The runs in one scenario, with the column `contender`.
        metric: A column with at least one value.
    """
    names = list(dict.fromkeys(runs["contender"]))
    yield ComparisonFigure(
        "means",
        f"Mean of {metric} by planner, with its 95 % confidence interval"
        f"{' (none for one seed)' * (not is_rate(metric))}. Dots are single"
        " runs.",
        (COLUMN, comparison_height(len(names))),
        lambda ax: plot_comparison(runs, metric, by="contender", ax=ax),
    )
    if len(names) > 1:
        yield ComparisonFigure(
            "differences",
            f"Difference of {metric} from that of {shown(names[0])} on equal"
            " seeds. Diamonds are means, with their 95 % confidence intervals"
            " (thick where one of the two is better); dots are single seeds.",
            (COLUMN, comparison_height(len(names) - 1)),
            lambda ax: plot_differences(runs, metric, ax=ax),
        )
    if not is_rate(metric):
        never = (
            " Runs that do not arrive count as later than all others."
            if base_name(metric) in TIMES
            else ""
        )
        yield ComparisonFigure(
            "distribution",
            f"Share of runs in which {metric} is at most the value below"
            f" (empirical distribution).{never}",
            (COLUMN, distribution_height(len(names))),
            lambda ax: plot_distribution(runs, metric, by="contender", ax=ax),
        )


def WriteFigures(
    runs: pd.DataFrame | Iterable[TrialResult],
    folder: str | Path,
    *,
    metrics: Sequence[str] | None = None,
    formats: Sequence[str] = FORMATS,
    made_by: str = "",
) -> list[Path]:
    """Writes figures that compare planners, each to files of its own.

    For each scenario and metric these are means, differences on equal seeds,
    and distributions. They have the width of a column, 3.4 inches, with text
    of 7 points and more. `figures.tex` includes them all, with captions that
    tell scenario, planners, seeds and version. Existing files are replaced.

    Args:
        runs: Results, or a table with a row per run: see `ReadRuns`.
        folder: The folder of the files; it is created if necessary.
        metrics: Columns of the table; by default those of the headline. A
            metric without a value in a scenario has no figure there.
        formats: Of "pdf", "svg" and "png".
        made_by: The suite and the versions, for captions.

    Returns:
        The paths of the files, `figures.tex` at the end.

    Raises:
        OSError: If a file cannot be written.
        ValueError: If there is no such column or format.
    """
    import matplotlib as mpl

    table = runs if isinstance(runs, pd.DataFrame) else tabulate_runs(runs)
    check_columns(table, ["scenario", "planner"])
    table = with_names(table)
    table = table.assign(contender=contenders(table))
    if metrics is None:
        metrics = [
            str(it)
            for base in HEADLINE
            for it in table
            if base_name(it) == base
        ]
    columns = [str(it) for it in table]
    for what, given, known in (
        ("metrics", metrics, columns),
        ("formats", formats, list(FORMATS)),
    ):
        for name in given:
            if name not in known:
                raise ValueError(
                    f"{what}: there is no {quoted(name)};"
                    f" {suggestion(name, known)}"
                )
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths, floats = [], []
    taken: set[str] = set()
    settings = {"pdf.fonttype": 42, "svg.hashsalt": "hunav_drake"}
    for scenario, part in table.groupby("scenario", sort=False):
        for metric in dict.fromkeys(metrics):
            if part[metric].notna().any():
                for it in comparison_figures(part, metric):
                    words = (str(scenario), metric, it.name)
                    stem = file_name_part("_".join(filter(None, words)))
                    # (LaTeX takes what is after a dot for a format.)
                    stem = stem.replace(".", "-")
                    # What is left of other names may be the same.
                    while stem.lower() in taken:
                        stem += "_"
                    taken.add(stem.lower())
                    with mpl.rc_context(settings):
                        drawing = drawn(it.size, it.draw)
                        for kind in formats:
                            paths.append(folder / f"{stem}.{kind}")
                            with atomic_write(paths[-1]) as file:
                                drawing.savefig(
                                    file,
                                    format=kind,
                                    dpi=_DPI,
                                    metadata=_UNDATED[kind],
                                )
                    about = runs_caption(part, made_by)
                    floats.append(_latex(stem, f"{it.caption} {about}."))
    paths.append(folder / "figures.tex")
    with atomic_write(paths[-1]) as file:
        text = "% In the preamble: \\usepackage{graphicx}\n\n"
        file.write((text + "\n".join(floats)).encode())
    return paths


# So that equal drawings are equal files.
_UNDATED: dict[str, dict[str, None]] = {
    "pdf": {"CreationDate": None},
    "svg": {"Date": None},
    "png": {},
}


def _latex(stem: str, caption: str) -> str:
    return "\n".join(
        [
            r"\begin{figure}",
            r"\centering",
            rf"\includegraphics[width=\columnwidth]{{{stem}}}",
            rf"\caption{{{escaped(caption)}}}",
            r"\end{figure}",
            "",
        ]
    )
