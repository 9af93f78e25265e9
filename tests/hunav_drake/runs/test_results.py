from concurrent.futures import ProcessPoolExecutor
import errno
import json
import math
from multiprocessing import get_context
import os
import shutil
import signal

from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pandas as pd
import pytest

from hunav_drake import ReadRecording, WriteReport
from hunav_drake.runs import result_files
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_folders import find_pages, find_runs
from hunav_drake.runs.run_log import NAME, append_rows, read_rows
from hunav_drake.runs.run_row import make_row
from hunav_drake.runs.run_table import ReadRuns, WriteTables, tabulate_runs
from hunav_drake.systems.evaluation.compute import Evaluation
from hunav_drake.systems.evaluation.metrics import METRICS, register_metric
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.provenance import MakeProvenance
from hunav_drake.trial.result import (
    CSV_NUMBERS,
    FormatMetricsTable,
    MakeTrialResult,
    MetricTables,
    TrialResult,
    with_situations,
)
from tests.choices import COMMON_METRICS
from tests.hunav_drake.passing_trials import make_recording, make_result

# The children only write files; none of the threads' locks matters to them.
forks = pytest.mark.filterwarnings(
    "ignore:This process .* is multi-threaded:DeprecationWarning"
)


RECORDING = make_recording(
    y=(2.0, 5.0),
    samples=5,
    speed=0.5,
    behaviors=("regular", "scared"),
    behavior_status=np.array([[0, k >= 2] for k in range(5)]),
    goal=(2.0, 0.0, 0.0),
)


def make_timeout(seed=0, **kwargs) -> TrialResult:
    """Returns a trial that ended before its goal, with all metrics."""
    settings = {
        "metric_names": ["all"],
        "end_reason": "timeout",
        "end_message": "0.4 s have passed",
    }
    return make_result(RECORDING, seed=seed, **(settings | kwargs))


def snapshot(directory) -> dict[str, bytes]:
    """Returns the files below a folder, by their paths in it."""
    return {
        path.relative_to(directory).as_posix(): path.read_bytes()
        for path in directory.rglob("*")
        if path.is_file()
    }


def test_a_result_has_all_tables():
    dut = make_timeout()
    assert list(dut.metrics.index) == list(dut.by_behavior.columns)
    assert list(dut.by_behavior.index) == ["regular", "scared"]
    assert dut.end_time == 0.4
    assert dut.metrics["path_length"] == pytest.approx(0.2)
    assert dut.metrics.attrs["units"]["path_length"] == "m"
    assert dut.by_behavior.loc["scared", "min_dist_to_people"] == (
        pytest.approx(4.4)
    )
    active = dut.steps_by_behavior["scared"]["behavior_active"]
    assert active.tolist() == [0, 0, 1, 1, 1]
    assert not dut.steps_by_behavior["regular"]["behavior_active"].any()


def test_only_the_chosen_metrics_are_in_it():
    dut = make_timeout(metric_names=["path_length", "goal"])
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
    result = make_timeout()
    folder = WriteResult(result, tmp_path / "new/folder", tag="a")
    assert folder == tmp_path / "new/folder/runs/a"
    assert {path.name for path in folder.iterdir()} == {
        "recording.npz",
        "result.json",
        "steps.csv",
        "steps_beh_regular.csv",
        "steps_beh_scared.csv",
    }
    for file in (folder, folder / "recording.npz"):
        assert ReadRecording(file) == result.recording
    steps = pd.read_csv(folder / "steps.csv", index_col="time")
    pd.testing.assert_frame_equal(
        steps, result.steps, rtol=1e-11, check_dtype=False
    )
    summary = json.loads((folder / "result.json").read_text())
    assert summary["provenance"]["seed"] == 0
    assert summary["metrics"]["path_length"]["unit"] == "m"
    assert summary["metrics"]["time_to_reach_goal"]["value"] is None
    assert (
        summary["by_behavior"]["scared"]["min_dist_to_people"]
        == (result.by_behavior.loc["scared", "min_dist_to_people"])
    )


