"""MPPI: what each critic gives in closed form, and one cycle of it."""

import dataclasses
import math

import numpy as np
import pytest

from hunav_drake.systems.crowd.social_force.numpy_forces import pair_force
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.planning import PLANNERS, View
from hunav_drake.systems.planning.mppi import MppiMemory, MppiPlanner
from hunav_drake.systems.planning.mppi.improving import average, improve
from hunav_drake.systems.planning.mppi.mppi import (
    FAULT,
    CriticSettings,
    CriticWeights,
    draw_noise,
    even_path,
    setting,
)
from hunav_drake.systems.planning.mppi.parameters import Critic
from hunav_drake.systems.planning.mppi.rollouts import smooth
from hunav_drake.systems.planning.navigation.memory import LocalPlan
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.maps.costs import Costmap
from tests.systems.planning.test_local_planner import make_task

CRITICS = [critic.name.lower() for critic in Critic][:-1]
DT = 0.05
N = 24
STRAIGHT = np.column_stack([np.arange(61) * 0.05, np.zeros(61), np.zeros(61)])
FAR = (9.0, 0.0, 0.0)
NOBODY = np.zeros((0, 7))
QUICK = RobotLimits(
    max_speed=2.0,
    max_reverse_speed=1.0,
    max_acceleration=100.0,
    max_turn_rate=10.0,
    max_turn_acceleration=1000.0,
)
TASK = dataclasses.replace(make_task(), limits=QUICK)


def make_map(cost=0, *, size=8.0):
    cells = round(size / 0.05)
    costs = np.full((cells, cells), cost, dtype=np.uint8)
    return Costmap(costs, (-size / 2, -size / 2), 0.05)


def make_planner(*critics, **parameters):
    """Returns a planner with these critics alone, of weight 1."""
    weights = {name: float(name in critics) for name in CRITICS}
    return MppiPlanner(
        weights=CriticWeights(**weights),
        **{
            "max_vel_x": 1.0,
            "max_acc_x": 100.0,
            "max_acc_theta": 1000.0,
            "time_steps": N,
            **parameters,
        },
    )


def roll(
    planner,
    *,
    state=(0, 0, 0, 0, 0),
    control=None,
    goal=FAR,
    plan=STRAIGHT,
    costmap=None,
    humans=NOBODY,
    task=TASK,
    noise=None,
):
    """Returns what `improve` gives for constant controls, as it moves now."""
    made = setting(planner, task)
    steps = planner.time_steps
    controls = np.tile(
        np.array(state[3:] if control is None else control, float), (steps, 1)
    )
    noise = np.zeros((1, steps, 2)) if noise is None else noise
    costmap = costmap or make_map()
    return improve(
        *(np.array(state, float), controls, np.zeros((4, 2)), noise),
        *(np.array(goal), even_path(plan, 0.05), 0.05),
        *(costmap.costs, *costmap.origin, costmap.resolution),
        *(planner.setup(task).footprint, humans, made.forces),
        *(made.weights, made.values),
    )


def score(critic, *, settings=None, **kwargs):
    """Returns the score of one critic for one rollout."""
    planner = make_planner(critic, critics=CriticSettings(**(settings or {})))
    alive, _, scores, _ = roll(planner, **kwargs)
    assert alive == 1
    total, *each = scores[0]
    assert total == each[CRITICS.index(critic)]
    return total


def test_a_rollout_follows_its_controls():
    _, _, _, poses = roll(make_planner(), state=(1, 2, 0.5, 0.8, 0.0))
    way = 0.8 * DT * np.arange(1, N + 1)
    expected = np.column_stack(
        [1 + way * math.cos(0.5), 2 + way * math.sin(0.5), np.full(N, 0.5)]
    )
    np.testing.assert_allclose(poses[0], expected, atol=1e-12)
    # A turn ends where the chords of a circle do.
    _, _, _, poses = roll(make_planner(), state=(0, 0, 0, 0.5, 1.0))
    yaw = DT * np.arange(N)
    np.testing.assert_allclose(
        poses[0, -1],
        [0.5 * DT * np.cos(yaw).sum(), 0.5 * DT * np.sin(yaw).sum(), DT * N],
        atol=1e-12,
    )


def test_a_rollout_begins_as_the_robot_moves_and_accelerates_as_it_can():
    planner = make_planner(max_acc_x=2.0)
    _, _, _, poses = roll(planner, state=(0, 0, 0, 0.4, 0), control=(0.7, 0.0))
    speeds = np.diff(poses[0, :, 0], prepend=0.0) / DT
    np.testing.assert_allclose(speeds[:5], [0.4, 0.5, 0.6, 0.7, 0.7])


