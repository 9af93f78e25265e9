"""Commands that are killed at random instants lose nothing they have saved.

`python -m tests.reliability.kills 100` kills each command so often.
"""

import argparse
from collections.abc import Callable
import json
from pathlib import Path
import re
import signal
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

import numpy as np

from hunav_drake.runs.result_files import LoadResults
from hunav_drake.runs.run_folders import find_runs
from hunav_drake.runs.run_log import read_rows

# (Where the seed draws nothing, as in free_run, a suite runs one.)
_SUITE = {
    "name": "small",
    "scenarios": ["passing"],
    "planners": ["pursuit"],
    "overrides": ["simulation.duration=0.5"],
    "seeds": 4,
}

# Saves a scenario again and again, as the editor does, and tells of each.
_SAVER = """
import sys
from pathlib import Path
from hunav_drake.editor.files import SessionFile
file = SessionFile(Path("out/mine.yaml"))
for i in range(int(sys.argv[1])):
    file.write(f"description: {i:01000d}")
    print("saved", i, flush=True)
"""


class Command(NamedTuple):
    """A command, and what it leaves.

    Attributes:
        words: What starts it.
        look: Given its folder and what it has printed, returns what is lost or
            broken; nothing if all is well.
    """

    words: list[str]
    look: Callable[[Path, str], str]


def _look_at_runs(folder: Path, printed: str) -> str:
    out = folder / "out"
    runs = find_runs(out)
    if runs:
        # Raises where one is not whole.
        LoadResults(out)
    told = re.findall(r"out/runs/([\w.-]+)", printed)
    lost = set(told) - set(runs)
    return f"lost: {lost}" if lost else ""


def _look_at_suite(folder: Path, printed: str) -> str:
    log = folder / "out/small/runs.jsonl"
    seeds = [row.seed for row in read_rows(log)] if log.is_file() else []
    if len(seeds) != len(set(seeds)):
        return f"runs twice: {seeds}"
    if "Report" in printed and len(seeds) != _SUITE["seeds"]:
        return f"lost: only {seeds} are there"
    return ""


def _look_at_file(folder: Path, printed: str) -> str:
    path = folder / "out/mine.yaml"
    saved = [int(line.split()[1]) for line in printed.splitlines()]
    if not path.is_file():
        return "lost: no file" if saved else ""
    number = int(path.read_text().removeprefix("description: "))
    if len(path.read_bytes()) != len("description: ") + 1000:
        return "the file is cut"
    return f"lost: {saved[-1]}" if saved and number < saved[-1] else ""


def _hunav(line: str) -> list[str]:
    return [sys.executable, "-m", "hunav_drake.commands.cli", *line.split()]


COMMANDS = {
    "run": Command(
        _hunav("run free_run --set simulation.duration=0.5 --out out"),
        _look_at_runs,
    ),
    "bench": Command(
        _hunav("bench suite.yaml --workers 1 --quiet --out out"), _look_at_suite
    ),
    "evaluate": Command(
        _hunav("evaluate recording.npz --out out"), _look_at_runs
    ),
    "save": Command([sys.executable, "-c", _SAVER, "2000"], _look_at_file),
}


def prepare(folder: Path) -> Path:
    """Writes what the commands read into a folder."""
    from tests.hunav_drake.passing_trials import make_recording

    (folder / "suite.yaml").write_text(json.dumps(_SUITE))
    make_recording().save(folder / "recording.npz")
    (folder / "out").mkdir()
    return folder


def run_through(command: Command, folder: Path) -> float:
    """Runs a command to its end; returns how long it took, in seconds."""
    started = time.perf_counter()
    done = subprocess.run(
        command.words, cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 1) or "Traceback" in done.stderr:
        raise RuntimeError(f"{command.words}: {done.stderr}")
    fault = command.look(folder, done.stdout + done.stderr)
    if fault:
        raise RuntimeError(f"{command.words}: {fault}")
    return time.perf_counter() - started


def kill_at(command: Command, folder: Path, delay: float) -> str:
    """Kills a command after some seconds; returns what is lost, or broken."""
    with (folder / "printed").open("w+") as printed:
        process = subprocess.Popen(
            command.words,
            cwd=folder,
            stdout=printed,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            process.wait(delay)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
        printed.seek(0)
        text = printed.read()
    # What was being written when it was killed is no word of it.
    return command.look(folder, text[: text.rfind("\n") + 1])


def main() -> None:
    """Kills each command many times, and prints what was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="how often, each command")
    parser.add_argument("--command", nargs="+", default=list(COMMANDS))
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    for name in options.command:
        command, lost = COMMANDS[name], 0
        with tempfile.TemporaryDirectory() as folder:
            usual = run_through(command, prepare(Path(folder)))
        for _ in range(options.count):
            with tempfile.TemporaryDirectory() as folder:
                delay = rng.uniform(0, 1.1 * usual)
                fault = kill_at(command, prepare(Path(folder)), delay)
                lost += bool(fault)
                if fault:
                    print(f"{name}, killed after {delay:.3f} s: {fault}")
                # It can be done again, or goes on.
                run_through(command, Path(folder))
        print(f"{name}: killed {options.count} times, {lost} times with loss")


if __name__ == "__main__":
    main()
