"""Comparisons of planners over runs: means, differences, distributions."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from hunav_drake.report.plots.runs import check_any
from hunav_drake.report.plots.style import (
    DASHES,
    PALETTE,
    SMALL_SIZE,
    Axes,
    label_rows,
    legend_outside,
    line_styles,
    new_axes,
    note,
    shown,
    shown_apart,
)
from hunav_drake.runs.independent_runs import (
    comparable,
    draws_nothing,
    once_per_seed,
)
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.runs.settings import contenders, with_names
from hunav_drake.runs.statistics import (
    TIMES,
    arrival_rates,
    arrivals,
    check_columns,
    compare,
    differences,
    is_rate,
    summarize,
    with_numbers,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.suggest import shown as quoted
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.trial.metric_facts import HEADLINE, unit_of
from hunav_drake.trial.quantity_text import label_text
from hunav_drake.trial.result import TrialResult

# With more runs, dots would hide each other.
_MOST_DOTS = 200

# The height of a plot of distributions, in inches.
_DISTRIBUTION = 1.9

type Data = pd.DataFrame | Iterable[TrialResult]


def plot_comparison(
    runs: Data,
    metric: str | None = None,
    *,
    by: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draws bars of a metric's mean over runs, with confidence intervals.

    The intervals are 95 % intervals. Dots are single runs, for at most 200
    runs per bar. Runs without a value do not count. Rates are in percent. Runs
    whose seeds draw nothing count once, without an interval, and with a note.
    See `hunav_drake.runs.statistics.summarize`.

    Args:
        runs: Results, or a table with a row per run: see `ReadRuns`.
        metric: A column of the table; by default the first headline metric
            that has values, which is how many runs arrive if there are goals.
        by: The column to compare, with a bar for each value. By default
            planners, with separate settings, in each scenario.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the table has no such column.
    """
    table, metric, by = _prepared(runs, metric, by)
    statistics = summarize(table, by, metrics=metric, bounded=True)
    statistics = statistics.droplevel("metric")
    unit, factor = _shown_unit(table, metric)
    table = table.assign(**{metric: factor * table[metric]})
    statistics[["mean", "low", "high"]] *= factor
    ax = new_axes(ax, comparison_height(len(statistics)))
    rows = range(len(statistics))
    ax.barh(
        rows,
        statistics["mean"].fillna(0.0),
        height=0.62,
        color=list(_colors(statistics.index, table, by)),
        alpha=0.55,
    )
    for row, (name, values) in zip(rows, statistics.iterrows(), strict=True):
        samples = table.loc[table[by] == name, metric]
        _draw_dots(ax, row, samples[np.isfinite(samples)])
        _draw_interval(ax, row, values, "mean")
    if statistics["mean"].isna().all():
        note(ax, "there are no values")
    values = table[metric].to_numpy(dtype=float)
    if not (values < 0).any():
        # An axis needs a length even if all values are 0.
        is_wide = (values > 0).any() or (statistics["high"] > 0).any()
        ax.set_xlim(left=0, right=None if is_wide else 1)
    _label_values(ax, label_text(metric, unit))
    fixed = draws_nothing(table).groupby(table[by]).all()
    _label(
        ax,
        {
            str(it): ["all seeds alike"] * bool(fixed[it])
            for it in statistics.index
        },
    )
    return ax


