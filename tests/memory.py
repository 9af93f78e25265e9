"""The memory that this process takes at most, as Linux counts it.

That of `getrusage` also counts what the process that started this one took.
"""

from pathlib import Path
import re

import pytest

STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")

needs_linux = pytest.mark.skipif(
    not CLEAR.exists(), reason="only Linux tells a process's peak again"
)


def peak_memory() -> int:
    """Returns the most resident memory since the last reset, in bytes."""
    found = re.search(r"VmHWM:\s*(\d+) kB", STATUS.read_text())
    assert found is not None
    return 1024 * int(found[1])


def reset_peak_memory() -> int:
    """Makes the peak the memory that there is now, and returns it, in bytes."""
    CLEAR.write_text("5")
    return peak_memory()
