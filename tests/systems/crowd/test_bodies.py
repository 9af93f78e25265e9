"""Bodies that do not overlap, people who stand, and limits of rates."""

import math

from hypothesis import given, settings, strategies as st
import numpy as np
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

MODELS = ("social_force", "headed_social_force", "orca")
FAR = [50.0, 50.0, 0, 0, 0, 0, 0.35]


def commands_to(goals, *, speed=1.2):
    """Returns the commands to walk to some goals; None is none."""
    commands = np.zeros((len(goals), COMMAND_SIZE))
    for row, goal in zip(commands, goals, strict=True):
        if goal is not None:
            row[:2] = goal
            row[Command.HAS_GOAL] = 1
        row[Command.GOAL_RADIUS] = 0.3
        row[[Command.DESIRED_SPEED, Command.MAX_SPEED]] = speed
        row[Command.ROBOT_ROLE] = 1
        row[Command.GROUP_ID] = -1
    return commands


def run(
    places, goals, *, time, walls=None, robot=FAR, velocities=None, **options
):
    """Returns the states at each step, shape (k, n, 7), and the system."""
    radius = options.pop("radius", 0.35)
    humans = [HumanConfig(pose=(*p, 0.0), radius=radius) for p in places]
    dut = HumanCrowd(humans, obstacles=walls, config=CrowdConfig(**options))
    context = dut.CreateDefaultContext()
    if velocities is not None:
        rows = dut.get_human_states_output_port().Eval(context).reshape(-1, 7)
        rows = rows.copy()
        rows[:, 3:5] = velocities
        dut.SetStates(context, rows)
    dut.get_commands_input_port().FixValue(context, commands_to(goals).ravel())
    simulator = Simulator(dut, context)
    history = []
    robot = np.array(robot, dtype=float)
    for k in range(round(time / 0.05)):
        dut.get_robot_states_input_port().FixValue(context, robot)
        simulator.AdvanceTo(0.05 * k + 0.025)
        history.append(dut.get_human_states_output_port().Eval(context))
        robot[:3] += 0.05 * robot[3:6]
    return np.array(history).reshape(len(history), -1, 7), dut, context


def overlaps(rows, radius=0.25):
    """Returns how deep the deepest two bodies overlap in each step."""
    p = rows[:, :, :2]
    away = np.linalg.norm(p[:, :, None] - p[:, None], axis=-1)
    n = p.shape[1]
    away[:, range(n), range(n)] = np.inf
    return 2 * radius - away.min(axis=(1, 2))


@pytest.mark.parametrize("model", MODELS)
def test_bodies_do_not_overlap_in_a_crush(model):
    """Twenty people walk to one point from all sides."""
    angles = np.arange(20) * 2 * math.pi / 20
    places = 4 * np.column_stack([np.cos(angles), np.sin(angles)])
    rows, _, _ = run(places, [(0.0, 0.0)] * 20, time=8.0, model=model)
    assert overlaps(rows).max() < 0.01
    # And they do come together.
    assert np.linalg.norm(rows[-1, :, :2], axis=1).max() < 2.8


@pytest.mark.parametrize("model", MODELS)
def test_a_robot_drives_through_people_and_pushes_them_aside(model):
    places = [(0.0, 0.05), (1.0, -0.02), (1.0, 0.6), (2.0, 0.0)]
    robot = [-2.0, 0, 0, 1.0, 0, 0, 0.35]
    rows, _, _ = run(
        places, [None] * 4, time=5.0, robot=robot, model=model, walls=None
    )
    # Row k is the state after the update at 0.05 k.
    x = -2.0 + 0.05 * np.arange(1, len(rows) + 1)
    away = np.hypot(rows[:, :, 0] - x[:, None], rows[:, :, 1])
    assert (0.25 + 0.35 - away).max() < 0.01
    assert overlaps(rows).max() < 0.01


@pytest.mark.slow
def test_whoever_is_squeezed_shares_the_overlap_and_tells_it():
    """A robot as wide as a blind alley pushes three people to its end."""
    alley = Obstacles.from_shapes(
        [np.array([(-9, -0.5), (2, -0.5), (2, 0.5), (-9, 0.5)])], solid=[False]
    )
    places = [(0.0, -0.1), (0.6, 0.1), (1.2, 0.0)]
    robot = [-1.0, 0, 0, 1.0, 0, 0, 0.5]
    rows, dut, context = run(
        places, [None] * 3, time=2.3, walls=alley, robot=robot
    )
    assert np.isfinite(rows).all()
    assert rows[..., 0].max() <= 2 - 0.1 + 1e-6
    assert abs(rows[..., 1]).max() <= 0.5 - 0.1 + 1e-6
    robot[0] = 1.3
    dut.get_robot_states_input_port().FixValue(context, robot)
    depths = dut.get_overlaps_output_port().Eval(context)
    p = rows[-1, :, :2]
    expected = 0.25 + 0.5 - np.hypot(p[:, 0] - 1.3, p[:, 1])
    assert (depths >= expected - 1e-9).all()
    # It is shared: nobody bears all of it.
    assert 0.05 < depths.max() < 0.6
    assert np.count_nonzero(depths > 0.05) == 3


