"""Crowds walk as fast, and pass doors as fast, as people were measured to.

`pytest -s` shows the numbers. Weidmann 1993 for the speeds, Seyfried et al.
2009 for the doors, NIST TN 1822 for the two rooms.
"""

import math

import numpy as np
import pytest

from hunav_drake.systems.crowd import (
    AnticipationVelocityModel,
    CollisionFreeSpeedModel,
)
from tests.systems.crowd.measured_crowds import (
    door_flow,
    lane_order,
    meet,
    ring_speed,
    trembling,
    walk_against,
    walk_in_ring,
    walk_through_door,
    weidmann,
)

COLLISION_FREE = CollisionFreeSpeedModel()
ANTICIPATION = AnticipationVelocityModel()
BOTH = pytest.mark.parametrize(
    "model",
    [COLLISION_FREE, ANTICIPATION],
    ids=["collision_free", "anticipation"],
)


def test_weidmanns_speeds_are_those_of_the_table():
    np.testing.assert_allclose(
        weidmann([0.5, 1, 2, 3, 4]), [1.30, 1.06, 0.61, 0.33, 0.16], atol=0.005
    )


@pytest.mark.slow
@BOTH
def test_the_speed_in_a_dense_stream_is_as_measured(model):
    assert abs(ring_speed(model, 2.0) - weidmann(2.0)) < 0.1


@pytest.mark.slow
@BOTH
def test_speeds_at_densities_are_as_measured(model):
    """Means of three starts, which differ at 1 person per m^2."""
    densities = [0.5, 1.0, 1.5, 2.0, 3.0]
    speeds = np.array(
        [
            [ring_speed(model, density, seed=seed) for density in densities]
            for seed in range(3)
        ]
    )
    errors = speeds.mean(axis=0) - weidmann(densities)
    print(speeds.mean(axis=0).round(2), errors.round(2))
    assert np.abs(errors).mean() < 0.1
    assert np.abs(errors).max() < 0.18
    assert np.abs(np.delete(errors, 1)).max() < 0.1
    # Slower the denser it is.
    assert (np.diff(speeds.mean(axis=0)) < 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("width", [0.8, 1.2, 2.4])
def test_doors_pass_as_many_as_measured(width):
    states = walk_through_door(COLLISION_FREE, width)
    flow = door_flow(states, width)
    trembled = trembling(states[100:])
    print(f"{width} m: {flow:.2f} /(m s), trembling {trembled.mean():.4f} m/s")
    assert 1.6 < flow < 2.2
    # Nobody swings to and fro in front of it.
    assert trembled.mean() < 0.005
    assert np.percentile(trembled, 95) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("width", [0.8, 2.4])
def test_no_door_is_clogged_by_who_anticipates(width):
    flow = door_flow(walk_through_door(ANTICIPATION, width), width)
    print(f"{width} m: {flow:.2f} /(m s)")
    assert 1.3 < flow < 2.2


@BOTH
@pytest.mark.parametrize("width", [0.9, 1.2, 1.5, 2.0, 3.0])
def test_two_who_meet_in_a_corridor_pass_each_other(model, width):
    for offset in (0.0, 0.1, -0.05):
        time, apart = meet(model, width, offset=offset)
        assert time < 13
        # Bodies of 0.2 m do not overlap.
        assert apart > 0.4


@BOTH
@pytest.mark.parametrize("density", [1.0, 3.0])
def test_a_stream_does_not_tremble(model, density):
    states = walk_in_ring(model, density, time=8.0)[60:]
    assert np.percentile(trembling(states), 95) < 0.02
    rate = np.abs(np.diff(np.unwrap(states[..., 2], axis=0), axis=0)) / 0.05
    assert np.percentile(rate, 99) < 1.0


@pytest.mark.slow
def test_two_crowds_change_rooms():
    """In a corridor of 2 m, the more come the other way, the longer."""
    times = []
    for others in (0, 20, 100):
        time, left, states = walk_against(
            ANTICIPATION, 100, others, duration=240.0
        )
        print(f"100 against {others}: {time:.1f} s, {left} left")
        times.append(time)
        assert np.abs(states[..., 1]).max() < 5.0
    assert times[0] < times[1] < times[2] < math.inf


@pytest.mark.slow
def test_streams_order_themselves_into_lanes():
    orders = [lane_order(ANTICIPATION, seed=seed) for seed in range(2)]
    print(orders)
    assert np.mean(orders) > 0.65