def test_constraint():
    assert score("constraint", state=(0, 0, 0, 0.9, 0.5)) == 0
    # 0.1 m/s too fast, or backwards, for 1.2 s; and a turn.
    fast = score("constraint", state=(0, 0, 0, 1.1, 0.0))
    assert fast == pytest.approx(0.1 * N * DT)
    back = score("constraint", state=(0, 0, 0, -0.45, 0.0))
    assert back == pytest.approx(0.1 * N * DT)
    turn = score("constraint", state=(0, 0, 0, 0.0, -2.4))
    assert turn == pytest.approx(0.5 * N * DT)


def test_cost_is_a_mean_of_cells():
    costmap = make_map()
    costmap.costs[:, 80:] = 100
    moving = {"state": (0.01, 0, 0, 1.0, 0)}
    assert score("cost", costmap=costmap, **moving) == pytest.approx(100 / 254)
    # Half of the way: 12 of 24 poses.
    costmap.costs[:, 92:] = 0
    assert score("cost", costmap=costmap, **moving) == pytest.approx(
        50 / 254, abs=100 / 254 / 12
    )
    near = {"costmap": costmap, "goal": (0.9, 0, 0)}
    assert score("cost", **near, **moving) == 0


@pytest.mark.parametrize("cost", [253, 254, 255])
def test_a_collision_costs_more_than_all_else(cost):
    costmap = make_map()
    costmap.costs[:, 90:] = cost
    planner = make_planner("cost", "goal")
    alive, _, scores, _ = roll(
        planner, state=(0, 0, 0, 1.0, 0), costmap=costmap
    )
    assert (alive, scores[0, 0]) == (0, 1e6)
    # So is what is off the map.
    alive, _, _, _ = roll(
        planner, state=(0, 0, 0, 1.0, 0), costmap=make_map(size=1.0)
    )
    assert alive == 0


def test_the_outline_may_tell_a_collision():
    settings = {"consider_footprint": True}
    inscribed = make_map(253)
    assert score("cost", costmap=inscribed, settings=settings) == pytest.approx(
        300 / 254
    )
    wall = make_map(1)
    wall.costs[:, 88:] = 254
    planner = make_planner("cost", critics=CriticSettings(**settings))
    # The robot of 0.3 m touches it 0.4 m ahead.
    for v, survives in ((0.04, 1), (0.2, 0)):
        alive, _, _, _ = roll(planner, state=(0, 0, 0, v, 0), costmap=wall)
        assert alive == survives


def test_goal():
    # At rest 0.5 m away; then a mean over the way there.
    goal = (0.3, 0.4, 0)
    assert score("goal", goal=goal) == pytest.approx(0.5)
    moved = 0.2 * DT * np.arange(1, N + 1)
    assert score(
        "goal", goal=(1.0, 0, 0), state=(0, 0, 0, 0.2, 0)
    ) == pytest.approx((1.0 - moved).mean())
    assert score("goal", goal=(1.5, 0, 0)) == 0


def test_goal_angle():
    near = (0.3, 0.0, 3.0)
    at = (0, 0, -3.0, 0, 0)
    away = 2 * math.pi - 6.0
    assert score("goal_angle", goal=near, state=at) == pytest.approx(away)
    turned = away - 0.05 * DT * np.arange(1, N + 1)
    assert score(
        "goal_angle", goal=near, state=(0, 0, -3.0, 0, -0.05)
    ) == pytest.approx(turned.mean())
    assert score("goal_angle", goal=(0.6, 0, 3.0), state=at) == 0


def test_path_align():
    beside = (0, 0.2, 0, 1.0, 0)
    assert score("path_align", state=beside) == pytest.approx(0.2)
    assert score("path_align", state=(0, 0, 0, 1.0, 0)) == pytest.approx(0)
    # Not so near to the goal, nor with so little of the plan reached.
    assert score("path_align", state=beside, goal=(0.3, 0, 0)) == 0
    assert score("path_align", state=(0, 0.2, 0, 0.9, 0)) > 0.2
    assert score("path_align", state=(0, 0.2, 0, 0.7, 0)) == 0


def test_path_align_leaves_a_plan_that_is_blocked():
    costmap = make_map()
    costmap.costs[78:82, 85:88] = 254
    state = (0, 0.2, 0, 1.0, 0)
    assert score("path_align", state=state, costmap=costmap) == 0
    lenient = {"max_path_occupancy_ratio": 0.5}
    assert score(
        "path_align", state=state, costmap=costmap, settings=lenient
    ) == pytest.approx(0.2)


