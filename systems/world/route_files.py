"""Maps of ways on disk, for the next process.

They are in the user's cache folder. HUNAV_CACHE names another folder, and an
empty one switches this off; nothing is lost if the folder is deleted.
"""

from collections.abc import Callable
from contextlib import suppress
import functools
import hashlib
import os
from pathlib import Path

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.files import atomic_write, read_arrays

# The variable with the folder of the files; empty to keep none.
VARIABLE = "HUNAV_CACHE"


def kept(
    key: str, build: Callable[[], tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Returns the arrays on disk for a key, or else builds and writes them.

    A file that is damaged, or cannot be read or written, does no harm.

    Args:
        key: The data from which the map follows, beside the sources of this
            package.
        build: Makes the vertices (m, 2) and ways (e, 3) of a `RouteMap`.
    """
    folder = cache_folder()
    if folder is None:
        return build()
    name = hashlib.sha256(f"{_sources()} {key}".encode()).hexdigest()
    path = folder / f"{name}.npz"
    with suppress(OSError, ValueError, KeyError):
        arrays = read_arrays(path, "a map of ways")
        vertices, ways = arrays["vertices"], arrays["ways"]
        if _fit(vertices, ways):
            return vertices, ways
    vertices, ways = build()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as file:
            np.savez(file, vertices=vertices, ways=ways)
    return vertices, ways


def cache_folder() -> Path | None:
    """Returns the folder of the files; None to keep none."""
    given = os.environ.get(VARIABLE)
    if given is not None:
        return Path(given) / "routes" if given else None
    from platformdirs import user_cache_path

    return user_cache_path("hunav_drake") / "routes"


@functools.cache
def _sources() -> str:
    """Returns a hash of the sources from which a map follows."""
    content = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        content.update(path.read_bytes())
    return content.hexdigest()


def _fit(vertices: Array, ways: Array) -> bool:
    return (
        vertices.dtype == ways.dtype == np.float64
        and vertices.ndim == ways.ndim == 2
        and (vertices.shape[1], ways.shape[1]) == (2, 3)
        and bool(((ways[:, :2] >= 0) & (ways[:, :2] < len(vertices))).all())
    )
