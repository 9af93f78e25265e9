"""Who arrives seldom is not better for the way of those who do."""

import math
import re

import numpy as np
import pytest

from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs import Suite, SuiteResult
from hunav_drake.runs.comparison.latex import to_latex
from hunav_drake.runs.comparison.markdown import to_markdown
from hunav_drake.runs.comparison.relations import judge
from hunav_drake.runs.comparison.tables import (
    ENDS,
    behavior_tables,
    scenario_tables,
    to_text,
)
from hunav_drake.runs.intervals import wilson_interval
from hunav_drake.runs.statistics import compare
from hunav_drake.runs.suite import Relation
from tests.hunav_drake.report.pages import visible
from tests.hunav_drake.runs.made_runs import (
    make_cell,
    make_result,
    make_row,
    runs_of,
)

SEEDS = 40

# Every fourth seed is easy. One planner arrives always; the other is 2 %
# slower, and arrives in those.
EASY = np.arange(SEEDS) % 4 == 0
TIMES = np.where(EASY, 18.0, 38.0) + 0.01 * np.arange(SEEDS)


@pytest.fixture(scope="module")
def result():
    return make_result(
        {
            ("hall", "good"): runs_of(TIMES.tolist()),
            ("hall", "seldom"): runs_of((1.02 * TIMES).tolist(), EASY * 1.0),
        },
        relations=[
            Relation(
                scenarios=["hall"],
                metric="time_to_reach_goal",
                holds="seldom < good",
            ),
            Relation(
                scenarios=["hall"], metric="completed", holds="seldom < good"
            ),
        ],
    )


def test_planners_are_compared_where_both_arrive(result):
    compared = compare(result.runs(), "good", "seldom").loc["hall"]
    for name in ("time_to_reach_goal", "path_length"):
        row = compared.loc[name]
        assert (row["n"], row["pairs"]) == (10, "both arrive")
        assert row["better"] == "good"
        assert row["b"] == pytest.approx(1.02 * row["a"])
    row = compared.loc["completed"]
    assert (row["n"], row["pairs"], row["better"]) == (SEEDS, "all", "good")


def test_where_hardly_any_pair_arrives_there_is_no_verdict():
    never = make_result(
        {
            ("hall", "good"): runs_of(TIMES.tolist()),
            ("hall", "never"): runs_of(TIMES.tolist(), [0.0] * SEEDS),
        }
    )
    compared = compare(never.runs(), "good", "never").loc["hall"]
    for name in ("time_to_reach_goal", "path_length"):
        row = compared.loc[name]
        assert (row["n"], row["pairs"], row["better"]) == (
            0,
            "both arrive",
            None,
        )
        assert math.isnan(row["difference"])
    assert compared.loc["completed", "better"] == "good"


def two(arrived, shift=1.0, metric="path_length"):
    """Returns two planners that arrive in the same seeds."""
    return make_result(
        {
            ("hall", "a"): runs_of(TIMES.tolist(), arrived),
            ("hall", "b"): runs_of((TIMES + shift).tolist(), arrived),
        },
        relations=[Relation(scenarios=["hall"], metric=metric, holds="a < b")],
    )


def test_who_fails_in_the_same_seeds_is_compared_in_the_others():
    # Where they fail, one comes farther before it does.
    made = two(EASY * 1.0)
    for row in made.rows[:SEEDS]:
        assert row.metrics["path_length"] == 1.0 or EASY[row.seed]
    compared = compare(made.runs(), "a", "b").loc["hall"]
    for name in ("time_to_reach_goal", "path_length"):
        row = compared.loc[name]
        assert (row["n"], row["pairs"]) == (10, "both arrive")
        assert row["better"] == "a"
    assert compared.loc["completed", "pairs"] == "all"
    (judgement,) = judge(made)
    assert judgement.verdict == "holds"
    assert "on the 10 of 40 seeds in which all arrive" in judgement.numbers


