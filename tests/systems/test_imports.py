"""Which file may know which: the shape of the package."""

import ast
from pathlib import Path

import pytest

import hunav_drake

PACKAGE = Path(hunav_drake.__file__).parent
SYSTEMS = PACKAGE / "systems"
FILES = sorted(p for p in SYSTEMS.rglob("*.py") if p.name != "__init__.py")


def imported(path):
    """Yields the modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def file_of(module):
    parts = module.split(".")
    path = PACKAGE.joinpath(*parts[1:]).with_suffix(".py")
    return path if parts[0] == "hunav_drake" and path.is_file() else None


def uses_drake(path):
    return any(name.split(".")[0] == "pydrake" for name in imported(path))


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_a_block_knows_nothing_of_the_application(path):
    for name in imported(path):
        if name.startswith("hunav_drake."):
            assert name.startswith("hunav_drake.systems"), name


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_blocks_meet_through_ports(path):
    """Of another block they know configurations and functions on data."""
    block = SYSTEMS / path.relative_to(SYSTEMS).parts[0]
    for name in imported(path):
        other = file_of(name)
        if (
            other is not None
            and other.is_relative_to(SYSTEMS)
            and not other.is_relative_to(block)
            and other.parent != SYSTEMS
        ):
            assert not uses_drake(other), f"{path} imports {other}"


def test_configurations_do_without_drake():
    configs = [*SYSTEMS.rglob("*_config.py"), SYSTEMS / "world.py"]
    assert len(configs) > 5
    for path in configs:
        assert not uses_drake(path)
