"""The shipped worlds: rooms that people cross, and a robot on its way."""

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.world.furniture import DoorFrame
from hunav_drake.systems.world.obstacles import inside, nearest_wall
from tests.walkers import seated

# With the number of people, and of doors at least.
WORLDS = {"house": (5, 6), "office": (8, 3), "hospital": (9, 6)}
OTHERS = {"warehouse": (6, 0), "cafe": (5, 0)}


@pytest.mark.parametrize("name", WORLDS)
def test_rooms_have_doors_that_people_go_through(name):
    scenario = LoadScenario(filename=name)
    people, doors = WORLDS[name]
    assert len(scenario.humans) == people
    frames = [
        it for it in scenario.world.furniture if isinstance(it, DoorFrame)
    ]
    assert len(frames) >= doors
    # The openings are as wide as doors of people and robots are.
    for frame in frames:
        assert 0.8 < frame.size[1] - 2 * frame.jamb < 1.5
    # Some start in another room than they go to: no one sees all goals.
    sight = scenario.world.sight_obstacles()
    hidden = 0
    for human in scenario.humans:
        a, b = np.array(human.pose[:2]), np.array(human.goals[-1])
        steps = np.linspace(a, b, 400)
        hidden += inside(sight, steps).any()
    assert hidden >= 3


@pytest.mark.parametrize("name", [*WORLDS, *OTHERS])
def test_there_are_groups_and_behaviors_to_meet(name):
    humans = LoadScenario(filename=name).humans
    assert len({human.behavior_name for human in humans}) >= 3
    if name != "cafe":
        groups = [human.group_id for human in humans if human.group_id >= 0]
        assert len(groups) >= 2
        assert len(set(groups)) < len(groups)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3])
@pytest.mark.parametrize("name", ["house", "office", "hospital", "warehouse"])
def test_everybody_gets_where_they_go(name, seed):
    """The robot stands where it starts, and people have time."""
    scenario = LoadScenario(
        filename=name, overrides=["robot.goal=null", "simulation.duration=120"]
    )
    recording = RunTrial(scenario, seed=seed).recording
    walls = scenario.world.obstacles()
    ways = recording.humans[:, :, :2]
    afoot = ~seated(recording)
    assert not (inside(walls, ways).any(axis=2) & afoot).any()
    gaps = np.linalg.norm(nearest_wall(walls, ways) - ways, axis=-1)
    for i, human in enumerate(scenario.humans):
        if not afoot[-1, i]:
            # (A patient stays in bed.)
            continue
        # Bodies do not reach into anything either, but for moments at jambs.
        walked = gaps[afoot[:, i], i]
        assert walked.min() > 0.5 * human.contact_radius
        assert (walked < 0.9 * human.contact_radius).mean() < 0.01
        # Of a group, one is at the goal and the others beside.
        near = human.goal_radius + (1.2 if human.group_id >= 0 else 0.15)
        begin = 0
        for goal in human.goals:
            distance = np.hypot(*(ways[begin:, i] - goal).T)
            reached = np.flatnonzero(distance < near)
            assert len(reached), (human.name, goal, distance.min())
            begin += int(reached[0])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3])
@pytest.mark.parametrize("name", ["house", "office", "hospital", "warehouse"])
def test_the_robot_arrives_whatever_the_seed(name, seed):
    result = RunTrial(LoadScenario(filename=name), seed=seed)
    assert result.end_reason == "goal"
    assert result.metrics["robot_on_person_collisions"] == 0
    assert result.metrics["static_obstacle_collisions"] == 0
