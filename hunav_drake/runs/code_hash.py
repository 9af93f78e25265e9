"""Hashes of the code that determines runs, to detect changed code."""

from collections.abc import Iterable, Iterator, Sequence
import hashlib
import importlib.util
import os
from pathlib import Path

# The code of this package, among the names of the user's modules and files.
PACKAGE = "hunav_drake"

# Hashes by name: of the package, and of modules and files of the user.
CodeHashes = tuple[tuple[str, str], ...]

_ROOT = Path(__file__).resolve().parents[1]
_KINDS = (".py", ".sdf", ".xml")
# Folders that show or read runs, and do not affect them.
_ASIDE = (
    *("runs/comparison", "commands", "editor", "report", "validation"),
    "views",
)


def hash_code(imports: Sequence[str] = ()) -> CodeHashes:
    """Returns the hashes of the package's code and of the user's.

    Args:
        imports: Modules and files of the user, as with `--import`. Modules
            that these import do not count.

    Raises:
        OSError: If a file cannot be read.
        ImportError: If there is no such module.
    """
    return tuple((name, code_sha256(name)) for name in (PACKAGE, *imports))


def hash_of_all(hashes: CodeHashes) -> str:
    """Returns one hash of several; it does not depend on folders of files."""
    lines = (f"{Path(name).name} {sha256}\n" for name, sha256 in hashes)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def code_sha256(name: str) -> str:
    """Returns the hash of the code of the package, a module or a file."""
    if name == PACKAGE:
        return _hash(_ROOT, _below(_ROOT))
    if name.endswith(".py"):
        return _hash(Path(name).parent, [Path(name)])
    spec = importlib.util.find_spec(name)
    if spec is None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    if spec.submodule_search_locations:
        folder = Path(spec.submodule_search_locations[0])
        return _hash(folder, _below(folder))
    origin = Path(spec.origin or "")
    return _hash(origin.parent, [origin] if origin.is_file() else [])


def _below(root: Path) -> Iterator[Path]:
    """Yields the code files in a folder; links are followed."""
    aside = {root / name for name in _ASIDE} if root == _ROOT else set()
    for folder, inner, names in os.walk(root, followlinks=True):
        inner[:] = [it for it in inner if Path(folder, it) not in aside]
        yield from (Path(folder, it) for it in names if it.endswith(_KINDS))


def _hash(root: Path, paths: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for path in sorted(paths):
        content = path.read_bytes()
        name = path.relative_to(root).as_posix()
        found.update(f"{name} {len(content)}\n".encode())
        found.update(content)
    return found.hexdigest()
