"""Whatever is chosen of a template, its scenario can be simulated."""

from hypothesis import given, settings, strategies as st
import pytest

from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.templates import (
    TEMPLATES,
    Cafe,
    Corridor,
    Crossing,
    Office,
    Room,
    template_forms,
    template_text,
)
from hunav_drake.scenario import CheckScenario, LoadScenario


def _check(template):
    scenario = CheckScenario(template.make())
    assert scenario.robot.goal is not None
    return scenario


def _check_room(template, people, always):
    """Checks that there is room, or that it is told that there is none."""
    if people <= always or _has_room(template):
        assert len(_check(template).humans) == people
        return
    with pytest.raises(ValueError, match="there is room for"):
        template.make()


def _has_room(template):
    try:
        template.make()
    except ValueError:
        return False
    return True


@settings(max_examples=12)
@given(st.floats(8, 100), st.floats(2, 12), st.integers(0, 60))
def test_corridors_are_sound(length, width, people):
    template = Corridor(length=length, width=width, people=people)
    _check_room(template, people, 12)


@settings(max_examples=12)
@given(st.floats(8, 60), st.integers(0, 6))
def test_crossings_are_sound(size, people):
    scenario = _check(Crossing(size=size, people_per_side=people))
    assert len(scenario.humans) == 4 * people


@settings(max_examples=12)
@given(
    st.floats(4, 20), st.floats(3.5, 15), st.floats(1.6, 6), st.integers(0, 12)
)
def test_offices_are_sound(width, depth, corridor, people):
    scenario = _check(
        Office(
            room_width=width,
            room_depth=depth,
            corridor_width=corridor,
            people=people,
        )
    )
    assert len(scenario.humans) == people


@settings(max_examples=10)
@given(st.integers(1, 40), st.integers(0, 40))
def test_cafes_are_sound(tables, guests):
    _check_room(Cafe(tables=tables, guests=guests), guests, 5)


@settings(max_examples=5)
@given(st.floats(3, 200), st.floats(2, 200))
def test_rooms_are_sound(width, depth):
    assert not _check(Room(width=width, depth=depth)).humans


@pytest.mark.parametrize("form", template_forms(), ids=lambda it: it["name"])
def test_forms_have_defaults_that_make_their_scenario(form):
    text = template_text(form["name"], form["defaults"])
    usual = TEMPLATES[form["name"]]().make()
    assert LoadScenario(data=text) == CheckScenario(usual)
    for field in form["schema"]["properties"].values():
        assert field["description"]
        assert "minimum" in field


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("offfice", {}, "did you mean 'office'"),
        ("office", {"people": 99}, "people: "),
        ("office", {"pupils": 1}, "pupils: "),
        ("corridor", {"length": 8.0, "people": 60}, "there is room for"),
        ("corridor", {"length": "x"}, "length: "),
    ],
)
def test_wrong_choices_are_told(name, values, words):
    with pytest.raises(OperationError, match=words):
        template_text(name, values)
