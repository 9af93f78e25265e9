"""Reads recordings of trials, from here or from elsewhere."""

from collections.abc import Callable
from pathlib import Path

from hunav_drake.runs.foreign_formats import RECORDING_PARSERS
from hunav_drake.runs.tidy_csv import parse_csv
from hunav_drake.systems.common.files import read_gzip_text
from hunav_drake.systems.evaluation.recording import Recording


def ReadRecording(filename: str | Path) -> Recording:
    """Reads a recording from a file, whose kind its name tells.

    - `.npz`: what `Recording.save` writes.
    - `.csv`: a row for each sample of each body, with a header; commas,
      semicolons or tabs between the cells. The columns `time` (s), `agent` (a
      name; "robot" is the robot), `x` and `y` (m) are needed. `yaw` (rad),
      `vx`, `vy` (m/s) and `omega` (rad/s) are worked out from the positions
      where a column is missing, `radius` (m) is 0.35 then. `behavior` (a
      name), `group_id` (-1 for none) and `behavior_status` (0 while someone
      does not react to the robot) are optional; the first two do not change.
      The order of rows does not matter, and times within a microsecond are
      one. Who has no row at a time is missing then, but the robot must not
      be. Other columns are an error, lest a misspelled one go unseen.
    - `.json`: the messages that HuNavSim's evaluator gets, step by step: a
      list, or an object with the list under "published", "steps" or "input".
      A step has `sec`, `nanosec`, `robot` and `agents`, each of whom `x, y,
      yaw, vx, vy, linear_vel, angular_vel, radius`, agents also `id`, and
      perhaps `behavior` (1 to 6) and `group_id`, which do not change,
      `behavior_state`, and `closest_obs` (nearest points of walls).
      `robot_goal` (x, y, and perhaps yaw) and `robot_goal_radius` may stand
      beside the list. Times count from the first step. A step with the stamp
      of the one before is a sample of its own, but tells nothing of
      accelerations.

    The last two do not tell the walls: `Recording.walls_known` is false.

    Each may be packed by gzip, with `.gz` at the end of its name, but for
    `.npz`, which is packed. What takes more than 2 GB of memory unpacked is
    refused; HUNAV_UNPACKED_GB, in the environment, sets another limit.

    Args:
        filename: The file.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not such a file. The text names the place.
    """
    path = Path(filename)
    suffixes = [suffix.lower() for suffix in path.suffixes]
    packed = suffixes[-1:] == [".gz"]
    kind = "".join(suffixes[-2:-1] if packed else suffixes[-1:])
    if kind == ".npz" and not packed:
        return Recording.load(path)
    parsers: dict[str, Callable[[str], Recording]] = {
        ".csv": parse_csv,
        **RECORDING_PARSERS,
    }
    if kind not in parsers:
        raise ValueError(
            f"{path}: is not a recording: its name must end in .npz, .csv,"
            " .json, .csv.gz or .json.gz"
        )
    try:
        return parsers[kind](_read_text(path, packed=packed))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _read_text(path: Path, *, packed: bool) -> str:
    data = read_gzip_text(path) if packed else path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not a text in UTF-8: {error}") from error
