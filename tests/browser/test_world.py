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


def test_an_untraced_map_is_a_problem_until_it_is_traced(open_editor, tmp_path):
    from tests.maps import write_map

    # A hall with a pillar, in which the robot stands.
    rows = ["#" * 80, *["#" + "." * 78 + "#"] * 58, "#" * 80]
    for i in range(24, 36):
        rows[i] = rows[i][:34] + "#" * 12 + rows[i][46:]
    editor = open_editor("robot: {start: [5.0, 5.0, 0]}\n")
    file = write_map(tmp_path, rows)
    editor.session.set_map(file)
    offer = editor.page.locator(".offer")
    offer.get_by_text("everybody walks through it").wait_for()
    told = editor.page.locator(".faults")
    editor.expect(told).to_have_text("1 problem")
    # It stays in the list when the offer is refused.
    offer.get_by_role("button", name="Not now").click()
    offer.wait_for(state="hidden")
    editor.tab("problems")
    editor.page.locator(".fix", has_text="Trace walls").click()
    editor.wait(lambda it: len(at(it.data, ["world", "walls"]) or []) > 1)
    # Now it is seen that the robot stands in the pillar.
    editor.expect(editor.part("robot/start")).to_contain_class("faulty")
    editor.page.locator(".fix", has_text="Move it").click()
    editor.expect(told).to_have_text("No problems")
    # What is traced takes doors, in the middle of the lower wall.
    walls = len(editor.session.data["world"]["walls"])
    editor.tool("door")
    editor.click(3.0, 2.05)
    editor.wait(lambda it: len(it.data["world"]["walls"]) > walls)
    editor.undo_all()
    editor.expect(told).to_have_text("1 problem")
    editor.page.get_by_role("button", name="Remove the background").click()
    editor.expect(told).to_have_text("No problems")
    assert editor.session.background is None


def lines(session):
    """Returns (center, size) of all walls."""
    walls = session.data["world"]["walls"]
    return [(tuple(it["center"]), tuple(it["size"])) for it in walls]


def test_rooms_side_by_side_share_a_wall_and_a_door(open_editor):
    editor = open_editor("robot: {start: [-4, -2, 0], goal: [2, 5.5, 0]}\n")
    editor.tool("room")
    editor.drag((-4, 0), (-1, 3))
    editor.wait(lambda it: it.data.get("world"))
    # Beside it, a little off: from the face of its wall.
    editor.tool("room")
    editor.drag((-0.92, -0.08), (2, 3.06))
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 7)
    walls = lines(editor.session)
    assert ((-1.0, 1.5), (0.15, 2.85)) in walls
    assert sum(abs(x + 1) < 0.2 for (x, _), _ in walls) == 1
    # North of the second room goes on where that of the first one ends.
    assert ((0.575, 3.0), (3.0, 0.15)) in walls
    # A door in the shared wall leads from room to room.
    editor.tool("door")
    editor.click(-1, 1.5)
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 8)
    # A third room, north of the first: it keeps the door, and shares too.
    editor.tool("door")
    editor.click(-2.5, 3)
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 9)
    editor.tool("room")
    editor.drag((-4, 3), (-1, 5))
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 12)
    from hunav_drake.scenario.reachability import FreeSpace

    space = FreeSpace(editor.session.scenario.world.fixtures())
    for goal in ((0, 1.5), (-2.5, 4)):
        assert space.joins((-2.5, 1.5), goal, 0.35, 0.0)
    editor.undo_all()
    editor.wait(lambda it: not it.data.get("world"))


def test_a_room_and_a_door_are_made_by_the_keyboard(open_editor):
    one = "{type: box, name: a, center: [0, 0], size: [0.15, 4]}"
    text = f"world: {{walls: [{one}]}}\nrobot: {{start: [-2, 0, 0]}}\n"
    editor = open_editor(text)
    # From beside the wall, in the middle of the view, to the right.
    x, _ = editor.world(*middle_of(editor.page.locator(".map")))
    editor.press("O")
    steps = round((x - 0.1) * 10)
    editor.press(*["ArrowLeft" if steps > 0 else "ArrowRight"] * abs(steps))
    editor.press(" ", "Shift+ArrowRight", "Shift+ArrowRight")
    editor.press("Shift+ArrowUp", " ")
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 4)
    walls = lines(editor.session)
    # The wall is the western one of the room.
    assert sum(abs(place[0]) < 0.2 for place, _ in walls) == 1
    editor.press("Escape", "d")
    steps = round(10 * x)
    editor.press(*["ArrowLeft" if steps > 0 else "ArrowRight"] * abs(steps))
    editor.press(" ")
    editor.wait(lambda it: len(it.data["world"]["walls"]) == 5)
    editor.undo_all()
    editor.wait(lambda it: it.text == text)


