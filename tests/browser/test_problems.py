"""What `hunav check` finds is told at its place, with the same words."""

import pytest

from tests.browser.driver import SharedWorker, at

# The simulation is loaded, perhaps on a busy machine.
PATIENCE = 300

# A closed room: three people outside want in, and the robot; and two inside
# want out.
CLOSED = """\
world:
  walls:
    - {type: box, name: north, center: [0, 2], size: [4.2, 0.2]}
    - {type: box, name: south, center: [0, -2], size: [4.2, 0.2]}
    - {type: box, name: east, center: [2, 0], size: [0.2, 4.2]}
    - {type: box, name: west, center: [-2, 0], size: [0.2, 4.2]}
    - {type: box, name: bar, center: [0, 1.75], size: [3.6, 0.5]}
humans:
  - {name: ana, pose: [-5, 0, 0], goals: [[0, 0.5]]}
  - {name: ben, pose: [-5, 1, 0], goals: [[-4, 1], [0, -0.5]]}
  - {name: cem, pose: [5, 1, 0], goals: [[1, 0]]}
  - {name: dora, pose: [-0.5, -1, 0], goals: [[5, 4]]}
  - {name: emil, pose: [1, -1, 0], goals: [[5, 3]]}
  - {name: fay, pose: [5, 3, 0], goals: [[0.3, 0]]}
robot:
  start: [-4, -3, 0]
  goal: [0.5, -0.5, 0]
"""


def checked(path):
    """Returns the messages of `hunav check` about a file."""
    from hunav_drake.scenario import LoadScenario, ScenarioError

    with pytest.raises(ScenarioError) as caught:
        LoadScenario(filename=path, ways=True)
    return [it.message for it in caught.value.faults]


def test_the_editor_tells_what_hunav_check_tells(open_editor, worker, tmp_path):
    editor = open_editor(CLOSED, worker=SharedWorker(worker))
    wanted = checked(tmp_path / "scene.yaml")
    assert len(wanted) == 7
    told = editor.page.locator(".faults")
    editor.expect(told).to_have_text("7 problems", timeout=1000 * PATIENCE)
    editor.tab("problems")
    shown = editor.page.locator(".problem-text").all_inner_texts()
    named = []
    for message in wanted:
        words = message.replace("; ", ": ")
        text = next(it for it in shown if it.endswith(words))
        shown.remove(text)
        named.append(text.partition(" line")[0])
    # At the goals, which are marked, and by name.
    goals = editor.page.locator(".map .goal.faulty, .map .goal.warned")
    editor.expect(goals).to_have_count(6)
    assert sorted(named)[:3] == [
        "goal 1 of ana",
        "goal 1 of cem",
        "goal 1 of dora",
    ]
    assert shown == []
    # After a change, they are looked for again; nobody has to ask.
    editor.part("world/walls/3").click()
    editor.press("Delete")
    editor.expect(told).to_have_text("No problems", timeout=1000 * PATIENCE)
    editor.press("Control+z")
    editor.expect(told).to_have_text("7 problems", timeout=1000 * PATIENCE)


def test_text_and_button_have_one_remedy(open_editor, worker, tmp_path):
    editor = open_editor(CLOSED, worker=SharedWorker(worker))
    # Between the bar and the wall, with no room on the near side.
    path = ["humans", 3, "pose"]
    editor.part("humans/3").click()
    with editor.pressed(-0.5, -1):
        editor.drop_at((0.4, 1.7))
    editor.wait(lambda it: at(it.data, path)[1] > 1)
    editor.tab("problems")
    problem = editor.page.locator(".problem", has_text="move it")
    button = problem.locator(".fix")
    text = problem.locator(".problem-text").inner_text()
    label = button.inner_text()
    assert label.startswith("Move it ")
    assert f": m{label[1:]}" in text
    # Run says who it is about.
    editor.page.get_by_role("button", name="Run (Ctrl+Enter)").first.click()
    toast = editor.page.locator(".toast")
    editor.expect(toast).to_contain_text("dora pose: ")
    button.click()
    left = editor.page.locator(".fix", has_text="Move it")
    editor.expect(left).to_have_count(0)
    problems = [it["message"] for it in editor.session.faults]
    assert not any("move it" in it for it in problems)
    path = tmp_path / "after.yaml"
    path.write_text(editor.session.text)
    assert all(it.startswith("cannot be reached") for it in checked(path))
