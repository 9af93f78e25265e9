"""The command `hunav doctor`: finds problems of a machine."""

import argparse
from collections.abc import Iterator
import dataclasses
from importlib import metadata
import importlib.util
import json
import os
from pathlib import Path
import platform
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from typing import Literal

from hunav_drake.commands.errors import DONE, FAILED

# The space that recordings and replays of a suite need, in bytes.
_ROOM = 1 << 30

# The ports at which Meshcat tries to listen.
_PORTS = range(7000, 7100)

# The time limit for the start of a camera, in seconds.
_CAMERA_TIME = 60.0

# Optional extras: name, a module of it, and what needs it.
_EXTRAS = (
    ("completion", "shtab", "hunav completion"),
    ("dask", "distributed", "hunav bench --executor dask"),
    ("editor", "anywidget", "hunav edit"),
    ("falsify", "cma", "hunav falsify"),
    ("film", "av", "hunav render to .mp4"),
    ("gazebo", "trimesh", "meshes of worlds of Gazebo"),
    ("notebook", "jupyterlab", "make notebook"),
    ("ros", "rosbags", "hunav export and hunav bridge"),
    ("xacro", "xacro", "robots of .xacro files"),
)

_REQUIREMENT = re.compile(r"([\w.-]+)(?:\[[^]]*\])?\s*>=\s*([\w.]+)")


@dataclasses.dataclass(frozen=True)
class Finding:
    """The result of one check.

    Attributes:
        name: The subject of the check.
        state: `ok`; `note` for what only some users need; `trouble` for what
            must be fixed.
        text: The result in words.
        remedy: How to fix it; empty if nothing needs to be done.
    """

    name: str
    state: Literal["ok", "note", "trouble"]
    text: str
    remedy: str = ""


