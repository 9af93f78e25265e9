"""The shape of the package: rooms, sizes, and which file may know which."""

import ast
from collections import defaultdict
import importlib
from pathlib import Path
import sys

import pytest

import hunav_drake
from tests import architecture

PACKAGE = Path(hunav_drake.__file__).parent
SYSTEMS = PACKAGE / "systems"
FILES = sorted(p for p in SYSTEMS.rglob("*.py") if p.name != "__init__.py")


def imported(text):
    """Yields the files of this package that a text imports, wherever in it."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from files_of(alias.name, None)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                yield from files_of(node.module, alias.name)


def files_of(module, name):
    """Yields the file of a module, or the one where its export is defined."""
    if module.split(".")[0] != "hunav_drake":
        return
    imported = importlib.import_module(module)
    if name is not None and Path(imported.__file__).name == "__init__.py":
        # A package: what counts is where the name comes from.
        value = getattr(imported, name, None)
        home = getattr(value, "__module__", None) or f"{module}.{name}"
        imported = sys.modules.get(home, imported)
    yield Path(imported.__file__)


def uses_drake(path):
    nodes = ast.walk(ast.parse(path.read_text()))
    names = [
        node.module if isinstance(node, ast.ImportFrom) else alias.name
        for node in nodes
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    ]
    return any((name or "").split(".")[0] == "pydrake" for name in names)


def breaches(path, text):
    """Yields what a file of a block must not import, but does."""
    block = SYSTEMS / path.relative_to(SYSTEMS).parts[0]
    for other in imported(text):
        if not other.is_relative_to(SYSTEMS):
            yield f"the application: {other.relative_to(PACKAGE)}"
        elif (
            not other.is_relative_to(block)
            and not other.is_relative_to(SYSTEMS / "common")
            and uses_drake(other)
        ):
            yield f"another system: {other.relative_to(SYSTEMS)}"


@pytest.mark.slow
def test_blocks_meet_through_ports():
    """Of another block they know configurations and functions on data."""
    assert len(FILES) > 200
    found = [
        f"{path.relative_to(SYSTEMS)}: {breach}"
        for path in FILES
        for breach in breaches(path, path.read_text())
    ]
    assert found == []


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("from hunav_drake.systems.crowd import HumanCrowd", "human_crowd"),
        (
            "from hunav_drake.systems.crowd.human_crowd import HumanCrowd",
            "another system",
        ),
        (
            "def f():\n    import hunav_drake.systems.crowd.open_crowd",
            "open_crowd",
        ),
        ("from hunav_drake.trial.humans import AddHumans", "the application"),
        ("from hunav_drake import AddHumans", "the application"),
    ],
)
def test_a_breach_is_found(line, words):
    path = SYSTEMS / "robot" / "differential_drive.py"
    (breach,) = breaches(path, line)
    assert words in breach


@pytest.mark.parametrize(
    "line",
    [
        "from hunav_drake.systems.people import HumanConfig",
        "from hunav_drake.systems.robot import RobotConfig",
        "from hunav_drake.systems.world.shapes import World",
        "from pydrake.systems.framework import LeafSystem",
    ],
)
def test_what_is_allowed_is_no_breach(line):
    path = SYSTEMS / "robot" / "differential_drive.py"
    assert not list(breaches(path, line))


def test_configurations_do_without_drake():
    configs = [*SYSTEMS.rglob("*_config.py"), SYSTEMS / "world/shapes.py"]
    assert len(configs) > 4
    for path in configs:
        assert not uses_drake(path)


@pytest.mark.slow
def test_no_file_imports_itself_by_a_detour():
    assert architecture.circles(architecture.files()) == []


def test_rooms_import_one_way():
    rooms = architecture.rooms()
    assert architecture.circles(rooms) == []
    assert architecture.mutual_pairs(rooms) == []


def test_rooms_are_few_and_low():
    rooms = architecture.rooms()
    assert {"systems/crowd", "scenario", "trial"} <= set(rooms)
    assert len(rooms) <= 22
    assert len(architecture.arrows()) <= 130
    assert architecture.floors(rooms) <= 12


def test_circles_are_found():
    graph = {
        "a": {"b"},
        "b": {"a", "d"},
        "c": {"a"},
        "d": {"e"},
        "e": {"f"},
        "f": {"d", "g"},
        "g": set(),
    }
    assert architecture.circles(graph) == [["a", "b"], ["d", "e", "f"]]
    assert architecture.mutual_pairs(graph) == [("a", "b")]
    # c; a and b; d, e and f; g
    assert architecture.floors(graph) == 4


def test_imports_count_wherever_they_stand(monkeypatch, tmp_path):
    texts = {
        "hunav_drake": "",
        "hunav_drake.pack": "from hunav_drake.a import One",
        "hunav_drake.a": "One = Two = 1",
        "hunav_drake.b": "def f():\n    import hunav_drake.a",
        "hunav_drake.c": "if TYPE_CHECKING:\n"
        "    from hunav_drake.pack import One",
        "hunav_drake.d": "from hunav_drake.pack import Other",
        "hunav_drake.e": "from hunav_drake import c, lazy_name\nimport os",
    }
    paths = {
        name: tmp_path / name / "__init__.py"
        if name in ("hunav_drake", "hunav_drake.pack")
        else tmp_path / f"{name}.py"
        for name in texts
    }
    for name, text in texts.items():
        paths[name].parent.mkdir(exist_ok=True)
        paths[name].write_text(text)
    stub = paths["hunav_drake"].with_suffix(".pyi")
    stub.write_text("from .b import lazy_name as lazy_name")
    monkeypatch.setattr(architecture, "modules", lambda: paths)
    caches = (architecture.imports, architecture._passed_on)
    for cached in caches:
        cached.cache_clear()
    try:
        found = {
            name.rpartition(".")[2]: {
                other.rpartition(".")[2] for other in architecture.imports(name)
            }
            for name in texts
        }
    finally:
        for cached in caches:
            cached.cache_clear()
    assert found == {
        "hunav_drake": set(),
        "pack": {"a"},
        "a": set(),
        "b": {"a"},
        "c": {"a"},
        "d": {"pack"},
        "e": {"b", "c"},
    }


def test_argument_lists_are_short():
    """Kernels of numba must have theirs spelled out."""
    found = [f for f in architecture.functions() if not f.compiled]
    assert [f for f in found if f.arguments > 8] == []


def equal_helpers(texts):
    """Returns the places of functions that have equal bodies, in groups.

    Those of a test or a fixture may say the same, and so may those that only
    return a constant.
    """
    found = defaultdict(list)
    for place, text in texts.items():
        for node in ast.parse(text).body:
            if not isinstance(node, ast.FunctionDef):
                continue
            decorators = map(ast.unparse, node.decorator_list)
            if node.name.startswith("test_") or any(
                "fixture" in decorator for decorator in decorators
            ):
                continue
            body = node.body[ast.get_docstring(node) is not None :]
            # More than a constant has a name in it.
            if any(
                isinstance(part, ast.Name)
                for part in ast.walk(ast.Module(body, []))
            ):
                key = "".join(map(ast.dump, body))
                found[key].append(f"{place}: {node.name}")
    return [places for places in found.values() if len(places) > 1]


def test_helpers_of_tests_stand_once():
    tests = Path(__file__).parent
    texts = {
        str(path.relative_to(tests)): path.read_text()
        for path in sorted(tests.rglob("*.py"))
    }
    assert len(texts) > 100
    assert equal_helpers(texts) == []


def test_equal_helpers_are_found():
    one = 'def at(x):\n    """A place."""\n    return [x, 0]\n'
    other = "def place(x):\n    return [x, 0]\n"
    test = "def test_at(x):\n    return [x, 0]\n"
    fixture = "@pytest.fixture\ndef who(x):\n    return [x, 0]\n"
    constant = "def yes(x):\n    return True\ndef no(x):\n    return True\n"
    assert equal_helpers({"a": one, "b": test + fixture + constant}) == []
    assert equal_helpers({"a": one, "b": other}) == [["a: at", "b: place"]]
