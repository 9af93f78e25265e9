"""Processes that need the same kernel do not compile it twice."""

import subprocess
import sys

from numba.core import event
import pytest

from hunav_drake.systems.common import kernels
from hunav_drake.systems.world.nearest import nearest_on_shapes as kernel

ASK = """
from hunav_drake.systems.world.nearest import nearest_on_shapes as kernel
kernel.compile_once(waits=False)
print(len(kernel.overloads), flush=True)
print(kernel.compiled().signature == kernel.signature, flush=True)
"""

HOLD = """
import sys, time
from hunav_drake.systems.common import kernels
from hunav_drake.systems.world.nearest import nearest_on_shapes as kernel
with kernels._locked(kernel, waits=True):
    print("locked", flush=True)
    time.sleep(float(sys.argv[1]))
"""


def holder(seconds):
    """Returns a process that has the kernel for some time."""
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(seconds)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout.readline() == "locked\n"
    return other


@pytest.mark.slow
def test_who_does_not_wait_goes_on_and_who_does_has_it_later():
    with kernels._locked(kernel, waits=True) as is_mine:
        assert is_mine
        other = subprocess.Popen(
            [sys.executable, "-c", ASK], stdout=subprocess.PIPE, text=True
        )
        assert other.stdout.readline() == "0\n"
        with pytest.raises(subprocess.TimeoutExpired):
            other.wait(0.5)
    assert other.communicate(timeout=100) == ("True\n", None)
    # It is free again.
    with kernels._locked(kernel, waits=False) as is_mine:
        assert is_mine


def test_the_lock_of_a_process_that_was_killed_is_free():
    other = holder(100)
    with kernels._locked(kernel, waits=False) as is_mine:
        assert not is_mine
    other.kill()
    other.communicate()
    with kernels._locked(kernel, waits=False) as is_mine:
        assert is_mine


def test_where_nothing_can_be_locked_each_compiles(monkeypatch):
    monkeypatch.setattr(kernels, "_lock_file", lambda _: None)
    with kernels._locked(kernel, waits=False) as is_mine:
        assert is_mine


@pytest.mark.slow
def test_who_only_reads_is_waited_for_quietly(monkeypatch):
    """Two commands at once, with all compiled: nothing is told."""
    told = []

    class Listener(event.Listener):
        def on_start(self, it):
            told.append(it)

        def on_end(self, it):
            told.append(it)

    for moment, times in ((60.0, 0), (0.05, 2)):
        monkeypatch.setattr(kernels, "_MOMENT", moment)
        other = holder(0.5)
        with (
            event.install_listener("numba:compile", Listener()),
            kernels._locked(kernel, waits=True) as is_mine,
        ):
            assert is_mine
        assert len(told) == times
        other.communicate(timeout=20)


def test_a_process_that_is_stopped_is_not_waited_for_without_end(monkeypatch):
    monkeypatch.setattr(kernels, "_MOMENT", 0.05)
    monkeypatch.setattr(kernels, "_PATIENCE", 0.2)
    other = holder(100)
    with kernels._locked(kernel, waits=True) as is_mine:
        assert is_mine
    other.kill()
    other.communicate()
