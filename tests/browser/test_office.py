"""An office made from nothing to the table of results, by the mouse alone."""

import math
import os
from pathlib import Path
import time

import pytest

from tests.browser.driver import at, near

# The simulation is loaded, perhaps compiled, perhaps on a busy machine.
PATIENCE = 300
# A folder for pictures of each step, to look at; none by default.
PICTURES = os.environ.get("HUNAV_EDITOR_PICTURES")

# Side by side: the second one begins at the face of the wall between them.
ROOMS = [((-5.5, 1), (-0.5, 4.6)), ((-0.42, 1.06), (5.5, 4.6))]
DOORS = [(-3, 1), (3, 1)]
# From room to room.
BETWEEN = (-0.5, 2.8)
# Where each person starts and looks, and the goals.
PEOPLE = [
    ((-4.8, 2), (-4.8, 3), [(-3, 2), (-3, -0.4)]),
    ((-2, 2), (-1.4, 2), [(-3, 0), (1, -0.6)]),
    ((-1.2, 3.4), (-1.2, 2.6), [(-4.2, 3)]),
    ((4.8, 2), (4.8, 3), [(3, 2), (3, -0.4)]),
    ((1.2, 2), (2, 2), [(3, 0.2), (-1, -0.5)]),
    ((1.2, 3.4), (1.2, 2.6), [(-2.4, 2.6)]),
    ((4.6, 0), (3.8, 0), [(-4.6, 0)]),
    ((-4.4, -1), (-3.6, -1), [(4.4, -0.2)]),
]
BEHAVIORS = {2: "curious", 6: "surprised"}


@pytest.fixture
def office(open_editor):
    from hunav_drake.editor.worker import Worker

    worker = Worker()
    worker.start()
    yield open_editor(
        None,
        view={"width": 1440, "height": 900},
        worker=worker,
        find_file=worker.file,
    )
    worker.close()


class Pictures:
    """Takes a picture of each step, if they are wanted."""

    def __init__(self, editor):
        self._editor = editor
        self._count = 0

    def take(self, name):
        if PICTURES:
            self._count += 1
            path = Path(PICTURES) / f"office_{self._count:02d}_{name}.png"
            self._editor.page.screenshot(path=path)


def test_an_office_of_eight_people_is_made_by_the_mouse(office, tmp_path):
    editor, page, begin = office, office.page, time.monotonic()
    pictures = Pictures(editor)
    dialog = page.locator("dialog[open]")
    dialog.wait_for()
    pictures.take("start")
    dialog.locator(".card").first.click()

    make_rooms(editor)
    pictures.take("rooms")
    make_people(editor)
    pictures.take("people")
    choose_behaviors(editor)
    pictures.take("behaviors")
    place_robot(editor)
    assert editor.session.faults == []
    pictures.take("robot")

    page.get_by_role("button", name="Save (Ctrl+S)").click()
    pictures.take("save")
    dialog.get_by_role("button", name="Save").click()
    editor.wait(lambda it: list(tmp_path.glob("*.yaml")))
    (saved,) = tmp_path.glob("*.yaml")
    assert saved.read_text() == editor.session.text

    page.get_by_role("button", name="Run (Ctrl+Enter)").first.click()
    page.wait_for_timeout(500)
    pictures.take("waiting")
    # Its compilation is not the editor's.
    before = time.monotonic()
    page.locator(".run-going").wait_for(timeout=1000 * PATIENCE)
    loading = time.monotonic() - before
    page.wait_for_timeout(600)
    pictures.take("running")
    page.locator(".run-head").wait_for(timeout=1000 * PATIENCE)
    seconds = time.monotonic() - begin - loading
    pictures.take("result")
    end = page.locator(".run-end")
    assert end.inner_text() == "reached the goal"

    check_table(editor, saved)
    page.locator(".run-links", has_text="Report").wait_for(
        timeout=1000 * PATIENCE
    )
    # The middle of the run, by a click on the slider of time.
    page.get_by_label("Time of the run in seconds").click()
    pictures.take("middle")
    print(
        f"from nothing to the table in {seconds:.1f} s, and {loading:.1f} s"
        " until the simulation was loaded"
    )
    assert seconds < 90
    assert time.monotonic() - begin < 300


