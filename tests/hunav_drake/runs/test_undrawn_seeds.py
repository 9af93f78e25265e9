"""Cells in which seeds draw nothing, and why runs do not arrive."""

import dataclasses
import json
import math

import numpy as np
import pandas as pd
import pytest

from hunav_drake import (
    LoadScenario,
    LoadSuite,
    ReadRuns,
    RunSuite,
    RunTrial,
    Suite,
    SuiteResult,
    compare,
    plot_comparison,
    summarize,
)
from hunav_drake.commands import cli
from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs.cell_plan import CellPlan
from hunav_drake.runs.comparison.relations import judge
from hunav_drake.runs.comparison.tables import ENDS, scenario_tables
from hunav_drake.runs.outcomes import count_outcomes
from hunav_drake.runs.suite import Relation
from hunav_drake.views.suite_replays import WriteReplays
from tests.hunav_drake.runs.made_runs import make_cell, make_result, runs_of

TRIAL = """\
name: bare
robot: {goal: [0.5, 0, 0]}
humans: [{pose: [3, 2, 0]}]
simulation: {duration: 4.0}
"""
SUITE = """\
name: seeds
scenarios: [bare.yaml]
planners: [pursuit]
seeds: [4, 2, 9]
repetitions: 2
settings: {fixed: [], drawn: [simulation.start_jitter=0.1]}
"""
BLOCKED = "world={walls: [{type: box, center: [0.9, 0], size: [0.2, 6]}]}"


@pytest.fixture
def suite(tmp_path):
    (tmp_path / "bare.yaml").write_text(TRIAL)

    (tmp_path / "seeds.yaml").write_text(SUITE)
    return tmp_path / "seeds.yaml"


@pytest.mark.slow
def test_a_cell_in_which_nothing_is_drawn_is_run_once(suite):
    result = RunSuite(LoadSuite(filename=suite), folder=suite.parent, workers=1)
    runs = result.runs()
    by_setting = runs.groupby("setting")
    assert by_setting.size().to_dict() == {"fixed": 1, "drawn": 6}
    assert by_setting.drawn.first().to_dict() == {
        "fixed": "nothing",
        "drawn": "start jitter",
    }
    assert runs[runs.setting == "fixed"].seed.tolist() == [4]
    summary = result.summary().loc["bare", "pursuit"]
    assert summary.loc[("fixed", "completed"), ["n", "mean"]].tolist() == [1, 1]
    assert summary.loc["fixed"][["low", "high"]].isna().all(axis=None)
    assert summary.loc[("drawn", "completed"), "n"] == 3
    (line,) = result.same_seeds()
    assert line.startswith("bare (fixed): nothing is drawn, all seeds give")
    assert "set simulation.start_jitter" in line
    page = WriteSuite(result, suite.parent / "out").read_text()
    assert "Nothing is drawn with pursuit, fixed: all seeds give" in page
    fixed = next(t for t in scenario_tables(result) if "fixed" in t.title)
    assert ("completed", "100 (1)", "%") in fixed.rows


@pytest.mark.slow
def test_equal_runs_of_tables_set_below_each_other_count_once(suite):
    """Their rows may have one index; another order changes nothing."""
    runs = RunSuite(LoadSuite(filename=suite), folder=suite.parent, workers=1)
    fixed = runs.runs().query("setting == 'fixed'")
    copy = fixed.assign(seed=2)
    for both in (pd.concat([fixed, copy]), pd.concat([copy, fixed])):
        assert not both.index.is_unique
        table = summarize(both).xs("completed", level="metric")
        assert table["n"].tolist() == [1]


@pytest.mark.slow
def test_each_seed_of_a_suite_has_its_own_people(tmp_path):
    text = (
        f"{TRIAL}population: {{cohorts: [{{number: 3, start: [{{rectangle:"
        " [2, -4, 8, -1]}]}]}\n"
    )
    (tmp_path / "bare.yaml").write_text(text)
    suite = Suite(scenarios=["bare.yaml"], planners=["pursuit"], seeds=[3, 1])
    runs = RunSuite(suite, folder=tmp_path, out=tmp_path / "out", workers=1)
    assert (runs.runs().drawn == "population").all()
    scenario = LoadScenario(filename=tmp_path / "bare.yaml")
    for row in runs.rows:
        expected = RunTrial(scenario, row.seed).metrics
        assert (
            row.metrics["min_dist_to_people"]
            == (expected["min_dist_to_people"])
        )
    (replay,) = WriteReplays(runs, tmp_path / "out", workers=1)
    assert replay.name == "bare_pursuit_3.html"


