"""What happened in a trial: the events of its time line, and how it ended."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.scene.overlays.reactions import reactions, stretches
from hunav_drake.trial.result import TrialResult

# At most so many events are told; the shortest ones are left out.
_MOST = 400

# The ends that have a place on the map, in words.
_EARLY = {
    "stuck": "is stuck",
    "timeout": "is out of time",
    "planner_failed": "has no plan, because its planner failed",
}


def events_of(result: TrialResult) -> list[dict[str, Any]]:
    """Returns the events of a trial in the order of time.

    Each has a kind ("contact", "reaction" or "end"), begin and end in seconds,
    and a text.
    """
    run = result.recording
    found = [*_reactions(run), *(it for r in run.robots for it in _contacts(r))]
    found.sort(key=lambda it: it["begin"] - it["end"])
    found = [*found[:_MOST], *_arrivals(result)]
    return sorted(found, key=lambda it: (it["begin"], it["text"]))


def ends_of(result: TrialResult) -> list[dict[str, Any]]:
    """Returns where robots were that did not reach their goals, and why."""
    ends = []
    for robot in result.recording.robots:
        reason = result.robot_ends.get(robot.robot_name, result.end_reason)
        if reason in _EARLY and len(robot):
            x, y = robot.robot[_last(robot), :2].tolist()
            place = [round(x, 3), round(y, 3)]
            message = result.end_message
            if name := robot.robot_name:
                # The message has one part for each robot, in brackets.
                part = f"; {message}; ".partition(f"; {name}: ")[2]
                message = part.partition(" (")[2].partition("); ")[0]
            ends.append(
                {
                    "robot": robot.robot_name,
                    "reason": reason,
                    "message": message,
                    "at": place,
                }
            )
    return ends


def _last(robot: Recording) -> int:
    """Returns the index of the instant at which a robot ended."""
    if robot.end_time is None:
        return -1
    return int(
        np.searchsorted(robot.times, robot.end_time).clip(0, len(robot) - 1)
    )


def _arrivals(result: TrialResult) -> Iterator[dict[str, Any]]:
    for robot in result.recording.robots:
        name = robot.robot_name
        reason = result.robot_ends.get(name, result.end_reason)
        time = robot.end_time
        if time is None:
            time = result.end_time
        words = {"goal": "reaches the goal", **_EARLY}.get(reason)
        if words is not None:
            text = f"{name or 'the robot'} {words}"
            yield _event("end", float(time), float(time), text)


def _reactions(run: Recording) -> Iterator[dict[str, Any]]:
    for i, begin, end in reactions(
        run.times, run.behavior_status, run.social_signals
    ):
        text = f"{run.human_names[i]} ({run.behaviors[i]}) reacts to the robot"
        yield _event("reaction", begin, end, text)


def _contacts(run: Recording) -> Iterator[dict[str, Any]]:
    who = run.robot_name or "the robot"
    if run.contacts is not None:
        for i, name in enumerate(run.human_names):
            touches = run.contacts[:, i, Contact.LASTS] > 0
            for begin, end in stretches(run.times, touches):
                yield _event("contact", begin, end, f"{who} touches {name}")
    if run.wall_contact is not None:
        touches = run.wall_contact[:, Contact.LASTS] > 0
        for begin, end in stretches(run.times, touches):
            yield _event("contact", begin, end, f"{who} touches a wall")


def _event(kind: str, begin: float, end: float, text: str) -> dict[str, Any]:
    return {
        "kind": kind,
        "begin": round(begin, 2),
        "end": round(end, 2),
        "text": text,
    }
