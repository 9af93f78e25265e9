"""HuNavSim's services: people for another simulator."""

import dataclasses
import json
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import HumanConfig, LoadScenario, MakeTrialDiagram
from hunav_drake.hunavsim.services import AgentServices
from hunav_drake.systems.crowd import CrowdConfig, DecisionsConfig
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.obstacles import Obstacles
from tests.recorded import read_recorded, single
from tests.walkers import make_walkers

ROBOT = [3.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.3]


def make_people(n=3):
    """Two of a group, and others."""
    walkers = make_walkers(n, xs=(1.5, 6.0), spacing=0.8, cyclic=False)
    return [
        dataclasses.replace(human, id=10 + i, group_id=0 if i < 2 else -1)
        for i, human in enumerate(walkers)
    ]


@pytest.fixture
def dut():
    return AgentServices(make_people())


def walk_by_service(services, states, steps):
    """The states after each of some steps, everyone moved as told."""
    history = []
    for _ in range(steps):
        states, _ = services.compute_agents(states, ROBOT)
        history.append(states)
    return np.array(history)


def test_people_move_as_in_a_trial():
    """Fed with the trial's own states, to the last bit."""
    scenario = LoadScenario(
        filename="crossing", overrides=["simulation.start_jitter=0.0"]
    )
    diagram = MakeTrialDiagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_context()
    dut = AgentServices(
        scenario.humans,
        obstacles=scenario.world.obstacles(),
        config=scenario.crowd,
        time_step=scenario.simulation.time_step,
    )

    def look(name):
        return diagram.GetOutputPort(name).Eval(context).copy()

    for k in range(300):
        now = look("human_states").reshape(-1, 7)
        robot = look("robot_state")
        status = look("behavior_status")
        agents = dut.compute_agents(now, robot, scenario.simulation.time_step)
        # Held states are those after the update at the present instant.
        simulator.AdvanceTo((k + 0.5) * scenario.simulation.time_step)
        np.testing.assert_array_equal(
            agents.states.ravel(), look("human_states")
        )
        np.testing.assert_array_equal(agents.behavior_status, status)


def test_moving_one_by_one_is_moving_all(dut):
    other = AgentServices(make_people())
    states = dut.agents.states
    for _ in range(60):
        agents = dut.compute_agents(states, ROBOT)
        one_by_one = [
            other.move_agent(states, ROBOT, agent_id)
            for agent_id in (12, 10, 11)
        ]
        np.testing.assert_array_equal(
            agents.states[[2, 0, 1]], [one.states for one in one_by_one]
        )
        assert [int(one.behavior_status) for one in one_by_one] == [0, 0, 0]
        states = agents.states
    assert (states[:, 0] > 2).all()


@pytest.mark.parametrize("decisions", [None, DecisionsConfig()])
def test_guides_and_decisions_go_on_one_by_one(decisions):
    """What people show each other, and the time, are those of all."""
    first, *others = make_people()
    first = dataclasses.replace(
        first, behavior={"type": "guide", "ports": {"people": "11, 12"}}
    )
    config = CrowdConfig(decisions=decisions)
    dut, other = (
        AgentServices([first, *others], config=config) for _ in range(2)
    )
    states = dut.agents.states
    for _ in range(12):
        agents = dut.compute_agents(states, ROBOT)
        for agent_id in (12, 10, 11):
            other.move_agent(states, ROBOT, agent_id)
        states = agents.states
        np.testing.assert_array_equal(other.agents.states, states)


def test_behaviors_may_name_places():
    first, *others = make_people()
    first = dataclasses.replace(
        first, behavior={"type": "queue", "ports": {"place": "desk"}}
    )
    desk = Place(name="desk", type="counter", pose=(4.0, 0.0, 0.0))
    dut = AgentServices([first, *others], places=[desk])
    after = walk_by_service(dut, dut.agents.states, 200)[-1]
    assert math.dist(after[0, :2], desk.pose[:2]) < 0.5


