import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from scipy.stats import binom

from hunav_drake.systems.sensing import Lidar, LidarConfig, scan_points
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.sensing.scans import (
    directions_of,
    fix,
    rows,
    scan,
    to_discs,
    to_segments,
)

DISCS = {"people": "discs", "range_min": 0.0}
WALL = Obstacles.from_shapes([[(2, -1), (2, 1)]], solid=[False])
ROOM = Obstacles.from_shapes(
    [[(-3, -2), (5, -2), (5, 2), (-3, 2)]], solid=[True]
)


def random_config(rng, rays):
    """A lidar anywhere on its robot, of any field of view."""
    full = rng.uniform() < 0.5
    return LidarConfig(
        num_rays=rays,
        field_of_view=2 * math.pi if full else rng.uniform(0.1, 6.2),
        range_max=rng.uniform(2, 30),
        pose=tuple(rng.uniform(-1, 1, 3)),
        **DISCS,
    )


def test_distances_are_those_of_geometry():
    """Over 100 000 rays among walls and people at random."""
    rng = np.random.default_rng(1)
    worst, count = 0.0, 0
    for _ in range(300):
        config = random_config(rng, rays=int(rng.integers(1, 800)))
        ends = rng.uniform(-10, 10, (rng.integers(0, 40), 2, 2))
        people = rows(*rng.uniform(-10, 10, (rng.integers(0, 20), 2)))
        people[:, 6] = rng.uniform(0.1, 0.6, len(people))
        robot = (*rng.uniform(-8, 8, 2), rng.uniform(-20, 20))
        obstacles = Obstacles.from_shapes(ends, solid=[False] * len(ends))
        found = scan(config, obstacles=obstacles, robot=robot, people=people)
        c, s = np.cos(robot[2]), np.sin(robot[2])
        x, y, yaw = config.pose
        start = np.array([robot[0] + c * x - s * y, robot[1] + s * x + c * y])
        u = directions_of(config, robot[2] + yaw)
        expected = np.minimum(
            to_segments(start, u, ends.reshape(-1, 4)),
            to_discs(start, u, people[:, [0, 1, 6]]),
        )
        expected = np.minimum(expected, config.range_max)
        worst = max(worst, abs(found - expected).max())
        count += len(found)
    assert count > 100_000
    assert worst < 1e-9


def test_no_ray_slips_out_of_a_closed_room():
    """Nor through corners, also where rays point at them."""
    config = LidarConfig(num_rays=720, range_max=50, range_min=0)
    for x, y in [(0, 0), (4.999, 1.999), (-3 + 1e-9, 0), (1, -2 + 1e-12)]:
        found = scan(config, obstacles=ROOM, robot=(x, y, 0.0))
        assert found.max() < 12
    corners = np.array([(-3, -2), (5, -2), (5, 2), (-3, 2)])
    angles = np.arctan2(*corners.T[::-1])
    for angle in angles:
        found = scan(
            LidarConfig(num_rays=1, range_max=50),
            obstacles=ROOM,
            robot=(0, 0, angle),
        )
        assert found[0] < 6


def test_what_is_not_met_is_at_the_largest_distance():
    found = scan(LidarConfig(num_rays=4, range_max=7), obstacles=WALL)
    # Back, right, ahead, left.
    np.testing.assert_allclose(found, [7, 7, 2, 7], rtol=1e-12)
    found = scan(LidarConfig(num_rays=4, range_max=1.9), obstacles=WALL)
    np.testing.assert_array_equal(found, 1.9)


def test_what_is_too_near_is_at_the_least_distance():
    person = rows((0.5, 0))
    config = LidarConfig(num_rays=1, range_min=0.4, people="discs")
    assert scan(config, people=person)[0] == 0.4
    assert scan(config, people=rows((0.1, 0)))[0] == 0.4
    assert scan(config, people=rows((1, 0)))[0] == pytest.approx(0.7)


def test_rays_go_around_to_the_left_from_the_right_end_of_the_field():
    config = LidarConfig(num_rays=5, field_of_view=math.pi)
    np.testing.assert_allclose(config.angles(), np.arange(-2, 3) * np.pi / 4)
    config = LidarConfig(num_rays=4)
    np.testing.assert_allclose(config.angles(), np.arange(-2, 2) * np.pi / 2)
    assert LidarConfig(num_rays=1, field_of_view=1.0).angles() == [0.0]


def test_points_lie_on_what_was_met():
    config = LidarConfig(pose=(0.2, 0.1, 0.5), range_max=20)
    robot = (1.0, -0.5, 2.0)
    found = scan(config, obstacles=ROOM, robot=robot)
    points = scan_points(config, found, rows(robot)[0])
    assert len(points) == 360
    inside = np.array([[-3, -2], [5, 2]])
    to_wall = np.abs(points[:, None, :] - inside).min(axis=(1, 2))
    assert to_wall.max() < 1e-9
    far = scan_points(config, np.full(360, 20.0), rows(robot)[0])
    assert far.shape == (0, 2)


