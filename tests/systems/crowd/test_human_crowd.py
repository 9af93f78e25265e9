import dataclasses
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd, OpenCrowd
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.crowd.crowds import FREE, human_states

ROBOT = [3.0, 0.4, math.pi, -0.5, 0.0, 0.0, 0.35]
WALL = Obstacles.from_shapes([[[-5.0, -1.0], [9.0, -1.0]]], solid=[False])


def make_humans(*, epsilon=0.005):
    forces = SocialForceParameters(epsilon=epsilon)
    poses = [[0, 0, 0], [4, 0.3, math.pi], [1, 2, -1.5], [2.5, -0.4, 0.3]]
    radii = [0.3, 0.35, 0.4, 0.25]
    return [
        HumanConfig(pose=pose, radius=radius, forces=forces)
        for pose, radius in zip(poses, radii, strict=True)
    ]


GOALS = [[8, 0], [-6, 0], [1, -0.5], [9, 2]]


def walk_to(goal, *, speed=1.2, group_id=-1, role=RobotRole.PEDESTRIAN):
    command = np.zeros(COMMAND_SIZE)
    command[:4] = *goal, 0.3, 1
    command[Command.DESIRED_SPEED] = command[Command.MAX_SPEED] = speed
    command[Command.ROBOT_ROLE] = role
    command[Command.GROUP_ID] = group_id
    return command


def make_crowd_simulator(dut, commands, robot=ROBOT, context=None):
    context = context or dut.CreateDefaultContext()
    dut.get_commands_input_port().FixValue(context, np.ravel(commands))
    if dut.HasInputPort("robot_states"):
        dut.get_robot_states_input_port().FixValue(context, robot)
    return Simulator(dut, context)


def run_crowd(dut, commands, time=4.0, robot=ROBOT):
    simulator = make_crowd_simulator(dut, commands, robot)
    simulator.AdvanceTo(time)
    return human_states(dut, simulator.get_context()).copy()


@pytest.fixture
def dut():
    return HumanCrowd(make_humans(), obstacles=WALL)


@pytest.fixture
def commands():
    return [walk_to(goal) for goal in GOALS]


def test_human_states_are_poses_velocities_and_radii(dut):
    context = dut.CreateDefaultContext()
    np.testing.assert_array_equal(
        human_states(dut, context)[2], [1, 2, -1.5, 0, 0, 0, 0.4]
    )


def test_a_walker_reaches_its_speed_exponentially():
    """Euler's steps of dv/dt = k (v_d - v) / tau have a closed form."""
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0])], config=CrowdConfig(**FREE), num_robots=0
    )
    simulator = make_crowd_simulator(dut, [walk_to([1000, 0], speed=1.3)])
    for k in range(1, 60):
        simulator.AdvanceTo(0.05 * k + 1e-9)
        speed = human_states(dut, simulator.get_context())[0, 3]
        # The update at time 0.05 k has been made as well.
        assert speed == pytest.approx(1.3 * (1 - 0.8 ** (k + 1)), rel=1e-12)


def test_a_fine_step_follows_the_exponential():
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0])],
        config=CrowdConfig(**FREE),
        num_robots=0,
        time_step=1e-4,
    )
    simulator = make_crowd_simulator(dut, [walk_to([1000, 0], speed=1.3)])
    simulator.AdvanceTo(0.5)
    speed = human_states(dut, simulator.get_context())[0, 3]
    assert speed == pytest.approx(
        1.3 * (1 - math.exp(-0.5 * 2 / 0.5)), rel=1e-4
    )


def test_a_person_at_the_goal_comes_to_rest():
    dut = HumanCrowd([HumanConfig(pose=[0, 0, 0])], num_robots=0)
    state = run_crowd(dut, [walk_to([3, 0])], time=30.0)[0]
    assert math.hypot(state[0] - 3, state[1]) < 0.3 + 0.2
    assert math.hypot(state[3], state[4]) < 1e-3


