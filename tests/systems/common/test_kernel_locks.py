"""Processes that need the same kernel do not compile it twice."""

import subprocess
import sys

import pytest

from hunav_drake.systems.common import kernels
from hunav_drake.systems.world.nearest import nearest_on_shapes as kernel

ASK = """
from hunav_drake.systems.world.nearest import nearest_on_shapes as kernel
kernel.compile_once(waits=False)
print(len(kernel.overloads), flush=True)
print(kernel.compiled().signature == kernel.signature, flush=True)
"""


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
    code = (
        "import time\n"
        "from hunav_drake.systems.common import kernels\n"
        "from hunav_drake.systems.world.nearest import nearest_on_shapes\n"
        "with kernels._locked(nearest_on_shapes, waits=True):\n"
        "    print('locked', flush=True)\n"
        "    time.sleep(100)\n"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
    )
    assert other.stdout.readline() == "locked\n"
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
