"""How trials end that cannot end well: in clear words, for all planners."""

import math
from pathlib import Path

import numpy as np
from pydantic.dataclasses import dataclass
import pytest

from hunav_drake import LoadScenario, RunTrial, ScenarioError
from hunav_drake.systems.planning import (
    PLANNERS,
    NavigationPlanner,
    register_planner,
)
from hunav_drake.systems.planning.navigation import Control
from tests.choices import fast
from tests.planners import NAMES, planner_override


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


def load(text, name, parameters=""):
    override = planner_override(name, parameters)
    return LoadScenario(data=text, overrides=[override])


ENCLOSED = """
world:
  walls:
    - {type: polyline, points: [[2, -1], [4, -1], [4, 1], [2, 1], [2, -1]]}
robot: {goal: [3, 0, 0]}
simulation: {duration: 30, stuck_time: 3}
"""


@pytest.mark.parametrize("name", NAMES)
def test_a_goal_that_no_way_leads_to(name):
    result = RunTrial(load(ENCLOSED, name))
    assert result.end_reason == "stuck"
    assert "the robot no longer gets anywhere" in result.end_message
    assert result.metrics["static_obstacle_collisions"] == 0
    x = result.recording.robot[-1, 0]
    if name == "pursuit":
        # It knows no ways, and stops at the wall.
        assert 1.0 < x < 2 - 0.35
        return
    assert (
        "there is no path from (0.00, 0.00) to the goal" in result.end_message
    )
    assert x == 0.0


COVERED = """
world:
  walls:
    - {type: polyline, points: [[-2, -3], [8, -3], [8, 3], [-2, 3], [-2, -3]]}
humans: [{pose: [4, 0, 0], behavior: impassive, desired_speed: 0.0}]
robot: {goal: [4, 0, 0], radius: 0.25}
simulation: {duration: 40, stuck_time: 11}
"""


@pytest.mark.parametrize("name", fast(NAMES, "pursuit", "orca"))
def test_people_who_cover_the_goal(name):
    result = RunTrial(load(COVERED, name))
    assert result.end_reason == "stuck"
    recording = result.recording
    away = recording.robot[:, :2] - recording.humans[:, 0, :2]
    # For those with maps, people are their feet.
    assert np.hypot(*away.T).min() > 0.2 + 0.24
    assert 2.0 < result.recording.robot[-1, 0] < 5.0
    if name != "pursuit":
        assert "people stand on the goal: the nearest" in result.end_message


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("place", ["start", "goal"])
def test_a_start_or_goal_in_a_wall_is_told_before_anything_runs(name, place):
    other = {"start": "goal", "goal": "start"}[place]
    text = f"""
world: {{walls: [{{type: box, center: [3, 0], size: [2, 2]}}]}}
robot: {{{place}: [3, 0.2, 0], {other}: [0, 0, 0]}}
"""
    words = rf"robot.{place}: .* world.walls\[0\].*; move it "
    with pytest.raises(ScenarioError, match=words):
        load(text, name)


def hang():
    while True:
        pass


BREAKS = {
    "raises": (
        lambda: 1 / 0,
        f"ZeroDivisionError: division by zero ({Path(__file__)}:",
    ),
    "gives_nan": (
        lambda: Control(0.1, math.nan),
        "Mine.plan() must give finite v and omega, got v = 0.1 and omega = nan",
    ),
    "gives_nothing": (
        lambda: None,
        "TypeError: Mine.control() must give a Control, got None",
    ),
    "hangs": (hang, "a cycle took longer than cycle_limit = 0.5 s"),
}


@pytest.mark.parametrize("how", BREAKS)
def test_a_planner_with_maps_that_breaks_ends_the_trial(how):
    breaks, words = BREAKS[how]

    @register_planner("mine")
    @dataclass
    class Mine(NavigationPlanner):
        def control(self, task, view, local, costmap, memory):
            return breaks() if view.robot[0] < 7.3 else Control(0.5, 0.0)

    scenario = LoadScenario(
        filename="passing", overrides=["planner={type: mine, cycle_limit: 0.5}"]
    )
    result = RunTrial(scenario)
    assert result.end_reason == "planner_failed"
    start = "planner 'mine' failed at t = 0."
    assert result.end_message.startswith(start)
    assert words in result.end_message
    assert len(result.end_message) < 300
    # What came up to then is kept.
    assert 0.3 < result.end_time < 1.0
    assert result.recording.times[-1] == result.end_time
