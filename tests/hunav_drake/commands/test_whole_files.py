"""Whatever stops a command, its files are whole, and one line tells it.

A command is stopped wherever it writes: at each file that it opens, of which
half is written then, and at each that it is about to name.
"""

import builtins
import errno
import io
import itertools
import os
from pathlib import Path
import shutil
import time

import pytest

from hunav_drake.runs.worker_pool import InlineExecutor
from tests.processes import press_ctrl_c, start_hunav

HALF = b"half of what was to be written"
SHORT = ["--set", "simulation.duration=1"]
SUITE = """
name: tiny
scenarios: [passing]
planners: [pursuit]
overrides: [simulation.duration=1.0]
seeds: 1
"""
# Of each command: its words, where OUT is a folder that may be there already,
# RUN one with a run, and HERE one with files; and what it says after Ctrl-C.
COMMANDS = {
    "run": ("run passing --out OUT", "run it again"),
    "evaluate": ("evaluate RUN/recording.npz --out OUT", "the same command"),
    "bench": (
        "bench HERE/tiny.yaml --out OUT --workers 1 --replays"
        " --markdown OUT/page.md",
        "continues from there",
    ),
    "validate": (
        "validate --case kept_speed --model orca --quick --out OUT"
        " --markdown OUT/page.md",
        "nothing",
    ),
    "report": ("report RUN/../.. -o OUT/report.html", "run it again"),
    "png": ("render RUN -o OUT/a.png --size 64x64 --force", "no film"),
    "gif": ("render RUN -o OUT/a.gif --size 64x64 --to 0.1 --force", "no film"),
    "mp4": ("render RUN -o OUT/a.mp4 --size 64x64 --to 0.1 --force", "no film"),
    "new": ("new OUT/mine --force", ""),
    "schema": ("schema -o OUT/a.json --force", ""),
    "tree": ("tree convert regular -o OUT/a.xml --force", ""),
}


class Stop:
    """Raises an error at the n-th time that a file is opened or named."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._folder = str(folder)
        self._left = -1
        self._error: BaseException | None = None
        for module, name in (
            (builtins, "open"),
            (io, "open"),
            (os, "replace"),
            (os, "rename"),
        ):
            was = getattr(module, name)
            is_open = name == "open"
            monkeypatch.setattr(module, name, self._watched(was, is_open))

    def at(self, number: int, error: BaseException) -> None:
        self._left, self._error = number, error

    @property
    def is_done(self) -> bool:
        return self._left <= 0

    def _watched(self, function, is_open):
        def watched(path, *words, **more):
            if isinstance(path, int) or not str(path).startswith(self._folder):
                return function(path, *words, **more)
            mode = str(more.get("mode", words[0] if words else "r"))
            # (`tempfile` has an opener of its own: a file without a name.)
            if is_open and (not set(mode) & set("wxa") or "opener" in more):
                return function(path, *words, **more)
            self._left -= 1
            if self._left != 0:
                return function(path, *words, **more)
            if is_open:
                with function(path, *words, **more) as file:
                    file.write(HALF if "b" in mode else HALF.decode())
            raise self._error

        return watched


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    from hunav_drake.commands.cli import main

    here = tmp_path_factory.mktemp("here")
    (here / "tiny.yaml").write_text(SUITE)
    words = ["run", "passing", *SHORT, "--no-replay", "--quiet", "--out"]
    assert main([*words, str(here / "results")]) == 1
    return here


def files_in(folder):
    return {
        path.relative_to(folder): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture
def no_workers(monkeypatch):
    """Suites run in this process, where what they write is watched, too."""
    monkeypatch.setattr(
        "hunav_drake.runs.worker_pool.WorkerPool", lambda _: InlineExecutor()
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_is_stopped_leaves_whole_files(
    name, hunav, here, tmp_path, monkeypatch, no_workers
):
    line, advice = COMMANDS[name]
    (run,) = (here / "results" / "runs").iterdir()
    out = tmp_path / "out"
    places = {"OUT": out, "RUN": run, "HERE": here}
    for place, path in places.items():
        line = line.replace(place, str(path))
    words = line.split()
    if name == "run":
        words += SHORT
    out.mkdir()
    done = hunav(*words)[0]
    assert done == (1 if name == "run" else 0)
    whole = set(files_in(out))
    stop = Stop(out, monkeypatch)
    for number in itertools.count(1):
        shutil.rmtree(out)
        out.mkdir()
        # By turns, so that it takes half the time.
        is_interrupt = number % 2 == 1
        error = (
            KeyboardInterrupt()
            if is_interrupt
            else OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "draft")
        )
        stop.at(number, error)
        code, _, err = hunav(*words)
        if not stop.is_done:
            break
        assert code == (130 if is_interrupt else 2), err
        (told,) = err.splitlines()
        words_told = "interrupted" if is_interrupt else "No space left on"
        assert told.startswith("hunav: ")
        assert words_told in told
        assert advice in told or not is_interrupt
        left = files_in(out)
        assert not [path for path in left if path.name.endswith(".tmp")]
        # What is not whole is the last line of a log, which is cut off then.
        assert set(left) <= whole
        halves = {path.name for path, text in left.items() if HALF in text}
        assert halves <= {"runs.jsonl"}
        runs = {path.parent for path in left if path.parts[0] == "runs"}
        for folder in runs:
            assert {p for p in left if p.parent == folder} == {
                p for p in whole if p.parent == folder
            }
    assert number > 2
    assert code == done
    assert set(files_in(out)) == whole


@pytest.mark.slow
def test_the_same_suite_goes_on_after_it_was_stopped(
    hunav, here, tmp_path, monkeypatch, no_workers
):
    words = ["bench", here / "tiny.yaml", "--out", tmp_path, "--workers", 1]
    stop = Stop(tmp_path, monkeypatch)
    for number in itertools.count(1):
        stop.at(number, KeyboardInterrupt())
        code, _, _ = hunav(*words)
        if code == 0:
            break
        assert code == 130
    lines = (tmp_path / "tiny" / "runs.jsonl").read_bytes().splitlines()
    assert len(lines) == 1
    assert HALF not in lines[0]


# A planner and a motion model that are at work for ever.
ENDLESS = """
import os, time
from pathlib import Path
import numpy as np
from pydantic.dataclasses import dataclass
from hunav_drake.systems.crowd import MotionModel, register_motion_model
from hunav_drake.systems.planning import register_plan

