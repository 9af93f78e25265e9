"""Relative metrics: with and without the robot, with and without people."""

import dataclasses
import math

import numpy as np
import pytest

from hunav_drake import (
    CompareAlone,
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    register_paired_metric,
)
from hunav_drake.report.trial_page import _metrics
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.trial.branches.future import Future
from hunav_drake.trial.branches.relative import (
    PAIRED_METRICS,
    neighbours,
    with_relative,
)
from tests.hunav_drake.test_branches import PAIR, stage, walker

RATIOS = [name for name, it in PAIRED_METRICS.items() if it.unit == "-"]
CROWD = [name for name in RATIOS if name.startswith("crowd")]
DIFFERENCES = [it for it in PAIRED_METRICS if it.endswith("_difference")]


def compared(scenario):
    diagram = MakeTrialDiagram(scenario)
    return CompareAlone(scenario, diagram, diagram.CreateDefaultContext())


def test_with_nobody_there_is_no_difference():
    found = compared(stage([]))
    assert {name: found.values[name] for name in RATIOS} == dict.fromkeys(
        RATIOS, 1.0
    )
    assert {found.values[name] for name in DIFFERENCES} == {0.0}
    assert found.values["aggregated_time"] == 0.0
    assert found.costs == {}


@pytest.mark.slow
def test_a_robot_far_away_does_not_matter_to_people():
    people = [walker("ana", 5, 200, -6), walker("luis", 6, 201, -6)]
    found = compared(stage(people))
    assert {found.values[name] for name in CROWD} == {1.0}
    assert found.texts() == []


@pytest.mark.slow
def test_a_robot_in_the_way_costs_time():
    found = compared(
        stage(PAIR, robot={"start": [-3, 0, 0], "goal": [6, 0, 0]})
    )
    time, _ = found.costs["ana"]
    assert time > 0
    assert found.texts()[0].startswith("the robot cost ana 0.")
    total = sum(time for time, _ in found.costs.values())
    assert found.values["aggregated_time"] == pytest.approx(total)
    assert found.values["crowd_time_difference"] == pytest.approx(
        total / len(found.costs)
    )
    assert 0 < found.values["relative_time_to_goal"] <= 1


def future(robot, person, goal=(10.0, 0.0)):
    """Returns a future of two who move at the given velocities from 0."""
    times = np.arange(0.0, 20.001, 0.5)
    states = np.zeros((2, len(times), 7))
    for rows, (x, y, vx, vy) in zip(states, (robot, person), strict=True):
        rows[:, 0], rows[:, 1] = x + vx * times, y + vy * times
        rows[:, 3], rows[:, 4], rows[:, 6] = vx, vy, 0.3
    nothing = np.zeros((len(times), 1))
    return Future(
        times=times,
        robots={"robot": states[0]},
        humans=states[1][:, None],
        social=nothing,
        work=nothing,
        goals=np.array([[*goal, 0.5]]),
        goals_left=nothing + 1,
        robot_goal=(8.0, 1.0, 0.0, 0.25, math.pi),
        result=None,
    )


@pytest.mark.slow
def test_of_several_robots_the_one_that_it_is_about_is_named():
    scenario = LoadScenario(
        data="robots:"
        "\n- {name: anna, robot: {start: [-3, 0, 0], goal: [6, 0, 0]}}"
        "\n- {name: bob, robot: {start: [-3, 9, 0], goal: [6, 9, 0]}}"
        "\nhumans: [{name: ana, pose: [4, 0.1, 3.14], goals: [[-6, 0]]}]"
        "\nsimulation: {duration: 20}"
    )
    found = compared(scenario)
    (text,) = found.texts()
    assert text.startswith("anna cost ana ")
    assert found.values["anna.aggregated_time"] > 0
    assert found.values["bob.aggregated_time"] == 0
    # The order of robots says nothing.
    turned = dataclasses.replace(scenario, robots=scenario.robots[::-1])
    other = compared(turned)
    assert dict(other.values) == pytest.approx(
        dict(found.values), rel=0, abs=1e-9, nan_ok=True
    )
    assert other.costs.keys() == found.costs.keys() == {"anna.ana"}
    # With files, too.
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    MakeTrialSimulator(diagram, context).AdvanceTo(5.0)
    result = GetTrialResult(scenario, diagram, context)
    names = with_relative(result, found).metrics.index
    assert {"bob.relative_jerk", "anna.extra_time[ana]"} <= set(names)
    assert "aggregated_time" not in names
    captions = [it.caption for it in _metrics(with_relative(result, found))]
    assert "relative" in captions
    assert "other" not in captions
    assert base_name("anna.aggregated_time") == "aggregated_time"


