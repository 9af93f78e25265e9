"""The texts that `hunav metrics` prints."""

from collections.abc import Sequence
import shutil
import textwrap

from hunav_drake.hunavsim.differences import differences_of_metric
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics

_DIRECTIONS = {
    "lower": "lower is better",
    "higher": "higher is better",
    "none": "neither is better",
}


def list_metrics() -> str:
    """Returns one line for each metric, by family: name, unit, definition.

    The sign before the unit is - if lower is better, + if higher is better.
    """
    width = shutil.get_terminal_size(fallback=(120, 24)).columns
    signs = {"lower": "-", "higher": "+", "none": " "}
    name_width = max(map(len, METRICS)) + 2
    lines = ["+ higher is better, - lower is better"]
    metrics = select_metrics(["all"])
    families = list(dict.fromkeys(metric.family for metric in metrics))
    metrics.sort(key=lambda metric: families.index(metric.family))
    family = None
    for metric in metrics:
        if metric.family != family:
            family = metric.family
            lines += ["", family]
        first = metric.definition.splitlines()[0]
        line = (
            f"  {metric.name:{name_width}}{signs[metric.direction]}"
            f" {metric.unit:6} {first}"
        )
        lines.append(line if len(line) <= width else line[: width - 3] + "...")
    return "\n".join(lines)


def show_metrics(names: Sequence[str]) -> str:
    """Returns the full descriptions of metrics: see `select_metrics`."""
    blocks = []
    for metric in select_metrics(map(base_name, names)):
        facts = [
            f"{metric.name} [{metric.unit}]",
            f"  family     {metric.family}",
            f"  direction  {_DIRECTIONS[metric.direction]}",
            f"  source     {metric.source}",
        ]
        if metric.aliases:
            facts.append(f"  also       {', '.join(metric.aliases)}")
        text = textwrap.indent(metric.definition, "  ")
        for row in differences_of_metric(metric.name):
            what = f", {row.name}" if row.series else ""
            text += "\n\n" + textwrap.fill(
                f"Not as in HuNavSim{what}. HuNavSim: {row.original}. Here:"
                f" {row.here}.",
                width=80,
                initial_indent="  ",
                subsequent_indent="  ",
            )
        blocks.append("\n".join([*facts, "", text]))
    return "\n\n".join(blocks)
