"""What must not change the metrics, does not."""

import dataclasses

import numpy as np
import pytest

from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation.compute import (
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.obstacles import Obstacles

WALLS = [
    np.array([[-3.0, -3.0], [-2.0, -3.0], [-2.0, 3.0], [-3.0, 3.0]]),
    np.array([[3.0, -1.0], [4.0, 2.0]]),
]


@pytest.fixture
def recording():
    """A wild crowd, in which everything happens to everyone."""
    rng = np.random.default_rng(3)
    samples, n = 120, 6
    t = np.cumsum(rng.uniform(0.05, 0.15, samples))
    phase = rng.uniform(0, 6, (n + 1, 4))
    a = rng.uniform(0.2, 1.2, (n + 1, 2))
    angle = a[:, 0] * t[:, None] + phase[:, 0]
    states = np.stack(
        [
            2 * np.cos(angle),
            1.5 * np.sin(a[:, 1] * t[:, None] + phase[:, 1]),
            np.remainder(angle, 6.28) - 3.14,
            rng.normal(size=(samples, n + 1)),
            rng.normal(size=(samples, n + 1)),
            rng.normal(size=(samples, n + 1)),
            np.broadcast_to(rng.uniform(0.1, 0.3, n + 1), (samples, n + 1)),
        ],
        axis=-1,
    )
    humans = states[:, 1:].copy()
    humans[30:50, 2] = np.nan
    contacts = rng.normal(size=(samples, n, 8))
    for sums in (Contact.IMPULSE, Contact.BY_ROBOT, Contact.BY_PERSON):
        steps = rng.integers(0, 3, (samples, n))
        contacts[..., sums] = np.cumsum(steps, axis=0)
    return Recording(
        times=t,
        robot=states[:, 0],
        humans=humans,
        contacts=contacts,
        wall_contact=np.abs(contacts[:, 0]),
        contact_forces_known=True,
        group_ids=(-1, 1, 1, 2, 2, 2),
        behaviors=("a", "b", "a", "b", "c", "a"),
        goal=(0.5, 0.5, 1.0),
        goal_tolerance=0.6,
        goal_yaw_tolerance=2.0,
        robot_max_speed=1.5,
        obstacles=Obstacles.from_shapes(WALLS, solid=[True, False]),
        reference_path=np.column_stack([t, np.sin(t), np.cos(2 * t)]),
    )


def moved_recording(recording, *, angle=0.0, shift=(0.0, 0.0), mirror=False):
    """Returns the same trial in a world that is turned and shifted."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s], [s, c]])
    flip = -1.0 if mirror else 1.0

    def move_points(p):
        return p * [1, flip] @ rotation.T + shift

    def move_states(states):
        result = states.copy()
        result[..., :2] = move_points(states[..., :2])
        result[..., 2] = flip * states[..., 2] + angle
        result[..., 3:5] = states[..., 3:5] * [1, flip] @ rotation.T
        result[..., 5] *= flip
        return result

    x, y, yaw = recording.goal
    contacts = recording.contacts.copy()
    force = np.s_[..., Contact.FORCE_X : Contact.FORCE_Y + 1]
    contacts[force] = contacts[force] * [1, flip] @ rotation.T
    reference = recording.reference_path.copy()
    reference[:, 1:] = move_points(reference[:, 1:])
    return dataclasses.replace(
        recording,
        robot=move_states(recording.robot),
        humans=move_states(recording.humans),
        contacts=contacts,
        goal=(*move_points(np.array([x, y])), flip * yaw + angle),
        obstacles=Obstacles.from_shapes(
            [move_points(wall) for wall in WALLS], solid=[True, False]
        ),
        reference_path=reference,
    )


def assert_same_metrics(a, b):
    for table in (compute_metrics, compute_steps):
        first, second = table(a), table(b)
        assert second.to_numpy() == pytest.approx(
            first.to_numpy(), rel=1e-8, abs=1e-8, nan_ok=True
        )


def test_the_trial_is_eventful(recording):
    values = compute_metrics(recording)
    assert not values.isna().any()
    nothing = set(values.index[values == 0])
    assert nothing <= {
        "time_not_moving",
        "completed",
        "min_dist_to_people",
        "public_space_intrusions",
        "success_weighted_path_length",
        "success_weighted_time_length",
        "cusps",
        "stalled_time",
        "min_time_to_collision",
        "min_clearance",
    }


@pytest.mark.parametrize("angle", [0.5, 2.0, np.pi, -1.3])
def test_turning_the_world(recording, angle):
    assert_same_metrics(recording, moved_recording(recording, angle=angle))


def test_shifting_the_world(recording):
    assert_same_metrics(
        recording, moved_recording(recording, shift=(30.0, -70.0))
    )


def test_mirroring_the_world(recording):
    assert_same_metrics(
        recording, moved_recording(recording, mirror=True, angle=0.3)
    )


def test_another_order_of_people(recording):
    order = [3, 0, 5, 1, 4, 2]
    other = dataclasses.replace(
        recording,
        humans=recording.humans[:, order],
        contacts=recording.contacts[:, order],
        group_ids=tuple(recording.group_ids[i] for i in order),
        behaviors=tuple(recording.behaviors[i] for i in order),
    )
    assert_same_metrics(recording, other)


def test_another_start_of_the_clock(recording):
    other = dataclasses.replace(recording, times=recording.times + 64.0)
    values = compute_metrics(other).to_numpy()
    assert values == pytest.approx(
        compute_metrics(recording).to_numpy(), rel=1e-9
    )


def test_someone_far_away_changes_no_collision_and_no_force(recording):
    stranger = np.zeros((len(recording), 1, 7))
    stranger[..., 0] = 1e3
    other = dataclasses.replace(
        recording,
        humans=np.concatenate([recording.humans, stranger], axis=1),
        contacts=np.concatenate(
            [recording.contacts, np.zeros((len(recording), 1, 8))], axis=1
        ),
        behavior_status=None,
        human_names=(),
        human_ids=(),
        behaviors=(),
        group_ids=(*recording.group_ids, -1),
    )
    a, b = compute_metrics(recording), compute_metrics(other)
    changed = {
        name
        for name in a.index
        if b[name] != pytest.approx(a[name], rel=1e-9, nan_ok=True)
    }
    assert changed == {
        "max_dist_to_people",
        "avg_pedestrian_velocity",
        "obstacle_force_on_agents",
        "obstacle_force_on_agents_rate",
        # The robot passes a person who stands still in the world.
        "danger_fear_cost",
        "danger_fear_cost_rate",
        "danger_panic_cost",
        "danger_panic_cost_rate",
        "topological_complexity",
    }


@pytest.mark.parametrize("factor", [2, 5])
def test_finer_samples_of_a_straight_pass(factor):
    """Rates and averages do not depend on the period; sums of forces do."""

    def run(dt):
        t = np.arange(round(8 / dt) + 1) * dt
        robot = np.zeros((len(t), 7))
        robot[:, 0] = t - 4
        robot[:, 3] = 1.0
        robot[:, 6] = 0.35
        humans = np.zeros((len(t), 1, 7))
        humans[:, 0, 0] = 4 - t
        humans[:, 0, 1] = 1.0
        humans[:, 0, 3] = -1.0
        humans[:, 0, 6] = 0.35
        return compute_metrics(
            Recording(
                times=t,
                robot=robot,
                humans=humans,
                goal=(4, 0, 0),
                obstacles=Obstacles.from_points([[0.0, -2.0]]),
                reference_path=[[0, -4, 1], [8, 4, 1]],
            )
        )

    coarse, fine = run(0.05), run(0.05 / factor)
    for name in (
        "path_length",
        "duration",
        "avg_robot_linear_speed",
        "completed",
        "min_dist_to_people",
        "final_dist_to_target",
        "robot_on_person_collisions",
        "avg_pedestrian_velocity",
        "path_efficiency",
        "path_irregularity",
        "success_weighted_path_length",
        "stalled_time",
        "min_clearance",
        "static_obstacle_collisions",
        "avg_displacement_error",
        "final_displacement_error",
        "asymmetric_dtw",
        "topological_complexity",
    ):
        assert fine[name] == pytest.approx(coarse[name], rel=1e-9), name
    for name in (
        "social_work_rate",
        "avg_dist_to_closest_person",
        "avg_clearance",
        "danger_fear_cost_rate",
        "danger_panic_cost_rate",
        "surprise_visibility_cost_rate",
    ):
        assert fine[name] == pytest.approx(coarse[name], rel=0.03), name
    share = "personal_space_intrusions"
    assert fine[share] == pytest.approx(coarse[share], abs=1.0)
    assert fine["social_work"] == pytest.approx(
        factor * coarse["social_work"], rel=0.03
    )


def test_behaviors_share_the_people_out(recording):
    parts = [compute_metrics(recording.only(b)) for b in "abc"]
    whole = compute_metrics(recording)
    for name in (
        "social_force_on_agents",
        "robot_on_person_collisions",
        "person_on_robot_collisions",
        "contact_impulse",
        "contacts_by_robot",
        "contacts_by_person",
    ):
        assert sum(p[name] for p in parts) == pytest.approx(whole[name]), name
    assert min(p["min_dist_to_people"] for p in parts) == pytest.approx(
        whole["min_dist_to_people"], abs=1e-12
    )