def test_compute_agent_goes_on_from_what_is_known(dut):
    dut.reset_agents(robot=ROBOT)
    states = dut.agents.states
    moved = dut.compute_agent(11)
    expected = AgentServices(make_people()).compute_agents(states, ROBOT)
    np.testing.assert_array_equal(moved.states, expected.states[1])
    # The others have not moved.
    after = dut.agents.states
    np.testing.assert_array_equal(after[[0, 2]], states[[0, 2]])
    np.testing.assert_array_equal(after[1], moved.states)


def test_the_caller_owns_where_people_are(dut):
    """Someone held back by the other simulator goes on from there."""
    states = walk_by_service(dut, dut.agents.states, 20)[-1]
    held = states.copy()
    held[0] = [-1.0, 5.0, 0.3, 0.0, 0.0, 0.0, 0.35]
    after, _ = dut.compute_agents(held, ROBOT)
    assert math.dist(after[0, :2], held[0, :2]) < 0.1
    np.testing.assert_array_equal(after[:, 6], 0.35)


@pytest.mark.parametrize("dt", [0.15, np.float32(0.15), 0.15 + 1e-9])
def test_a_longer_time_is_several_steps(dut, dt):
    states = dut.agents.states
    in_steps = walk_by_service(AgentServices(make_people()), states, 3)[-1]
    at_once, _ = dut.compute_agents(states, ROBOT, dt)
    np.testing.assert_array_equal(at_once, in_steps)


@pytest.mark.parametrize("dt", [0.0, -0.05, 0.07, 0.01, math.nan, math.inf])
def test_a_time_that_is_no_number_of_steps_is_refused(dut, dt):
    states = dut.agents.states
    calls = [
        lambda: dut.compute_agents(states, ROBOT, dt),
        lambda: dut.move_agent(states, ROBOT, 10, dt),
        lambda: dut.compute_agent(10, dt),
    ]
    for call in calls:
        with pytest.raises(ValueError, match=r"steps of 0\.05 s, got"):
            call()


def test_two_simulators_do_not_disturb_each_other(dut):
    alone = walk_by_service(AgentServices(make_people()), dut.agents.states, 40)
    other = AgentServices(make_people())
    states = dut.agents.states
    other_states = states + np.array([0, 3, 0, 0, 0, 0, 0])
    for expected in alone:
        states, _ = dut.compute_agents(states, ROBOT)
        other_states, _ = other.compute_agents(other_states, ROBOT)
        np.testing.assert_array_equal(states, expected)


def test_reset_starts_again(dut):
    start = dut.agents.states
    first = walk_by_service(dut, start, 60)
    assert (first[-1, :, 0] > 2).all()
    agents = dut.reset_agents()
    np.testing.assert_array_equal(agents.states, start)
    np.testing.assert_array_equal(
        walk_by_service(dut, agents.states, 60), first
    )


def test_a_reset_may_draw_weights_anew():
    people = [
        dataclasses.replace(human, forces_mode="random_uniform")
        for human in make_people()
    ]
    first, other = (
        walk_by_service(dut, dut.agents.states, 20)
        for dut in (AgentServices(people), AgentServices(people, seed=3))
    )
    assert (first[-1] != other[-1]).any()
    dut = AgentServices(people)
    dut.reset_agents(seed=3)
    np.testing.assert_array_equal(
        walk_by_service(dut, dut.agents.states, 20), other
    )
    # They keep them from then on.
    dut.reset_agents()
    np.testing.assert_array_equal(
        walk_by_service(dut, dut.agents.states, 20), other
    )
    with pytest.raises(ValueError, match="seed must be a whole number"):
        dut.reset_agents(seed=-1)


