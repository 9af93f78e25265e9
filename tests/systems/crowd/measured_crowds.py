"""Crowds of which figures are known, and how they are measured."""

import dataclasses
import math

import numpy as np

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, Snapshot
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.crowd.walls.keep_out import (
    keep_out_of_walls,
    wall_margins,
)
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.people.human_config import LARGEST_BODY
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from tests.systems.crowd.crowds import box_between

RADIUS = 0.2
SPEED = 1.34
TIME_STEP = 0.05
WEIGHTS = dataclasses.astuple(SocialForceParameters())

# A corridor that closes on itself, and how far people in it see, in meters.
LENGTH, WIDTH, SEEN = 15.0, 5.0, 5.0


def weidmann(density):
    """The speeds measured at densities (1/m^2) by Weidmann 1993, in m/s."""
    return 1.34 * (1 - np.exp(-1.913 * (1 / np.asarray(density) - 1 / 5.4)))


def make_commands(goals, speed=SPEED):
    """Commands to walk to goals (n, 2) at a speed, hurrying at most a bit."""
    command = np.zeros((len(goals), COMMAND_SIZE))
    command[:, :2] = goals
    command[:, Command.GOAL_RADIUS] = 0.3
    command[:, Command.HAS_GOAL] = 1
    command[:, Command.DESIRED_SPEED] = speed
    command[:, Command.MAX_SPEED] = 1.3 * speed
    command[:, Command.GROUP_ID] = -1
    return command


