"""Whoever runs a suite, the tables are the same."""

from concurrent.futures import Future, ThreadPoolExecutor
import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.cells import make_cells
from hunav_drake.runs.run_log import NAME, read_rows
from hunav_drake.runs.tasks import Task, UnfitWorkerError, do_task
from tests.hunav_drake.runs.suite_texts import texts_of
from tests.processes import dask_client

SUITE = """
name: small
scenarios: [crossing, combined]
planners: [pursuit, {type: pursuit, cruise_speed: 0.4, label: slow}]
overrides: [simulation.duration=1.0]
seeds: 8
relations:
  - {scenarios: [crossing], metric: completed, holds: slow <= pursuit}
"""

# Runs the suite in an interpreter of its own, which begins without threads.
CODE = """
import json
import sys
from hunav_drake.runs import LoadSuite, RunSuite
from tests.hunav_drake.runs.suite_texts import texts_of

result = RunSuite(LoadSuite(filename=sys.argv[1]), workers=1)
print(json.dumps(texts_of(result)))
"""
NO_THREADS = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    ),
    "1",
)


@pytest.fixture(scope="module")
def one():
    """What one worker gives."""
    return texts_of(RunSuite(LoadSuite(data=SUITE), workers=1))


@pytest.mark.slow
def test_tables_are_the_same_bit_for_bit_whoever_runs_them(one, tmp_path):
    suite = LoadSuite(data=SUITE)
    assert '"verdict": "holds"' in one["json"]
    two = RunSuite(suite, workers=2, out=tmp_path)
    assert texts_of(two) == one
    with ThreadPoolExecutor(3) as executor:
        threads = RunSuite(suite, executor=executor, workers=3)
    assert texts_of(threads) == one
    file = tmp_path / "small.yaml"
    file.write_text(SUITE)
    output = subprocess.run(
        [sys.executable, "-c", CODE, str(file)],
        env={**os.environ, **NO_THREADS},
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert json.loads(output) == one


@pytest.mark.slow
def test_a_dask_worker_that_is_killed_changes_nothing(one, tmp_path):
    suite = LoadSuite(data=SUITE)
    killed = []
    with dask_client(4) as client:
        assert len(set(client.run(os.getpid).values())) == 4

        def kill(row, done, total):
            if done >= total // 2 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        result = RunSuite(
            suite,
            executor=client.get_executor(pure=False),
            workers=4,
            out=tmp_path,
            progress=kill,
        )
    assert killed
    assert texts_of(result) == one
    rows = list(read_rows(tmp_path / NAME))
    assert len({row.key for row in rows}) == len(rows) == 32


@pytest.mark.slow
def test_a_cluster_on_other_processes_is_used_by_its_address(
    hunav, one, tmp_path
):
    """As the page on benchmarks prints it: a scheduler, workers, a command."""
    pytest.importorskip("distributed", reason="the extra `dask` is not here")
    suite = tmp_path / "small.yaml"
    suite.write_text(SUITE)
    where = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    file = ["--scheduler-file", str(where)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with contextlib.ExitStack() as stack:
        for arguments in (
            ("scheduler", "--host", "127.0.0.1", "--port", "0"),
            ("worker", "--nworkers", "2", "--nthreads", "1"),
        ):
            process = subprocess.Popen(
                [*dask, *arguments, "--no-dashboard", *file],
                cwd=tmp_path,
                **quiet,
            )
            stack.callback(process.wait)
            stack.callback(process.terminate)
            for _ in range(600):
                if where.exists():
                    break
                time.sleep(0.1)
        address = json.loads(where.read_text())["address"]
        code, _, err = hunav(
            *("bench", suite, "--out", tmp_path / "out", "--quiet"),
            *("--executor", "dask", "--address", address),
        )
    assert code == 0, err
    out = tmp_path / "out" / "small"
    rows = list(read_rows(out / NAME))
    assert len({row.key for row in rows}) == len(rows) == 32
    # All is done, so this only reads it.
    assert texts_of(RunSuite(LoadSuite(data=SUITE), out=out)) == one
    assert len(list(read_rows(out / NAME))) == 32


def test_dask_needs_an_address(hunav, tmp_path):
    code, _, err = hunav("bench", "paper", "--executor", "dask")
    assert code == 2
    assert "--address HOST:PORT" in err
    code, _, err = hunav("bench", "paper", "--address", "localhost:1")
    assert code == 2
    assert "--executor dask" in err


def test_without_dask_the_remedy_is_told(hunav, monkeypatch):
    import importlib.util

    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util,
        "find_spec",
        lambda name, *a: None if name == "distributed" else find(name, *a),
    )
    code, _, err = hunav(
        *("bench", "paper", "--executor", "dask", "--address", "localhost:1")
    )
    assert code == 2
    assert "pip install 'hunav_drake[dask]'" in err