def plot_differences(
    runs: Data,
    metric: str | None = None,
    *,
    reference: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draws how planners differ from one of them on equal seeds.

    A row has the mean difference, planner minus reference, with its 95 %
    confidence interval; dots are the differences of single pairs, for at most
    200 pairs. The interval is thick where one of the two is better. If one of
    them does not arrive in a pair, that pair counts for rates only. See
    `hunav_drake.runs.statistics.compare`.

    Args:
        runs: Results, or a table with a row per run: see `ReadRuns`.
        metric: A column of the table; by default as in `plot_comparison`.
        reference: The planner, with its setting, from which the others
            differ, as `plot_comparison` names it; by default the first.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the table has no such column or reference.
    """
    table, metric, _ = _prepared(runs, metric, "contender")
    for column in ("planner", "seed"):
        if column not in table:
            raise ValueError(
                f"the table of runs has no column {column!r}, and differences"
                " are of planners on equal seeds"
            )
    names = list(dict.fromkeys(table["contender"]))
    first = names[0] if reference is None else reference
    if first not in names:
        raise ValueError(
            f"reference: no run is of {quoted(first)}; there are"
            f" {', '.join(map(quoted, names))}"
        )
    scenarios = list(dict.fromkeys(table["scenario"]))
    rows = {
        ", ".join([name, *[str(it)] * (len(scenarios) > 1)]): (name, it)
        for it in scenarios
        for name in names
        if name != first
    }
    unit, factor = _shown_unit(table, metric)
    ax = new_axes(ax, comparison_height(len(rows)))
    colors = _colors([name for name, _ in rows.values()], table, "contender")
    notes: dict[str, list[str]] = {}
    for row, ((label, (name, scenario)), color) in enumerate(
        zip(rows.items(), colors, strict=True)
    ):
        pairs = comparable(table[table["scenario"] == scenario], "contender")
        try:
            given = pairs, first, name
            found = compare(*given, on="contender", metrics=metric).iloc[0]
            gaps = factor * differences(*given, metric, on="contender")
        except ValueError:
            notes[label] = ["no equal seeds"]
            continue
        notes[label] = ["no pair has both"] if not len(gaps) else []
        found = found.copy()
        found[["difference", "low", "high"]] *= factor
        sure = found["better"] is not None
        _draw_dots(ax, row, pd.Series(gaps))
        ax.plot(found["difference"], row, "D", ms=4, color=color, zorder=3)
        _draw_interval(ax, row, found, "difference", 2.4 if sure else 1.0)
    ax.axvline(0.0, color="0.6", lw=0.8, zorder=0)
    if not rows:
        note(ax, "there is one planner only")
    title = f"{metric}, difference from {shown(first)}"
    _label_values(ax, label_text(title, unit))
    _label(ax, notes)
    return ax


def plot_distribution(
    runs: Data,
    metric: str | None = None,
    *,
    by: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draws the share of runs in which a metric is at most a value.

    This is the empirical distribution function, as `scipy.stats.ecdf` has it,
    with a line for each planner. A run that never arrives is later than any
    time to the goal, so such a line ends below 100 %. Of other metrics, only
    runs with a value count. The legend has the number of runs that count: a
    seed counts once.

    Args:
        runs: Results, or a table with a row per run: see `ReadRuns`.
        metric: A column of the table; by default as in `plot_comparison`.
        by: The column to compare, as in `plot_comparison`.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the table has no such column.
    """
    table, metric, by = _prepared(runs, metric, by)
    kinds = list(dict.fromkeys(table[by]))
    unit, factor = _shown_unit(table, metric)
    ax = new_axes(ax, distribution_height(len(kinds)))
    found = {
        kind: factor * np.sort(_values(table[table[by] == kind], metric))
        for kind in kinds
    }
    ends = np.concatenate(list(found.values()))
    ends = ends[np.isfinite(ends)]
    low, high = (ends.min(), ends.max()) if len(ends) else (0.0, 1.0)
    room = 0.04 * (high - low) or 0.05 * abs(high) or 1.0
    styles = line_styles(len(kinds))
    scenarios = dict(zip(table[by], table["scenario"], strict=True))
    dashes = dict(zip(dict.fromkeys(scenarios.values()), DASHES, strict=False))
    few = table["scenario"].nunique() <= len(DASHES)
    if by == "place" and few and table["contender"].nunique() <= len(PALETTE):
        # A contender has one color, as in other plots; a scenario its dashes.
        styles = [
            {"color": color, "ls": dashes[scenarios[kind]]}
            for kind, color in zip(
                kinds, _colors(kinds, table, by), strict=True
            )
        ]
    labels = shown_apart(map(str, found))
    for values, label, style in zip(
        found.values(), labels, styles, strict=True
    ):
        finite = values[np.isfinite(values)]
        shares = np.arange(len(finite) + 1) / max(1, len(values))
        ax.step(
            [low - room, *finite, high + room] if len(values) else [],
            100 * np.array([*shares, shares[-1]] if len(values) else []),
            where="post",
            lw=1.2,
            label=f"{label} (n = {len(values)})",
            **style,
        )
    if not len(ends):
        note(ax, "there are no values")
    ax.set(xlim=(low - room, high + room), ylim=(-2, 102))
    _label_values(ax, label_text(metric, unit))
    ax.set_ylabel("runs at most there (%)")
    legend_outside(ax, columns=3)
    return ax


def comparison_height(bars: int) -> float:
    """Returns the height of the figure for a number of bars, in inches."""
    return 0.55 + 0.24 * max(2, bars)


def distribution_height(lines: int) -> float:
    """Returns the height of the figure for a number of lines, in inches."""
    return _DISTRIBUTION + 0.14 * lines


def default_metric(table: pd.DataFrame) -> str:
    """Returns the first headline metric that has a value in a table of runs.

    Raises:
        ValueError: If there is none.
    """
    for base in HEADLINE:
        for name in table.columns:
            if base_name(name) == base and np.isfinite(table[name]).any():
                return str(name)
    raise ValueError(
        "the table of runs has no headline metric with a value; name a metric"
    )


def _prepared(
    runs: Data, metric: str | None, by: str | None
) -> tuple[pd.DataFrame, str, str]:
    """Returns the table of runs, the metric, and the column to compare."""
    table = runs if isinstance(runs, pd.DataFrame) else tabulate_runs(runs)
    check_any(table)
    table = with_numbers(with_names(table), metric)
    if metric is None:
        metric = default_metric(table)
    if "scenario" not in table:
        table = table.assign(scenario="")
    if "planner" in table and "contender" not in table:
        table = table.assign(contender=contenders(table))
    if by is None:
        by = "contender"
        if by in table and table["scenario"].nunique() > 1:
            by = "place"
            places = table["contender"] + ", " + table["scenario"].astype(str)
            table = table.assign(place=places)
    if "contender" not in table:
        by = "planner" if by == "contender" else by
    check_columns(table, [metric, by])
    return table, metric, by


def _values(runs: pd.DataFrame, metric: str) -> Array:
    """Returns the values of a metric; infinity for a goal never reached."""
    columns = [metric, *arrival_rates(runs)]
    once = once_per_seed(runs, [], list(dict.fromkeys(columns)))
    values: Array = once[metric].to_numpy(dtype=float)
    if base_name(metric) in TIMES:
        values = np.where(arrivals(once, metric) < 1, np.inf, values)
        return values[~np.isnan(values)]
    return values[np.isfinite(values)]


def _shown_unit(table: pd.DataFrame, metric: str) -> tuple[str, float]:
    """Returns the unit in which a metric is drawn, and the factor to it."""
    return ("%", 100.0) if is_rate(metric) else (unit_of(table, metric), 1.0)


def _colors(
    kinds: Iterable[object], table: pd.DataFrame, by: str
) -> Iterable[str]:
    """Yields the color of each kind: a contender has one in all scenarios."""
    key = "contender" if by == "place" else by
    of_kind = dict(zip(table[by], table[key], strict=True))
    names = list(dict.fromkeys(table[key]))
    for kind in kinds:
        yield PALETTE[names.index(of_kind[kind]) % len(PALETTE)]


def _draw_dots(ax: Axes, row: int, samples: pd.Series) -> None:
    if len(samples) > _MOST_DOTS:
        return
    # Shifted, so that equal values do not hide each other.
    spread = np.linspace(-0.2, 0.2, len(samples) + 2)[1:-1]
    ax.plot(samples, row + spread, ".", ms=3, color="0.25", mew=0)


def _draw_interval(
    ax: Axes, row: int, values: pd.Series, middle: str, width: float = 1.2
) -> None:
    if pd.isna(values["low"]) or pd.isna(values["high"]):
        return
    # A float is not always the mean of its copies.
    reach = [
        [max(0.0, values[middle] - values["low"])],
        [max(0.0, values["high"] - values[middle])],
    ]
    ax.errorbar(
        values[middle], row, xerr=reach, color="black", lw=width, capsize=3
    )


def _label_values(ax: Axes, text: str) -> None:
    """Writes the name of the axis of values, apart from its power of ten."""
    # A long name has more room when it is aligned to the right.
    ax.set_xlabel(text, loc="right", parse_math=False)
    ax.xaxis.get_offset_text().set(x=0.0, ha="left", size=SMALL_SIZE)


def _label(ax: Axes, notes: dict[str, list[str]]) -> None:
    """Writes the name of each row: a planner, its setting, and notes."""
    parts = [name.partition(", ") for name in notes]
    heads = shown_apart(it[0] for it in parts)
    tails = shown_apart(it[2] for it in parts)
    rows = zip(heads, tails, notes.values(), strict=True)
    label_rows(
        ax, ["\n".join(filter(None, [a, b, *more])) for a, b, more in rows]
    )
