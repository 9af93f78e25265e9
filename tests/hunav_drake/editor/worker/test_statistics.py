import math

import numpy as np
import pytest

from hunav_drake.editor.worker.statistics import (
    plain_number,
    summary_rows,
    value_text,
)
from hunav_drake.runs.intervals import mean_interval


def test_numbers_are_those_of_json():
    assert plain_number(1.5) == 1.5
    assert plain_number(math.nan) is None
    assert plain_number(math.inf) == "Infinity"
    assert plain_number(-math.inf) == "-Infinity"


def test_values_of_one_of_several_robots_are_told_as_of_a_single_one():
    for name, value, text in (
        ("contacts_by_robot", 2.0, "2"),
        ("personal_space_intrusions", 64.81, "64.8"),
    ):
        assert value_text(name, value) == text
        assert value_text(f"anna.{name}", value) == text


def test_each_planner_has_mean_and_interval():
    values = {"a": [11.0, 12.0, 14.0], "b": [3.0, 3.0, 3.0]}
    runs = [
        {"planner": planner, "metrics": {"path_length": it, "x": None}}
        for planner, all_values in values.items()
        for it in all_values
    ]
    rows = {row["planner"]: row for row in summary_rows(runs)}
    assert {row["metric"] for row in rows.values()} == {"path_length"}
    low, high = mean_interval(np.array(values["a"]))
    assert rows["a"]["n"] == 3
    assert rows["a"]["mean"] == pytest.approx(37 / 3)
    assert (rows["a"]["low"], rows["a"]["high"]) == pytest.approx((low, high))
    assert rows["b"]["low"] == rows["b"]["high"] == 3.0


def test_intervals_have_no_impossible_values():
    values = {"anna.personal_space_intrusions": (5.0, 95.0), "a": (5.0, 95.0)}
    runs = [
        {"planner": "p", "metrics": {it: values[it][i] for it in values}}
        for i in range(2)
    ]
    share, other = summary_rows(runs)
    assert (share["low"], share["high"]) == (0.0, 100.0)
    assert other["low"] < 0.0
    assert other["high"] > 100.0


def test_one_run_has_a_mean_and_no_interval():
    (row,) = summary_rows([{"planner": "a", "metrics": {"path_length": 2.0}}])
    assert (row["n"], row["mean"]) == (1, 2.0)
    assert row["low"] is None


def test_values_of_no_run_give_no_rows():
    assert summary_rows([{"planner": "a", "metrics": {"x": None}}]) == []


def test_infinity_is_no_value():
    runs = [
        {"planner": "a", "metrics": {"path_length": it}}
        for it in ("Infinity", 2.0)
    ]
    (row,) = summary_rows(runs)
    assert (row["n"], row["mean"]) == (1, 2.0)


def test_equal_runs_of_which_nothing_is_drawn_count_once():
    run = {"planner": "a", "drawn": "nothing", "metrics": {"completed": 1.0}}
    (row,) = summary_rows([run, run, run])
    assert (row["n"], row["low"], row["high"]) == (1, None, None)
    (row,) = summary_rows([{**run, "drawn": "start jitter"}] * 3)
    assert row["n"] == 3
