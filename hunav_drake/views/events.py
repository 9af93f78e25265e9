"""What happens in a trial, to jump to it in its replay."""

from collections.abc import Iterator

import numpy as np

from hunav_drake.systems.common.layout import VX, VY
from hunav_drake.systems.evaluation.encounters import ZONES, find_encounters
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.scene.overlays.reactions import reactions, stretches
from hunav_drake.views.replay import Event

# The zones whose entries are told; larger ones are entered all the time.
_TOLD = ("contact", "intimate", "personal")

# A robot stops if it is slower than this, in m/s, for so long, in seconds.
_STOPPED, _LEAST_STOP = 0.05, 1.0


def events_of(recording: Recording) -> list[Event]:
    """Returns contacts, entries to zones, reactions and stops, by their time.

    Reactions are those of people whose behaviors react to robots.
    """
    names = recording.human_names
    events: list[Event] = [
        (f"{names[i]} reacts", begin, "reaction")
        for i, begin, _ in reactions(
            recording.times, recording.behavior_status, recording.social_signals
        )
    ]
    for robot in recording.robots:
        name = robot.robot_name
        events += _stops(robot, name or "the robot")
        if not recording.num_humans:
            continue
        zones = {zone: ZONES[zone] for zone in _TOLD}
        found = find_encounters(recording, zones, robot=name).event_rows()
        to = f" to {name}" if name else ""
        for row in found:
            if row["kind"] != "entry":
                continue
            zone, person = row["zone"], row["person"]
            if zone == "contact":
                text, kind = f"contact of {person}{to}", "contact"
            else:
                text = f"{zone} space of {person} entered"
                text, kind = text + (f" by {name}" if name else ""), "entry"
            events.append((text, row["time"], kind))
    return sorted(events, key=lambda event: event[1])


def _stops(robot: Recording, name: str) -> Iterator[Event]:
    stands = np.hypot(robot.robot[:, VX], robot.robot[:, VY]) < _STOPPED
    first, last = robot.times[[0, -1]].tolist()
    for begin, end in stretches(robot.times, stands):
        # (Not before it has started, and not what it does at its goal.)
        if begin > first and end < last and end - begin >= _LEAST_STOP:
            yield f"{name} stops", begin, "stop"
