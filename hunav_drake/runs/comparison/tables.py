"""Tables of a suite, planners side by side, and as text."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math

import pandas as pd

from hunav_drake.runs.comparison.captions import made_by_text, runs_caption
from hunav_drake.runs.comparison.paper import (
    METRICS,
    PUBLISHED_BY_BEHAVIOR,
    printed_values,
)
from hunav_drake.runs.outcomes import count_outcomes, outcome_text
from hunav_drake.runs.settings import contenders, with_names
from hunav_drake.runs.statistics import early_mark, is_rate, summarize
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.systems.evaluation.metric import (
    DERIVED_FAMILIES,
    FLEET_FAMILY,
    base_name,
)
from hunav_drake.systems.evaluation.metrics import METRICS as KNOWN
from hunav_drake.trial.metric_facts import family_of, unit_of
from hunav_drake.trial.provenance import program_versions
from hunav_drake.trial.quantity_text import ROUNDING, number_text, unit_text

# The metrics in the tables of a suite: those of the paper.
PAPER_METRICS = tuple(name for name, _, _ in METRICS)

# Those of several robots with each other, and of each of them.
_FLEET_METRICS = (
    "makespan",
    "sum_of_costs",
    "min_dist_between_robots",
    "contacts_between_robots",
    "deadlock_time",
)
_OF_EACH_ROBOT = (
    "min_dist_to_people",
    "personal_space_intrusions",
    "robot_on_person_collisions",
)

# The legend of a cell.
_EARLY = (
    "* Not all of these runs arrive, so the mean includes paths that end early."
)
NOTE = f"In brackets: n, the number of seeds. {_EARLY}"

# What the columns of a table of chosen metrics may be, and mean.
COLUMNS = {
    "estimate": "The numbers are means \N{PLUS-MINUS SIGN} half of their 95 %"
    " confidence intervals; rates have their interval. In brackets: the number"
    " of seeds with a value.",
    "n": "n is the number of seeds with a value.",
    "mean": "",
    "interval": "The interval is the 95 % confidence interval of the mean.",
    "sd": "sd is the standard deviation over seeds.",
    "median": "",
    "arrived": "arrived tells how many of the n reach the goal.",
}

# The row of end reasons.
ENDS = "ends"

_BEHAVIOR_METRICS = tuple(PUBLISHED_BY_BEHAVIOR["regular"]["dwb"])


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        title: The title.
        header: The names of the columns.
        rows: The cells; the first is the name of the row.
        caption: The caption of the table in a paper; empty for title and note.
        groups: Names above the columns between first and last, each with the
            number of its columns.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    groups: tuple[tuple[str, int], ...] = ()


def by_place(runs: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yields each scenario and setting, with its runs."""
    if runs.empty:
        return
    keys = ["scenario", "setting"]
    for (scenario, setting), part in runs.groupby(keys, sort=False):
        part.attrs = runs.attrs
        yield scenario, setting, part


