"""Captions, and tables of chosen metrics for LaTeX."""

import re

import pandas as pd
import pytest

from hunav_drake.runs.comparison.captions import (
    listed,
    made_by_text,
    runs_caption,
)
from hunav_drake.runs.comparison.latex import to_latex
from hunav_drake.runs.comparison.tables import COLUMNS, chosen_tables
from hunav_drake.runs.statistics import summarize

NAN = float("nan")


def runs_of(seeds=4, planners=("a_b", "c"), scenario="hall"):
    rows = [
        {
            "scenario": scenario,
            "planner": planner,
            "setting": "",
            "seed": seed,
            "drawn": "start jitter",
            "completed": float(seed > 0),
            "path_length": 10.0 + seed,
            "time_to_reach_goal": 5.0 + seed if seed else NAN,
            "robot_on_person_collisions": float(seed),
        }
        for planner in planners
        for seed in range(seeds)
    ]
    return pd.DataFrame(rows)


def test_captions_tell_scenario_planners_seeds_and_version():
    made_by = made_by_text("mine", "2", "0.1.0")
    assert runs_caption(runs_of(), made_by) == (
        "Scenario hall; planners a_b and c; 4 seeds (0 to 3); suite mine,"
        " version 2; hunav_drake 0.1.0"
    )
    assert made_by_text("", "", "0.1.0") == "hunav_drake 0.1.0"
    two = pd.concat([runs_of(), runs_of(scenario="yard")])
    assert runs_caption(two).startswith("Scenarios hall and yard; planners")


@pytest.mark.parametrize(
    ("runs", "told"),
    [
        (runs_of(1), "one seed (0)"),
        (runs_of(4).query("seed != 2"), "3 seeds (0, 1 and 3)"),
        (runs_of(4)[:-1], "3 to 4 seeds"),
        (runs_of(4).assign(seed=range(8)), "4 seeds"),
        (runs_of(4).assign(seed=""), "8 runs"),
        (runs_of(4).assign(seed=NAN), "8 runs"),
        (
            runs_of(4).assign(drawn="nothing"),
            "one run each, because all seeds are alike",
        ),
    ],
)
def test_captions_tell_which_seeds_there_are(runs, told):
    assert runs_caption(runs) == f"Scenario hall; planners a_b and c; {told}"


def test_lists_are_short():
    assert listed([]) == ""
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed(list("abcdef"), 4) == "a, b, c and 3 more"


def test_chosen_columns_are_statistics():
    runs = runs_of()
    names = ["completed", "path_length", "time_to_reach_goal"]
    columns = [it for it in COLUMNS if it != "estimate"]
    (table,) = chosen_tables(runs, names, columns)
    assert table.groups == (("a_b", 6), ("c", 6))
    assert table.header == ("", *columns, *columns, "unit")
    assert [row[0] for row in table.rows] == names
    told = dict(zip(columns, table.rows[1][1:7], strict=True))
    row = summarize(runs).loc[("hall", "c", "path_length")]
    assert told == {
        "n": "4",
        "mean": "11.50*",
        "interval": f"[{row['low']:.2f}, {row['high']:.2f}]",
        "sd": "1.29",
        "median": "11.50",
        "arrived": "3",
    }
    assert table.rows[0][2] == "75.0"
    assert table.rows[2][1] == "3"
    assert table.caption.endswith("paths that end early.")


def test_a_table_has_no_rows_of_the_robots_of_other_scenarios():
    fleet = runs_of(scenario="lobby")
    fleet["anna.path_length"] = fleet.pop("path_length")
    runs = pd.concat([runs_of(), fleet])
    both = ["path_length", "anna.path_length"]
    hall, lobby = chosen_tables(runs, ["completed", *both])
    assert [row[0] for row in hall.rows] == ["completed", "path_length"]
    assert [row[0] for row in lobby.rows] == ["completed", "anna.path_length"]
    (lobby,) = chosen_tables(runs, both[1:])
    assert lobby.title == "lobby"


def test_own_metrics_are_those_of_the_robots_that_are_there():
    fleet = runs_of(scenario="lobby")
    fleet["anna.path_length"] = fleet.pop("path_length")
    fleet["anna.mine"] = 1.0
    late = fleet.assign(scenario="late", **{"anna.mine": NAN})
    runs = pd.concat([runs_of(), fleet, late])
    tables = chosen_tables(runs, ["completed", "anna.mine"])
    names = [[row[0] for row in it.rows] for it in tables]
    assert names == [["completed"], *[["completed", "anna.mine"]] * 2]


def test_a_scenario_in_which_nobody_arrives_keeps_its_rows():
    hard = runs_of(scenario="hard").assign(completed=0.0, path_length=NAN)
    runs = pd.concat([runs_of(), hard])
    for metrics in (["completed", "path_length"], ["path_length"]):
        for table in chosen_tables(runs, metrics):
            assert [row[0] for row in table.rows] == metrics


def test_nothing_is_a_dash():
    runs = runs_of(1).assign(path_length=NAN, completed=NAN)
    (table,) = chosen_tables(runs, ["path_length"], ["mean", "interval", "sd"])
    assert table.rows[0][1:4] == ("-", "-", "-")
    assert "*" not in table.caption


def test_chosen_tables_are_balanced_and_escaped():
    runs = pd.concat([runs_of(), runs_of(scenario="a_%&#room")])
    metrics = ["path_length", "robot_on_person_collisions"]
    for columns in (["estimate"], ["mean"], ["mean", "interval", "n"]):
        tables = chosen_tables(runs, metrics, columns, "suite s_1, version 2")
        assert len(tables) == 2
        for table in tables:
            text = to_latex(table)
            body = [it for it in text.splitlines() if it.endswith(r"\\")]
            spec = re.search(r"\\begin{tabular}{(l(r+)l)}", text)
            width = len(spec[1])
            assert width == 2 + 2 * len(columns)
            for line in body:
                spans = re.findall(r"\\multicolumn{(\d+)}", line)
                cells = len(re.findall(r"(?<!\\)&", line)) + 1
                assert cells + sum(int(it) - 1 for it in spans) == width
            for line in (*body, *re.findall(r"\\caption.*", text)):
                assert not re.search(r"(?<!\\)[%#_]", line)
            # Rules are over the columns of one planner each.
            rules = re.findall(r"\\cmidrule\(lr\){(\d+)-(\d+)}", text)
            k = len(columns)
            assert rules == (
                [("2", str(k + 1)), (str(k + 2), str(2 * k + 1))]
                if k > 1
                else []
            )
            order = (r"\toprule", r"\midrule", r"\bottomrule")
            places = [text.index(it) for it in order]
            assert places == sorted(places)
            assert text.count("{") == text.count("}")
            for word in ("begin", "end"):
                assert text.count(rf"\{word}{{table*}}") == 1
            assert r"4 seeds (0 to 3); suite s\_1, version 2" in text


def test_an_unknown_metric_is_told():
    with pytest.raises(ValueError, match="has no column 'path_lenth'"):
        chosen_tables(runs_of(), ["path_lenth"])