def test_without_a_goal_the_velocity_decays_with_the_relaxation_time():
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0])], config=CrowdConfig(**FREE), num_robots=0
    )
    command = walk_to([5, 0])
    command[Command.HAS_GOAL] = 0
    context = dut.CreateDefaultContext()
    context.SetDiscreteState(0, [0, 0, 0, 1.0, 0, 0])
    simulator = make_crowd_simulator(dut, [command], context=context)
    simulator.AdvanceTo(0.5 - 0.01)
    assert human_states(dut, context)[0, 3] == pytest.approx(0.9**10, rel=1e-12)


def test_hold_stops_at_once_and_turns_at_the_given_rate():
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0])], config=CrowdConfig(**FREE), num_robots=0
    )
    command = walk_to([5, 0])
    command[Command.HOLD] = 1
    command[Command.YAW_TARGET] = -3.0
    command[Command.TURN_RATE] = math.pi
    context = dut.CreateDefaultContext()
    context.SetDiscreteState(0, [0, 0, 3.0, 1.0, 0, 0])
    simulator = make_crowd_simulator(dut, [command], context=context)
    simulator.AdvanceTo(0.01)
    x, y, yaw, vx, vy, omega, _ = human_states(dut, context)[0]
    assert (x, y, vx, vy) == (0, 0, 0, 0)
    # The short way, over pi.
    assert yaw == pytest.approx(3.0 + math.pi * 0.05 - 2 * math.pi)
    assert omega == pytest.approx(math.pi)
    simulator.AdvanceTo(0.06)
    assert human_states(dut, context)[0, 2] == pytest.approx(-3.0)


def test_the_speed_never_exceeds_the_limit(dut, commands):
    for command in commands:
        command[Command.DESIRED_SPEED] = 5.0
    simulator = make_crowd_simulator(dut, commands)
    for k in range(40):
        simulator.AdvanceTo(0.05 * k)
        states = human_states(dut, simulator.get_context())
        assert np.hypot(states[:, 3], states[:, 4]).max() <= 1.2 * (1 + 1e-12)


@pytest.mark.parametrize(
    ("role", "felt"),
    [
        (RobotRole.UNSEEN, None),
        (RobotRole.PEDESTRIAN, 2),
        (RobotRole.OBSTACLE, 1),
    ],
)
def test_the_robot_enters_the_forces_as_commanded(role, felt):
    dut = HumanCrowd([HumanConfig(pose=[2, 0, 0])])
    simulator = make_crowd_simulator(dut, [walk_to([9, 0], role=role)])
    forces = dut.get_forces_output_port().Eval(simulator.get_context())
    others = forces.reshape(8, 2)[1:7]
    for component in range(1, 7):
        assert others[component - 1].any() == (component == felt)


def test_the_robot_repels_as_commanded():
    human = HumanConfig(pose=[0, 0, 0], radius=0.4)
    dut = HumanCrowd([human], num_robots=2)
    command = walk_to([9, 0], role=RobotRole.UNSEEN)
    command[Command.ROBOT_REPULSION] = 4.0
    near, far = [0, 2.0, 0, 0, 0, 0, 0.3], [-3.0, 0, 0, 0, 0, 0, 0.3]
    simulator = make_crowd_simulator(dut, [command], robot=[*far, *near])
    forces = dut.get_forces_output_port().Eval(simulator.get_context())
    np.testing.assert_allclose(forces.reshape(8, 2)[6], [0, -4.0 / 1.6])
    # Overlapped, it still pushes away, no harder than at 5 cm.
    simulator = make_crowd_simulator(
        dut, [command], robot=[*far, 0, 0.1, 0, 0, 0, 0, 0.3]
    )
    forces = dut.get_forces_output_port().Eval(simulator.get_context())
    np.testing.assert_allclose(forces.reshape(8, 2)[6], [0, -4.0 / 0.05])


def test_a_wall_pushes_from_its_nearest_point_only_within_range():
    human = HumanConfig(pose=[0, 0, 0], radius=0.3)
    for distance, expected in [(1.0, 10 * math.exp(-0.7 / 0.2)), (5.1, 0.0)]:
        wall = [[-5.0, -distance], [9.0, -distance]]
        dut = HumanCrowd(
            [human],
            obstacles=Obstacles.from_shapes([wall], solid=[False]),
            num_robots=0,
        )
        simulator = make_crowd_simulator(dut, [walk_to([9, 0])])
        forces = dut.get_forces_output_port().Eval(simulator.get_context())
        np.testing.assert_allclose(
            forces.reshape(8, 2)[1], [0, expected], atol=1e-15
        )


