"""Places on the map: drawn, moved with their slots, turned, edited."""

import math

from hunav_drake.systems.people.furniture_places import with_furniture
from tests.browser.driver import SMALL, at, near

PLACES = (
    SMALL
    + """\
places:
  - {name: till, type: counter, pose: [0, 2, 0]}
  - name: bench
    type: seat
    pose: [2, -1, 0]
    slots: [[2, -1, 0], [2.6, -1, 0]]   # two
    approaches: [[2, -1.6], [2.6, -1.6]]
"""
)


def test_a_place_is_drawn_and_given_a_type(open_editor):
    editor = open_editor(SMALL)
    editor.tool("place")
    editor.drag((0, 1.5), (0, 2.5))
    editor.wait(
        lambda it: near(
            at(it.data, ["places", 0, "pose"]), (0, 1.5, math.pi / 2), 0.03
        )
    )
    assert at(editor.session.data, ["places", 0, "name"]) == "place_1"
    editor.settle()
    editor.field("type").locator("select").select_option("counter")
    editor.wait_for(["places", 0, "type"], "counter")
    letter = editor.part("places/0").locator(".letter")
    editor.expect(letter).to_have_text("C")
    editor.tool("place")
    editor.click(-1, 1)
    editor.wait(lambda it: len(it.data["places"]) == 2)
    assert at(editor.session.data, ["places", 1, "name"]) == "place_2"
    editor.undo_all()
    assert editor.session.text == SMALL


def test_slots_and_approaches_follow_their_place(open_editor):
    editor = open_editor(PLACES)
    editor.drag((2, -1), (1, 0))
    editor.wait(
        lambda it: near(at(it.data, ["places", 1, "pose"]), (1, 0, 0), 0.01)
    )
    place = editor.session.data["places"][1]
    assert place["slots"] == [[1, 0, 0], [1.6, 0, 0]]
    assert place["approaches"] == [[1, -0.6], [1.6, -0.6]]
    editor.settle()
    for _ in range(6):
        editor.press("[")
        editor.settle()
    place = editor.session.data["places"][1]
    assert near(place["pose"], (1, 0, math.pi / 2), 0.01)
    assert near(place["slots"][1], (1, 0.6, math.pi / 2), 0.01)
    assert near(place["approaches"][0], (1.6, 0), 0.01)
    editor.undo_all()
    assert editor.session.text == PLACES


def test_places_are_listed_copied_and_removed(open_editor):
    editor = open_editor(PLACES)
    row = editor.page.locator('[data-row="places/1"]')
    editor.expect(row).to_contain_text("bench")
    row.click()
    editor.settle()
    slots = editor.field("slots").locator(".point input")
    editor.expect(slots).to_have_count(6)
    slots.nth(4).fill("-0.5")
    slots.nth(4).press("Tab")
    editor.wait_for(["places", 1, "slots", 1, 1], -0.5)
    editor.focus_map()
    editor.press("Control+d")
    editor.wait(lambda it: len(it.data["places"]) == 3)
    copy = editor.session.data["places"][2]
    assert copy["name"] == "bench_2"
    assert near(copy["slots"][0], (2.5, -1.5, 0), 0.01)
    editor.press("Delete")
    editor.wait(lambda it: len(it.data["places"]) == 2)


def test_furniture_without_a_name_is_listed_by_that_of_its_place(open_editor):
    editor = open_editor("""\
world:
  furniture:
    - {type: table, center: [3, 0]}
    - {type: chair, center: [3.75, 0], yaw: 3.1416}
    - {type: chair, center: [2.25, 0]}
""")
    rows = editor.page.locator('[data-row^="world/furniture/"] .row-name')
    editor.expect(rows).to_have_text(["table_1", "chair_1", "chair_2"])
    places = with_furniture([], editor.session.scenario.world)
    assert [it.name for it in places] == ["chair_1", "chair_2"]


def test_a_fault_of_a_place_is_shown_at_it(open_editor):
    editor = open_editor(PLACES.replace("pose: [0, 2, 0]", "pose: [0, 4, 0]"))
    part = editor.part("places/0")
    editor.wait(lambda _: "faulty" in part.get_attribute("class"))


def test_a_place_has_a_number_of_its_own(open_editor):
    text = PLACES.replace("name: till,", "name: till, id: 3,")
    editor = open_editor(text)
    editor.tool("place")
    editor.click(-1, 1)
    editor.wait(lambda it: len(it.data["places"]) == 3)
    editor.settle()
    assert editor.session.data["places"][2]["id"] == 4
    editor.click(0, 2)
    editor.settle()
    editor.focus_map()
    editor.press("Control+d")
    editor.wait(lambda it: len(it.data["places"]) == 4)
    assert editor.session.data["places"][3]["id"] == 5
