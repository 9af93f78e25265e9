"""People react as they should wherever they start and walk to.

`tests.reaction_table` prints what is held here.
"""

import itertools

import numpy as np
import pytest

from tests.reaction_table import (
    BEHAVIORS,
    PLACEMENTS,
    Run,
    outcomes,
    placed,
    placements,
    scenario_of,
    summary,
)
from tests.systems.behavior.ticks import as_original

REACTING = [it for it in BEHAVIORS if it not in ("regular", "impassive")]

# The number of 20 placements in which the robot arrives. People in its way may
# stop it until the trial is over, and people at the goal stay there.
ROBOTS = dict.fromkeys(BEHAVIORS, 20) | {"threatening": 19, "impassive": 17}

# The largest number of starts and ends of a reaction.
SWITCHES = {
    "regular": 0,
    "impassive": 0,
    "surprised": 6,
    "scared": 2,
    "curious": 4,
    "threatening": 2,
    "distracted": 4,
    "cooperative": 4,
}

# The duration of the longest reaction, in seconds.
LONGEST = {"surprised": 30.0, "curious": 30.0, "threatening": 40.0}


def check(behavior, rows, share=1.0):
    got = summary(rows)
    assert got["reacted"] == len(rows)
    assert got["arrived"] >= int(ROBOTS[behavior] * share)
    assert got["switches"] <= SWITCHES[behavior]
    # People who come to the goal slow down by 3 m/s^2.
    assert got["braking"] <= 3.0 + 1e-6
    assert got["acceleration"] <= 5.5
    assert got["active"] <= LONGEST.get(behavior, 60.0) + 0.1
    assert got["overlaps"] == 0


@pytest.mark.parametrize("behavior", BEHAVIORS)
def test_first_placements(behavior):
    check(behavior, outcomes(behavior, 1), 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("behavior", BEHAVIORS)
def test_all_placements(behavior):
    rows = outcomes(behavior)
    check(behavior, rows)
    if behavior == "threatening":
        whole = sum(abs(it.active - 40.0) < 0.2 for it in rows)
        assert whole >= 12
        assert min(it.gap for it in rows) > 0.15
    if behavior == "curious":
        assert sum(abs(it.active - 30.0) < 0.2 for it in rows) >= 16


@pytest.mark.slow
@pytest.mark.parametrize("behavior", ["threatening", "curious", "surprised"])
def test_placements_with_orca(behavior):
    rows = outcomes(behavior, 8, model="orca")
    assert all(it.reacted for it in rows)
    assert all(it.gap > 0 for it in rows)


@pytest.mark.slow
def test_original_is_worse():
    """It walks into the robot, and steps to and fro."""
    rows = outcomes("threatening", 4, tree=as_original("threatening"))
    assert sum(it.gap < -0.05 for it in rows) >= 2
    assert max(it.acceleration for it in rows) > 6


def test_surprised_person_at_the_border_of_sight_does_not_dither():
    """It walks behind the robot, faster, and stops 4 m off."""
    scenario = scenario_of("surprised")
    place = ((-7.252, -2.743, 0.157), (6.282, -0.598))
    ours = Run(placed(scenario, *place)).outcome()
    theirs = Run(
        placed(scenario, *place, behavior=as_original("surprised")), "surprised"
    )
    assert theirs.outcome().switches > 40
    assert ours.switches <= 6
    assert ours.braking <= 2.6 < theirs.outcome().braking


def test_cooperative_person_lets_the_robot_pass_at_the_goal_too():
    """It stands there with its back to the robot."""
    place = ((-4.557, 1.065, -0.21), (2.72, -0.483))
    run = Run(placed(scenario_of("cooperative"), *place))
    assert run.arrived
    assert run.gap.min() > 0.2
    yielding = np.flatnonzero(run.active)[0]
    assert np.hypot(*(run.human[yielding, :2] - place[1])) < 0.6


def test_distracted_person_who_stands_in_the_way_steps_aside():
    place = ((1.0, 0.0, 0.3), (5.0, 0.0))
    run = Run(placed(scenario_of("distracted"), *place))
    assert run.arrived
    assert run.made_way.any()
    assert run.gap.min() > 0.1
    theirs = Run(placed(scenario_of("impassive"), *place))
    assert not theirs.made_way.any()


@pytest.mark.parametrize("model", ["", "orca"])
def test_impassive_person_gets_past_a_robot_head_on(model):
    """With the pursuit planner, which waits for as long as it takes."""
    place = ((7.0, 0.0, np.pi), (-7.0, 0.0))
    run = Run(placed(scenario_of("impassive"), *place, model=model))
    assert run.arrived
    assert run.gap.min() > 0.15
    assert np.hypot(*(run.human[-1, :2] - place[1])) < 0.5
    # It does not turn to and fro.
    turn = np.angle(np.exp(1j * np.diff(run.human[5:, 2])))
    assert np.abs(turn).sum() < 4 * np.pi


def test_placements_are_always_the_same():
    first, second = (list(placements("scared")) for _ in range(2))
    assert first == second
    assert len(first) == PLACEMENTS
    assert all(a != b for a, b in itertools.pairwise(first))
