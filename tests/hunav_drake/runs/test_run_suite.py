import dataclasses
import json
import re
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from hunav_drake.runs import (
    LoadResults,
    LoadSuite,
    ReadRuns,
    RunSuite,
    Suite,
    WriteResult,
    code_hash,
)
from hunav_drake.runs.code_hash import hash_code
from hunav_drake.runs.run_log import NAME, RunLog, read_rows
from hunav_drake.runs.run_row import row_to_json
from hunav_drake.runs.tasks import Task
from hunav_drake.scenario import ScenarioError
from hunav_drake.systems.planning import (
    Plan,
    Planner,
    PlannerStatus,
    register_planner,
)
from tests.hunav_drake.runs.made_runs import make_cell, make_row

SUITE = """
name: small
scenarios: [crossing]
planners: [pursuit, {type: pursuit, cruise_speed: 0.4, label: slow}]
overrides: [simulation.duration=2.0]
seeds: 4
"""


@pytest.fixture
def suite():
    return LoadSuite(data=SUITE)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The suite, run once, and its folder."""
    out = tmp_path_factory.mktemp("done")
    return RunSuite(LoadSuite(data=SUITE), out=out, workers=1), out


@pytest.fixture(scope="module")
def reference(done):
    return done[0].runs()


@pytest.fixture
def out(done, tmp_path):
    """A folder in which the suite has been run."""
    return shutil.copytree(done[1], tmp_path / "done")


def assert_same(runs, reference):
    pd.testing.assert_frame_equal(runs, reference, check_exact=True)


@pytest.mark.slow
def test_a_row_for_each_run_in_the_order_of_the_suite(reference):
    assert list(reference.planner) == ["pursuit"] * 4 + ["slow"] * 4
    assert list(reference.seed) == [0, 1, 2, 3] * 2
    assert (reference.end_reason == "timeout").all()
    fast, slow = reference.path_length[:4], reference.path_length[4:]
    assert (fast.to_numpy() > slow.to_numpy()).all()


def test_equals_single_trials(reference):
    from hunav_drake import LoadScenario, RunTrial

    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=2.0"]
    )
    metrics = RunTrial(scenario, 3).metrics
    row = reference[(reference.planner == "pursuit") & (reference.seed == 3)]
    for name, value in metrics.items():
        np.testing.assert_array_equal(row[name].to_numpy(), [value])


def test_stopped_and_resumed_gives_the_same(suite, reference, tmp_path):
    class Stop(Exception):
        pass

    def stop(row, done, total):
        assert total == 8
        if done == 3:
            raise Stop

    with pytest.raises(Stop):
        RunSuite(suite, out=tmp_path, workers=1, progress=stop)
    kept = list(read_rows(tmp_path / NAME))
    assert 3 <= len(kept) < 8
    seen = []
    result = RunSuite(
        suite,
        out=tmp_path,
        workers=1,
        progress=lambda row, done, total: seen.append(row.key),
    )
    assert_same(result.runs(), reference)
    assert not set(seen) & {row.key for row in kept}
    # All is there: nothing is run.
    again = RunSuite(suite, out=tmp_path, workers=1, progress=lambda *_: 1 / 0)
    assert_same(again.runs(), reference)


@pytest.mark.slow
def test_a_cut_off_line_is_run_again(suite, reference, out):
    path = out / NAME
    path.write_bytes(path.read_bytes()[:-100])
    assert_same(RunSuite(suite, out=out, workers=1).runs(), reference)
    assert len(list(read_rows(path))) == 8


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"metrics": True}, "metrics: must be a mapping, got true"),
        ({"metrics": {"a": "x"}}, "metrics.a: must be a number, got 'x'"),
        ({"by_behavior": {"a": []}}, "by_behavior.a: must be a mapping"),
        ({"seed": 1.5}, "seed: must be a whole number, got 1.5"),
        ({"planner": None}, "planner: must be text, got nothing"),
        ({"cost": [1]}, "cost: must be a mapping, got a list of 1"),
        ({"end_time": "late"}, "end_time: must be a number, got 'late'"),
        ({"more": 1}, "there is no field 'more'"),
    ],
)
def test_a_row_with_a_wrong_value_is_told(tmp_path, change, told):
    row = row_to_json(make_row(make_cell("a", "b"), 0, {"m": float("nan")}))
    path = tmp_path / NAME
    path.write_text(f"{row}\n{json.dumps(json.loads(row) | change)}\n")
    with pytest.raises(ValueError, match=re.escape(told)) as caught:
        list(read_rows(path))
    assert str(caught.value).startswith(f"{path}:2: is damaged: is not a run")


def test_a_damaged_line_is_told_by_its_number(suite, out):
    path = out / NAME
    lines = path.read_text().splitlines(keepends=True)
    path.write_text(lines[0] + "{}\n" + "".join(lines[2:]))
    with pytest.raises(ValueError, match=r"runs.jsonl:2: is damaged.*delete"):
        RunSuite(suite, out=out, workers=1)


@pytest.mark.slow
def test_a_changed_scenario_is_noticed(suite, out):
    changed = dataclasses.replace(suite, overrides=["simulation.duration=1.0"])
    with pytest.raises(ValueError, match=r"4 of crossing/pursuit.*--fresh"):
        RunSuite(changed, out=out, workers=1)
    result = RunSuite(changed, out=out, workers=1, fresh=True)
    assert (result.runs().end_time == 1.0).all()
    assert len(list(read_rows(out / "runs_old.jsonl"))) == 8


def test_beginning_anew_again_loses_nothing(tmp_path):
    for text in ("whole", "few", ""):
        (tmp_path / "recordings").mkdir()
        (tmp_path / "recordings" / "a.npz").write_text(text)
        (tmp_path / NAME).write_text(text)
        with RunLog(tmp_path, fresh=True):
            pass
    assert not (tmp_path / NAME).read_bytes()
    assert sorted(it.name for it in tmp_path.iterdir()) == [
        *("recordings_old", "recordings_old_2", "recordings_old_3"),
        *("runs.jsonl", "runs_old.jsonl", "runs_old_2.jsonl"),
    ]
    for end, text in (("", "whole"), ("_2", "few")):
        assert (tmp_path / f"runs_old{end}.jsonl").read_text() == text
        kept = tmp_path / f"recordings_old{end}" / "a.npz"
        assert kept.read_text() == text


PLANNER = """
from dataclasses import dataclass