@pytest.mark.slow
def test_a_report_on_runs_counts_equal_ones_once(tmp_path, capsys):
    (tmp_path / "bare.yaml").write_text(TRIAL)
    words = ["run", str(tmp_path / "bare.yaml"), "--out", str(tmp_path)]
    for seed in ("0", "1", "2"):
        assert cli.main([*words, "--seed", seed, "--no-replay"]) == 0
    told = "hunav: note: nothing is drawn at random, so all seeds give the same"
    assert capsys.readouterr().err.count(told) == 3
    runs = ReadRuns(tmp_path)
    assert runs.drawn.tolist() == ["nothing"] * 3
    assert (summarize(runs)["n"].dropna() <= 1).all()
    assert cli.main(["report", str(tmp_path)]) == 0
    page = " ".join((tmp_path / "report.html").read_text().split())
    assert "Nothing is drawn with pursuit: all seeds give the same" in page
    assert ">n&nbsp;=&nbsp;1<" in page
    again = ReadRuns(tmp_path / "runs.csv")
    assert (summarize(again)["n"].dropna() <= 1).all()


@pytest.mark.parametrize(
    ("fields", "runs"),
    [
        ({}, [(s, k) for s in (4, 2, 9) for k in (0, 1)]),
        ({"drawn": "nothing", "once": True}, [(4, 0)]),
        # Whether a planner of one's own repeats itself is to be seen.
        ({"drawn": "nothing"}, [(4, 0), (4, 1)]),
    ],
)
def test_repetitions_are_for_planners_of_ones_own(fields, runs):
    cell = dataclasses.replace(make_cell("bare", "a"), **fields)
    suite = Suite(scenarios=["bare"], seeds=[4, 2, 9], repetitions=2)
    plan = CellPlan(cell, suite, ())
    given = []
    while task := plan.next_task():
        given += task.runs
    assert given == runs
    assert plan.total == len(runs)


@pytest.mark.slow
def test_bench_tells_why_runs_do_not_arrive(suite, capsys):
    words = ["bench", str(suite), "--out", str(suite.parent), "--workers", "1"]
    changes = [BLOCKED, "robot.goal=[2, 0, 0]", "simulation.stuck_time=1.0"]
    for change in changes:
        words += ["--set", change]
    assert cli.main([*words, "--quiet"]) == 0
    out = capsys.readouterr().out
    assert "7 runs ended: stuck 7\n" in out
    assert "\nbare/pursuit/fixed: stuck 1\n    stuck: the robot no lon" in out
    assert "\nbare (fixed): nothing is drawn" in out
    about = json.loads((suite.parent / "seeds" / "suite.json").read_text())
    told = [(it["end_reason"], it["count"]) for it in about["outcomes"]]
    assert told == [("stuck", 1), ("stuck", 6)]
    report = (suite.parent / "seeds" / "report.html").read_text()
    assert "7 runs, scenario bare, planner pursuit, 2 settings" in report
    assert "the robot no longer gets anywhere" in report
    table = (suite.parent / "seeds" / "outcomes.csv").read_text()
    assert "the robot no longer gets anywhere" in table


def test_outcomes_are_counted_with_what_most_tell():
    arrived = [1.0, 0.0, 0.0, 1.0, 0.0]
    runs = make_result(
        {("hall", "a"): runs_of([9.0, 1.0, 2.0, 3.0, 4.0], arrived)}
    ).runs()
    runs.loc[2, "end_message"] = "somebody"
    table = count_outcomes(runs, ["planner"])
    assert table.values.tolist() == [
        ["a", "goal", 2, 5, ""],
        ["a", "stuck", 3, 5, "a wall, 1.00 m off (2 of 3 say so)"],
    ]
    (page,) = scenario_tables(make_result({("hall", "a"): runs_of([1.0])}))
    assert page.rows[-1] == (ENDS, "goal 1", "")


