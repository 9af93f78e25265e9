"""File names, atomic writing, and reading of packed files up to a limit.

A packed file may be a thousand times as large unpacked, and exhaust the memory.
So no other module unpacks files that it has not packed itself.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import errno
import glob
import gzip
import os
from pathlib import Path
import re
import secrets
from typing import Any, BinaryIO
import unicodedata
import zipfile
import zlib

import numpy as np
from numpy.typing import NDArray

# The variable with the limit of memory for unpacked files, in GB.
VARIABLE = "HUNAV_UNPACKED_GB"
_USUAL_GB = 2.0

# The memory of a table of short rows, in bytes per byte of text.
_TEXT_FACTOR = 20

_DRAFT = ".{}.{}.tmp"

# Parts that no file name may have, or that some system reads otherwise.
_UNFIT = re.compile(
    r"[\\/:*?\"<>|]|^[ .-]|[ .]$"
    r"|^(con|prn|aux|nul|com\d|lpt\d)(\..*)?$",
    re.IGNORECASE,
)
_MOST_BYTES = 200

FILE_NAME_RULE = (
    "must be fit for the name of a file on any system: without"
    ' / \\ : * ? " < > |, no dot, dash or blank at its beginning, no dot or'
    " blank at its end, short, and no device such as con"
)


def is_file_name(text: str) -> bool:
    """Returns whether a text may be the name of a file: see FILE_NAME_RULE."""
    return (
        text.isprintable()
        and 0 < len(text.encode()) <= _MOST_BYTES
        # Some systems take a wide letter for the usual one.
        and not _UNFIT.search(unicodedata.normalize("NFKC", text))
    )


def file_name_part(text: str) -> str:
    """Returns a text as a part of a file name: plain letters."""
    return re.sub(r"[^A-Za-z0-9._+-]+", "_", text)


def as_file_name(text: str) -> str:
    """Returns a text if it is valid, with at most 64 letters, else a part."""
    if len(text) <= 64 and is_file_name(text):
        return text
    name = file_name_part(text).strip(".-")[:60].rstrip(".")
    return name if is_file_name(name) else f"_{name}"


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Opens a binary file that takes its name only when it is complete.

    A file of that name stays until then, and for good if the block raises.
    The folder must exist.

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
        if not error.errno or error.filename not in (str(draft), None):
            raise
        # A full disk has no name, and the user does not know the draft's.
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with suppress(OSError):
            draft.unlink()


def remove_drafts(path: str | Path) -> None:
    """Removes drafts that killed writers of a file have left beside it.

    No process may be writing the file.
    """
    target = Path(path).resolve()
    name = _DRAFT.format(glob.escape(target.name), "*")
    for draft in target.parent.glob(name):
        with suppress(OSError):
            draft.unlink()


def read_gzip_text(path: Path) -> bytes:
    """Returns the text of a file packed by gzip.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not such a file, or its text would take more than
            2 GB of memory when read, twenty times its size. The environment
            variable HUNAV_UNPACKED_GB sets another limit.
    """
    limit = _limit()
    most = limit // _TEXT_FACTOR
    with path.open("rb") as packed:
        try:
            with gzip.open(packed) as file:
                data = file.read(most + 1)
        except (EOFError, OSError, zlib.error) as error:
            raise ValueError(f"cannot be unpacked: {error}") from error
    if len(data) > most:
        raise ValueError(_too_large(limit))
    return data


def read_arrays(path: str | Path, what: str) -> dict[str, NDArray[Any]]:
    """Returns the arrays of a .npz archive by name; pickles are refused.

    Args:
        path: The file.
        what: Its expected content, for errors: "a recording".

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not such an archive, or is damaged, or is larger
            than 2 GB unpacked, and larger than it is packed. The environment
            variable HUNAV_UNPACKED_GB sets another limit. The text begins with
            the path.
    """
    limit = _limit()
    with Path(path).open("rb") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                parts = archive.infolist()
            size = sum(part.file_size for part in parts)
            # (Other kinds of packing could exceed what an archive declares.)
            known = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            if any(part.compress_type not in known for part in parts):
                raise ValueError("it is packed in a way that is not read")
            if size > max(limit, file.seek(0, os.SEEK_END)):
                raise ValueError(_too_large(limit))
            file.seek(0)
            with np.load(file, allow_pickle=False) as arrays:
                return dict(arrays)
        # A damaged archive may fail anywhere in the unpacking.
        except Exception as error:
            raise ValueError(
                f"{path}: is not {what}, or is damaged:"
                f" {str(error) or type(error).__name__:.200}"
            ) from error


def _limit() -> int:
    """Returns the largest number of bytes that may be unpacked at a time."""
    text = os.environ.get(VARIABLE) or str(_USUAL_GB)
    with suppress(ValueError):
        if 0 < float(text) <= 1e6:
            return int(float(text) * 1e9)
    raise ValueError(
        f"{VARIABLE} must be a number of GB in (0, 1000000], got {text!r:.60}"
    )


def _too_large(limit: int) -> str:
    return (
        f"it would take more than {limit / 1e9:g} GB of memory unpacked; if it"
        f" is to be read, set {VARIABLE} to more, in the environment"
    )
