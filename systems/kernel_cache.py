"""Sees to it that compiled code on disk is that of the present sources.

Numba keeps what it compiles beside the source file, for as long as that file
stays the same. It does not notice when a function that was compiled into it,
from another file, has changed.
"""

import contextlib
import hashlib
from pathlib import Path

_FOLDER = Path(__file__).parent
_STAMP = _FOLDER / "__pycache__" / "kernels.sha256"


def drop_stale_kernels(folder: Path = _FOLDER, stamp: Path = _STAMP) -> bool:
    """Deletes all compiled code if one of the sources has changed.

    Where nothing can be written, numba keeps its code elsewhere, in a place
    that is named after the folder of the sources.

    Args:
        folder: Where the sources are.
        stamp: The file that remembers what they were.

    Returns:
        Whether there was a change.
    """
    content = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        text = path.read_bytes()
        if b"jit" in text:
            content.update(path.name.encode() + text)
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