def test_equal_runs_count_once_where_nothing_is_drawn():
    runs = make_result(
        {
            ("hall", "a"): runs_of([9.0] * 4),
            ("hall", "b"): runs_of([9.0, 9.0, 8.0, 9.0]),
        }
    ).runs()
    known = summarize(runs)
    assert (known["n"] == 4).all()
    runs["drawn"] = "nothing"
    table = summarize(runs).xs("completed", level="metric").droplevel(0)
    # Those of b are not what they should be; nobody hides that.
    assert table["n"].tolist() == [1, 2]
    assert table["low"].isna().tolist() == [True, False]
    ax = plot_comparison(runs[runs.planner == "a"], "path_length")
    (label,) = (it.get_text() for it in ax.get_yticklabels())
    assert "all seeds alike" in label
    assert len(ax.containers) == 1


def one_beside_drawn(lengths, fixed="a"):
    """Returns runs of a planner of which nothing is drawn, and of another."""
    other = {"a": "b", "b": "a"}[fixed]
    paths = {fixed: [5.0], other: lengths}
    result = make_result(
        {
            ("hall", name): [
                {"path_length": it, "completed": 1.0} for it in paths[name]
            ]
            for name in ("a", "b")
        },
        relations=[
            Relation(scenarios=["hall"], metric="path_length", holds=holds)
            for holds in ("a < b", "b < a", "(a * 0.5 < b) & (b * 0.5 < a)")
        ],
    )
    return drawing(
        result, lambda it: "nothing" if it.planner == fixed else "noise"
    )


def drawing(result, drawn):
    """Returns a result whose runs draw what a function tells of each."""
    cells = [dataclasses.replace(it, drawn=drawn(it)) for it in result.cells]
    rows = [it._replace(drawn=drawn(it)) for it in result.rows]
    return SuiteResult(result.suite, cells, rows)


@pytest.mark.parametrize(("fixed", "sign"), [("a", 1), ("b", -1)])
def test_a_run_of_which_nothing_is_drawn_stands_for_every_seed(fixed, sign):
    lengths = [4.0, 6.0, 6.0, 6.0]
    result = one_beside_drawn(lengths, fixed)
    compared = compare(result.runs(), "a", "b").loc["hall", "path_length"]
    assert compared["n"] == 4
    assert compared[["a", "b"]].tolist() == [5.0, 5.5][::sign]
    assert compared["difference"] == sign * 0.5
    by_hand = result.runs().assign(drawn="noise").to_dict("records")
    (run,) = (it for it in by_hand if it["planner"] == fixed)
    by_hand += [{**run, "seed": seed} for seed in (1, 2, 3)]
    expected = compare(pd.DataFrame(by_hand), "a", "b")
    pd.testing.assert_series_equal(
        compared, expected.loc["hall", "path_length"]
    )
    judged = judge(result)
    if fixed == "b":
        judged[:2] = judged[1::-1]
    assert [it.verdict for it in judged] == ["mean only", "fails", "holds"]
    # Of four, at least three of the drawn ones must be 6: 0.74 of samples.
    assert judged[0].share == pytest.approx(0.7383, abs=0.04)
    assert judged[2].share == 1
    assert "5.5" in judged[0].numbers
    assert "(n = 4)" in judged[0].numbers


def test_a_seed_that_draws_something_tells_no_share():
    result = one_beside_drawn([6.0, math.nan, math.nan])
    judged = judge(result)
    assert [it.verdict for it in judged] == ["mean only", "fails", "mean only"]
    assert np.isnan([it.share for it in judged]).all()
    both = SuiteResult(result.suite, result.cells, result.rows[:2])
    (first, *_) = judge(drawing(both, lambda it: "nothing"))
    assert (first.verdict, first.share) == ("holds", 1)


def test_two_runs_of_which_nothing_is_drawn_are_one_pair():
    runs = one_beside_drawn([6.0] * 3).runs().assign(drawn="nothing")
    runs.loc[runs.planner == "a", "seed"] = 7
    assert (compare(runs, "a", "b")["n"] == 1).all()


def test_a_run_stands_for_the_seeds_of_its_own_scenario():
    runs = one_beside_drawn([4.0, 6.0, 6.0, 6.0]).runs()
    yard = runs.assign(scenario="yard", seed=runs.seed + 5)
    compared = compare(pd.concat([runs, yard[:-1]]), "a", "b")
    counts = compared.xs("path_length", level="metric")["n"]
    assert counts.to_dict() == {"hall": 4, "yard": 3}
