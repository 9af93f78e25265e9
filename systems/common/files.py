"""Atomic writing of files."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import errno
import glob
import os
from pathlib import Path
import secrets
from typing import BinaryIO

_DRAFT = ".{}.{}.tmp"


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Opens a binary file that takes its name only when it is complete.

    What had the name before stays until then, and stays for good if the block
    raises. The folder must exist.

    Raises:
        OSError: If the file cannot be written; it names ``path``.
    """
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "Not a regular file", str(path))
    # Beside the target, since only within one file system a rename is atomic.
    draft = target.with_name(_DRAFT.format(target.name, secrets.token_hex(8)))
    try:
        with draft.open("xb") as file:
            yield file
        os.replace(draft, target)
    except OSError as error:
        if error.filename != str(draft):
            raise
        # Nobody knows the draft by its name.
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with suppress(OSError):
            draft.unlink()


def remove_drafts(path: str | Path) -> None:
    """Removes what killed writers of a file have left beside it.

    Nobody may be writing it.
    """
    target = Path(path).resolve()
    name = _DRAFT.format(glob.escape(target.name), "*")
    for draft in target.parent.glob(name):
        with suppress(OSError):
            draft.unlink()