def test_path_follow():
    # It reaches 1.2 m, which is point 24; then 5 points, 0.05 m apart.
    state = (0, 0, 0, 1.0, 0)
    assert score("path_follow", state=state) == pytest.approx(0.25)
    costmap = make_map()
    costmap.costs[78:82, 108:112] = 254
    # Points 28 to 31 are blocked.
    assert score("path_follow", state=state, costmap=costmap) == pytest.approx(
        0.4, abs=0.051
    )
    assert score("path_follow", state=state, goal=(1.3, 0, 0)) == 0


def test_path_angle():
    across = (0, 0, math.pi / 2, 0, 0)
    assert score("path_angle", state=across) == pytest.approx(math.pi / 2)
    assert score("path_angle", state=(0, 0, 0.9, 0, 0)) == 0
    assert score("path_angle", state=(0, 0, 1.1, 0, 0)) == pytest.approx(1.1)
    assert score("path_angle", state=across, goal=(0.4, 0, 0)) == 0


def test_prefer_forward():
    assert score("prefer_forward", state=(0, 0, 0, 0.5, 0)) == 0
    back = (0, 0, 0, -0.3, 0)
    assert score("prefer_forward", state=back) == pytest.approx(0.3 * N * DT)
    assert score("prefer_forward", state=back, goal=(0.4, 0, 0)) == 0


def social_work(state, humans, *, steps=N, every=4):
    """Returns the mean social work by NumPy."""
    x, y, yaw, v, _ = state
    heading = np.array([math.cos(yaw), math.sin(yaw)])
    parameters = SocialForceParameters()
    works = []
    for k in range(every, steps + 1, every):
        at = np.array([x, y]) + v * k * DT * heading
        forces = np.array(
            [
                pair_force(
                    *(human[:2] + k * DT * human[3:5] - at),
                    *(v * heading - human[3:5]),
                    parameters,
                )
                for human in humans
            ]
        ).reshape(-1, 2)
        each = np.hypot(*forces.T)
        works.append(each.sum() + np.hypot(*forces.sum(axis=0)))
    return np.mean(works)


PEOPLE = np.array(
    [
        [2.0, 0.3, 3.1, -1.0, 0.1, 0.0, 0.3],
        [1.0, -0.9, 1.5, 0.0, 0.6, 0.0, 0.3],
        [0.6, 0.8, 0.0, 0.0, 0.0, 0.0, 0.3],
    ]
)


@pytest.mark.parametrize("people", [PEOPLE[:1], PEOPLE[1:2], PEOPLE])
def test_social_work_is_that_of_the_forces(people):
    state = (0.0, 0.0, 0.2, 0.5, 0.0)
    expected = social_work(state, people)
    # What is faint is left out.
    assert score("social", state=state, humans=people) == pytest.approx(
        expected, rel=0.02
    )
    assert expected > 0.5
    far = people + np.array([30.0, 0, 0, 0, 0, 0, 0])
    assert score("social", state=state, humans=far) == 0
    assert score("social", state=state) == 0


def test_opposite_forces_cancel_on_the_robot_but_not_on_people():
    one = np.array([[0.0, 1.0, 0, 0, 0, 0, 0.3]])
    two = np.array([[0.0, 1.0, 0, 0, 0, 0, 0.3], [0.0, -1.0, 0, 0, 0, 0, 0.3]])
    alone = score("social", humans=one)
    assert alone > 0.1
    # 2 f of one alone; of both, the f on each remain.
    assert score("social", humans=two) == pytest.approx(alone, rel=0.05)


def test_leaving_the_last_controls_costs():
    planner = make_planner(gamma=0.1, vx_std=0.2, wz_std=0.5)
    noise = np.zeros((1, N, 2))
    noise[0, 3] = (1.5, -2.0)
    _, _, scores, _ = roll(
        planner, control=(0.4, 0.3), state=(0, 0, 0, 0.4, 0.3), noise=noise
    )
    expected = 0.1 * (0.4 * 0.3 / 0.2**2 + 0.3 * -1.0 / 0.5**2)
    assert scores[0, Critic.CONTROL] == pytest.approx(expected)
    assert scores[0, 0] == pytest.approx(expected)


def test_the_average_weighs_by_how_good_they_are():
    sampled = np.array([[[1.0, 0.0]], [[2.0, 1.0]], [[9.0, 9.0]]])
    totals = np.array([5.0, 5.0 + 0.3 * math.log(3), 1e6])
    mean = average.py_func(sampled, totals, 0.3)
    np.testing.assert_allclose(mean, [[1.25, 0.25]])