from hunav_drake.systems.planning import (
    Plan,
    Planner,
    PlannerStatus,
    register_planner,
)


@register_planner("NAME")
@dataclass
class Edited(Planner):
    def plan(self, task, view, memory):
        return Plan(SPEED, 0.0, PlannerStatus.DRIVING)
"""


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_changed_code_of_the_user_is_noticed(workers, tmp_path, hunav):
    file, out = tmp_path / "mine.py", tmp_path / "out"
    suite = tmp_path / "suite.yaml"
    # What was registered stays for the tests to come.
    name = f"edited_{workers}"
    text = SUITE.replace("[pursuit, {", f"[{name}, {{")
    suite.write_text(text.replace("seeds: 4", "seeds: 2"))
    command = "bench", suite, "--import", file, "--workers", workers
    ways = []
    for speed in (0.1, 0.3):
        text = PLANNER.replace("SPEED", str(speed)).replace("NAME", name)
        file.write_text(text)
        if ways:
            code, _, err = hunav(*command, "--out", out)
            assert code != 0
            assert "other scenarios, behavior trees, code or versions" in err
            assert f"2 of crossing/{name}, 2 of crossing/slow" in err
            code, _, err = hunav(*command, "--out", out, "--fresh")
        else:
            code, _, err = hunav(*command, "--out", out)
        assert code == 0, err
        runs = pd.read_csv(out / "small" / "runs.csv")
        ways.append(runs[runs.planner == name].path_length.mean())
    assert ways[1] > 2 * ways[0]


def test_changed_code_of_the_package_is_noticed(suite, done, out, monkeypatch):
    result, _ = done
    assert {row.code_sha256 for row in result.rows} == {result.code_sha256}
    monkeypatch.setattr(code_hash, "_KINDS", (".xml",))
    with pytest.raises(ValueError, match=r"code or versions .4 of crossing/"):
        RunSuite(suite, out=out, workers=1)


def test_runs_of_before_code_had_a_hash_are_of_other_code(suite, out):
    rows = [json.loads(it) for it in (out / NAME).open()]
    for row in rows:
        del row["code_sha256"]
    lines = (json.dumps(row) + "\n" for row in rows)
    (out / NAME).write_text("".join(lines))
    with pytest.raises(ValueError, match=r"code or versions .*--fresh"):
        RunSuite(suite, out=out, workers=1)


def test_a_finished_suite_may_be_where_nothing_can_be_written(suite, out):
    times = {it: it.stat().st_mtime_ns for it in out.rglob("*")}
    RunSuite(suite, out=out, workers=1)
    assert {it: it.stat().st_mtime_ns for it in out.rglob("*")} == times


def test_two_drivers_cannot_share_a_folder(suite, tmp_path):
    with (
        RunLog(tmp_path),
        pytest.raises(BlockingIOError, match="in use by another"),
    ):
        RunSuite(suite, out=tmp_path, workers=1)


@pytest.mark.slow
def test_worker_processes_change_nothing(suite, reference, tmp_path):
    result = RunSuite(suite, out=tmp_path, workers=2)
    assert_same(result.runs(), reference)
    assert len(list((tmp_path / "recordings").iterdir())) == 2


@pytest.mark.slow
def test_any_executor_will_do(suite, reference):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as executor:
        assert_same(RunSuite(suite, executor=executor).runs(), reference)


@register_planner("fails_at_odd_seeds")
@dataclasses.dataclass
class Failing(Planner):
    def plan(self, task, view, memory):
        if view.robot[0] > 1.0005:
            raise RuntimeError("lost its way")
        return Plan(0.2, 0.0, PlannerStatus.DRIVING)


@pytest.mark.slow
def test_a_bad_run_is_a_row_with_its_reason(suite):
    mixed = dataclasses.replace(
        suite, planners=["fails_at_odd_seeds", "pursuit"], seeds=2
    )
    mixed.overrides = [
        "simulation.duration=2.0",
        "robot.start=[1.0, -4.75, 0.0]",
    ]
    result = RunSuite(mixed, workers=1)
    assert [row.seed for row in result.failures] == [0, 1]
    assert all("lost its way" in row.end_message for row in result.failures)
    assert (
        list(result.runs().end_reason)
        == ["planner_failed"] * 2 + ["timeout"] * 2
    )


@pytest.mark.slow
def test_stops_when_a_mean_is_known_whoever_is_first(suite):
    until = {"metric": "path_length", "half_width": 1e-4, "least": 3}
    known = dataclasses.replace(suite, until=until, seeds=50)
    one = RunSuite(known, workers=1).runs()
    # (All paths are equal to 1e-4 from the third run on.)
    assert (one.groupby("planner").size() < 50).all()
    wide = dataclasses.replace(
        suite,
        until={"metric": "min_dist_to_people", "half_width": 1e-9},
        seeds=8,
    )
    assert len(RunSuite(wide, workers=1).runs()) == 16


def test_seeds_and_repetitions(suite):
    twice = dataclasses.replace(
        suite, planners=["pursuit"], seeds=[7, 3], repetitions=2
    )
    runs = RunSuite(twice, workers=1).runs()
    assert list(runs.seed) == [7, 7, 3, 3]
    assert list(runs.repetition) == [0, 1, 0, 1]
    a = runs[runs.repetition == 0].path_length.to_numpy()
    b = runs[runs.repetition == 1].path_length.to_numpy()
    np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scenarios: []", "scenarios: must be a list of at least 1"),
        ("scenarios: [passing]\nseeds: 0", "data:2: seeds: must be the number"),
        ("scenarios: [passing]\nseeds: [1, 1]", "a list of different seeds"),
        ("scenarios: [passing]\nplaner: x", "did you mean 'planners'"),
        ("scenarios: [passing]\nuntil: {metric: a}", "half_width: is missing"),
        ("", "is empty"),
    ],
)
def test_faults_of_a_suite_have_their_place(text, message):
    with pytest.raises(ScenarioError) as caught:
        LoadSuite(data=text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scenarios": ["pasing"]}, "did you mean passing"),
        ({"planners": ["dwbb"]}, "dwbb"),
        ({"overrides": ["robot.radius=-1"]}, "robot.radius"),
        ({"scenarios": ["crossing", "crossing"]}, "two cells are called"),
    ],
)
def test_the_whole_suite_is_checked_before_anything_runs(changes, message):
    suite = dataclasses.replace(LoadSuite(data=SUITE), **changes)
    with pytest.raises(ScenarioError) as caught:
        RunSuite(suite, workers=1, progress=lambda *_: 1 / 0)
    assert message in str(caught.value)


@pytest.mark.slow
def test_relative_paths_begin_at_the_suite(tmp_path, hunav):
    from hunav_drake import LoadScenario, SaveScenario

    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.duration=1.0"]
    )
    SaveScenario(scenario, tmp_path / "room.yaml")
    file = tmp_path / "suite.yaml"
    file.write_text("scenarios: [room.yaml]\nseeds: 1\n")
    code, out, err = hunav(
        "bench", file, "--out", tmp_path / "out", "--workers", 1
    )
    assert code == 0, err
    assert "time_to_reach_goal" in out
    assert (tmp_path / "out" / "suite" / "report.html").is_file()


# Runs the suite in processes that it kills at random instants: some while they
# look at the log, some while they run, some while they write. It copies itself,
# so that none has to import everything again.
KILLED = """
import os
from pathlib import Path
import signal
import sys
import time

