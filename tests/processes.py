"""Python in a process of its own, for what a test's own would spoil."""

import os
import signal
import subprocess
import sys


def run_python(code: str) -> subprocess.CompletedProcess[str]:
    """Runs code in another process, and returns what it printed.

    Raises:
        subprocess.CalledProcessError: If it fails.
    """
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )


def start_hunav(*words: object) -> "subprocess.Popen[str]":
    """Starts the command in a process group of its own, as a terminal does.

    Ctrl-C ends it also where the tests were started with SIGINT ignored.
    """
    code = (
        "import signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from hunav_drake.commands.cli import main\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def press_ctrl_c(process: "subprocess.Popen[str]") -> tuple[int, str]:
    """Interrupts a process and all that it has started.

    Returns:
        Its exit code and what it wrote as errors.
    """
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors
