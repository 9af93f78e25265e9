"""Forms, the text, problems and files."""

import re

from tests.agents import AGENTS
from tests.browser.driver import SMALL, at, near


def test_a_range_is_told_at_its_field(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 2)
    field = editor.field("desired_speed")
    field.locator("input").fill("12")
    editor.wait(lambda it: len(it.faults) == 1)
    fault = field.locator(".field-fault")
    editor.expect(fault).to_contain_text("[0, 10] m/s")
    editor.expect(field.locator("input")).to_have_attribute(
        "aria-invalid", "true"
    )
    field.locator("input").fill("1.3")
    editor.wait(lambda it: it.faults == [])
    fault.wait_for(state="hidden")


def test_fields_show_unit_range_and_help(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 0)
    field = editor.field("desired_speed")
    field.locator("input").focus()
    editor.expect(field.locator(".unit")).to_have_text("m/s")
    words = editor.page.locator(".help-strip:visible")
    editor.expect(words).to_contain_text("Desired speed")
    editor.expect(words).to_contain_text("0 to 10 m/s")


def test_angles_may_be_typed_in_degrees_and_keys_reset(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 2)
    yaw = editor.field("pose").locator("input").nth(2)
    yaw.fill("90deg")
    yaw.press("Enter")
    editor.wait(
        lambda it: near([at(it.data, ["humans", 1, "pose", 2])], [1.5708], 1e-3)
    )
    editor.field("desired_speed").get_by_role("button").click()
    editor.wait(lambda it: "desired_speed" not in it.data["humans"][1])
    speed = editor.field("desired_speed").locator("input")
    editor.expect(speed).to_have_value("")
    editor.expect(speed).to_have_attribute("placeholder", re.compile(r"1\.2"))


def test_typed_text_moves_the_map(open_editor):
    editor = open_editor(SMALL)
    editor.tab("yaml")
    area = editor.page.locator("textarea.yaml")
    area.fill(SMALL.replace("pose: [-3, 0, 0]", "pose: [-1, 0, 0]"))
    editor.wait_for(["humans", 0, "pose"], [-1, 0, 0])
    moved = "[data-key='humans/0'] > g[transform='translate(-1 0)']"
    editor.page.locator(moved).wait_for(state="attached")


def test_broken_text_is_told_and_the_map_kept(open_editor):
    editor = open_editor(SMALL)
    editor.tab("yaml")
    area = editor.page.locator("textarea.yaml")
    area.fill(SMALL.replace("goals: [[1, 2]]", "goals: [[1, 2]"))
    banner = editor.page.locator(".banner")
    editor.expect(banner).to_contain_text("line 20: is not YAML")
    editor.expect(editor.page.locator(".map .person")).to_have_count(2)
    # Edits on the map wait.
    editor.drag((-3, 0), (-2, 1))
    editor.page.locator(".toast", has_text="fix it first").wait_for()
    assert at(editor.session.data, ["humans", 0, "pose"]) == [-3, 0, 0]
    area.fill(SMALL)
    banner.wait_for(state="hidden")


def test_people_only_begun_in_the_text_do_not_stop_the_page(open_editor):
    editor = open_editor(
        "humans:\n  -\n  - {name: b, pose: [-3, 0, 90deg]}\nsensors: {a: {}}\n"
    )
    editor.part("humans/1").click()
    editor.expect(editor.field("name").locator("input")).to_have_value("b")
    editor.drag((-3, 0), (-2, 1))
    editor.wait_for(["humans", 1, "pose"], [-2, 1, "90deg"])
    editor.undo_all()
    problems = editor.page.locator(".problem")
    editor.expect(problems.filter(has_text="sensors")).not_to_have_count(0)


def test_a_broken_text_is_told_together_with_its_reason(open_editor):
    wrong = SMALL.replace("desired_speed: 1.1", "desired_speed: 99")
    editor = open_editor(wrong)
    editor.tab("yaml")
    editor.page.evaluate(
        """() => {
          window.told = [];
          const banner = document.querySelector(".banner");
          const note = () => banner.hidden || told.push(banner.textContent);
          new MutationObserver(note).observe(banner,
            {attributes: true, childList: true});
        }"""
    )
    area = editor.page.locator("textarea.yaml")
    for text in (wrong.replace("[1, 2]]", "[1, 2]"), "just words", wrong):
        area.fill(text)
        editor.wait(lambda it, text=text: it.text == text)
        editor.settle()
    # Never without a reason, never with what was wrong before.
    told = list(dict.fromkeys(editor.page.evaluate("told")))
    assert len(told) == 2
    assert "line 20: is not YAML" in told[0]
    assert "line 1: a scenario is a mapping" in told[1]