def test_where_nobody_arrives_no_way_is_better():
    none = two([0.0] * SEEDS)
    for row in none.rows[:SEEDS]:
        row.metrics["path_length"] = 0.5
    compared = compare(none.runs(), "a", "b").loc["hall"]
    assert compared.loc["path_length", ["n", "better"]].tolist() == [0, None]
    (judgement,) = judge(none)
    assert judgement.verdict == "not tested"
    assert "path_length in seeds in which all arrive" in judgement.numbers


def test_where_all_arrive_or_there_is_no_goal_all_pairs_count():
    for arrived in (None, [math.nan] * SEEDS):
        made = two(arrived)
        compared = compare(made.runs(), "a", "b").loc["hall"]
        assert set(compared["pairs"]) == {"all"}
        assert compared.loc["path_length", "n"] == SEEDS
        assert "(n = 40)" in judge(made)[0].numbers


@pytest.mark.parametrize(
    ("values", "text"),
    [
        # What the mean's decimals would hide.
        ([1500.0, 1500.1, 1500.2, 1500.3, 1500.4, 1500.5], "1500 ± 0.196 (6)"),
        ([50.0, 50.001, 50.002], "50.00 ± 0.002 (3)"),
        ([20.0, 21.0, 22.0], "21.00 ± 2.48 (3)"),
        # Equal ones, and rounding.
        ([1500.0] * 6, "1500 (6)"),
        ([1e6, 1e6 + 1e-9, 1e6], "1.0e+06 (3)"),
    ],
)
def test_a_mean_has_no_interval_only_where_all_are_equal(values, text):
    made = make_result({("hall", "a"): [{"path_length": v} for v in values]})
    (table,) = scenario_tables(made)
    assert [row[1] for row in table.rows if row[0] == "path_length"] == [text]


def test_relations_are_judged_where_all_arrive_and_say_so(result):
    times, rates = judge(result)
    assert times.verdict == "fails"
    assert "on the 10 of 40 seeds in which all arrive" in times.numbers
    assert "(n = 10)" in times.numbers
    assert (rates.verdict, rates.numbers) == (
        "holds",
        "seldom 0.25, good 1 (n = 40)",
    )


def test_each_cell_tells_n_and_marks_ways_that_end_early(result):
    (table,) = scenario_tables(result)
    rows = {row[0]: row[1:] for row in table.rows}
    low, high = (100 * end for end in wilson_interval(10, 40))
    assert rows["completed"][1] == f"25 [{low:.0f}, {high:.0f}] (40)"
    good, seldom = rows["time_to_reach_goal"][:2]
    assert good.endswith(" (40)")
    assert seldom.endswith(" (10)")
    good, seldom = rows["path_length"][:2]
    assert good.endswith(" (40)")
    assert seldom.endswith(" (40)*")
    assert rows.pop(ENDS)[:2] == ("goal 40", "goal 10, stuck 30")
    for row in rows.values():
        for text in row[:-1]:
            assert re.search(r" \(\d+\)\*?$", text)


@pytest.mark.slow
def test_all_tables_say_the_same(result, tmp_path):
    (table,) = scenario_tables(result)
    page = visible(WriteSuite(result, tmp_path).read_text())
    markdown = to_markdown(result, "hunav bench hall").replace(r"\*", "*")
    latex = to_latex(table).replace(r"$\pm$", "±")
    for row in table.rows:
        for text in row[1:3]:
            assert text in to_text(table)
            assert text in latex
            # The page has the ends of intervals, not half their width.
            mean = text.split(" ")[0].removesuffix("(40)")
            assert f" {mean}" in page
            # It tells n once, where it is the same in all cells.
            assert f"| {text.replace(' (40)', '')} |" in markdown
    assert "with 40 seeds for each cell (" in markdown
    WriteSuite(result, tmp_path)
    summary = (tmp_path / "summary.csv").read_text().splitlines()
    header = summary[0].split(",")
    for planner, arrived in (("good", 40), ("seldom", 10)):
        (line,) = (
            dict(zip(header, line.split(","), strict=True))
            for line in summary
            if f",{planner},," in line and ",path_length," in line
        )
        assert (line["n"], float(line["arrived"])) == ("40", arrived)