def middle_of(locator):
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_door_cuts_all_walls_that_it_crosses(open_editor):
    two = """\
world:
  walls:
    - {type: box, name: a, center: [0, 0], size: [4, 0.15]}
    - {type: box, name: b, center: [0, 0.225], size: [4, 0.15], yaw: 0.0}
    - {type: polyline, name: rail, points: [[-4, -3], [4, -3]]}
    - {type: polygon, name: old, points: [[-4, 2], [4, 2], [4, 2.2], [-4, 2.2]]}
robot: {start: [0, -4, 0], goal: [0, 4, 0]}
"""
    editor = open_editor(two)
    told = editor.page.locator(".toast")
    for y, walls in ((0.1, 6), (2.1, 7), (-3, 8)):
        # The wall is selected: its handles are no obstacle.
        editor.click(1.2, y)
        editor.tool("door")
        editor.click(0, y)
        editor.wait(lambda it, n=walls: len(it.data["world"]["walls"]) == n)
    from hunav_drake.scenario.reachability import check_ways

    world = editor.session.scenario
    gap = [it for it in world.world.walls if it.name.startswith("rail")]
    assert [it.points[-1][0] for it in gap] == [-0.45, 4.0]
    # The outer ends are open; the ways through the doors are 0.9 m wide.
    assert not list(check_ways(world))
    editor.tool("door")
    editor.click(0, 1)
    editor.expect(told).to_contain_text("there is no wall at (0.00, 1.00)")
    editor.undo_all()
    editor.wait(lambda it: it.text == two)


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


def test_keys_work_before_a_click_and_after_a_button(open_editor):
    editor = open_editor(SMALL)
    tool = editor.page.locator(".map")
    for key, name in (("p", "person"), ("w", "wall"), ("f", "furniture")):
        editor.press(key)
        editor.expect(tool).to_have_attribute("data-tool", name)
        editor.press("Escape")
    # The list of parts has the focus, and the buttons above.
    editor.page.locator('[data-row="humans/1"]').click()
    editor.press("Delete")
    editor.wait(lambda it: len(it.data["humans"]) == 1)
    editor.page.locator(".step.undo").click()
    editor.wait(lambda it: it.text == SMALL)
    editor.press("g")
    editor.expect(tool).to_have_attribute("data-tool", "goal")
    # Fields take letters as letters.
    editor.page.get_by_label("Search the parts").press_sequentially("rp")
    editor.expect(tool).to_have_attribute("data-tool", "goal")


def test_furniture_is_chosen_by_its_picture_and_drawn_from_above(open_editor):
    editor = open_editor(SMALL)
    cards = editor.page.locator(".palette .kind-card")
    editor.press("f")
    # This scenario has a table; the others follow by how common they are.
    assert cards.all_inner_texts()[:3] == ["table", "chair", "shelf"]
    for k in range(cards.count()):
        box = cards.nth(k).locator(".shape").bounding_box()
        assert min(box["width"], box["height"]) > 3
    cards.get_by_text("bed", exact=True).click()
    editor.click(-1, -1.5)
    editor.wait(lambda it: len(it.data["world"]["furniture"]) == 2)
    bed = editor.part("world/furniture/1")
    # Frame, mattress, blanket, pillow and headboard, and what it is.
    editor.settle()
    assert bed.locator(".piece").count() >= 4
    editor.expect(bed.locator(".kind")).to_have_text("bed")
    headboard = bed.locator(".piece").last.bounding_box()
    whole = bed.locator(".shape").bounding_box()
    assert abs(headboard["x"] - whole["x"]) < 2
    assert headboard["width"] < 0.2 * whole["width"]
    # It turns with its parts.
    editor.press("Escape", "]", "]")
    editor.settle()
    turned = bed.locator(".piece").last.bounding_box()
    assert turned["width"] > 1.5 * headboard["width"]
    # What is used most comes first.
    for x in (1, 3):
        editor.press("f")
        cards.get_by_text("bed", exact=True).click()
        editor.click(x, -1.5)
    editor.press("Escape")
    editor.press("f")
    assert cards.first.inner_text() == "bed"


def test_the_step_to_undo_is_readable(open_editor):
    editor = open_editor(SMALL, view={"width": 1280, "height": 800})
    editor.part("humans/1").click()
    editor.page.get_by_role("button", name="Duplicate (Ctrl+D)").click()
    name = editor.page.locator(".step.undo .step-name")
    editor.expect(name).to_have_text("Copy bruno")
    # Nothing of it is cut off, also with a long one and many problems.
    shows = "it => it.scrollWidth <= it.clientWidth + 1"
    assert name.evaluate(shows)
    editor.tool("robot-goal")
    editor.drag((3, 1.5), (4, 1.5))
    editor.expect(name).to_have_text("Place the robot's goal")
    assert name.evaluate(shows)


def test_on_a_telephone_the_settings_are_below_the_map(open_editor):
    editor = open_editor(SMALL, view={"width": 390, "height": 800})
    for selector in (".map", ".right", ".tool-bar", ".button.primary"):
        box = editor.page.locator(selector).first.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
        assert box["y"] + box["height"] <= 800
