"""Drops compiled code on disk when its sources have changed.

Numba keeps what it compiles beside the source file, for as long as that file
stays the same. It does not notice when a function that was compiled into it,
from another file, has changed.
"""

import contextlib
import hashlib
from pathlib import Path
import re

_FOLDER = Path(__file__).parents[1]
_STAMP = _FOLDER / "__pycache__" / "kernels.sha256"
_JIT = re.compile(rb"\bn?jit(_as)?\b")
_IMPORT = re.compile(rb"^ *from hunav_drake\.systems\.([\w.]+) import", re.M)


def drop_stale_kernels(folder: Path = _FOLDER, stamp: Path = _STAMP) -> bool:
    """Deletes all compiled code if one of its sources has changed.

    They are the files that compile something, and all that these import: a
    constant is compiled in like a function.

    Where nothing can be written, numba keeps its code elsewhere, in a place
    that is named after the folder of the sources.

    Returns:
        Whether the sources differ from what file `stamp` remembers.
    """
    content = hashlib.sha256()
    for path, text in sorted(_compiled_from(folder).items()):
        content.update(f"{path.relative_to(folder)}\n".encode() + text)
    present = content.hexdigest()
    with contextlib.suppress(OSError):
        if stamp.read_text() == present:
            return False
    with contextlib.suppress(OSError):
        for path in folder.rglob("__pycache__/*.nb[ic]"):
            path.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(present)
    return True


def _compiled_from(folder: Path) -> dict[Path, bytes]:
    """Returns the files that compiled code is made of, and their texts."""
    found: dict[Path, bytes] = {}
    todo = [p for p in folder.rglob("*.py") if _JIT.search(p.read_bytes())]
    while todo:
        path = todo.pop()
        if path in found or not path.is_file():
            continue
        found[path] = path.read_bytes()
        for name in _IMPORT.findall(found[path]):
            module = folder / name.decode().replace(".", "/")
            todo += [module.with_suffix(".py"), module / "__init__.py"]
    return found