@given(
    series=arrays(
        float,
        (3, 2),
        elements=st.floats() | st.sampled_from([1 / 3, 1e12 + 0.5, -0.0]),
    ),
    name=st.sampled_from(["gap", "a,b", 'say "a"', "ö\n", ""]),
)
def test_texts_of_series_are_those_of_pandas(series, name):
    times = np.array([0.0, 0.1 + 0.2, 1e-7])
    found = Evaluation(
        times, {}, {name: series[:, 0], "b": series[:, 1]}, {name: "m", "b": ""}
    )
    own = MetricTables(found, {"calm": found}, {})
    written = own.step_texts
    assert written[None] == found.steps().to_csv(float_format=CSV_NUMBERS)
    assert own.steps is own.steps  # From now on, changes of a table count.
    assert own.step_texts == written
    own.steps.loc[0.0, "b"] = 7.0
    assert ",7\n" in own.step_texts[None]


@pytest.mark.parametrize("whole", [False, True])
def test_facts_that_a_user_replaces_count(tmp_path, whole):
    result = make_timeout()
    metrics = result.metrics
    metrics["mine"] = 3.25
    attrs = {key: {**facts} for key, facts in metrics.attrs.items()}
    attrs["units"]["mine"] = "kg"
    attrs["families"]["mine"] = "proxemics"
    if whole:
        metrics.attrs = attrs
    else:
        metrics.attrs |= attrs
    facts = {"unit": "kg", "family": "proxemics", "direction": "none"}
    assert make_row(result).facts == {"mine": facts}
    page = WriteReport(result, tmp_path / "report.html").read_text()
    headline = page.partition('id="plots"')[0]
    assert "mine" in headline
    assert "kg" in headline


def test_metrics_that_a_user_adds_or_drops_do_no_harm(tmp_path):
    result = make_timeout()
    result.metrics["mine"] = 4.0
    result.metrics.drop("path_length", inplace=True)
    page = WriteReport(result, tmp_path / "report.html").read_text()
    assert "path_length" not in page
    assert with_situations(result).metrics["mine"] == 4.0


def test_values_by_behavior_are_those_of_the_table():
    tables = make_timeout().tables
    before = tables.values_by_behavior
    assert "regular" in tables.by_behavior.index
    assert repr(tables.values_by_behavior) == repr(before)
    tables.by_behavior.loc["regular", "path_length"] = 9.0
    assert tables.values_by_behavior["regular"]["path_length"] == 9.0


def test_a_run_comes_back_bit_for_bit(tmp_path):
    result = make_timeout()
    result.metrics[:] = (
        np.random.default_rng(0).normal(size=len(COMMON_METRICS)) ** 9
    )
    WriteResult(result, tmp_path, tag="a")
    (again,) = LoadResults(tmp_path)
    assert again.tag == "a"
    pd.testing.assert_series_equal(
        again.metrics, result.metrics, check_exact=True
    )
    pd.testing.assert_frame_equal(again.by_behavior, result.by_behavior)


def test_a_second_run_leaves_the_first_as_it_is(tmp_path):
    folder = WriteResult(make_timeout(), tmp_path)
    before = snapshot(folder)
    WriteResult(make_timeout(), tmp_path)
    WriteResult(make_timeout(seed=3), tmp_path)
    WriteResult(make_timeout(seed=10), tmp_path)
    assert snapshot(folder) == before
    # Numbers in tags are in the order of their size.
    assert ReadRuns(tmp_path)["tag"].tolist() == [
        "passing_pursuit_0",
        "passing_pursuit_0_run2",
        "passing_pursuit_3",
        "passing_pursuit_10",
    ]


