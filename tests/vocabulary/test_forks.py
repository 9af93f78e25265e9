"""What people show each other is in the Context: saved, forked, transferred."""

import json

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    ScenarioError,
    SetTrialSeed,
    TransferContext,
)
from hunav_drake.systems.common.layout import SIGNAL_SIZE, Activity, Signal
from hunav_drake.systems.evaluation.recording import Recording
from tests.vocabulary.stage import tree

TALK = tree(
    '<TimeDelay delay="1"><RunOnce><ConversationFormation goal_id="mid"'
    ' non_main_agent_ids="2,3" conversation_duration="5"/></RunOnce>'
    "</TimeDelay>"
)
CHATS = tree(
    '<ForceFailure><Cooldown seconds="2"><Sequence><RandomChanceCondition'
    ' probability="0.1"/><SaySomething message="well, well"/></Sequence>'
    "</Cooldown></ForceFailure>"
)
HEARS = tree(
    '<Sequence><IsAnyoneSpeaking distance_threshold="8" speaker_id="{who}"/>'
    '<LookAtAgent target_id="{who}" walk="true"/><AlwaysFailure/></Sequence>'
)


def scenario(**more):
    people = [
        {"pose": [-4, 0, 0], "goals": [[9, 0]], "behavior": TALK},
        {"pose": [4, 1, 3.1], "goals": [[-9, 1]], "behavior": CHATS},
        {"pose": [0, 5, -1.5], "goals": [[0, -9]], "behavior": HEARS},
        {"pose": [6, 6, 0], "goals": [[-6, 6]], "behavior": CHATS},
    ]
    robot = {
        "type": "differential_drive",
        "start": [-6, -4, 0],
        "goal": [6, -4, 0],
    }
    data = {
        "places": [{"name": "mid", "pose": [0, 0, 0]}],
        "humans": people,
        "robot": robot,
        "planner": {"type": "pursuit"},
        "simulation": {"duration": 15.0, "seed": 5},
    }
    return LoadScenario(data=json.dumps(data | more))


def ends_of(diagram, context, until):
    simulator = Simulator(diagram, context)
    simulator.Initialize()
    simulator.AdvanceTo(until)
    return signals_of(diagram, context)


def signals_of(diagram, context):
    humans = diagram.GetSubsystemByName("humans")
    own = humans.GetMyContextFromRoot(context)
    return np.concatenate(
        [
            humans.GetOutputPort(name).Eval(own)
            for name in ("human_states", "social_signals")
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize("separate", [True, False])
def test_02_forks_and_files_go_on_bit_for_bit(separate, tmp_path):
    given = scenario(crowd={"separate_trees": separate})
    diagram = MakeTrialDiagram(given)
    simulator = MakeTrialSimulator(diagram)
    context = simulator.get_context()
    instants = np.random.default_rng(2).uniform(0.2, 11, 20)
    clones = []
    for instant in sorted(instants):
        simulator.AdvanceTo(round(instant / 0.05) * 0.05)
        clones.append(context.Clone())
    simulator.AdvanceTo(12.0)
    expected = signals_of(diagram, context)
    assert expected[-22:].any()
    other = MakeTrialDiagram(given)
    for i, clone in enumerate(clones):
        path = tmp_path / f"{i}.npz"
        SaveContext(diagram, clone, path)
        loaded = LoadContext(other, path)
        for made, start in ((diagram, clone), (other, loaded)):
            found = ends_of(made, start, 12.0)
            np.testing.assert_array_equal(found, expected)


def test_02_a_transferred_context_goes_on_bit_for_bit():
    diagram = MakeTrialDiagram(scenario())
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(4.0)
    other = MakeTrialDiagram(scenario(planner={"type": "dwb"}))
    moved = TransferContext(diagram, simulator.get_context(), other)
    before = signals_of(diagram, simulator.get_context())
    np.testing.assert_array_equal(signals_of(other, moved), before)
    again = MakeTrialDiagram(scenario())
    back = TransferContext(other, moved, again)
    simulator.AdvanceTo(9.0)
    expected = signals_of(diagram, simulator.get_context())
    np.testing.assert_array_equal(ends_of(again, back, 9.0), expected)


@pytest.mark.slow
def test_the_seed_of_the_trial_is_that_of_what_people_do_by_chance():
    diagram = MakeTrialDiagram(scenario())
    ends = []
    for seed in (5, 6, 7, 5):
        context = diagram.CreateDefaultContext()
        SetTrialSeed(diagram, context, seed)
        ends.append(ends_of(diagram, context, 12.0))
    assert (ends[0] == ends[3]).all()
    assert (ends[0] != ends[1]).any()
    assert (ends[1] != ends[2]).any()
    default = ends_of(diagram, diagram.CreateDefaultContext(), 12.0)
    np.testing.assert_array_equal(default, ends[0])


@pytest.mark.parametrize(
    ("change", "place", "words"),
    [
        ({"places": []}, "humans[0].behavior", "there is no place 'mid'"),
        (
            {"places": [{"name": "mid", "pose": [0, 0, 0]}] * 2},
            "places",
            r"places\[0\] and places\[1\] have the same name 'mid'",
        ),
    ],
)
def test_names_that_do_not_fit_are_faults_of_the_scenario(change, place, words):
    with pytest.raises(ScenarioError, match=words) as info:
        scenario(**change)
    assert info.value.faults[0].path == place


def test_a_recording_has_what_people_have_shown(tmp_path):
    trial = scenario(simulation={"duration": 6.0})
    recording = RunTrial(trial).recording
    shown = recording.social_signals
    assert shown.shape == (len(recording), 4, SIGNAL_SIZE)
    assert (shown[:, 0, Signal.ACTIVITY] == Activity.CONVERSATION).any()
    recording.save(tmp_path / "r.npz")
    again = Recording.load(tmp_path / "r.npz")
    np.testing.assert_array_equal(again.social_signals, shown)
    # It is in the Context, too.
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(3.0)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    forked = Simulator(diagram, LoadContext(diagram, file))
    forked.AdvanceTo(6.0)
    evaluator = diagram.GetSubsystemByName("evaluator")
    own = evaluator.GetMyContextFromRoot(forked.get_context())
    np.testing.assert_array_equal(
        evaluator.GetRecording(own).social_signals, shown
    )
