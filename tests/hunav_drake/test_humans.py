"""People in a diagram of one's own."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.obstacles import Obstacles

ROBOT = [3.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3]


def make_humans(n):
    return [
        HumanConfig(
            pose=[0, 2 * i, 0], goals=[[6, 2 * i], [0, 2 * i]], cyclic=True
        )
        for i in range(n)
    ]


def simulate(humans, *, time=4.0, robot=ROBOT, **kwargs):
    """Returns what the ports give at a time."""
    builder = DiagramBuilder()
    ports = AddHumans(builder, humans, **kwargs)
    if ports.robot_state is not None:
        source = builder.AddSystem(ConstantVectorSource(robot))
        builder.Connect(source.get_output_port(), ports.robot_state)
    for name in ("human_states", "behavior_status", "forces"):
        builder.ExportOutput(getattr(ports, name), name)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(time)
    context = simulator.get_context()
    return [
        diagram.GetOutputPort(name).Eval(context).reshape(len(humans), width)
        for name, width in (
            ("human_states", 7),
            ("behavior_status", 1),
            ("forces", 16),
        )
    ]


@pytest.mark.parametrize("n", [0, 1, 3])
def test_people_walk_around_a_robot_of_ones_own(n):
    states, status, forces = simulate(make_humans(n))
    assert states.shape == (n, 7)
    assert status.shape == (n, 1)
    assert forces.shape == (n, 16)
    if n:
        assert (states[:, 0] > 3).all()
        # The first person meets the robot and leaves the line.
        assert abs(states[0, 1]) > 0.05


@pytest.mark.parametrize("num_robots", [0, 1, 2])
def test_any_number_of_robots_will_do(num_robots):
    states, _, _ = simulate(
        make_humans(2), num_robots=num_robots, robot=ROBOT * num_robots
    )
    assert np.isfinite(states).all()
    assert (abs(states[0, 1]) > 0.05) == (num_robots > 0)


def test_people_feel_walls():
    wall = Obstacles.from_shapes([[[-9, -0.5], [9, -0.5]]], solid=[False])
    states, _, forces = simulate(make_humans(1), num_robots=0, obstacles=wall)
    assert states[0, 1] > 0.01
    assert forces[0, 3] > 0


def test_an_unknown_behavior_is_refused():
    human = HumanConfig(pose=[0, 0, 0], behavior="reglar")
    with pytest.raises(ValueError, match="reglar"):
        AddHumans(DiagramBuilder(), [human])


def test_goals_are_walked_to_in_turn():
    human = HumanConfig(pose=[0, 0, 0], goals=[[3, 0], [3, 3]])
    states, _, _ = simulate([human], num_robots=0, time=3.3)
    assert states[0, 1] > 0.1
    states, _, _ = simulate([human], num_robots=0, time=30.0)
    np.testing.assert_allclose(states[0, :2], [3, 3], atol=0.5)
    np.testing.assert_allclose(states[0, 3:5], 0, atol=1e-3)
