"""Rules for any crowd in any room, with every part switched on."""

import math

from hypothesis import given, settings, strategies as st
import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import HumanCrowd
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles, inside

# A room of 10 m by 8 m with two tables and a thin wall.
ROOM = [
    [[-5.2, -4.2], [5.2, -4.2], [5.2, -4.0], [-5.2, -4.0]],
    [[-5.2, 4.0], [5.2, 4.0], [5.2, 4.2], [-5.2, 4.2]],
    [[-5.2, -4.0], [-5.0, -4.0], [-5.0, 4.0], [-5.2, 4.0]],
    [[5.0, -4.0], [5.2, -4.0], [5.2, 4.0], [5.0, 4.0]],
    [[-2.5, -1.0], [-1.0, -1.0], [-1.0, 0.5], [-2.5, 0.5]],
    [[1.0, 1.0], [2.2, 1.4], [1.8, 2.6], [0.6, 2.2]],
    [[1.5, -3.0], [1.5, -0.5]],
]
SOLID = [True] * 6 + [False]

point = st.tuples(st.floats(-4.9, 4.9), st.floats(-3.9, 3.9))


@st.composite
def people_in_room(draw):
    """Draws people: (place, yaw, velocity, goal, radius, group) of each."""
    n = draw(st.integers(0, 7))
    people = []
    for _ in range(n):
        place = draw(point)
        if inside(Obstacles.from_shapes(ROOM, solid=SOLID), place).any():
            place = (0.0, -3.0)
        people.append(
            (
                place,
                draw(st.floats(-3, 3)),
                draw(st.tuples(st.floats(-2, 2), st.floats(-2, 2))),
                draw(point),
                draw(st.floats(0.15, 0.6)),
                draw(st.sampled_from([-1, -1, 0, 1])),
            )
        )
    return people


def generic_people(n, seed):
    """Returns people without the ties of simple numbers.

    In a tie, as of two ways around a table of the same length, rounding
    decides, and a turned world may decide otherwise.
    """
    rng = np.random.default_rng(seed)
    people = []
    while len(people) < n:
        place, goal = rng.uniform([-4.6, -3.6], [4.6, 3.6], (2, 2))
        walls = Obstacles.from_shapes(ROOM, solid=SOLID)
        if not inside(walls, [place, goal]).any():
            people.append(
                (
                    place,
                    rng.uniform(-3, 3),
                    rng.uniform(-1, 1, 2),
                    goal,
                    rng.uniform(0.2, 0.4),
                    rng.integers(-1, 2),
                )
            )
    return people


def run_in_room(
    people, *, matrix=None, epsilon=0.005, steps=30, time_step=0.05
):
    """Returns the states after some steps, in a world that was moved."""
    matrix = np.eye(2) if matrix is None else matrix
    turn = math.atan2(matrix[1, 0], matrix[0, 0])
    sign = np.sign(np.linalg.det(matrix))
    forces = SocialForceParameters(epsilon=epsilon)
    humans = []
    start = np.zeros((len(people), 6))
    commands = np.zeros((len(people), COMMAND_SIZE))
    for i, (place, yaw, velocity, goal, radius, group) in enumerate(people):
        start[i, :2] = matrix @ place
        start[i, 2] = sign * yaw + turn
        start[i, 3:5] = matrix @ velocity
        humans.append(
            HumanConfig(pose=start[i, :3], radius=radius, forces=forces)
        )
        commands[i, :2] = matrix @ goal
        commands[i, Command.GOAL_RADIUS] = 0.3
        commands[i, Command.HAS_GOAL] = 1
        commands[i, Command.DESIRED_SPEED] = 1.2
        commands[i, Command.MAX_SPEED] = 1.5
        commands[i, Command.ROBOT_ROLE] = 1
        commands[i, Command.GROUP_ID] = group
    walls = Obstacles.from_shapes(
        [np.array(shape) @ matrix.T for shape in ROOM], solid=SOLID
    )
    dut = HumanCrowd(humans, obstacles=walls, time_step=time_step)
    context = dut.CreateDefaultContext()
    if people:
        context.SetDiscreteState(0, start.ravel())
    dut.GetInputPort("commands").FixValue(context, commands.ravel())
    robot = np.array([0.0, 0.0, 0.0, 0.4, 0.2, 0.0, 0.3])
    robot[3:5] = matrix @ robot[3:5]
    dut.get_robot_states_input_port().FixValue(context, robot)
    simulator = Simulator(dut, context)
    simulator.AdvanceTo((steps - 0.5) * time_step)
    states = dut.get_human_states_output_port().Eval(simulator.get_context())
    return states.reshape(-1, 7), walls


@given(people_in_room(), st.sampled_from([0.01, 0.05, 0.2]))
def test_nobody_is_lost_too_fast_or_inside_a_wall(people, time_step):
    states, walls = run_in_room(people, time_step=time_step)
    assert np.isfinite(states).all()
    # People who begin faster than the limit brake.
    limit = max(
        [1.5, *(math.hypot(*velocity) for _, _, velocity, *_ in people)]
    )
    assert (np.hypot(states[:, 3], states[:, 4]) <= limit + 1e-12).all()
    assert not inside(walls, states[:, :2]).any()
    assert (abs(states[:, 0]) < 5).all()
    assert (abs(states[:, 1]) < 4).all()


@settings(max_examples=40)
@given(st.integers(0, 9), st.integers(0, 2**32 - 1))
def test_the_order_does_not_matter(n, seed):
    people = generic_people(n, seed)
    order = np.random.default_rng(seed).permutation(n)
    plain, _ = run_in_room(people, steps=20)
    permuted, _ = run_in_room([people[i] for i in order], steps=20)
    np.testing.assert_allclose(permuted, plain[order], atol=1e-6)


@settings(max_examples=40)
@given(
    st.integers(0, 9),
    st.integers(0, 2**32 - 1),
    st.floats(-3, 3),
    st.booleans(),
)
def test_a_turned_or_mirrored_world_is_the_same(n, seed, angle, mirrored):
    people = generic_people(n, seed)
    c, s = math.cos(angle), math.sin(angle)
    sign = -1.0 if mirrored else 1.0
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1.0, sign])
    plain, _ = run_in_room(people, steps=20)
    moved, _ = run_in_room(
        people, steps=20, matrix=matrix, epsilon=sign * 0.005
    )
    np.testing.assert_allclose(moved[:, :2], plain[:, :2] @ matrix.T, atol=1e-6)


def test_the_drawn_people_are_moved_at_all():
    """The properties above are not those of people who stand still."""
    people = [
        ((-4.0, 3.0), 0.0, (0.3, 0.1), (4.0, -3.0), 0.3, -1),
        ((4.1, -2.9), 0.0, (0.1, 0.2), (-4.2, 3.1), 0.35, -1),
    ]
    states, _ = run_in_room(people, steps=40)
    moved = np.hypot(*(states[:, :2] - [p[0] for p in people]).T)
    assert (moved > 1).all()