def test_a_taken_tag_is_refused(tmp_path):
    folder = WriteResult(make_timeout(), tmp_path, tag="a")
    before = snapshot(folder)
    with pytest.raises(FileExistsError, match=r"'a' is taken.*runs/a"):
        WriteResult(make_timeout(seed=4), tmp_path, tag="a")
    assert snapshot(tmp_path / "runs") == {
        f"a/{name}": content for name, content in before.items()
    }
    assert len(list(read_rows(tmp_path / NAME))) == 1


def test_of_two_writers_of_one_run_the_first_to_end_wins(tmp_path):
    def write_again(folder):
        # The other one begins later, and ends earlier.
        assert list(find_runs(tmp_path)) == []
        WriteResult(make_timeout(seed=1), tmp_path, tag="a")

    with pytest.raises(FileExistsError, match="'a' is taken"):
        WriteResult(make_timeout(), tmp_path, tag="a", add=write_again)
    assert ReadRuns(tmp_path)["seed"].tolist() == [1]
    assert os.listdir(tmp_path / "runs") == ["a"]


def test_a_writer_without_a_tag_takes_the_next_free_one(tmp_path):
    others = []

    def write_again(folder):
        if not others:
            others.append(WriteResult(make_timeout(), tmp_path).name)

    folder = WriteResult(make_timeout(), tmp_path, add=write_again)
    assert others == ["passing_pursuit_0"]
    assert folder.name == "passing_pursuit_0_run2"
    assert sorted(os.listdir(tmp_path / "runs")) == [*others, folder.name]


def test_more_files_of_a_run_appear_with_it(tmp_path):
    def add(folder):
        assert not list(find_runs(tmp_path))
        (folder / "report.html").write_text("<p>")

    folder = WriteResult(make_timeout(), tmp_path, add=add)
    assert find_pages(tmp_path, folder.name) == {
        "report": folder / "report.html"
    }


def test_if_a_file_cannot_be_written_there_is_no_run(tmp_path):
    def fail(folder):
        (folder / "report.html").write_text("<p>")
        raise ValueError("no report")

    with pytest.raises(ValueError, match="no report"):
        WriteResult(make_timeout(), tmp_path, add=fail)
    assert os.listdir(tmp_path / "runs") == []


@pytest.mark.parametrize("tag", ["", "../a", " a", "a/b", "..", ".a"])
def test_a_tag_must_fit_into_the_name_of_a_file(tmp_path, tag):
    with pytest.raises(ValueError, match="the tag must be fit"):
        WriteResult(make_timeout(), tmp_path, tag=tag)
    assert not list(tmp_path.iterdir())


def test_a_run_has_a_tag_whatever_its_scenario_is_called(tmp_path):
    names = ("..", ".hidden", "a/b", "", "\u597d\u5947", "x" * 300)
    folders = [
        WriteResult(
            make_timeout(scenario_name=name, provenance={}), tmp_path
        ).name
        for name in names
    ]
    assert folders == ["trial", "hidden", "a_b", "trial_run2", "_", "x" * 80]
    assert sorted(os.listdir(tmp_path / "runs")) == sorted(folders)
    assert {r.scenario_name for r in LoadResults(tmp_path)} == set(names)


def test_a_table_has_runs_with_other_metrics(tmp_path):
    WriteResult(make_timeout(metric_names=["path"]), tmp_path, tag="a")
    WriteResult(make_timeout(metric_names=["goal"]), tmp_path, tag="b")
    table = ReadRuns(tmp_path).set_index("tag")
    assert table.loc["a", "path_length"] == pytest.approx(0.2)
    assert math.isnan(table.loc["b", "path_length"])
    assert table.loc["b", "completed"] == 0