def work():
    Path({folder!r}, f"worker_{{os.getpid()}}").touch()
    while True:
        time.sleep(0.01)

@register_plan("endless")
def endless(task, view, memory):
    work()

@register_motion_model("endless")
@dataclass
class Endless(MotionModel):
    def forces(self, snapshot):
        return np.zeros((len(snapshot.states), 16))

    def advance(self, snapshot, forces):
        work()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ["bench", "standard", "--planner", "endless", "--quiet"],
        ["validate", "--model", "endless", "--case", "lanes", "kept_speed"],
    ],
    ids=lambda words: words[0],
)
def test_ctrl_c_ends_workers_whatever_they_do(words, tmp_path):
    code = tmp_path / "endless.py"
    code.write_text(ENDLESS.format(folder=str(tmp_path)))
    out = tmp_path / "out"
    process = start_hunav(
        *(*words, "--workers", 2, "--import", code, "--out", out)
    )
    workers = []
    for _ in range(600):
        # (The first trial of a suite is for one worker alone.)
        workers = [int(p.name[7:]) for p in tmp_path.glob("worker_*")]
        if workers or process.poll() is not None:
            break
        time.sleep(0.1)
    code, err = press_ctrl_c(process)
    assert workers
    (told,) = err.splitlines()
    assert code == 130
    assert told.startswith("hunav: interrupted: ")
    for worker in workers:
        with pytest.raises(ProcessLookupError):
            os.kill(worker, 0)


@pytest.mark.slow
def test_ctrl_c_ends_the_editor(here):
    pytest.importorskip("tornado", reason="the extra `editor` is not here")
    file = here / "mine.yaml"
    file.write_text("robot: {goal: [2, 0, 0]}\n")
    process = start_hunav("edit", file, "--no-browser", "--port", 0)
    for line in process.stdout:
        if line == "Ctrl-C ends it.\n":
            break
    code, err = press_ctrl_c(process)
    assert (code, err) == (0, "")
    assert file.read_text() == "robot: {goal: [2, 0, 0]}\n"
    assert not list(here.glob(".*"))
