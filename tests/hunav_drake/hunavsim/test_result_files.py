"""The text files of HuNavSim's evaluator."""

import json

import numpy as np
import pandas as pd
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.hunavsim.result_files import HUNAV_NAMES
from hunav_drake.runs.result_files import WriteResult
from tests.hunav_drake.passing_trials import make_recording, make_result
from tests.recorded import read_recorded

RECORDING = make_recording(
    (0.0, 0.0, 0.0),
    y=(2.0, 5.0, 8.0),
    samples=5,
    times=7 + np.arange(5) * 0.1,
    behaviors=("regular", "scared", "my own"),
    behavior_status=np.array([[1, k >= 2, 0] for k in range(5)]),
    goal=(5.0, 0.0, 0.0),
)


def read_table(path):
    return pd.read_csv(path, sep="\t")


def test_four_kinds_of_files_besides_the_others(tmp_path):
    result = make_result(RECORDING, metric_names="all")
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    assert {path.name for path in folder.glob("*.txt")} == {
        "metrics.txt",
        "metrics_steps_a.txt",
        "metrics_beh_1.txt",
        "metrics_beh_1_steps_a.txt",
        "metrics_beh_4.txt",
        "metrics_beh_4_steps_a.txt",
    }


def test_one_row_for_the_run_with_the_names_of_the_original(tmp_path):
    result = make_result(RECORDING, metric_names="all")
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    table = read_table(folder / "metrics.txt")
    assert table["experiment_tag"].tolist() == ["a"]
    assert set(table.columns) == {"experiment_tag", *HUNAV_NAMES.values()}
    for name, original in HUNAV_NAMES.items():
        assert table[original][0] == pytest.approx(
            result.metrics[name], nan_ok=True
        )
    text = (folder / "metrics.txt").read_text()
    assert "\tnan\t" in text
    assert "\tFalse\t" in text
    behavior = read_table(folder / "metrics_beh_4.txt")
    assert behavior["minimum_distance_to_people"][0] == pytest.approx(
        result.by_behavior.loc["scared", "min_dist_to_people"]
    )


def test_each_of_several_robots_has_files_of_its_own(tmp_path):
    robots = "".join(
        f"\n- {{name: {name}, robot: {{start: [{x}, 0, 0], goal: [9, 0, 0]}}}}"
        for name, x in (("anna", 0), ("bob", 3))
    )
    result = RunTrial(
        LoadScenario(
            data=f"robots:{robots}\nsimulation: {{duration: 1}}\n"
            "humans: [{pose: [5, 2, 0]}]"
        )
    )
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    names = ("metrics.txt", "metrics_steps_a.txt", "metrics_beh_1.txt")
    assert {path.name for path in folder.glob("*.txt")} == {
        f"{robot}_{name}"
        for robot in ("anna", "bob")
        for name in (*names, "metrics_beh_1_steps_a.txt")
    }
    for robot in ("anna", "bob"):
        gap = result.metrics[f"{robot}.min_dist_to_people"]
        table = read_table(folder / f"{robot}_metrics.txt")
        assert table["minimum_distance_to_people"][0] == pytest.approx(gap)
        assert set(table) <= {"experiment_tag", *HUNAV_NAMES.values()}
        steps = read_table(folder / f"{robot}_metrics_beh_1_steps_a.txt")
        least = steps["avg_distance_to_closest_person"].min()
        assert least == pytest.approx(gap)
        assert list(steps["behavior_active"].unique()) == [0]


def test_the_names_are_those_of_the_original():
    expected = json.loads(read_recorded("metrics/06_surprised_pass"))[
        "expected"
    ]
    assert set(HUNAV_NAMES.values()) == set(expected["final"])


def test_steps_count_from_the_first(tmp_path):
    result = make_result(RECORDING, metric_names="all")
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    steps = read_table(folder / "metrics_steps_a.txt")
    assert steps["time_stamps"].to_numpy() == pytest.approx(np.arange(5) * 0.1)
    assert steps["avg_distance_to_closest_person"].to_numpy() == pytest.approx(
        result.steps["avg_dist_to_closest_person"].to_numpy()
    )
    assert "behavior_active" not in steps


def test_a_behavior_is_active_only_by_its_own_people(tmp_path):
    result = make_result(RECORDING, metric_names="all")
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    active = {
        number: read_table(folder / f"metrics_beh_{number}_steps_a.txt")[
            "behavior_active"
        ].tolist()
        for number in (1, 4)
    }
    assert active == {1: [1] * 5, 4: [0, 0, 1, 1, 1]}


def test_only_the_chosen_metrics_are_in_them(tmp_path):
    result = make_result(RECORDING, metric_names=["path", "efficiency"])
    folder = WriteResult(result, tmp_path, tag="a", format="hunav")
    assert read_table(folder / "metrics.txt").columns.tolist() == [
        "experiment_tag",
        "path_length",
        "cumulative_heading_changes",
    ]


def test_without_the_format_there_are_none(tmp_path):
    WriteResult(make_result(RECORDING), tmp_path)
    assert not list(tmp_path.rglob("*.txt"))