@pytest.mark.parametrize("make", [HumanCrowd, OpenCrowd])
def test_a_robot_at_nan_is_an_error_and_not_ignored(make):
    dut = make([HumanConfig(pose=[0, 0, 0])])
    robot = [math.nan, 0, 0, 0, 0, 0, 0.3]
    with pytest.raises(RuntimeError, match=r"t = 0.000 s: robot_states must"):
        run_crowd(dut, [walk_to([3, 0])], robot=robot)


def test_forces_add_up():
    # (No group pulls on who passes a robot, or goes elsewhere than the rest.)
    config = CrowdConfig(groups_part=False, robot_gap=0.0)
    dut = HumanCrowd(make_humans(), obstacles=WALL, config=config)
    commands = [walk_to(goal, group_id=1) for goal in GOALS]
    # People 0 and 3 in touch; a push from the robot.
    context = dut.CreateDefaultContext()
    state = context.get_discrete_state(0).value().reshape(4, 6).copy()
    state[3, :2] = 0.3, 0.2
    # Person 1 walks away from the others.
    commands[1] = walk_to([9, 0], group_id=1)
    context.SetDiscreteState(0, state.ravel())
    commands[0][Command.ROBOT_REPULSION] = 4.0
    simulator = make_crowd_simulator(dut, commands, context=context)
    forces = dut.get_forces_output_port().Eval(simulator.get_context())
    forces = forces.reshape(4, 8, 2)
    assert forces[:, :7].any(axis=(0, 2)).all()
    np.testing.assert_allclose(forces[:, :7].sum(axis=1), forces[:, 7])


def test_forces_follow_every_input(dut, commands):
    simulator = make_crowd_simulator(dut, commands)
    context = simulator.get_mutable_context()
    port = dut.get_forces_output_port()
    before = port.Eval(context).copy()
    commands[1] = walk_to([0, 9])
    dut.get_commands_input_port().FixValue(context, np.ravel(commands))
    after_command = port.Eval(context).copy()
    assert (before != after_command).any()
    dut.get_robot_states_input_port().FixValue(
        context, [0.5, 0.5, 0, 0, 0, 0, 0.3]
    )
    after_robot = port.Eval(context).copy()
    assert (after_command != after_robot).any()
    context.SetDiscreteState(0, np.arange(24.0))
    assert (after_robot != port.Eval(context)).any()


def test_only_the_state_enters_human_states(dut):
    """So crowd and trees can form a loop."""
    assert not dut.HasDirectFeedthrough(
        dut.get_human_states_output_port().get_index()
    )


@pytest.mark.parametrize("n", [0, 1])
def test_hardly_anybody_is_a_crowd_too(n):
    dut = HumanCrowd(make_humans()[:n])
    states = run_crowd(dut, [walk_to(goal) for goal in GOALS[:n]])
    assert states.shape == (n, 7)
    assert np.isfinite(states).all()


@pytest.mark.parametrize("distance", [0.0, 1e-300, 1e-9])
def test_people_in_one_place_stay_finite(distance):
    humans = [HumanConfig(pose=[0, 0, 0]), HumanConfig(pose=[distance, 0, 0])]
    commands = [walk_to([0, 0], group_id=1), walk_to([5, 0], group_id=1)]
    dut = HumanCrowd(humans, obstacles=Obstacles.from_points([[0, 0]]))
    states = run_crowd(dut, commands, robot=[0, 0, 0, 0, 0, 0, 0.3])
    assert np.isfinite(states).all()


def test_two_contexts_do_not_disturb_each_other(dut, commands):
    alone = run_crowd(dut, commands)
    first = make_crowd_simulator(dut, commands)
    second = make_crowd_simulator(dut, [walk_to([0, 5])] * 4)
    for k in range(1, 81):
        first.AdvanceTo(k * 0.05)
        second.AdvanceTo(k * 0.05)
    np.testing.assert_array_equal(human_states(dut, first.get_context()), alone)


