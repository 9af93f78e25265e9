"""Crowds do what crowds do. `pytest -s` shows the numbers.

The cases R1 and R6 are tests 1 and 6 of the RiMEA guideline 4.1.1.
"""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people.profile import own_forces
from hunav_drake.systems.world.obstacles import inside
from hunav_drake.systems.world.shapes import Box, World
from tests.systems.crowd.crowds import FREE, box_between

TIME_STEP = 0.05


def record_steps(
    humans,
    *,
    walls=(),
    duration,
    time_step=TIME_STEP,
    until=lambda rows: False,
    config=None,
):
    """Returns the times and the states at each step, shape (k, n, 7)."""
    builder = DiagramBuilder()
    ports = AddHumans(
        builder,
        humans,
        obstacles=World(walls=list(walls)).obstacles(),
        num_robots=0,
        time_step=time_step,
        config=config,
    )
    builder.ExportOutput(ports.human_states, "human_states")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_context()
    history = []
    for k in range(round(duration / time_step) + 1):
        rows = diagram.GetOutputPort("human_states").Eval(context)
        history.append(rows.reshape(-1, 7).copy())
        if until(history[-1]):
            break
        # In the middle of the step, so that rounding skips no update.
        simulator.AdvanceTo((k + 0.5) * time_step)
    return np.arange(len(history)) * time_step, np.array(history)


def outside(walls, states):
    """Returns the number of samples in a wall, by more than 1 mm."""
    shrunk = [
        Box(center=box.center, size=(box.size[0] - 2e-3, box.size[1] - 2e-3))
        for box in walls
    ]
    return int(inside(World(walls=shrunk).obstacles(), states[..., :2]).sum())


def grid(n, corner, opposite, *, columns):
    """Places for n people, column by column, with a little disorder."""
    rows = math.ceil(n / columns)
    x = np.linspace(corner[0], opposite[0], columns)
    y = np.linspace(corner[1], opposite[1], rows)
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    generator = np.random.default_rng(0)
    return places[:n] + generator.uniform(-0.08, 0.08, (n, 2))


def first_time(times, reached):
    """When each person first is where `reached`, shape (k, n), says."""
    return np.where(
        reached.any(axis=0), times[np.argmax(reached, axis=0)], np.inf
    )


@pytest.mark.parametrize("speed", [0.5, 1.2])
def test_the_free_speed_is_reached_exponentially(speed):
    """v(t) = v (1 - exp(-t k_d / tau))."""
    human = HumanConfig(pose=[0, 0, 0], goals=[[99, 0]], desired_speed=speed)
    forces = own_forces(human, "default")
    rate = forces.goal_factor / forces.relaxation_time
    times, states = record_steps(
        [human], duration=3.0, time_step=1e-3, config=CrowdConfig(**FREE)
    )
    expected = speed * (1 - np.exp(-times * rate))
    error = abs(states[:, 0, 3] - expected).max()
    print(f"free speed {speed} m/s: largest error {error * 1e3:.2f} mm/s")
    # The error of an Euler step of 1 ms: e^-1 v rate h / 2.
    assert error < 1e-3 * speed * rate / 4
    assert states[-1, 0, 3] == pytest.approx(speed, rel=1e-4)


def test_r1_the_free_speed_is_kept_in_a_corridor():
    """40 m at 1.33 m/s take 26 to 34 s."""
    walls = [box_between(-1, -0.2, 42, 0), box_between(-1, 2, 42, 2.2)]
    human = HumanConfig(
        pose=[0, 1, 0], goals=[[50, 1]], desired_speed=1.33, radius=0.2
    )
    times, states = record_steps([human], walls=walls, duration=40.0)
    (time,) = first_time(times, states[..., 0] >= 40)
    print(f"R1: {time:.2f} s for 40 m")
    assert 26 <= time <= 34
    assert abs(states[..., 1] - 1).max() < 1e-3


def test_r6_people_walk_round_a_corner():
    """20 people in a corridor 2 m wide; nobody leaves it, all arrive."""
    walls = [
        box_between(-0.2, -0.2, 12.2, 0),
        box_between(12, 0, 12.2, 12),
        box_between(-0.2, 0, 0, 2.2),
        box_between(0, 2, 10, 2.2),
        box_between(9.8, 2.2, 10, 12),
    ]
    humans = [
        HumanConfig(
            pose=[*place, 0],
            goals=[[11, 1], [11, 30]],
            goal_radius=0.9,
            radius=0.2,
            desired_speed=1.3,
        )
        for place in grid(20, (0.4, 0.4), (5.8, 1.6), columns=7)
    ]
    times, states = record_steps(
        humans,
        walls=walls,
        duration=90.0,
        until=lambda rows: (rows[:, 1] > 12).all(),
    )
    arrival = first_time(times, states[..., 1] > 12)
    in_walls = outside(walls, states)
    x, y = states[..., 0], states[..., 1]
    in_corridor = (x > 0) & (x < 12) & (y > 0) & ((y < 2) | (x > 10))
    left = int((~in_corridor & (y < 12)).sum())
    print(
        f"R6: arrivals {arrival.min():.1f} to {arrival.max():.1f} s;"
        f" samples in walls {in_walls}, outside {left} of {x.size}"
    )
    assert np.isfinite(arrival).all()
    assert in_walls == 0
    assert left == 0