def test_runs_without_a_result_have_not_arrived():
    lost = make_result({("hall", "a"): [*runs_of([10.0, 11.0, 12.0]), None]})
    summary = lost.summary().droplevel(["scenario", "planner", "setting"])
    assert (summary.loc["completed", ["n", "mean"]] == [4, 0.75]).all()
    assert summary.loc["time_to_reach_goal", "n"] == 3
    none = make_result({("hall", "a"): [None, None]})
    (table,) = scenario_tables(none)
    assert [row[:2] for row in table.rows] == [
        ("completed", "0 [0, 66] (2)"),
        (ENDS, "worker_died 2"),
    ]


def test_the_page_of_markdown_tells_how_many_seeds_there_are():
    def page(seeds, **suite):
        runs = {("hall", p): runs_of(TIMES[:n].tolist()) for p, n in seeds}
        return to_markdown(make_result(runs, **suite), "hunav bench x")

    assert "with 1 seed for each cell (" in page([("a", 1)])
    assert "with 4 seeds for each cell (" in page([("a", 4), ("b", 4)])
    # As where `until` has ended some.
    assert "with 6 to 16 seeds for each" in page([("a", 6), ("b", 16)])
    twice = make_result(
        {("hall", "a"): runs_of([10.0, 10.0, 11.0, 11.0])}, repetitions=2
    )
    text = to_markdown(twice, "hunav bench x")
    assert "with 2 seeds for each cell, each 2 times (" in text


def test_the_page_of_markdown_tells_what_planners_cost_people():
    def row(delay, charged, gap):
        return {
            "completed": 1.0,
            "aggregated_time": delay,
            "contacts_charged": charged,
            "min_gap_exact": gap,
        }

    runs = {
        ("hall", "a"): [row(1.0, 0.0, 0.4), row(2.0, 1.0, -0.02)],
        ("hall", "b"): [row(-0.001, 0.0, 0.5), row(math.nan, 0.0, 0.3)],
        ("door", "a"): [row(math.nan, 2.0, 0.01)] * 2,
        ("door", "b"): [row(3.5, 0.0, 0.2)] * 2,
    }
    page = to_markdown(make_result(runs), "hunav bench x")
    _, _, page = page.partition("## Responsibility")
    assert "| aggregated time (s) | a | b |" in page
    assert "| hall | 1.50 | 0.00 |" in page
    assert "| door |  | 3.50 |" in page
    assert "| a | 5 | -0.020 m in hall, seed 1 |" in page
    assert "| b | 0 | 0.200 m in door, seed 0 |" in page
    plain = make_result({("hall", "a"): runs_of([10.0])})
    assert "Responsibility" not in to_markdown(plain, "hunav bench x")


NAN = {"completed": math.nan, "path_length": math.nan}


@pytest.mark.parametrize(
    "values",
    [
        {("hall", "a"): runs_of([10.0])},
        {("hall", "a"): runs_of([10.0] * 7), ("hall", "b"): runs_of([9.0] * 7)},
        {("hall", "a"): [None] * 7, ("hall", "b"): [None] * 7},
        {("hall", "a"): [None] * 7, ("hall", "b"): runs_of([9.0] * 7)},
        {("hall", "a"): [NAN] * 7, ("hall", "b"): runs_of([9.0] * 7)},
        {("hall", "a"): [NAN] * 2, ("hall", "b"): [NAN] * 2},
        {
            ("hall", "a"): runs_of([10.0] * 7, [0.0] * 7),
            ("hall", "b"): runs_of([9.0] * 7, [0.0] * 7),
        },
        # Cells without runs, as of a suite that was stopped.
        {
            ("hall", "a"): runs_of([10.0] * 7),
            ("hall", "b"): [],
            ("yard", "a"): [],
        },
        {("hall", "a"): [], ("yard", "a"): runs_of([10.0, 12.0])},
    ],
    ids=[
        *("one run", "equal runs", "all failed", "one failed", "one NaN"),
        *("all NaN", "none arrives", "missing cells", "first cell missing"),
    ],
)
def test_whatever_the_runs_are_all_is_written(values, tmp_path):
    relations = [
        Relation(scenarios=["hall"], metric=metric, holds=f"a {sign} b")
        for metric in ("path_length", "completed", "time_to_reach_goal")
        for sign in ("<", ">=")
    ]
    made = make_result(values, relations=relations, identities=True)
    judgements = judge(made)
    for it in judgements[-6::2]:
        assert it.verdict in ("holds", "mean only", "fails", "not tested")
    for one, other in zip(judgements[-6::2], judgements[-5::2], strict=True):
        # Not both, and of NaN neither.
        assert {"holds"} != {one.verdict, other.verdict}
        tested = [it.verdict != "not tested" for it in (one, other)]
        assert tested[0] == tested[1]
    WriteSuite(made, tmp_path, judgements)
    page = to_markdown(made, "hunav bench x")
    text = "\n".join(map(to_text, scenario_tables(made)))
    tex = (tmp_path / "tables.tex").read_text()
    for told in (page, text, tex):
        assert not re.search(r"\bnan\b", told, re.IGNORECASE)


