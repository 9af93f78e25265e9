"""The shape of the code: `python -m tests.architecture` prints it.

Files per folder, lines per file, arrows between rooms, circles of imports,
and the longest lists of arguments.
"""

import ast
from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# The package as it is imported; `hunav_drake/systems` is a link to `systems`.
PLACES = {
    "hunav_drake.systems": ROOT / "systems",
    "hunav_drake": ROOT / "hunav_drake",
}


class Function(NamedTuple):
    """A function, and how many arguments it takes."""

    arguments: int
    place: str
    compiled: bool


@cache
def modules() -> dict[str, Path]:
    """Returns the files of the package by the names of their modules."""
    found = {}
    for package, folder in PLACES.items():
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            if parts[-1] == "__init__":
                parts = parts[:-1]
            found.setdefault(".".join([package, *parts]), path)
    # The link is one way to the files of the systems, not a second place.
    seen: dict[Path, str] = {}
    for name, path in found.items():
        real = path.resolve()
        if real not in seen:
            seen[real] = name
    return {
        name: path for path, name in sorted(seen.items(), key=lambda i: i[1])
    }


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def _at_import(node: ast.AST):
    """Yields the nodes that run when a module is imported."""
    for child in ast.iter_child_nodes(node):
        if isinstance(
            child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
        ):
            continue
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(
            child.test
        ):
            continue
        yield child
        yield from _at_import(child)


def imports(name: str, *, at_import: bool = False) -> set[str]:
    """Returns the modules of the package that a module imports.

    Args:
        name: The module.
        at_import: Whether only those count that are imported with it, not
            those that a function imports when it is called.
    """
    known = modules()
    nodes = (
        _at_import(tree(known[name]))
        if at_import
        else ast.walk(tree(known[name]))
    )
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif (
            isinstance(node, ast.ImportFrom) and node.module and not node.level
        ):
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.add(inner if inner in known else node.module)
    return {other for other in found if other in known and other != name}


def room(name: str) -> str:
    """Returns the room of a module: a folder of systems/ or of the package."""
    parts = name.split(".")
    if parts[:2] == ["hunav_drake", "systems"]:
        return "/".join(["systems", *parts[2:3]])
    path = modules()[name]
    is_package = path.name == "__init__.py"
    inner = len(parts) > 2 or (is_package and len(parts) == 2)
    return parts[1] if inner else "hunav_drake"


def arrows() -> dict[tuple[str, str], list[str]]:
    """Returns which room imports which, and by which modules."""
    found = defaultdict(list)
    for name in modules():
        for other in sorted(imports(name)):
            ends = room(name), room(other)
            if ends[0] != ends[1]:
                found[ends].append(f"{name} -> {other}")
    return dict(sorted(found.items()))


def circles() -> list[list[str]]:
    """Returns the circles of modules that import each other as they load."""
    graph = {name: imports(name, at_import=True) for name in modules()}
    return _components(graph)


def room_circles() -> list[list[str]]:
    """Returns the circles of rooms of systems/."""
    graph = defaultdict(set)
    for a, b in arrows():
        if a.startswith("systems/") and b.startswith("systems/"):
            graph[a].add(b)
            graph[b] |= set()
    return _components(graph)


def _components(graph):
    """Returns the strongly connected components of more than one node."""
    reach: dict[str, set[str]] = {}
    for start in graph:
        seen: set[str] = set()
        todo = [start]
        while todo:
            for other in graph.get(todo.pop(), ()):
                if other not in seen:
                    seen.add(other)
                    todo.append(other)
        reach[start] = seen
    found = {
        tuple(sorted(b for b in reach[a] if a in reach[b]))
        for a in graph
        if a in reach[a]
    }
    return sorted(map(list, found))


def files_per_folder() -> dict[str, int]:
    """Returns how many files of Python, but for `__init__.py`, a folder has."""
    counts: dict[str, int] = defaultdict(int)
    for path in modules().values():
        folder = str(path.parent.relative_to(ROOT))
        counts[folder] += path.name != "__init__.py"
    return dict(sorted(counts.items()))


def lines_per_file() -> dict[str, int]:
    """Returns how many lines each file has, the longest first."""
    counts = {
        str(path.relative_to(ROOT)): len(path.read_text().splitlines())
        for path in modules().values()
    }
    return dict(sorted(counts.items(), key=lambda item: -item[1]))


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
                for decorator in node.decorator_list
                for word in ("jit", "vectorized")
            )
            found.append(Function(count, f"{name}.{node.name}", compiled))
    return sorted(found, reverse=True)


def main() -> None:
    print("Files per folder")
    for folder, count in files_per_folder().items():
        print(f"  {count:3d}  {folder}")
    lines = lines_per_file()
    print(f"\nLines: {sum(lines.values())} in {len(lines)} files; the longest")
    for path, count in list(lines.items())[:10]:
        print(f"  {count:4d}  {path}")
    print("\nArrows between rooms (number of imports)")
    by_room = defaultdict(list)
    for (a, b), places in arrows().items():
        by_room[a].append(f"{b} {len(places)}")
    for a, others in by_room.items():
        print(f"  {a} -> {', '.join(others)}")
    print(f"\nCircles of modules: {len(circles())}")
    for circle in circles():
        print("  " + ", ".join(circle))
    print(f"Circles of rooms of systems/: {len(room_circles())}")
    for circle in room_circles():
        print("  " + ", ".join(circle))
    plain = [f for f in functions() if not f.compiled]
    compiled = [f for f in functions() if f.compiled]
    print("\nLongest lists of arguments")
    for function in plain[:5]:
        print(f"  {function.arguments:3d}  {function.place}")
    print("  of compiled kernels")
    for function in compiled[:3]:
        print(f"  {function.arguments:3d}  {function.place}")


if __name__ == "__main__":
    main()
