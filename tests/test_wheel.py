"""The built wheel works where there is no repository."""

import os
from pathlib import Path
import shutil
import subprocess
import sys
import zipfile

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    # A build writes into its source folder: two workers need two of them.
    folder = tmp_path_factory.mktemp("wheel")
    source = shutil.copytree(
        ROOT,
        folder / "source",
        symlinks=True,
        ignore=shutil.ignore_patterns(
            ".*", "build", "dist", "out", "*.egg-info", "__pycache__"
        ),
    )
    built = subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--outdir", folder, source],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return next(folder.glob("*.whl"))


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
def test_runs_a_trial(wheel, tmp_path):
    place = tmp_path / "installed"
    zipfile.ZipFile(wheel).extractall(place)
    environment = {**os.environ, "PYTHONPATH": str(place)}

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
    assert where.stdout.startswith(str(place))
    result = run("-m", "hunav_drake.cli", "run", "passing", "--out", "out")
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "out/runs/passing_pursuit_0/replay.html").exists()
