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

from hunav_drake.results.files import (
    CheckTables,
    GetTag,
    LoadResult,
    LoadResults,
    WriteResult,
)
from hunav_drake.results.provenance import MakeProvenance
from hunav_drake.results.run_table import ReadRuns, tabulate_runs
from hunav_drake.results.text_table import append_row, read_rows
from hunav_drake.results.trial_result import (
    FormatMetricsTable,
    MakeTrialResult,
    TrialResult,
)
from hunav_drake.systems.evaluation.metrics import METRICS, register_metric
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
    assert GetTag(WriteResult(make_result(), tmp_path, tag="a")) == "a"
    before = (tmp_path / "recording_a.npz").read_bytes()
    for _ in range(2):
        with pytest.raises(FileExistsError, match=r"'a' is taken.*recording_a"):
            WriteResult(make_result(seed=4), tmp_path, tag="a")
        # Not even if nobody can tell whether it was complete.
        (tmp_path / "metrics.csv").write_text("tag\n1,2\n")
    assert (tmp_path / "recording_a.npz").read_bytes() == before


def test_a_killed_run_can_be_repeated(tmp_path):
    WriteResult(make_result(seed=1), tmp_path, tag="other")
    table = tmp_path / "metrics.csv"
    before = table.read_bytes()
    WriteResult(make_result(), tmp_path, tag="a", format="hunav")
    # As if it had been killed before its last step.
    table.write_bytes(before)
    WriteResult(make_result(seed=2), tmp_path, tag="a", format="hunav")
    assert pd.read_csv(table)["tag"].tolist() == ["other", "a"]
    for path in tmp_path.glob("metrics_beh_*.csv"):
        rows = pd.read_csv(path)
        assert rows["tag"].tolist() == ["other", "a"]
        assert rows["seed"].tolist() == [1, 2]
    texts = pd.read_csv(tmp_path / "metrics.txt", sep="\t")
    assert texts["experiment_tag"].tolist() == ["a"]
    assert LoadResult(tmp_path, "a").provenance["seed"] == 2


def test_files_stay_even_if_their_table_is_gone(tmp_path):
    paths = WriteResult(make_result(), tmp_path)
    before = paths[0].read_bytes()
    (tmp_path / "metrics.csv").unlink()
    tag = GetTag(WriteResult(make_result(), tmp_path))
    assert tag == "passing_pursuit_0_2"
    assert paths[0].read_bytes() == before


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


def test_what_cannot_have_a_row_is_kept(tmp_path):
    path = tmp_path / "metrics_beh_scared.csv"
    path.write_text("tag,x\na,1\nb\n")
    with pytest.raises(ValueError, match=r"metrics_beh_scared\.csv.*row 2"):
        CheckTables(tmp_path)
    with pytest.raises(ValueError, match=r"metrics_beh_scared\.csv.*row 2"):
        WriteResult(make_result(), tmp_path, tag="c")
    # The recording is there, and no other table has a row without its like.
    assert Recording.load(tmp_path / "recording_c.npz")
    assert {p.name for p in tmp_path.glob("metrics*")} == {path.name}
    path.unlink()
    CheckTables(tmp_path)
    WriteResult(make_result(), tmp_path, tag="c")
    CheckTables(tmp_path)
    CheckTables(tmp_path / "nowhere")


def test_behaviors_do_not_write_over_each_other(tmp_path):
    behaviors = (
        "run away",
        "run_away",
        "\u597d\u5947",
        "\u5bb3\u6015",
        "x" * 300,
    )
    times = np.arange(3) * 0.1
    humans = np.zeros((3, 5, 7))
    humans[..., 0] = [2, 3, 4, 5, 6]
    recording = Recording(
        times=times,
        robot=np.zeros((3, 7)),
        humans=humans,
        behaviors=behaviors,
    )
    for tag in "ab":
        result = MakeTrialResult(
            recording, provenance={}, end_reason="end", metric_names="paper"
        )
        WriteResult(result, tmp_path, tag=tag)
    tables = [ReadRuns(p) for p in tmp_path.glob("metrics_beh_*.csv")]
    found = {table["behavior"].unique()[0]: table for table in tables}
    assert set(found) == set(behaviors)
    for behavior, table in found.items():
        assert table["tag"].tolist() == ["a", "b"]
        assert set(table["behavior"]) == {behavior}
        assert table["min_dist_to_people"][0] == pytest.approx(
            result.by_behavior.loc[behavior, "min_dist_to_people"]
        )
    assert len(list(tmp_path.glob("steps_a_beh_*.csv"))) == 5
    # A name that is fit stays as it is.
    assert (tmp_path / "metrics_beh_run_away.csv").exists()


