"""What the time line of a run tells, and where robots ended."""

import dataclasses

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.editor.worker.events import ends_of, events_of
from hunav_drake.systems.common.layout import Contact
from tests.hunav_drake.passing_trials import make_recording, make_result


def told(result):
    return [(it["kind"], it["begin"], it["text"]) for it in events_of(result)]


def test_contacts_reactions_and_the_end_are_in_order():
    contacts = np.zeros((11, 2, 8))
    contacts[4:6, 1, Contact.LASTS] = 1
    contacts[8:, 1, Contact.LASTS] = 1
    reacts = np.zeros((11, 2), dtype=int)
    reacts[2:7, 0] = 2
    run = make_recording(
        contacts=contacts,
        wall_contact=np.zeros((11, 8)),
        behavior_status=reacts,
        human_names=("ana", "ben"),
        behaviors=("curious", "regular"),
    )
    result = dataclasses.replace(
        make_result(run), end_reason="stuck", end_message="it is", end_time=1.0
    )
    assert told(result) == [
        ("reaction", 0.2, "ana (curious) reacts to the robot"),
        ("contact", 0.4, "the robot touches ben"),
        ("contact", 0.8, "the robot touches ben"),
        ("end", 1.0, "the robot is stuck"),
    ]
    # Stretches end where they ended, and at the end of the run.
    assert [it["end"] for it in events_of(result)] == [0.7, 0.6, 1.0, 1.0]
    (end,) = ends_of(result)
    assert end == {
        "robot": "",
        "reason": "stuck",
        "message": "it is",
        "at": [1.0, 0.0],
    }


def test_each_of_several_robots_has_its_end():
    """Also if the name of one ends as that of another."""
    second = make_recording(start=-5.0, robot_name="anna", end_time=0.5)
    run = make_recording(robot_name="joanna", end_time=0.9, others=(second,))
    result = dataclasses.replace(
        make_result(run),
        end_reason="stuck",
        end_message="joanna: goal after 0.90 s (it is there); anna: stuck after"
        " 0.50 s (no way; a wall (thick))",
        robot_ends={"joanna": "goal", "anna": "stuck"},
    )
    assert told(result) == [
        ("end", 0.5, "anna is stuck"),
        ("end", 0.9, "joanna reaches the goal"),
    ]
    (end,) = ends_of(result)
    assert (end["robot"], end["at"]) == ("anna", [-4.5, 0.0])
    assert end["message"] == "no way; a wall (thick)"


@pytest.mark.slow
def test_who_talks_and_sits_does_not_react():
    """As in the replay, which tells of the same reactions."""
    scenario = LoadScenario(
        filename="living_cafe", overrides=["simulation.duration=8.0"]
    )
    result = RunTrial(scenario)
    assert (result.recording.behavior_status != 0).any()
    assert {it["kind"] for it in events_of(result)} == {"end"}
