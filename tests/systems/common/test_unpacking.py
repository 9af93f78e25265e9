"""Packed files are read up to a limit, and in one place."""

import ast
import gzip
import resource
import subprocess
import sys
import zipfile

import numpy as np
import pytest

from hunav_drake import LoadContext, LoadScenario, MakeTrialDiagram
from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.systems.common.files import (
    VARIABLE,
    read_arrays,
    read_gzip_text,
)
from tests.architecture import modules, tree

# The functions that unpack foreign files, wherever they are called.
PACKERS = {
    *("bz2", "compression", "gzip", "lzma", "tarfile", "zipfile", "zstandard")
}
READERS = {
    *("decompress", "decompressobj", "genfromtxt", "loadtxt", "unpack_archive"),
    *("read_csv", "read_json", "read_parquet", "read_pickle", "read_table"),
}


def unpackers(text):
    """Yields the calls in a text that may unpack a file."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module in PACKERS:
            yield node.module
        if not isinstance(node, ast.Attribute):
            continue
        name = ast.unparse(node)
        owner, _, method = name.rpartition(".")
        if (
            (owner in PACKERS and name != "gzip.compress")
            or method in READERS
            or name in ("np.load", "numpy.load")
        ):
            yield name


@pytest.mark.slow
def test_nothing_else_unpacks():
    found = {
        name: calls
        for name, path in modules().items()
        if (calls := list(unpackers(path.read_text())))
    }
    # A table that is packed is none.
    assert found.pop("hunav_drake.runs.run_table") == ["pd.read_csv"] * 2
    calls = ast.unparse(tree(modules()["hunav_drake.runs.run_table"]))
    assert calls.count("compression=None") == 2
    assert list(found) == ["hunav_drake.systems.common.files"]


@pytest.mark.parametrize(
    "text",
    [
        "gzip.open(path)",
        "def f():\n    np.load(path)",
        "from zipfile import ZipFile",
        "zlib.decompressobj()",
        "pd.read_csv(path)",
    ],
)
def test_what_unpacks_is_found(text):
    assert list(unpackers(text))


@pytest.fixture
def limit(monkeypatch):
    """A megabyte, of which a text may have a twentieth."""
    monkeypatch.setenv(VARIABLE, "0.001")


def packed_text(path, size):
    with gzip.open(path, "wb") as file:
        file.write(b"x" * size)
    return path


def test_a_text_may_have_a_twentieth(tmp_path, limit):
    assert len(read_gzip_text(packed_text(tmp_path / "a", 50_000))) == 50_000
    with pytest.raises(ValueError, match=r"more than 0\.001 GB of memory"):
        read_gzip_text(packed_text(tmp_path / "b", 50_001))


def test_arrays_may_have_all(tmp_path, limit):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, a=np.zeros(120_000))
    assert read_arrays(path, "a test")["a"].size == 120_000
    np.savez_compressed(path, a=np.zeros(60_000), b=np.zeros(66_000))
    with pytest.raises(ValueError, match=f"more than 0.001 GB.*{VARIABLE}"):
        read_arrays(path, "a test")


def test_what_is_not_packed_has_no_limit(tmp_path, limit):
    """It is as large on the disk, so nobody is surprised."""
    np.savez(tmp_path / "a.npz", a=np.zeros(500_000))
    assert read_arrays(tmp_path / "a.npz", "a test")["a"].size == 500_000


def test_packing_that_may_exceed_what_it_declares_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    for kind in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        with zipfile.ZipFile(path, "w", kind) as archive:
            archive.writestr("a.npy", bytes(1000))
        with pytest.raises(ValueError, match="in a way that is not read"):
            read_arrays(path, "a test")


@pytest.mark.parametrize("text", ["x", "-1", "0", "nan", "inf", "2GB"])
def test_a_wrong_limit_is_told(tmp_path, monkeypatch, text):
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(ValueError, match=f"{VARIABLE} must be a number of GB"):
        read_gzip_text(packed_text(tmp_path / "a", 1))


def test_a_packed_table_of_runs_is_none(tmp_path):
    with pytest.raises(ValueError, match="is not a table of runs"):
        ReadRuns(packed_text(tmp_path / "runs.csv.gz", 1000))


def bomb(folder, name):
    """Writes a file of a few MB that would be 3 GB unpacked."""
    path = folder / name
    if name.endswith(".npz"):
        with (
            zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
            archive.open("times.npy", "w", force_zip64=True) as file,
        ):
            header = {"descr": "<f8", "fortran_order": False}
            np.lib.format.write_array_header_1_0(
                file, {**header, "shape": (375_000_000,)}
            )
            for _ in range(300):
                file.write(bytes(10_000_000))
    else:
        row = b"0,robot,0,0\n" if ".csv" in name else b"[0],"
        start = b"time,agent,x,y\n" if ".csv" in name else b"["
        with gzip.open(path, "wb", 9) as file:
            file.write(start)
            for _ in range(300):
                file.write(row * (10_000_000 // len(row)))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a.csv.gz", "a.json.gz", "a.npz"])
def test_bombs_are_refused_with_a_line_and_little_memory(tmp_path, name):
    path = bomb(tmp_path, name)
    assert path.stat().st_size < 10e6
    done = subprocess.run(
        [sys.executable, "-m", "hunav_drake.commands.cli", "evaluate", path],
        # In bytes: a fraction of what it would be unpacked.
        preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_DATA, (1_500_000_000,) * 2
        ),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert VARIABLE in done.stderr


def test_all_readers_of_archives_have_the_limit(tmp_path, limit):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, times=np.zeros(500_000))
    diagram = MakeTrialDiagram(LoadScenario(filename="free_run"))
    for read in (ReadRecording, lambda it: LoadContext(diagram, it)):
        with pytest.raises(ValueError, match=VARIABLE):
            read(path)
    for name in ("a.csv.gz", "a.json.gz"):
        with pytest.raises(ValueError, match=VARIABLE):
            ReadRecording(packed_text(tmp_path / name, 500_000))