def test_reset_puts_people_where_they_are_said_to_be(dut):
    states = dut.agents.states + np.array([0.5, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(
        dut.reset_agents(states, ROBOT).states, states
    )
    assert np.isfinite(dut.compute_agent(10).states).all()


def test_a_refused_reset_changes_nothing(dut):
    before = walk_by_service(dut, dut.agents.states, 5)[-1]
    with pytest.raises(ValueError, match="robot must hold 1 rows"):
        dut.reset_agents(robot=ROBOT[:3])
    np.testing.assert_array_equal(dut.agents.states, before)


def test_what_people_have_in_mind_can_be_saved(dut):
    states = walk_by_service(dut, dut.agents.states, 30)[-1]
    saved = dut.context.Clone()
    future = walk_by_service(dut, states, 30)
    dut.context = saved
    np.testing.assert_array_equal(dut.agents.states, states)
    np.testing.assert_array_equal(walk_by_service(dut, states, 30), future)
    # The saved Context is not touched.
    assert saved.get_time() == pytest.approx(1.5)


def test_a_context_of_other_people_is_refused(dut):
    with pytest.raises(RuntimeError):
        dut.context = AgentServices(make_people()).context


def test_people_feel_walls():
    wall = Obstacles.from_shapes([[[-9, -0.5], [9, -0.5]]], solid=[False])
    dut = AgentServices(make_people(1), obstacles=wall, num_robots=0)
    states, _ = dut.compute_agents(dut.agents.states)
    assert states[0, 1] > 0


@pytest.mark.parametrize("num_robots", [0, 1, 2])
@pytest.mark.parametrize("n", [0, 1, 3])
def test_any_number_will_do(n, num_robots):
    dut = AgentServices(make_people(n), num_robots=num_robots)
    robots = np.array([ROBOT] * num_robots)
    agents = dut.compute_agents(dut.agents.states, robots)
    assert agents.states.shape == (n, 7)
    assert agents.behavior_status.shape == (n,)
    if num_robots == 0:
        dut.compute_agents(dut.agents.states)


@pytest.mark.parametrize(
    ("humans", "robot", "message"),
    [
        (np.zeros((2, 7)), ROBOT, r"humans must hold 3 rows .* shape \(2, 7\)"),
        (np.zeros((7, 3)), ROBOT, r"humans must hold 3 rows .* shape \(7, 3\)"),
        (np.full((3, 7), np.nan), ROBOT, "humans must be finite, got the row"),
        (np.zeros((3, 7)), None, "robot must hold 1 rows"),
        (np.zeros((3, 7)), [math.inf] * 7, "robot must be finite"),
    ],
)
def test_what_does_not_fit_is_refused(dut, humans, robot, message):
    before = dut.agents.states
    with pytest.raises(ValueError, match=message):
        dut.compute_agents(humans, robot)
    np.testing.assert_array_equal(dut.agents.states, before)


def test_nobody_has_that_number(dut):
    with pytest.raises(ValueError, match="nobody has the number 1; there are"):
        dut.move_agent(dut.agents.states, ROBOT, 1)


def test_the_robot_must_be_known(dut):
    with pytest.raises(ValueError, match="not known yet where the robots"):
        dut.compute_agent(10)


def test_numbers_are_unique():
    people = make_people(1) * 2
    with pytest.raises(ValueError, match="two people have the number 10"):
        AgentServices(people)


def test_everybodys_step_is_computed_once(dut, monkeypatch):
    count = []
    begin = AgentServices._begin

    def counted(self, given, points):
        count.append(given)
        return begin(self, given, points)

    monkeypatch.setattr(AgentServices, "_begin", counted)
    states = dut.agents.states
    for expected in (1, 2):
        # The second time, nobody has been moved: a new step.
        for agent_id in (10, 11, 12):
            dut.move_agent(states, ROBOT, agent_id)
        assert len(count) == expected
    dut.move_agent(states + 0.1, ROBOT, 10)
    assert len(count) == 3
    # What was left of that step is not taken by the others.
    dut.compute_agents(states, ROBOT)
    dut.move_agent(states + 0.1, ROBOT, 11)
    assert len(count) == 4


def test_the_context_put_back_ends_what_was_begun(dut):
    states = walk_by_service(dut, dut.agents.states, 20)[-1]
    saved = dut.context.Clone()
    first = dut.move_agent(states, ROBOT, 10).states
    dut.move_agent(states, ROBOT, 11)
    dut.context = saved
    np.testing.assert_array_equal(
        dut.move_agent(states, ROBOT, 10).states, first
    )


def test_numbers_too_large_are_refused(dut):
    states = dut.agents.states
    states[1, 3] = 1e154
    with pytest.raises(ValueError, match=r"no numbers beyond 1e\+12, got"):
        dut.compute_agents(states, ROBOT)


@pytest.mark.parametrize("dt", ["0.05", True])
def test_a_time_that_is_no_number_is_refused(dut, dt):
    # True counts as 1 in Python, and would be 20 steps.
    states = dut.agents.states
    calls = [
        lambda: dut.compute_agents(states, ROBOT, dt),
        lambda: dut.move_agent(states, ROBOT, 10, dt),
        lambda: dut.compute_agent(10, dt),
    ]
    for call in calls:
        with pytest.raises(TypeError, match=r"dt must be a number, .* got"):
            call()


@pytest.mark.parametrize("humans", ["here", {"x": 1}, [[0, 0], [0]], 10**400])
def test_states_that_are_no_numbers_are_refused(dut, humans):
    with pytest.raises(ValueError, match="humans must hold numbers: "):
        dut.compute_agents(humans, ROBOT)


def test_points_of_a_person_replace_the_walls_in_that_call():
    """Who is given points moves as if the world were made of them."""
    people = make_people()
    walls = Obstacles.from_points([[0.6, 0.1], [0.6, 0.9]])
    points = [[0.5, 0.2], [0.4, -0.5], [7.0, 0.0]]
    dut = AgentServices(people, obstacles=walls)
    usual = AgentServices(people, obstacles=walls)
    at_points = AgentServices(
        people,
        obstacles=Obstacles.from_points(points),
        config=CrowdConfig(
            route_planning=False, keep_out_of_walls=False, obstacle_range=1e5
        ),
    )
    free = AgentServices(people)
    states = dut.agents.states
    # The height of HuNavSim's points is not read.
    given = [[*point, 1.0] for point in points]
    for _ in range(20):
        moved = dut.compute_agents(
            states, ROBOT, closest_obs=[given, None, []]
        ).states
        expected = [
            services.compute_agents(states, ROBOT).states
            for services in (at_points, usual, free)
        ]
        for i in range(3):
            np.testing.assert_array_equal(moved[i], expected[i][i])
        assert (abs(expected[0][0] - expected[1][0]) > 1e-6).any()
        states = moved
    # The next call knows nothing of them.
    np.testing.assert_array_equal(
        dut.compute_agents(states, ROBOT).states,
        usual.compute_agents(states, ROBOT).states,
    )


def test_who_is_moved_alone_sees_nobody_moved():
    """By HuNavSim's rules, the others have moved only if all are moved."""
    people = [
        HumanConfig(
            id=i, pose=[1.0, 0.5 * i, 0.0], goals=[[9, 0]], behavior="scared"
        )
        for i in (1, 2)
    ]
    given = AgentServices(people).agents.states
    given[:, 3] = 0.5

    def moved(order, number=None):
        """The row of the first person, of two who are listed in an order."""
        services = AgentServices(
            [people[i] for i in order], config=CrowdConfig(profile="hunavsim")
        )
        if number is not None:
            return services.move_agent(given[order], ROBOT, number).states
        return services.compute_agents(given[order], ROBOT).states[
            order.index(0)
        ]

    # Whose number was put last into the hash table moves first.
    np.testing.assert_array_equal(moved([1, 0]), moved([1, 0], 1))
    np.testing.assert_array_equal(moved([1, 0], 1), moved([0, 1], 1))
    assert (moved([0, 1]) != moved([0, 1], 1)).any()


def test_people_whom_points_push_together_keep_apart():
    """Each of them knows that the other is pushed, too."""
    people = [
        HumanConfig(pose=[x, 0.0, 0.0], goals=[[9 - x, 0.0]])
        for x in (0.0, 0.6)
    ]
    dut = AgentServices(people, num_robots=0)
    states = dut.agents.states
    points = [[[-0.3, 0.05]], [[0.9, 0.05]]]
    for _ in range(10):
        states = dut.compute_agents(states, closest_obs=points).states
        apart = math.dist(states[0, :2], states[1, :2])
        assert apart > 0.5 - 1e-3
    assert apart < 0.55


@pytest.mark.parametrize("steps", [1, 3])
def test_points_count_for_one_who_is_moved_alone(steps):
    together = AgentServices(make_people())
    alone = AgentServices(make_people())
    points = [[[0.5, 0.2]], None, [[0.4, 1.5]]]
    states = together.agents.states
    if steps == 1:
        moved = together.compute_agents(
            states, ROBOT, closest_obs=points
        ).states
        for i in range(3):
            row = alone.move_agent(
                states, ROBOT, 10 + i, closest_obs=points
            ).states
            np.testing.assert_array_equal(row, moved[i])
    else:
        near = alone.move_agent(
            states, ROBOT, 10, dt=0.05 * steps, closest_obs=points
        ).states
        far = together.move_agent(states, ROBOT, 10, dt=0.05 * steps).states
        assert (abs(near - far) > 1e-3).any()


def test_other_points_begin_a_new_step():
    dut = AgentServices(make_people())
    states = dut.agents.states
    first = dut.move_agent(
        states, ROBOT, 10, closest_obs=[[[0.5, 0.2]], None, None]
    )
    second = dut.move_agent(
        states, ROBOT, 11, closest_obs=[None, [[0.5, 0.9]], None]
    )
    free = AgentServices(make_people()).compute_agents(states, ROBOT)
    assert (first.states != free.states[0]).any()
    assert (second.states != free.states[1]).any()


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([None], "for each of 3 people, got 1"),
        ("abc", "for each of 3 people, got 3"),
        ([None, [[1.0]], None], r"closest_obs\[1\] must hold rows"),
        ([None, [1.0, 2.0], None], r"closest_obs\[1\] must hold rows"),
        ([[["x", 1]], None, None], r"closest_obs\[0\] must hold numbers"),
        ([[[np.nan, 1]], None, None], r"closest_obs\[0\] must be finite"),
        ([[[1e6, 1]], None, None], "within 100000 m"),
    ],
)
def test_faulty_points_are_refused(dut, points, words):
    states = dut.agents.states
    before = states.copy()
    with pytest.raises(ValueError, match=words):
        dut.compute_agents(states, ROBOT, closest_obs=points)
    np.testing.assert_array_equal(dut.agents.states, before)


