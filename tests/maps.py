"""Maps of map_server for tests: written from rows of text."""

from pathlib import Path

import numpy as np
from PIL import Image
import yaml

GRAY = {"#": 0, ".": 254, "?": 205}


def write_map(
    folder: Path,
    rows: list[str] | np.ndarray,
    *,
    name: str = "map",
    **changes: object,
) -> Path:
    """Writes a map; returns the path of its YAML file.

    Args:
        folder: Where.
        rows: The rows from the top as texts, "#" for occupied, "." for free,
            "?" for unknown; or the gray values.
        name: What the files are called.
        changes: Settings that differ.
    """
    if not isinstance(rows, np.ndarray):
        rows = np.array([[GRAY[it] for it in row] for row in rows], np.uint8)
    settings = {
        "image": f"{name}.pgm",
        "resolution": 0.1,
        "origin": [1.0, 2.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.19,
        **changes,
    }
    if settings["image"] == f"{name}.pgm":
        Image.fromarray(rows).save(folder / str(settings["image"]))
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(settings))
    return path
