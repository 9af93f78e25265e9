"""The page on metrics, made from their definitions."""

from pathlib import Path

from hunav_drake.hunavsim.differences import differences_of_metric
from hunav_drake.systems.evaluation.metric import TABLE_I, Metric
from hunav_drake.systems.evaluation.metrics import select_metrics

HEAD = """# Metrics

The metrics of a trial, as `hunav metrics show all` prints them. A gap is the
distance between the surfaces of two discs, the robot's and a person's, and 0
where they overlap. Samples are numbered from 0 to N. Metrics of the paper's
Table I are marked. `evaluator: {metrics: [...]}` selects by name or family; to
add one, see [a metric of your own](own_metric.md).
"""

_BETTER = {"lower": "lower", "higher": "higher", "none": ""}


def metrics_reference(drawings: Path) -> str:
    """Returns the page, in Markdown.

    Args:
        drawings: The folder in which families have their drawings, as
            metrics_FAMILY.svg.
    """
    families: dict[str, list[Metric]] = {}
    for metric in select_metrics(["all"]):
        families.setdefault(metric.family, []).append(metric)
    lines = [HEAD]
    for family, metrics in families.items():
        lines += [f"## {family.capitalize()}", ""]
        if (drawings / f"metrics_{family}.svg").exists():
            lines += [
                f"![What the metrics of {family} measure]"
                f"(metrics_{family}.svg)",
                "",
            ]
        lines += ["| metric | unit | better | what it is |"]
        lines += ["| --- | --- | --- | --- |"]
        for metric in metrics:
            first = metric.definition.splitlines()[0].replace("|", "\\|")
            lines.append(
                f"| [`{metric.name}`](#{_anchor(metric)}) | {metric.unit}"
                f" | {_BETTER[metric.direction]} | {first} |"
            )
        for metric in metrics:
            lines += ["", *_section(metric)]
        lines.append("")
    return "\n".join(lines)


def _anchor(metric: Metric) -> str:
    return metric.name.replace("+", "-plus")


def _section(metric: Metric) -> list[str]:
    mark = ", Table I" if metric.name in TABLE_I else ""
    facts = [f"unit {metric.unit}{mark}", f"source: {metric.source}"]
    if metric.aliases:
        names = ", ".join(f"`{alias}`" for alias in metric.aliases)
        facts.append(f"also called {names}")
    lines = [
        f"### `{metric.name}` {{ #{_anchor(metric)} }}",
        "",
        "```text",
        metric.definition.strip(),
        "```",
        "",
        *(f"- {fact}" for fact in facts),
    ]
    for row in differences_of_metric(metric.name):
        what = f" ({row.name})" if row.series else ""
        lines.append(
            f"- not as in HuNavSim{what}: there {row.original}; here {row.here}"
        )
    return lines