def test_points_of_the_original_give_its_steps():
    """HuNavSim's simulators tell each person the nearest point, or some."""
    case = json.loads(read_recorded("crowd/30_regular5_obstacles"))
    scenario = case["scenario"]
    walls = scenario["obstacles"]
    dut = AgentServices(
        [
            HumanConfig(
                id=agent["id"],
                pose=[agent["x"], agent["y"], agent["yaw"]],
                desired_speed=agent["desired_velocity"],
                radius=agent["radius"],
                goals=agent["goals"],
                goal_radius=agent["goal_radius"],
            )
            for agent in scenario["agents"]
        ],
        config=CrowdConfig(profile="hunavsim"),
        time_step=scenario["dt"],
    )
    points = np.array(walls["points"])
    states = dut.agents.states
    for step in case["trace"]["steps"][1:150]:
        near = []
        for x, y in states[:, :2]:
            away = np.hypot(*(points - [x, y]).T)
            order = np.argsort(away, kind="stable")[: walls["count"]]
            near.append(points[order[away[order] <= walls["max_dist"]]])
        robot = [*step["robot"], single(scenario["robot"]["radius"])]
        states = dut.compute_agents(states, robot, closest_obs=near).states
        np.testing.assert_allclose(
            states[:, [0, 1, 3, 4]],
            np.array(step["agents"])[:, [0, 1, 3, 4]],
            rtol=0,
            atol=1e-9,
        )