def lane_order(states, to_right):
    """The order parameter of lanes in the middle 10 m of a 20 m corridor.

    The mean over strips 0.2 m wide of ((n_L - n_R)/(n_L + n_R))^2; NaN if
    nobody is there.
    """
    x, y = states[:, 0], states[:, 1]
    middle = (x > 5) & (x < 15)
    strips = np.floor(y[middle] / 0.2)
    sides = np.where(to_right[middle], 1.0, -1.0)
    return float(
        np.mean(
            [np.mean(sides[strips == strip]) ** 2 for strip in set(strips)]
            or [np.nan]
        )
    )


def test_counterflows_pass_and_form_lanes():
    """20 against 20 people in a corridor of 3 x 20 m."""
    walls = [box_between(-12, -0.2, 32, 0), box_between(-12, 3, 32, 3.2)]
    starts = grid(20, (-8, 0.5), (-1, 2.5), columns=5)
    to_right = np.arange(40) < 20
    humans = [
        HumanConfig(pose=[x, y, 0], goals=[[40, 1.5]], radius=0.2)
        for x, y in starts
    ] + [
        HumanConfig(pose=[20 - x, y, math.pi], goals=[[-20, 1.5]], radius=0.2)
        for x, y in grid(20, (-8, 0.5), (-1, 2.5), columns=5)[::-1]
    ]

    def arrived(rows):
        return np.where(to_right, rows[..., 0] > 20, rows[..., 0] < 0)

    times, states = record_steps(
        humans,
        walls=walls,
        duration=120.0,
        until=lambda rows: arrived(rows).all(),
    )
    arrival = first_time(times, arrived(states))
    both = [
        rows
        for rows in states
        if all(
            ((rows[side, 0] > 5) & (rows[side, 0] < 15)).sum() >= 5
            for side in (to_right, ~to_right)
        )
    ]
    order = np.mean([lane_order(rows, to_right) for rows in both])
    # Few people in a strip are in order by chance, too.
    generator = np.random.default_rng(0)
    by_chance = np.mean(
        [lane_order(rows, generator.permutation(to_right)) for rows in both]
    )
    print(
        f"counterflow: {np.isfinite(arrival).sum()} of 40 arrive, the last"
        f" after {arrival.max():.1f} s; lane order parameter {order:.2f},"
        f" without lanes {by_chance:.2f};"
        f" samples in walls {outside(walls, states)}"
    )
    assert np.isfinite(arrival).all()
    assert order > by_chance + 0.1


def spread(states):
    """The mean distance of people from their center, at each step."""
    p = states[..., :2]
    return np.hypot(*(p - p.mean(axis=1, keepdims=True)).T).mean(axis=0)


def test_a_group_stays_together_where_strangers_do_not():
    """Three who differ in speed, and three who meet them, not together."""

    def three(group_id):
        return [
            HumanConfig(
                pose=[0, y, 0],
                goals=[[60, y]],
                desired_speed=speed,
                group_id=group_id,
            )
            for y, speed in ((-1.0, 1.0), (0.0, 1.2), (1.0, 1.4))
        ]

    against = [
        HumanConfig(pose=[14, y, math.pi], goals=[[-60, y]])
        for y in (-0.8, 0.1, 0.9)
    ]
    group, strangers = (
        spread(record_steps(three(k) + against, duration=25.0)[1][:, :3])
        for k in (1, -1)
    )
    print(
        f"spread after 25 s: group {group[-1]:.2f} m (greatest"
        f" {group.max():.2f}), strangers {strangers[-1]:.2f} m"
    )
    assert group.max() < 1.5
    assert strangers[-1] > 2 * group[-1]


def test_people_pass_a_narrow_door():
    """30 people leave a room of 6 x 6 m by a door 1 m wide."""
    walls = [
        box_between(-0.2, -0.2, 0, 6.2),
        box_between(0, -0.2, 6.2, 0),
        box_between(0, 6, 6.2, 6.2),
        box_between(6, 0, 6.2, 2.5),
        box_between(6, 3.5, 6.2, 6),
    ]
    humans = [
        HumanConfig(
            pose=[*place, 0],
            goals=[[6.1, 3], [20, 3]],
            goal_radius=0.4,
            radius=0.2,
            desired_speed=1.3,
        )
        for place in grid(30, (0.5, 0.6), (4.5, 5.4), columns=5)
    ]
    times, states = record_steps(
        humans,
        walls=walls,
        duration=180.0,
        until=lambda rows: (rows[:, 0] > 6.5).all(),
    )
    passage = np.sort(first_time(times, states[..., 0] > 6.2))
    in_walls = outside(walls, states)
    flow = (len(passage) - 1) / (passage[-1] - passage[0])
    print(
        f"door: {np.isfinite(passage).sum()} of 30 pass, the last after"
        f" {passage[-1]:.1f} s; {flow:.2f} persons/s;"
        f" samples in walls {in_walls}"
    )
    assert np.isfinite(passage).all()
    assert 0.5 < flow < 4.0
    x, y = states[..., 0], states[..., 1]
    through_walls = (x > 6) & (x < 6.2) & (abs(y - 3) > 0.501)
    assert in_walls == 0
    assert not through_walls.any()