import numpy as np

from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.run_log import NAME, read_rows

suite = LoadSuite(filename=sys.argv[1])
out = Path(sys.argv[2])
log = out / NAME
RunSuite(suite, workers=1)


def size():
    return log.stat().st_size if log.exists() else 0


random = np.random.default_rng(0)
for _ in range(20):
    before, tasks = size(), random.integers(3)
    pid = os.fork()
    if pid == 0:
        RunSuite(suite, out=out, workers=1)
        os._exit(0)
    written = before
    while tasks and os.waitpid(pid, os.WNOHANG) == (0, 0):
        time.sleep(1e-3)
        if size() > written:
            written, tasks = size(), tasks - 1
    time.sleep(random.uniform(0.0, 0.2))
    os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    assert os.WIFSIGNALED(status), "it had ended before it was killed"
    rows = list(read_rows(log)) if log.exists() else []
    assert len({row.key for row in rows}) == len(rows)
    print(len(rows), flush=True)
"""


@pytest.mark.slow
def test_killed_at_any_instant_and_resumed(suite, tmp_path):
    suite.seeds = 150
    file = tmp_path / "small.yaml"
    file.write_text(
        SUITE.replace("seeds: 4", "seeds: 150").replace("=2.0", "=0.5")
    )
    suite.overrides = ["simulation.duration=0.5"]
    reference = RunSuite(suite, workers=1).runs()
    output = subprocess.run(
        [sys.executable, "-c", KILLED, str(file), str(tmp_path / "out")],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout
    kept = [int(line) for line in output.split()]
    assert len(kept) == 20
    # None was lost, most have got further, and the last had some left to do.
    assert kept == sorted(kept)
    assert len(set(kept)) > 10
    assert 20 < kept[-1] < 300
    result = RunSuite(suite, out=tmp_path / "out", workers=1)
    assert_same(result.runs(), reference)
    rows = list(read_rows(tmp_path / "out" / NAME))
    assert len({row.key for row in rows}) == len(rows) == 300


def test_tasks_are_small_enough_to_send(suite):
    import pickle

    task = Task(
        cell=dataclasses.replace(
            make_cell("a", "b"), sha256="0" * 64, text="x" * 5000
        ),
        code=hash_code(),
        runs=((0, 0),),
    )
    assert len(pickle.dumps(task)) < 6000
    assert task.one(3, 1).runs == ((3, 1),)


def test_rows_are_read_back_to_the_last_bit(done):
    result, out = done
    for row, line in zip(
        sorted(result.rows, key=lambda r: r.key),
        sorted(read_rows(out / NAME), key=lambda r: r.key),
        strict=True,
    ):
        assert json.dumps(row.metrics) == json.dumps(line.metrics)
        assert row.end_time == line.end_time


def test_a_suite_in_python_is_that_of_a_file(suite):
    made = Suite(
        name="small",
        scenarios=["crossing"],
        planners=[
            "pursuit",
            {"type": "pursuit", "cruise_speed": 0.4, "label": "slow"},
        ],
        overrides=["simulation.duration=2.0"],
        seeds=4,
    )
    assert made == suite


def test_scenarios_may_have_seeds_of_their_own():
    suite = LoadSuite(filename="paper")
    assert suite.seed_list("passing") == list(range(10))
    assert suite.seed_list("combined") == list(range(30))
    assert suite.seed_list("free_run") == [0]


@pytest.mark.slow
def test_the_folder_of_a_suite_is_read_as_any_other(suite, tmp_path):
    result = RunSuite(suite, out=tmp_path, workers=1)
    for by_behavior in (False, True):
        runs = result.runs(by_behavior=by_behavior)
        read = ReadRuns(tmp_path, by_behavior=by_behavior)
        assert_same(read, runs)
        assert read.attrs == runs.attrs
    runs = result.runs()
    runs.to_csv(tmp_path / "runs.csv", index=False)
    pd.testing.assert_frame_equal(
        ReadRuns(tmp_path / "runs.csv"), runs, check_dtype=False
    )
    # A recording is kept of the first seed of each cell.
    kept = LoadResults(tmp_path)
    assert [it.provenance["planner"] for it in kept] == ["pursuit", "slow"]
    assert [it.metrics.path_length for it in kept] == [
        *runs[runs.seed == 0].path_length
    ]
    # Single runs may be written into the same folder.
    WriteResult(kept[0], tmp_path)
    assert len(ReadRuns(tmp_path)) == len(runs) + 1
    assert len(LoadResults(tmp_path)) == 3
    assert_same(RunSuite(suite, out=tmp_path, workers=1).runs(), runs)


def test_a_log_of_before_rows_told_their_planner_is_read(tmp_path):
    row = make_row(make_cell("hall", "dwb"), 3, {"path_length": 2.0})
    data = json.loads(row_to_json(row))
    for name in ("scenario", "planner", "setting"):
        del data[name]
    data |= {"cell": "hall/dwb/fast", "repetition": 0}
    (tmp_path / NAME).write_text(json.dumps(data) + "\n")
    (read,) = ReadRuns(tmp_path).to_dict("records")
    assert (read["scenario"], read["planner"]) == ("hall", "dwb")
    assert (read["setting"], read["seed"]) == ("fast", 3)
    assert read["path_length"] == 2.0
