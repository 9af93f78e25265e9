"""Reads and writes files with recorded people."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.people.tracks import Tracks
from hunav_drake.tracks.formats import (
    FORMATS,
    Options,
    check_homography,
    read_tracks,
)


def ReadTracks(
    filename: str | Path,
    format: str = "auto",
    *,
    fps: float | None = None,
    unit: str | None = None,
    homography: ArrayLike | None = None,
) -> Tracks:
    """Reads the tracks of recorded people from a file.

    - "csv": a table with the columns time (s), id, x, y (m) and perhaps yaw
      (rad).
    - "petrack": PeTrack's and Juelich's text: rows id, frame, x, y, z, with the
      frame rate and the unit in a header of lines that begin with #.
    - "jupedsim": JuPedSim's database (SQLite), with the walkable area.
    - "eth": ETH's `obsmat.txt`: rows frame, id, x, z, y, vx, vz, vy.
    - "ucy": ETH and UCY as text: rows frame, id, x, y.
    - "ucy_vsp": UCY's control points of splines, in pixels of a film.
    - "trajnet": TrajNet++'s lines of JSON; predictions are not read.

    Rows of "eth" and "ucy" are 0.4 s apart, unless `fps` says otherwise.

    Args:
        filename: The file.
        format: One of these, or "auto": its content tells.
        fps: Frames per second, where the file does not say; it takes precedence
            over what the file says.
        unit: "m", "cm" or "mm", in the same way.
        homography: Shape (3, 3), for "ucy_vsp": it takes pixels (x, y, 1) to
            the floor, in meters.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not valid. The message has row, rule and remedy.
    """
    path = Path(filename)
    H = None if homography is None else np.asarray(homography, dtype=float)
    try:
        return read_tracks(path, format, Options(fps, unit, H))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def WriteTracks(
    tracks: Tracks,
    filename: str | Path,
    format: str = "csv",
    *,
    fps: float | None = None,
    homography: ArrayLike | None = None,
) -> None:
    """Writes tracks to a file, which `ReadTracks` reads again.

    Args:
        tracks: The tracks.
        filename: The file, which is overwritten.
        format: See `ReadTracks`.
        fps: Frames per second, for formats with frames; by default, one frame
            per row.
        homography: See `ReadTracks`.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If the format is unknown, or cannot hold the tracks.
    """
    H = None if homography is None else np.asarray(homography, dtype=float)
    check_choice("format", format, FORMATS)
    check_homography(format, H)
    if not tracks.people:
        raise ValueError(f"{filename}: there are no tracks to write")
    content = FORMATS[format].write(tracks, Options(fps, None, H))
    with atomic_write(filename) as file:
        file.write(content)