def test_a_clone_has_the_same_future(dut, commands):
    simulator = make_crowd_simulator(dut, commands)
    simulator.AdvanceTo(2.0)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(4.0)
    continued = Simulator(dut, clone)
    continued.AdvanceTo(4.0)
    np.testing.assert_array_equal(
        human_states(dut, simulator.get_context()), human_states(dut, clone)
    )


def test_a_run_repeats_bit_for_bit(dut, commands):
    again = HumanCrowd(make_humans(), obstacles=WALL)
    np.testing.assert_array_equal(
        run_crowd(dut, commands), run_crowd(again, commands)
    )


def test_the_order_of_people_does_not_matter(commands):
    order = [2, 0, 3, 1]
    humans = make_humans()
    plain = run_crowd(HumanCrowd(humans, obstacles=WALL), commands)
    permuted = run_crowd(
        HumanCrowd([humans[i] for i in order], obstacles=WALL),
        [commands[i] for i in order],
    )
    np.testing.assert_allclose(permuted, plain[order], atol=1e-9)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_moved_world_moves_the_same_way(mirrored):
    """Rotates, or mirrors about the x-axis, everything at once."""
    angle = 0.0 if mirrored else 0.7
    c, s = math.cos(angle), math.sin(angle)
    sign = -1.0 if mirrored else 1.0
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1.0, sign])

    def move_row(row):
        row = np.array(row, dtype=float)
        row[:2] = matrix @ row[:2]
        row[2] = sign * row[2] + angle
        row[3:5] = matrix @ row[3:5]
        row[5] *= sign
        return row

    humans = make_humans()
    moved = make_humans(epsilon=sign * 0.005)
    for human in moved:
        human.pose = tuple(move_row([*human.pose, 0, 0, 0])[:3])
    wall = np.array([[-5.0, -1.0], [9.0, -1.0]])
    walls = Obstacles.from_shapes([wall @ matrix.T], solid=[False])
    plain = run_crowd(
        HumanCrowd(humans, obstacles=WALL),
        [walk_to(goal, group_id=1) for goal in GOALS],
    )
    result = run_crowd(
        HumanCrowd(moved, obstacles=walls),
        [walk_to(matrix @ goal, group_id=1) for goal in GOALS],
        robot=move_row(ROBOT),
    )
    expected = np.array([move_row(row) for row in plain])
    columns = [0, 1, 3, 4, 5, 6]
    np.testing.assert_allclose(
        result[:, columns], expected[:, columns], atol=1e-9
    )
    np.testing.assert_allclose(
        np.exp(1j * result[:, 2]), np.exp(1j * expected[:, 2]), atol=1e-9
    )


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="time_step must be positive"):
        HumanCrowd([], time_step=0.0)
    with pytest.raises(ValueError, match="num_robots must be at least 0"):
        HumanCrowd([], num_robots=-1)
    with pytest.raises(ValueError, match="num_robots=0"):
        HumanCrowd([], num_robots=0).get_robot_states_input_port()
    with pytest.raises(ValueError, match="start_jitter must be at least 0"):
        HumanCrowd([], start_jitter=-0.1)
    with pytest.raises(ValueError, match="seed must be a whole number in"):
        HumanCrowd([], seed=-1)


def weights_of(dut):
    return dut.GetWeights(dut.CreateDefaultContext())


def test_weights_are_a_parameter(dut, commands):
    """A crowd moves as one that was made with these weights."""
    others = [
        dataclasses.replace(
            human,
            forces=SocialForceParameters(
                goal_factor=1.0 + i, obstacle_factor=5.0 + i, n=1.5
            ),
        )
        for i, human in enumerate(make_humans())
    ]
    expected = HumanCrowd(others, obstacles=WALL)
    context = dut.CreateDefaultContext()
    dut.SetWeights(context, weights_of(expected))
    np.testing.assert_array_equal(dut.GetWeights(context), weights_of(expected))
    simulator = make_crowd_simulator(dut, commands, context=context)
    simulator.AdvanceTo(4.0)
    np.testing.assert_array_equal(
        human_states(dut, context), run_crowd(expected, commands)
    )
    assert (human_states(dut, context) != run_crowd(dut, commands)).any()


