"""Random decisions: the port, the process, and trials with them."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    HumanConfig,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    ScenarioError,
    SetDecisionSeed,
    SetTrialSeed,
)
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OUTSIDE,
    STATE_SIZE,
    Command,
    Hold,
    X,
    Y,
)
from hunav_drake.systems.crowd import DecisionsConfig, HumanDecisions
from hunav_drake.systems.world.shapes import Box, World

GOAL = slice(Command.GOAL_X, Command.GOAL_Y + 1)
DECIDING = ["crowd.decisions={}", "simulation.duration=6.0"]


def people(n):
    return [HumanConfig(pose=(0.0, float(i), 0.0)) for i in range(n)]


def commands(n, *, goal=(6.0, 0.0), hold=Hold.WALK):
    rows = np.zeros((n, COMMAND_SIZE))
    rows[:, GOAL] = goal
    rows[:, Command.GOAL_RADIUS] = 0.3
    rows[:, Command.HAS_GOAL] = 1.0
    rows[:, Command.DESIRED_SPEED] = 1.0
    rows[:, Command.HOLD] = hold
    return rows


def states(n):
    rows = np.zeros((n, STATE_SIZE))
    rows[:, Y] = np.arange(n)
    return rows


def fixed(dut, rows, command):
    context = dut.CreateDefaultContext()
    dut.GetInputPort("human_states").FixValue(context, rows.ravel())
    dut.GetInputPort("commands").FixValue(context, command.ravel())
    return context


def turned(dut, context):
    return dut.GetOutputPort("commands").Eval(context).reshape(-1, COMMAND_SIZE)


def headings(dut, context):
    return dut.GetOutputPort("headings").Eval(context)


def test_the_port_turns_goals_about_people_by_the_headings():
    dut = HumanDecisions(people(3))
    rows = states(3)
    context = fixed(dut, rows, commands(3))
    angles = headings(dut, context)
    assert (angles != 0).all()
    ways = commands(3)[:, GOAL] - rows[:, [X, Y]]
    found = turned(dut, context)
    for i, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        expected = rows[i, [X, Y]] + [[c, -s], [s, c]] @ ways[i]
        np.testing.assert_allclose(found[i, GOAL], expected, atol=1e-12)
    rest = np.delete(found, [0, 1], axis=1)
    np.testing.assert_array_equal(rest, np.delete(commands(3), [0, 1], axis=1))


@pytest.mark.parametrize(
    "change",
    [
        {Command.HOLD: Hold.STAND},
        {Command.HOLD: Hold.STAY},
        {Command.HOLD: Hold.PLACED},
        {Command.HAS_GOAL: 0.0},
        {Command.GOAL_RADIUS: 7.0},
    ],
)
def test_who_does_not_walk_keeps_the_command(change):
    command = commands(2)
    for name, value in change.items():
        command[0, name] = value
    dut = HumanDecisions(people(2))
    found = turned(dut, fixed(dut, states(2), command))
    np.testing.assert_array_equal(found[0], command[0])
    assert (found[1, GOAL] != command[1, GOAL]).all()


def test_who_is_outside_keeps_the_command():
    rows = states(1)
    rows[0, [X, Y]] = OUTSIDE
    dut = HumanDecisions(people(1))
    found = turned(dut, fixed(dut, rows, commands(1)))
    np.testing.assert_array_equal(found, commands(1))


def test_without_deviation_nothing_changes():
    dut = HumanDecisions(people(2), DecisionsConfig(sigma_heading=0.0))
    found = turned(dut, fixed(dut, states(2), commands(2)))
    np.testing.assert_array_equal(found, commands(2))


def test_no_wall_comes_between_a_person_and_the_turned_goal():
    """In a corridor, far goals would be beyond its walls."""
    walls = World(
        walls=[Box(center=(5, y), size=(20, 0.2)) for y in (-1.0, 1.0)]
    ).obstacles()
    dut = HumanDecisions(
        people(1), DecisionsConfig(sigma_heading=0.3), obstacles=walls
    )
    context = fixed(dut, np.zeros((1, STATE_SIZE)), commands(1, goal=(9, 0)))
    changed = 0
    for seed in range(50):
        dut.SetSeed(context, seed)
        (angle,) = headings(dut, context)
        x, y = turned(dut, context)[0, GOAL]
        assert abs(y) < 0.9
        assert math.isclose(math.atan2(y, x), angle) or (x, y) == (9, 0)
        changed += (x, y) != (9, 0)
    assert changed > 25


def test_the_way_around_a_wall_is_turned_not_the_goal_behind_it():
    wall = World(walls=[Box(center=(3, 0), size=(0.2, 4))]).obstacles()
    dut = HumanDecisions(people(1), obstacles=wall)
    context = fixed(dut, np.zeros((1, STATE_SIZE)), commands(1))
    for seed in range(20):
        dut.SetSeed(context, seed)
        x, y = turned(dut, context)[0, GOAL]
        (angle,) = headings(dut, context)
        # To an end of the wall, or the way of the behavior.
        expected = math.atan2(-2.3, 2.6) + angle
        assert math.isclose(math.atan2(y, x), expected) or (x, y) == (6, 0)


def test_rotated_people_are_turned_alike():
    dut = HumanDecisions(people(4))
    rows, command = states(4), commands(4)
    found = turned(dut, fixed(dut, rows, command))
    c, s = math.cos(0.7), math.sin(0.7)
    rotation = np.array([[c, s], [-s, c]])
    rows[:, [X, Y]] = rows[:, [X, Y]] @ rotation
    command[:, GOAL] = command[:, GOAL] @ rotation
    again = turned(dut, fixed(dut, rows, command))
    np.testing.assert_allclose(
        again[:, GOAL], found[:, GOAL] @ rotation, atol=1e-12
    )


def test_headings_have_the_deviation_and_the_correlation():
    """Also those of time 0: the process is stationary from the start."""
    dut = HumanDecisions(people(400))
    simulator = Simulator(dut, fixed(dut, states(400), commands(400)))
    context = simulator.get_context()
    found = []
    for k in range(12):
        simulator.AdvanceTo(0.25 * k + 0.1)
        found.append(headings(dut, context).copy())
    found = np.array(found)
    np.testing.assert_allclose(found.std(axis=1), 0.2, rtol=0.12)
    assert abs(found.mean()) < 0.01
    pairs = np.corrcoef(found[:-1].ravel(), found[1:].ravel())[0, 1]
    assert abs(pairs - 0.85) < 0.02
    distant = np.corrcoef(found[:-4].ravel(), found[4:].ravel())[0, 1]
    assert abs(distant - 0.85**4) < 0.05


def test_headings_are_held_between_decisions():
    dut = HumanDecisions(people(2), DecisionsConfig(period=0.5))
    simulator = Simulator(dut, fixed(dut, states(2), commands(2)))
    values = []
    for k in range(21):
        simulator.AdvanceTo(0.05 * k + 0.02)
        values.append(tuple(headings(dut, simulator.get_context())))
    assert len(set(values[:10])) == len(set(values[10:20])) == 1
    assert len(set(values)) == 3


def test_more_people_do_not_change_the_decisions_of_others():
    few, many = HumanDecisions(people(2)), HumanDecisions(people(5))
    a = headings(few, fixed(few, states(2), commands(2)))
    b = headings(many, fixed(many, states(5), commands(5)))
    np.testing.assert_array_equal(a, b[:2])


def test_state_and_seed_live_in_the_context():
    """Two contexts of one system do not disturb each other."""
    dut = HumanDecisions(people(2))
    simulator = Simulator(dut, fixed(dut, states(2), commands(2)))
    simulator.AdvanceTo(1.0)
    first, second = (simulator.get_context().Clone() for _ in range(2))
    before = headings(dut, first).copy()
    dut.SetSeed(second, 7)
    assert (dut.GetSeed(first), dut.GetSeed(second)) == (0, 7)
    np.testing.assert_array_equal(headings(dut, first), before)
    later = []
    for context in (first, second):
        fork = Simulator(dut, context)
        fork.AdvanceTo(2.0)
        later.append(headings(dut, fork.get_context()).copy())
    simulator.AdvanceTo(2.0)
    np.testing.assert_array_equal(
        later[0], headings(dut, simulator.get_context())
    )
    assert (later[0] != later[1]).all()


def headings_of(redraws, seed=0):
    """Returns the headings of 12 decisions, one every 0.25 s."""
    dut = HumanDecisions(people(2), DecisionsConfig(redraws=redraws))
    context = fixed(dut, states(2), commands(2))
    dut.SetSeed(context, seed)
    simulator = Simulator(dut, context)
    found = []
    for k in range(12):
        simulator.AdvanceTo(0.25 * k + 0.1)
        found.append(headings(dut, simulator.get_context()).copy())
    return np.array(found)


def test_decisions_are_redrawn_from_a_time_on():
    """The decision at that very time is the first one."""
    plain = headings_of([])
    for time, first in ((1.0, 4), (1.01, 5), (0.0, 0)):
        found = headings_of([(time, 1)])
        np.testing.assert_array_equal(found[:first], plain[:first])
        assert (found[first:] != plain[first:]).all()
    other = headings_of([(1.0, 2)])
    assert (other[4:] != headings_of([(1.0, 1)])[4:]).all()
    twice = headings_of([(1.0, 1), (2.0, 2)])
    np.testing.assert_array_equal(twice[:8], headings_of([(1.0, 1)])[:8])
    assert (twice[8:] != other[8:]).all()


def test_the_seed_counts_in_redrawn_decisions_too():
    redraws = [(1.0, 1)]
    assert (headings_of(redraws, 1) != headings_of(redraws, 2)).all()


def test_redrawn_decisions_are_distributed_alike():
    dut = HumanDecisions(people(400), DecisionsConfig(redraws=[(0.0, 5)]))
    found = headings(dut, fixed(dut, states(400), commands(400)))
    assert found.std() == pytest.approx(0.2, rel=0.12)
    assert abs(found.mean()) < 0.03


@pytest.mark.parametrize("redraws", [[(2.0, 1), (2.0, 2)], [(3, 1), (1, 2)]])
def test_redraws_are_sorted(redraws):
    with pytest.raises(ValueError, match="sorted by time"):
        DecisionsConfig(redraws=redraws)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"seed": -1}, "seed must be"),
        ({"time_step": 0.1}, "period must be a multiple"),
    ],
)
def test_bad_arguments_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        HumanDecisions(people(1), **arguments)


@pytest.fixture(scope="module")
def trial():
    scenario = LoadScenario(filename="passing", overrides=DECIDING)
    return scenario, MakeTrialDiagram(scenario)


def advanced(diagram, context, time):
    simulator = MakeTrialSimulator(diagram, context)
    simulator.AdvanceTo(time)
    states = diagram.GetOutputPort("human_states")
    return states.Eval(simulator.get_context()).copy(), simulator


def test_trials_repeat_by_their_seed_and_differ_by_it(trial):
    scenario, diagram = trial
    assert "decisions of people" in drawn_by_seed(scenario)
    first = RunTrial(scenario, 3, diagram=diagram).recording
    assert RunTrial(scenario, 3).recording == first
    assert RunTrial(scenario, 4, diagram=diagram).recording != first


def test_a_fork_with_another_seed_is_equal_until_the_next_decision(trial):
    _, diagram = trial
    _, simulator = advanced(diagram, None, 2.1)
    saved = simulator.get_context()
    forks = {}
    for seed in (0, 5, 5):
        context = saved.Clone()
        SetDecisionSeed(diagram, context, seed)
        soon, fork = advanced(diagram, context, 2.25)
        fork.AdvanceTo(4.0)
        late = diagram.GetOutputPort("human_states").Eval(fork.get_context())
        if seed in forks:
            np.testing.assert_array_equal(forks[seed][1], late)
        forks[seed] = soon, late.copy()
    simulator.AdvanceTo(4.0)
    through = diagram.GetOutputPort("human_states").Eval(
        simulator.get_context()
    )
    np.testing.assert_array_equal(forks[0][0], forks[5][0])
    np.testing.assert_array_equal(forks[0][1], through)
    assert (forks[0][1] != forks[5][1]).any()


def test_a_saved_context_goes_on_as_the_trial(trial, tmp_path):
    _, diagram = trial
    _, simulator = advanced(diagram, None, 2.1)
    path = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    loaded = LoadContext(diagram, path)
    simulator.AdvanceTo(4.0)
    again, _ = advanced(diagram, loaded, 4.0)
    np.testing.assert_array_equal(
        again,
        diagram.GetOutputPort("human_states").Eval(simulator.get_context()),
    )


def test_the_seed_of_the_trial_reaches_the_decisions(trial):
    _, diagram = trial
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, 11)
    humans = diagram.GetSubsystemByName("humans")
    system = humans.GetSubsystemByName("decisions")
    assert system.GetSeed(system.GetMyContextFromRoot(context)) == 11


def test_without_the_key_there_is_no_system():
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    humans = diagram.GetSubsystemByName("humans")
    assert not humans.HasSubsystemNamed("decisions")
    with pytest.raises(ValueError, match=r"crowd\.decisions"):
        SetDecisionSeed(diagram, diagram.CreateDefaultContext(), 1)


def test_a_period_that_is_no_multiple_of_the_step_is_refused():
    with pytest.raises(ScenarioError, match=r"crowd\.decisions\.period: must"):
        LoadScenario(
            filename="passing", overrides=["crowd.decisions.period=0.13"]
        )


def test_people_on_seats_stay_there():
    """Decisions turn who walks; who sits is placed."""
    scenario = """
world:
  furniture: [{type: chair, center: [3.0, 0.0]}]
humans:
  - {pose: [0.0, 0.0, 0.0], behavior: sit}
robot: {start: [0.0, 8.0, 0.0]}
simulation: {duration: 30.0}
"""
    ends = [
        RunTrial(
            LoadScenario(data=scenario, overrides=overrides)
        ).recording.humans[:, 0, [X, Y]]
        for overrides in ([], ["crowd.decisions={}"])
    ]
    # While it sits, the seat holds it; the way there differs.
    near = [np.hypot(*(end - [3.0, 0.0]).T) < 0.3 for end in ends]
    assert near[0].sum() > 50
    assert near[1].sum() > 50
    seats = [end[flag][20:40] for end, flag in zip(ends, near, strict=True)]
    np.testing.assert_allclose(seats[0], seats[1], atol=0.02)


def test_a_period_that_is_no_multiple_names_its_system():
    with pytest.raises(ValueError, match="HumanDecisions: period must"):
        HumanDecisions([], DecisionsConfig(period=0.25), time_step=0.1)