def test_smoothing_keeps_a_quadratic():
    k = np.arange(-4.0, 30.0)
    values = np.column_stack([1 + 0.3 * k + 0.02 * k**2, 2 - 0.1 * k])
    result = smooth.py_func(values[4:], values[:4])
    # (The end has nothing behind it.)
    np.testing.assert_allclose(result[:-4], values[4:-4], atol=1e-12)
    noisy = values + 0.1 * (-1.0) ** k[:, None]
    rough = smooth.py_func(noisy[4:], noisy[:4]) - values[4:]
    assert np.abs(rough[:-4]).max() < 0.02


def test_noise_follows_from_seed_and_number():
    noise = draw_noise(3, 7, 500, 40)
    draw_noise.cache_clear()
    np.testing.assert_array_equal(noise, draw_noise(3, 7, 500, 40))
    assert not noise.flags.writeable
    for other in (draw_noise(3, 8, 500, 40), draw_noise(4, 7, 500, 40)):
        assert abs(np.corrcoef(noise.ravel(), other.ravel())[0, 1]) < 0.03
    assert noise.std() == pytest.approx(1, abs=0.02)


def test_a_plan_is_resampled_evenly():
    plan = np.array([[0, 0, 0], [0.03, 0, 0], [0.3, 0, 0], [0.3, 0.4, 0]])
    path = even_path(plan, 0.1)
    np.testing.assert_allclose(
        path,
        [[0, 0], [0.1, 0], [0.2, 0], [0.3, 0]]
        + [[0.3, 0.1 * k] for k in (1, 2, 3, 4)],
        atol=1e-12,
    )
    np.testing.assert_array_equal(even_path(plan[:1], 0.1), [[0, 0]])


def decide(planner, *, robot=(0, 0, 0, 0, 0, 0, 0.3), memory=None, cost=0):
    view = View(np.array(robot, float), NOBODY, np.array(FAR))
    local = LocalPlan(STRAIGHT, FAR, True)
    memory = MppiMemory() if memory is None else memory
    return planner.control(make_task(), view, local, make_map(cost), memory)


def test_it_drives_along_a_plan_within_the_limits_of_the_robot():
    planner, memory = MppiPlanner(), None
    x = v = 0.0
    speeds = []
    for _ in range(60):
        control = decide(planner, robot=(x, 0, 0, v, 0, 0, 0.3), memory=memory)
        assert not control.fault
        # As the robot does: the last command is on its way.
        assert control.v - v <= 2 * DT * 1.0 + 1e-9
        x, v, memory = x + v * DT, control.v, control.memory
        speeds.append(v)
        if x > 1.0:
            x = 0.0
    assert 0.5 < speeds[-1] <= 0.6
    assert memory.cycle == 60
    assert not memory.controls.flags.writeable
    assert not memory.past.flags.writeable


def test_a_cycle_repeats_and_the_next_draws_anew():
    planner = MppiPlanner()
    first, again = decide(planner), decide(MppiPlanner())
    assert (first.v, first.omega) == (again.v, again.omega)
    np.testing.assert_array_equal(first.memory.controls, again.memory.controls)
    later = decide(planner, memory=MppiMemory(cycle=1))
    assert later.omega != first.omega
    assert decide(MppiPlanner(noise_seed=1)).omega != first.omega
    fixed = MppiPlanner(regenerate_noises=False)
    one, two = decide(fixed), decide(fixed, memory=MppiMemory(cycle=1))
    assert one.omega == two.omega


def test_old_controls_that_lead_into_something_are_dropped():
    """It tries again from rest; if all collide, it says so."""
    wild = np.tile([5.0, 0.0], (56, 1))
    memory = MppiMemory(controls=wild, cycle=4)
    assert not decide(MppiPlanner(), memory=memory).fault
    costs = make_map()
    costs.costs[:, 94:] = 254
    view = View(np.array([0, 0, 0, 0.0, 0, 0, 0.3]), NOBODY, np.array(FAR))
    control = MppiPlanner().control(
        *(TASK, view, LocalPlan(STRAIGHT, FAR, True)), *(costs, memory)
    )
    assert not control.fault
    assert abs(control.v) < 0.3
    assert decide(MppiPlanner(), cost=254).fault == FAULT


def test_it_is_known_by_name():
    planner = PLANNERS.make({"type": "mppi", "weights": {"social": 0.0}})
    assert isinstance(planner, MppiPlanner)
    with pytest.raises(ValueError, match="batch_size"):
        PLANNERS.make({"type": "mppi", "batch_size": 0})