def test_forces_and_derivatives_follow_the_weights(dut, commands):
    context = make_crowd_simulator(dut, commands).get_mutable_context()
    port = dut.get_forces_output_port()
    before = port.Eval(context).copy(), dut.CalcJacobian(context)
    dut.SetWeights(context, 2 * dut.GetWeights(context))
    after = port.Eval(context), dut.CalcJacobian(context)
    assert (before[0] != after[0]).any()
    assert (before[1].states != after[1].states).any()


def test_weights_read_are_a_copy(dut):
    context = dut.CreateDefaultContext()
    dut.GetWeights(context)[:] = 7.0
    np.testing.assert_array_equal(dut.GetWeights(context), weights_of(dut))


def test_refused_weights_change_nothing(dut):
    context = dut.CreateDefaultContext()
    for wrong in (-weights_of(dut), weights_of(dut)[:2], np.full((4, 13), 1e9)):
        with pytest.raises(ValueError, match="weights"):
            dut.SetWeights(context, wrong)
    np.testing.assert_array_equal(dut.GetWeights(context), weights_of(dut))


@pytest.fixture(scope="module")
def random_people():
    """People whose weights are drawn, in three different ways."""
    modes = ("random_normal", "random_uniform", "custom", "random_uniform")
    return [
        dataclasses.replace(human, forces_mode=mode)
        for human, mode in zip(make_humans(), modes, strict=True)
    ]


@pytest.mark.parametrize("seed", [0, 1, 2**32, 2**63 - 1])
def test_a_context_of_any_seed_is_that_of_a_crowd_of_that_seed(
    random_people, commands, seed
):
    dut = HumanCrowd(random_people, start_jitter=0.2, seed=9)
    other = HumanCrowd(random_people, start_jitter=0.2, seed=seed)
    simulator = make_crowd_simulator(dut, commands)
    simulator.AdvanceTo(1.0)
    context = simulator.get_mutable_context()
    dut.SetSeed(context, seed)
    expected = other.CreateDefaultContext()
    np.testing.assert_array_equal(
        human_states(dut, context), human_states(other, expected)
    )
    np.testing.assert_array_equal(
        dut.GetWeights(context), other.GetWeights(expected)
    )
    assert dut.GetSeed(context) == other.GetSeed(expected) == seed
    assert (
        (dut.GetWeights(context)[:2] != weights_of(dut)[:2]).any(axis=1).all()
    )
    nominal = [human.pose[:2] for human in random_people]
    offsets = human_states(dut, context)[:, :2] - nominal
    assert abs(offsets).min() > 0
    assert abs(offsets).max() <= 0.2


@pytest.mark.parametrize("seed", [-1, 2**63, 1.0, True, "1"])
def test_a_refused_seed_changes_nothing(random_people, seed):
    dut = HumanCrowd(random_people, seed=3)
    context = dut.CreateDefaultContext()
    with pytest.raises(ValueError, match="seed must be a whole number in"):
        dut.SetSeed(context, seed)
    assert dut.GetSeed(context) == 3


def test_a_start_may_be_at_the_very_edge_of_the_world():
    """An offset is no part of the configuration, whose range ends there."""
    dut = HumanCrowd([HumanConfig(pose=[1e5, -1e5, 0])], start_jitter=1.0)
    context = dut.CreateDefaultContext()
    beyond = []
    for seed in range(20):
        dut.SetSeed(context, seed)
        (state,) = human_states(dut, context)
        assert 0 < np.hypot(*(state[:2] - [1e5, -1e5])) < 1.5
        beyond.append(abs(state[:2]).max() > 1e5)
    assert any(beyond)


def test_a_crowd_of_autodiff_has_weights_and_seed_too(random_people):
    dut = HumanCrowd(random_people, start_jitter=0.2, seed=5)
    converted = dut.ToAutoDiffXd()
    context = dut.CreateDefaultContext()
    other = converted.CreateDefaultContext()
    for seed in (5, 2**40):
        dut.SetSeed(context, seed)
        if seed != 5:
            converted.SetSeed(other, seed)
        assert converted.GetSeed(other) == seed
        np.testing.assert_array_equal(
            converted.GetWeights(other), dut.GetWeights(context)
        )
    weights = np.ones((4, 13))
    converted.SetWeights(other, weights)
    np.testing.assert_array_equal(converted.GetWeights(other), weights)