def test_a_row_is_added_as_text_or_with_new_columns(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(b"tag,x\r\na,1.50")
    append_row(path, {"tag": "b", "x": 2})
    assert path.read_bytes() == b"tag,x\r\na,1.50\nb,2\n"
    append_row(path, {"tag": "c", "y": 3.0})
    append_row(path, {"tag": "b", "x": 4})
    assert read_rows(path) == (
        ["tag", "x", "y"],
        [["a", "1.50", ""], ["c", "", "3.0"], ["b", "4", ""]],
    )


def test_drafts_of_dead_writers_are_removed(tmp_path):
    old = tmp_path / f".recording_x.npz.{'0' * 16}.tmp"
    new = tmp_path / f".report.html.{'1' * 16}.tmp"
    mine = tmp_path / ".notes.tmp"
    for path in (old, new, mine):
        path.touch()
    for path in (old, mine):
        os.utime(path, (0, 0))
    WriteResult(make_result(), tmp_path)
    assert [p.exists() for p in (old, new, mine)] == [False, True, True]


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


def test_the_behavior_trees_have_a_place_in_it():
    assert "behavior_sha256" not in MakeProvenance("", 0)
    dut = MakeProvenance("", 0, behavior_sha256="abc")
    assert dut["behavior_sha256"] == "abc"


def test_one_name_of_metrics_is_enough():
    assert len(make_result(metric_names="paper").metrics) == 28
    assert len(make_result(metric_names="path_length").metrics) == 1


@pytest.fixture
def broken_metric():
    """Registers metrics, and forgets them again."""
    before = dict(METRICS)

    def register(name, function):
        function.__doc__ = "Returns what a test needs."
        register_metric(name=name, unit="m", family="mine", source="me")(
            function
        )

    yield register
    METRICS.clear()
    METRICS.update(before)


def test_a_metric_that_fails_does_not_take_the_trial_with_it(
    broken_metric, tmp_path
):
    def fail(recording):
        raise ZeroDivisionError("no people")

    def fail_alone(recording):
        if recording.num_humans < 2:
            raise IndexError("one person")
        return 2.0

    broken_metric("broken", fail)
    broken_metric("needs_two", fail_alone)
    names = ["path_length", "broken", "needs_two"]
    with pytest.warns(RuntimeWarning) as caught:
        dut = make_result(metric_names=names)
    texts = [str(warning.message) for warning in caught]
    assert len(texts) == 2
    assert "no value: metric 'broken': " in texts[0]
    assert "no people" in texts[0]
    assert "no value by behavior: metric 'needs_two': " in texts[1]
    assert "one person" in texts[1]
    assert list(dut.metrics.index) == list(dut.by_behavior.columns) == names
    assert dut.metrics["path_length"] == pytest.approx(0.2)
    assert math.isnan(dut.metrics["broken"])
    assert dut.metrics["needs_two"] == 2.0
    assert dut.by_behavior["needs_two"].isna().all()
    assert dut.metrics.attrs["units"]["broken"] == "m"
    assert dut.by_behavior.attrs["units"]["broken"] == "m"
    WriteResult(dut, tmp_path)


def test_what_is_infinite_is_a_text_in_json(broken_metric, tmp_path):
    broken_metric("far", lambda recording: math.inf)
    broken_metric("near", lambda recording: -math.inf)
    WriteResult(make_result(metric_names=["far", "near"]), tmp_path, tag="a")

    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    text = (tmp_path / "result_a.json").read_text()
    values = json.loads(text, parse_constant=refuse)["metrics"]
    assert values["far"]["value"] == "Infinity"
    assert values["near"]["value"] == "-Infinity"
    (again,) = LoadResults(tmp_path)
    assert again.metrics.tolist() == [math.inf, -math.inf]


def test_the_table_of_runs_has_the_same_columns_in_files_and_in_memory(
    tmp_path,
):
    results = [make_result(seed=seed) for seed in (0, 1)]
    for result in results:
        WriteResult(result, tmp_path)
    table = tabulate_runs(LoadResults(tmp_path))
    assert table.attrs["units"]["path_length"] == "m"
    pd.testing.assert_frame_equal(ReadRuns(tmp_path), table, check_dtype=False)


def test_an_unknown_metric_is_an_error():
    with pytest.raises(ValueError, match="did you mean 'path_length'"):
        make_result(metric_names=["path_lenght"])


def test_the_path_may_be_a_string(tmp_path):
    paths = WriteResult(make_result(), str(tmp_path))
    assert all(isinstance(path, Path) for path in paths)