def test_a_scheduler_that_does_not_answer_is_told(hunav, tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="the extra `dask` is not here")
    from hunav_drake.runs import cluster

    monkeypatch.setattr(cluster, "_SCHEDULER", 0.5)
    code, _, err = hunav(
        *("bench", "paper", "--out", tmp_path),
        *("--executor", "dask", "--address", "localhost:1"),
    )
    assert code == 2
    assert "--address localhost:1: no Dask scheduler answers" in err
    assert "dask scheduler" in err
    assert "Traceback" not in err


class FakeClient:
    """A cluster of some workers that have these versions."""

    def __init__(self, versions):
        self.versions = versions

    def wait_for_workers(self, n_workers, timeout):
        if not self.versions:
            raise TimeoutError

    def run(self, function, on_error):
        assert on_error == "return"
        here = function()
        return {
            worker: it if isinstance(it, Exception) else here | it
            for worker, it in self.versions.items()
        }


def test_workers_of_other_versions_are_refused():
    pytest.importorskip("distributed", reason="the extra `dask` is not here")
    from hunav_drake.runs.cluster import ClusterError, check_workers

    check_workers(FakeClient({"tcp://a": {}, "tcp://b": {}}))
    with pytest.raises(ClusterError, match="had no worker"):
        check_workers(FakeClient({}))
    other = {"tcp://a": {}, "tcp://b": {"numpy": "1.0"}}
    with pytest.raises(
        ClusterError, match=r"numpy is 1\.0, not .* 1 of 2 .*tcp://b"
    ):
        check_workers(FakeClient(other))
    missing = {"tcp://a": ModuleNotFoundError("No module named 'hunav_drake'")}
    with pytest.raises(ClusterError, match="No module named 'hunav_drake'"):
        check_workers(FakeClient(missing))


@pytest.mark.slow
def test_a_worker_that_came_later_with_another_version_ends_the_suite(
    tmp_path, monkeypatch
):
    from hunav_drake.runs import tasks

    suite = LoadSuite(data=SUITE)
    monkeypatch.setattr(tasks, "_sha256_here", lambda text: "another")
    with (
        ThreadPoolExecutor(1) as executor,
        pytest.raises(UnfitWorkerError, match="install the same on all"),
    ):
        RunSuite(suite, executor=executor, out=tmp_path)
    assert not (tmp_path / NAME).read_bytes()


@pytest.mark.slow
def test_code_that_is_changed_while_a_suite_runs_ends_it(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("SPEED = 0.1\n")

    class Edited(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            file.write_text("SPEED = 0.2\n")
            return super().submit(fn, *args, **kwargs)

    with (
        Edited(1) as executor,
        pytest.raises(UnfitWorkerError, match=r"other code of .*mine\.py than"),
    ):
        RunSuite(LoadSuite(data=SUITE), executor=executor, imports=[str(file)])


def test_workers_import_user_code_first_and_once(tmp_path):
    suite = LoadSuite(data=SUITE)
    cell = make_cells(suite)[0]
    code = tmp_path / "mine.py"
    count = tmp_path / "count"
    code.write_text(f"open({str(count)!r}, 'a').write('x')\n")
    task = Task(cell=cell, code=(), runs=((0, 0),), imports=(str(code),))
    assert do_task(task)[0].end_reason == "timeout"
    do_task(task)
    assert count.read_text() == "x"
    missing = Task(**{**vars(task), "imports": (str(tmp_path / "nowhere.py"),)})
    with pytest.raises(UnfitWorkerError, match=r"nowhere\.py"):
        do_task(missing)


def test_a_cluster_that_gives_up_is_told(tmp_path):
    class Lost(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            future = super().submit(lambda: None)
            future.result()
            if fn is do_task:
                future = Future()
                future.cancel()
                future.set_running_or_notify_cancel()
            return future

    with Lost(1) as executor, pytest.raises(ConnectionError, match="are kept"):
        RunSuite(LoadSuite(data=SUITE), executor=executor, out=tmp_path)
    assert not (tmp_path / NAME).read_bytes()