def test_behaviors_do_not_write_over_each_other(tmp_path):
    behaviors = (
        "run away",
        "run_away",
        "\u597d\u5947",
        "\u5bb3\u6015",
        "x" * 300,
    )
    humans = np.zeros((3, 5, 7))
    humans[..., 0] = [2, 3, 4, 5, 6]
    recording = Recording(
        times=np.arange(3) * 0.1,
        robot=np.zeros((3, 7)),
        humans=humans,
        behaviors=behaviors,
    )
    result = MakeTrialResult(
        recording, provenance={}, end_reason="end", metric_names="paper"
    )
    for tag in "ab":
        folder = WriteResult(result, tmp_path, tag=tag)
    table = ReadRuns(tmp_path, by_behavior=True)
    assert table["tag"].tolist() == ["a"] * 5 + ["b"] * 5
    assert table["behavior"].tolist() == [*behaviors, *behaviors]
    expected = result.by_behavior["min_dist_to_people"].tolist()
    assert table["min_dist_to_people"].tolist() == [*expected, *expected]
    assert len(list(folder.glob("steps_beh_*.csv"))) == 5
    # A name that is fit stays as it is.
    assert (folder / "steps_beh_run_away.csv").exists()


def _write_many(arguments):
    folder, worker = arguments
    for i in range(5):
        WriteResult(
            make_timeout(seed=i, metric_names=["path"]),
            folder,
            tag=None if i % 2 else f"w{worker}_{i}",
        )


@pytest.mark.slow
@forks
def test_parallel_writers_lose_no_run(tmp_path):
    with ProcessPoolExecutor(4, mp_context=get_context("fork")) as pool:
        list(pool.map(_write_many, [(tmp_path, w) for w in range(4)]))
    table = ReadRuns(tmp_path)
    assert len(table) == len(LoadResults(tmp_path)) == 20
    assert not table["path_length"].isna().any()
    assert not list((tmp_path / "runs").glob(".*"))


def _write_forever(folder, finished):
    while True:
        WriteResult(make_timeout(metric_names=["path"]), folder)
        finished.value += 1


@pytest.mark.slow
@forks
def test_a_killed_writer_leaves_whole_runs_only(tmp_path):
    # (Who is killed with its lock would keep it.)
    finished = get_context("fork").Value("i", 0, lock=False)
    WriteResult(make_timeout(metric_names=["path"]), tmp_path)
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
    results = LoadResults(tmp_path)
    # The last run of each may be there without having been counted.
    assert 1 + finished.value <= len(results) <= 21 + finished.value
    assert finished.value >= 20
    names = [set(os.listdir(f)) for f in (tmp_path / "runs").glob("[!.]*")]
    assert len(names[0]) == 5
    assert names == [names[0]] * len(results)
    WriteResult(make_timeout(), tmp_path)


def _killed_while_writing(folder):
    def die(path):
        os.kill(os.getpid(), signal.SIGKILL)

    WriteResult(make_timeout(), folder, tag="a", add=die)


@forks
def test_a_run_whose_writer_was_killed_can_be_repeated(tmp_path):
    """What a runner of many trials needs: the tags tell what is done."""
    process = get_context("fork").Process(
        target=_killed_while_writing, args=(tmp_path,)
    )
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    assert len(os.listdir(tmp_path / "runs")) == 1
    assert find_runs(tmp_path) == {}
    with pytest.raises(FileNotFoundError, match="hunav run SCENARIO --out"):
        LoadResults(tmp_path)
    WriteResult(make_timeout(), tmp_path, tag="a")
    assert list(find_runs(tmp_path)) == ["a"]


# --- damaged runs ---


def wrong(value, *keys):
    """Returns a damage that sets an entry of a summary to a value."""

    def damage(folder):
        path = folder / "result.json"
        summary = json.loads(path.read_text())
        place = summary
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = value
        path.write_text(json.dumps(summary))

    return damage


def writes(name, content):
    return lambda folder: (folder / name).write_bytes(content)


def remove(name):
    return lambda folder: (folder / name).unlink()


def empty(folder):
    for path in folder.iterdir():
        path.unlink()


PATH_LENGTH = ("metrics", "path_length")
OWN = {"value": 1.0, "unit": "m", "family": "mine", "direction": "up"}


