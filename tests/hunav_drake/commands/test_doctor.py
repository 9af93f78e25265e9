"""`hunav doctor` tells each trouble in one line, with what to do."""

import json
from pathlib import Path
import shutil
import socket
import subprocess

import pytest

from hunav_drake.commands import doctor


def only(findings):
    (found,) = findings
    assert "\n" not in found.text + found.remedy
    return found


def trouble(findings):
    found = only(f for f in findings if f.state != "ok")
    assert found.remedy
    return found


def test_an_old_python_is_told(monkeypatch):
    monkeypatch.setattr(doctor.platform, "python_version", lambda: "3.11.9")
    found = trouble(doctor.check_python())
    assert found.state == "trouble"
    assert found.text == "3.11.9, but >=3.12 is needed"


def test_what_is_not_installed_is_told(monkeypatch):
    def missing(name):
        raise doctor.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.metadata, "metadata", missing)
    assert "pip install" in trouble(doctor.check_python()).remedy


@pytest.mark.parametrize("present", ["0.67.9", "0.9", None])
def test_an_old_or_missing_dependency_is_told(monkeypatch, present):
    real = doctor.metadata.version

    def version(name):
        if name != "numba":
            return real(name)
        if present is None:
            raise doctor.metadata.PackageNotFoundError(name)
        return present

    monkeypatch.setattr(doctor.metadata, "version", version)
    found = trouble(doctor.check_versions())
    assert (found.name, found.state) == ("numba", "trouble")
    assert found.remedy.startswith("pip install 'numba>=0.6")


def test_what_is_installed_here_is_enough():
    found = list(doctor.check_versions())
    assert {"drake", "numpy", "numba"} <= {f.name for f in found}
    assert all(f.state == "ok" for f in found)


@pytest.mark.parametrize(
    ("version", "state"), [(None, "trouble"), ("0.0.1", "trouble")]
)
def test_an_old_copy_is_told(monkeypatch, tmp_path, version, state):
    (tmp_path / "hunav_drake").mkdir()
    (tmp_path / "hunav_drake" / "__init__.py").touch()
    if version:
        info = tmp_path / f"hunav_drake-{version}.dist-info"
        info.mkdir()
        text = f"Name: hunav_drake\nVersion: {version}\n"
        (info / "METADATA").write_text(text)
    root = str(Path(doctor.__file__).parents[2])
    monkeypatch.setattr(doctor.sys, "path", [root, str(tmp_path)])
    monkeypatch.setattr(
        doctor, "_version_in", fake_version(doctor._version_in, root)
    )
    found = trouble(doctor.check_copies())
    assert found.state == state
    assert str(tmp_path) in found.text
    assert (version or "unknown") in found.text


def fake_version(real, root):
    return lambda folder: "9.9" if str(folder) == root else real(folder)


def test_a_folder_for_compiled_code_that_cannot_be_written_is_told(monkeypatch):
    monkeypatch.setattr(doctor, "_is_writable", lambda folder: False)
    assert "NUMBA_CACHE_DIR" in trouble(doctor.check_kernels()).remedy


def test_a_folder_without_compiled_code_is_told(monkeypatch, tmp_path):
    from hunav_drake.systems.crowd.social_force import kernel

    class Stats:
        cache_path = tmp_path / "none"

    class Kernel:
        stats = Stats

    monkeypatch.setattr(kernel, "social_forces", Kernel)
    assert "first run compiles" in only(doctor.check_kernels()).text
    Stats.cache_path.mkdir()
    (Stats.cache_path / "kernel.social_forces-1.nbi").touch()
    assert only(doctor.check_kernels()).state == "ok"
    Stats.cache_path = None
    assert "NUMBA_CACHE_DIR" in trouble(doctor.check_kernels()).remedy


def test_a_folder_is_writable_if_it_could_be_made(tmp_path):
    assert doctor._is_writable(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
    assert not doctor._is_writable(Path("/proc/none"))


def test_a_full_disk_is_told(monkeypatch):
    usage = shutil._ntuple_diskusage(100, 99, 1)
    monkeypatch.setattr(doctor.shutil, "disk_usage", lambda path: usage)
    assert "--out DIR" in trouble(doctor.check_room()).remedy


def test_ports_that_are_taken_are_told(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        monkeypatch.setattr(doctor, "_PORTS", range(port, port + 1))
        assert "--no-replay" in trouble(doctor.check_port()).remedy
    assert only(doctor.check_port()).state == "ok"


def test_a_renderer_that_crashes_is_told(monkeypatch):
    def crash(*arguments, **options):
        return subprocess.CompletedProcess([], -11, "", "")

    monkeypatch.setattr(doctor.subprocess, "run", crash)
    found = trouble(doctor.check_camera())
    assert "ended with -11" in found.text
    assert "libegl1" in found.remedy

    def hang(*arguments, **options):
        raise subprocess.TimeoutExpired([], options["timeout"])

    monkeypatch.setattr(doctor.subprocess, "run", hang)
    assert "no result after 60 s" in trouble(doctor.check_camera()).text


def test_a_missing_graphviz_is_told(monkeypatch):
    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    assert "graphviz" in trouble(doctor.check_graphviz()).remedy


def test_missing_extras_are_told_with_who_needs_them(monkeypatch):
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda name: None)
    found = list(doctor.check_extras())
    lines = [f"{f.text}; {f.remedy}" for f in found]
    assert (
        "not installed, for hunav edit; pip install 'hunav_drake[editor]'"
        in lines
    )
    assert all(f.state == "note" for f in found)


def test_extras_are_those_of_the_package():
    known = set(
        doctor.metadata.metadata("hunav_drake").get_all("Provides-Extra")
    )
    assert {extra for extra, *_ in doctor._EXTRAS} == known - {"dev", "docs"}


def test_trouble_fails_and_runs_no_trial(monkeypatch, hunav):
    def broken():
        yield doctor.Finding("numba", "trouble", "0.1", "pip install numba")

    monkeypatch.setattr(doctor, "examine", broken)
    monkeypatch.setattr(doctor, "_short_runs", lambda: pytest.fail("ran"))
    code, out, _ = hunav("doctor")
    assert code == 1
    assert out.splitlines()[0] == (
        "trouble  numba          0.1; pip install numba"
    )
    code, out, _ = hunav("doctor", "--json")
    assert code == 1
    assert json.loads(out) == {
        "ok": False,
        "findings": [
            {
                "name": "numba",
                "state": "trouble",
                "text": "0.1",
                "remedy": "pip install numba",
            }
        ],
    }


def test_notes_are_no_trouble(monkeypatch, hunav):
    note = doctor.Finding("dask", "note", "not installed", "pip install it")
    monkeypatch.setattr(doctor, "examine", lambda: iter([note]))
    monkeypatch.setattr(doctor, "_short_runs", lambda: iter([]))
    code, out, _ = hunav("doctor", "--json")
    assert code == 0
    assert json.loads(out)["ok"]
