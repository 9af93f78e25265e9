"""The built wheel is complete, and works where there is no repository."""

import os
from pathlib import Path
import subprocess
import sys
import zipfile

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
def test_holds_the_systems_and_their_data(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for name in (
        "hunav_drake/py.typed",
        "hunav_drake/report/templates/style.css",
        "hunav_drake/report/templates/trial.html",
        "hunav_drake/scenarios/passing.yaml",
        "hunav_drake/systems/behavior/trees/regular.xml",
        "hunav_drake/systems/behavior/hunavsim/regular.xml",
        "hunav_drake/systems/crowd/human_crowd.py",
    ):
        assert name in names
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {
        "hunav_drake"
    }


@pytest.mark.slow
def test_holds_each_file_of_the_package_as_it_is(wheel):
    archive = zipfile.ZipFile(wheel)
    names = set(archive.namelist())
    package = ROOT / "hunav_drake"
    for folder, folders, files in os.walk(package, followlinks=True):
        if "__pycache__" in folders:
            folders.remove("__pycache__")
        for file in files:
            path = Path(folder, file)
            name = path.relative_to(ROOT).as_posix()
            assert name in names, name
            assert archive.read(name) == path.read_bytes(), name


@pytest.mark.slow
def test_runs_a_trial(installed, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(installed)}

    def run(*arguments):
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    where = run("-c", "import hunav_drake; print(hunav_drake.__file__)")
    assert where.stdout.startswith(str(installed))
    result = run(
        "-m", "hunav_drake.commands.cli", "run", "passing", "--out", "out"
    )
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "out/runs/passing_pursuit_0/replay.html").exists()
