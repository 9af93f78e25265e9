"""Reads all worlds and models of Gazebo below folders, a line for each.

`python -m tests.foreign_files FOLDER...` tells what is loaded, and what is
missing.
"""

from pathlib import Path
import sys
import time

from hunav_drake.systems.common.models.gazebo import is_gazebo_file, read_gazebo
from hunav_drake.systems.world.shapes import Model, World
from hunav_drake.systems.world.solids import WorldFileError


def tell(path: Path) -> str:
    """Returns a line on a file."""
    start = time.perf_counter()
    model = Model(file=str(path), skip_missing=True)
    try:
        obstacles = World(models=[model]).obstacles()
        cut = World(models=[model]).sight_obstacles()
    except WorldFileError as error:
        return f"REFUSED {str(error)[:300]}"
    lost: tuple[str, ...] = ()
    if is_gazebo_file(path):
        lost = read_gazebo(path, (), True).losses
    line = (
        f"loaded  {path.name}: {len(obstacles)} outlines,"
        f" {len(obstacles.segments)} edges, {len(cut.segments)} at eye height,"
        f" {time.perf_counter() - start:.1f} s"
    )
    return f"{line}; {len(lost)} lost, {lost[0][:160]}" if lost else line


def main(folders: list[str]) -> None:
    """Prints a line for each file, and how many are loaded."""
    lines = []
    for folder in folders:
        for path in sorted(Path(folder).rglob("*")):
            if path.suffix in (".world", ".sdf") and path.is_file():
                lines.append(tell(path))
                print(lines[-1], flush=True)
    loaded = sum(line.startswith("loaded") for line in lines)
    print(f"{loaded} of {len(lines)} files are loaded")


if __name__ == "__main__":
    main(sys.argv[1:])
