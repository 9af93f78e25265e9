"""The mark of each reaction, in its own scenario, with the robot driving."""

import dataclasses
import functools
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
)
from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import MakeHumans
from tests.choices import fast
from tests.systems.behavior.ticks import all_discrete_state

REACTIONS = [
    "surprised",
    "scared",
    "curious",
    "threatening",
    "distracted",
    "cooperative",
]
both_steps = pytest.mark.parametrize(
    "time_step", [0.05, pytest.param(0.01, marks=pytest.mark.slow)]
)


@functools.cache
def run(reaction, time_step, behavior=None, **crowd):
    """Returns the recording of a reaction's scenario, a row each 0.05 s."""
    overrides = [f"simulation.time_step={time_step}", "evaluator.period=0.05"]
    overrides += [f"crowd.{key}={value}" for key, value in crowd.items()]
    if behavior:
        overrides.append(f"humans[0].behavior={behavior}")
    scenario = LoadScenario(
        filename=f"reaction_{reaction}", overrides=overrides
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    return result.recording


def offsets(recording):
    """From the person to the robot, shape (n, 2)."""
    return recording.robot[:, :2] - recording.humans[:, 0, :2]


def distances(recording):
    return np.hypot(*offsets(recording).T)


def speeds(recording):
    return np.hypot(*recording.humans[:, 0, 3:5].T)


def is_active(recording):
    return recording.behavior_status[:, 0] > 0


def phases(recording):
    """The first and the last active row, and how many times it starts."""
    active = is_active(recording)
    rows = np.flatnonzero(active)
    starts = np.count_nonzero(np.diff(active.astype(int)) == 1) + active[0]
    return rows[0], rows[-1], starts


@both_steps
def test_surprised_person_stands_and_faces_the_driving_robot(time_step):
    recording = run("surprised", time_step)
    first, last, starts = phases(recording)
    assert starts == 1
    # A half turn takes a second at most.
    standing = slice(first + 20, last + 1)
    assert (speeds(recording)[standing] == 0).all()
    bearing = np.arctan2(*offsets(recording)[standing].T[::-1])
    turn = bearing - recording.humans[standing, 0, YAW]
    assert np.abs(np.angle(np.exp(1j * turn))).max() < 0.05
    assert recording.robot[standing, X].max() > 2
    assert distances(recording)[first] <= 4.0
    # Then the person walks on, to the goal.
    assert speeds(recording)[last + 20] > 0.5
    assert np.hypot(*(recording.humans[-1, 0, :2] - [-7.0, 1.5])) < 1.0


@both_steps
def test_scared_person_keeps_farther_off_than_a_regular_one(time_step):
    scared = run("scared", time_step)
    regular = run("scared", time_step, "regular")
    assert distances(scared).min() > distances(regular).min() + 0.5
    first, last, starts = phases(scared)
    assert starts == 1
    assert distances(scared)[first] <= 3.0
    # It ends a second after the robot is 4 m away, 1 m farther than it began.
    assert distances(scared)[last - 21] <= 4.0 < distances(scared)[last - 18]
    # It slows down by 2.5 m/s^2 and what the push adds, not at once.
    assert np.diff(speeds(scared)[first : last + 1]).min() > -4.0 * 0.05
    slow = slice(first + 8, last + 1)
    assert speeds(scared)[slow].max() <= 0.6 + 1e-9
    assert np.hypot(*(scared.humans[-1, 0, :2] - [-7.0, 0.8])) < 0.5


@both_steps
def test_curious_person_stops_before_the_robot_and_leaves(time_step):
    recording = run("curious", time_step)
    first, last, starts = phases(recording)
    assert starts == 1
    assert (last - first + 1) * 0.05 == pytest.approx(30.0, abs=0.1)
    standing = is_active(recording) & (speeds(recording) == 0)
    stop = np.flatnonzero(standing & (np.arange(len(standing)) > 5))[0]
    assert distances(recording)[stop] == pytest.approx(1.5, abs=0.2)
    # It goes along with the robot, that far behind.
    behind = distances(recording)[last - 100 : last]
    assert behind == pytest.approx(1.5, abs=0.2)
    assert distances(recording)[last + 100] > 2.5
    assert recording.humans[-1, 0, X] > 7
    assert (recording.robot[first + 20 : last, 3] > 0.2).all()


@both_steps
def test_threatening_person_stays_in_front_of_the_robot(time_step):
    recording = run("threatening", time_step)
    first, last, starts = phases(recording)
    assert starts == 1
    assert (last - first + 1) * 0.05 == pytest.approx(40.0, abs=0.1)
    yaw = recording.robot[:, YAW]
    front = recording.robot[:, :2] + 1.1 * np.stack(
        [np.cos(yaw), np.sin(yaw)], axis=1
    )
    to_front = np.hypot(*(recording.humans[:, 0, :2] - front).T)
    near = to_front[first : last + 1] < 0.6
    assert near.mean() > 0.9
    # Being in the way slows the robot down, but does not stop it.
    driven = np.hypot(*(recording.robot[last, :2] - recording.robot[first, :2]))
    assert 5 < driven < 0.5 * 0.6 * 40
    assert np.hypot(*(recording.humans[-1, 0, :2] - [8.0, 3.0])) < 0.7


@both_steps
def test_distracted_person_notices_the_robot_late(time_step):
    distracted = run("distracted", time_step)
    regular = run("distracted", time_step, "regular")
    first, last, _ = phases(distracted)
    assert 1.3 < distances(distracted)[first] <= 1.5
    assert last - first < 60
    # Until then it walks straight on, where a regular person gives way.
    assert np.abs(distracted.humans[:first, 0, Y] - 0.6).max() < 1e-4
    assert np.abs(regular.humans[:first, 0, Y] - 0.6).max() > 0.02
    # Then it gets past the robot, too.
    assert distances(distracted).min() > 0.75


@both_steps
def test_cooperative_person_lets_the_robot_pass(time_step):
    cooperative = run("cooperative", time_step)
    regular = run("cooperative", time_step, "regular", robot_gap=0.0)
    _, last, starts = phases(cooperative)
    assert starts == 1
    assert distances(cooperative).min() > 0.8 > distances(regular).min()
    # The robot need not slow down, and is there sooner.
    cruising = slice(40, len(cooperative.times) - 60)
    assert cooperative.robot[cruising, 3].min() > 0.55
    assert cooperative.times[-1] < regular.times[-1]
    assert speeds(cooperative)[last + 20] > 0.5
    assert np.hypot(*(cooperative.humans[-1, 0, :2] - [-7.0, 0.1])) < 0.5


def test_scared_person_in_a_corridor_starts_once():
    """It flees from the robot ahead, and from the one that it has passed."""
    recording = run_in_corridor(
        "scared",
        2.6,
        "humans[0].behavior={type: scared, ports: {make_way: false}}",
    )
    active = is_active(recording)
    changes = recording.times[1:][np.diff(active)]
    # It is driven back to the end, and has had enough after 40 s.
    assert changes[1] - changes[0] == pytest.approx(40.0, abs=0.15)


def run_in_corridor(reaction, width, *overrides):
    """Returns the recording of a reaction in a corridor of some width."""
    # (Each step is recorded: reactions may pause for one.)
    scenario = LoadScenario(
        filename=f"reaction_{reaction}",
        overrides=["evaluator.period=0.05", *overrides],
    )
    walls = []
    for wall in scenario.world.walls:
        x, y = wall.center
        if wall.name in ("north", "south"):
            y = math.copysign(width / 2 + wall.size[1] / 2, y)
        walls.append(dataclasses.replace(wall, center=(x, y)))
    world = dataclasses.replace(scenario.world, walls=walls)
    scenario = dataclasses.replace(scenario, world=world)
    return RunTrial(scenario).recording


@pytest.mark.parametrize("width", [2.4, 2.6, 2.8, 3.0])
def test_cooperative_person_does_not_walk_through_the_robot(width):
    """It leans on the wall, so that the robot need not stop."""
    recording = run_in_corridor("cooperative", width)
    # The body is 0.25 m wide to each side.
    assert distances(recording).min() > min(0.95, width / 2 - 0.35)
    assert phases(recording)[2] == 1
    stopped = (recording.robot[60:-60, 3] < 0.01).sum() * 0.1
    assert stopped == 0
    assert np.hypot(*(recording.humans[-1, 0, :2] - [-7.0, 0.1])) < 0.5
    assert recording.robot[-1, X] > 7.7


@pytest.mark.parametrize("width", [2.4, 3.0])
@pytest.mark.parametrize("stop", [-3.0, -1.0])
def test_cooperative_person_passes_a_robot_that_has_stopped(width, stop):
    """It comes, and stays where it is for good."""
    edges = [
        [[-20.0, side * width / 2], [20.0, side * width / 2]]
        for side in (1, -1)
    ]
    human = HumanConfig(
        pose=(7.0, 0.1, math.pi), goals=[(-7.0, 0.1)], behavior="cooperative"
    )
    people = MakeHumans(
        [human], obstacles=Obstacles.from_shapes(edges, solid=[False, False])
    )
    simulator = Simulator(people)
    context = simulator.get_mutable_context()
    positions, active = [], []
    for step in range(700):
        x = min(-8.0 + 0.6 * 0.05 * step, stop)
        robot = [x, 0.0, 0.0, 0.6 if x < stop else 0.0, 0.0, 0.0, 0.35]
        people.GetInputPort("robot_states").FixValue(context, robot)
        simulator.AdvanceTo(0.05 * (step + 0.5))
        states = people.GetOutputPort("human_states").Eval(context)
        positions.append([states[0] - x, states[1]])
        active.append(people.GetOutputPort("behavior_status").Eval(context)[0])
    assert np.hypot(*np.transpose(positions)).min() > 0.65
    assert np.count_nonzero(np.diff(active)) <= 4
    assert states[:2] == pytest.approx([-7.0, 0.1], abs=0.5)


def walk_past(robots, width=None):
    """Returns the way of a cooperative person past robots that stand."""
    edges = [
        [[-5.0, side * width / 2], [15.0, side * width / 2]]
        for side in ((1, -1) if width else ())
    ]
    human = HumanConfig(
        pose=(0.0, 0.0, 0.0), goals=[(10.0, 0.0)], behavior="cooperative"
    )
    people = MakeHumans(
        [human],
        obstacles=Obstacles.from_shapes(edges, solid=[False] * len(edges)),
        num_robots=len(robots),
    )
    simulator = Simulator(people)
    context = simulator.get_mutable_context()
    rows = [[*xy, math.pi, 0.0, 0.0, 0.0, 0.3] for xy in robots]
    people.GetInputPort("robot_states").FixValue(context, np.ravel(rows))
    way, active = [], []
    for step in range(300):
        simulator.AdvanceTo(0.05 * (step + 0.5))
        way.append(people.GetOutputPort("human_states").Eval(context)[:2])
        active.append(people.GetOutputPort("behavior_status").Eval(context)[0])
    assert way[-1] == pytest.approx([10.0, 0.0], abs=0.5)
    assert np.count_nonzero(np.diff(active)) == 2
    return np.array(way)


# Of a person of 0.35 m radius and a robot of 0.3 m in the middle. A corridor
# of less than 2 m is too narrow for both; just above, walls push the person
# into the robot a little, as there is a force of walls and no hard contact.
@pytest.mark.parametrize(
    ("width", "overlap"),
    [(1.8, 0.25), (2.0, 0.15), (2.2, 0.08), (2.4, 0.0), (3.0, -0.15)],
)
def test_cooperative_person_arrives_past_a_standing_robot(width, overlap):
    way = walk_past([(5.0, 0.0)], width)
    assert np.hypot(*(way - [5.0, 0.0]).T).min() > 0.65 - overlap
    # It does not turn back.
    assert np.diff(way[:, 0]).min() > -0.01


@pytest.mark.parametrize("y", [0.3, 0.4, 0.6, 0.8])
def test_cooperative_person_goes_around_two_robots_side_by_side(y):
    robots = [(5.0, y), (5.0, -y)]
    way = walk_past(robots)
    for robot in robots:
        assert np.hypot(*(way - robot).T).min() > 1.0
    assert np.diff(way[:, 0]).min() > -0.01


# The largest difference of two runs of a reaction, in rows of 0.05 s and in m:
# of a whole reaction, and of its end position.
SAME_OUTCOME = {
    "surprised": (2, 0.05),
    "scared": (4, 0.1),
    "curious": (2, 0.2),
    "threatening": (2, 0.2),
    "distracted": (2, 0.05),
    "cooperative": (8, 0.1),
}


@pytest.mark.parametrize("reaction", fast(REACTIONS, "surprised"))
def test_both_steps_have_the_same_outcome(reaction):
    coarse, fine = run(reaction, 0.05), run(reaction, 0.01)
    rows, meters = SAME_OUTCOME[reaction]
    assert phases(coarse)[0] == pytest.approx(phases(fine)[0], abs=2)
    assert phases(coarse)[2] == phases(fine)[2]
    active = [np.count_nonzero(is_active(it)) for it in (coarse, fine)]
    assert active[0] == pytest.approx(active[1], abs=rows)
    nearest = [distances(it).min() for it in (coarse, fine)]
    assert nearest[0] == pytest.approx(nearest[1], abs=0.05)
    ends = [it.humans[-1, 0, :2] for it in (coarse, fine)]
    np.testing.assert_allclose(*ends, atol=meters)
    assert coarse.times[-1] == pytest.approx(fine.times[-1], rel=0.1)
    first = slice(0, phases(coarse)[0])
    np.testing.assert_allclose(
        coarse.humans[first, 0, :2], fine.humans[first, 0, :2], atol=0.1
    )


@pytest.mark.parametrize("reaction", REACTIONS)
def test_clone_in_the_middle_of_a_reaction_has_the_same_future(reaction):
    active = is_active(run(reaction, 0.05))
    middle = 0.05 * np.flatnonzero(active)[active.sum() // 2]
    scenario = LoadScenario(filename=f"reaction_{reaction}")
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(middle)
    context = simulator.get_context()
    assert diagram.GetOutputPort("behavior_status").Eval(context) == [1]
    fork = MakeTrialSimulator(diagram, context.Clone())
    for other in (simulator, fork):
        other.AdvanceTo(middle + 5.0)
    np.testing.assert_array_equal(
        all_discrete_state(simulator.get_context()),
        all_discrete_state(fork.get_context()),
    )


@pytest.mark.slow
@pytest.mark.parametrize("model", fast(["social_force", "orca"], "orca"))
def test_three_behaviors_meet_in_the_combined_scenario(model):
    scenario = LoadScenario(
        filename="combined",
        overrides=[f"crowd={{model: {model}}}", "planner=sfw"],
    )
    assert [human.behavior for human in scenario.humans] == [
        "regular",
        "curious",
        "threatening",
    ]
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    # (2 is to make way.)
    status = result.recording.behavior_status == 1
    active = status.sum(axis=0) * 0.1
    assert active[0] == 0
    # The robot may be at its goal before they have had enough.
    for person, enough in ((1, 30), (2, 40)):
        assert active[person] == pytest.approx(enough, abs=0.15) or (
            status[-1, person] and 15 < active[person] < enough
        )