def add_doctor_options(doctor: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav doctor`."""
    doctor.set_defaults(function=_doctor)
    doctor.add_argument(
        "--json", action="store_true", help="print the findings as JSON"
    )


def _doctor(options: argparse.Namespace) -> int:
    found = []
    for finding in find_all():
        found.append(finding)
        if not options.json:
            print(_line(finding), flush=True)
    troubles = sum(finding.state == "trouble" for finding in found)
    if options.json:
        findings = [dataclasses.asdict(finding) for finding in found]
        print(json.dumps({"ok": not troubles, "findings": findings}, indent=2))
    else:
        print(
            f"\n{troubles} to fix: see the lines with 'trouble'"
            if troubles
            else "\nNothing is missing."
        )
    return FAILED if troubles else DONE


def _line(finding: Finding) -> str:
    remedy = f"; {finding.remedy}" if finding.remedy else ""
    return f"{finding.state:8} {finding.name:14} {finding.text}{remedy}"


def find_all() -> Iterator[Finding]:
    """Yields all findings; runs trials only if there is no trouble."""
    troubles = 0
    for finding in examine():
        troubles += finding.state == "trouble"
        yield finding
    if not troubles:
        yield from _short_runs()


def _short_runs() -> Iterator[Finding]:
    """Runs a short trial twice, and compares the results."""
    from hunav_drake.runs.compiling_ahead import compiling_ahead
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.trial.compiling import told_compile_time
    from hunav_drake.trial.simulation import RunTrial

    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=2.0"]
    )
    started = time.perf_counter()
    with told_compile_time(lambda: compiling_ahead(scenario)) as compiled:
        first = RunTrial(scenario)
    elapsed = time.perf_counter() - started - compiled.seconds
    yield Finding(
        "short run", "ok", f"{elapsed:.2f} s for {first.end_time:g} s"
    )
    if first.recording == RunTrial(scenario).recording:
        yield Finding("repeats", "ok", "bit for bit")
    else:
        yield Finding(
            "repeats",
            "trouble",
            "two equal runs differ",
            "report it, with the output of `hunav doctor --json`",
        )


def examine() -> Iterator[Finding]:
    """Yields the findings about this machine, each as soon as it is known."""
    for look in (
        *(check_python, check_versions, check_copies, check_kernels),
        *(check_room, check_port, check_camera),
        *(check_graphviz, check_extras),
    ):
        yield from look()


def check_python() -> Iterator[Finding]:
    """Checks the version of Python."""
    present = platform.python_version()
    try:
        wanted = metadata.metadata("hunav_drake")["Requires-Python"] or ""
    except metadata.PackageNotFoundError:
        yield Finding(
            "hunav_drake",
            "trouble",
            "is used from a folder, but is not installed",
            "pip install -e . in the clone, or pip install hunav_drake",
        )
        return
    lowest = wanted.removeprefix(">=")
    if _key(present) < _key(lowest):
        yield Finding(
            "python",
            "trouble",
            f"{present}, but {wanted} is needed",
            f"make a new environment with Python {lowest} or newer",
        )
        return
    yield Finding("python", "ok", f"{present} ({sys.executable})")


def check_versions() -> Iterator[Finding]:
    """Checks the versions of the required packages."""
    try:
        required = metadata.requires("hunav_drake") or []
    except metadata.PackageNotFoundError:
        return
    for requirement in required:
        bound = _REQUIREMENT.fullmatch(requirement.strip())
        if bound is None:
            # A requirement of an extra: see `check_extras`.
            continue
        name, lowest = bound.groups()
        remedy = f"pip install '{name}>={lowest}'"
        try:
            present = metadata.version(name)
        except metadata.PackageNotFoundError:
            yield Finding(name, "trouble", "not installed", remedy)
            continue
        if _key(present) < _key(lowest):
            text = f"{present}, but at least {lowest} is needed"
            yield Finding(name, "trouble", text, remedy)
        else:
            yield Finding(name, "ok", present)


def check_copies() -> Iterator[Finding]:
    """Looks for other copies of the package on the path."""
    import hunav_drake

    used = Path(hunav_drake.__file__).resolve().parent
    version = _version_in(used.parent)
    for entry in sys.path:
        other = Path(entry or os.curdir, "hunav_drake").resolve()
        if other == used or not (other / "__init__.py").is_file():
            continue
        found = _version_in(other.parent)
        yield Finding(
            "copies",
            "note" if found == version else "trouble",
            f"{used} ({version}) is used, but {other} ({found}) exists, too",
            "pip uninstall hunav_drake until none is left; install it again",
        )


def check_kernels() -> Iterator[Finding]:
    """Checks whether compiled code can be cached, and whether it is."""
    name = "compiled code"
    remedy = "set NUMBA_CACHE_DIR to a folder that can be written"
    from hunav_drake.systems.crowd.social_force import kernel

    # Empty if numba finds no folder.
    folder = Path(kernel.social_forces.stats.cache_path or "")
    if not folder.name or not _is_writable(folder):
        where = f" in {folder}" if folder.name else ""
        text = f"cannot be kept{where}: each run compiles it again"
        yield Finding(name, "trouble", text, remedy)
    elif any(folder.glob("*.nbi")):
        yield Finding(name, "ok", f"is kept in {folder}")
    else:
        yield Finding(
            name,
            "note",
            f"none yet in {folder}: the first run compiles it, once",
        )


def check_room() -> Iterator[Finding]:
    """Checks the free space for results in the current folder."""
    free = shutil.disk_usage(os.curdir).free
    text = f"{free / 1e9:.1f} GB free in {Path.cwd()}"
    if free < _ROOM:
        remedy = "free some space, or write elsewhere with --out DIR"
        yield Finding("disk", "trouble", text, remedy)
    else:
        yield Finding("disk", "ok", text)


def check_port() -> Iterator[Finding]:
    """Checks whether Meshcat can open a port on this machine."""
    error: OSError | None = None
    for port in _PORTS:
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as it:
            try:
                it.bind(("127.0.0.1", port))
            except OSError as refused:
                error = refused
                continue
        yield Finding("meshcat", "ok", f"port {port} is free")
        return
    yield Finding(
        "meshcat",
        "trouble",
        f"no port from {_PORTS[0]} to {_PORTS[-1]} can be used: {error}",
        "end other programs that use these ports, or run with --no-replay",
    )


def check_camera() -> Iterator[Finding]:
    """Checks whether cameras can render, in a process that may crash."""
    code = f"from {__name__} import draw_once; draw_once()"
    try:
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_CAMERA_TIME,
            check=False,
        )
        failed = done.returncode != 0
        lines = done.stderr.strip().splitlines() or [
            f"the renderer ended with {done.returncode}"
        ]
    except subprocess.TimeoutExpired:
        failed, lines = True, [f"no result after {_CAMERA_TIME:g} s"]
    if failed:
        yield Finding(
            "camera",
            "note",
            f"cannot draw ({lines[-1]}): no cameras, no films",
            "install EGL: apt-get install libegl1 libgl1",
        )
    else:
        yield Finding("camera", "ok", "draws without a display")


def draw_once() -> None:
    """Renders an empty scene with a camera, as a test of the renderer."""
    from pydrake.geometry import (
        ClippingRange,
        ColorRenderCamera,
        MakeRenderEngineVtk,
        RenderCameraCore,
        RenderEngineVtkParams,
        SceneGraph,
    )
    from pydrake.math import RigidTransform
    from pydrake.systems.sensors import CameraInfo

    scene = SceneGraph()
    scene.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))
    core = RenderCameraCore(
        "vtk",
        CameraInfo(width=8, height=8, fov_y=1.0),
        ClippingRange(0.1, 10.0),
        RigidTransform(),
    )
    query = scene.get_query_output_port().Eval(scene.CreateDefaultContext())
    query.RenderColorImage(
        ColorRenderCamera(core), scene.world_frame_id(), RigidTransform()
    )


def check_graphviz() -> Iterator[Finding]:
    """Checks whether pictures of trees and diagrams can be drawn."""
    found = shutil.which("dot")
    if found is None:
        yield Finding(
            "graphviz",
            "note",
            "not installed: no pictures of behavior trees and diagrams",
            "apt-get install graphviz, or brew install graphviz",
        )
    else:
        yield Finding("graphviz", "ok", found)


def check_extras() -> Iterator[Finding]:
    """Checks which optional extras are installed."""
    for extra, module, command in _EXTRAS:
        if importlib.util.find_spec(module) is not None:
            yield Finding(extra, "ok", f"for {command}")
        else:
            yield Finding(
                extra,
                "note",
                f"not installed, for {command}",
                f"pip install 'hunav_drake[{extra}]'",
            )


def _key(version: str) -> tuple[int, ...]:
    """Returns the leading numbers of a version, without zeros at the end."""
    leading = re.match(r"\d+(\.\d+)*", version)
    numbers = [int(it) for it in leading[0].split(".")] if leading else []
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def _version_in(folder: Path) -> str:
    """Returns the version that is installed in a folder."""
    for found in metadata.distributions(name="hunav_drake", path=[str(folder)]):
        return found.version
    return "of unknown version"


def _is_writable(folder: Path) -> bool:
    """Returns whether files can be written to a folder, or it be created."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
