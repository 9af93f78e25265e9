"""Python in a process of its own, for what a test's own would spoil."""

from collections.abc import Iterator
import contextlib
import os
import signal
import subprocess
import sys
from typing import Any

import pytest


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


@contextlib.contextmanager
def dask_client(num_workers: int) -> Iterator[Any]:
    """Yields the client of a Dask cluster of processes of this machine."""
    distributed = pytest.importorskip(
        "distributed", reason="the extra `dask` is not here"
    )
    with (
        distributed.LocalCluster(
            n_workers=num_workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client
