"""No home, folders that cannot be written, and full disks: one line tells."""

import os
from pathlib import Path
import resource
import shutil
import subprocess
import sys

import pytest

from tests.hunav_drake.passing_trials import make_recording

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = {
    "run": "run free_run --set simulation.duration=0.2 --out OUT",
    "bench": "bench suite.yaml --workers 1 --quiet --out OUT",
    "evaluate": "evaluate recording.npz --out OUT",
    "new": "new OUT/mine",
    "schema": "schema -o OUT/a.json",
    "tree": "tree convert regular -o OUT/a.xml",
}
_SUITE = """
name: small
scenarios: [free_run]
planners: [pursuit]
overrides: [simulation.duration=0.2]
seeds: 1
"""


@pytest.fixture
def here(tmp_path):
    (tmp_path / "suite.yaml").write_text(_SUITE)
    make_recording().save(tmp_path / "recording.npz")
    (tmp_path / "out").mkdir()
    return tmp_path


def hunav(name, here, *, before=(), environment=None, **options):
    line = COMMANDS[name].replace("OUT", "out")
    return subprocess.run(
        [
            *before,
            sys.executable,
            "-m",
            "hunav_drake.commands.cli",
            *line.split(),
        ],
        cwd=here,
        env={**os.environ, "PYTHONPATH": str(ROOT), **(environment or {})},
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def assert_refused(done, here):
    assert done.returncode == 2, done.stderr
    *notes, line = done.stderr.splitlines()
    assert line.startswith("hunav: ")
    # (A trial may tell of itself before.)
    assert not any("rror" in it or "Traceback" in it for it in notes)
    assert "may be a bug" not in line
    assert not [p for p in (here / "out").rglob("*") if p.suffix == ".tmp"]


def small_files(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("size", [0, 1500])
def test_a_disk_that_is_full(name, size, here):
    """As the system tells: files above a size cannot be written."""
    if name in ("tree", "new") and size:
        pytest.skip("the file is smaller")
    done = hunav(name, here, preexec_fn=small_files(size))
    assert_refused(done, here)
    assert "File too large" in done.stderr
    again = hunav(name, here)
    assert again.returncode in (0, 1), again.stderr


# Root may write everywhere, unless it gives that up.
_WITHOUT = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_written(name, here):
    before = []
    if os.getuid() == 0:
        if shutil.which("setpriv") is None:
            pytest.skip("root can write everywhere")
        before = _WITHOUT
    (here / "out").chmod(0o555)
    done = hunav(name, here, before=before)
    assert_refused(done, here)
    assert "Permission denied" in done.stderr


@pytest.mark.slow
def test_without_a_home(here):
    """What is kept there can be done without; not even root can make it."""
    gone = {"HOME": "/proc/none", "XDG_CACHE_HOME": "", "MPLCONFIGDIR": ""}
    for name in ("run", "evaluate", "bench"):
        done = hunav(name, here, environment=gone)
        assert done.returncode in (0, 1), done.stderr
        assert "Traceback" not in done.stderr
        assert "may be a bug" not in done.stderr
