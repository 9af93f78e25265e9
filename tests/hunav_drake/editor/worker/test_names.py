import sys

import pytest

from hunav_drake.editor.worker.names import (
    find_model_outlines,
    find_names_faults,
)
from hunav_drake.systems.common.choice_loading import registered_only

PERSON = "humans:\n- {name: ana, pose: [4, 0, 0], behavior: BEHAVIOR}\n"


def _faults(text, folder=None, name=None):
    return find_names_faults(text, folder, name)


def test_an_unknown_behavior_is_found_where_it_stands():
    (fault,) = _faults(PERSON.replace("BEHAVIOR", "curios"))
    assert fault["path"] == ["humans", 0, "behavior"]
    assert "curious" in fault["message"]


def test_a_wrong_port_is_found_where_it_stands():
    text = PERSON.replace("BEHAVIOR", "{type: curious, distance: far}")
    (fault,) = _faults(text)
    assert fault["path"] == ["humans", 0, "behavior", "distance"]


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("planner: no_such", ["planner", "type"]),
        ("crowd: {model: no_such}", ["crowd", "model", "type"]),
        ("evaluator: {metrics: [no_such]}", ["evaluator", "metrics", 0]),
    ],
)
def test_unknown_choices_are_found(text, path):
    (fault,) = _faults(text)
    assert fault["path"] == path


def test_files_are_looked_for_in_the_folder(tmp_path):
    text = PERSON.replace("BEHAVIOR", "./mine.xml")
    assert _faults(text, str(tmp_path))
    (tmp_path / "mine.xml").write_text(
        '<root BTCPP_format="4" main_tree_to_execute="Mine">'
        '<BehaviorTree ID="Mine"><SubTree ID="RegularNavTree"/></BehaviorTree>'
        "</root>"
    )
    assert not _faults(text, str(tmp_path))


def test_one_of_several_scenarios_is_looked_at():
    text = "one: {planner: no_such}\ntwo: {planner: pursuit}\n"
    assert _faults(text, name="one")
    assert not _faults(text, name="two")


@pytest.mark.slow
def test_models_have_the_outlines_that_people_walk_around(tmp_path):
    (tmp_path / "rack.sdf").write_text(
        '<sdf version="1.9"><model name="rack"><static>true</static>'
        '<link name="body"><collision name="c"><geometry><box>'
        "<size>2 1 1.5</size></box></geometry></collision></link>"
        "</model></sdf>"
    )
    text = "world: {models: [{file: rack.sdf, pose: [5, 5, 1]}, {file: no}]}"
    found = find_model_outlines(text, str(tmp_path), None)
    assert set(found) == {"rack.sdf"}
    (corners,) = found["rack.sdf"]
    # From its own place, wherever it stands.
    expected = {(x, y) for x in (-1.0, 1.0) for y in (-0.5, 0.5)}
    assert {tuple(it) for it in corners} == expected


def test_no_module_is_imported_for_a_name(tmp_path, monkeypatch):
    (tmp_path / "evil_planner.py").write_text("raise SystemExit('executed')")
    monkeypatch.syspath_prepend(tmp_path)
    with registered_only():
        (fault,) = _faults("planner: {type: 'evil_planner:Planner'}")
    assert "--import" in fault["message"]
    assert "evil_planner" not in sys.modules


@pytest.mark.parametrize(
    "text", ["", ":", "[", "- 1", "3", "\x00", "a: &a [*a]"]
)
def test_a_text_that_is_no_scenario_is_left_to_others(text):
    assert isinstance(_faults(text), list)
    assert find_model_outlines(text, None, None) == {}
