"""Metrics whose value can be worked out by hand."""

import dataclasses
import math

import numpy as np
import pytest

from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.crowd.social_force.numpy_forces import (
    obstacle_force,
    pair_force,
)
from hunav_drake.systems.evaluation.compute import (
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles, nearest_points
from tests.systems.evaluation.trials import R, make, rows


def times_to(duration, dt=0.1):
    return np.arange(round(duration / dt) + 1) * dt


def drive_straight(speed=0.5, duration=4.0, **kwargs):
    t = times_to(duration)
    return make(t, rows(len(t), x=speed * t, vx=speed), **kwargs)


def test_straight_line():
    v = compute_metrics(
        drive_straight(goal=(2.0, 1.0, 0.0), goal_tolerance=0.2)
    )
    assert v["path_length"] == pytest.approx(2.0)
    assert v["duration"] == pytest.approx(4.0)
    assert v["cumulative_heading_changes"] == 0
    assert v["avg_robot_linear_speed"] == pytest.approx(0.5)
    assert v["avg_robot_angular_speed"] == 0
    assert v["avg_robot_acceleration"] == 0
    assert v["avg_robot_jerk"] == 0
    assert v["time_not_moving"] == 0
    assert v["min_dist_to_target"] == pytest.approx(1.0)
    assert v["final_dist_to_target"] == pytest.approx(1.0)
    assert v["completed"] == 0
    assert math.isnan(v["time_to_reach_goal"])


def test_standstill():
    t = times_to(5.0)
    v = compute_metrics(make(t, rows(len(t), vx=0.0099, omega=-0.0199)))
    assert v["time_not_moving"] == pytest.approx(5.0)
    assert v["path_length"] == 0
    for moving in ({"vx": 0.0101}, {"omega": -0.0201}, {"vx": -0.0101}):
        v = compute_metrics(make(t, rows(len(t), **moving)))
        assert v["time_not_moving"] == 0


def test_time_not_moving_counts_intervals_still_at_both_ends():
    t = np.array([0.0, 0.1, 0.3, 0.6, 1.0, 1.5])
    robot = rows(6, vx=[0.5, 0.0, 0.0, 0.0, 0.5, 0.0])
    recording = make(t, robot)
    assert compute_metrics(recording)["time_not_moving"] == pytest.approx(0.5)
    steps = compute_steps(recording)["time_not_moving"]
    assert steps.to_numpy() == pytest.approx([0, 0, 0.2, 0.3, 0, 0])


def test_circle():
    t = times_to(60.0, 0.01)
    omega = 2 * math.pi / 60
    yaw = omega * t
    robot = rows(
        len(t),
        x=np.sin(yaw),
        y=-np.cos(yaw),
        # The heading is given in [-pi, pi], so it jumps once.
        yaw=np.arctan2(np.sin(yaw), np.cos(yaw)),
        vx=omega * np.cos(yaw),
        vy=omega * np.sin(yaw),
        omega=omega,
    )
    v = compute_metrics(make(t, robot))
    # The chords of a circle of radius 1 m.
    chords = 6000 * 2 * math.sin(omega * 0.01 / 2)
    assert v["path_length"] == pytest.approx(chords, rel=1e-12)
    assert v["path_length"] == pytest.approx(2 * math.pi, rel=1e-6)
    assert v["cumulative_heading_changes"] == pytest.approx(2 * math.pi)
    assert v["avg_robot_linear_speed"] == pytest.approx(omega)
    assert v["avg_robot_angular_speed"] == pytest.approx(omega)
    assert v["avg_robot_acceleration"] == pytest.approx(0, abs=1e-12)


def test_turning_to_and_fro_adds_up():
    v = compute_metrics(make(times_to(0.3), rows(4, yaw=[0, 0.5, -0.5, 0])))
    assert v["cumulative_heading_changes"] == pytest.approx(2.0)


def test_backwards_is_negative():
    t = times_to(1.0)
    v = compute_metrics(
        make(t, rows(len(t), yaw=math.pi / 2, vy=-0.3, omega=-0.2))
    )
    assert v["avg_robot_linear_speed"] == pytest.approx(-0.3)
    assert v["avg_robot_angular_speed"] == pytest.approx(0.2)
    assert v["time_not_moving"] == 0


def test_constant_acceleration():
    t = np.array([0.0, 0.1, 0.3, 0.6, 1.0])
    v = compute_metrics(make(t, rows(5, x=0.4 * t**2, vx=0.8 * t)))
    assert v["avg_robot_acceleration"] == pytest.approx(0.8)
    assert v["avg_robot_jerk"] == pytest.approx(0, abs=1e-12)


def test_constant_jerk_whatever_the_intervals():
    for t in (times_to(2.0), np.array([0.0, 0.1, 0.3, 0.6, 1.0])):
        v = compute_metrics(make(t, rows(len(t), vx=0.3 * t**2)))
        # The mean acceleration of an interval is that of its middle.
        assert v["avg_robot_jerk"] == pytest.approx(0.6)


def test_braking_and_speeding_up_make_jerk():
    v = compute_metrics(make([0.0, 1.0, 2.0], rows(3, vx=[1.0, 0.0, 1.0])))
    assert v["avg_robot_acceleration"] == 1
    assert v["avg_robot_jerk"] == 2
    steps = compute_steps(make([0.0, 1.0, 2.0], rows(3, vx=[1.0, 0.0, 1.0])))
    assert steps["avg_robot_acceleration"].to_numpy() == pytest.approx(
        [np.nan, 1, 1], nan_ok=True
    )
    assert steps["avg_robot_jerk"].to_numpy() == pytest.approx(
        [np.nan, np.nan, 2], nan_ok=True
    )


def test_the_goal_is_reached_at_the_first_sample_within_tolerance():
    # It passes the goal's tolerance of 0.2 m after 1.8 m, exclusively.
    recording = drive_straight(goal=(2.0, 0.0, 0.0), goal_tolerance=0.2001)
    v = compute_metrics(recording)
    assert v["completed"] == 1
    assert v["time_to_reach_goal"] == pytest.approx(3.6)
    v = compute_metrics(
        drive_straight(goal=(2.0, 0.0, 0.0), goal_tolerance=0.1999)
    )
    assert v["time_to_reach_goal"] == pytest.approx(3.7)
    steps = compute_steps(recording)
    assert steps["final_dist_to_target"].iloc[0] == pytest.approx(2.0)


def test_a_goal_that_was_left_again_is_not_completed():
    v = compute_metrics(drive_straight(goal=(1.0, 0.0, 0.0)))
    assert v["time_to_reach_goal"] == pytest.approx(1.6)
    assert v["completed"] == 0
    assert v["min_dist_to_target"] == pytest.approx(0, abs=1e-9)
    assert v["final_dist_to_target"] == pytest.approx(1.0)


@pytest.mark.parametrize(("yaw", "done"), [(0.2, 1), (0.3, 0), (-0.2, 1)])
def test_the_heading_belongs_to_the_goal(yaw, done):
    goal = (2.0, 0.0, yaw + 2 * math.pi)
    v = compute_metrics(drive_straight(goal=goal, goal_yaw_tolerance=0.25))
    assert v["completed"] == done
    assert compute_metrics(drive_straight(goal=goal))["completed"] == 1


def test_distance_to_someone_standing_abreast():
    t = times_to(4.0)
    robot = rows(len(t), x=t - 2, vx=1.0)
    person = rows(len(t), y=1.5, r=0.4)
    far = rows(len(t), y=30.0)
    recording = make(t, robot, [far, person])
    gap = np.hypot(t - 2, 1.5) - 0.75
    v = compute_metrics(recording)
    assert v["min_dist_to_people"] == pytest.approx(0.75)
    assert v["avg_dist_to_closest_person"] == pytest.approx(gap.mean())
    assert v["max_dist_to_people"] == pytest.approx(math.hypot(2, 30) - 0.7)
    steps = compute_steps(recording)["avg_dist_to_closest_person"]
    assert steps.to_numpy() == pytest.approx(gap)


def test_overlapping_bodies_have_no_gap():
    v = compute_metrics(make([0.0], rows(1), [rows(1, x=0.3)]))
    assert v["min_dist_to_people"] == 0
    assert v["intimate_space_intrusions"] == 100


@pytest.mark.parametrize(
    ("gap", "space"),
    [
        (0.0, "intimate"),
        (0.4499, "intimate"),
        (0.4501, "personal"),
        (1.1999, "personal"),
        (1.2001, "social+"),
        (3.5999, "social+"),
        (3.6001, "public"),
        (50.0, "public"),
    ],
)
def test_spaces(gap, space):
    v = compute_metrics(make([0.0], rows(1), [rows(1, x=0.7 + gap)]))
    shares = {
        name: v[f"{name}_space_intrusions"]
        for name in ("intimate", "personal", "social+", "public")
    }
    assert shares == dict.fromkeys(shares, 0.0) | {space: 100.0}
    for name in ("intimate", "personal", "social+"):
        assert math.isnan(v[f"group_{name}_space_intrusions"])


def test_share_of_samples_in_a_space():
    # The gap grows by 0.1 m a sample, from 0.07 m.
    x = 0.77 + 0.1 * np.arange(40)
    v = compute_metrics(make(np.arange(40.0), rows(40), [rows(40, x=x)]))
    assert v["intimate_space_intrusions"] == pytest.approx(100 * 4 / 40)
    assert v["personal_space_intrusions"] == pytest.approx(100 * 8 / 40)
    assert v["social+_space_intrusions"] == pytest.approx(100 * 24 / 40)
    assert v["public_space_intrusions"] == pytest.approx(100 * 4 / 40)


def group_values(distance, **kwargs):
    """Two people 3 m apart look at each other: their center is between."""
    a = rows(1, x=-1.5, yaw=0.0)
    b = rows(1, x=1.5, yaw=math.pi)
    settings = {"group_ids": (4, 4)} | kwargs
    return compute_metrics(make([0.0], rows(1, y=distance), [a, b], **settings))


@pytest.mark.parametrize(
    ("gap", "space"), [(0.44, "intimate"), (0.46, "personal"), (1.3, "social+")]
)
def test_spaces_of_a_group_are_around_what_it_looks_at(gap, space):
    v = group_values(R + gap)
    for name in ("intimate", "personal", "social+"):
        expected = 100 if name == space else 0
        assert v[f"group_{name}_space_intrusions"] == expected


def test_one_person_is_no_group():
    v = group_values(1.0, group_ids=(4, 5))
    assert math.isnan(v["group_personal_space_intrusions"])


def test_the_closest_group_counts():
    people = [rows(1, x=x, yaw=yaw) for x in (-1.5, 8.5) for yaw in (0.0, 0.0)]
    v = compute_metrics(
        make([0.0], rows(1, y=0.5), people, group_ids=(1, 1, 2, 2))
    )
    assert v["group_intimate_space_intrusions"] == 100


def approach(v_robot, v_person, **kwargs):
    """Robot and person meet head on after 1 s, then stay in contact."""
    t = times_to(2.0)
    meet = np.minimum(t, 1.0)
    robot = rows(len(t), x=v_robot * meet, vx=v_robot)
    start = 2 * R + v_robot + v_person
    person = rows(len(t), x=start - v_person * meet, vx=-v_person, **kwargs)
    return make(t, robot, [person])


@pytest.mark.parametrize(
    ("v_robot", "v_person", "robot", "person"),
    [
        (0.8, 0.5, 1, 0),
        (0.5, 0.8, 0, 1),
        (0.5, 0.5, 1, 1),
        # Equal but for rounding, and just not.
        (0.5 + 9e-7, 0.5, 1, 1),
        (0.5, 0.5 + 9e-7, 1, 1),
        (0.5 + 1.1e-6, 0.5, 1, 0),
        (0.5, 0.5 + 1.1e-6, 0, 1),
        (0.5, 0.0, 1, 0),
        (0.0, 1.0, 0, 1),
    ],
)
def test_a_collision_is_charged_to_the_faster(v_robot, v_person, robot, person):
    recording = approach(v_robot, v_person)
    v = compute_metrics(recording)
    assert v["robot_on_person_collisions"] == robot
    assert v["person_on_robot_collisions"] == person
    steps = compute_steps(recording, ["collisions"])
    # In contact from 1 s to 2 s, at either end.
    assert steps["robot_on_person_collisions"].sum() == 11 * robot
    assert steps["person_on_robot_collisions"].sum() == 11 * person


def test_a_robot_hit_from_behind_is_not_to_blame():
    t = times_to(2.0)
    x = np.minimum(0.5 + 0.2 * t, 2.0)
    robot = rows(len(t), x=x, vx=0.2)
    person = rows(len(t), x=np.minimum(-2.0 + 2 * t, x - 0.7), vx=2.0)
    v = compute_metrics(make(t, robot, [person]))
    assert v["robot_on_person_collisions"] == 0
    assert v["person_on_robot_collisions"] == 1


@pytest.mark.parametrize(
    ("gap", "contacts"), [(0.0201, 0), (0.0199, 1), (0.0, 1)]
)
def test_tangent_contact(gap, contacts):
    """The robot passes a person at a constant gap at the closest."""
    t = times_to(2.0)
    robot = rows(len(t), x=t - 1.0, vx=1.0)
    v = compute_metrics(make(t, robot, [rows(len(t), y=0.7 + gap)]))
    total = v["robot_on_person_collisions"] + v["person_on_robot_collisions"]
    # At the very tangent nobody closes in, but one sample before somebody did.
    assert total == (1 if gap < 0.015 else 0)
    contact = make(t, robot, [rows(len(t), y=0.7 + gap)]).features.contact
    assert contact.any() == bool(contacts)


def test_each_contact_is_an_event_of_its_own():
    t = np.arange(6.0)
    near, far = 0.7, 1.5
    x = np.array([far, near, near, far, near, far])
    recording = make(t, rows(6, vx=1.0), [rows(6, x=x), rows(6, x=-far)])
    assert compute_metrics(recording)["robot_on_person_collisions"] == 2
    steps = compute_steps(recording, ["robot_on_person_collisions"])
    assert steps.iloc[:, 0].tolist() == [0, 1, 1, 0, 1, 0]


def test_a_contact_at_the_start_is_a_collision():
    v = compute_metrics(make([0.0, 1.0], rows(2, vx=1.0), [rows(2, x=0.6)]))
    assert v["robot_on_person_collisions"] == 1


def test_who_stands_inside_the_robot_is_a_contact_of_nobody():
    v = compute_metrics(make([0.0], rows(1, vx=1.0), [rows(1)]))
    assert v["robot_on_person_collisions"] == 0
    assert v["person_on_robot_collisions"] == 0
    assert np.isfinite(v["social_work"])


def test_speeds_of_people():
    t = times_to(1.0)
    slow = rows(len(t), x=1.0, vx=0.3, vy=0.4)
    fast = rows(len(t), x=5.0, vy=-1.5)
    v = compute_metrics(make(t, rows(len(t)), [fast, slow]))
    assert v["avg_pedestrian_velocity"] == pytest.approx(1.0)
    assert v["avg_closest_pedestrian_velocity"] == pytest.approx(0.5)


def test_the_closest_person_is_by_the_center():
    thin = rows(1, x=2.0, vx=0.1, r=0.1)
    wide = rows(1, x=2.2, vx=0.9, r=0.9)
    v = compute_metrics(make([0.0], rows(1), [wide, thin]))
    assert v["avg_closest_pedestrian_velocity"] == pytest.approx(0.1)
    assert v["min_dist_to_people"] == pytest.approx(2.2 - 0.9 - R)


def test_social_force_between_two_who_stand():
    # At rest the interaction has the direction of the other, so B = gamma and
    # theta = 0, which leaves k_s exp(-r / gamma).
    v = compute_metrics(make([0.0, 1.0], rows(2), [rows(2, x=0.6, y=0.8)]))
    force = 2.1 * math.exp(-1.0 / 0.35)
    assert v["social_force_on_agents"] == pytest.approx(2 * force)
    assert v["social_force_on_robot"] == pytest.approx(2 * force)
    assert v["social_work"] == pytest.approx(4 * force)
    assert v["social_force_on_agents_rate"] == pytest.approx(force)
    assert v["social_work_rate"] == pytest.approx(2 * force)


def test_social_forces_are_those_of_the_crowd_with_the_metrics_constants():
    rng = np.random.default_rng(1)
    robot = rng.normal(size=(9, 7)) ** 2
    humans = rng.normal(size=(9, 4, 7)) ** 2
    parameters = SocialForceParameters(social_factor=2.1, epsilon=0.0)
    offset = np.moveaxis(robot[:, None] - humans, -1, 0)
    on_people = pair_force(*offset[:2], *-offset[3:5], parameters)
    recording = make(np.arange(9.0), robot, [humans[:, i] for i in range(4)])
    steps = compute_steps(recording)["social_force_on_agents"]
    expected = np.hypot(*on_people).sum(axis=1)
    assert steps.to_numpy() == pytest.approx(expected, rel=1e-12)


def test_obstacle_force_of_one_wall():
    wall = Obstacles.from_shapes([[[-9, 1], [9, 1]]], solid=[False])
    near, far = rows(2, y=0.5, r=0.4), rows(2, y=-50.0)
    v = compute_metrics(make([0.0, 1.0], rows(2), [near, far], obstacles=wall))
    on_robot = 10 * math.exp(-(1 - R) / 0.2)
    on_near = 10 * math.exp(-(0.5 - 0.4) / 0.2)
    assert v["obstacle_force_on_robot"] == pytest.approx(2 * on_robot)
    assert v["obstacle_force_on_agents"] == pytest.approx(2 * on_near / 2)
    assert v["obstacle_force_on_robot_rate"] == pytest.approx(on_robot)
    assert v["social_work"] == pytest.approx(
        v["social_force_on_robot"]
        + v["obstacle_force_on_robot"]
        + v["social_force_on_agents"],
        rel=1e-15,
    )


def test_walls_on_both_sides_cancel():
    walls = Obstacles.from_points([[0, 1], [0, -1]])
    v = compute_metrics(make([0.0], rows(1), [rows(1)], obstacles=walls))
    assert v["obstacle_force_on_robot"] == pytest.approx(0, abs=1e-15)


def test_given_nearest_points_stand_in_for_walls():
    nearest = np.full((1, 2, 2, 2), np.nan)
    nearest[0, 0, 0] = [0, 1]
    nearest[0, 1] = [[3, 0.5], [2.5, 0]]
    recording = make(
        [0.0],
        rows(1),
        [rows(1, x=3.0)],
        nearest_walls=nearest,
        obstacles=Obstacles.from_points([[0, 0.01]]),
    )
    v = compute_metrics(recording)
    assert v["obstacle_force_on_robot"] == pytest.approx(
        10 * math.exp(-(1 - R) / 0.2)
    )
    assert v["obstacle_force_on_agents"] == pytest.approx(
        math.sqrt(2) * 10 * math.exp(-(0.5 - R) / 0.2)
    )


def test_many_bodies_and_walls_in_blocks_are_as_one_by_one():
    rng = np.random.default_rng(2)
    humans = rng.uniform(-4, 4, (900, 6, 7)) ** 2
    walls = Obstacles.from_shapes(
        [rng.uniform(-4, 4, (4, 2)) for _ in range(3)], solid=[True] * 3
    )
    recording = make(
        np.arange(900.0),
        rng.uniform(0, 4, (900, 7)),
        [humans[:, i] for i in range(6)],
        obstacles=walls,
    )
    parameters = SocialForceParameters(social_factor=2.1, epsilon=0.0)
    force = recording.features.obstacle_force_on_humans
    for k, i in ((0, 0), (682, 4), (683, 0), (899, 5)):
        p = humans[k, i, :2]
        d = (p - nearest_points(walls, p)).T
        each = np.array(obstacle_force(*d, humans[k, i, 6], parameters))
        assert force[k, i] == pytest.approx(np.hypot(*each.sum(axis=1)))


def test_without_people_sums_are_0_and_the_rest_has_no_value():
    v = compute_metrics(drive_straight(goal=(2.0, 0.0, 0.0)))
    zero = [
        "robot_on_person_collisions",
        "person_on_robot_collisions",
        "social_force_on_agents",
        "social_force_on_robot",
        "social_work",
        "danger_fear_cost",
        "danger_panic_cost",
        "surprise_visibility_cost",
        "surprise_shock_cost",
        "surprise_react_cost",
        "topological_complexity",
    ]
    assert (v[zero] == 0).all()
    nothing = {name for name in v.index if math.isnan(v[name])}
    proxemics = {n for n, m in METRICS.items() if m.family == "proxemics"}
    assert nothing == proxemics | {
        "avg_pedestrian_velocity",
        "avg_closest_pedestrian_velocity",
        "obstacle_force_on_agents",
        "obstacle_force_on_agents_rate",
        "min_time_to_collision",
        # Contacts are not recorded.
        "max_contact_force",
        "contact_impulse",
        "contacts_by_robot",
        "contacts_by_person",
        "contacts_with_walls",
        # There are no walls either, and no reference.
        "min_clearance",
        "avg_clearance",
        "avg_displacement_error",
        "final_displacement_error",
        "asymmetric_dtw",
        # Nor is the robot's largest speed known.
        "success_weighted_time_length",
    }


def test_contacts_are_those_of_the_recording():
    """Whatever came before it, and between the samples."""
    contacts = np.zeros((4, 2, 8))
    # A contact is over when the recording begins, another one is not.
    contacts[..., 0, Contact.PEAK_FORCE] = [900, 900, 300, 300]
    contacts[..., 0, Contact.IMPULSE] = [50, 50, 62, 62]
    contacts[..., 0, Contact.BY_ROBOT] = [1, 1, 2, 2]
    contacts[..., 1, Contact.LASTS] = [1, 0, 0, 1]
    contacts[..., 1, Contact.PEAK_FORCE] = [400, 400, 400, 100]
    contacts[..., 1, Contact.IMPULSE] = [5, 7, 7, 8]
    contacts[..., 1, Contact.BY_PERSON] = [3, 3, 3, 5]
    contacts[2, 0, 1:3] = [-30, 40]
    contacts[2, 1, 1:3] = [6, 8]
    recording = dataclasses.replace(
        make(np.arange(4.0), rows(4), [rows(4, x=2.0), rows(4, x=3.0)]),
        contacts=contacts,
        contact_forces_known=True,
    )
    v = compute_metrics(recording, ["contacts"])
    assert v["max_contact_force"] == 400
    assert v["contact_impulse"] == 12 + 3
    assert v["contacts_by_robot"] == 1
    assert v["contacts_by_person"] == 2
    steps = compute_steps(recording, ["contacts"])
    assert steps["max_contact_force"].tolist() == [0, 0, 50, 0]
    assert steps["contact_impulse"].tolist() == [0, 2, 14, 15]
    assert steps["contacts_by_robot"].tolist() == [0, 0, 1, 1]
    # That with walls before the recording is not of it, either.
    walls = np.zeros((4, 8))
    walls[:, Contact.BY_ROBOT] = [2, 2, 3, 5]
    walled = dataclasses.replace(recording, wall_contact=walls)
    assert compute_metrics(walled)["contacts_with_walls"] == 3
    assert np.isnan(v["contacts_with_walls"])
    kinematic = dataclasses.replace(recording, contact_forces_known=False)
    v = compute_metrics(kinematic, ["contacts"])
    assert np.isnan(v[["max_contact_force", "contact_impulse"]]).all()
    assert v["contacts_by_person"] == 2


def test_one_sample_has_neither_acceleration_nor_jerk():
    v = compute_metrics(make([3.0], rows(1, vx=0.4), [rows(1, x=2.0)]))
    assert v["path_length"] == 0
    assert v["duration"] == 0
    assert v["avg_robot_linear_speed"] == 0.4
    assert v["time_not_moving"] == 0
    assert v[["avg_robot_acceleration", "avg_robot_jerk"]].isna().all()
    steps = compute_steps(make([3.0], rows(1)))
    assert len(steps) == 1


def test_a_missing_person_counts_only_while_there():
    t = np.arange(4.0)
    here = rows(4, x=1.7, vx=1.0)
    here[2] = np.nan
    gone = np.full((4, 7), np.nan)
    recording = make(t, rows(4), [here, gone], group_ids=(1, 1))
    v = compute_metrics(recording)
    assert v["avg_dist_to_closest_person"] == pytest.approx(1.0)
    assert v["personal_space_intrusions"] == 75
    assert v["avg_pedestrian_velocity"] == 1
    assert v["avg_closest_pedestrian_velocity"] == 1
    assert math.isnan(v["group_personal_space_intrusions"])
    assert v["robot_on_person_collisions"] == 0
    steps = compute_steps(recording)
    assert math.isnan(steps["avg_dist_to_closest_person"].iloc[2])
    assert steps["social_force_on_agents"].iloc[2] == 0
    alone = compute_metrics(make(t, rows(4), [here]))
    assert len(alone) > 60
    for name in alone.index:
        assert alone[name] == pytest.approx(v[name], nan_ok=True), name


def test_who_comes_back_into_contact_begins_anew():
    person = rows(3, x=0.6, vx=-1.0)
    person[1] = np.nan
    v = compute_metrics(make(np.arange(3.0), rows(3), [person]))
    assert v["person_on_robot_collisions"] == 2
