"""Makes a scenario of a world of Gazebo."""

from collections.abc import Sequence
import itertools
import math
import os
from pathlib import Path

import numpy as np

from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.files import as_file_name
from hunav_drake.systems.common.models.gazebo import Actor, read_gazebo
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.shapes import Model, World

# Waypoints nearer to each other are one, in meters; a person waits there.
_APART = 0.05

# Whoever is slower waits, in m/s.
_STILL = 0.05

# The range of speeds, in m/s: that of a person.
_SPEEDS = 0.1, 3.0


def import_world(
    file: str | Path,
    model_path: Sequence[str] = (),
    skip_missing: bool = False,
    notes: list[str] | None = None,
) -> Scenario:
    """Returns a scenario in a world of Gazebo, with its actors as people.

    A person walks from waypoint to waypoint of its actor's script with its mean
    speed, without the time that it waits; it begins anew if the script does.

    Args:
        file: The world, or a model.
        model_path: Folders in which its models are searched first.
        skip_missing: Whether models that are not there are left out.
        notes: Receives a line for all that is lost, or has no meaning here.

    Raises:
        ModelFault: If the file cannot be read.
    """
    file = os.path.abspath(file)
    folders = [os.path.abspath(it) for it in model_path]
    found = read_gazebo(file, folders, skip_missing)
    people: dict[str, HumanConfig] = {}
    taken = {actor.name for actor in found.actors}
    for actor in found.actors:
        numbered = (f"{actor.name[:58]}_{i}" for i in itertools.count(2))
        name = actor.name[:64]
        if name in people:
            name = next(it for it in numbered if it not in taken)
        taken.add(name)
        people[name] = _person(actor, name)
    if notes is not None:
        notes += [*found.losses, *found.notes]
    return Scenario(
        name=as_file_name(Path(file).stem),
        description=f"Imported from {Path(file).name}."[:200],
        humans=list(people.values()),
        world=World(
            models=[
                Model(file=file, model_path=folders, skip_missing=skip_missing)
            ]
        ),
    )


def _person(actor: Actor, name: str) -> HumanConfig:
    rows = np.array(actor.waypoints)
    places = [rows[0, 1:3]]
    length = time = 0.0
    for before, row in itertools.pairwise(rows):
        step = float(np.hypot(*(row[1:3] - before[1:3])))
        if row[0] > before[0] and step >= _STILL * (row[0] - before[0]):
            length += step
            time += row[0] - before[0]
        if np.hypot(*(row[1:3] - places[-1])) >= _APART:
            places.append(row[1:3])
    goals = places[1:]
    loops = actor.loops and len(goals) > 0
    if loops and np.hypot(*(goals[-1] - places[0])) >= _APART:
        goals.append(places[0])
    x, y = places[0].tolist()
    yaw = float(rows[0, 3])
    if goals:
        yaw = math.atan2(*(goals[0] - places[0])[::-1])
    human = HumanConfig(
        name=name,
        pose=(round(x, 3), round(y, 3), round(yaw, 3)),
        goals=[(round(gx, 3), round(gy, 3)) for gx, gy in goals],
    )
    if goals and time > 0:
        human.desired_speed = round(float(np.clip(length / time, *_SPEEDS)), 3)
    if loops:
        human.cyclic = True
    return human
