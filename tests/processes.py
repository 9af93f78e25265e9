"""Python in a process of its own, for what a test's own would spoil."""

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
