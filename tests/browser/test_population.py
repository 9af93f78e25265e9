"""People whom a seed draws, on the map before a run."""

from tests.browser.driver import SharedWorker, at, near

# The simulation is loaded, perhaps on a busy machine.
PATIENCE = 300

DRAWN = """\
# Guests come from the south.
humans:
  - {name: ana, pose: [0, 0, 0]}
robot: {start: [-6, 0, 0]}
population:
  seed: 3
  cohorts:
    - name: guest
      number: 4
      start: [{rectangle: [-4, -4, 4, -2]}]
      goals: [{rectangle: [-4, 2, 4, 4]}]
    - {number: 2, start: [{rectangle: [5, -4, 7, 4]}]}
"""


def drawn_by(text):
    from hunav_drake.scenario import LoadScenario, draw_people

    return draw_people(LoadScenario(data=text))


def test_drawn_people_are_shown_and_become_their_own(open_editor, worker):
    editor = open_editor(DRAWN, worker=SharedWorker(worker))
    shown = editor.page.locator(".map .drawn .person")
    editor.expect(shown).to_have_count(6, timeout=1000 * PATIENCE)
    wanted = drawn_by(DRAWN)[1:]
    for k, person in enumerate(wanted):
        assert near(place_of(editor, f"drawn/{k}"), person.pose[:2], 0.1)
    label = editor.part("drawn/0").get_attribute("aria-label")
    assert label.startswith(f"{wanted[0].name}, drawn by the seed 3")
    # Another seed draws them elsewhere.
    text = DRAWN.replace("seed: 3", "seed: 4")
    editor.tab("yaml")
    editor.page.locator(".yaml").fill(text)
    moved = drawn_by(text)[1]

    def is_at(person):
        wanted = person.pose[:2]
        return lambda _: near(place_of(editor, "drawn/0"), wanted, 0.1)

    editor.wait(is_at(moved), PATIENCE)
    editor.page.locator(".step").first.click()
    editor.expect(shown).to_have_count(6, timeout=1000 * PATIENCE)
    editor.wait(lambda it: it.text == DRAWN)
    # Back at seed 3: one of the guests is dragged, so all four are listed.
    first = wanted[0]
    editor.wait(is_at(first), PATIENCE)
    editor.drag(first.pose[:2], (0, 3))
    editor.wait(lambda it: len(it.data["humans"]) == 5)
    listed = editor.session.data["humans"][1:]
    assert near(listed[0]["pose"][:2], (0, 3), 0.11)
    assert [it["name"] for it in listed] == [it.name for it in wanted[:4]]
    for mine, person in zip(listed[1:], wanted[1:], strict=False):
        assert near(mine["pose"], person.pose, 2e-3)
        assert near(mine["goals"][0], person.goals[0], 2e-3)
    assert len(editor.session.data["population"]["cohorts"]) == 1
    toast = editor.page.locator(".toast")
    editor.expect(toast).to_contain_text("Make 4 people of guest their own")
    # Those of the other cohort are drawn as before.
    editor.expect(shown).to_have_count(2, timeout=1000 * PATIENCE)
    editor.expect(editor.page.locator(".step").first).to_be_enabled()
    editor.undo_all()
    editor.wait(lambda it: it.text == DRAWN)


def place_of(editor, key):
    disc = editor.part(key).locator(".disc")
    box = disc.bounding_box() if disc.count() else None
    if box is None:
        return None
    return editor.world(
        box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    )


def test_a_cohort_becomes_listed_people_by_the_keyboard(open_editor, worker):
    editor = open_editor(DRAWN, worker=SharedWorker(worker))
    shown = editor.page.locator(".map .drawn .person")
    editor.expect(shown).to_have_count(6, timeout=1000 * PATIENCE)
    row = '[data-row="population/cohorts/1"]'
    editor.tab_to(row)
    editor.press("Enter")
    editor.tab_to('[title^="Lists these people"]')
    editor.press("Enter")
    editor.wait(lambda it: len(it.data["humans"]) == 3)
    assert len(at(editor.session.data, ["population", "cohorts"])) == 1
    editor.press("Control+z")
    editor.wait(lambda it: it.text == DRAWN)
