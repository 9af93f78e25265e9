"""Reads recordings of trials, also of other programs."""

from collections.abc import Callable
from pathlib import Path

from hunav_drake.runs.foreign_formats import (
    RECORDING_PARSERS,
    RECORDING_READERS,
)
from hunav_drake.runs.tidy_csv import parse_csv
from hunav_drake.systems.common.files import read_gzip_text
from hunav_drake.systems.evaluation.recording import Recording


def ReadRecording(
    filename: str | Path, *, people: str = "", robot: str = ""
) -> Recording:
    """Reads a recording from a file; its suffix determines the format.

    - `.npz`: a file of `Recording.save`.
    - `.csv`: a header and a row for each sample of each agent, separated by
      commas, semicolons or tabs. The columns `time` (s), `agent` (a name;
      "robot" is the robot), `x` and `y` (m) are required. If missing, `yaw`
      (rad), `vx`, `vy` (m/s) and `omega` (rad/s) are computed from the
      positions, and `radius` (m) is 0.35. `behavior` (a name), `group_id` (-1
      for none) and `behavior_status` (0 while the person does not react to the
      robot) are optional; the first two are constant. The order of rows does
      not matter, and times within a microsecond are equal. A person without a
      row at a time is absent; the robot must have all rows. Other columns are
      an error, so that misspelled names are found.
    - `.json`: the messages that HuNavSim's evaluator gets at each step: a
      list, or an object with the list under "published", "steps" or "input".
      A step has `sec`, `nanosec`, `robot` and `agents`, each of these with `x,
      y, yaw, vx, vy, linear_vel, angular_vel, radius`, agents also `id`, and
      perhaps `behavior` (1 to 6) and `group_id`, which are constant,
      `behavior_state`, and `closest_obs` (nearest points of walls).
      `robot_goal` (x, y, and perhaps yaw) and `robot_goal_radius` may be in
      the same object as the list. Times start at the first step. A step with
      the time stamp of the previous one is a separate sample, but does not
      count for accelerations.

    - `.mcap`, `.db3`, `.bag`, or a folder: a bag of ROS; see `ReadBag`.
    - The folder of a run: its `recording.npz`.

    `.csv` and `.json` have no walls: `Recording.walls_known` is false.

    `.csv` and `.json` may be compressed with gzip, with `.gz` at the end of
    the name. Files that need more than 2 GB of memory are refused; the
    environment variable HUNAV_UNPACKED_GB sets another limit.

    Args:
        filename: The file.
        people: The topic of people in a bag, if there are several.
        robot: The topic of the robot in a bag, if there are several.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If the file is invalid. The message names the place.
        ImportError: If it is a bag, and rosbags is not installed.
    """
    path = Path(filename)
    if (path / "recording.npz").exists():
        path /= "recording.npz"
    suffixes = [suffix.lower() for suffix in path.suffixes]
    packed = suffixes[-1:] == [".gz"]
    kind = "".join(suffixes[-2:-1] if packed else suffixes[-1:])
    if path.is_dir():
        return RECORDING_READERS[""](path, people, robot)
    if kind and kind in RECORDING_READERS and not packed:
        return RECORDING_READERS[kind](path, people, robot)
    if people or robot:
        raise ValueError(f"{path}: is no bag, and has no topics to choose")
    if kind == ".npz" and not packed:
        return Recording.load(path)
    parsers: dict[str, Callable[[str], Recording]] = {
        ".csv": parse_csv,
        **RECORDING_PARSERS,
    }
    if kind not in parsers:
        raise ValueError(
            f"{path}: is not a recording: its name must end in .npz, .csv,"
            " .json, .csv.gz, .json.gz, .mcap, .db3 or .bag"
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
