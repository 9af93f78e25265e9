"""The formats of files with recorded people.

Each reader turns a file into the rows of a table; `read_tracks` checks them and
makes the tracks. Each writer is its reverse.
"""

from collections.abc import Callable, Iterator, Sequence
import contextlib
import csv
import io
import json
import math
from pathlib import Path
import re
import sqlite3
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.people.tracks import Tracks, motion_at

# Files with rows every 0.4 s, which name no rate.
_PERIOD = 0.4
# The frames per second of films whose rows name only frames.
_FILM = 25.0
# Farther away, in meters, nobody walks: maps (UTM) have so large coordinates.
_FARTHEST = 1e7
# Times are within that many seconds of 0.
_LATEST = 1e9

_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_RATE = re.compile(r"frame[ _-]*rate\D*?([\d.]+)", re.IGNORECASE)
_UNIT = re.compile(r"\bx\s*[/\[(]\s*(?:in\s+)?(mm|cm|m)\b", re.IGNORECASE)
_COUNT = re.compile(
    r"\s*(\d+)\s*-\s*(the number of splines|num of control)", re.I
)


class Options(NamedTuple):
    """What a file may leave open.

    Attributes:
        fps: Frames per second, if the file does not say, or says it wrongly.
        unit: The unit of its positions: "m", "cm" or "mm".
        homography: Shape (3, 3): it takes pixels (x, y, 1) to the floor.
    """

    fps: float | None = None
    unit: str | None = None
    homography: Array | None = None


class Rows(NamedTuple):
    """The rows of a file: a person at a time.

    Attributes:
        lines: The line of each, or its number, from 1.
        ids: Shape (n,), the numbers of the persons.
        times: Shape (n,), in seconds.
        positions: Shape (n, 2), in meters.
        yaws: Shape (n,), in radians, if the file has them.
        walls: See `Tracks`.
    """

    lines: NDArray[np.int64]
    ids: Array
    times: Array
    positions: Array
    yaws: Array | None = None
    walls: tuple[Array, ...] = ()


class Format(NamedTuple):
    """A format of files.

    Attributes:
        ending: The usual ending of its files.
        doc: What it is, in one line.
        read: Reads a file.
        write: Returns tracks as the content of a file.
    """

    ending: str
    doc: str
    read: Callable[[Path, Options], Rows]
    write: Callable[[Tracks, Options], bytes]


def read_tracks(path: Path, name: str, options: Options) -> Tracks:
    """Reads a file: see `ReadTracks`."""
    check_choice("format", name, ["auto", *FORMATS])
    if options.fps is not None and not (0 < options.fps < 1e6):
        raise ValueError(
            "fps: must be a number of frames per second in (0, 1e6), got"
            f" {options.fps}"
        )
    if options.unit is not None and options.unit not in _UNITS:
        raise ValueError(
            f"unit: must be m, cm or mm, got {shown(options.unit)}"
        )
    name = find_format(path) if name == "auto" else name
    if name == "csv" and options.fps is not None:
        raise ValueError(
            "fps has no part in csv, whose rows have times; leave it out"
        )
    check_homography(name, options.homography)
    rows = FORMATS[name].read(path, options)
    if not len(rows.ids):
        raise ValueError("has no rows")
    scale = _UNITS[options.unit or "m"]
    positions = rows.positions * scale
    for what, wrong, rule in (
        (
            "person",
            ~((rows.ids == np.round(rows.ids)) & (np.abs(rows.ids) < 2.0**53)),
            "must be a whole number below 2^53",
        ),
        (
            "time",
            ~(np.abs(rows.times) <= _LATEST),
            f"must be a number of seconds up to {_LATEST:g}",
        ),
        (
            "position",
            ~(np.abs(positions) <= _FARTHEST).all(axis=1),
            f"must be within {_FARTHEST:g} m of the origin",
        ),
    ):
        if wrong.any():
            k = int(np.argmax(wrong))
            got = {
                "person": rows.ids[k],
                "time": rows.times[k],
                "position": tuple(positions[k].tolist()),
            }[what]
            raise ValueError(
                f"row {rows.lines[k]}: the {what} {rule}, got {got}; correct"
                " or delete the row"
            )
    keys = np.column_stack([rows.ids, rows.times])
    _, first, counts = np.unique(
        keys, axis=0, return_index=True, return_counts=True
    )
    if (counts > 1).any():
        key = keys[first[np.argmax(counts > 1)]]
        same = rows.lines[(keys == key).all(axis=1)]
        raise ValueError(
            f"row {same[1]}: person {key[0]:g} is at {key[1]:g} s in row"
            f" {same[0]}, too; delete one of them"
        )
    return Tracks.from_rows(
        rows.ids.astype(int),
        rows.times,
        positions,
        rows.yaws,
        [wall * scale for wall in rows.walls],
    )