def forget_log(directory):
    """Leaves what versions without a log have written."""
    (directory / NAME).unlink()


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (empty, "result.json: No such file"),
        (remove("result.json"), "result.json: No such file"),
        (remove("recording.npz"), "recording.npz: No such file"),
        (writes("result.json", b""), "result.json: is not a result: the file"),
        (writes("result.json", b"{"), "the file: Invalid JSON"),
        (writes("result.json", b"\xff"), "the file: Invalid JSON"),
        (writes("result.json", b"[" * 10**5), "the file: Invalid JSON"),
        (writes("result.json", b"[]"), "the file: must be a mapping"),
        (writes("result.json", b"{}"), "scenario: Field required"),
        (wrong("1", "end_time"), "end_time: must be a number, got '1'"),
        (wrong(math.nan, "end_time"), "end_time: must be a finite number"),
        (wrong("bored", "end_reason"), "end_reason: unknown value 'bored'"),
        (wrong([], "metrics"), "metrics: must be a mapping"),
        (wrong([3], *PATH_LENGTH), r"metrics\.path_length: .*a list of 1"),
        (wrong([1], *PATH_LENGTH, "value"), "path_length: .*a list of 1"),
        (wrong("fast", *PATH_LENGTH, "value"), "path_length: .*got 'fast'"),
        (wrong(True, *PATH_LENGTH, "value"), "path_length: .*got true"),
        (wrong({}, *PATH_LENGTH, "value"), "path_length: .*got a mapping"),
        (wrong(OWN, "metrics", "my_own"), "direction: unknown value 'up'"),
        (wrong([0], "provenance", "seed"), r"seed.*must be .*a list of 1"),
        (wrong({"a": 1}, "by_behavior"), r"by_behavior\.a: .*got 1"),
        (writes("recording.npz", b""), "recording.npz: is not a recording"),
        (writes("recording.npz", b"PK\3\4"), "recording.npz: is not a rec"),
    ],
)
def test_a_damaged_run_is_named_with_what_to_do(tmp_path, damage, words):
    WriteResult(make_timeout(metric_names=["path"]), tmp_path, tag="good")
    bad = make_timeout(metric_names=["path"])
    damage(WriteResult(bad, tmp_path, tag="bad"))
    forget_log(tmp_path)
    remedy = r"(?s)/runs/bad/.*" + words + ".*Delete the damaged run"
    with pytest.raises(ValueError, match=remedy):
        LoadResults(tmp_path)
    damaged = {}
    results = LoadResults(tmp_path, damaged=damaged)
    assert [result.tag for result in results] == ["good"]
    assert list(damaged) == ["bad"]
    if "recording" not in words:
        with pytest.raises(ValueError, match=remedy):
            ReadRuns(tmp_path)
    # It does not stand in the way of others.
    WriteResult(make_timeout(metric_names=["path"]), tmp_path, tag="new")


@pytest.fixture
def work(monkeypatch):
    """Counts what is read and computed."""
    counts = {"summary": 0, "recording": 0, "result": 0}

    def count(name, function):
        def counted(*args, **kwargs):
            counts[name] += 1
            return function(*args, **kwargs)

        return counted

    for name, owner, function in (
        ("summary", result_files, "_read_summary"),
        ("recording", Recording, "load"),
        ("result", result_files, "MakeTrialResult"),
    ):
        monkeypatch.setattr(
            owner, function, count(name, getattr(owner, function))
        )
    return counts


