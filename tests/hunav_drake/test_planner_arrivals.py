"""Every planner arrives: however near, wherever it faces, however often asked.

Alone on a free floor, so that nothing but the planner is to blame.
"""

import functools
import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from tests.planners import NAMES

GOALS = {
    "ahead": (4.0, 0.0, 0.0),
    "behind": (-4.0, 0.0, math.pi),
    "left": (0.0, 4.0, math.pi / 2),
    # On no cell's middle, and to be faced from another side.
    "aside": (-1.2345, -2.0119, 2.5),
}
NEAR = {"beside": (-0.53, -0.68, 1.19)}
TOLERANCES = (0.05, 0.1, 0.2, 0.5)
PERIODS = (0.05, 0.1, 0.2, 0.5)


@functools.cache
def run(
    name,
    goal,
    *,
    tolerance=0.25,
    yaw=0.25,
    period=0.05,
    step=0.05,
    turn_rate=2.09,
):
    """Returns a trial of a planner, 60 s at most, and its speeds ahead."""
    there = (GOALS | NEAR)[goal]
    scenario = LoadScenario(
        data=f"""
            robot:
              goal: {list(there)}
              goal_tolerance: {tolerance}
              goal_yaw_tolerance: {yaw}
              limits: {{max_turn_rate: {turn_rate}}}
            simulation: {{duration: 60, time_step: {step}}}
            evaluator: {{period: {step}}}
            """,
        overrides=[
            f"planner={{type: {name}, period: {period}"
            + (", batch_size: 200}" if name == "mppi" else "}")
        ],
    )
    result = RunTrial(scenario)
    x, y, heading, vx, vy = result.recording.robot[:, :5].T
    away = math.hypot(x[-1] - there[0], y[-1] - there[1])
    return result, away, vx * np.cos(heading) + vy * np.sin(heading)


def arrives(name, goal, **how):
    result, away, speeds = run(name, goal, **how)
    assert result.end_reason == "goal", f"{goal}, {how}: {result.end_message}"
    assert away < how.get("tolerance", 0.25)
    # Somebody who does not get on recovers, and so may arrive after all.
    assert result.end_time < 17.0, f"{goal}, {how}"
    return result.end_time, speeds


@pytest.mark.parametrize("name", NAMES)
def test_arrives_within_a_small_tolerance(name):
    arrives(name, "ahead", tolerance=0.05)
    arrives(name, "behind", tolerance=0.1, yaw=0.05)


@pytest.mark.parametrize("tolerance", [0.03, 0.1])
@pytest.mark.parametrize("yaw", [0.1, 3.14])
def test_mppi_does_not_hang_beside_small_goals(tolerance, yaw):
    """Neither beside it, nor before it, with the right heading."""
    usual, _ = arrives("mppi", "aside")
    time, _ = arrives("mppi", "aside", tolerance=tolerance, yaw=yaw)
    assert time < usual + 3.0


@pytest.mark.parametrize("tolerance", [0.1, 0.25])
def test_sfw_does_not_circle_around_a_near_goal(tolerance):
    how = {"tolerance": tolerance, "yaw": 3.14, "turn_rate": 0.5}
    arrives("sfw", "beside", **how)
    result, _, _ = run("sfw", "beside", **how)
    assert result.metrics["path_length"] < 1.5 * math.hypot(0.53, 0.68)


@pytest.mark.parametrize("name", NAMES)
def test_a_goal_behind_is_turned_to_first(name):
    _, speeds = arrives(name, "behind")
    _, ahead = arrives(name, "ahead")
    assert (ahead >= -1e-9).all()
    # MPPI weighs turning against driving back, as Nav2's does.
    assert (speeds < -1e-3).mean() < (0.4 if name == "mppi" else 0.01)


def cruising(speeds):
    """Returns the speed on the way, without its beginning and its end."""
    return float(np.quantile(speeds, 0.75))


@pytest.mark.parametrize("name", NAMES)
def test_a_longer_period_makes_no_slower(name):
    time, speeds = arrives(name, "ahead")
    later, speeds_later = arrives(name, "ahead", period=0.5)
    assert abs(later - time) < 0.15 * time
    assert cruising(speeds_later) == pytest.approx(cruising(speeds), rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("goal", "tolerance"), zip(GOALS, TOLERANCES, strict=True)
)
def test_arrives_at_every_period(name, goal, tolerance):
    times = [
        arrives(name, goal, tolerance=tolerance, period=period)[0]
        for period in PERIODS
    ]
    assert max(times) < 1.35 * min(times) + 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("step", "period"),
    [(0.01, 0.01), (0.01, 0.07), (0.02, 0.2), (0.1, 0.5), (0.2, 0.2)],
)
def test_arrives_at_every_step(name, step, period):
    how = {"step": step, "period": period}
    arrives(name, "ahead", tolerance=0.25, **how)
    arrives(name, "behind", tolerance=0.05, **how)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("period", [0.05, 0.5])
def test_arrives_at_every_heading(name, period):
    for goal in GOALS:
        arrives(name, goal, yaw=0.02, period=period)
