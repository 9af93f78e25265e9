"""The recorded results of the original programs: see data/README.md."""

import gzip
import lzma
import os
from pathlib import Path

import numpy as np

_TESTS = Path(__file__).resolve().parent

# A part of them, which comes with the tests, and all, which may be there.
COMPACT = _TESTS / "data/reference"
FULL = Path(
    os.environ.get("HUNAV_REFERENCE", _TESTS / "../../shared/reference")
).resolve()


def single(value):
    """Rounds as the original does: it keeps these in single precision."""
    return float(np.float32(value))


def recorded_names(kind: str) -> list[str]:
    """Returns the names of all cases of a kind, as "crowd/32_mix6"."""
    names = {
        f"{kind}/{path.name.split('.')[0]}"
        for folder in (COMPACT, FULL)
        for path in (folder / kind).glob("*.json.?z")
    }
    return sorted(names)


def read_recorded(name: str) -> str:
    """Returns the text of a case, in JSON: the full one if it is there."""
    full = FULL / f"{name}.json.gz"
    if full.is_file():
        return gzip.decompress(full.read_bytes()).decode()
    return read_compact(name)


def read_compact(name: str) -> str:
    """Returns the text of a case of the compact set, in JSON."""
    packed = (COMPACT / f"{name}.json.xz").read_bytes()
    return lzma.decompress(packed).decode()