def test_points_of_a_scan_of_another_lidar_are_refused():
    with pytest.raises(ValueError, match=r"shape \(360,\).*got \(5,\)"):
        scan_points(LidarConfig(), np.ones(5), rows((0, 0))[0])
    with pytest.raises(ValueError, match="mounted on the robot: give robot_st"):
        scan_points(LidarConfig(), np.ones(360))


def test_a_lidar_on_the_ground_sees_the_robot():
    config = LidarConfig(mount="world", pose=(0, 0, 0), num_rays=1)
    assert scan(config, robot=(2, 0, 0))[0] == pytest.approx(1.7)
    on_robot = LidarConfig(num_rays=1)
    assert scan(on_robot, robot=(2, 0, 0))[0] == on_robot.range_max


def test_other_robots_are_seen():
    dut = Lidar(LidarConfig(num_rays=1), num_other_robots=2)
    context = dut.CreateDefaultContext()
    fix(dut, context)
    others = rows((3, 0.1), (2, -0.1), radius=0.2)
    port = dut.get_other_robot_states_input_port()
    port.FixValue(context, others.ravel())
    expected = 2 - math.sqrt(0.2**2 - 0.1**2)
    found = dut.get_scan_output_port().Eval(context)[0]
    assert found == pytest.approx(expected, abs=1e-12)
    with pytest.raises(ValueError, match="has no port other_robot_states"):
        Lidar().get_other_robot_states_input_port()


def test_nobody_is_as_tall_as_a_plane_above_all_heads():
    high = LidarConfig(num_rays=1, height=1.75, people="discs")
    low = LidarConfig(num_rays=1, height=1.65, people="discs")
    person = rows((2, 0))
    assert scan(high, people=person)[0] == high.range_max
    assert scan(low, people=person)[0] == pytest.approx(1.7)


# Noise.


def noisy(sigma=0.05, **options):
    return Lidar(
        LidarConfig(noise=sigma, num_rays=1000, range_max=20),
        obstacles=ROOM,
        **options,
    )


def scans_of(dut, end, *, context=None, period=0.1):
    """The scans at every period up to a time, and the simulator."""
    simulator = Simulator(dut, context or dut.CreateDefaultContext())
    own = simulator.get_mutable_context()
    fix(dut, own)
    first = round(own.get_time() / period)
    result = []
    for k in range(first, round(end / period) + 1):
        simulator.AdvanceTo(k * period)
        result.append(dut.get_scan_output_port().Eval(own).copy())
    return np.array(result), simulator


def test_noise_is_normal_and_anew_in_each_scan():
    found, _ = scans_of(noisy(), 2.0)
    exact = scan(LidarConfig(num_rays=1000, range_max=20), obstacles=ROOM)
    errors = (found - exact) / 0.05
    assert abs(errors.mean()) < 4 / math.sqrt(errors.size)
    assert errors.std() == pytest.approx(1, abs=0.02)
    # A normal distribution, by its fourth moment, and no echo of other scans.
    assert (errors**4).mean() == pytest.approx(3, abs=0.2)
    together = np.corrcoef(errors)
    assert abs(together - np.eye(len(errors))).max() < 0.15


def test_noise_grows_with_the_distance():
    """Standard deviation a + b times the range; none without a hit."""
    config = {"num_rays": 500, "range_max": 4.0}
    dut = Lidar(
        LidarConfig(noise=0.01, noise_per_meter=0.02, **config), obstacles=ROOM
    )
    found, _ = scans_of(dut, 4.0)
    exact = scan(LidarConfig(**config), obstacles=ROOM)
    met = exact < 3.5
    assert 100 < met.sum() < 400
    errors = (found - exact)[:, met] / (0.01 + 0.02 * exact[met])
    assert abs(errors.mean()) < 4 / math.sqrt(errors.size)
    assert errors.std() == pytest.approx(1, abs=0.02)
    rays = errors.std(axis=0)
    assert np.corrcoef(rays, exact[met])[0, 1] < 0.2
    np.testing.assert_array_equal(found[:, exact == 4.0], 4.0)


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_some_rays_have_no_return(noise):
    """As many as is said, anew in each scan, by draws of their own."""
    config = {"num_rays": 1000, "range_max": 20.0, "noise": noise}
    dut = Lidar(LidarConfig(dropout=0.03, **config), obstacles=ROOM)
    found, _ = scans_of(dut, 2.0)
    full, _ = scans_of(Lidar(LidarConfig(**config), obstacles=ROOM), 2.0)
    lost = found == 20.0
    low, high = binom.interval(1 - 1e-6, lost.size, 0.03)
    assert low <= lost.sum() <= high
    np.testing.assert_array_equal(found[~lost], full[~lost])
    both = (lost[1:] & lost[:-1]).sum()
    low, high = binom.interval(1 - 1e-6, lost[1:].size, 0.03**2)
    assert low <= both <= high
    blind = Lidar(LidarConfig(dropout=1.0, **config), obstacles=ROOM)
    assert (scans_of(blind, 0.0)[0] == 20.0).all()


