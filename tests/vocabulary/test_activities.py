"""Activities: behaviors by name that people do with places and each other."""

import json

import numpy as np
import pytest

from hunav_drake import (
    HumanConfig,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    ScenarioError,
)
from hunav_drake.systems.behavior import ACTIVITIES, BEHAVIORS, LoadTree
from hunav_drake.systems.common.layout import (
    SIGNAL_SIZE,
    STATE_SIZE,
    Activity,
    Posture,
    Signal,
)
from hunav_drake.systems.people.furniture_places import with_furniture

WORLD = {
    "furniture": [
        {"type": "shelf", "center": [-4, -3]},
        {"type": "shelf", "center": [-4, 5]},
        {"type": "counter", "name": "till", "center": [3, 4], "yaw": 3.1416},
        {"type": "chair", "center": [0, -3]},
    ]
}


def scenario(*people, **more):
    data = {
        "world": WORLD,
        "humans": list(people),
        "robot": {"start": [-8, -8, 0], "goal": [-8, 8, 1.5]},
        "planner": {"type": "pursuit"},
        "simulation": {"duration": 60.0},
    }
    return LoadScenario(data=json.dumps(data | more))


def watched(trial, seconds):
    """Yields the states and the signals of all people in each step."""
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    n = len(diagram.humans)
    for k in range(1, round(seconds / 0.05)):
        simulator.AdvanceTo(0.05 * k)
        context = simulator.get_context()
        yield (
            diagram.GetOutputPort("human_states")
            .Eval(context)
            .reshape(n, STATE_SIZE),
            diagram.GetOutputPort("social_signals")
            .Eval(context)
            .reshape(n, SIGNAL_SIZE),
        )


@pytest.mark.parametrize("name", ACTIVITIES)
def test_activities_load_with_a_description_in_all_profiles(name):
    for profile in ("default", "hunavsim", "hunav_drake_0.1"):
        tree = LoadTree(name, profile=profile)
        assert tree.is_social
        assert tree.documents.comments[0].strip().endswith(".")
    assert name not in BEHAVIORS


def test_errands_are_done_in_order_and_the_way_goes_on():
    person = {
        "pose": [0, 0, 0],
        "goals": [[6, -2]],
        "behavior": {
            "type": "errands",
            "first": "shelf_2",
            "second": "shelf_1",
            "counter": "till",
            "seconds": 2.0,
        },
    }
    trial = scenario(person)
    names = [it.name for it in with_furniture([], trial.world)]
    visited = []
    end = np.zeros(2)
    for states, signals in watched(trial, 45.0):
        end = states[0, :2]
        place = signals[0, Signal.PLACE]
        if place >= 0 and (not visited or visited[-1] != names[int(place)]):
            visited.append(names[int(place)])
    assert visited == ["shelf_2", "shelf_1", "till"]
    assert np.hypot(*(end - [6, -2])) < 0.5


def test_who_waits_sits_down_later_and_again():
    person = {
        "pose": [3, -1, 0],
        "goals": [[3, -1]],
        "behavior": {
            "type": "sit",
            "place": "chair_1",
            "seconds": 3.0,
            "wait": 4.0,
            "again": 6.0,
        },
    }
    begins, sat = [], False
    for k, (_, signals) in enumerate(watched(scenario(person), 40.0)):
        sits = signals[0, Signal.POSTURE] == Posture.SEATED
        if sits and not sat:
            begins.append(0.05 * k)
        sat = sits
    assert begins[0] > 5.0
    # 3 s on it, 6 s of rest, and the ways.
    assert len(begins) >= 3
    assert np.diff(begins).min() > 9.0


@pytest.mark.slow
def test_a_guide_leads_a_group_from_goal_to_goal():
    guide = {
        "pose": [-2, 0, 0],
        "goals": [[2, 0], [5, 0]],
        "behavior": {
            "type": "guide",
            "people": "2, 3",
            "text": "Here it was.",
            "seconds": 3.0,
        },
    }
    group = [{"pose": [-3, y, 0]} for y in (-1, 1)]
    said, talked = [], 0
    for states, signals in watched(scenario(guide, *group), 40.0):
        if signals[0, Signal.UTTERANCE]:
            said.append(states[0, 0])
        talks = signals[:, Signal.ACTIVITY] == Activity.CONVERSATION
        talked += talks.all()
    # At both goals, for 3 s each.
    assert {round(x) for x in said} >= {2, 5}
    assert talked > 2 * 3.0 / 0.05
    assert np.hypot(*(states[:, :2] - [5, 0]).T).max() < 2.0


@pytest.mark.slow
def test_cohorts_have_activities_by_share():
    cohort = {
        "number": 6,
        "start": [{"rectangle": [-3, -1, 3, 3]}],
        "goals": [{"point": [7, 0]}],
        "behaviors": {"sit": 1, "chat": 1, "regular": 1},
    }
    trial = scenario(population={"seed": 2, "cohorts": [cohort]})
    sat = [
        (signals[:, Signal.POSTURE] == Posture.SEATED).any()
        for _, signals in watched(trial, 12.0)
    ]
    assert any(sat)


def test_unknown_words_have_activities_among_the_proposals():
    with pytest.raises(ScenarioError, match="did you mean 'errands'"):
        scenario({"pose": [0, 0, 0], "behavior": "errand"})
    with pytest.raises(ScenarioError, match="there is no place 'shelf_9'"):
        scenario(
            {
                "pose": [0, 0, 0],
                "behavior": {"type": "errands", "first": "shelf_9"},
            }
        )


@pytest.mark.slow
def test_a_person_alone_may_have_any_activity():
    """Nothing fails where a place or a partner is not there."""
    for name in ACTIVITIES:
        if name in ("queue", "lunch", "talk", "guide"):
            # (These name a counter or a person.)
            continue
        person = HumanConfig(
            pose=(0, 0, 0), goals=[(2, 0)], behavior={"type": name}
        )
        trial = scenario(
            {"pose": [0, 0, 0], "goals": [[2, 0]], "behavior": {"type": name}},
            world={},
        )
        assert person.behavior_name == name
        for states, _ in watched(trial, 4.0):
            assert np.isfinite(states).all()
