"""Walls, furniture and templates."""

import re

import pytest

from tests.browser.driver import SMALL, at, near

SHIPPED = ["cafe", "office", "station", "house", "crossing"]


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenarios_are_shown_without_a_fault(open_editor, name):
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.scenarios import shipped_text

    editor = open_editor(shipped_text(name), filename=f"{name}.yaml")
    scenario = LoadScenario(filename=name)
    people = len(scenario.humans)
    editor.wait(lambda _: editor.page.locator(".map .person").count() == people)
    fixtures = len(scenario.world.walls) + len(scenario.world.furniture)
    shown = editor.page.locator(".map .fixture")
    editor.wait(lambda _: shown.count() == fixtures)
    told = editor.page.locator(".faults")
    editor.wait(lambda _: told.inner_text() == "No problems")


def test_walls_boxes_polygons_and_rooms_are_drawn(open_editor):
    editor = open_editor(SMALL)
    walls = len(editor.session.data["world"]["walls"])
    editor.press("Escape")
    editor.tool("wall")
    editor.click(-4, 2.5)
    editor.click(-2, 2.5)
    editor.double_click(-2, 3.5)
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 1)
    wall = editor.session.data["world"]["walls"][-1]
    assert wall["type"] == "polyline"
    assert len(wall["points"]) == 3
    editor.press("Escape")

    editor.tool("polygon")
    for place in ((3, -1), (4, -1), (4, -0.2), (3, -1)):
        editor.click(*place)
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 2)
    assert editor.session.data["world"]["walls"][-1]["type"] == "polygon"
    editor.press("Escape")

    editor.tool("box")
    editor.drag((1, 2.5), (2, 3))
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 3)
    box = editor.session.data["world"]["walls"][-1]
    assert near(box["center"], (1.5, 2.75))
    assert near(box["size"], (1, 0.5), 0.11)

    editor.tool("disc")
    editor.drag((-4.2, -1), (-3.8, -1))
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 4)
    disc = editor.session.data["world"]["walls"][-1]
    assert disc["type"] == "disc"
    assert near(disc["center"], (-4.2, -1), 0.11)
    assert abs(disc["radius"] - 0.4) < 0.11
    editor.drag_handle("radius", (-3.6, -1))
    path = ["world", "walls", walls + 3]
    editor.wait(lambda it: at(it.data, [*path, "radius"]) > 0.5)
    with editor.pressed(-4.2, -1):
        editor.drop_at((-4.2, -2))
    editor.wait(lambda it: near(at(it.data, [*path, "center"]), (-4.2, -2)))

    editor.tool("room")
    editor.drag((-0.5, -2.7), (1.5, -0.7))
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 8)
    # A door in the upper wall of the room.
    editor.tool("door")
    editor.click(0.5, -0.7)
    editor.wait(lambda it: len(it.data["world"]["walls"]) == walls + 9)
    undo = editor.page.locator(".step").first
    editor.wait(lambda _: undo.get_attribute("title").endswith("Add a door"))
    editor.undo_all()
    editor.wait(lambda it: it.text == SMALL)


def test_furniture_is_placed_moved_turned_and_resized(open_editor):
    editor = open_editor(SMALL)
    editor.tool("furniture")
    editor.page.locator(".palette").get_by_text("plant", exact=True).click()
    # It does not cover what is to be clicked.
    editor.page.locator(".palette").wait_for(state="hidden")
    editor.click(0, 3)
    editor.wait(lambda it: len(it.data["world"]["furniture"]) == 2)
    plant = editor.session.data["world"]["furniture"][1]
    assert plant["type"] == "plant"
    assert near(plant["center"], (0, 3))
    editor.press("Escape")
    editor.click(3, 1.5)
    editor.drag_handle("turn", (3, 3))
    editor.wait(
        lambda it: abs(at(it.data, ["world", "furniture", 0, "yaw"]) or 0) > 1.5
    )
    before = at(editor.session.data, ["world", "furniture", 0, "size"])
    editor.drag_handle("size 1 1", (1.5, 3))
    editor.wait(
        lambda it: at(it.data, ["world", "furniture", 0, "size"]) != before
    )


def test_a_corner_is_dragged_added_and_removed(open_editor):
    editor = open_editor(SMALL)
    path = ["world", "walls", 1, "points"]
    editor.click(-2, -3)
    editor.drag_handle("corner 1", (0, -2))
    editor.wait(lambda it: near(at(it.data, [*path, 1]), (0, -2)))
    editor.drag_handle("side 0", (-2, -2))
    editor.wait(lambda it: len(at(it.data, path)) == 4)
    assert near(at(editor.session.data, [*path, 1]), (-2, -2))
    editor.focus_map()
    editor.press("Enter", "Tab", "Delete")
    editor.wait(lambda it: len(at(it.data, path)) == 3)


