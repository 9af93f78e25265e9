"""A crowd of AutoDiffXd knows the derivatives of its steps."""

import copy
import dataclasses
import math
import pickle

import numpy as np
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    Command,
    Hold,
    RobotRole,
)
from hunav_drake.systems.crowd import (
    CrowdConfig,
    HumanCrowd,
    MotionModel,
    register_motion_model,
)
from hunav_drake.systems.crowd.human_crowd import HumanCrowd_
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.crowd.crowds import FREE

WALLS = Obstacles.from_shapes(
    [
        [[-6.0, -2.0], [6.0, -2.0]],
        [[1.0, 2.5], [3.0, 2.5], [3.0, 4.0]],
        [[-1.0, 0.5]],
    ],
    solid=[False, True, False],
)
N, M = 5, 2
ROLES = [
    RobotRole.PEDESTRIAN,
    RobotRole.OBSTACLE,
    RobotRole.PEDESTRIAN,
    RobotRole.OBSTACLE,
    RobotRole.UNSEEN,
]

# The elements of a robot's state that people feel: x, y, vx, vy.
FELT = [0, 1, 3, 4, 7, 8, 10, 11]


def make_moody_crowd(seed, **options):
    """Returns a crowd, and a Context with everybody in a different mood."""
    rng = np.random.default_rng(seed)
    humans = [
        HumanConfig(
            pose=[0, 0, 0],
            radius=float(rng.uniform(0.2, 0.5)),
            forces=SocialForceParameters(
                social_factor=float(rng.uniform(2, 6)),
                epsilon=float(rng.choice([0.0, 0.005])),
            ),
        )
        for _ in range(N)
    ]
    options = {"config": CrowdConfig(**FREE), **options}
    dut = HumanCrowd(humans, obstacles=WALLS, num_robots=M, **options)
    context = dut.CreateDefaultContext()
    states = rng.normal(size=(N, 6)) * [2, 1.5, 1, 0.6, 0.6, 1]
    # A pair of the group is in touch.
    states[1, :2] = states[0, :2] + [0.2, 0.1]
    context.SetDiscreteState(0, states.ravel())
    commands = np.zeros((N, COMMAND_SIZE))
    for i, command in enumerate(commands):
        command[:4] = *rng.uniform(-9, 9, 2), 0.3, 1
        command[Command.DESIRED_SPEED] = 1.2
        command[Command.MAX_SPEED] = [0.2, 9.0, 9.0, 9.0, 9.0][i]
        command[Command.ROBOT_ROLE] = ROLES[i]
        command[Command.ROBOT_REPULSION] = [0, 1.5, 1.5, 0, 2.0][i]
        command[Command.HOLD] = i == 3
        command[Command.TURN_RATE] = 0.5 if i == 2 else 0.0
        command[Command.YAW_TARGET] = 2.0
        command[Command.GROUP_ID] = 4 if i < 3 else -1
    dut.get_commands_input_port().FixValue(context, commands.ravel())
    robots = rng.normal(size=(M, 7)) * [1.5, 1.5, 1, 0.5, 0.5, 1, 0]
    dut.get_robot_states_input_port().FixValue(context, robots.ravel())
    return dut, context


def next_state(dut, context, state, robots):
    context = context.Clone()
    context.SetDiscreteState(0, state)
    dut.get_robot_states_input_port().FixValue(context, robots)
    updated = dut.EvalUniquePeriodicDiscreteUpdate(context)
    return updated.get_vector(0).CopyToVector()


def present(dut, context):
    """Returns the states of the people, and those of the robots."""
    return (
        context.get_discrete_state(0).CopyToVector(),
        dut.get_robot_states_input_port().Eval(context).copy(),
    )


def autodiff_step(dut, context):
    """Returns the next state with its derivatives by state and robots."""
    converted = dut.ToAutoDiffXd()
    state, robots = present(dut, context)
    variables = InitializeAutoDiff(np.concatenate([state, robots])).ravel()
    other = converted.CreateDefaultContext()
    converted.SetWeights(other, dut.GetWeights(context))
    commands = dut.get_commands_input_port().Eval(context)
    converted.get_commands_input_port().FixValue(other, commands)
    return next_state(converted, other, variables[: 6 * N], variables[6 * N :])


def differences(dut, context):
    """Returns the derivatives by the robots, by differences of order 4."""
    state, robots = present(dut, context)
    turn = np.array([0, 0, 2 * math.pi, 0, 0, 2 * math.pi / 0.05] * N)
    columns = []
    for c in range(len(robots)):

        def at(h, c=c):
            moved = robots.copy()
            moved[c] += h
            return next_state(dut, context, state, moved)

        h = 2e-4
        near, far = at(h) - at(-h), at(2 * h) - at(-2 * h)
        for change in (near, far):
            # An angle may have gone round.
            angle = turn > 0
            change[angle] -= turn[angle] * np.round(change[angle] / turn[angle])
        columns.append((8 * near - far) / (12 * h))
    return np.array(columns).T


@pytest.mark.parametrize("seed", range(6))
def test_the_next_state_by_the_robot_is_that_of_finite_differences(seed):
    dut, context = make_moody_crowd(seed)
    gradient = ExtractGradient(autodiff_step(dut, context))
    by_robots = gradient[:, 6 * N :]
    expected = differences(dut, context)
    np.testing.assert_allclose(by_robots, expected, rtol=1e-6, atol=1e-9)
    # All but the one who stands still feel something, in place and velocity.
    felt = abs(by_robots[:, FELT]).reshape(N, -1).max(axis=1) > 1e-6
    assert felt.tolist() == [True, True, True, False, True]
    others = np.delete(by_robots, FELT, axis=1)
    np.testing.assert_array_equal(others, 0)


@pytest.mark.parametrize("seed", range(6))
def test_the_analytic_jacobian_agrees(seed):
    dut, context = make_moody_crowd(seed)
    gradient = ExtractGradient(autodiff_step(dut, context))
    jacobian = dut.CalcJacobian(context)
    assert jacobian.states.shape == (6 * N, 6 * N)
    assert jacobian.robots.shape == (6 * N, 7 * M)
    np.testing.assert_allclose(
        np.hstack(jacobian), gradient, rtol=1e-9, atol=1e-9
    )


def test_derivatives_are_those_with_the_weights_of_the_context():
    dut, context = make_moody_crowd(1)
    before = dut.CalcJacobian(context)
    dut.SetWeights(context, 1.5 * dut.GetWeights(context))
    gradient = ExtractGradient(autodiff_step(dut, context))
    after = dut.CalcJacobian(context)
    assert (before.robots != after.robots).any()
    np.testing.assert_allclose(np.hstack(after), gradient, rtol=1e-9, atol=1e-9)


def test_the_values_are_those_of_the_plain_crowd():
    dut, context = make_moody_crowd(1)
    expected = next_state(dut, context, *present(dut, context))
    result = ExtractValue(autodiff_step(dut, context)).ravel()
    np.testing.assert_allclose(result, expected, rtol=1e-12, atol=1e-12)


def test_the_ports_carry_derivatives():
    dut, context = make_moody_crowd(1)
    converted = dut.ToAutoDiffXd()
    other = converted.CreateDefaultContext()
    state, robots = present(dut, context)
    commands = dut.get_commands_input_port().Eval(context)
    converted.get_commands_input_port().FixValue(other, commands)
    variables = InitializeAutoDiff(robots).ravel()
    converted.get_robot_states_input_port().FixValue(other, variables)
    other.SetDiscreteState(0, state)
    forces = converted.get_forces_output_port().Eval(other)
    np.testing.assert_allclose(
        ExtractValue(forces).ravel(),
        dut.get_forces_output_port().Eval(context),
        rtol=1e-12,
        atol=1e-12,
    )
    assert abs(ExtractGradient(forces)).max() > 0.01
    # The state of the people now does not depend on the robots.
    states = converted.get_human_states_output_port().Eval(other)
    np.testing.assert_array_equal(
        ExtractValue(states).ravel(),
        dut.get_human_states_output_port().Eval(context),
    )


@pytest.mark.parametrize("distance", [0.0, 1e-300, 1e-155, 1e-120, 1e-9])
def test_derivatives_are_finite_where_forces_are_undefined(distance):
    """People on one another, on a wall, on the goal and on the robot."""
    dut, context = make_moody_crowd(0)
    state = np.zeros((N, 6))
    state[:, 0] = -1.0
    state[:, 1] = 0.5 + np.arange(N) * distance
    context.SetDiscreteState(0, state.ravel())
    robots = np.zeros((M, 7))
    robots[:, :2] = -1.0, 0.5
    dut.get_robot_states_input_port().FixValue(context, robots.ravel())
    port = dut.get_commands_input_port()
    commands = port.Eval(context).reshape(N, COMMAND_SIZE)
    commands[:, :3] = -1.0, 0.5, 0.0
    port.FixValue(context, commands.ravel())
    result = autodiff_step(dut, context)
    assert np.isfinite(ExtractValue(result)).all()
    gradient = ExtractGradient(result)
    assert np.isfinite(gradient).all()
    jacobian = np.hstack(dut.CalcJacobian(context))
    assert np.isfinite(jacobian).all()
    if distance == 0:
        np.testing.assert_allclose(jacobian, gradient, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("n", "m"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_hardly_anybody_has_derivatives_too(n, m):
    dut = HumanCrowd([HumanConfig(pose=[0, 0, 0])] * n, num_robots=m)
    context = dut.CreateDefaultContext()
    converted = dut.ToAutoDiffXd()
    other = converted.CreateDefaultContext()
    for system, its_context in ((dut, context), (converted, other)):
        system.get_commands_input_port().FixValue(
            its_context, [5, 0, 0.3, 1, 1, 1, 1, 0, 0, 0, 0, -1] * n
        )
        if m:
            system.get_robot_states_input_port().FixValue(
                its_context, [1, 0.5, 0, 0, 0, 0, 0.3]
            )
    other.SetDiscreteState(0, InitializeAutoDiff(np.zeros(6 * n)).ravel())
    updated = converted.EvalUniquePeriodicDiscreteUpdate(other)
    jacobian = dut.CalcJacobian(context)
    assert jacobian.states.shape == (6 * n, 6 * n)
    assert jacobian.robots.shape == (6 * n, 7 * m)
    if n:
        gradient = ExtractGradient(updated.get_vector(0).CopyToVector())
        np.testing.assert_allclose(jacobian.states, gradient, atol=1e-12)


def test_a_crowd_converts_and_stays_the_same_class():
    dut, _ = make_moody_crowd(0)
    converted = dut.ToAutoDiffXd()
    assert isinstance(dut, HumanCrowd)
    assert isinstance(dut, LeafSystem)
    assert isinstance(converted, HumanCrowd_[AutoDiffXd])
    assert HumanCrowd_[float] is HumanCrowd
    assert converted.num_input_ports() == dut.num_input_ports()
    back = converted.ToScalarType[float]()
    assert isinstance(back, HumanCrowd)
    assert dut.ToSymbolicMaybe() is None
    assert pickle.loads(pickle.dumps(HumanCrowd)) is HumanCrowd
    assert copy.copy(HumanCrowd) is HumanCrowd


def test_a_diagram_with_a_crowd_converts():
    builder = DiagramBuilder()
    human = HumanConfig(pose=[0, 0, 0])
    crowd = builder.AddNamedSystem("crowd", HumanCrowd([human], num_robots=0))
    command = builder.AddSystem(
        ConstantVectorSource([5, 0, 0.3, 1, 1, 1, 0, 0, 0, 0, 0, -1])
    )
    builder.Connect(command.get_output_port(), crowd.get_commands_input_port())
    converted = builder.Build().ToAutoDiffXd()
    crowd = converted.GetSubsystemByName("crowd")
    context = crowd.GetMyContextFromRoot(converted.CreateDefaultContext())
    forces = crowd.GetOutputPort("forces").Eval(context)
    assert forces[0].value() == pytest.approx(2.0 * 1.0 / 0.5)


def test_a_model_without_derivatives_says_so():
    @register_motion_model("test_autodiff: everybody stands")
    @dataclasses.dataclass
    class Standing(MotionModel):
        def forces(self, snapshot):
            return np.zeros((len(snapshot.states), 16))

        def advance(self, snapshot, forces):
            return snapshot.states

    dut = HumanCrowd(
        [], config=CrowdConfig(model="test_autodiff: everybody stands")
    )
    message = "need the motion model 'social_force'; .*everybody stands"
    with pytest.raises(ValueError, match=message):
        dut.ToAutoDiffXd()
    with pytest.raises(ValueError, match=message):
        dut.CalcJacobian(dut.CreateDefaultContext())


def test_only_plain_crowds_calculate_the_jacobian():
    dut, _ = make_moody_crowd(0)
    converted = dut.ToAutoDiffXd()
    with pytest.raises(TypeError, match="HumanCrowd_\\[float\\]"):
        converted.CalcJacobian(converted.CreateDefaultContext())


def test_people_who_are_placed_have_no_derivatives():
    """They would be moved by forces: AutoDiff's step would be another one."""
    dut, context = make_moody_crowd(1)
    commands = dut.get_commands_input_port().Eval(context)
    rows = commands.reshape(N, COMMAND_SIZE)
    rows[[1, 4], Command.HOLD] = Hold.PLACED
    dut.get_commands_input_port().FixValue(context, rows.ravel())
    message = r"no derivatives; these are in the rows \[1, 4\]"
    with pytest.raises(ValueError, match=message):
        dut.CalcJacobian(context)
    with pytest.raises(ValueError, match=message):
        autodiff_step(dut, context)