def make_rooms(editor):
    # Some more floor, by the wheel, in the middle of the map.
    editor.page.mouse.move(*editor.pixels(0, 0))
    editor.page.mouse.wheel(0, 150)
    editor.settle()
    for i, (low, high) in enumerate(ROOMS):
        editor.tool("room")
        editor.drag(low, high)
        # They share a wall.
        editor.wait(lambda it, i=i: parts(it, "walls") == 4 * i + 4)
        editor.tool("door")
        editor.click(*DOORS[i])
        editor.wait(lambda it, i=i: parts(it, "walls") == 4 * i + 5)
    editor.tool("door")
    editor.click(*BETWEEN)
    editor.wait(lambda it: parts(it, "walls") == 10)
    editor.tool("wall")
    editor.click(-5.5, -1.8)
    editor.double_click(5.5, -1.8)
    editor.wait(lambda it: parts(it, "walls") == 11)
    editor.tool("furniture")
    editor.page.locator(".palette").get_by_text("desk", exact=True).click()
    for i, x in enumerate((-3, 3)):
        editor.click(x, 3.7)
        editor.wait(lambda it, i=i: parts(it, "furniture") == i + 1)


def parts(session, kind):
    return len(at(session.data, ["world", kind]) or [])


def make_people(editor):
    editor.tool("person")
    for i, (start, look, goals) in enumerate(PEOPLE):
        editor.drag(start, look)
        for goal in goals[:-1]:
            editor.click(*goal)
        editor.double_click(*goals[-1])
        editor.wait(
            lambda it, i=i, goals=goals: (
                len(at(it.data, ["humans", i, "goals"]) or "") == len(goals)
            )
        )
        person = editor.session.data["humans"][i]
        *place, yaw = person["pose"]
        assert near(place, start)
        wanted = math.atan2(look[1] - start[1], look[0] - start[0])
        assert math.cos(yaw - wanted) > 0.999
        for goal, wanted in zip(person["goals"], goals, strict=True):
            assert near(goal, wanted)


def choose_behaviors(editor):
    editor.tool("select")
    for i, name in BEHAVIORS.items():
        editor.click(*PEOPLE[i][0])
        editor.tab("behavior")
        editor.page.locator(f'[data-behavior="{name}"]').click()
        editor.wait_for(["humans", i, "behavior"], name)


def place_robot(editor):
    editor.tool("robot")
    editor.drag((-4.8, -0.2), (-4, -0.2))
    editor.wait(
        lambda it: near(at(it.data, ["robot", "start"]), (-4.8, -0.2, 0))
    )
    editor.tool("robot-goal")
    editor.drag((4.8, -1), (5.4, -1))
    goal = (4.8, -1, 0)
    editor.wait(lambda it: near(at(it.data, ["robot", "goal"]), goal))


def check_table(editor, saved):
    """Checks the table against the metrics of a run of the saved file."""
    from hunav_drake import LoadScenario, RunTrial
    from hunav_drake.editor.worker.statistics import value_text

    scenario = LoadScenario(filename=saved)
    assert len(scenario.humans) == 8
    result = RunTrial(scenario)
    # All goals are reached.
    assert result.end_reason == "goal"
    for person, states in zip(
        scenario.humans, result.recording.humans.swapaxes(0, 1), strict=True
    ):
        for goal in person.goals:
            away = [math.dist(goal, state[:2]) for state in states]
            # Between two samples, a person walks this far.
            step = person.desired_speed * scenario.evaluator.period
            assert min(away) <= person.goal_radius + step, person.name
    expected = result.metrics
    shown = editor.metrics()
    assert set(shown) == set(expected.index)
    for name, text in shown.items():
        assert text == value_text(name, float(expected[name])), name