def scenario_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each scenario and setting: metrics by planner.

    For cells see `mean_text`. The paper's suite also has the paper's values.
    """
    tables = []
    for scenario, setting, runs in by_place(result.runs()):
        published = printed_values(result.suite.name, scenario)
        title = " ".join(filter(None, (scenario, setting)))
        names = fleet_metrics(runs) or (*PAPER_METRICS, *scores(runs))
        table = _table(title, runs, names, published)
        tables.append(_captioned(table, result, runs))
    return [table for table in tables if table]


def chosen_tables(
    runs: pd.DataFrame,
    metrics: Sequence[str],
    columns: Sequence[str] = ("estimate",),
    made_by: str = "",
) -> list[Table]:
    """Returns a table of chosen metrics for each scenario.

    A row is a metric; each planner, with its setting, has all columns. A
    metric that only other scenarios have, as of their robots, has no row.

    Args:
        runs: A row per run: see `ReadRuns`.
        metrics: Columns of `runs`.
        columns: Keys of `COLUMNS`.
        made_by: The suite and the versions, for the captions.

    Raises:
        ValueError: If the table has no such column.
    """
    runs = with_names(runs)
    runs = runs.assign(contender=contenders(runs))
    tables = []
    for scenario, part in runs.groupby("scenario", sort=False):
        statistics = summarize(part, "contender", metrics=metrics)
        names = list(dict.fromkeys(part["contender"]))
        others = others_of(part, runs)
        rows = []
        for metric in metrics:
            if metric in others:
                continue
            unit = shown_unit(part, metric)
            cells = [
                _chosen(statistics.loc[(name, metric)], it, metric, unit)
                for name in names
                for it in columns
            ]
            rows.append((metric, *cells, unit_text(unit)))
        if not rows:
            continue
        groups: tuple[tuple[str, int], ...] = ()
        heads = names
        if len(columns) > 1:
            groups = tuple((name, len(columns)) for name in names)
            heads = [*columns] * len(names)
        about = runs_caption(part, made_by)
        table = Table(
            title=str(scenario),
            header=("", *heads, "unit"),
            rows=tuple(rows),
            caption=_noted(about, columns, rows),
            groups=groups,
        )
        tables.append(table)
    return tables


def _chosen(described: pd.Series, column: str, metric: str, unit: str) -> str:
    """Returns the text of a statistic of a metric in a cell."""
    if column == "estimate":
        return mean_text(described, metric, unit)
    if column in ("n", "arrived"):
        return number_text(float(described[column]), "-")
    factor = 100.0 if is_rate(metric) else 1.0
    # The mean of counts may not be whole.
    unit = "" if unit == "-" else unit
    keys = ("low", "high") if column == "interval" else (column,)
    numbers = [factor * float(described[key]) for key in keys]
    scale = max(map(abs, numbers))
    texts = [number_text(it, unit, scale=scale) for it in numbers]
    if column == "interval":
        return "-" if "-" in texts else f"[{', '.join(texts)}]"
    return texts[0] + early_mark(metric, described) * (column == "mean")


def behavior_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each behavior, if there are several (Table IV)."""
    tables = []
    for scenario, setting, runs in by_place(result.runs(by_behavior=True)):
        behaviors = runs.behavior.unique()
        for behavior in behaviors if len(behaviors) > 1 else ():
            rows = runs[runs.behavior == behavior]
            rows.attrs = runs.attrs
            published = printed_values(result.suite.name, scenario, behavior)
            place = " ".join(filter(None, (scenario, setting)))
            title = f"{place}, {behavior} people"
            # What robots are to each other does not depend on people.
            own = [it for it in fleet_metrics(rows) if it not in _FLEET_METRICS]
            table = _table(title, rows, own or _BEHAVIOR_METRICS, published)
            tables.append(
                _captioned(table, result, rows, f"{behavior} people only")
            )
    return [table for table in tables if table]


def _captioned(
    table: Table | None, result: SuiteResult, runs: pd.DataFrame, of: str = ""
) -> Table | None:
    """Returns a table with a caption: its runs, and what its numbers are."""
    if table is None:
        return None
    suite = result.suite
    made_by = made_by_text(
        suite.name, suite.version, str(program_versions()["hunav_drake"])
    )
    about = "; ".join(filter(None, [runs_caption(runs, made_by), of]))
    return replace(table, caption=_noted(about, ["estimate"], table.rows))


def _noted(
    about: str, columns: Sequence[str], rows: Sequence[Sequence[str]]
) -> str:
    """Returns a caption that explains columns, and marks that are used."""
    notes = [COLUMNS[it] for it in columns]
    notes += [_EARLY] * any("*" in cell for row in rows for cell in row)
    return " ".join([f"{about}.", *filter(None, notes)])


def _table(
    title: str,
    runs: pd.DataFrame,
    metrics: Sequence[str],
    published: dict[str, dict[str, float]],
) -> Table | None:
    names = [name for name in metrics if name in runs.columns]
    if not names:
        return None
    planners = list(dict.fromkeys(runs.planner))
    statistics = summarize(runs, "planner", metrics=names)
    header = [""]
    for planner in planners:
        header += [planner] + (["paper"] if planner in published else [])
    rows: list[tuple[str, ...]] = []
    for name in names:
        unit = shown_unit(runs, name)
        row = [name]
        for planner in planners:
            row.append(mean_text(statistics.loc[planner, name], name, unit))
            if planner in published:
                value = published[planner].get(name, math.nan)
                row.append(number_text(value, unit))
        rows.append((*row, unit_text(unit)))
    if "behavior" not in runs:
        ends = count_outcomes(runs, ["planner"])
        row = [ENDS]
        for planner in planners:
            row.append(outcome_text(ends[ends.planner == planner]))
            row += ["-"] * (planner in published)
        rows.append((*row, ""))
    return Table(title, (*header, "unit"), tuple(rows))