def test_two_straight_lines_by_hand():
    with_ = future((0, 1, 0.5, 0), (0, 0, 0.8, 0))
    alone = future((0, 1, 0.8, 0), (0, 0, 1.0, 0))
    values = {
        name: it.function(with_, alone) for name, it in PAIRED_METRICS.items()
    }
    # The person has 9.5 m to go, the robot more than 7.75 m, to the end of a
    # step of 0.5 s.
    expected = {
        "aggregated_time": 9.5 / 0.8 - 9.5,
        "crowd_relative_time": 1 / 0.8,
        "crowd_relative_path": 1.0,
        "relative_time_to_goal": 10.0 / 16.0,
        "time_to_goal_difference": 6.0,
        "relative_path_length": 1.0,
    }
    for name, value in expected.items():
        assert values[name] == pytest.approx(value, abs=1e-12), name
    # Without any jerk, a ratio would say nothing.
    assert math.isnan(values["relative_jerk"])
    assert math.isnan(values["crowd_relative_jerk"])
    assert values["crowd_jerk_difference"] == pytest.approx(0.0, abs=1e-12)
    assert neighbours(with_).tolist() == [True]


def test_who_does_not_arrive_does_not_count():
    with_ = future((0, 1, 0.5, 0), (0, 0, 0.1, 0))
    alone = future((0, 1, 0.8, 0), (0, 0, 1.0, 0))
    for name in ("crowd_relative_time", "aggregated_time"):
        assert math.isnan(PAIRED_METRICS[name].function(with_, alone)), name
    nowhere = dataclasses.replace(with_, robot_goal=None)
    metric = PAIRED_METRICS["relative_time_to_goal"].function
    assert math.isnan(metric(nowhere, alone))


@pytest.mark.slow
def test_own_metrics_are_computed_too(monkeypatch):
    monkeypatch.setattr(
        "hunav_drake.trial.branches.relative.PAIRED_METRICS",
        dict(PAIRED_METRICS),
    )

    @register_paired_metric("extra_steps", "-", "lower", "myself", "robot")
    def extra_steps(with_, without):
        """How many more steps there are."""
        return len(with_.times) - len(without.times)

    found = compared(stage(PAIR))
    assert found.values["extra_steps"] == 0
    assert base_name("anna.extra_steps") == "extra_steps"
    with pytest.raises(ValueError, match="is registered already"):
        register_paired_metric(
            "aggregated_time", "s", "lower", "myself", "robot"
        )(extra_steps)


@pytest.mark.slow
def test_hunav_run_tells_it(hunav, tmp_path):
    code, out, _ = hunav(
        *("run", "crossing", "--relative", "--out", tmp_path, "--no-replay")
    )
    assert code == 0
    assert "the robot cost ana" in out
    (page,) = tmp_path.glob("runs/*/report.html")
    text = page.read_text()
    assert "extra_<wbr>time[ana]" in text
    assert "crowd_<wbr>relative_<wbr>time" in text


def test_a_physical_robot_is_refused(hunav):
    code, _, err = hunav(
        "run", "crossing", "--relative", "--quiet", "--set", "robot.type=pmb2"
    )
    assert code == 2
    assert "is physical, and needs people" in err
    assert LoadScenario(filename="crossing").robot.physical is False
