"""A trial that ends away from its goal says why, and what helps."""

import dataclasses
import json
import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial, WriteReport, WriteResult
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.end import explain_end

HALL = """
world:
  walls:
    - {type: box, name: block, center: [5, 9.5], size: [0.2, 17.2]}
    - {type: box, name: low, center: [5, -9.5], size: [0.2, 18.2]}
    - {type: box, name: west, center: [-9, 0], size: [0.2, 36.6]}
    - {type: box, name: east, center: [19, 0], size: [0.2, 36.6]}
    - {type: box, name: north, center: [5, 18.2], size: [28, 0.2]}
    - {type: box, name: south, center: [5, -18.7], size: [28, 0.2]}
robot: {radius: 0.3, start: [0, 0, 0], goal: [4, 0, 0], goal_tolerance: 0.2}
"""
# The door becomes 0.4 m wide.
NARROW = ["world.walls[0].center=[5, 9.05]", "world.walls[0].size=[0.2, 18.1]"]


@pytest.fixture(scope="module")
def hall():
    return LoadScenario(data=HALL)


def recording(robot, people=None, *, goal=(4.0, 0.0, 0.0), **options):
    """Returns a recording of ten samples per second, from places."""
    robot = np.asarray(robot, dtype=float)
    rows = np.zeros((len(robot), 7))
    rows[:, :3] = robot
    rows[1:, 3:5] = np.diff(robot[:, :2], axis=0) / 0.1
    rows[:, 6] = 0.3
    humans = np.zeros((len(robot), 0, 7))
    if people is not None:
        humans = np.zeros((len(robot), len(people), 7))
        humans[..., :2] = people
        humans[..., 6] = 0.3
    return Recording(
        times=0.1 * np.arange(len(robot)),
        robot=rows,
        humans=humans,
        goal=goal,
        **{"goal_tolerance": 0.2, "goal_yaw_tolerance": 0.25, **options},
    )


def standing(x, y=0.0, yaw=0.0, seconds=20):
    return [[x, y, yaw]] * (10 * seconds + 1)


def test_a_heading_that_is_off_is_told_with_its_tolerance(hall):
    words = explain_end(recording(standing(3.97, yaw=0.6)), hall)
    assert words.startswith(
        "0.03 m from the goal, but heading off by 0.60 rad"
        " (goal_yaw_tolerance 0.25); raise robot.goal_yaw_tolerance"
    )


@pytest.mark.parametrize("yaw", [0.2, -0.2, 2 * math.pi])
def test_at_the_goal_there_is_nothing_to_tell(hall, yaw):
    assert explain_end(recording(standing(3.9, yaw=yaw)), hall) == ""


def test_without_a_goal_there_is_nothing_to_tell(hall):
    assert explain_end(recording(standing(1), goal=None), hall) == ""


def test_who_blocks_the_way_is_named_with_the_time(hall):
    names = ("ana", "carmen")
    walk = [[0.1 * i, 0, 0] for i in range(10)]
    robot = [*walk, *standing(1.0, seconds=14)]
    people = [(1.9, 3.0), (1.8, 0.1)]
    words = explain_end(recording(robot, people, human_names=names), hall)
    assert words.startswith("3.00 m from the goal, blocked by carmen for 14 s;")
    assert "try another planner" in words
    people = [(1.9, -0.2), (1.8, 0.3)]
    words = explain_end(recording(robot, people, human_names=names), hall)
    assert "and 1 more for 14 s" in words


def test_who_is_behind_or_only_passes_does_not_block(hall):
    behind = [(0.2, 0.0)]
    words = explain_end(recording(standing(1.0), behind), hall)
    assert "blocked" not in words
    assert "standing for 20 s" in words
    passing = np.zeros((201, 1, 2))
    passing[:, 0] = [3.0, 3.0]
    passing[-5:, 0] = [1.8, 0.0]
    robot = standing(1.0)
    rows = recording(robot, [(9, 9)])
    humans = rows.humans.copy()
    humans[..., :2] = passing
    passed = Recording(
        times=rows.times, robot=rows.robot, humans=humans, goal=rows.goal
    )
    assert "blocked" not in explain_end(passed, hall)


def test_a_door_too_narrow_is_told_with_its_width(hall):
    words = explain_end(
        recording(standing(4.0), goal=(8.0, 0.0, 0.0)),
        LoadScenario(data=HALL, overrides=NARROW),
    )
    assert words.startswith("4.00 m from the goal: no way through a door of")
    assert "('block')" in words
    assert "0.40 m" in words