def test_nobody_is_pushed_when_all_have_room():
    rows, dut, context = run([(0.0, 0.0), (3.0, 0.0)], [None] * 2, time=0.5)
    np.testing.assert_array_equal(rows[-1, :, 3:5], 0.0)
    np.testing.assert_array_equal(
        dut.get_overlaps_output_port().Eval(context), 0.0
    )


@settings(max_examples=30)
@given(st.integers(2, 12), st.integers(0, 2**32 - 1))
def test_contact_gives_nobody_energy(n, seed):
    """Without forces, a crash of people leaves no more energy than before."""
    rng = np.random.default_rng(seed)
    places = [(0.55 * (i % 4), 0.55 * (i // 4)) for i in range(n)]
    velocities = rng.uniform(-1, 1, (n, 2))

    def energy(**options):
        rows, _, _ = run(
            places,
            [None] * n,
            time=0.05,
            velocities=velocities,
            standing=False,
            max_acceleration=None,
            **options,
        )
        return (rows[-1, :, 3:5] ** 2).sum()

    assert energy() <= energy(keep_apart=False) * (1 + 1e-9)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(-3, 3), st.booleans())
def test_a_crush_is_the_same_in_any_order_and_any_direction(seed, angle, flip):
    rng = np.random.default_rng(seed)
    n = 10
    places = 0.6 * np.array([(i % 4, i // 4) for i in range(n)]) - 0.8
    places += rng.uniform(-0.04, 0.04, (n, 2))
    goals = rng.uniform(-0.5, 0.5, (n, 2))
    order = rng.permutation(n)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    options = {"time": 0.5, "model": "orca" if flip else "social_force"}
    plain, _, _ = run(places, goals.tolist(), **options)
    other, _, _ = run(
        places[order] @ turn.T, (goals[order] @ turn.T).tolist(), **options
    )
    np.testing.assert_allclose(
        other[-1, :, :2], plain[-1, order, :2] @ turn.T, atol=1e-5
    )


def test_who_overlaps_at_the_start_is_put_beside_at_rest():
    rows, _, _ = run(
        [(0.0, 0.0), (0.1, 0.0)], [None] * 2, time=0.05, standing=False
    )
    assert overlaps(rows)[-1] < 0.01
    np.testing.assert_array_equal(rows[-1, :, 3:5], 0.0)


def test_two_people_pass_each_other_in_a_narrow_door():
    """Bodies of 0.25 m do, in 0.8 m."""
    walls = Obstacles.from_shapes(
        [
            np.array([(0.0, -5.0), (0.0, -0.4)]),
            np.array([(0.0, 0.4), (0.0, 5.0)]),
        ],
        solid=[False, False],
    )
    rows, _, _ = run(
        [(-3.0, 0.1), (3.0, -0.1)],
        [(3.0, 0.0), (-3.0, 0.0)],
        time=20.0,
        walls=walls,
    )
    assert overlaps(rows).max() < 0.01
    assert rows[-1, 0, 0] > 2.5
    assert rows[-1, 1, 0] < -2.5


@pytest.mark.parametrize("model", MODELS)
def test_nobody_overshoots_a_goal(model):
    rows, _, _ = run([(-4.0, 0.0)], [(0.0, 0.0)], time=8.0, model=model)
    assert rows[:, 0, 0].max() < 0.1
    assert abs(rows[-1, 0, 0]) <= 0.3
    assert rows[-1, 0, 3] == 0


def test_who_stands_keeps_place_and_heading():
    """A crowd passes at 0.7 m; a wall is at 0.4 m."""
    walls = Obstacles.from_shapes(
        [np.array([(-9, -0.4), (9, -0.4)])], solid=[0]
    )
    places = [(0.0, 0.0), *((-2.0 - i, 0.8) for i in range(8))]
    goals = [None, *[(9.0, 0.8)] * 8]
    rows, _, _ = run(places, goals, time=12.0, walls=walls)
    assert np.hypot(rows[:, 0, 0], rows[:, 0, 1]).max() < 0.15
    np.testing.assert_array_equal(rows[:, 0, 2], 0.0)
    assert (rows[-1, 1:, 0] > 3).all()


def test_who_is_pushed_away_comes_back():
    robot = [-2.0, 0.02, 0, 0.8, 0, 0, 0.35]
    rows, _, _ = run([(0.0, 0.0)], [None], time=20.0, robot=robot)
    assert np.hypot(*rows[:, 0, :2].T).max() > 0.4
    assert np.hypot(*rows[-1, 0, :2]) < 0.1
    assert np.hypot(*rows[-1, 0, 3:5]) < 0.01


def test_headings_and_velocities_change_at_limited_rates():
    rng = np.random.default_rng(1)
    places = [(1.2 * (i % 5), 1.2 * (i // 5)) for i in range(15)]
    goals = [tuple(rng.uniform(-3, 9, 2)) for _ in places]
    rows, _, _ = run(places, goals, time=8.0, keep_apart=False)
    change = np.linalg.norm(np.diff(rows[..., 3:5], axis=0), axis=-1)
    assert change.max() <= 3.5 * 0.05 + 1e-9
    assert abs(rows[..., 5]).max() <= 4.0 + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_of_contact_are_those_of_finite_differences(seed):
    """Of people and a robot in touch, by AutoDiff and by `CalcJacobian`."""
    rng = np.random.default_rng(seed)
    humans = [HumanConfig(pose=(0.5 * i, 0.02 * i, 0.0)) for i in range(4)]
    config = CrowdConfig(
        model={"type": "social_force", "time_gap": 0.0}, robot_gap=0.0
    )
    dut = HumanCrowd(humans, config=config)
    context = dut.CreateDefaultContext()
    states = np.zeros((4, 6))
    states[:, 0] = 0.51 * np.arange(4)
    states[:, 1] = rng.uniform(-0.05, 0.05, 4)
    states[:, 3] = [1.0, 0.2, -0.3, -1.0]
    states[:, 4] = rng.uniform(-0.2, 0.2, 4)
    robot = np.array([2.08, 0.1, math.pi, -0.8, 0.1, 0.1, 0.35])
    commands = commands_to([(9.0, 0.1), (9.0, 0), (-9.0, 0), (-9.0, 0.2)])

    def after(values):
        other = context.Clone()
        other.SetDiscreteState(0, values[:24])
        dut.get_commands_input_port().FixValue(other, commands.ravel())
        dut.get_robot_states_input_port().FixValue(other, values[24:])
        return dut.EvalUniquePeriodicDiscreteUpdate(other).value(0)

    inputs = np.concatenate([states.ravel(), robot])
    h = 1e-6
    expected = np.column_stack(
        [
            (after(inputs + h * e) - after(inputs - h * e)) / (2 * h)
            for e in np.eye(len(inputs))
        ]
    )
    # They do touch: the robot pushes the last one.
    assert abs(expected[18:, 24:26]).max() > 0.1

    context.SetDiscreteState(0, states.ravel())
    dut.get_commands_input_port().FixValue(context, commands.ravel())
    dut.get_robot_states_input_port().FixValue(context, robot)
    jacobian = np.hstack(dut.CalcJacobian(context))
    np.testing.assert_allclose(jacobian, expected, atol=2e-3)

    converted = dut.ToAutoDiffXd()
    other = converted.CreateDefaultContext()
    scalars = InitializeAutoDiff(inputs).ravel()
    other.SetDiscreteState(0, scalars[:24])
    converted.get_commands_input_port().FixValue(other, commands.ravel())
    converted.get_robot_states_input_port().FixValue(other, scalars[24:])
    updated = converted.EvalUniquePeriodicDiscreteUpdate(other)
    np.testing.assert_allclose(
        ExtractGradient(updated.get_vector(0).CopyToVector()),
        jacobian,
        atol=1e-6,
    )


def test_two_contexts_and_a_clone():
    """The places where people stand are in the Context."""
    rows, dut, context = run([(0.0, 0.0)], [None], time=0.5)
    clone = context.Clone()
    for its in (context, clone):
        state = rows[-1].copy()
        state[0, 0] = 0.3
        dut.SetStates(its, state)
        Simulator(dut, its).AdvanceTo(3.0)
    for index in range(2):
        np.testing.assert_array_equal(
            context.get_discrete_state(index).value(),
            clone.get_discrete_state(index).value(),
        )
    place = context.get_discrete_state(0).value()[:2]
    assert np.hypot(*place) < 0.1