def fleet_metrics(runs: pd.DataFrame) -> list[str]:
    """Returns the metrics in tables of several robots; none of one robot."""
    known = [it for it in runs if runs[it].notna().any()]
    if "min_dist_between_robots" not in known:
        # Of several robots, others were chosen.
        names = {it: base_name(it) for it in known if base_name(it) != it}
        return [it for b in PAPER_METRICS for it in names if names[it] == b]
    own = (it for b in _OF_EACH_ROBOT for it in known if it.endswith(f".{b}"))
    return [*(it for it in _FLEET_METRICS if it in runs), *own]


def others_of(part: pd.DataFrame, runs: pd.DataFrame) -> set[str]:
    """Returns the columns of runs that only robots of other scenarios have.

    (Where nobody arrives, the robots have a metric, without a value.)
    """

    def robots_of(table: pd.DataFrame) -> set[str]:
        has = table.notna().any()
        return {
            it.removesuffix(base_name(it))
            for it in table
            if base_name(it) in KNOWN
            and KNOWN[base_name(it)].family != FLEET_FAMILY
            and has[it]
        }

    here, every = robots_of(part), robots_of(runs) - {""}
    # (A trial of several robots may have values of its own, too.)
    here = here - {""} or here

    def is_of_others(metric: str) -> bool:
        if metric in KNOWN and KNOWN[metric].family == FLEET_FAMILY:
            return here == {""}
        robot = next((it for it in every if metric.startswith(it)), "")
        return bool(here) and robot not in here

    empty = runs.columns[part.isna().all() & runs.notna().any()]
    return {it for it in empty if is_of_others(it)}


def scores(runs: pd.DataFrame) -> list[str]:
    """Returns the numbers of runs that kinds of scenarios have."""
    return [
        it
        for it in runs.attrs["units"]
        if base_name(it) not in KNOWN
        and family_of(runs, it) not in DERIVED_FAMILIES
        and runs[it].notna().any()
    ]


def shown_unit(runs: pd.DataFrame, metric: str) -> str:
    """Returns the unit of a metric in tables: rates are in percent."""
    return "%" if is_rate(metric) else unit_of(runs, metric)


def mean_text(described: pd.Series, metric: str, unit: str) -> str:
    """Returns the text of a metric in a cell.

    It has the mean, half the width of its 95 % interval (for rates, the
    interval), n in brackets, and perhaps an asterisk: see `NOTE`.

    Args:
        described: A row of `summarize`.
        metric: The name of the metric.
        unit: The unit in which it is shown.
    """
    scale = 100.0 if is_rate(metric) else 1.0
    mean, low, high = (
        scale * float(described[key]) for key in ("mean", "low", "high")
    )
    half = (high - low) / 2
    text = number_text(mean, unit)
    if is_rate(metric):
        text = text.removesuffix(".0")
        # This interval is not symmetric.
        text += f" [{low:.0f}, {high:.0f}]" * math.isfinite(half)
    elif math.isfinite(half) and half > ROUNDING * max(1.0, abs(mean)):
        reach = number_text(half, unit, scale=abs(mean))
        if float(reach) == 0:
            # More decimals than those of the mean are better than 0.
            reach = number_text(half)
        text += f" \N{PLUS-MINUS SIGN} {reach}"
    mark = early_mark(metric, described)
    return f"{text} ({described['n']:.0f}){mark}"


def to_text(table: Table) -> str:
    """Returns a table for a terminal."""
    rows = [table.header, *table.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [table.title]
    for row in rows:
        first, *others = (
            text.ljust(width) if i == 0 else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        lines.append("  ".join([first, *others]).rstrip())
    return "\n".join(lines)
