"""The worker with its processes; each takes some seconds to load."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from hunav_drake.editor.worker import Worker
from hunav_drake.editor.worker.requests import RunRequest

pytestmark = pytest.mark.slow

TEXT = """
humans: [{name: ana, pose: [2, 0.1, 3.14], goals: [[-3, 0]]}]
robot: {start: [-2, 0, 0], goal: [2.5, 0, 0]}
planner: pursuit
simulation: {duration: 12.0}
"""
LONG = """
humans: [{name: ana, pose: [2, 3, 0], goals: [[-3, 3], [3, 3]]}]
robot: {start: [-50, 0, 0], goal: [50, 0, 0]}
simulation: {duration: 500.0}
"""
# Longer than anything takes on a machine that does something else as well.
PATIENCE = 120.0


class Listener:
    """Keeps messages, and waits for one."""

    def __init__(self, worker):
        self.messages = []
        self._changed = threading.Condition()
        self.end = worker.listen(self._take)

    def _take(self, message):
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait(self, kind, **facts):
        """Returns the first message of a kind with these facts."""

        def found():
            return next(
                (
                    it
                    for it in self.messages
                    if it["kind"] == kind
                    and all(it[key] == value for key, value in facts.items())
                ),
                None,
            )

        with self._changed:
            assert self._changed.wait_for(found, PATIENCE), (kind, facts)
            return found()

    def clear(self):
        with self._changed:
            self.messages.clear()


@pytest.fixture(scope="module")
def shared():
    dut = Worker()
    yield dut
    dut.close()


@pytest.fixture
def worker(shared):
    shared.start()
    listener = Listener(shared)
    listener.wait("worker", status="ready")
    listener.clear()
    yield shared, listener
    shared.cancel()
    listener.end()


def test_it_checks_names(worker):
    dut, listener = worker
    number = dut.check(TEXT.replace("name: ana", "behavior: curios"), None)
    (fault,) = listener.wait("checked", ticket=number)["faults"]
    assert fault["path"] == ["humans", 0, "behavior"]


def test_runs_come_in_order_with_files_and_statistics(worker):
    dut, listener = worker
    text = TEXT.replace("{duration", "{start_jitter: 0.05, duration")
    dut.run(RunRequest(text=text, seeds=[5, 6], revision=8))
    runs = listener.wait("runs", revision=8)["runs"]
    assert [it["seed"] for it in runs] == [5, 6]
    last = runs[-1]["run"]
    frame = listener.wait("frame", run=runs[0]["run"])
    assert len(frame["people"]) == 1
    first = listener.wait("result", run=runs[0]["run"])
    assert first["report_url"] is None
    listener.wait("result", run=last)
    deadline = time.monotonic() + PATIENCE
    while not (
        url := [
            it["report_url"]
            for it in listener.messages
            if it["kind"] == "result" and it["run"] == last
        ][-1]
    ):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    _, token, run, name = url.split("/")
    assert "<html" in dut.file(token, run, name).read_text()
    rows = [it for it in listener.messages if it["kind"] == "summary"][-1]
    assert {it["n"] for it in rows["rows"]} == {2}


def test_a_new_view_is_told_of_the_last_runs(worker):
    dut, listener = worker
    dut.run(RunRequest(text=TEXT))
    (run,) = (it["run"] for it in listener.wait("runs")["runs"])
    before = listener.wait("result", run=run)
    listener.clear()
    dut.repeat()
    listener.wait("worker", status="ready")
    assert listener.wait("runs")["runs"][0]["run"] == run
    after = listener.wait("result", run=run)
    assert after["metrics"] == before["metrics"]
    listener.wait("summary")


def test_two_processes_share_the_runs(worker):
    dut, listener = worker
    dut.run(RunRequest(text=TEXT, seeds=[1, 2], workers=2))
    for it in listener.wait("runs")["runs"]:
        assert listener.wait("result", run=it["run"])["error"] is None


def test_there_are_no_more_processes_than_runs(worker):
    dut, listener = worker
    before = len(dut._others)
    dut.run(RunRequest(text=TEXT, seeds=[1], workers=8))
    (run,) = (it["run"] for it in listener.wait("runs")["runs"])
    listener.wait("result", run=run)
    assert len(dut._others) == before < 7


def test_a_run_is_cancelled_and_the_next_one_works(worker):
    dut, listener = worker
    dut.run(RunRequest(text=LONG, seeds=[1, 2], speed=2.0))
    listener.wait("frame")
    begin = time.monotonic()
    dut.cancel()
    for it in listener.wait("runs")["runs"]:
        result = listener.wait("result", run=it["run"])
        assert result["end_reason"] == "cancelled"
    print(f"cancelled after {time.monotonic() - begin:.2f} s")
    listener.clear()
    dut.run(RunRequest(text=TEXT))
    (run,) = (it["run"] for it in listener.wait("runs")["runs"])
    assert listener.wait("result", run=run)["metrics"]


def begin_run(dut, listener):
    """Begins a long run, and returns its number once it moves."""
    dut.run(RunRequest(text=LONG, speed=2.0))
    (run,) = listener.wait("runs")["runs"]
    listener.wait("frame", run=run["run"])
    return run["run"]


def test_questions_are_answered_during_a_run(worker):
    dut, listener = worker
    dut.run(RunRequest(text=LONG, speed=2.0))
    listener.wait("frame")
    number = dut.check("planner: no_such", None)
    assert listener.wait("checked", ticket=number)["faults"]


def test_a_process_that_is_killed_is_replaced(worker):
    dut, listener = worker
    number = begin_run(dut, listener)
    os.kill(dut._first.pid, signal.SIGKILL)
    result = listener.wait("result", run=number)
    assert result["end_reason"] == "failed"
    assert "-9" in listener.wait("worker", status="dead")["message"]
    listener.wait("worker", status="ready")
    listener.clear()
    dut.run(RunRequest(text=TEXT))
    (run,) = listener.wait("runs")["runs"]
    assert listener.wait("result", run=run["run"])["metrics"]


def test_a_process_that_hears_nothing_is_ended(worker):
    dut, listener = worker
    number = begin_run(dut, listener)
    os.kill(dut._first.pid, signal.SIGSTOP)
    begin = time.monotonic()
    dut.cancel()
    result = listener.wait("result", run=number)
    assert result["end_reason"] == "cancelled"
    print(f"cancelled after {time.monotonic() - begin:.2f} s")
    listener.wait("worker", status="ready")


def test_imports_that_fail_are_told(tmp_path):
    (tmp_path / "broken.py").write_text("nothing_of_this_name")
    dut = Worker(imports=[str(tmp_path / "broken.py")])
    listener = Listener(dut)
    dut.start()
    dut.run(RunRequest(text=TEXT))
    assert "nothing_of_this_name" in listener.wait("result")["error"]
    assert "broken.py" in listener.wait("worker", status="dead")["message"]
    dut.close()


def test_processes_end_with_their_parent():
    code = (
        "from hunav_drake.editor.worker import Worker\n"
        "import os, sys, time\n"
        "worker = Worker()\n"
        "worker.start()\n"
        "print(worker._first.pid, flush=True)\n"
        "os._exit(0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, check=True
    )
    pid = int(done.stdout)
    deadline = time.monotonic() + PATIENCE
    while os.path.exists(f"/proc/{pid}"):
        assert time.monotonic() < deadline
        time.sleep(0.1)


def test_a_page_without_a_run_loads_no_drake():
    code = (
        "import sys, hunav_drake.editor.worker\n"
        "assert not {'pydrake', 'numba', 'pandas'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