def test_tables_of_several_robots_have_their_metrics():
    one = {"completed": 1.0, "path_length": 8.0}
    fleet = {
        "anna.completed": 1.0,
        "anna.path_length": 7.0,
        "anna.min_dist_to_people": 0.5,
        "makespan": 20.0,
        "min_dist_between_robots": 0.4,
    }
    made = make_result({("hall", "p"): [one] * 2, ("lobby", "p"): [fleet] * 2})
    hall, lobby = (
        {row[0]: row[1] for row in table.rows}
        for table in scenario_tables(made)
    )
    assert hall["path_length"].startswith("8")
    assert "makespan" not in hall
    assert lobby["makespan"].startswith("20")
    assert lobby["anna.min_dist_to_people"].startswith("0.5")
    assert not any(text.startswith("-") for text in lobby.values())


def test_tables_of_several_robots_have_the_metrics_that_were_chosen():
    values = {
        ("hall", "p"): [{"path_length": 8.0}] * 2,
        ("lobby", "p"): [{"anna.path_length": 7.0, "bob.path_length": 6.0}] * 2,
    }
    hall, lobby = scenario_tables(make_result(values))
    assert [row[0] for row in hall.rows] == ["path_length", ENDS]
    assert [row[:2] for row in lobby.rows[:-1]] == [
        ("anna.path_length", "7.00 (2)"),
        ("bob.path_length", "6.00 (2)"),
    ]


def test_tables_by_behavior_of_several_robots_have_those_of_each_robot():
    cells = make_cell("hall", "p"), make_cell("lobby", "p")
    common = {"min_dist_between_robots": 0.4}
    by_behavior = [
        {
            name: {"min_dist_to_people": gap, "social_work": 2.0}
            for name, gap in (("calm", 0.5), ("curious", 0.3))
        },
        {
            name: {"anna.min_dist_to_people": gap, **common}
            for name, gap in (("calm", 0.6), ("curious", 0.2))
        },
    ]
    rows = [
        make_row(cell, seed, {}, by_behavior=values)
        for cell, values in zip(cells, by_behavior, strict=True)
        for seed in range(2)
    ]
    suite = Suite(scenarios=["hall", "lobby"], seeds=2)
    tables = behavior_tables(SuiteResult(suite, cells, rows))
    assert [
        (table.title, row[0], row[1]) for table in tables for row in table.rows
    ] == [
        ("hall, calm people", "min_dist_to_people", "0.500 (2)"),
        ("hall, calm people", "social_work", "2.00 (2)"),
        ("hall, curious people", "min_dist_to_people", "0.300 (2)"),
        ("hall, curious people", "social_work", "2.00 (2)"),
        ("lobby, calm people", "anna.min_dist_to_people", "0.600 (2)"),
        ("lobby, curious people", "anna.min_dist_to_people", "0.200 (2)"),
    ]