def find_format(path: Path) -> str:
    """Returns the name of a file's format, from what is in it.

    Raises:
        ValueError: If it is none of them.
    """
    with path.open("rb") as file:
        begin = file.read(4096)
    if begin.startswith(b"SQLite format 3"):
        return "jupedsim"
    text = begin.decode("utf-8-sig", errors="replace")
    if text.lstrip().startswith("{"):
        return "trajnet"
    if "number of splines" in text:
        return "ucy_vsp"
    first = next((line for _, line in _rows_of(text)), "")
    if not text.strip():
        raise ValueError("has no rows")
    if text.lstrip().startswith("#") and _RATE.search(text):
        return "petrack"
    if re.search(r"\btime\b", first) and re.search(r"[,;\t]", first):
        return "csv"
    found = {8: "eth", 5: "petrack", 4: "ucy"}.get(len(first.split()))
    if found is None:
        raise ValueError(
            f"is of no known format: its first row is {shown(first)}; name one"
            f" of {', '.join(FORMATS)}"
        )
    return found


def _text_of(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not a text in UTF-8: {error}") from error


def _table(
    lines: Sequence[tuple[int, str]],
    names: Sequence[str],
    *,
    more: bool = False,
) -> tuple[NDArray[np.int64], Array]:
    """Returns the numbers of lines, and their rows of numbers.

    Raises:
        ValueError: If a row has not as many numbers as names, or more.
    """
    count, rows = len(names), []
    for number, line in lines:
        words = line.split()
        try:
            if len(words) < count or (len(words) > count and not more):
                raise ValueError
            rows.append([float(word) for word in words[:count]])
        except ValueError:
            raise ValueError(
                f"row {number}: must be {count} numbers ({', '.join(names)}),"
                f" got {shown(line.strip())}; correct or delete it"
            ) from None
    numbers = np.array([number for number, _ in lines], dtype=np.int64)
    return numbers, np.array(rows).reshape(-1, count)


def _rows_of(text: str, comment: str = "#") -> list[tuple[int, str]]:
    return [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(comment)
    ]


def _read_petrack(path: Path, options: Options) -> Rows:
    text = _text_of(path)
    header = "\n".join(
        line for line in text.splitlines() if line.lstrip().startswith("#")
    )
    rate, unit = _RATE.search(header), _UNIT.search(header)
    fps = options.fps or (_rate_of(rate[1]) if rate else None)
    if fps is None:
        raise ValueError(
            "names no frame rate in its header (# framerate: 25); give fps"
        )
    if unit is None and options.unit is None:
        raise ValueError(
            "names no unit in its header (# id frame x/m y/m z/m); give unit"
        )
    names = ["person", "frame", "x", "y"]
    lines, table = _table(_rows_of(text), names, more=True)
    scale = 1.0
    if options.unit is None and unit is not None:
        scale = _UNITS[unit[1].lower()]
    return Rows(lines, table[:, 0], table[:, 1] / fps, scale * table[:, 2:4])


def _write_petrack(tracks: Tracks, options: Options) -> bytes:
    fps = _fps_of(tracks, options)
    lines = [f"# framerate: {fps!r}", "# id frame x/m y/m z/m"]
    lines += [
        f"{id} {frame} {x!r} {y!r} 0.0"
        for id, frame, x, y in _frames(tracks, 1 / fps)
    ]
    return ("\n".join(lines) + "\n").encode()


def _frames(
    tracks: Tracks, period: float
) -> Iterator[tuple[int, int, float, float]]:
    """Yields rows (person, frame, x, y) of tracks at multiples of a period.

    Raises:
        ValueError: If a time is no such multiple.
    """
    for it in tracks.people:
        frames = np.round(it.times / period)
        off = np.abs(it.times - frames * period) > 1e-6
        if off.any():
            raise ValueError(
                f"person {it.id} has a row at {it.times[np.argmax(off)]:g} s,"
                f" which is no multiple of {period:g} s; resample the tracks"
                f" at {period:g} s"
            )
        for frame, (x, y) in zip(frames, it.positions.tolist(), strict=True):
            yield it.id, int(frame), x, y


def _frame_times(frames: Array, options: Options) -> Array:
    """Returns the times of frames; by default, rows are 0.4 s apart."""
    return frames / (options.fps or _usual_step(frames) / _PERIOD)


def _usual_step(frames: Array) -> float:
    """Returns the most common distance of frames; 1 for a single one."""
    values, counts = np.unique(np.diff(np.unique(frames)), return_counts=True)
    return float(values[np.argmax(counts)]) if len(values) else 1.0


def _least_step(frames: Array) -> float:
    """Returns the least distance of frames; 1 for a single one."""
    steps = np.diff(np.unique(frames))
    return float(steps.min()) if len(steps) else 1.0


def _check_period(tracks: Tracks) -> None:
    """Raises a ValueError if rows are usually not 0.4 s apart."""
    frames = [frame for _, frame, _, _ in _frames(tracks, _PERIOD)]
    period = _usual_step(np.array(frames)) * _PERIOD
    if period > 1.5 * _PERIOD:
        raise ValueError(
            f"rows are {period:g} s apart, and would be read as {_PERIOD:g} s;"
            f" resample the tracks at {_PERIOD:g} s"
        )


def _rate_of(text: str) -> float:
    """Returns a rate in frames per second.

    Raises:
        ValueError: If it is no positive number.
    """
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0 < rate < 1e6:
        raise ValueError(
            f"has the frame rate {shown(text)}, which must be a number of"
            " frames per second in (0, 1e6); correct it, or give fps"
        )
    return rate


def _fps_of(tracks: Tracks, options: Options) -> float:
    """Returns the frames per second to write, by default one per row."""
    if options.fps:
        return options.fps
    if math.isnan(tracks.period):
        raise ValueError("nobody has two rows, so there is no rate; give fps")
    return float(f"{1 / tracks.period:.10g}")


def _read_eth(path: Path, options: Options) -> Rows:
    names = ["frame", "person", "x", "z", "y", "vx", "vz", "vy"]
    lines, table = _table(_rows_of(_text_of(path)), names)
    times = _frame_times(table[:, 0], options)
    return Rows(lines, table[:, 1], times, table[:, [2, 4]])


def _write_eth(tracks: Tracks, options: Options) -> bytes:
    _check_period(tracks)
    lines = []
    for it in tracks.people:
        velocities = motion_at(it, it.times).velocities.tolist()
        one = Tracks((it,))
        for (id, frame, x, y), (vx, vy) in zip(
            _frames(one, _PERIOD), velocities, strict=True
        ):
            numbers = (10.0 * frame, id, x, 0.0, y, vx, 0.0, vy)
            lines.append(" ".join(map(repr, numbers)))
    return ("\n".join(lines) + "\n").encode()


def _read_ucy(path: Path, options: Options) -> Rows:
    names = ["frame", "person", "x", "y"]
    lines, table = _table(_rows_of(_text_of(path)), names)
    times = _frame_times(table[:, 0], options)
    return Rows(lines, table[:, 1], times, table[:, 2:])


def _write_ucy(tracks: Tracks, options: Options) -> bytes:
    _check_period(tracks)
    rows = sorted(_frames(tracks, _PERIOD), key=lambda row: (row[1], row[0]))
    lines = [f"{10 * f}\t{id}\t{x!r}\t{y!r}\n" for id, f, x, y in rows]
    return "".join(lines).encode()


def check_homography(name: str, homography: Array | None) -> None:
    """Raises ValueError if a format with meters is given a homography."""
    if name != "ucy_vsp" and homography is not None:
        raise ValueError(
            f"homography is for pixels, as of ucy_vsp; {name} has meters; leave"
            " it out"
        )


def _homography(options: Options) -> Array:
    if options.homography is None:
        raise ValueError(
            "has positions in pixels of a film; give homography, the 3 x 3"
            " matrix that takes them to the floor in meters"
        )
    H = np.asarray(options.homography, dtype=float)
    if H.shape != (3, 3) or not np.isfinite(H).all() or not np.linalg.det(H):
        raise ValueError(
            "homography: must be 3 x 3 finite numbers that can be inverted, got"
            f" shape {H.shape}"
        )
    return H


def _projected(H: Array, points: Array) -> Array:
    result = np.column_stack([points, np.ones(len(points))]) @ H.T
    projected: Array = result[:, :2] / result[:, 2:]
    return projected


def _read_ucy_vsp(path: Path, options: Options) -> Rows:
    H = _homography(options)
    fps = options.fps or _FILM
    rows, ids, left, person = [], [], 0, 0
    for number, line in _rows_of(_text_of(path)):
        counted = _COUNT.match(line)
        if counted and "control" in counted[2].lower():
            if left:
                raise ValueError(
                    f"row {number}: person {person} lacks {left} control"
                    " points; correct the number above them"
                )
            left, person = int(counted[1]), person + 1
        elif left:
            left -= 1
            rows.append((number, line.partition(" - ")[0]))
            ids.append(person)
        elif counted is None and "number of splines" not in line:
            # (What follows the paths, as their gaze, is not read.)
            break
    if left:
        raise ValueError(
            f"ends before the last {left} control points of person {person}; it"
            " is cut off: take a whole file"
        )
    lines, table = _table(rows, ["x", "y", "frame"], more=True)
    positions = _projected(H, table[:, :2])
    return Rows(lines, np.array(ids), table[:, 2] / fps, positions)


def _write_ucy_vsp(tracks: Tracks, options: Options) -> bytes:
    H = np.linalg.inv(_homography(options))
    fps = options.fps or _FILM
    lines = [f"{len(tracks.people)} - the number of splines"]
    for it in tracks.people:
        points = _projected(H, it.positions).tolist()
        lines.append(f"{len(points)} - Num of control points")
        lines += [
            f"{x!r} {y!r} {t * fps!r} 0.0 - (2D point, m_id)"
            for (x, y), t in zip(points, it.times.tolist(), strict=True)
        ]
    return ("\n".join(lines) + "\n").encode()


def _read_trajnet(path: Path, options: Options) -> Rows:
    rows, lines, rates = [], [], []
    for number, line in _rows_of(_text_of(path)):
        try:
            data = json.loads(line)
            if "track" in data:
                it = data["track"]
                # (Predictions are no recordings.)
                if it.get("prediction_number") in (None, -1):
                    rows.append([float(it[key]) for key in "fpxy"])
                    lines.append(number)
            elif "scene" in data:
                rates.append(float(data["scene"].get("fps") or 0.0))
            else:
                raise KeyError
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ValueError(
                f'row {number}: must be {{"track": {{"f": 0, "p": 1, "x": 0.5,'
                f' "y": 0.5}}}} or a scene, got {shown(line.strip())}; correct'
                " or delete it"
            ) from None
    table = np.array(rows).reshape(-1, 4)
    if options.fps is None and rates and rates[0] > 0:
        # Its rate is that of rows: frames may count by more than one.
        fps = rates[0] * _least_step(table[:, 0])
        options = options._replace(fps=fps)
    times = _frame_times(table[:, 0], options)
    return Rows(
        np.array(lines, dtype=np.int64), table[:, 1], times, table[:, 2:]
    )


def _write_trajnet(tracks: Tracks, options: Options) -> bytes:
    fps = _fps_of(tracks, options)
    rows = sorted(_frames(tracks, 1 / fps), key=lambda row: (row[1], row[0]))
    scene = {"id": 0, "p": rows[0][0], "s": rows[0][1], "e": rows[-1][1]}
    rate = fps / _least_step(np.array([frame for _, frame, _, _ in rows]))
    lines: list[Any] = [{"scene": {**scene, "fps": rate}}]
    lines += [
        {"track": {"f": f, "p": p, "x": x, "y": y}} for p, f, x, y in rows
    ]
    return "".join(json.dumps(line) + "\n" for line in lines).encode()


def _read_jupedsim(path: Path, options: Options) -> Rows:
    file = f"{path.resolve().as_uri()}?mode=ro"
    try:
        with contextlib.closing(sqlite3.connect(file, uri=True)) as database:
            told = dict(database.execute("SELECT key, value FROM metadata"))
            table = database.execute(
                "SELECT frame, id, pos_x, pos_y FROM trajectory_data"
            ).fetchall()
            walls = database.execute("SELECT wkt FROM geometry").fetchall()
    except sqlite3.Error as error:
        raise ValueError(
            f"is not a database of JuPedSim that can be read: {error}; it has"
            " the tables metadata, trajectory_data and geometry"
        ) from error
    if not options.fps and "fps" not in told:
        raise ValueError("names no fps in its metadata; give fps")
    fps = options.fps or _rate_of(str(told["fps"]))
    try:
        rows = np.array(table, dtype=float).reshape(-1, 4)
    except (TypeError, ValueError) as error:
        raise ValueError(
            "has a row of trajectory_data that is not numbers; delete it"
        ) from error
    return Rows(
        np.arange(1, len(rows) + 1, dtype=np.int64),
        rows[:, 1],
        rows[:, 0] / fps,
        rows[:, 2:],
        walls=tuple(ring for (text,) in walls for ring in _rings(str(text))),
    )


def _rings(text: str) -> Iterator[Array]:
    """Yields the outlines of a geometry in WKT."""
    import shapely

    try:
        geometry = shapely.from_wkt(text)
    except shapely.errors.GEOSException as error:
        raise ValueError(f"has a geometry that is not WKT: {error}") from error
    # (A collection may have areas of several parts.)
    for part in shapely.get_parts(shapely.get_parts(geometry)):
        if part.geom_type == "Polygon":
            for ring in (part.exterior, *part.interiors):
                yield np.array(ring.coords)[:, :2]


def _write_jupedsim(tracks: Tracks, options: Options) -> bytes:
    import shapely

    fps = _fps_of(tracks, options)
    rows = [(f, id, x, y, 0.0, 0.0) for id, f, x, y in _frames(tracks, 1 / fps)]
    area = shapely.MultiPolygon([shapely.Polygon(it) for it in tracks.walls])
    with contextlib.closing(sqlite3.connect(":memory:")) as database:
        database.executescript(
            "CREATE TABLE metadata(key TEXT NOT NULL UNIQUE, value TEXT);"
            "CREATE TABLE geometry(hash INTEGER NOT NULL, wkt TEXT);"
            "CREATE TABLE trajectory_data(frame INTEGER, id INTEGER,"
            " pos_x REAL, pos_y REAL, ori_x REAL, ori_y REAL);"
        )
        database.executemany(
            "INSERT INTO metadata VALUES (?, ?)",
            [("version", "2"), ("fps", repr(fps))],
        )
        database.execute("INSERT INTO geometry VALUES (0, ?)", [area.wkt])
        database.executemany(
            "INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)", rows
        )
        database.commit()
        return database.serialize()


_COLUMNS = ("time", "id", "x", "y")


def _read_csv(path: Path, options: Options) -> Rows:
    text = _text_of(path)
    header = next(iter(text.splitlines()), "")
    separator = max(",;\t", key=header.count)
    reader = csv.reader(io.StringIO(text), delimiter=separator)
    names = [name.strip() for name in next(reader, [])]
    if sorted(names) not in (sorted(_COLUMNS), sorted((*_COLUMNS, "yaw"))):
        raise ValueError(
            "row 1: must name the columns time, id, x, y and, if known, yaw,"
            f" got {shown(header)}"
        )
    lines, rows = [], []
    for row in reader:
        if not row:
            continue
        try:
            rows.append([float(cell) for cell in row])
            if len(row) != len(names):
                raise ValueError
        except ValueError:
            raise ValueError(
                f"row {reader.line_num}: must be {len(names)} numbers"
                f" ({', '.join(names)}), got {shown(separator.join(row))};"
                " correct or delete it"
            ) from None
        lines.append(reader.line_num)
    table = np.array(rows).reshape(-1, len(names))
    column = {name: table[:, k] for k, name in enumerate(names)}
    return Rows(
        np.array(lines, dtype=np.int64),
        column["id"],
        column["time"],
        np.column_stack([column["x"], column["y"]]),
        column.get("yaw"),
    )


def _write_csv(tracks: Tracks, options: Options) -> bytes:
    has_yaws = all(it.yaws is not None for it in tracks.people)
    rows = []
    for it in tracks.people:
        columns = [it.times, it.positions[:, 0], it.positions[:, 1]]
        columns += [it.yaws] if has_yaws and it.yaws is not None else []
        for time, *others in np.column_stack(columns).tolist():
            rows.append((time, it.id, *others))
    names = (*_COLUMNS, *(["yaw"] if has_yaws else []))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([names, *sorted(rows)])
    return text.getvalue().encode()


FORMATS: dict[str, Format] = {
    "csv": Format(
        ".csv",
        "A table with the columns time (s), id, x, y (m) and perhaps yaw (rad)",
        _read_csv,
        _write_csv,
    ),
    "petrack": Format(
        ".txt",
        "PeTrack and Juelich: rows id, frame, x, y, z, and a header",
        _read_petrack,
        _write_petrack,
    ),
    "jupedsim": Format(
        ".sqlite",
        "JuPedSim: a database with the walkable area",
        _read_jupedsim,
        _write_jupedsim,
    ),
    "eth": Format(
        ".txt",
        "ETH's obsmat: rows frame, id, x, z, y, vx, vz, vy, every 0.4 s",
        _read_eth,
        _write_eth,
    ),
    "ucy": Format(
        ".txt",
        "ETH and UCY as text: rows frame, id, x, y, every 0.4 s",
        _read_ucy,
        _write_ucy,
    ),
    "ucy_vsp": Format(
        ".vsp",
        "UCY's splines of pixels, with a homography",
        _read_ucy_vsp,
        _write_ucy_vsp,
    ),
    "trajnet": Format(
        ".ndjson",
        "TrajNet++: a line of JSON per person and frame",
        _read_trajnet,
        _write_trajnet,
    ),
}
