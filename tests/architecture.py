"""The shape of the code: `python -m tests.architecture` prints it.

A room is a folder of the first level below `hunav_drake` or `systems`, or a
file that lies loose beside such folders. An import counts wherever it
stands: in a function or for type checkers, too. A name that a package passes
on counts as one of the file that has it.
"""

import ast
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
import sys
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# The package as it is imported; `hunav_drake/systems` is a link to `systems`.
PLACES = {
    "hunav_drake": ROOT / "hunav_drake",
    "hunav_drake.systems": ROOT / "systems",
}

# The packages themselves are no rooms.
DOORS = {"", "systems"}

type Graph = Mapping[str, set[str]]


class Function(NamedTuple):
    """A function, and how many arguments it takes."""

    arguments: int
    place: str
    compiled: bool


class Walk(NamedTuple):
    """What a reader meets who follows a call, each function once."""

    functions: int
    files: int
    stays: int


@cache
def modules() -> dict[str, Path]:
    """Returns the files of the package by the names of their modules."""
    found = {}
    for package, folder in PLACES.items():
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            if parts[-1] == "__init__":
                parts = parts[:-1]
            found[".".join([package, *parts])] = path
    return dict(sorted(found.items()))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def _passed_on(name: str) -> dict[str, str]:
    """Returns the modules where a package has what it passes on."""
    path = modules().get(name)
    if path is None or path.name != "__init__.py":
        return {}
    stub = path.with_suffix(".pyi")
    return {
        alias.asname or alias.name: f"{name}.{node.module}"
        if node.level
        else node.module
        for node in tree(stub if stub.exists() else path).body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }


def _home(module: str, name: str) -> str:
    """Returns the module that has a name, which another may pass on."""
    if f"{module}.{name}" in modules():
        return f"{module}.{name}"
    further = _passed_on(module).get(name)
    return module if further is None else _home(further, name)


@cache
def imports(name: str) -> frozenset[str]:
    """Returns the modules of the package that a module imports anywhere."""
    found = set()
    for node in ast.walk(tree(modules()[name])):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {_home(node.module, alias.name) for alias in node.names}
    return frozenset(found & modules().keys() - {name})


def room(name: str) -> str:
    """Returns the room of a module."""
    parts = name.split(".")[1:]
    return "/".join(parts[: 2 if parts[:1] == ["systems"] else 1])


def arrows() -> dict[tuple[str, str], list[str]]:
    """Returns which room imports which, and by which modules."""
    found = defaultdict(list)
    for name in modules():
        for other in sorted(imports(name)):
            ends = room(name), room(other)
            if ends[0] != ends[1] and not DOORS & {*ends}:
                found[ends].append(f"{name} -> {other}")
    return dict(sorted(found.items()))


def files() -> dict[str, set[str]]:
    """Returns the files of the package, each with those that it imports."""
    return {name: set(imports(name)) for name in modules()}


def rooms() -> dict[str, set[str]]:
    """Returns the rooms, each with those that it imports."""
    graph: dict[str, set[str]] = {
        room(name): set() for name in modules() if room(name) not in DOORS
    }
    for a, b in arrows():
        graph[a].add(b)
    return graph


def circles(graph: Graph) -> list[list[str]]:
    """Returns the groups that import each other, also by detours."""
    reach: dict[str, set[str]] = {}
    for start in graph:
        seen: set[str] = set()
        todo = [start]
        while todo:
            for other in graph[todo.pop()] - seen:
                seen.add(other)
                todo.append(other)
        reach[start] = seen
    found = {
        tuple(sorted(b for b in reach[a] if a in reach[b]))
        for a in graph
        if a in reach[a]
    }
    return sorted(map(list, found))


def mutual_pairs(graph: Graph) -> list[tuple[str, str]]:
    """Returns those that import each other directly."""
    return sorted(
        (a, b) for a in graph for b in graph[a] if a < b and a in graph[b]
    )


