"""Reads recordings of HuNavSim's messages in JSON."""

from collections.abc import Mapping
import json
import math
from typing import Any

import numpy as np

from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.recording import (
    GOAL_YAW_TOLERANCE,
    Recording,
)

# The required keys of the robot and of each agent.
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

# The keys of an agent that must not change, with their defaults.
_CONSTANT = {"behavior": 1, "group_id": -1}

_SECOND = 10**9


def parse_json(text: str) -> Recording:
    """Makes a recording from messages in JSON: see `ReadRecording`.

    Raises:
        ValueError: If the text is not of that form, with the place.
    """
    try:
        document = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"is not JSON: {error}") from error
    steps, place, goal, radius = _find_steps(document)
    people = _find_people(steps, place)
    settings: dict[str, Any] = {}
    if goal is not None:
        x, y = _numbers(goal, 2, "robot_goal")
        settings["goal"] = (x, y, 0.0)
        if len(goal) > 2:
            settings["goal"] = (x, y, _number(goal[2], "robot_goal"))
            settings["goal_yaw_tolerance"] = GOAL_YAW_TOLERANCE
    if radius is not None:
        settings["goal_tolerance"] = _number(radius, "robot_goal_radius")
    return Recording(
        times=_stamps(steps, place),
        **_bodies(steps, place, list(people)),
        walls_known=False,
        human_ids=tuple(people),
        behaviors=tuple(map(_behavior, people.values())),
        group_ids=tuple(a.get("group_id", -1) for a in people.values()),
        **settings,
    )


def _find_people(steps: list[Any], place: str) -> dict[Any, Mapping[str, Any]]:
    """Returns the first entry of each agent by id; checks all entries."""
    people: dict[Any, Mapping[str, Any]] = {}
    first: dict[Any, str] = {}
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        _check_keys(step, ("sec", "nanosec", "robot", "agents"), where)
        _check_state(step["robot"], f"{where}.robot")
        ids = []
        for i, agent in enumerate(_list(step["agents"], f"{where}.agents")):
            at = f"{where}.agents[{i}]"
            _check_state(agent, at, "id")
            id = agent["id"]
            if id in ids:
                raise ValueError(f"{at}: the id {id} is taken")
            ids.append(id)
            known = people.setdefault(id, agent)
            first.setdefault(id, at)
            for key, default in _CONSTANT.items():
                old, new = known.get(key, default), agent.get(key, default)
                if old != new:
                    raise ValueError(
                        f"{at}.{key}: must not change, but is {shown(new)}"
                        " here and"
                        f" {shown(old)} in {first[id]}"
                    )
    return people


def _find_steps(document: Any) -> tuple[list[Any], str, Any, Any]:
    """Returns the steps, their place, the goal and its radius."""
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
    """Returns the times since the first step, in seconds.

    They are computed in whole nanoseconds, because a float of the time of day
    is less accurate. A repeated stamp is increased by one nanosecond.
    """
    stamps: list[int] = []
    times: list[int] = []
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        second = _number(step["sec"], f"{where}.sec")
        part = _number(step["nanosec"], f"{where}.nanosec")
        whole = math.floor(second)
        stamp = whole * _SECOND + round((second - whole) * _SECOND + part)
        if stamps and stamp < stamps[-1]:
            raise ValueError(
                f"{where}: is at {stamp / _SECOND} s, after a step at"
                f" {stamps[-1] / _SECOND} s"
            )
        stamps.append(stamp)
        times.append(max(stamp, times[-1] + 1) if times else stamp)
    return np.array([(time - times[0]) / _SECOND for time in times])


def _bodies(steps: list[Any], place: str, ids: list[Any]) -> dict[str, Any]:
    """Returns the arrays of a Recording, with people in the order of ids."""
    row = {id: i for i, id in enumerate(ids)}
    samples, n = len(steps), len(ids)
    robot = np.empty((samples, STATE_SIZE))
    humans = np.full((samples, n, STATE_SIZE), np.nan)
    status = np.zeros((samples, n))
    velocities = np.full((samples, 1 + n, 2), np.nan)
    points: dict[tuple[int, int], Array] = {}
    for k, step in enumerate(steps):
        where = f"{place}[{k}]"
        robot[k] = _state(step["robot"], f"{where}.robot")
        velocities[k, 0] = _velocity(step["robot"])
        _add_points(points, (k, 0), step["robot"], f"{where}.robot")
        for a, agent in enumerate(step["agents"]):
            at = f"{where}.agents[{a}]"
            i = row[agent["id"]]
            humans[k, i] = _state(agent, at)
            velocities[k, 1 + i] = _velocity(agent)
            status[k, i] = _number(agent.get("behavior_state", 0), at)
            _add_points(points, (k, 1 + i), agent, at)
    told = any(
        "closest_obs" in body
        for step in steps
        for body in (step["robot"], *step["agents"])
    )
    most = max(map(len, points.values()), default=0)
    walls = np.full((samples, 1 + n, most, 2), np.nan)
    for index, near in points.items():
        walls[index][: len(near)] = near
    return {
        "robot": robot,
        "humans": humans,
        "behavior_status": status,
        "nearest_walls": walls if told else None,
        "told_velocities": velocities,
    }


def _velocity(body: Mapping[str, Any]) -> tuple[float, float]:
    """Returns the velocity of a body that `_state` has read."""
    return float(body["vx"]), float(body["vy"])


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


def _state(body: Mapping[str, Any], place: str) -> list[float]:
    """Returns the row of a robot or a person.

    HuNavSim uses a separate field for the speed, which is rounded to single
    precision, and limited in Gazebo: the velocity gets this length. With a
    speed and no velocity, the direction is the heading.
    """
    x, y, yaw, vx, vy, speed, omega, radius = (
        _number(body[key], f"{place}.{key}") for key in _STATE_KEYS
    )
    if vx == vy == 0:
        along = yaw
    else:
        along = math.atan2(vy, vx)
        speed = abs(speed)
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
    for key in ("id", "group_id"):
        if type(number := body.get(key, -1)) is not int:
            raise ValueError(
                f"{place}.{key}: must be a whole number, got {shown(number)}"
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
    """Returns the first numbers of a list."""
    values = _list(value, place)
    if len(values) < count:
        raise ValueError(f"{place}: needs {count} numbers, got {value!r:.40}")
    return [_number(v, place) for v in values[:count]]


def _number(value: Any, place: str) -> float:
    # JSON files contain texts for numbers that are not finite.
    if not isinstance(value, bool) and isinstance(value, int | float | str):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            number = math.nan
        if math.isfinite(number):
            return number
    raise ValueError(f"{place}: must be a finite number, got {value!r:.40}")
