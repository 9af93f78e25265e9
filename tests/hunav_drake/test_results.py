from concurrent.futures import ProcessPoolExecutor
import errno
import json
import math
from multiprocessing import get_context
import os
from pathlib import Path
import signal

import numpy as np
import pandas as pd
import pytest

from hunav_drake.results import (
    FormatMetricsTable,
    MakeProvenance,
    MakeTrialResult,
    TrialResult,
    WriteResult,
)
from hunav_drake.run_table import append_row
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording

# The children only write files; none of the threads' locks matters to them.
forks = pytest.mark.filterwarnings(
    "ignore:This process .* is multi-threaded:DeprecationWarning"
)


def make_result(seed: int = 0, metric_names=("all",), **kwargs) -> TrialResult:
    times = np.arange(5) * 0.1
    robot = np.zeros((5, 7))
    robot[:, 0] = 0.5 * times
    robot[:, 3] = 0.5
    robot[:, 6] = 0.35
    humans = np.zeros((5, 2, 7))
    humans[:, :, 1] = [2.0, 5.0]
    humans[:, :, 6] = 0.35
    recording = Recording(
        times=times,
        robot=robot,
        humans=humans,
        behaviors=("regular", "scared"),
        behavior_status=np.array([[0, k >= 2] for k in range(5)]),
        goal=(2.0, 0.0, 0.0),
    )
    settings = {
        "scenario_name": "passing",
        "provenance": MakeProvenance("humans: []", seed, planner="pursuit"),
        "end_reason": "timeout",
        "end_message": "0.4 s have passed",
    }
    return MakeTrialResult(
        recording, metric_names=metric_names, **(settings | kwargs)
    )


def test_a_result_has_all_tables():
    dut = make_result()
    assert list(dut.metrics.index) == list(dut.by_behavior.columns)
    assert list(dut.by_behavior.index) == ["regular", "scared"]
    assert dut.end_time == 0.4
    assert dut.metrics["path_length"] == pytest.approx(0.2)
    assert dut.metrics.attrs["units"]["path_length"] == "m"
    assert dut.by_behavior.loc["scared", "min_dist_to_people"] == (
        pytest.approx(4.3)
    )
    active = dut.steps_by_behavior["scared"]["behavior_active"]
    assert active.tolist() == [0, 0, 1, 1, 1]
    assert not dut.steps_by_behavior["regular"]["behavior_active"].any()


def test_only_the_chosen_metrics_are_in_it():
    dut = make_result(metric_names=["path_length", "goal"])
    assert dut.metrics.index[0] == "path_length"
    assert {METRICS[name].family for name in dut.metrics.index} == {
        "path",
        "goal",
    }


def test_provenance_names_versions_and_scenario():
    dut = MakeProvenance("humans: []", 7, planner="pursuit")
    assert dut["seed"] == 7
    assert dut["planner"] == "pursuit"
    assert len(dut["scenario_sha256"]) == 64
    assert dut["numpy"] == np.__version__
    assert dut["drake"].startswith("1.")
    assert {"hunav_drake", "numba", "python", "machine"} <= dut.keys()
    other = MakeProvenance("humans: [ ]", 7)
    assert other["scenario_sha256"] != dut["scenario_sha256"]


def test_files_are_there_and_load(tmp_path):
    result = make_result()
    paths = WriteResult(result, tmp_path / "new/folder", tag="a")
    names = {path.name for path in paths}
    assert names == {path.name for path in (tmp_path / "new/folder").iterdir()}
    assert names == {
        "metrics.csv",
        "metrics_beh_regular.csv",
        "metrics_beh_scared.csv",
        "recording_a.npz",
        "result_a.json",
        "steps_a.csv",
        "steps_a_beh_regular.csv",
        "steps_a_beh_scared.csv",
    }
    folder = paths[0].parent
    assert Recording.load(folder / "recording_a.npz") == result.recording
    table = pd.read_csv(folder / "metrics.csv", index_col="tag")
    for name, value in result.metrics.items():
        assert table.loc["a", name] == pytest.approx(value, nan_ok=True, rel=0)
    steps = pd.read_csv(folder / "steps_a.csv", index_col="time")
    pd.testing.assert_frame_equal(
        steps, result.steps, check_exact=True, check_dtype=False
    )
    summary = json.loads((folder / "result_a.json").read_text())
    assert summary["provenance"]["seed"] == 0
    assert summary["metrics"]["path_length"]["unit"] == "m"
    assert summary["metrics"]["time_to_reach_goal"]["value"] is None


def test_a_second_run_leaves_the_first_as_it_is(tmp_path):
    WriteResult(make_result(), tmp_path)
    before = (tmp_path / "steps_passing_pursuit_0.csv").read_bytes()
    WriteResult(make_result(), tmp_path)
    WriteResult(make_result(seed=3), tmp_path)
    assert (tmp_path / "steps_passing_pursuit_0.csv").read_bytes() == before
    tags = pd.read_csv(tmp_path / "metrics.csv")["tag"].tolist()
    assert tags == [
        "passing_pursuit_0",
        "passing_pursuit_0_2",
        "passing_pursuit_3",
    ]


def test_a_taken_tag_is_refused(tmp_path):
    WriteResult(make_result(), tmp_path, tag="a")
    with pytest.raises(FileExistsError, match=r"tag 'a' is taken.*recording_a"):
        WriteResult(make_result(), tmp_path, tag="a")


@pytest.mark.parametrize("tag", ["", "../a", "a b", "a/b"])
def test_a_tag_must_fit_into_the_name_of_a_file(tmp_path, tag):
    with pytest.raises(ValueError, match="tag must be of letters"):
        WriteResult(make_result(), tmp_path, tag=tag)
    assert not list(tmp_path.iterdir())


