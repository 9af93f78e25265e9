"""The tables of a report as data for the templates."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from hunav_drake.runs.outcomes import GOAL, why_not_goal
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.trial.metric_facts import (
    Table as Metrics,
    direction_of,
    family_of,
)
from hunav_drake.trial.quantity_text import number_text, superscript, unit_text

if TYPE_CHECKING:
    import pandas as pd

_ARROWS = {"lower": "↓", "higher": "↑"}


class Metric(NamedTuple):
    """The name of a metric as a cell of a table.

    Attributes:
        name: The name.
        arrow: Whether lower or higher values are better; may be empty.
        definition: The definition in one sentence; may be empty.
    """

    name: str
    arrow: str
    definition: str


class Estimate(NamedTuple):
    """A mean as a cell of a table.

    Attributes:
        text: The mean.
        low: The lower end of its confidence interval; may be empty.
        high: The upper end.
        n: The number of runs with a value, if some have none.
    """

    text: str
    low: str = ""
    high: str = ""
    n: str = ""


class Marked(NamedTuple):
    """Text in a special style as a cell of a table.

    Attributes:
        text: The text.
        kind: Its CSS class.
    """

    text: str
    kind: str


# Text, a metric, a mean, or links by their texts.
Cell = str | Metric | Estimate | Marked | Mapping[str, str]


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        head: The headings of the columns; may be empty.
        groups: The rows below each subheading, "" for none. The first cell of
            a row is its heading.
        numbers: The columns of numbers, which are aligned to the right.
        caption: The heading of the table.
        kind: The CSS class of the table.
    """

    head: Sequence[Cell]
    groups: Mapping[str, Sequence[Sequence[Cell]]]
    numbers: Collection[int] = ()
    caption: str = ""
    kind: str = ""


def split_by_family(table: Table) -> list[Table]:
    """Returns a table for each group of rows, with its name as caption."""
    return [
        Table(table.head, {"": rows}, table.numbers, group, table.kind)
        for group, rows in table.groups.items()
    ]


@dataclass
class MetricRows:
    """Collects rows about metrics.

    Attributes:
        metrics: The metrics of a trial or a table of runs, with their units.
        by_family: Whether to group rows by family.
        groups: The rows of each group.
    """

    metrics: Metrics
    by_family: bool = True
    groups: dict[str, list[list[Cell]]] = field(default_factory=dict)

    def add(
        self, name: str, cells: Iterable[Cell], unit: str, told: str = ""
    ) -> None:
        """Adds the row of a metric: its name or `told`, cells, and its unit."""
        family = family_of(self.metrics, name) if self.by_family else ""
        cell = metric_cell(self.metrics, name)._replace(name=told or name)
        row = [cell, *cells, unit_text(unit)]
        self.groups.setdefault(family, []).append(row)


def metric_cell(metrics: Metrics, name: str) -> Metric:
    """Returns the name of a metric with its direction and definition."""
    definition = ""
    if (metric := METRICS.get(base_name(name))) is not None:
        first = metric.definition.split("\n\n")[0]
        definition = " ".join(first.split())
    arrow = _ARROWS.get(direction_of(metrics, name), "")
    return Metric(name, arrow, definition)


def outcome_table(
    outcomes: "pd.DataFrame", names: Mapping[str, str]
) -> Table | None:
    """Returns the counts of end reasons of each kind of runs, with messages.

    Args:
        outcomes: From `count_outcomes`.
        names: The columns that distinguish kinds, with their headings.
    """
    if outcomes.empty:
        return None
    reasons = list(dict.fromkeys([GOAL, *outcomes["end_reason"]]))
    rows: list[list[Cell]] = []
    for kind, own in outcomes.groupby(list(names), sort=False, dropna=False):
        counts = dict(zip(own["end_reason"], own["count"], strict=True))
        ended = [str(counts.get(reason, 0)) for reason in reasons]
        why = "; ".join(why_not_goal(own))
        rows.append([*kind, str(own["runs"].iloc[0]), *ended, why])
    head = [*names.values(), "runs", *reasons, "why"]
    numbers = range(len(names), len(head) - 1)
    return Table(head, {"": rows}, numbers=numbers, kind="outcomes")


def provenance_table(provenance: Mapping[str, Any]) -> Table:
    """Returns the table of provenance."""
    rows = [[k.replace("_", " "), str(v)] for k, v in provenance.items()]
    return Table([], {"": rows}, kind="provenance")


def number(value: float, unit: str = "", *, scale: float = 0.0) -> str:
    """Returns the text of a number: see `number_text`; a dash for NaN."""
    text = number_text(value, unit, scale=scale)
    if text == "-":
        return "\N{EN DASH}"
    mantissa, power, exponent = text.partition("e")
    if power:
        raised = superscript(str(int(exponent)))
        mantissa += f"\N{MULTIPLICATION SIGN}10{raised}"
    mantissa = mantissa.replace("inf", "\N{INFINITY}")
    return mantissa.replace("-", "\N{MINUS SIGN}")


def signed(value: float, unit: str = "") -> str:
    """Returns the text of a difference, with its sign: see `number`."""
    text = number(float(value), unit)
    return f"+{text}" if value > 0 and text != "0" else text