def test_a_wall_that_is_touched_is_named(hall):
    words = explain_end(
        recording(standing(4.59, 3.0), goal=(3.0, 9.0, 0.0)), hall
    )
    assert "at world.walls[0] ('block') for 20 s" in words


def test_what_it_stands_before_is_named(hall):
    """Where it faces, or where its goal is; the nearest counts."""
    words = explain_end(recording(standing(4.0, 3.0), goal=(4, 9, 0)), hall)
    assert "standing for 20 s, 0.60 m before world.walls[0] ('block')" in words
    robot = standing(4.0, 3.0, yaw=2.0)
    words = explain_end(recording(robot, goal=(4.7, 3, 0)), hall)
    assert "standing for 20 s, 0.60 m before world.walls[0] ('block')" in words
    ana = {"people": [(4.0, 4.5)], "human_names": ("ana",)}
    words = explain_end(
        recording(standing(4.0, 3.0, yaw=1.5), goal=(4, 9, 0), **ana), hall
    )
    assert "standing for 20 s, 0.90 m before ana;" in words


def test_what_is_beside_far_or_passing_is_not_before_it(hall):
    # Beside the wall, gliding along it, and with nothing ahead.
    beside = recording(standing(4.55, 3.0, yaw=1.57), goal=(4.55, 9, 0))
    assert "before" not in explain_end(beside, hall)
    far = recording(standing(2.0, 3.0), goal=(2, 9, 0))
    assert "standing for 20 s; try" in explain_end(far, hall)
    rows = recording(standing(2.0, 3.0), [(9, 9)], goal=(2, 9, 0))
    humans = rows.humans.copy()
    humans[-5:, 0, :2] = [3.5, 3.0]
    passing = dataclasses.replace(rows, humans=humans)
    assert "before" not in explain_end(passing, hall)


@pytest.mark.parametrize(
    ("planner", "size", "words"),
    [
        ("pursuit", [0.8, 4], "standing for 5 s, 0.3"),
        # Between walls it comes nearer.
        ("sfw", [0.4, 0.4], "at world.walls[0] ('pillar') for 5 s"),
    ],
)
def test_a_robot_that_stops_before_a_pillar_says_the_pillar(
    planner, size, words
):
    data = f"""
world:
  walls:
    - {{type: box, name: pillar, center: [3, 0], size: {size}}}
    - {{type: box, center: [3, 1], size: [12, 0.1]}}
    - {{type: box, center: [3, -1], size: [12, 0.1]}}
planner: {{type: {planner}}}
simulation: {{stuck_time: 5}}
robot: {{radius: 0.25, start: [0, 0, 0], goal: [6, 0, 0]}}
"""
    result = RunTrial(LoadScenario(data=data))
    assert result.end_reason == "stuck"
    assert words in result.end_message
    assert "world.walls[0] ('pillar')" in result.end_message


def test_one_on_its_way_is_given_time_that_suffices(hall):
    robot = [[0.05 * i, 0, 0] for i in range(41)]
    words = explain_end(recording(robot), hall)
    assert "2.00 m from the goal, and on its way at 0.49 m/s" in words
    assert int(words.split(", to ")[1].split()[0]) >= 8


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """Returns a trial that is over too soon, and its folder."""
    scenario = LoadScenario("passing", overrides=["simulation.duration=4"])
    result = RunTrial(scenario)
    folder = WriteResult(result, tmp_path_factory.mktemp("out"))
    return result, folder


@pytest.mark.slow
def test_a_trial_says_it_in_result_file_and_report(stopped):
    result, folder = stopped
    assert result.end_reason == "timeout"
    words = "the time is over; "
    assert result.end_message.startswith(words)
    assert "and on its way at" in result.end_message
    saved = json.loads((folder / "result.json").read_text())
    assert saved["end_message"] == result.end_message
    page = WriteReport(result, folder / "report.html").read_text()
    assert "and on its way at" in page


def test_with_the_time_it_asks_for_it_arrives(stopped):
    result, _ = stopped
    needed = result.end_message.split(", to ")[1].split()[0]
    longer = LoadScenario(
        "passing", overrides=[f"simulation.duration={needed}"]
    )
    assert RunTrial(longer).end_reason == "goal"