def test_selection_marks_lines_and_the_caret_selects(open_editor):
    editor = open_editor(SMALL)
    editor.tab("yaml")
    editor.click(-3, 2)
    editor.page.locator(".line-mark").wait_for()
    editor.page.locator("[data-key='humans/1'].selected").wait_for()
    area = editor.page.locator("textarea.yaml")
    start = SMALL.index("# at the door")
    area.focus()
    area.evaluate("(it, at) => it.setSelectionRange(at, at)", start)
    editor.press("ArrowRight")
    editor.page.locator("[data-key='humans/0'].selected").wait_for()


def test_an_edit_keeps_comments_and_spacing(open_editor):
    editor = open_editor(SMALL)
    editor.click(-3, 2)
    editor.field("desired_speed").locator("input").fill("0.9")
    editor.wait_for(["humans", 1, "desired_speed"], 0.9)
    wanted = SMALL.replace("desired_speed: 1.1", "desired_speed: 0.9")
    editor.wait(lambda it: it.text == wanted)
    assert "pose: [ -3, 2.0,0 ]" in wanted


def choose_file(editor, entry, path):
    """Gives a file to an entry of the menu."""
    with editor.page.expect_file_chooser() as chosen:
        editor.page.get_by_role("button", name="File", exact=True).click()
        editor.page.get_by_role("menuitem", name=entry).click()
    chosen.value.set_files(path)


def test_agents_of_hunavsim_are_imported(open_editor, tmp_path):
    agents = tmp_path / "agents.yaml"
    agents.write_text(AGENTS)
    editor = open_editor("robot: {start: [5, 5, 0]}\n")
    choose_file(editor, "Import agents.yaml", agents)
    editor.wait(lambda it: len(it.data.get("humans", [])) == 1)
    assert near(at(editor.session.data, ["humans", 0, "pose"])[:2], (-3, 7))
    editor.part("humans/0").wait_for()
    # What has no counterpart is told; the import is one step.
    notes = editor.page.locator("dialog[open] .notes")
    editor.expect(notes).to_contain_text("skin")
    editor.press("Escape")
    editor.page.locator(".step").first.click()
    editor.wait(lambda it: it.text == "robot: {start: [5, 5, 0]}\n")


def test_metrics_of_hunavsim_are_imported(open_editor, tmp_path):
    metrics = tmp_path / "metrics.yaml"
    metrics.write_text(METRICS)
    editor = open_editor(SMALL)
    choose_file(editor, "Import metrics.yaml", metrics)
    path = ["evaluator", "metrics"]
    editor.wait_for(path, ["time_to_reach_goal", "path_length"])
    assert at(editor.session.data, ["evaluator", "period"]) == 0.1
    # All else is as it was, comments too; and so it is after undo.
    editor.wait(lambda it: it.text.startswith(SMALL))
    editor.press("Escape")
    editor.page.locator(".step").first.click()
    editor.wait(lambda it: it.text == SMALL)


def test_a_faulty_import_is_told_with_its_line(open_editor, tmp_path):
    agents = tmp_path / "agents.yaml"
    agents.write_text(AGENTS.replace("max_vel: 1.5", "max_vel: fast"))
    editor = open_editor(SMALL)
    choose_file(editor, "Import agents.yaml", agents)
    editor.page.get_by_role("button", name="Replace them").click()
    told = editor.page.locator(".toast", has_text="max_vel")
    line = AGENTS.splitlines().index("      max_vel: 1.5") + 1
    editor.expect(told).to_contain_text(f"agents.yaml:{line}")
    assert editor.session.text == SMALL


def test_what_was_just_typed_is_saved(open_editor, tmp_path):
    editor = open_editor(SMALL)
    editor.tab("yaml")
    area = editor.page.locator("textarea.yaml")
    area.press_sequentially("# mine\n")
    editor.press("Control+s")
    path = tmp_path / "scene.yaml"
    editor.wait(lambda _: "# mine" in path.read_text())
    editor.part("humans/0").click()
    name = editor.field("name").locator("input")
    name.fill("zoe")
    editor.press("Control+s")
    editor.wait(lambda _: "zoe" in path.read_text())