def places(n, x0, y0, x1, y1, seed=0):
    """Places (n, 2) in a rectangle, on a grid with some disorder."""
    rng = np.random.default_rng(seed)
    columns = max(1, round(math.sqrt(n * (x1 - x0) / (y1 - y0))))
    rows = max(1, math.ceil(n / columns))
    size = np.array([(x1 - x0) / columns, (y1 - y0) / rows])
    cell = rng.permutation(columns * rows)[:n]
    grid = np.stack([cell % columns, cell // columns], axis=1) + 0.5
    free = np.clip((size - 2 * RADIUS) / 2, 0, 0.3)
    return [x0, y0] + grid * size + rng.uniform(-1, 1, (n, 2)) * free


def walk_in_ring(model, density, *, time, seed=0):
    """The states (k, n, 6) in a corridor whose ends are joined.

    x goes on from lap to lap. People near an end see those at the other one.
    """
    n = round(density * LENGTH * WIDTH)
    obstacles = Obstacles.from_shapes(
        [[[-9e3, y], [9e3, y]] for y in (0.0, WIDTH)], solid=[False, False]
    )
    states = np.zeros((n, 6))
    states[:, :2] = places(n, 0, 0.2, LENGTH, WIDTH - 0.2, seed)
    states[:, 3] = weidmann(density)
    lap = np.array([LENGTH, 0, 0, 0, 0, 0])
    history = [states]
    for _ in range(round(time / TIME_STEP)):
        laps = np.floor(states[:, :1] / LENGTH) * lap
        here = states - laps
        rows = np.concatenate(
            [
                here,
                here[here[:, 0] > LENGTH - SEEN] - lap,
                here[here[:, 0] < SEEN] + lap,
            ]
        )
        snapshot = Snapshot(
            states=rows,
            radii=np.full(len(rows), RADIUS),
            command=make_commands(rows[:, :2] + [100.0, 0.0]),
            parameters=np.tile(WEIGHTS, (len(rows), 1)),
            robots=np.zeros((0, 7)),
            obstacles=obstacles,
            obstacle_range=5.0,
            max_obstacles=0,
            time_step=TIME_STEP,
        )
        after = model.advance(snapshot, model.forces(snapshot))
        margins = wall_margins(np.minimum(snapshot.radii, LARGEST_BODY))
        kept = keep_out_of_walls(rows, after, margins, obstacles.table)
        states = laps + kept[:n]
        history.append(states)
    return np.array(history)


def ring_speed(model, density, *, warm=15.0, time=20.0, seed=0):
    """The mean speed along the corridor, after some time, in m/s."""
    x = walk_in_ring(model, density, time=warm + time, seed=seed)[:, :, 0]
    return (x[-1] - x[round(warm / TIME_STEP)]).mean() / time


def walk(model, starts, goals, walls, *, duration, until):
    """The states (k, n, 6) of people who walk from rest, until they are."""
    step = CrowdStep(
        [HumanConfig(pose=(x, y, 0.0), radius=RADIUS) for x, y in starts],
        obstacles=World(walls=list(walls)).obstacles(),
        config=CrowdConfig(model=model),
        time_step=TIME_STEP,
    )
    n = len(starts)
    states = np.zeros((n, 6))
    states[:, :2] = starts
    aim = np.asarray(goals) - states[:, :2]
    states[:, 2] = np.arctan2(aim[:, 1], aim[:, 0])
    command = make_commands(goals)
    weights = np.tile(WEIGHTS, (n, 1))
    history = [states]
    for _ in range(round(duration / TIME_STEP)):
        snapshot = step.look(states, command, np.zeros((0, 7)), weights)
        states, *_ = step.advance(
            snapshot, step.forces(snapshot), np.zeros((len(states), 3))
        )
        history.append(states)
        if until(states):
            break
    return np.array(history)


def walk_through_door(model, width, *, n=120, seed=0, duration=150.0):
    """The states (k, n, 6) of a crowd in front of a door at x = 0."""
    walls = [
        box_between(-0.1, width / 2, 0.1, 5.2),
        box_between(-0.1, -5.2, 0.1, -width / 2),
        box_between(-10, 5.0, 0.1, 5.2),
        box_between(-10, -5.2, 0.1, -5.0),
    ]
    starts = places(n, -7.0, -4.0, -0.6, 4.0, seed)
    goals = np.column_stack([np.full(n, 30.0), 0.3 * starts[:, 1]])
    return walk(
        model,
        starts,
        goals,
        walls,
        duration=duration,
        until=lambda states: (states[:, 0] > 0).all(),
    )


def door_flow(states, width, *, ends=20):
    """The flow per width of a door, in 1/(m s), without first and last ones.

    It is 0 if not all of them pass.
    """
    passed = states[:, :, 0] > 0
    if not passed.any(axis=0).all():
        return 0.0
    times = np.sort(passed.argmax(axis=0)) * TIME_STEP
    times = times[ends : len(times) - ends]
    return (len(times) - 1) / (times[-1] - times[0]) / width


def meet(model, width, *, offset=0.0, duration=30.0):
    """The time in which two people change sides in a corridor, and their gap.

    The time is infinite if they do not.
    """
    walls = [
        box_between(-9, width / 2, 9, width / 2 + 0.2),
        box_between(-9, -width / 2 - 0.2, 9, -width / 2),
    ]
    states = walk(
        model,
        [[-6.0, 0.0], [6.0, offset]],
        [[7.0, 0.0], [-7.0, 0.0]],
        walls,
        duration=duration,
        until=lambda states: states[0, 0] > 6 and states[1, 0] < -6,
    )
    apart = np.linalg.norm(states[:, 0, :2] - states[:, 1, :2], axis=1).min()
    passed = states[-1, 0, 0] > 6 and states[-1, 1, 0] < -6
    return (len(states) - 1) * TIME_STEP if passed else math.inf, apart


def walk_against(model, n, m, *, duration, seed=0):
    """NIST 2.8: n and m people change rooms by a corridor of 10 m x 2 m.

    Returns:
        The time in which all do, or infinity; how many do not; the states.
    """
    walls = [box_between(-5, y, 5, 1.2 * y) for y in (1, -1)]
    for side in (-1, 1):
        walls += [
            *(box_between(5 * side, y, 5.2 * side, 5 * y) for y in (1, -1)),
            *(
                box_between(5 * side, 5 * y, 15 * side, 5.2 * y)
                for y in (1, -1)
            ),
            box_between(15 * side, -5.2, 15.2 * side, 5.2),
        ]
    starts = np.concatenate(
        [
            places(n, -14.5, -4.5, -6.0, 4.5, seed),
            -places(m, -14.5, -4.5, -6.0, 4.5, seed + 1)[:m],
        ]
    )
    way = -np.sign(starts[:, 0])
    goals = np.column_stack([14.0 * way, 0.95 * starts[:, 1]])
    states = walk(
        model,
        starts,
        goals,
        walls,
        duration=duration,
        until=lambda states: (states[:, 0] * way > 5.5).all(),
    )
    left = int((states[-1, :, 0] * way <= 5.5).sum())
    time = (len(states) - 1) * TIME_STEP
    return time if left == 0 else math.inf, left, states


def lane_order(model, *, seed=0):
    """The order of the lanes of two streams of 27, in [0, 1].

    They meet in a corridor of 38 m x 3 m, and are counted in rows of 0.2 m
    of its middle, while both are there.
    """
    walls = [box_between(-20, 1.5, 20, 1.7), box_between(-20, -1.7, 20, -1.5)]
    starts = np.concatenate(
        [
            places(27, -12, -1.3, -3, 1.3, seed),
            places(27, 3, -1.3, 12, 1.3, seed + 1),
        ]
    )
    way = -np.sign(starts[:, 0])
    goals = np.column_stack([19 * way, starts[:, 1]])
    states = walk(
        model, starts, goals, walls, duration=12.0, until=lambda states: False
    )
    orders = []
    for rows in states[round(4 / TIME_STEP) :]:
        inside = np.abs(rows[:, 0]) < 5
        line = np.floor((rows[:, 1] + 1.5) / 0.2).astype(int).clip(0, 14)
        right = np.bincount(line[inside & (way > 0)], minlength=15)
        left = np.bincount(line[inside & (way < 0)], minlength=15)
        if right.sum() >= 5 and left.sum() >= 5:
            both = right + left
            used = both > 0
            part = (right - left)[used] / both[used]
            orders.append((part**2).mean())
    return float(np.mean(orders))


def trembling(states):
    """The detour of ways per second, shape (k n,), in m/s.

    Sampled by seconds.
    """
    each = round(1 / TIME_STEP)
    p = states[: (len(states) - 1) // each * each + 1, :, :2]
    steps = np.linalg.norm(np.diff(p, axis=0), axis=2)
    ways = steps.reshape(-1, each, steps.shape[1]).sum(axis=1)
    return (ways - np.linalg.norm(np.diff(p[::each], axis=0), axis=2)).ravel()
