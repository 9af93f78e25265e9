"""The image has what `make demo` needs; here, no image is built."""

from fnmatch import fnmatch
import os
from pathlib import Path, PurePosixPath
import re
import tomllib

ROOT = Path(__file__).resolve().parents[1]
DOCKERFILE = (ROOT / "Dockerfile").read_text()
MAKEFILE = (ROOT / "Makefile").read_text()
PATTERNS = (ROOT / ".dockerignore").read_text().split()


def is_left_out(path):
    """Whether .dockerignore leaves a path out, or a folder that it is in."""
    path = PurePosixPath(path)
    for place in (path, *path.parents):
        for pattern in PATTERNS:
            anywhere = pattern.removeprefix("**/")
            if anywhere != pattern and fnmatch(place.name, anywhere):
                return True
            # A pattern without / is of the top folder.
            if place.parent == PurePosixPath(".") and fnmatch(
                place.name, pattern
            ):
                return True
    return False


def test_patterns_are_of_the_kinds_that_are_understood_here():
    assert all("/" not in p.removeprefix("**/") for p in PATTERNS)
    assert not [p for p in PATTERNS if p[0] in "!#"]


def test_what_a_demo_needs_is_in_the_image():
    needed = [".python-version", "Makefile", "pyproject.toml"]
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    needed += [project["readme"], *project["license-files"]]
    for folder, folders, files in os.walk(
        ROOT / "hunav_drake", followlinks=True
    ):
        folders[:] = [name for name in folders if name != "__pycache__"]
        place = Path(folder).relative_to(ROOT)
        needed += [(place / name).as_posix() for name in files]
    # What links point to is there, too.
    needed += ["hunav_drake/systems", "systems", "scenarios"]
    assert len(needed) > 400
    for path in needed:
        assert (ROOT / path).exists()
        assert not is_left_out(path), path


def test_what_was_built_here_is_not():
    for path in (
        ".git/HEAD",
        ".venv/bin/python",
        ".venv-lowest/bin/python",
        "out/demo/runs",
        "systems/crowd/__pycache__/orca.nbi",
    ):
        assert is_left_out(path)


def test_its_python_and_its_targets_are_those_of_the_project():
    wanted = (ROOT / ".python-version").read_text().strip()
    assert re.search(rf"^FROM python:{re.escape(wanted)}-", DOCKERFILE, re.M)
    (ready,) = re.findall(r"^RUN make (.*)$", DOCKERFILE, re.M)
    assert ready == ".venv/.ready"
    assert re.search(r"^VENV := \.venv$", MAKEFILE, re.M)
    assert re.search(r"^READY := \$\(VENV\)/\.ready$", MAKEFILE, re.M)
    (target,) = re.findall(r'^CMD \["make", "(\w+)"\]$', DOCKERFILE, re.M)
    assert re.search(rf"^{target}: \$\(READY\)$", MAKEFILE, re.M)
    packages = re.search(
        r"--no-install-recommends((?:\s|\\|[\w.+-])+)&&", DOCKERFILE
    )
    assert "make" in packages[1].split()
