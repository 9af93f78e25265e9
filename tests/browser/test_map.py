"""People, goals and the robot on the map, by the mouse and by keys."""

import math

from tests.browser.driver import SMALL, at, near


def test_a_dragged_person_is_there_in_data_text_and_form(open_editor):
    editor = open_editor(SMALL)
    editor.drag((-3, 2), (-1, 1))
    editor.wait(lambda it: near(at(it.data, ["humans", 1, "pose"]), (-1, 1, 0)))
    # Written as it was, with its spaces.
    editor.wait(lambda it: "pose: [ -1, 1,0 ]" in it.text)
    editor.settle()
    values = editor.field("pose").locator("input")
    for value, wanted in zip(values.all(), ("-1", "1", "0"), strict=True):
        editor.expect(value).to_have_value(wanted)
    assert "# at the door" in editor.session.text
    # One step, with a name.
    undo = editor.page.locator(".step").first
    editor.wait(lambda _: undo.get_attribute("title").endswith("Move bruno"))
    undo.click()
    editor.wait(lambda it: it.text == SMALL)
    editor.wait(lambda _: undo.is_disabled())


def test_the_chain_follows_a_dragged_goal(open_editor):
    editor = open_editor(SMALL)
    way = editor.page.locator('[data-chain="humans/0"] + .way')
    with editor.pressed(2, 0):
        editor.drop_at((2, 1))
        # While it is still held.
        editor.wait(lambda _: way.get_attribute("d") == "M-3 0L0 0L2 1")
        assert at(editor.session.data, ["humans", 0, "goals", 1]) == [2, 0]
    editor.wait_for(["humans", 0, "goals", 1], [2, 1])
    assert at(editor.session.data, ["humans", 0, "goals", 0]) == [0, 0]


def test_a_person_is_turned_by_the_handle_and_by_keys(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 0)
    editor.drag_handle("turn", (-3, 2))
    editor.wait(
        lambda it: (
            abs(at(it.data, ["humans", 0, "pose", 2]) - math.pi / 2) < 0.02
        )
    )
    before = at(editor.session.data, ["humans", 0, "pose", 2])
    editor.press("]")
    editor.wait(
        lambda it: (
            abs(at(it.data, ["humans", 0, "pose", 2]) - before + math.pi / 12)
            < 2e-3
        )
    )


def test_the_robot_is_placed_by_press_and_pull(open_editor):
    editor = open_editor(SMALL)
    editor.tool("robot")
    editor.drag((-2, -1), (-2, -0.2))
    editor.wait(
        lambda it: near(at(it.data, ["robot", "start"]), (-2, -1, 1.571), 0.03)
    )
    editor.tool("robot-goal")
    editor.drag((2, -1), (3, -1))
    editor.wait(
        lambda it: near(at(it.data, ["robot", "goal"]), (2, -1, 0), 0.03)
    )
    editor.drag((2, -1), (1, -1.5))
    editor.wait(
        lambda it: near(at(it.data, ["robot", "goal"]), (1, -1.5, 0), 0.03)
    )


def test_robots_are_added_moved_named_and_removed(open_editor):
    text = SMALL.replace("start: [-2, -2, 0]", "start: [-2, -1, 0]")
    editor = open_editor(text.replace("goal: [3, -2, 0]", "goal: [3, -1, 0]"))
    before = editor.session.text
    add = editor.page.get_by_role("button", name="Add a robot beside")
    add.click()
    editor.wait(lambda it: len(at(it.data, ["robots"]) or ()) == 2)
    assert "robot" not in editor.session.data
    assert at(editor.session.data, ["robots", 0, "name"]) == "robot_1"
    assert "# who comes first" in editor.session.text
    editor.part("robots/1/robot/goal").wait_for()
    start = at(editor.session.data, ["robots", 1, "robot", "start"])
    editor.drag(start[:2], (1, 1))
    editor.wait(
        lambda it: near(at(it.data, ["robots", 1, "robot", "start"]), (1, 1, 0))
    )
    editor.settle()
    name = editor.field("name").locator("input")
    name.fill("bob")
    name.press("Tab")
    editor.wait_for(["robots", 1, "name"], "bob")
    label = editor.part("robots/1/robot/start").locator(".name")
    editor.expect(label).to_have_text("bob")
    add.click()
    editor.wait(lambda it: len(it.data["robots"]) == 3)
    assert at(editor.session.data, ["robots", 2, "name"]) == "bob_2"
    editor.focus_map()
    editor.press("Control+c", "Control+v")
    editor.wait(lambda it: len(it.data["robots"]) == 4)
    starts = [it["robot"]["start"] for it in editor.session.data["robots"]]
    assert starts[3] != starts[2]
    editor.press("Delete")
    editor.wait(lambda it: len(it.data["robots"]) == 3)
    # One robot stays.
    editor.press("Control+a", "Delete")
    editor.wait(lambda it: len(it.data["robots"]) == 1)
    editor.settle()
    editor.undo_all()
    assert editor.session.text == before


def test_a_person_with_goals_is_added_by_the_mouse(open_editor):
    editor = open_editor(SMALL)
    editor.tool("person")
    editor.drag((0, 1), (0, 2))
    editor.click(1, 1)
    editor.click(2.5, 3)
    editor.double_click(-1, 3)
    editor.wait(lambda it: len(it.data["humans"]) == 3)
    editor.wait(lambda it: len(it.data["humans"][2].get("goals", [])) == 3)
    person = editor.session.data["humans"][2]
    assert near(person["pose"], (0, 1, 1.571), 0.03)
    assert near(person["goals"][0], (1, 1))
    assert near(person["goals"][2], (-1, 3))
    # The tool goes on with the next person.
    editor.click(4, 3)
    editor.wait(lambda it: len(it.data["humans"]) == 4)
    names = [it["name"] for it in editor.session.data["humans"]]
    assert len(set(names)) == 4


