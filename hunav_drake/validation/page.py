"""Writes the results of the validation as HTML, and Markdown with pictures."""

from collections.abc import Iterator, Mapping, Sequence
import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hunav_drake.report.environment import write_page
from hunav_drake.report.figures import make_figure
from hunav_drake.report.plots.style import COLUMN, set_text_sizes
from hunav_drake.report.tables import provenance_table
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.common.suggest import counted
from hunav_drake.validation.case import VERDICTS, Case, Outcome
from hunav_drake.validation.cases import by_topic
from hunav_drake.validation.plots import PLOTS, ValidationPlot
from hunav_drake.validation.tables import counts, models_of, told

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE = "Validation of the motion models"

PREFACE = (
    "Each case simulates people of a motion model on one floor, and checks"
    " whether they walk like real people. Most cases are those of three"
    " standards, with their numbers: the RiMEA guideline 4.1.1, NIST Technical"
    " Note 1822 and ISO 20414:2020. Where the original needs several floors,"
    " the case is adapted to one. The standards specify thresholds for RiMEA"
    " 1, 5, 10 and 15 and NIST 2.8 and 5.2; all other thresholds are choices"
    " of this project. Unless stated otherwise, people have a radius of 0.2 m"
    " and a desired speed of 1.34 m/s, and the time step is 0.05 s. If nobody"
    " has left for 20 s (at wide places up to 60 s), the remaining people"
    " count as never leaving."
)

SOURCES = (
    "RiMEA e.V. 2025, Guideline for microscopic evacuation analyses, 4.1.1",
    "Ronchi, Kuligowski, Reneke, Peacock & Nilsson 2013, The process of"
    " verification and validation of building fire evacuation models, NIST"
    " Technical Note 1822",
    "ISO 20414:2020, Fire safety engineering: verification and validation"
    " protocol for building fire evacuation models",
    "Weidmann 1993, Transporttechnik der Fußgänger, ETH Zürich",
    "Seyfried, Passon, Steffen, Boltes, Rupprecht & Klingsch 2009, New insights"
    " into pedestrian flow through bottlenecks",
    "Helbing, Farkas & Vicsek 2000, Simulating dynamical features of escape"
    " panic",
    "Moussaïd, Perozo, Garnier, Helbing & Theraulaz 2010, The walking behaviour"
    " of pedestrian social groups and its impact on crowd dynamics",
    "Feliciani & Nishinari 2016, Empirical analysis of the lane formation"
    " process in bidirectional pedestrian flow",
)

_MARKS = {"passes": "yes", "fails": "**no**", "not applicable": "n/a"}


def WriteValidationPage(
    outcomes: Sequence[Outcome],
    filename: str | Path,
    provenance: Mapping[str, Any],
) -> Path:
    """Writes a page about outcomes as one HTML file, with plots.

    Args:
        outcomes: The outcomes of cases, each for the same models.
        filename: The file to write; an existing one is replaced.
        provenance: All that must be equal for equal outcomes.

    Returns:
        The path of the file.

    Raises:
        OSError: If the file cannot be written.
    """
    models = models_of(outcomes)
    rows = _rows(outcomes)
    count = sum(map(len, rows.values()))
    sums = {
        verdict: [counts(outcomes, model)[verdict] for model in models]
        for verdict in VERDICTS
    }
    return write_page(
        Path(filename),
        "validation.html",
        title=TITLE,
        about=[
            counted(count, "case"),
            counted(len(models), "model"),
            f"{provenance['form']} form",
        ],
        summary=_summary(outcomes),
        preface=PREFACE,
        replay=None,
        left_out={},
        duplicates=[],
        models=models,
        sources=SOURCES,
        topics=rows,
        sums=sums,
        figures=[
            make_figure(
                plot.case.replace("_", "-"),
                plot.caption,
                (COLUMN, plot.height(len(measured))),
                functools.partial(_draw, plot, measured),
                layout=plot.layout,
            )
            for plot, measured in _plots(outcomes)
        ],
        provenance=provenance_table(provenance),
    )


def _summary(outcomes: Sequence[Outcome]) -> list[str]:
    """Returns sentences on which models pass, and which cases none does."""
    judged: dict[str, list[bool]] = {}
    models: dict[str, list[bool]] = {}
    for it in outcomes:
        if it.verdict != "not applicable":
            judged.setdefault(it.case, []).append(it.verdict == "passes")
            models.setdefault(it.model, []).append(it.verdict == "passes")
    if not models:
        return ["No case applies."]
    passed = [
        f"{model} {sum(own)} of {len(own)}" for model, own in models.items()
    ]
    every = sum(map(all, judged.values()))
    none = [case for case, own in judged.items() if not any(own)]
    return [
        f"Cases passed: {', '.join(passed)}.",
        f"All models to which a case applies pass {every} of {len(judged)}.",
        f"None passes {', '.join(none)}." if none else "",
    ]


