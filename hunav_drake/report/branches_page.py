"""The page about branches of a trial."""

import math
from pathlib import Path
from typing import Any

from hunav_drake.report.environment import write_page
from hunav_drake.report.figures import make_figure
from hunav_drake.report.plots.branches import (
    branches_height,
    plot_branches,
    plot_delays,
)
from hunav_drake.report.plots.style import COLUMN
from hunav_drake.report.summary import branches_summary
from hunav_drake.report.tables import (
    Cell,
    MetricRows,
    Table,
    number,
    provenance_table,
    signed,
)
from hunav_drake.trial.branches.future import QUANTITIES
from hunav_drake.trial.branches.run import SAME, Branches
from hunav_drake.trial.metric_facts import headline_of, unit_of
from hunav_drake.trial.quantity_text import label_text

_HEADS = {
    "time": "extra time (s)",
    "path": "extra path (m)",
    "social_impulse": "extra social impulse (m/s)",
    "social_work": "extra social work (m²/s²)",
}

# The height of a plot over time, in inches.
_SERIES = 2.2


def WriteBranchesPage(
    branches: Branches, filename: str | Path, title: str
) -> Path:
    """Writes the page about branches as one HTML file, atomically.

    Args:
        branches: The branches.
        filename: The file to write; an existing one is replaced.
        title: The heading, as the name of the scenario.

    Returns:
        The path of the file.

    Raises:
        OSError: If it cannot be written.
    """
    provenance = dict(branches[SAME].provenance)
    for key in ("branch", "branch_text"):
        provenance.pop(key)
    return write_page(
        Path(filename),
        "branches.html",
        title=title,
        about=[
            f"{len(branches.futures)} branches from {branches.start:g} s until"
            f" {branches.until:g} s",
            f"people compared with: {branches.reference}",
        ],
        summary=branches_summary(branches),
        replay=None,
        left_out={},
        duplicates=[],
        totals=_totals(branches),
        people=_people(branches),
        metrics=_metrics(branches),
        figures=_figures(branches),
        provenance=provenance_table(provenance),
    )


def _totals(branches: Branches) -> Table:
    rows: list[list[Cell]] = []
    for name, row in branches.totals.iterrows():
        sums = [signed(row[it], unit) for it, unit in QUANTITIES.items()]
        rows.append([str(name), *sums, f"{row['people']:.0f}"])
    head = ["branch", *_HEADS.values(), "people"]
    return Table(head, {"": rows}, numbers=range(1, len(head)))


def _people(branches: Branches) -> list[Table]:
    """Returns a table for each quantity: people by branches."""
    table = branches.people
    names = [it for it in branches.futures if it != branches.reference]
    found = []
    for quantity, unit in QUANTITIES.items():
        own = table[table["quantity"] == quantity]
        rows: list[list[Cell]] = []
        for person, part in own.groupby("person", sort=False):
            by = part.set_index("branch")
            cells: list[Cell] = [
                signed(by.loc[it, "difference"], unit) for it in names
            ]
            base = number(by.loc[branches.reference, "value"], unit)
            rows.append([str(person), base, *cells])
        head = ["person", branches.reference, *(f"{it}, extra" for it in names)]
        name = f"{quantity.replace('_', ' ')} until the arrival"
        caption = label_text(name, unit)
        numbers = range(1, len(head))
        found.append(Table(head, {"": rows}, numbers, caption))
    return found


def _metrics(branches: Branches) -> Table:
    """Returns the headline metrics of the branches that have a robot."""
    same = branches[SAME].metrics
    names = [it for it, future in branches.futures.items() if future.robots]
    found = branches.metrics.set_index(["branch", "metric"])["value"]
    rows = MetricRows(same, by_family=False)
    for metric in headline_of(same):
        unit = unit_of(same, metric)
        values = [found.get((it, metric), math.nan) for it in names]
        cells = [number(float(it), unit) for it in values]
        rows.add(metric, cells, unit)
    ends: list[Cell] = [branches[it].end_reason for it in names]
    rows.groups.setdefault("", []).append(["end", *ends, ""])
    head = ["metric", *names, "unit"]
    return Table(head, rows.groups, numbers=range(1, len(names) + 1))


def _figures(branches: Branches) -> list[Any]:
    figures = [
        make_figure(
            "branches",
            "The ways of the robots (thick) and of the people (thin) in each"
            " branch, from the instant on. Dots are where they are then, stars"
            " the robots' goals.",
            (COLUMN, branches_height(branches)),
            lambda ax: plot_branches(branches, ax=ax),
            layout="compressed",
        )
    ]
    if branches.human_names:
        delays = make_figure(
            "delays",
            "How late people are, summed over those on their way: the time"
            " since they had come as near to their goals in the reference.",
            (COLUMN, _SERIES),
            lambda ax: plot_delays(branches, ax=ax),
        )
        figures.append(delays)
    return figures
