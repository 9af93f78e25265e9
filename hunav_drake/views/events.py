"""What happens in a trial, to jump to it in its replay."""

from collections.abc import Iterator

import numpy as np

from hunav_drake.systems.common.arrays import Mask
from hunav_drake.systems.common.layout import VX, VY
from hunav_drake.systems.evaluation.encounters import ZONES, find_encounters
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.scene.overlays.tags import calm_activities
from hunav_drake.views.replay import Event

# The zones whose entries are told; larger ones are entered all the time.
_TOLD = ("contact", "intimate", "personal")

# A robot stops if it is slower than this, in m/s, for so long, in seconds.
_STOPPED, _LEAST_STOP = 0.05, 1.0


def events_of(recording: Recording) -> list[Event]:
    """Returns contacts, entries to zones, reactions and stops, by their time.

    Reactions are those of people whose behaviors react to robots.
    """
    events = [*_reactions(recording)]
    for robot in recording.robots:
        name = robot.robot_name
        events += _stops(robot, name or "the robot")
        if not recording.num_humans:
            continue
        zones = {zone: ZONES[zone] for zone in _TOLD}
        found = find_encounters(recording, zones, robot=name).events()
        to = f" to {name}" if name else ""
        for row in found[found["kind"] == "entry"].itertuples():
            if row.zone == "contact":
                text, kind = f"contact of {row.person}{to}", "contact"
            else:
                text = f"{row.zone} space of {row.person} entered"
                text, kind = text + (f" by {name}" if name else ""), "entry"
            events.append((text, float(row.time), kind))
    return sorted(events, key=lambda event: event[1])


def _begins(mask: Mask) -> Mask:
    """Returns where rows of a mask begin to be true, not at the first."""
    begins = np.zeros_like(mask)
    begins[1:] = mask[1:] & ~mask[:-1]
    return begins


def _reactions(recording: Recording) -> Iterator[Event]:
    status, signals = recording.behavior_status, recording.social_signals
    if status is None:
        return
    for k, i in np.argwhere(_begins(status != 0)).tolist():
        row = None if signals is None else signals[k]
        if not calm_activities(row, recording.num_humans)[i]:
            name = recording.human_names[i]
            yield f"{name} reacts", float(recording.times[k]), "reaction"


def _stops(robot: Recording, name: str) -> Iterator[Event]:
    times = robot.times
    stands = np.hypot(robot.robot[:, VX], robot.robot[:, VY]) < _STOPPED
    for k in np.flatnonzero(_begins(stands)).tolist():
        moves = np.flatnonzero(~stands[k:])
        # (Not what it does at its goal.)
        if len(moves) and times[k + moves[0]] - times[k] >= _LEAST_STOP:
            yield f"{name} stops", float(times[k]), "stop"