def test_a_person_in_a_table_is_told_everywhere_and_put_right(open_editor):
    editor = open_editor(SMALL)
    with editor.pressed(-3, 0):
        editor.drop_at((3, 1.5))
        # While it is still held.
        editor.page.locator("[data-key='humans/0'].faulty").wait_for()
        assert at(editor.session.data, ["humans", 0, "pose"]) == [-3, 0, 0]
    editor.wait(lambda it: len(it.faults) == 1)
    person = editor.part("humans/0")
    inside = re.compile("is inside")
    editor.expect(person).to_have_attribute("aria-description", inside)
    desk = editor.part("world/furniture/0")
    editor.expect(desk).to_contain_class("used")
    message = editor.field("pose").locator(".field-fault")
    editor.expect(message).to_contain_text("is inside")
    editor.tab("yaml")
    editor.settle()
    lines = editor.session.text.splitlines()
    (line,) = (i for i, it in enumerate(lines, 1) if "at the door" in it)
    faulty = editor.page.locator(".gutter .faulty")
    editor.expect(faulty).to_have_text(str(line))
    editor.tab("problems")
    editor.page.locator(".fix").click()
    editor.wait(lambda it: it.faults == [])
    told = editor.page.locator(".faults")
    editor.wait(lambda _: told.inner_text() == "No problems")
    # The button is gone; keys are not lost with it.
    editor.press("Control+z")
    editor.wait(lambda it: len(it.faults) == 1)


def test_a_template_is_chosen_by_its_card(open_editor):
    editor = open_editor(None, view={"width": 1440})
    dialog = editor.page.locator("dialog[open]")
    dialog.get_by_text("Corridor", exact=True).click()
    editor.wait(lambda it: it.data.get("humans"))
    assert editor.session.faults == []
    editor.settle()
    people = editor.page.locator(".map .person")
    editor.expect(people).to_have_count(len(editor.session.data["humans"]))


def test_a_map_of_ros_lies_in_its_place_and_is_traced(open_editor, tmp_path):
    import numpy as np
    from PIL import Image

    cells = np.full((40, 60), 254, dtype=np.uint8)
    # A block of 1 m, whose lower left corner is at (1, 0.5) in W.
    cells[40 - 30 : 40 - 10, 40:60] = 0
    Image.fromarray(cells).save(tmp_path / "hall.pgm")
    (tmp_path / "hall.yaml").write_text(
        "image: hall.pgm\nresolution: 0.05\norigin: [-1.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    editor = open_editor("humans: []\n")
    editor.session.set_map(tmp_path / "hall.yaml")
    image = editor.page.locator(".map image")
    image.wait_for()
    box = image.bounding_box()
    low = editor.world(box["x"], box["y"] + box["height"])
    high = editor.world(box["x"] + box["width"], box["y"])
    assert near(low, (-1, 0), 0.02)
    assert near(high, (2, 2), 0.02)
    editor.page.get_by_role("button", name="Convert dark").click()
    editor.wait(lambda it: it.data.get("world", {}).get("walls"))
    (wall,) = editor.session.data["world"]["walls"]
    xs, ys = zip(*wall["points"], strict=True)
    assert near((min(xs), min(ys), max(xs), max(ys)), (1, 0.5, 2, 1.5), 0.06)


def test_a_picture_gets_its_scale_by_two_clicks(open_editor, tmp_path):
    from PIL import Image

    picture = tmp_path / "plan.png"
    Image.new("L", (80, 40), 255).save(picture)
    editor = open_editor("humans: []\n")
    map_ = editor.page.locator(".map")
    with editor.page.expect_file_chooser() as chosen:
        editor.page.get_by_role("button", name="File", exact=True).click()
        editor.page.get_by_text("Background map or picture").click()
    chosen.value.set_files(picture)
    image = map_.locator("image")
    editor.page.get_by_role("button", name="Set the size").click()
    # 80 pixels of 5 cm; the left half of its lower side is 5 m in truth.
    editor.click(0, 0)
    editor.click(2, 0)
    editor.page.get_by_role("textbox", name="distance").fill("5")
    editor.page.locator("dialog").get_by_text("Set scale").click()
    editor.wait(lambda it: near([it.background.message()["width_m"]], [10]))

    def is_ten_by_five(_):
        box = image.bounding_box()
        low = editor.world(box["x"], box["y"] + box["height"])
        high = editor.world(box["x"] + box["width"], box["y"])
        return near(low, (0, 0), 0.1) and near(high, (10, 5), 0.1)

    editor.wait(is_ten_by_five)


def test_furniture_is_repeated_in_rows_and_columns(open_editor):
    editor = open_editor(SMALL)
    editor.click(3, 1.5)
    editor.page.get_by_role("button", name="Repeat in rows").click()
    dialog = editor.page.locator("dialog[open]")
    for name, value in {
        "columns": 2,
        "rows": 3,
        "across": -2,
        "up": -1,
    }.items():
        dialog.get_by_label(name).fill(str(value))
        dialog.get_by_label(name).press("Tab")
    dialog.get_by_role("button", name="Repeat").click()
    editor.wait(lambda it: len(it.data["world"]["furniture"]) == 6)
    parts = editor.session.data["world"]["furniture"]
    places = {tuple(it["center"]) for it in parts}
    assert places == {(x, y) for x in (3, 1) for y in (1.5, 0.5, -0.5)}
    assert len({it["name"] for it in parts}) == 6
    editor.page.locator(".step").first.click()
    editor.wait(lambda it: it.text == SMALL)
