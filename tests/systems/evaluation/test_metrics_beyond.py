"""The metrics beyond the paper's, where they can be worked out by hand."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from hunav_drake.systems.evaluation.compute import (
    compute_by_behavior,
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.comparison import (
    displacement,
    warped_distance,
)
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.evaluation.trials import R, make, rows

PI = math.pi


def along(points, *, step=0.05, r=R, **kwargs):
    """Returns a robot that follows a polyline at 1 m/s, turning on the spot."""
    positions, yaws = [], []
    for p, q in itertools.pairwise(points):
        d = np.subtract(q, p)
        parts = round(float(np.hypot(*d)) / step)
        fractions = np.arange(parts + 1) / parts
        positions += list(np.array(p) + fractions[:, None] * d)
        yaws += [math.atan2(d[1], d[0])] * (parts + 1)
    p = np.array(positions)
    t = np.arange(len(p)) * step
    return make(
        t, rows(len(p), p[:, 0], p[:, 1], np.array(yaws), r=r), **kwargs
    )


def wall_through(*points):
    return Obstacles.from_shapes([points], solid=[False])


def value(recording, name):
    return compute_metrics(recording, [name]).iloc[0]


def test_a_straight_path_is_efficient_and_regular():
    dut = along([(0, 0), (3, 4)], goal=(3, 4, 0))
    assert value(dut, "path_efficiency") == pytest.approx(1.0)
    assert value(dut, "path_irregularity") == pytest.approx(0.0, abs=1e-12)
    assert value(dut, "spl") == pytest.approx(1.0)


def test_a_detour_costs_its_length():
    # Two legs of a right angle: 3 + 4 instead of 5 meters.
    dut = along([(0, 0), (3, 0), (3, 4)], goal=(3, 4, 0))
    assert value(dut, "path_efficiency") == pytest.approx(5 / 7)
    assert value(dut, "spl") == pytest.approx(5 / 7)
    # It turns by 90 degrees; straight on it would turn there and back.
    assert value(dut, "path_irregularity") == pytest.approx(0.0, abs=1e-12)


def test_weaving_is_irregular():
    dut = along([(0, 0), (1, 1), (2, 0), (3, 1), (4, 0)])
    # It starts and ends at 45 degrees off the straight way, and turns by 90
    # degrees three times.
    expected = (3 * PI / 2 - PI / 2) / (4 * math.sqrt(2))
    assert value(dut, "path_irregularity") == pytest.approx(expected)
    assert value(dut, "path_efficiency") == pytest.approx(1 / math.sqrt(2))


def test_a_circle_is_irregular_by_its_curvature():
    angle = np.linspace(0, 2 * PI, 2001)
    robot = rows(2001, 2 * np.cos(angle), 2 * np.sin(angle), angle + PI / 2)
    dut = make(np.linspace(0, 10, 2001), robot)
    assert value(dut, "path_irregularity") == pytest.approx(0.5, rel=1e-5)
    assert value(dut, "path_efficiency") == pytest.approx(0.0, abs=1e-12)


def test_standing_has_neither_efficiency_nor_irregularity():
    dut = make(np.arange(5.0), rows(5, yaw=np.arange(5.0)), goal=(3, 0, 0))
    assert math.isnan(value(dut, "path_efficiency"))
    assert math.isnan(value(dut, "path_irregularity"))
    assert value(dut, "spl") == 0
    at_goal = make(np.arange(5.0), rows(5), goal=(0, 0, 0))
    assert value(at_goal, "spl") == 1


def test_the_shortest_way_leads_around_walls():
    # A thin wall across the way, of half length 2, open to the left.
    walls = wall_through((2, -50), (2, 2))
    dut = along([(0, 0), (4, 0)], goal=(4, 0, 0), obstacles=walls, r=0.3)
    # The robot went through it, and was shorter than the shortest way.
    assert value(dut, "path_efficiency") == 1
    # One that walks around the corner at a distance of 1 m.
    points = [(0, 0), (1, 3), (3, 3), (4, 0)]
    dut = along(points, goal=(4, 0, 0), obstacles=walls, r=0.3)
    length = 2 * math.sqrt(10) + 2
    # Two tangents and an arc around the end of the wall.
    tangent = math.sqrt(8 - 0.3**2)
    arc = 2 * (PI / 4 + math.asin(0.3 / math.sqrt(8)))
    expected = (2 * tangent + 0.3 * arc) / length
    assert value(dut, "spl") == pytest.approx(expected)
    assert value(dut, "path_efficiency") == pytest.approx(expected)
    # Up, along the wall's end and down it turns; the way does less.
    turned = 2 * math.atan2(3, 1)
    before_and_after = math.atan2(3, 1) - arc / 2
    assert value(dut, "path_irregularity") == pytest.approx(
        (turned - arc - 2 * before_and_after) / length, abs=1e-12
    )


def with_slit(width, points, **kwargs):
    """Returns a robot beside a wall at x = 5 with a slit, open above y = 3."""
    walls = Obstacles.from_shapes(
        [[(5, -10), (5, -width / 2)], [(5, width / 2), (5, 3)]],
        solid=[False, False],
    )
    return along(points, obstacles=walls, **kwargs)


@pytest.mark.parametrize(
    ("width", "passes"), [(-0.1, 0), (0, 0), (0.05, 0), (0.6, 0), (0.72, 1)]
)
@pytest.mark.parametrize("goal", [(10, 0, 0), (5.1, 0, 0), (5.5, 0, 0)])
def test_the_shortest_way_leads_through_no_slit(width, passes, goal):
    dut = with_slit(width, [(0, 0), (5, 3.4), goal[:2]], goal=goal)
    straight = math.hypot(*goal[:2])
    around = math.hypot(5, 3) + math.hypot(goal[0] - 5, 3)
    spl = value(dut, "spl")
    if passes:
        assert spl == pytest.approx(straight / dut.path_features.length)
    else:
        # Taut around the end of the wall, with room for the robot.
        assert around / dut.path_features.length < spl <= 1
    assert value(dut, "path_efficiency") == pytest.approx(spl)


@pytest.mark.parametrize(("width", "needed"), [(0.05, True), (0.72, False)])
def test_no_one_needs_to_turn_around_what_is_passable(width, needed):
    points = [(0, 0), (1, 0), (5, 3.4), (9, 0), (10, 0)]
    dut = with_slit(width, points)
    turned = 4 * math.atan2(3.4, 4)
    irregularity = value(dut, "path_irregularity")
    if needed:
        assert irregularity * dut.path_features.length < 0.3 * turned
    else:
        assert irregularity == pytest.approx(turned / dut.path_features.length)


def test_the_shortest_way_may_begin_and_end_beside_walls():
    # The robot touches a wall at the start, and another at its goal.
    walls = (
        wall_through((-1, 0.1), (1, 0.1)),
        wall_through((4, -0.1), (6, -0.1)),
    )
    walls = Obstacles.from_shapes(
        [w.segments.reshape(2, 2) for w in walls], solid=[False, False]
    )
    dut = along([(0, 0), (5, 0)], goal=(5, 0, 0), obstacles=walls)
    assert value(dut, "spl") == pytest.approx(1)


def test_where_only_a_thinner_robot_passes_there_is_no_way():
    box = [(-2, -2), (2, -2), (2, -0.2), (2, 0.2), (2, 2), (-2, 2)]
    room = Obstacles.from_shapes(
        [box[:3], [*box[3:], box[0]]], solid=[False, False]
    )
    points, goal = [(0, 0), (4, 0)], (4, 0, 0)
    thin = along(points, goal=goal, obstacles=room, r=0.19)
    assert value(thin, "spl") == pytest.approx(1)
    thick = along(points, goal=goal, obstacles=room, r=0.25)
    for name in ("spl", "path_efficiency", "path_irregularity"):
        assert math.isnan(value(thick, name))


def test_no_way_to_the_goal_has_no_spl():
    box = wall_through((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
    dut = along([(0, 0), (4, 0)], goal=(4, 0, 0), obstacles=box)
    for name in ("spl", "path_efficiency", "path_irregularity"):
        assert math.isnan(value(dut, name))


def test_spl_is_0_short_of_the_goal_and_nothing_without():
    assert value(along([(0, 0), (3, 0)], goal=(4, 0, 0)), "spl") == 0
    assert math.isnan(value(along([(0, 0), (3, 0)]), "spl"))


def test_stl_is_the_least_time_over_that_to_the_goal():
    # 5 m at 1 m/s, and 2 s at the goal, by a robot that can do 1.5 m/s.
    t = np.linspace(0, 7, 71)
    x = np.minimum(t, 5.0)
    facts = {"goal": (5.0, 0, 0), "goal_tolerance": 0.05}
    dut = make(t, rows(71, x=x), robot_max_speed=1.5, **facts)
    assert value(dut, "stl") == pytest.approx((5 / 1.5) / 5)
    # Nobody is faster than the fastest.
    dut = make(t / 10, rows(71, x=x), robot_max_speed=1.5, **facts)
    assert value(dut, "stl") == 1
    assert math.isnan(value(make(t, rows(71, x=x), **facts), "stl"))
    short = make(t, rows(71, x=0.9 * x), robot_max_speed=1.5, **facts)
    assert value(short, "stl") == 0
    here = make(t, rows(71, x=5.0), robot_max_speed=1.5, **facts)
    assert value(here, "stl") == 1
    assert math.isnan(value(make(t, rows(71), robot_max_speed=1.5), "stl"))


def test_the_least_time_is_that_around_walls():
    walls = wall_through((2, -50), (2, 2))
    points = [(0, 0), (1, 3), (3, 3), (4, 0)]
    dut = along(points, goal=(4, 0, 0), obstacles=walls, r=0.3)
    dut = dataclasses.replace(dut, robot_max_speed=2.0)
    time = value(dut, "time_to_reach_goal")
    length = value(dut, "spl") * dut.path_features.length
    assert value(dut, "stl") == pytest.approx(length / 2 / time)


def smoothness(*points, yaw=0.0):
    p = np.array(points, dtype=float)
    dut = make(np.arange(len(p)), rows(len(p), p[:, 0], p[:, 1], yaw))
    names = (
        "angle_over_length",
        "cusps",
        "normalized_curvature",
        "max_curvature",
    )
    return [value(dut, name) for name in names]


def test_a_straight_path_is_smooth():
    x = np.linspace(0, 3, 31)
    assert smoothness(*zip(x, 2 * x, strict=True)) == pytest.approx([0] * 4)


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("samples", [51, 400, 5000])
@pytest.mark.parametrize("turn", [PI, 2 * PI])
def test_a_circle_has_the_curvature_of_its_radius(radius, samples, turn):
    angle = np.linspace(0, turn, samples)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    aol, cusps, total, most = smoothness(*zip(x, y, strict=True))
    # The path turns between its first leg and its last, of 5 cm or a sample.
    leg = max(0.05, turn * radius / (samples - 1))
    assert aol == pytest.approx(1 / radius, rel=2 * leg / (turn * radius))
    assert cusps == 0
    assert most == pytest.approx(1 / radius)
    # Up to its ends, it turns by the whole angle.
    assert total == pytest.approx(turn, rel=0.01)


def test_smoothness_is_that_of_the_way_back():
    t = np.linspace(0, 12, 300)
    way = np.column_stack([1.5 * np.sin(t / 2), 1.5 * np.cos(t / 3)])
    there, back = smoothness(*way), smoothness(*way[::-1])
    assert there[1] == back[1]
    assert there == pytest.approx(back, rel=0.02)


def test_noise_of_a_millimeter_is_no_cusp():
    rng = np.random.default_rng(0)
    x, noise = np.linspace(0, 4, 2001), rng.normal(0, 1e-3, 2001)
    aol, cusps, total, most = smoothness(*zip(x, noise, strict=True))
    assert cusps == 0
    # Each leg of 5 cm is a few hundredths of a radian off its direction.
    assert aol < 1
    assert total < 0.1
    assert most < 0.1


def test_a_corner_of_the_path_is_angle_and_curvature():
    legs = [(0.5 * k, 0) for k in range(5)]
    legs += [(2 + 0.5 * k * 0.8, 0.5 * k * 0.6) for k in range(1, 5)]
    turn = math.atan2(0.6, 0.8)
    aol, cusps, total, most = smoothness(*legs)
    assert aol == pytest.approx(turn / 4)
    assert cusps == 0
    # The circle through the corner and the points 0.5 m beside.
    circle = 2 * math.sin(turn / 2) / 0.5
    assert most == pytest.approx(circle)
    assert total == pytest.approx(circle * 0.5)


def test_a_reversal_is_a_cusp_and_no_curvature():
    back = [(k / 10, 0) for k in range(21)] + [(2 - k / 10, 0) for k in (1, 9)]
    assert smoothness(*back) == pytest.approx([PI / 2.9, 1, 0, 0])
    # To turn on the spot or to stand is no path.
    on_the_spot = smoothness(*[(1, 1)] * 9, yaw=np.arange(9.0))
    assert math.isnan(on_the_spot[0])
    assert on_the_spot[1:] == [0, 0, 0]


def test_smoothness_does_not_hang_on_the_speed_or_the_sampling():
    angle = np.linspace(0, PI, 1001) ** 2 / PI
    fine = smoothness(*zip(np.cos(angle), np.sin(angle), strict=True))
    angle = np.linspace(0, PI, 501)
    even = smoothness(*zip(np.cos(angle), np.sin(angle), strict=True))
    assert fine == pytest.approx(even, rel=0.02)


def test_stalled_time_is_that_of_getting_nowhere():
    x = [0, 0, 0.1, 0.1, 0.1, 2.0, 2.0]
    t = np.array([0, 1, 2, 4, 5, 6, 9.0])
    robot = rows(7, x=np.array(x), yaw=np.arange(7.0))
    dut = make(t, robot, goal=(2, 0, 0))
    assert value(dut, "stalled_time") == pytest.approx(1 + 2 + 1)
    steps = compute_steps(dut, ["stalled_time"])["stalled_time"]
    assert steps.tolist() == [0, 1, 0, 2, 1, 0, 0]
    assert value(make(t, robot), "stalled_time") == pytest.approx(7)


def test_clearance_of_a_corridor():
    walls = Obstacles.from_shapes(
        [[(-9, 1), (9, 1)], [(-9, -2), (9, -2)]], solid=[False, False]
    )
    dut = along([(0, 0), (4, 0)], obstacles=walls)
    assert value(dut, "min_clearance") == pytest.approx(1 - R)
    assert value(dut, "avg_clearance") == pytest.approx(1 - R)
    assert value(dut, "static_obstacle_collisions") == 0


def test_walls_are_touched_once_per_contact():
    y = np.array([0.0, 0.63, 0.64, 0.7, 0.0, 0.62, 0.631])
    dut = make(
        np.arange(7.0), rows(7, y=y), obstacles=wall_through((-9, 1), (9, 1))
    )
    # A gap of 0.02 m is none.
    assert value(dut, "static_obstacle_collisions") == 2
    assert value(dut, "min_clearance") == 0
    steps = compute_steps(dut, ["static_obstacle_collisions"]).iloc[:, 0]
    assert steps.tolist() == [0, 0, 1, 1, 0, 0, 1]


def test_inside_of_a_solid_there_is_no_clearance():
    box = [[(-5, -5), (5, -5), (5, 5), (-5, 5)]]
    dut = along(
        [(-8, 0), (0, 0)], obstacles=Obstacles.from_shapes(box, solid=[True])
    )
    assert dut.path_features.wall_gap[-1] == 0
    assert value(dut, "static_obstacle_collisions") == 1


def test_near_points_stand_in_for_walls():
    near = np.full((3, 1, 2, 2), np.nan)
    near[1, 0, 0] = (0, 1)
    dut = make(np.arange(3.0), rows(3), nearest_walls=near)
    assert value(dut, "min_clearance") == pytest.approx(1 - R)
    assert np.isnan(dut.path_features.wall_gap).tolist() == [True, False, True]


def head_on(offset=0.0, samples=3):
    """Robot and person at 1 m/s towards each other, 10 m apart."""
    t = np.arange(samples) * 0.5
    return make(
        t,
        rows(samples, x=t, vx=1.0),
        [rows(samples, x=10 - t, y=offset, yaw=PI, vx=-1.0)],
    )


def test_time_to_a_head_on_collision():
    dut = head_on()
    steps = compute_steps(dut, ["min_time_to_collision"]).iloc[:, 0]
    expected = (10 - 2 * R) / 2 - dut.times
    assert steps.to_numpy() == pytest.approx(expected)
    assert value(dut, "min_time_to_collision") == pytest.approx(expected[-1])


def test_time_to_a_collision_off_the_center():
    # They touch where the distance along the way is sqrt(0.7^2 - 0.42^2).
    assert value(head_on(0.42, 1), "min_time_to_collision") == pytest.approx(
        (10 - 0.56) / 2
    )


@pytest.mark.parametrize("offset", [0.7001, -5.0])
def test_who_passes_has_no_time_to_collision(offset):
    assert math.isnan(value(head_on(offset), "min_time_to_collision"))


def test_who_departs_has_no_time_to_collision_but_who_touches_has_0():
    leaving = make([0.0], rows(1, vx=-1.0), [rows(1, x=2.0, vx=1.0)])
    assert math.isnan(value(leaving, "min_time_to_collision"))
    touching = make([0.0], rows(1, vx=-1.0), [rows(1, x=0.7, vx=1.0)])
    assert value(touching, "min_time_to_collision") == 0


def test_fear_is_the_speed_over_the_distance():
    dut = head_on(samples=3)
    expected = [2 / 10, 2 / 9, 2 / 8]
    steps = compute_steps(dut, ["danger_fear_cost"]).iloc[:, 0]
    assert steps.to_numpy() == pytest.approx(expected)
    assert value(dut, "danger_fear_cost") == pytest.approx(sum(expected))
    rate = value(dut, "danger_fear_cost_rate")
    # The time average goes straight from sample to sample.
    assert rate == pytest.approx((2 / 10 + 2 * 2 / 9 + 2 / 8) / 4)
    assert value(dut, "danger_panic_cost") == 0
    away = make([0.0], rows(1, vx=-1.0), [rows(1, x=2.0)])
    assert value(away, "danger_fear_cost") == 0


def test_panic_is_at_who_passes_closely():
    # At (3, 4) with the velocity along x: passes at 4 m, sine 4/5.
    dut = make([0.0], rows(1, vx=1.5), [rows(1, x=3.0, y=4.0)])
    expected = 1.5 / ((4 - 2 * R) * 0.8)
    assert value(dut, "danger_panic_cost") == pytest.approx(expected)
    still = make([0.0], rows(1), [rows(1, x=3.0, y=4.0)])
    assert value(still, "danger_panic_cost") == 0


def test_nobody_panics_at_a_robot_that_recedes():
    # It passes at 4 m, from 3 m before to 3 m after.
    x = np.linspace(0, 6, 13)
    dut = make(np.arange(13.0), rows(13, x, vx=1.5), [rows(13, x=3.0, y=4.0)])
    steps = compute_steps(dut, ["danger_panic_cost"]).iloc[:, 0].to_numpy()
    before = np.arange(13) < 6
    sine = 4 / np.hypot(3 - x, 4)
    expected = np.where(before, 1.5 / ((4 - 2 * R) * sine), 0.0)
    assert steps == pytest.approx(expected)
    away = make([0.0], rows(1, vx=-1.5), [rows(1, x=3.0, y=4.0)])
    assert value(away, "danger_panic_cost") == 0


@pytest.mark.parametrize(
    ("distance", "counts"), [(0.03, 0.05), (0.0499, 0.05), (0.06, 0.06)]
)
def test_fear_and_surprise_are_bounded_at_5_cm(distance, counts):
    human = rows(1, x=distance, yaw=PI + PI / 6)
    dut = make([0.0], rows(1, vx=1.5), [human])
    assert value(dut, "danger_fear_cost") == pytest.approx(1.5 / counts)
    expected = 0.45 / counts * 0.5
    got = value(dut, "surprise_visibility_cost")
    assert got == pytest.approx(expected)


@pytest.mark.parametrize(
    ("miss", "counts"), [(0.001, 0.05), (0.03, 0.05), (0.06, 0.06)]
)
def test_panic_is_bounded_at_5_cm(miss, counts):
    # It passes at a right angle in a moment, so the sine is 1.
    human = rows(1, x=1e-9, y=2 * R + miss)
    dut = make([0.0], rows(1, vx=1.5), [human])
    assert value(dut, "danger_panic_cost") == pytest.approx(1.5 / counts)


def test_what_depends_on_walls_has_no_value_without_them():
    humans = [rows(81, x=5.0, yaw=PI + 0.5)]
    known = along([(0, 0), (4, 0)], humans=humans, goal=(4, 0, 0))
    dut = dataclasses.replace(known, walls_known=False)
    without = compute_metrics(dut)
    lost = {
        *("min_clearance", "avg_clearance", "static_obstacle_collisions"),
        *("path_irregularity", "path_efficiency"),
        *("success_weighted_path_length", "success_weighted_time_length"),
    } | {
        name + end
        for name in (
            *("obstacle_force_on_agents", "obstacle_force_on_robot"),
            *("social_work", "surprise_visibility_cost"),
            *("surprise_shock_cost", "surprise_react_cost"),
        )
        for end in ("", "_rate")
    }
    assert without[list(lost)].isna().all()
    others = [name for name in without.index if name not in lost]
    with_walls = compute_metrics(known)
    assert without[others].equals(with_walls[others])
    # Near points tell of forces and gaps, but not of ways and sight.
    near = np.full((81, 2, 1, 2), np.nan)
    dut = dataclasses.replace(dut, nearest_walls=near)
    values = compute_metrics(dut)
    assert values["static_obstacle_collisions"] == 0
    assert values["obstacle_force_on_robot"] == 0
    assert values["social_work"] == with_walls["social_work"]
    assert math.isnan(values["path_efficiency"])
    assert math.isnan(values["surprise_shock_cost"])


def test_a_rate_does_not_depend_on_the_sampling():
    def drive(t):
        robot = rows(len(t), x=t, vx=1.0)
        human = rows(len(t), x=20.0, yaw=PI)
        return make(t, robot, [human])

    even = np.linspace(0, 10, 201)
    dense = np.unique(np.r_[np.arange(0, 10.1, 0.5), np.arange(4, 6, 0.02)])
    for name in ("danger_fear_cost", "social_force_on_agents"):
        a, b = (value(drive(t), f"{name}_rate") for t in (even, dense))
        assert a == pytest.approx(b, rel=0.02), name
        a, b = (value(drive(t), name) for t in (even, dense))
        assert a != pytest.approx(b, rel=0.1), name
    # 1 / (20 - t) from 0 to 10.
    rate = value(drive(even), "danger_fear_cost_rate")
    assert rate == pytest.approx(math.log(2) / 10, rel=1e-4)


def test_a_rate_leaves_out_what_has_no_value():
    series = np.array([np.nan, 1, 3, np.nan, 100, np.nan])
    times = np.array([0, 1, 4, 5, 6, 7.0])
    assert reduce.time_average(series, times) == 2
    alone = np.array([np.nan, 4, np.nan])
    assert math.isnan(reduce.time_average(alone, np.arange(3.0)))
    assert math.isnan(reduce.time_average(alone[:1], np.zeros(1)))


def test_visibility_grows_to_the_edge_of_view():
    def cost(degrees):
        human = rows(1, x=2.0, yaw=PI + math.radians(degrees))
        return value(make([0.0], rows(1), [human]), "surprise_visibility_cost")

    assert cost(0) == pytest.approx(0, abs=1e-12)
    assert cost(30) == pytest.approx(0.45 / 2 * 30 / 60)
    assert cost(-59.9) == pytest.approx(0.45 / 2 * 59.9 / 60)
    assert cost(60.1) == 0
    assert cost(180) == 0


def test_walls_hide_the_robot():
    human = rows(1, x=2.0, yaw=PI + 0.5)
    name = "surprise_visibility_cost"
    hidden = make(
        [0.0], rows(1), [human], obstacles=wall_through((1, -1), (1, 1))
    )
    assert value(hidden, name) == 0
    beside = make(
        [0.0], rows(1), [human], obstacles=wall_through((1, 1), (1, 2))
    )
    assert value(beside, name) > 0


def test_surprise_fades_while_the_robot_is_seen():
    t = np.arange(10) * 0.1
    # It comes around the corner, into view, at 0.2 s.
    yaw = np.where(t < 0.15, 0.0, PI)
    dut = make(t, rows(10), [rows(10, x=3.0, yaw=yaw)])
    seen = t - 0.2
    in_view = t > 0.15
    for name, span in (("shock", 0.15), ("react", 0.6)):
        expected = in_view * 0.45 / 3 * np.maximum(0, 1 - seen / span)
        got = compute_steps(dut, [f"surprise_{name}_cost"]).iloc[:, 0]
        assert got.to_numpy() == pytest.approx(expected, abs=1e-12), name


def test_what_is_in_view_from_the_start_is_no_surprise():
    dut = make(np.arange(9) * 0.1, rows(9), [rows(9, x=3.0, yaw=PI)])
    assert value(dut, "surprise_shock_cost") == 0
    assert value(dut, "surprise_react_cost") == 0
    # Nor is it to people who arrive and see it at once.
    human = rows(9, x=3.0, yaw=PI)
    human[:4] = np.nan
    dut = make(np.arange(9) * 0.1, rows(9), [human])
    assert value(dut, "surprise_shock_cost") == 0
    assert value(dut, "surprise_react_cost") == 0


@pytest.mark.parametrize(
    ("x", "rel"), [(20.0, 1e-9), (3.3, 1e-9), (100.0, 1e-9), (3e6, 1e-4)]
)
def test_turns_do_not_depend_on_the_place_of_steps_of_just_5_cm(x, rel):
    """As those of a robot at 0.5 m/s, ten times per second."""
    angle = 2 * math.asin(0.025) * np.arange(120)
    t, circle = 0.1 * np.arange(120), (np.cos(angle), np.sin(angle))
    here = make(t, rows(120, x=circle[0], y=circle[1]))
    there = make(t, rows(120, x=circle[0] + x, y=circle[1] - 0.3 * x))
    for name in ("angle_over_length", "normalized_curvature"):
        assert value(there, name) == pytest.approx(value(here, name), rel=rel)


def test_space_compliance():
    gap = np.array([0.2, 0.499, 0.501, 3.0])
    dut = make(np.arange(4.0), rows(4), [rows(4, x=gap + 2 * R)])
    assert value(dut, "space_compliance") == 50
    human = rows(4, x=gap + 2 * R)
    human[3] = np.nan
    dut = make(np.arange(4.0), rows(4), [human])
    assert value(dut, "space_compliance") == pytest.approx(100 / 3)


def test_displacement_of_a_parallel_path():
    dut = along([(0, 1), (4, 1)])
    reference = along([(0, 0), (4, 0)])
    dut = dut.compared_with(reference)
    for name in ("ade", "fde", "adtw"):
        assert value(dut, name) == pytest.approx(1.0)
    same = reference.compared_with(reference)
    for name in ("ade", "fde", "adtw"):
        assert value(same, name) == pytest.approx(0.0, abs=1e-12)


def test_displacement_of_who_is_late_is_not_warped():
    # The robot drives at half the speed of its reference, on the same path.
    fast = along([(0, 0), (4, 0)], step=0.05)
    t = np.arange(81) * 0.1
    slow = make(t, rows(81, x=0.5 * t)).compared_with(fast)
    # It is behind by t / 2 up to 4 s, then catches up until 8 s.
    assert value(slow, "ade") == pytest.approx(80 / 81, rel=1e-9)
    assert value(slow, "fde") == pytest.approx(0, abs=1e-12)
    assert value(slow, "adtw") == pytest.approx(0, abs=1e-12)


def test_the_reference_has_its_own_clock_and_rests_in_the_end():
    reference = np.array([[7.0, 0, 0], [8.0, 2, 0]])
    got = displacement(np.array([100, 100.5, 103]), np.zeros((3, 2)), reference)
    assert got == pytest.approx([0, 1, 2])


def test_warping_is_in_the_order_of_both():
    line = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0]])
    # The shorter path is matched whole; the longer may have rests.
    beside = np.array([[0.0, 1], [1, 1]])
    assert warped_distance(beside, line) == pytest.approx(1.0)
    assert warped_distance(line, beside) == pytest.approx(1.0)
    # Against the order all but one have to be matched far off.
    there = np.array([[0.0, 0], [2, 0]])
    assert warped_distance(there[::-1] * 0.999, line) > 0.4
    point = np.array([[1.0, 2.0]])
    assert warped_distance(point, line) == pytest.approx(2.0)
    assert warped_distance(point, point) == 0


def test_finer_points_of_the_longer_path_do_not_matter():
    rng = np.random.default_rng(2)
    longer = np.cumsum(rng.normal(size=(12, 2)), axis=0)
    middle = (longer[1:] + longer[:-1]) / 2
    finer = np.empty((23, 2))
    finer[::2], finer[1::2] = longer, middle
    shorter = 0.1 * longer[:7]
    assert warped_distance(shorter, finer) == pytest.approx(
        warped_distance(shorter, longer), rel=1e-9
    )


def test_who_circles_another_winds_once_a_turn():
    angle = np.linspace(0, 2 * PI * 3, 400)
    t = np.linspace(0, 10, 400)
    for sign in (1, -1):
        robot = rows(400, np.cos(angle), sign * np.sin(angle))
        dut = make(t, robot, [rows(400)])
        assert value(dut, "topological_complexity") == pytest.approx(3)


def test_passing_from_far_to_far_is_half_a_turn():
    x = np.linspace(-1e5, 1e5, 201)
    dut = make(np.linspace(0, 10, 201), rows(201, x), [rows(201, -x, 1.0)])
    assert value(dut, "topological_complexity") == pytest.approx(0.5, abs=1e-4)


def test_winding_is_summed_over_all_pairs():
    angle = np.linspace(0, 2 * PI, 100)
    t = np.linspace(0, 10, 100)
    ring = [rows(100, np.cos(angle + a), np.sin(angle + a)) for a in (0, 2, 4)]
    dut = make(t, ring[0], ring[1:])
    # Three bodies that turn around a common center: three pairs.
    assert value(dut, "topological_complexity") == pytest.approx(3)


def test_nobody_winds_around_who_is_away():
    angle = np.linspace(0, 2 * PI, 101)
    human = rows(101)
    human[26:75] = np.nan
    robot = rows(101, np.cos(angle), np.sin(angle))
    dut = make(np.linspace(0, 10, 101), robot, [human])
    # A quarter until they part, and 25 of 100 steps from then on.
    assert value(dut, "topological_complexity") == pytest.approx(0.5)


def test_behaviors_have_the_same_way():
    """What has to do with the robot alone is the same for all behaviors."""
    dut = along(
        [(0, 0), (3, 0), (3, 4)],
        humans=[rows(142, y=2.0), rows(142, y=5.0)],
        behaviors=("a", "b"),
        goal=(3, 4, 0),
        robot_max_speed=1.0,
        obstacles=wall_through((1, 1), (2, 2)),
    )
    table = compute_by_behavior(dut, ["efficiency", "clearance"])
    whole = compute_metrics(dut, ["efficiency", "clearance"])
    for behavior in "ab":
        assert table.loc[behavior].to_numpy() == pytest.approx(whole.to_numpy())