def test_damage_is_found_before_the_work(tmp_path, work):
    result = make_timeout(metric_names=["path"])
    for i in range(12):
        WriteResult(result, tmp_path, tag=f"run_{i}")
    forget_log(tmp_path)
    runs = tmp_path / "runs"
    (runs / "run_11/recording.npz").write_bytes(b"")
    with pytest.raises(ValueError, match="run_11"):
        LoadResults(tmp_path)
    assert work == {"summary": 12, "recording": 12, "result": 0}
    work |= dict.fromkeys(work, 0)
    (runs / "run_0/result.json").write_text("{")
    with pytest.raises(ValueError, match="run_0"):
        LoadResults(tmp_path)
    assert work == {"summary": 12, "recording": 0, "result": 0}
    work |= dict.fromkeys(work, 0)
    for i in range(12):
        (runs / f"run_{i}/result.json").write_text("{")
    with pytest.raises(ValueError, match=r"run_4(?s:.*)and 7 more") as info:
        LoadResults(tmp_path)
    assert len(str(info.value).splitlines()) == 6
    assert LoadResults(tmp_path, damaged={}) == []
    assert work == {"summary": 24, "recording": 0, "result": 0}


def test_the_table_is_made_of_summaries_alone(tmp_path, work):
    for seed in range(3):
        WriteResult(make_timeout(seed=seed, metric_names="path"), tmp_path)
    runs = ReadRuns(tmp_path)
    people = ReadRuns(tmp_path, by_behavior=True)
    # The log tells all; if it is not there, each run does.
    assert work == {"summary": 0, "recording": 0, "result": 0}
    forget_log(tmp_path)
    pd.testing.assert_frame_equal(ReadRuns(tmp_path), runs)
    again = ReadRuns(tmp_path, by_behavior=True)
    pd.testing.assert_frame_equal(again, people)
    assert work == {"summary": 6, "recording": 0, "result": 0}


def test_a_run_that_is_deleted_and_done_again_is_the_new_one(tmp_path):
    shutil.rmtree(WriteResult(make_timeout(seed=1), tmp_path, tag="a"))
    with pytest.raises(FileNotFoundError, match="No results are there"):
        ReadRuns(tmp_path)
    WriteResult(make_timeout(seed=2), tmp_path, tag="a")
    assert ReadRuns(tmp_path)["seed"].tolist() == [2]
    (result,) = LoadResults(tmp_path)
    assert result.provenance["seed"] == 2


def test_a_line_that_was_cut_off_is_no_run_and_in_nobodys_way(tmp_path):
    WriteResult(make_timeout(seed=1), tmp_path)
    log = tmp_path / NAME
    whole = log.read_bytes()
    log.write_bytes(whole + whole[:100])
    assert ReadRuns(tmp_path)["seed"].tolist() == [1]
    WriteResult(make_timeout(seed=2), tmp_path)
    assert log.read_bytes().startswith(whole)
    assert [row.seed for row in read_rows(log)] == [1, 2]


def test_what_is_no_run_is_not_read(tmp_path):
    WriteResult(make_timeout(metric_names=["path"]), tmp_path, tag="a")
    (tmp_path / "runs/notes.txt").touch()
    (tmp_path / "runs/.a.0123456789abcdef.tmp").mkdir()
    (tmp_path / "plots").mkdir()
    assert [result.tag for result in LoadResults(tmp_path)] == ["a"]


@pytest.mark.parametrize("read", [LoadResults, ReadRuns])
@pytest.mark.parametrize("with_runs", [False, True])
def test_folders_of_old_versions_are_refused(tmp_path, read, with_runs):
    (tmp_path / "metrics.csv").write_text("tag,path_length\nold,0.2\n")
    if with_runs:
        WriteResult(make_timeout(metric_names="path"), tmp_path)
        assert len(read(tmp_path)) == 1
        (tmp_path / "recording_old.npz").touch()
    with pytest.raises(OSError, match=r"results of an old version.*hunav eval"):
        read(tmp_path)


def test_a_folder_that_is_a_file_is_named(tmp_path):
    path = tmp_path / "file"
    path.write_text("mine")
    with pytest.raises(OSError, match=r"cannot write the results.*file"):
        WriteResult(make_timeout(), path)
    assert path.read_text() == "mine"