def test_a_table_takes_rows_with_other_metrics(tmp_path):
    WriteResult(make_result(metric_names=["path"]), tmp_path, tag="a")
    WriteResult(make_result(metric_names=["goal"]), tmp_path, tag="b")
    table = pd.read_csv(tmp_path / "metrics.csv", index_col="tag")
    assert table.loc["a", "path_length"] == pytest.approx(0.2)
    assert math.isnan(table.loc["b", "path_length"])
    assert table.loc["b", "completed"] == 0


def test_texts_with_commas_and_quotes_survive(tmp_path):
    path = tmp_path / "t.csv"
    append_row(path, {"tag": 'a "b", c\nd', "x": 0.1})
    append_row(path, {"tag": "ü", "x": math.nan})
    table = pd.read_csv(path)
    assert table["tag"].tolist() == ['a "b", c\nd', "ü"]
    assert table["x"].tolist()[0] == 0.1


def test_a_damaged_table_is_not_touched(tmp_path):
    path = tmp_path / "metrics.csv"
    path.write_text("tag,x\na,1\nb\n")
    with pytest.raises(ValueError, match=r"metrics\.csv.*row 2"):
        WriteResult(make_result(), tmp_path)
    assert path.read_text() == "tag,x\na,1\nb\n"


def _write_many(arguments):
    folder, worker = arguments
    for i in range(5):
        WriteResult(
            make_result(seed=i, metric_names=["path"]),
            folder,
            tag=None if i % 2 else f"w{worker}_{i}",
        )


@forks
def test_parallel_writers_lose_no_row(tmp_path):
    with ProcessPoolExecutor(4, mp_context=get_context("fork")) as pool:
        list(pool.map(_write_many, [(tmp_path, w) for w in range(4)]))
    table = pd.read_csv(tmp_path / "metrics.csv")
    assert len(table) == 20
    assert table["tag"].is_unique
    assert not table["path_length"].isna().any()
    assert len(list(tmp_path.glob("recording_*.npz"))) == 20
    assert not list(tmp_path.glob(".*"))


def _write_forever(folder, finished):
    while True:
        WriteResult(make_result(metric_names=["path"]), folder)
        finished.value += 1


@forks
def test_a_killed_writer_leaves_whole_files_and_no_lock(tmp_path):
    finished = get_context("fork").Value("i", 0)
    WriteResult(make_result(metric_names=["path"]), tmp_path)
    for i in range(20):
        process = get_context("fork").Process(
            target=_write_forever, args=(tmp_path, finished)
        )
        before = finished.value
        process.start()
        while finished.value == before and process.is_alive():
            process.join(timeout=0.001)
        # At each turn it gets to another point of its work.
        process.join(timeout=0.0037 * i)
        process.kill()
        process.join()
        assert process.exitcode == -signal.SIGKILL
    table = pd.read_csv(tmp_path / "metrics.csv")
    # The last row of each may be there without having been counted.
    assert 1 + finished.value <= len(table) <= 21 + finished.value
    assert finished.value >= 20
    assert table["tag"].is_unique
    assert not table["path_length"].isna().any()
    for path in tmp_path.glob("recording_*.npz"):
        Recording.load(path)
    for path in tmp_path.glob("result_*.json"):
        json.loads(path.read_text())
    for tag in table["tag"]:
        assert len(pd.read_csv(tmp_path / f"steps_{tag}.csv")) == 5
        assert (tmp_path / f"recording_{tag}.npz").exists()
    WriteResult(make_result(), tmp_path)


def test_a_folder_that_is_a_file_is_named(tmp_path):
    path = tmp_path / "file"
    path.write_text("mine")
    with pytest.raises(OSError, match=r"cannot write the results.*file"):
        WriteResult(make_result(), path)
    assert path.read_text() == "mine"


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    WriteResult(make_result(), tmp_path, tag="a")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(*args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match=r"cannot write.*No space left") as info:
        WriteResult(make_result(), tmp_path, tag="b")
    assert info.value.errno == errno.ENOSPC
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_the_table_for_the_terminal_is_narrow_and_complete():
    result = make_result(end_message="a very long story, " * 9)
    text = FormatMetricsTable(result)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 80
    for name in result.metrics.index:
        assert sum(line.split()[:1] == [name] for line in lines) == 1
    assert "passing, planner pursuit, seed 0" in lines[0]
    words = {line.split()[0]: line.split()[1:] for line in lines if line}
    assert words["path_length"] == ["0.200", "m"]
    assert words["time_to_reach_goal"] == ["-", "s"]
    assert words["completed"] == ["0"]
    assert words["robot_on_person_collisions"] == ["0"]
    assert words["social+_space_intrusions"] == ["100.0", "%"]


def test_each_family_has_a_heading():
    lines = FormatMetricsTable(make_result()).splitlines()
    for family in {metric.family for metric in METRICS.values()}:
        assert family in lines


def test_a_result_keeps_a_copy_of_its_provenance():
    provenance = MakeProvenance("", 0)
    dut = make_result(provenance=provenance)
    provenance["seed"] = 1
    assert dut.provenance["seed"] == 0


def test_an_unknown_metric_is_an_error():
    with pytest.raises(ValueError, match="did you mean 'path_length'"):
        make_result(metric_names=["path_lenght"])


def test_the_path_may_be_a_string(tmp_path):
    paths = WriteResult(make_result(), str(tmp_path))
    assert all(isinstance(path, Path) for path in paths)
