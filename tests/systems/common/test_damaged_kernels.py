"""Compiled code on disk that is damaged is compiled anew, with one line."""

import importlib.util
import os
import shutil
import subprocess
import sys
import warnings

import pytest

from hunav_drake.systems.common import kernels

SOURCE = """
from hunav_drake.systems.common.kernels import INTEGER, jit, jit_as

@jit
def twice(number):
    return 2 * number

@jit_as(INTEGER, INTEGER)
def thrice(number):
    return number + twice(number)
"""


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels._KeptCode, "is_told", False)
    path = tmp_path / "numbers.py"
    path.write_text(SOURCE)
    return path


def calculate(source):
    """Calls a kernel as another process does; returns what it was told.

    Also returns whether it found the code on disk.
    """
    spec = importlib.util.spec_from_file_location("numbers", source)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert module.thrice(7) == 21
    hits = sum(module.thrice.stats.cache_hits.values())
    return [str(it.message) for it in told], hits == 1


def files(source, pattern="*.nb[ic]"):
    return sorted(source.parent.glob(f"__pycache__/{pattern}"))


def cut(path):
    os.truncate(path, path.stat().st_size // 2)


def empty(path):
    os.truncate(path, 0)


def zero(path):
    path.write_bytes(bytes(path.stat().st_size))


def flip(path):
    """Changes one bit of the machine code, which numba would run."""
    data = bytearray(path.read_bytes())
    if data:
        data[len(data) // 2] ^= 1
    path.write_bytes(data)


def replace_by_folder(path):
    path.unlink()
    path.mkdir()


DAMAGE = [
    *(("*.nbi", change) for change in (cut, empty, zero)),
    *(("*.nbc", change) for change in (cut, empty, zero, flip)),
]


@pytest.mark.parametrize(("pattern", "damage"), DAMAGE)
def test_damaged_code_heals_with_one_line(source, pattern, damage):
    assert calculate(source) == ([], False)
    assert calculate(source) == ([], True)
    for path in files(source, pattern):
        damage(path)
    (told,), found = calculate(source)
    assert "is damaged; it is compiled anew" in told
    assert str(source.parent) in told
    assert not found
    assert calculate(source) == ([], True)


@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
def test_what_cannot_be_replaced_does_no_harm(source, pattern):
    calculate(source)
    for path in files(source, pattern):
        replace_by_folder(path)
    (told,), found = calculate(source)
    assert not found
    assert "compiled" in told


def test_code_under_another_kernels_name_is_not_run(source):
    """As two processes leave it that write index and code at a time."""
    calculate(source)
    thrice, twice = files(source, "*.nbc")
    shutil.copy(twice, thrice)
    assert calculate(source) == ([], False)
    assert calculate(source) == ([], True)


def test_code_of_other_sources_is_not_read(source, monkeypatch):
    calculate(source)
    monkeypatch.setattr(kernels, "SOURCES", "others")
    assert calculate(source) == ([], False)


def test_a_full_disk_is_told_once(source, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernels._CheckedFiles, "_save_data", fail)
    (told,), found = calculate(source)
    assert "No space left on device" in told
    assert not found


def test_without_any_folder_each_process_compiles(source, monkeypatch):
    def nowhere(self, function):
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(kernels._KeptCode, "__init__", nowhere)
    assert calculate(source) == ([], False)
    assert not files(source)


def hunav(folder, *words):
    """Runs a command whose compiled code is in a folder."""
    return subprocess.run(
        [sys.executable, "-m", "hunav_drake.commands.cli", *words],
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_commands_mend_damaged_code(tmp_path):
    """Whatever of it is damaged; both that run a trial, and that look."""
    run = ("run", "free_run", "--set", "simulation.duration=1.0")
    metrics = hunav(tmp_path, *run, "--json").stdout
    for pattern in ("*.nbi", "*.nbc"):
        damages = [damage for it, damage in DAMAGE if it == pattern]
        for words in (("doctor",), (*run, "--json")):
            kept = sorted(tmp_path.rglob(pattern))
            assert len(kept) > 20
            # Of all of them, it would take minutes to compile them again.
            for damage, path in zip(
                damages, kept[:: len(kept) // len(damages)], strict=False
            ):
                damage(path)
            done = hunav(tmp_path, *words)
            assert "may be a bug" not in done.stderr
            assert done.stderr.count("is damaged") <= 1, done.stderr
            if "run" in words:
                assert done.stdout == metrics
