"""Scores against recorded people: for terminals, pages and programs."""

from collections.abc import Sequence
import csv
import io
import json
import math
import textwrap
from typing import Any

from hunav_drake.validation.recorded import Sample, Score

_GOALS = {
    "true": "told where each goes (the true end point and mean speed)",
    "ahead": "told nothing (straight on, at the speed of the past)",
}

_HEADS = (
    *("model", "ADE (m)", "FDE (m)", "overlap (%)"),
    *("nearest", "speed", "accel.", "collision", "by density (m/s)"),
)

_LEGEND = (
    "ADE and FDE are the mean and the last distance from the recording over"
    " 4.8 s, with intervals of 95 % over paths. Overlap is the share of persons"
    " and samples whose body (0.2 m) overlaps another's. The next columns tell"
    " how the distances to the nearest person, the speeds, the accelerations"
    " and the times to collision are distributed otherwise than in the"
    " recording: the Kolmogorov-Smirnov statistic, 0 for equal, 1 for"
    " disjoint. The last one is how far the mean speed at a local density"
    " (others within 2 m, in steps of 0.25 persons/m²) is from the recorded"
    " one, on average over densities."
)


def _number(value: float, digits: int = 3) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _cells(score: Score, *, intervals: bool) -> list[str]:
    errors = []
    for mean, low, high in (score.ade, score.fde):
        text = _number(mean)
        if intervals:
            text += f" [{_number(low)}, {_number(high)}]"
        errors.append(text)
    return [
        *(score.model, *errors, _number(100 * score.overlap, 1)),
        *map(
            _number,
            (
                *(score.nearest, score.speeds),
                *(score.accelerations, score.collisions, score.by_density),
            ),
        ),
    ]


def _tables(scores: Sequence[Score]) -> list[tuple[str, str, list[Score]]]:
    """Returns scene, goal and scores of each table."""
    keys = dict.fromkeys((score.scene, score.goal) for score in scores)
    return [
        (scene, goal, [s for s in scores if (s.scene, s.goal) == (scene, goal)])
        for scene, goal in keys
    ]


def format_scores(scores: Sequence[Score], overlaps: dict[str, float]) -> str:
    """Returns the scores as tables for a terminal.

    `overlaps` are the shares of overlapping bodies in the recordings.
    """
    lines = []
    for scene, goal, own in _tables(scores):
        lines += [
            f"{scene}: {own[0].people} paths, models are {_GOALS[goal]}",
            f"(in the recording, {100 * overlaps[scene]:.1f} % overlap)",
        ]
        rows = [list(_HEADS), *(_cells(it, intervals=False) for it in own)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for name, *cells in rows:
            texts = [
                f"{cell:>{width}}"
                for cell, width in zip(cells, widths[1:], strict=True)
            ]
            lines.append(f"  {name:{widths[0]}}  {'  '.join(texts)}")
        lines.append("")
    return "\n".join([*lines, *textwrap.wrap(_LEGEND, 79)])


def scores_markdown(
    scores: Sequence[Score],
    overlaps: dict[str, float],
    pictures: dict[str, str],
) -> str:
    """Returns the scores as a page in Markdown, with the intervals.

    `pictures` are the names of files with the distributions, by scene.
    """
    lines = ["# Motion models against recorded people", "", _LEGEND, ""]
    scene_before = ""
    for scene, goal, own in _tables(scores):
        if scene != scene_before:
            lines += [f"## {scene}", ""]
            lines += [f"![Distributions of {scene}]({pictures[scene]})", ""]
            scene_before = scene
        lines += [
            f"{own[0].people} paths, in which {100 * overlaps[scene]:.1f} %"
            f" overlap; models are {_GOALS[goal]}.",
            "",
            f"| {' | '.join(_HEADS)} |",
            f"| {' | '.join(['---'] * len(_HEADS))} |",
            *(f"| {' | '.join(_cells(it, intervals=True))} |" for it in own),
            "",
        ]
    return "\n".join(lines)


def _flat(score: Score) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for name, value in score._asdict().items():
        if isinstance(value, Sample):
            continue
        if isinstance(value, tuple):
            ends = ("", "_low", "_high")
            row |= {f"{name}{e}": v for e, v in zip(ends, value, strict=True)}
        else:
            row[name] = value
    return row


def scores_csv(scores: Sequence[Score]) -> str:
    """Returns a row per score, with a header."""
    text = io.StringIO()
    rows = list(map(_flat, scores))
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def scores_json(scores: Sequence[Score]) -> str:
    """Returns a list of objects; NaN is null."""
    rows = [
        {
            name: None if isinstance(v, float) and math.isnan(v) else v
            for name, v in _flat(score).items()
        }
        for score in scores
    ]
    return json.dumps(rows, indent=2, allow_nan=False)