def test_goals_are_inserted_reordered_and_closed_to_a_round(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 0)
    editor.press("g")
    # On the way from the first to the second.
    editor.click(1, 0)
    editor.wait(lambda it: len(at(it.data, ["humans", 0, "goals"])) == 3)
    assert near(at(editor.session.data, ["humans", 0, "goals", 1]), (1, 0))
    editor.click(0, 0)
    editor.wait_for(["humans", 0, "cyclic"], True)
    editor.press("Escape")
    editor.page.locator('[aria-label="y of point 2"]').focus()
    editor.press("Alt+ArrowUp")
    editor.wait(lambda it: near(at(it.data, ["humans", 0, "goals", 0]), (1, 0)))
    assert near(at(editor.session.data, ["humans", 0, "goals", 1]), (0, 0))


def test_undo_brings_back_comments(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 0)
    editor.press("Delete")
    editor.wait(lambda it: len(it.data["humans"]) == 1)
    editor.wait(lambda it: "# at the door" not in it.text)
    editor.press("Control+z")
    editor.wait(lambda it: it.text == SMALL)
    editor.press("Control+Shift+z")
    editor.wait(lambda it: len(it.data["humans"]) == 1)


def test_twenty_edits_are_undone_and_done_again_to_the_byte(open_editor):
    editor = open_editor(SMALL)
    for _ in range(4):
        editor.click(-3, 0)
        editor.press("]", "Control+d", "Shift+ArrowUp", "Shift+G", "Delete")
        editor.settle()
        editor.press("Escape")
    editor.settle()
    after = editor.session.text
    assert after != SMALL
    editor.undo_all()
    assert editor.session.text == SMALL
    redo = editor.page.locator(".step").nth(1)
    while not redo.is_disabled():
        redo.click()
        editor.settle()
    assert editor.session.text == after


def test_several_are_moved_grouped_and_set_in_one_step_each(open_editor):
    people = "".join(
        f"  - {{name: p{i}, pose: [{i - 2}, 0, 0]}}\n" for i in range(5)
    )
    text = f"humans:\n{people}"
    editor = open_editor(text)
    editor.drag((-3, 1), (3, -1))
    editor.drag((0, 0), (0, 2))
    editor.wait(
        lambda it: all(
            near(p["pose"][:2], (i - 2, 2))
            for i, p in enumerate(it.data["humans"])
        )
    )
    editor.press("Control+g")
    editor.wait(
        lambda it: {p.get("group_id") for p in it.data["humans"]} == {1}
    )
    speed = editor.field("desired_speed").locator("input")
    speed.fill("0.7")
    speed.press("Enter")
    editor.wait(
        lambda it: {p.get("desired_speed") for p in it.data["humans"]} == {0.7}
    )
    undo = editor.page.locator(".step").first
    for _ in range(3):
        undo.click()
        editor.settle()
    assert editor.session.text == text
    assert undo.is_disabled()


def test_what_is_pasted_has_a_name_of_its_own(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 2)
    editor.press("Control+c", "Control+v")
    editor.wait(lambda it: len(it.data["humans"]) == 3)
    editor.press("Control+v")
    editor.wait(lambda it: len(it.data["humans"]) == 4)
    names = [it["name"] for it in editor.session.data["humans"]]
    assert len(set(names)) == 4
    assert at(editor.session.data, ["humans", 2, "desired_speed"]) == 1.1


def test_behaviors_name_the_same_people_after_one_is_removed(open_editor):
    text = """\
humans:
  - {name: kim, pose: [0, -2, 0], id: 6}
  - {name: ann, pose: [0, 4, 0], behavior: {type: talk, people: "3"}}
  - {name: ben, pose: [2, 0, 0]}
  - {name: eva, pose: [0, 2, 0]}
  - {name: tom, pose: [2, 2, 0]}
  - {name: leo, pose: [4, 2, 0], id: 0}
"""
    editor = open_editor(text)
    editor.part("humans/2").click()
    editor.press("Delete")
    editor.wait(lambda it: len(it.data["humans"]) == 5)
    editor.settle()
    humans = editor.session.scenario.humans
    assert [it.id for it in humans] == [6, 1, 3, 4, 0]
    editor.undo_all()
    assert editor.session.text == text


def test_escape_takes_a_drag_back(open_editor):
    editor = open_editor(SMALL)
    with editor.pressed(-3, 0):
        editor.drop_at((3, 1.5))
        editor.page.locator("[data-key='humans/0'].faulty").wait_for()
        editor.press("Escape")
    editor.settle()
    assert editor.session.text == SMALL
    place = editor.part("humans/0").locator("> g")
    editor.expect(place).to_have_attribute("transform", "translate(-3 0)")
    editor.expect(editor.page.locator(".faults")).to_have_text("No problems")


def test_copies_are_dragged_off_with_control(open_editor):
    editor = open_editor(SMALL)
    editor.page.keyboard.down("Control")
    editor.drag((3, 1.5), (0, 1.5))
    editor.page.keyboard.up("Control")
    editor.wait(lambda it: len(it.data["world"]["furniture"]) == 2)
    first, second = editor.session.data["world"]["furniture"]
    assert first["center"] == [3, 1.5]
    assert near(second["center"], (0, 1.5))
    assert second["name"] == "desk_2"