def _draw(plot: ValidationPlot, measured: Any, ax: "Axes") -> object:
    return plot.draw(measured, ax=ax)


def _rows(outcomes: Sequence[Outcome]) -> dict[str, list[dict[str, Any]]]:
    """Returns each case with its outcomes, by topic."""
    return {
        topic: [
            {
                "case": case,
                "outcomes": [o for o in outcomes if o.case == case.name],
            }
            for case in cases
        ]
        for topic, cases in by_topic(o.case for o in outcomes).items()
    }


def _plots(
    outcomes: Sequence[Outcome],
) -> Iterator[tuple[ValidationPlot, dict[str, Any]]]:
    """Yields the plots of cases with quantities."""
    for plot in PLOTS:
        measured = {
            outcome.model: outcome.numbers
            for outcome in outcomes
            if outcome.case == plot.case and outcome.numbers
        }
        if measured:
            yield plot, measured


def WriteValidationMarkdown(
    outcomes: Sequence[Outcome], filename: str | Path
) -> Path:
    """Writes a page about outcomes as Markdown, and its pictures beside it.

    Args:
        outcomes: The outcomes of cases, each for the same models.
        filename: The file to write; an existing one is replaced. The names of
            the pictures begin with its name.

    Returns:
        The path of the file.

    Raises:
        OSError: If a file cannot be written.
    """
    path = Path(filename)
    models = models_of(outcomes)
    lines = [f"# {TITLE}", "", PREFACE, ""]
    lines += ["`hunav validate --markdown FILE` writes this page.", ""]
    lines += ["## Overview", "", *_overview(outcomes, models), ""]
    for plot, measured in _plots(outcomes):
        picture = path.with_name(f"{path.stem}_{plot.case}.svg")
        _write_picture(picture, plot, measured)
        lines += [f"![{plot.caption}]({picture.name})", "", plot.caption, ""]
    for topic, rows in _rows(outcomes).items():
        lines += [f"## {topic}", ""]
        for row in rows:
            lines += _section(row["case"], row["outcomes"])
    lines += ["## Sources", "", *(f"- {source}" for source in SOURCES), ""]
    with atomic_write(path) as file:
        file.write("\n".join(lines).encode())
    return path


def _overview(outcomes: Sequence[Outcome], models: list[str]) -> list[str]:
    lines = [
        "| " + " | ".join(["case", "standard", *models]) + " |",
        "| --- " * (len(models) + 2) + "|",
    ]
    for rows in _rows(outcomes).values():
        for row in rows:
            name = row["case"].name
            marks = [_MARKS[outcome.verdict] for outcome in row["outcomes"]]
            cells = [f"[{name}](#{name})", row["case"].standards, *marks]
            lines.append("| " + " | ".join(cells) + " |")
    for verdict in VERDICTS:
        sums = [str(counts(outcomes, model)[verdict]) for model in models]
        lines.append("| " + " | ".join([verdict, "", *sums]) + " |")
    return lines


def _section(case: Case, outcomes: Sequence[Outcome]) -> list[str]:
    source = f" ({case.standards})" if case.standards else ""
    lines = [f"### {case.name}", "", f"{case.question}{source}", ""]
    lines += [f"Expected: {case.expected}.", ""]
    if case.measure is None:
        return [*lines, f"Not applicable: {case.reason}.", ""]
    lines += ["| model | verdict | measured |", "| --- | --- | --- |"]
    for outcome in outcomes:
        text = told(outcome).replace("|", r"\|")
        lines.append(f"| {outcome.model} | {outcome.verdict} | {text} |")
    return [*lines, ""]


def _write_picture(path: Path, plot: ValidationPlot, measured: Any) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    # Equal drawings give equal files.
    with mpl.rc_context({"svg.hashsalt": plot.case}):
        drawing = Figure(
            figsize=(1.6 * COLUMN, 1.6 * plot.height(len(measured))),
            layout=plot.layout,
        )
        ax = drawing.subplots()
        set_text_sizes(ax)
        _draw(plot, measured, ax)
        with atomic_write(path) as file:
            drawing.savefig(file, format="svg", metadata={"Date": None})
