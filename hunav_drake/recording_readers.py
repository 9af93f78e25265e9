"""Reads recordings of trials, from here or from elsewhere."""

from collections.abc import Callable, Mapping
import gzip
import json
import math
from pathlib import Path
from typing import Any
import zlib

import numpy as np
from numpy.typing import NDArray

from hunav_drake.hunav_yaml import BEHAVIOR_NAMES
from hunav_drake.recording_csv import parse_csv
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.layout import STATE_SIZE

Array = NDArray[np.float64]

# What every entry of the robot or an agent has.
_STATE_KEYS = (
    "x",
    "y",
    "yaw",
    "vx",
    "vy",
    "linear_vel",
    "angular_vel",
    "radius",
)

# A stamp that is repeated is moved on by this, in seconds.
_NEXT_INSTANT = 1e-9


def ReadRecording(filename: str | Path) -> Recording:
    """Reads a recording from a file, whose kind its name tells.

    - `.npz`: what `Recording.save` writes.
    - `.csv`: a row for each sample of each body, with a header. The columns
      `time` (s), `agent` (a name; "robot" is the robot), `x` and `y` (m) are
      needed. `yaw` (rad), `vx`, `vy` (m/s) and `omega` (rad/s) are worked out
      from the positions where a column is missing, `radius` (m) is 0.35 then.
      `behavior` (a name), `group_id` (-1 for none) and `behavior_status` (0
      while someone does not react to the robot) are optional. The order of
      rows does not matter; who has no row at a time is missing then, but the
      robot must not be. Other columns are an error, lest a misspelled one go
      unseen.
    - `.json`: the messages that HuNavSim's evaluator gets, step by step: a
      list, or an object with the list under "published", "steps" or "input".
      A step has `sec`, `nanosec`, `robot` and `agents`, each of whom `x, y,
      yaw, vx, vy, linear_vel, angular_vel, radius`, agents also `id`, and
      perhaps `behavior` (1 to 6), `behavior_state`, `group_id` and
      `closest_obs` (nearest points of walls). `robot_goal` and
      `robot_goal_radius` may stand beside the list.

    Each may be packed by gzip, with `.gz` at the end of its name, but for
    `.npz`, which is packed.

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
        ".json": _parse_json,
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
    data = path.read_bytes()
    if packed:
        try:
            data = gzip.decompress(data)
        except (EOFError, OSError, zlib.error) as error:
            raise ValueError(f"cannot be unpacked: {error}") from error
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not a text in UTF-8: {error}") from error


def _parse_json(text: str) -> Recording:
    try:
        document = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"is not JSON: {error}") from error
    steps, place, goal, radius = _find_steps(document)
    people: dict[Any, Mapping[str, Any]] = {}
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        _check_keys(step, ("sec", "nanosec", "robot", "agents"), where)
        _check_state(step["robot"], f"{where}.robot")
        ids = []
        for i, agent in enumerate(_list(step["agents"], f"{where}.agents")):
            _check_state(agent, f"{where}.agents[{i}]", "id")
            if agent["id"] in ids:
                raise ValueError(
                    f"{where}.agents[{i}]: the id {agent['id']} is taken"
                )
            ids.append(agent["id"])
            people.setdefault(agent["id"], agent)
    settings: dict[str, Any] = {}
    if goal is not None:
        settings["goal"] = (*_numbers(goal, 2, "robot_goal"), 0.0)
    if radius is not None:
        settings["goal_tolerance"] = _number(radius, "robot_goal_radius")
    return Recording(
        times=_stamps(steps, place),
        **_bodies(steps, place, list(people)),
        human_ids=tuple(people),
        behaviors=tuple(map(_behavior, people.values())),
        group_ids=tuple(a.get("group_id", -1) for a in people.values()),
        **settings,
    )


def _find_steps(document: Any) -> tuple[list[Any], str, Any, Any]:
    """Returns the steps, where they are, and the goal and its radius."""
    place = "steps"
    steps = document
    holders: list[dict[str, Any]] = []
    if isinstance(document, dict):
        for holder in (document, *map(document.get, ("input", "expected"))):
            if isinstance(holder, dict):
                holders.append(holder)
        for key in ("published", "steps", "input"):
            if key in document:
                place, steps = key, document[key]
                break
        else:
            raise ValueError(
                "is not a recording: it needs a list of steps, or one under"
                ' "published", "steps" or "input"'
            )
        if isinstance(steps, dict):
            _check_keys(steps, ("steps",), place)
            place, steps = f"{place}.steps", steps["steps"]
    if not _list(steps, place):
        raise ValueError(f"{place}: needs at least one step")

    def find(key: str) -> Any:
        return next((h[key] for h in holders if h.get(key) is not None), None)

    return steps, place, find("robot_goal"), find("robot_goal_radius")


def _stamps(steps: list[Any], place: str) -> Array:
    times: list[float] = []
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        second = _number(step["sec"], f"{where}.sec")
        time = second + 1e-9 * _number(step["nanosec"], f"{where}.nanosec")
        if times and time < times[-1] - _NEXT_INSTANT * len(times):
            raise ValueError(
                f"{where}: is at {time} s, after a step at {times[-1]} s"
            )
        times.append(max(time, times[-1] + _NEXT_INSTANT) if times else time)
    return np.array(times)


def _bodies(steps: list[Any], place: str, ids: list[Any]) -> dict[str, Any]:
    """Returns the arrays of a Recording, rows of people in the order of ids."""
    row = {id: i for i, id in enumerate(ids)}
    samples, n = len(steps), len(ids)
    robot = np.empty((samples, STATE_SIZE))
    humans = np.full((samples, n, STATE_SIZE), np.nan)
    status = np.zeros((samples, n))
    points: dict[tuple[int, int], Array] = {}
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        robot[k] = _state(step["robot"], f"{where}.robot", forward=True)
        _add_points(points, (k, 0), step["robot"], f"{where}.robot")
        for a, agent in enumerate(step["agents"]):
            at = f"{where}.agents[{a}]"
            i = row[agent["id"]]
            humans[k, i] = _state(agent, at)
            status[k, i] = _number(agent.get("behavior_state", 0), at)
            _add_points(points, (k, 1 + i), agent, at)
    most = max(map(len, points.values()), default=0)
    walls = np.full((samples, 1 + n, most, 2), np.nan)
    for index, near in points.items():
        walls[index][: len(near)] = near
    return {
        "robot": robot,
        "humans": humans,
        "behavior_status": status,
        "nearest_walls": walls,
    }


def _add_points(
    points: dict[tuple[int, int], Array],
    index: tuple[int, int],
    body: Mapping[str, Any],
    place: str,
) -> None:
    near = _list(body.get("closest_obs", []), f"{place}.closest_obs")
    if near:
        points[index] = np.array(
            [_numbers(p, 2, f"{place}.closest_obs") for p in near]
        )


def _state(
    body: Mapping[str, Any], place: str, *, forward: bool = False
) -> list[float]:
    """Returns the row of a robot or a person.

    HuNavSim takes speeds from a field of their own, which is rounded to single
    precision: the velocity gets that length. That of the robot is along its
    heading.
    """
    x, y, yaw, vx, vy, speed, omega, radius = (
        _number(body[key], f"{place}.{key}") for key in _STATE_KEYS
    )
    along = yaw if forward or vx == vy == 0 else math.atan2(vy, vx)
    return [
        *(x, y, yaw, speed * math.cos(along), speed * math.sin(along)),
        *(omega, radius),
    ]


def _behavior(agent: Mapping[str, Any]) -> str:
    behavior = agent.get("behavior", 1)
    name = BEHAVIOR_NAMES.get(behavior) if type(behavior) is int else None
    return name or str(behavior)


def _check_state(body: Any, place: str, *more: str) -> None:
    _check_keys(body, (*_STATE_KEYS, *more), place)
    if type(body.get("id", 0)) is not int:
        raise ValueError(
            f"{place}.id: must be a whole number, got {body['id']!r}"
        )
    if type(body.get("group_id", -1)) is not int:
        raise ValueError(
            f"{place}.group_id: must be a whole number, got"
            f" {body['group_id']!r}"
        )


def _check_keys(value: Any, keys: tuple[str, ...], place: str) -> None:
    if not isinstance(value, dict):
        raise ValueError(f"{place}: must be an object, got {value!r:.40}")
    for key in keys:
        if key not in value:
            raise ValueError(f"{place}: has no {key!r}")


def _list(value: Any, place: str) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError(f"{place}: must be a list, got {value!r:.40}")
    return value


def _numbers(value: Any, count: int, place: str) -> list[float]:
    values = _list(value, place)
    if len(values) < count:
        raise ValueError(f"{place}: needs {count} numbers, got {value!r:.40}")
    return [_number(v, place) for v in values[:count]]


def _number(value: Any, place: str) -> float:
    # What is not finite is written as "nan" or "inf" in JSON.
    if not isinstance(value, bool) and isinstance(value, int | float | str):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            number = math.nan
        if math.isfinite(number):
            return number
    raise ValueError(f"{place}: must be a finite number, got {value!r:.40}")
