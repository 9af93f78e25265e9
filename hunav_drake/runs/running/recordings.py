"""The recordings and replays that a suite keeps: one of each cell."""

from pathlib import Path

from hunav_drake.runs.running.run_row import RunRow
from hunav_drake.systems.common.files import file_name_part

FOLDER = "recordings"
REPLAYS = "replays"

# The longest part of a name that is made of other names.
_LONGEST = 160


def recording_path(folder: Path, cell: str, seed: int) -> Path:
    """Returns where the recording of a run is kept."""
    name = file_name_part(cell)[:_LONGEST].lstrip(".-")
    return folder / FOLDER / f"{name}_{seed}.npz"


def replay_path(folder: Path, cell: str, seed: int) -> Path:
    """Returns where the replay of a run is kept."""
    return folder / REPLAYS / f"{recording_path(folder, cell, seed).stem}.html"


def keep_recording(row: RunRow, folder: Path) -> None:
    """Writes the recording of a run.

    Raises:
        OSError: If it cannot be written.
    """
    if row.recording is not None:
        path = recording_path(folder, row.cell, row.seed)
        path.parent.mkdir(parents=True, exist_ok=True)
        row.recording.save(path)
