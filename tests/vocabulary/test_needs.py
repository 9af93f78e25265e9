"""Needs and the time of the trial: tests of the specification, by number."""

import json

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import HumanConfig, LoadScenario, ScenarioError
from hunav_drake.systems.behavior import BehaviorTreeError, NodeStatus
from hunav_drake.systems.people.places import Place
from tests.systems.behavior.ticks import all_discrete_state
from tests.vocabulary.stage import DT, STAND, Stage, someone, tree

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE

NEEDS = {
    "thirst": {"initial": 40, "rate": 2.0},
    "rest": {"initial": 50, "rate": 1.5},
}
BAR = Place(name="bar", type="counter", pose=(30, 0, 0))


def wait(name, seconds=3):
    return f'<StopAndWaitTimerAction name="{name}" wait_duration="{seconds}"/>'


CHOOSES = (
    '<NeedsSelector name="it"><Satisfies need="thirst" amount="60" place="bar">'
    f'{wait("drinks")}</Satisfies><Satisfies need="rest" amount="60">'
    f"{wait('rests')}</Satisfies></NeedsSelector>"
)


def level(stage, need, index=0):
    system = stage._trees(index)
    context = system.GetMyContextFromRoot(stage.context)
    trees = system.trees()
    slots = trees[index if len(trees) > 1 else 0].slots
    memory = system.GetMemory(context, index)
    return memory[slots.index(f"need {need}")]


def test_31_the_most_urgent_need_comes_first():
    stage = Stage([someone(0, 0, 0, CHOOSES, needs=NEEDS)], places=[BAR])
    found, levels = [], []
    for _ in stage.run(12.0):
        found.append(stage.statuses(0))
        levels.append([level(stage, "thirst"), level(stage, "rest")])
    drinks, rests = (
        [k for k, it in enumerate(found) if it[name] == S]
        for name in ("drinks", "rests")
    )
    # Drinks, and when that is done, rests.
    assert drinks[0] == pytest.approx(3 / DT, abs=2)
    assert rests[0] == pytest.approx(6 / DT, abs=3)
    # 40 - 3 s x 2 / s + 60.
    assert levels[drinks[0] + 1][0] == pytest.approx(94, abs=0.3)
    assert np.diff(levels[: drinks[0]], axis=0) == pytest.approx(
        np.tile([-0.1, -0.075], (drinks[0] - 1, 1))
    )


def test_31_levels_stay_between_0_and_100():
    nodes = (
        '<Sequence><TimeOfTrial name="late" from="8"/><RunOnce><Satisfies'
        ' need="a" amount="100"><Satisfies need="a" amount="100">'
        f"{wait('it', 0)}</Satisfies></Satisfies></RunOnce></Sequence>"
    )
    person = someone(0, 0, 0, nodes, needs={"a": {"initial": 10, "rate": 2.0}})
    stage = Stage([person])
    levels = []
    for _ in stage.run(9.0):
        levels.append(level(stage, "a"))
    assert levels[-22] == 0
    assert max(levels[-20:]) == 100
    assert min(levels) == 0


def test_31_a_long_queue_makes_a_need_wait():
    queue = '<Queue place="bar"/>'
    people = [
        someone(29.5 - 0.9 * i, 0, 0, queue, rest=STAND) for i in range(8)
    ]
    late = f'<TimeDelay delay="1">{CHOOSES}</TimeDelay>'
    people.insert(0, someone(0, 5, 0, late, needs=NEEDS))
    stage = Stage(people, places=[BAR])
    for _ in stage.run(2.0):
        pass
    found = stage.statuses(0)
    assert (found["drinks"], found["rests"]) == (0, R)


def test_a_need_below_a_level():
    nodes = '<ForceFailure><NeedBelow name="it" need="thirst"/></ForceFailure>'
    stage = Stage([someone(0, 0, 0, nodes, needs=NEEDS)])
    found = [stage.statuses(0)["it"] for _ in stage.run(7.0)]
    # (40 - 30) / 2 per second.
    assert found.index(S) == pytest.approx(5 / DT, abs=2)
    assert {*found[found.index(S) :]} == {S}


def test_a_timetable():
    nodes = "".join(
        f'<Sequence><TimeOfTrial from="{begin}" to="{begin + 2}"/>'
        f"{wait(f'from {begin}', 9)}</Sequence>"
        for begin in (1, 4)
    )
    stage = Stage([someone(0, 0, 0, nodes, goals=[(9, 0)])])
    # (A reactive fallback goes on with the first one that runs.)
    found = [stage.statuses(0)]
    found += [stage.statuses(0) for _ in stage.run(7.0)]
    assert found[19]["from 1"] == 0
    assert found[20]["from 1"] == R


@pytest.mark.parametrize("separate", [True, False])
def test_02_needs_go_on_bit_for_bit_from_forks(separate):
    people = [
        someone(3 * i, 0, 0, CHOOSES, goals=[(3 * i, 9)], needs=NEEDS)
        for i in range(2)
    ]
    stage = Stage(people, places=[BAR], separate_trees=separate)
    for _ in stage.run(4.3):
        pass
    clone = stage.context.Clone()
    for _ in stage.run(8.0):
        pass
    simulator = Simulator(stage.diagram, clone)
    simulator.Initialize()
    simulator.AdvanceTo(stage.k * DT)
    np.testing.assert_array_equal(
        all_discrete_state(clone), all_discrete_state(stage.context)
    )


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        (CHOOSES.replace("thirst", "thrist"), "there is no need 'thrist'"),
        (f"<NeedsSelector>{wait('a')}</NeedsSelector>", "write Satisfies"),
        (
            '<SetBlackboard value="rest" output_key="it"/><NeedBelow'
            ' need="{it}"/>',
            "must be the name of a need",
        ),
    ],
)
def test_needs_that_do_not_fit_are_told(nodes, message):
    with pytest.raises(BehaviorTreeError, match=message):
        Stage([someone(0, 0, 0, nodes, needs=NEEDS)], places=[BAR])


def test_needs_are_keys_of_a_scenario():
    data = {
        "places": [{"name": "bar", "pose": [4, 0, 0]}],
        "humans": [
            {"pose": [0, 0, 0], "behavior": tree(CHOOSES), "needs": NEEDS}
        ],
        "robot": {"start": [-6, -3, 0], "goal": [6, -3, 0]},
        "planner": {"type": "pursuit"},
    }
    (person,) = LoadScenario(data=json.dumps(data)).humans
    assert isinstance(person, HumanConfig)
    assert person.needs["rest"].rate == 1.5
    del data["humans"][0]["needs"]
    with pytest.raises(ScenarioError, match="there is no need 'thirst'"):
        LoadScenario(data=json.dumps(data))