def test_a_text_stays_typed_while_the_page_is_told_something(open_editor):
    editor = open_editor(SMALL)
    editor.part("humans/0").click()
    name = editor.field("name").locator("input")
    name.fill("zoe")
    name.press("Tab")
    # As when the simulation has checked the scenario.
    with editor.session._lock:
        editor.session.send_state(None, None)
    editor.wait_for(["humans", 0, "name"], "zoe")


def test_save_writes_that_file_only(open_editor, tmp_path):
    other = tmp_path / "other.yaml"
    other.write_text("humans: []\n")
    editor = open_editor(SMALL)
    editor.drag((-3, 0), (-2, 1))
    editor.wait(
        lambda it: near(at(it.data, ["humans", 0, "pose"])[:2], (-2, 1))
    )
    assert (tmp_path / "scene.yaml").read_text() == SMALL
    editor.page.locator(".unsaved").wait_for()
    editor.press("Control+s")
    editor.page.locator(".unsaved").wait_for(state="hidden")
    assert (tmp_path / "scene.yaml").read_text() == editor.session.text
    assert sorted(it.name for it in tmp_path.iterdir()) == [
        "other.yaml",
        "scene.yaml",
    ]
    assert other.read_text() == "humans: []\n"


def test_a_file_changed_by_another_is_asked_for(open_editor, tmp_path):
    editor = open_editor(SMALL)
    editor.drag((-3, 0), (-2, 1))
    editor.wait(
        lambda it: near(at(it.data, ["humans", 0, "pose"])[:2], (-2, 1))
    )
    (tmp_path / "scene.yaml").write_text(SMALL.replace("bruno", "berta"))
    dialog = editor.page.locator("dialog[open]")
    editor.expect(dialog).to_contain_text("changed by another program")
    dialog.get_by_role("button", name="Yes").click()
    editor.wait(lambda it: at(it.data, ["humans", 1, "name"]) == "berta")


def test_what_was_not_saved_outlives_the_server(open_editor, tmp_path):
    editor = open_editor(SMALL)
    editor.drag((-3, 0), (-2, 1))
    editor.wait(lambda it: "pose: [-2, 1, 0]" in it.text)
    kept = editor.session.text
    editor.page.wait_for_function(
        "text => Object.values(localStorage).some("
        "it => JSON.parse(it).text === text)",
        arg=kept,
    )
    # All has ended without a word; the file is opened again.
    editor.page.close()
    port = editor.server.page.port
    editor.restart(filename=tmp_path / "scene.yaml", folder=tmp_path)
    assert editor.server.page.port == port
    assert editor.session.text == SMALL
    dialog = editor.page.locator("dialog[open]")
    editor.expect(dialog).to_contain_text("unsaved changes")
    # Whoever does not answer is asked again.
    editor.page.reload()
    dialog.get_by_role("button", name="Restore").click()
    editor.wait(lambda it: it.text == kept)
    assert (tmp_path / "scene.yaml").read_text() == SMALL


def test_work_that_is_discarded_is_not_offered_again(open_editor, tmp_path):
    editor = open_editor(SMALL)
    editor.drag((-3, 0), (-2, 1))
    editor.page.wait_for_function("() => localStorage.length === 1")
    editor.page.close()
    editor.restart(filename=tmp_path / "scene.yaml", folder=tmp_path)
    dialog = editor.page.locator("dialog[open]")
    dialog.get_by_role("button", name="Discard").click()
    editor.page.wait_for_function("() => localStorage.length === 0")
    assert editor.session.text == SMALL


def test_two_pages_stay_in_step(open_editor):
    editor = open_editor(SMALL)
    other = editor.new_page()
    editor.drag((-3, 0), (-2, 1))
    editor.wait(
        lambda it: near(at(it.data, ["humans", 0, "pose"])[:2], (-2, 1))
    )
    moved = "[data-key='humans/0'] > g[transform='translate(-2 1)']"
    other.locator(moved).wait_for(state="attached")
    other.locator(".step").first.click()
    editor.wait(lambda it: it.text == SMALL)
    back = "[data-key='humans/0'] > g[transform='translate(-3 0)']"
    editor.page.locator(back).wait_for(state="attached")


METRICS = """\
hunav_evaluator_node:
  ros__parameters:
    frequency: 10.0
    metrics:
      time_to_reach_goal: true
      path_length: true
      total_collisions: false
"""
