"""Cases of encounters in narrow or crowded places."""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.world.shapes import Box
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.measures import (
    STANDARD_GRAVITY,
    nearest_centers,
    peak_acceleration,
    touches,
)
from hunav_drake.validation.places import Area, corridor, wall
from hunav_drake.validation.walkers import SPEED, TIME_STEP, Walkers

# The radius of people including their personal space, in meters.
BODY = 0.35

# A person is stuck who moved less than this (m) in this time (s) at the end.
_STUCK = 0.5
_STUCK_FOR = 10.0


@case(
    "",
    question="Do two people of 0.35 m radius who meet head-on pass each other"
    " in corridors of 1.2, 1.5, 2 and 3 m, at a distance?",
    expected="both pass in all corridors, and centers are at least 0.5 m apart",
    accepts=lambda it: max(it["time"]) < np.inf and min(it["nearest"]) >= 0.5,
    shown="{width:g} m wide: nearest {nearest:.2f} m, past each other at"
    " {time:.1f} s",
)
def head_on(setting: Setting) -> Numbers:
    """Measures how two people pass each other in corridors."""
    widths = [1.2, 1.5, 2.0, 3.0]
    generator = setting.generator("head-on")
    nearest, times = [], []
    for width in widths:
        y = width / 2 + generator.uniform(-0.01, 0.01, 2)
        walk = Walkers(
            setting,
            [[0, y[0]], [10, y[1]]],
            [[30, y[0]], [-20, y[1]]],
            walls=corridor(-22, 32, width),
            radii=BODY,
        ).walk(20.0 if setting.quick else 40.0)
        passed = np.stack([walk.x[:, 0] > 10, walk.x[:, 1] < 0], axis=1)
        times.append(float(walk.first_time(passed).max()))
        nearest.append(nearest_centers(walk))
    return {"width": widths, "nearest": nearest, "time": times}


# The side of a hall with obstacles, in meters.
_SIDE = 12.0


def _hall() -> list[Box]:
    return [
        *corridor(-0.2, _SIDE + 0.2, _SIDE),
        wall(-0.2, 0, 0, _SIDE),
        wall(_SIDE, 0, _SIDE + 0.2, _SIDE),
        wall(2.4, 2.4, 3.6, 4.6),
        wall(7.2, 2, 9.2, 3),
        wall(2, 8, 4, 9),
        wall(5.5, 5.5, 6.5, 6.5),
        wall(8.3, 7.4, 9.3, 9.4),
    ]


def _free_places(n: int, generator: np.random.Generator) -> Array:
    """Returns places in the hall, away from walls: shape (n, 2)."""
    blocked = [
        Area(
            box.center[0] - box.size[0] / 2 - 0.6,
            box.center[1] - box.size[1] / 2 - 0.6,
            box.center[0] + box.size[0] / 2 + 0.6,
            box.center[1] + box.size[1] / 2 + 0.6,
        )
        for box in _hall()
    ]
    found: list[Array] = []
    while len(found) < n:
        place = generator.uniform(0, _SIDE, 2)
        if not any(area.holds(place) for area in blocked):
            found.append(place)
    return np.array(found)


@case(
    "",
    question="Do 30 people of 0.35 m radius, who walk from place to place in a"
    " hall of 12 x 12 m with five obstacles for 120 s, move without getting"
    " stuck, contacts and jerks?",
    expected="nobody stuck, speed over 0.6 of the desired speed, under 0.3"
    " contacts per person and minute, acceleration under 0.4 g",
    accepts=lambda it: (
        it["stuck"] == 0
        and it["speed"] > 0.6
        and it["contacts"] < 0.3
        and it["peak"] < 0.4
    ),
    shown="{stuck:.0f} stuck, {speed:.2f} of the preferred speed,"
    " {contacts:.1f} contacts, {peak:.2f} g",
)
def among_obstacles(setting: Setting) -> Numbers:
    """Measures how smoothly people walk among obstacles and each other."""
    people = 15 if setting.quick else 30
    seconds = 20.0 if setting.quick else 120.0
    generator = setting.generator("obstacles")
    starts = _apart(_free_places(20 * people, generator), people)
    # More goals than any person reaches.
    goals = _free_places(people * 100, generator).reshape(people, -1, 2)
    walkers = Walkers(setting, starts, goals[:, 0], walls=_hall(), radii=BODY)
    at = np.zeros(people, dtype=int)

    def go_on(it: Walkers) -> None:
        rows = it.states
        there = it.command[:, : Command.GOAL_Y + 1]
        near = np.hypot(*(rows[:, :2] - there).T) < 0.5
        at[near] = (at[near] + 1) % goals.shape[1]
        it.command[:, : Command.GOAL_Y + 1] = goals[np.arange(people), at]

    walk = walkers.walk(seconds, each=go_on)
    last = walk.states[-round(min(_STUCK_FOR, seconds / 2) / TIME_STEP) :]
    came = np.hypot(*np.moveaxis(last[..., :2] - last[0, :, :2], -1, 0))
    speeds = np.hypot(*np.moveaxis(walk.velocities(), -1, 0))
    minutes = people * seconds / 60
    contacts = touches(walk.states[..., :2]) / minutes
    return {
        "stuck": float((came.max(axis=0) < _STUCK).sum()),
        "speed": float(speeds.mean() / SPEED),
        "contacts": contacts,
        "peak": peak_acceleration(walk) / STANDARD_GRAVITY,
    }


def _apart(places: Array, n: int) -> Array:
    """Returns the first n places that are 0.8 m or more apart."""
    chosen: list[Array] = []
    for place in places:
        if all(np.hypot(*(place - other)) >= 0.8 for other in chosen):
            chosen.append(place)
    return np.array(chosen[:n])


CASES = (head_on, among_obstacles)