def floors(graph: Graph) -> int:
    """Returns how many lie above each other; a circle is one floor."""
    group = {name: (name,) for name in graph}
    for circle in circles(graph):
        group |= dict.fromkeys(circle, tuple(circle))

    @cache
    def height(names: tuple[str, ...]) -> int:
        below = {group[other] for name in names for other in graph[name]}
        return 1 + max(map(height, below - {names}), default=0)

    return max(map(height, group.values()), default=0)


def lines_per_folder() -> dict[str, int]:
    """Returns how many lines of Python each folder has, in all its files."""
    counts: dict[str, int] = defaultdict(int)
    for name, path in modules().items():
        counts[room(name)] += len(path.read_text().splitlines())
    return dict(sorted(counts.items()))


def functions() -> list[Function]:
    """Returns all functions, those with most arguments first."""
    found = []
    for name, path in modules().items():
        for node in ast.walk(tree(path)):
            if not isinstance(node, ast.FunctionDef):
                continue
            a = node.args
            count = len(a.posonlyargs) + len(a.args) + len(a.kwonlyargs)
            first = (a.posonlyargs + a.args)[:1]
            count -= bool(first) and first[0].arg in ("self", "cls")
            compiled = any(
                word in ast.unparse(decorator)
                for word in ("jit", "late_as")
                for decorator in node.decorator_list
            )
            found.append(Function(count, f"{name}.{node.name}", compiled))
    return sorted(found, reverse=True)


def walk(call: Callable[[], object]) -> Walk:
    """Follows a call through the functions of the package.

    Those of `systems/common`, which all share, do not count.
    """
    places = {str(path.resolve()) for path in modules().values()}
    common = str(ROOT / "systems" / "common")
    seen = {}

    def note(frame, event, _):
        code = frame.f_code
        if event == "call" and code not in seen:
            seen[code] = str(Path(code.co_filename).resolve())

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    way = [
        place
        for code, place in seen.items()
        if place in places
        and not place.startswith(common)
        and not code.co_name.startswith("<")
    ]
    stays = [b for a, b in zip(["", *way], way, strict=False) if a != b]
    return Walk(len(way), len(set(way)), len(stays))


def walks() -> Iterator[tuple[str, Walk]]:
    """Yields how far a reader goes through the program's main calls."""
    from hunav_drake import LoadScenario, MakeTrialDiagram

    scenario = LoadScenario("passing")
    MakeTrialDiagram(scenario)  # What is loaded at the first call is no step.
    yield "LoadScenario", walk(lambda: LoadScenario("passing"))
    yield "MakeTrialDiagram", walk(lambda: MakeTrialDiagram(scenario))


def main() -> None:
    lines = lines_per_folder()
    print(f"Lines: {sum(lines.values())} in {len(modules())} files")
    for folder, count in lines.items():
        print(f"  {count:6d}  {folder or 'hunav_drake'}")
    print("\nArrows between rooms (number of imports)")
    by_room = defaultdict(list)
    for (a, b), places in arrows().items():
        by_room[a].append(f"{b} {len(places)}")
    for name, others in by_room.items():
        print(f"  {name} -> {', '.join(others)}")
    graph = rooms()
    print(f"\nRooms: {len(graph)}")
    print(f"Arrows: {len(arrows())}")
    print(f"Floors: {floors(graph)}")
    for title, found in (
        ("Rooms that import each other", mutual_pairs(graph)),
        ("Circles of rooms", circles(graph)),
        ("Circles of files", circles(files())),
    ):
        print(f"{title}: {len(found)}")
        for names in found:
            print(f"  {', '.join(names)}")
    plain = [f for f in functions() if not f.compiled]
    compiled = [f for f in functions() if f.compiled]
    print("\nLongest lists of arguments")
    for function in plain[:5]:
        print(f"  {function.arguments:3d}  {function.place}")
    print("  of compiled kernels")
    for function in compiled[:3]:
        print(f"  {function.arguments:3d}  {function.place}")
    print("\nA walk through each call")
    for call, (count, places, stays) in walks():
        print(f"  {call}: {count} functions in {places} files, {stays} stays")


if __name__ == "__main__":
    main()