def test_without_noise_distances_are_exact():
    found, _ = scans_of(noisy(0.0), 0.5)
    exact = scan(LidarConfig(num_rays=1000, range_max=20), obstacles=ROOM)
    for one in found:
        np.testing.assert_array_equal(one, exact)


def test_noise_makes_no_distance_out_of_range():
    config = LidarConfig(noise=3.0, range_max=6, range_min=0.5)
    found = scan(config, obstacles=ROOM)
    assert found.min() == 0.5
    assert found.max() == 6


def test_noise_follows_from_seed_and_number():
    first, _ = scans_of(noisy(seed=3), 0.5)
    again, _ = scans_of(noisy(seed=3), 0.5)
    np.testing.assert_array_equal(first, again)
    for other in (noisy(seed=4), noisy(seed=3, number=1)):
        assert (scans_of(other, 0.5)[0] != first).mean() > 0.99
    dut = noisy(seed=0)
    context = dut.CreateDefaultContext()
    dut.SetSeed(context, 3)
    assert dut.GetSeed(context) == 3
    changed, _ = scans_of(dut, 0.5, context=context)
    np.testing.assert_array_equal(changed, first)


def test_a_clone_has_the_same_future_and_contexts_are_independent():
    dut = noisy(seed=5)
    expected, _ = scans_of(dut, 2.0)
    _, forked = scans_of(dut, 1.0)
    scans_of(dut, 1.5)
    clone = forked.get_context().Clone()
    other = forked.get_context().Clone()
    dut.SetSeed(other, 6)
    rest, _ = scans_of(dut, 2.0, context=clone)
    np.testing.assert_array_equal(rest, expected[10:])
    changed, _ = scans_of(dut, 2.0, context=other)
    assert (changed != expected[10:]).mean() > 0.99


# When scans are made.


def test_a_scan_is_there_at_once_and_held_until_the_next():
    dut = Lidar(
        LidarConfig(num_rays=1, period=0.2), obstacles=WALL, time_step=0.05
    )
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix(dut, context)
    port = dut.get_scan_output_port()
    assert port.Eval(context)[0] == 2
    simulator.AdvanceTo(0.1)
    fix(dut, context, robot=(0.5, 0, 0))
    assert port.Eval(context)[0] == 2
    simulator.AdvanceTo(0.2)
    # At that instant already, before the updates.
    assert port.Eval(context)[0] == 1.5
    simulator.AdvanceTo(0.25)
    fix(dut, context, robot=(1, 0, 0))
    assert port.Eval(context)[0] == 1.5


def test_a_scan_follows_each_input():
    dut = Lidar(LidarConfig(num_rays=4, **DISCS), num_humans=1)
    context = dut.CreateDefaultContext()
    port = dut.get_scan_output_port()
    fix(dut, context, people=rows((2, 0)))
    assert port.Eval(context)[2] == pytest.approx(1.7)
    fix(dut, context, people=rows((3, 0)))
    assert port.Eval(context)[2] == pytest.approx(2.7)
    fix(dut, context, people=rows((3, 0)), robot=(1, 0, 0))
    assert port.Eval(context)[2] == pytest.approx(1.7)


# What is refused.


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"range_min": 5.0, "range_max": 5.0}, "range_max must be above"),
        ({"height": 0.9}, "height must be at most 0.7 m .* people: discs"),
        ({"num_rays": 0}, "at least 1"),
        ({"field_of_view": 7.0}, r"must be in \(0, 6.28319\] rad, got 7"),
        ({"noise": -0.1}, r"must be in \[0, 10\] m, got -0.1"),
        ({"noise": float("nan")}, "finite number"),
        ({"dropout": 1.5}, r"must be in \[0, 1\], got 1.5"),
        ({"noise_per_meter": 2.0}, r"must be in \[0, 1\] m/m, got 2"),
        ({"delay": 6.0}, r"must be in \[0, 5\] s, got 6"),
    ],
)
def test_a_lidar_that_cannot_be_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        LidarConfig(**options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"time_step": 0.03}, "period must be a multiple of time_step"),
        ({"seed": -1}, "seed must be a whole number"),
        ({"num_humans": -1}, "num_humans must be at least 0, got -1"),
        ({"number": 1.5}, "number must be a whole number, got 1.5"),
    ],
)
def test_arguments_out_of_range_are_refused(options, words):
    with pytest.raises((ValueError, TypeError), match=words):
        Lidar(**options)