@pytest.mark.parametrize("call", ["replace", "rename"])
def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, call):
    WriteResult(make_timeout(), tmp_path, tag="a")
    before = snapshot(tmp_path)

    def full(*args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    # A recording is written by the one, a folder by the other.
    monkeypatch.setattr(os, call, full)
    with pytest.raises(OSError, match=r"cannot write.*No space left") as info:
        WriteResult(make_timeout(), tmp_path, tag="b")
    assert info.value.errno == errno.ENOSPC
    assert snapshot(tmp_path) == before
    assert os.listdir(tmp_path / "runs") == ["a"]


def test_a_log_on_a_full_disk_is_named(tmp_path, monkeypatch):
    def full(*args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left") as info:
        append_rows(tmp_path, [make_row(make_timeout(), "a")])
    assert info.value.filename == str(tmp_path / NAME)


def test_the_table_for_the_terminal_is_narrow_and_complete():
    result = make_timeout(end_message="a very long story, " * 9)
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
    lines = FormatMetricsTable(make_timeout()).splitlines()
    for family in {metric.family for metric in COMMON_METRICS.values()}:
        assert family in lines


def test_a_result_keeps_a_copy_of_its_provenance():
    provenance = MakeProvenance("", 0)
    dut = make_timeout(provenance=provenance)
    provenance["seed"] = 1
    assert dut.provenance["seed"] == 0


def test_the_behavior_trees_have_a_place_in_it():
    assert "behavior_sha256" not in MakeProvenance("", 0)
    dut = MakeProvenance("", 0, behavior_sha256="abc")
    assert dut["behavior_sha256"] == "abc"


def test_one_name_of_metrics_is_enough():
    assert len(make_timeout(metric_names="paper").metrics) == 28
    assert len(make_timeout(metric_names="path_length").metrics) == 1


@pytest.fixture
def broken_metric(restored_metrics):
    """Registers metrics, and forgets them again."""

    def register(name, function):
        function.__doc__ = "Returns what a test needs."
        register_metric(name=name, unit="m", family="mine", source="me")(
            function
        )

    return register


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
        dut = make_timeout(metric_names=names)
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
    WriteResult(make_timeout(metric_names=["far", "near"]), tmp_path, tag="a")

    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    text = (tmp_path / "runs/a/result.json").read_text()
    values = json.loads(text, parse_constant=refuse)["metrics"]
    assert values["far"]["value"] == "Infinity"
    assert values["near"]["value"] == "-Infinity"
    (again,) = LoadResults(tmp_path)
    assert again.metrics.tolist() == [math.inf, -math.inf]


def test_the_table_of_runs_has_the_same_columns_in_files_and_in_memory(
    tmp_path,
):
    results = [make_timeout(seed=seed) for seed in (0, 1)]
    for result in results:
        WriteResult(result, tmp_path)
    loaded = LoadResults(tmp_path)
    for by_behavior, name in ((False, "runs"), (True, "runs_by_behavior")):
        table = tabulate_runs(loaded, by_behavior=by_behavior)
        assert table.attrs["units"]["path_length"] == "m"
        assert len(table) == (4 if by_behavior else 2)
        read = ReadRuns(tmp_path, by_behavior=by_behavior)
        pd.testing.assert_frame_equal(read, table)
        assert read.attrs == table.attrs
        assert WriteTables(loaded, tmp_path) == tmp_path / "runs.csv"
        pd.testing.assert_frame_equal(
            ReadRuns(tmp_path / f"{name}.csv"), table, check_dtype=False
        )


def test_an_unknown_metric_is_an_error():
    with pytest.raises(ValueError, match="did you mean 'path_length'"):
        make_timeout(metric_names=["path_lenght"])


def test_the_path_may_be_a_string(tmp_path):
    assert WriteResult(make_timeout(), str(tmp_path)).parent == (
        tmp_path / "runs"
    )
    assert len(LoadResults(str(tmp_path))) == 1
