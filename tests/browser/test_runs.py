"""What the page has of the worker: faults, trees, metrics and runs."""

import math
import os
import re
import signal
import time

import pytest

from tests.browser.driver import SMALL, SharedWorker, at

# The processes are loaded, perhaps on a machine that has much else to do.
PATIENCE = 300
PLANNER = "planner: pursuit\nsimulation: {duration: 15.0}\n"
QUICK = f"{SMALL}{PLANNER}"
LONG = f"{SMALL}planner: pursuit\nsimulation: {{duration: 900.0}}\n".replace(
    "goal: [3, -2, 0]", "goal: [400, -2, 0]"
)


@pytest.fixture
def open_with_worker(open_editor, worker):
    def start(text=None):
        shared = SharedWorker(worker)
        editor = open_editor(text, worker=shared, find_file=worker.file)
        editor.page.wait_for_selector(
            ".chip >> nth=3", state="attached", timeout=1000 * PATIENCE
        )
        return editor

    return start


def _wait_text(editor, selector, text):
    editor.page.wait_for_selector(
        f'{selector}:has-text("{text}")', timeout=1000 * PATIENCE
    )


def _run(editor, seeds="", planners=(), speed=""):
    """Presses Run; the table of an earlier test's runs is gone then."""
    editor.tab("runs")
    editor.page.get_by_label("Seeds").fill(seeds)
    for name in planners:
        editor.page.locator(".chip", has_text=name).first.click()
    editor.page.get_by_label("Speed", exact=True).select_option(speed)
    editor.page.locator(".run-side .primary").click()
    editor.page.get_by_role("button", name="Stop the runs").wait_for()


def _result(editor, count=1):
    """Waits for results in the table."""
    editor.page.wait_for_selector(
        f".run-table .run-head >> nth={count - 1}", timeout=1000 * PATIENCE
    )


def test_the_choice_of_a_speed_is_readable(open_editor):
    editor = open_editor(SMALL, view={"width": 1280, "height": 800})
    editor.tab("runs")
    # The room of its words without padding and the arrow.
    room = editor.page.get_by_label("Speed", exact=True).evaluate(
        """(it) => {
          const style = getComputedStyle(it);
          const pen = document.createElement("canvas").getContext("2d");
          pen.font = style.font;
          return it.clientWidth - parseFloat(style.paddingLeft)
            - parseFloat(style.paddingRight) - 16
            - pen.measureText(it.selectedOptions[0].text).width;
        }"""
    )
    assert room >= 0


def test_an_unknown_behavior_is_a_fault_of_the_worker(open_with_worker):
    editor = open_with_worker(
        QUICK.replace("behavior: regular", "behavior: curios")
    )
    _wait_text(editor, ".faults", "1 problem")
    fault = editor.wait(lambda it: it.faults, PATIENCE)[0]
    assert fault["path"] == ["humans", 0, "behavior"]
    assert "curious" in f"{fault['message']} {fault['remedy']}"
    editor.expect(editor.part("humans/0")).to_contain_class("faulty")
    # Chosen from the list, it is well again.
    editor.click(-3, 0)
    editor.tab("behavior")
    editor.page.locator('[data-behavior="curious"]').click()
    editor.wait_for(["humans", 0, "behavior"], "curious")
    _wait_text(editor, ".faults", "No problems")


def test_ports_of_a_behavior_are_set_and_reset(open_with_worker):
    editor = open_with_worker(QUICK)
    editor.click(-3, 0)
    editor.tab("behavior")
    editor.page.locator('[data-behavior="curious"]').click()
    editor.wait_for(["humans", 0, "behavior"], "curious")
    port = editor.page.locator('.ports [data-field="distance"]')
    editor.expect(port.locator("input")).to_have_attribute("placeholder", "10")
    editor.expect(port.locator(".unit")).to_have_text("m")
    port.locator("input").fill("6.5")
    editor.wait_for(
        ["humans", 0, "behavior"], {"type": "curious", "distance": 6.5}
    )
    editor.wait(lambda it: "distance: 6.5" in it.text)
    port.locator("input").press("Tab")
    port.locator(".reset").click()
    editor.wait_for(["humans", 0, "behavior"], "curious")
    picture = editor.page.locator(".tree-picture img")
    editor.wait(lambda _: picture.evaluate("it => it.naturalWidth") > 100)
    picture.click()
    editor.page.locator("dialog[open] img").wait_for()


def test_a_port_that_is_too_large_is_a_fault_at_its_field(open_with_worker):
    editor = open_with_worker(QUICK.replace("regular", "curious"))
    editor.click(-3, 0)
    editor.tab("behavior")
    port = editor.page.locator('.ports [data-field="speed"]')
    port.locator("input").fill("99")
    _wait_text(editor, '.ports [data-field="speed"] .field-fault', "10")


def test_all_people_by_all_behaviors(open_with_worker):
    editor = open_with_worker(QUICK)
    editor.tab("behavior")
    editor.page.get_by_label("bruno: scared").check()
    editor.wait_for(["humans", 1, "behavior"], "scared")
    editor.page.get_by_label("All: curious").click()
    editor.wait(
        lambda it: (
            [at(it.data, ["humans", i, "behavior"]) for i in (0, 1)]
            == ["curious", "curious"]
        )
    )
    # That was one step.
    editor.page.locator(".step").first.click()
    editor.wait_for(["humans", 1, "behavior"], "scared")


def test_the_shortest_list_of_metrics_is_written(open_with_worker):
    editor = open_with_worker(QUICK)
    editor.tab("metrics")
    path = ["evaluator", "metrics"]
    choose = editor.page.locator

    def is_written(words):
        editor.wait(lambda it: sorted(at(it.data, path) or []) == sorted(words))

    choose('[data-choice="all"]').click()
    is_written([])
    choose('[data-choice="path"]').click()
    is_written(["path"])
    choose('[data-choice="paper"]').click()
    words = at(editor.session.data, path)
    editor.wait(lambda it: "paper" in at(it.data, path))
    words = at(editor.session.data, path)
    assert len(words) <= 3
    choose('[data-choice="all"]').click()
    is_written(["all"])
    choose('[data-family="goal"]').click()
    choose('[data-choice="completed"]').click()
    editor.wait(lambda it: at(it.data, path) != ["all"])
    words = at(editor.session.data, path)
    from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics

    chosen = {it.name for it in select_metrics(words)}
    assert chosen == set(METRICS) - {"completed"}
    assert len(words) < 20
    choose('[data-metric="completed"]').click()
    editor.page.locator(".definition").first.wait_for()


def test_a_run_moves_on_the_map_and_gives_the_table(open_with_worker):
    from hunav_drake import LoadScenario, RunTrial

    editor = open_with_worker(QUICK)
    _run(editor, seeds="3", speed="10")
    ghost = editor.page.locator(".ghost-body").last
    ghost.wait_for(timeout=1000 * PATIENCE)
    before = ghost.get_attribute("transform")
    editor.wait(lambda _: ghost.get_attribute("transform") != before)
    _result(editor)
    expected = RunTrial(LoadScenario(data=QUICK), 3).metrics
    shown = editor.metrics()
    assert set(shown) == set(expected.index)
    for name, text in shown.items():
        value = expected[name]
        if math.isfinite(value):
            assert float(text) == pytest.approx(value, rel=6e-3, abs=6e-3)
        else:
            assert not any(it.isdigit() for it in text)
    # The whole way, and the bodies at a time.
    slider = editor.page.get_by_label("Time of the run in seconds")
    slider.fill("0")
    start = re.compile(r"^translate\(-2 -2\)")
    editor.expect(ghost).to_have_attribute("transform", start)
    _wait_text(editor, ".run-links", "Replay")
    command = editor.page.locator(".run-command")
    editor.expect(command).to_contain_text("--seed 3")
    # The links show whole pages, without the cookie of the editor.
    for name, words in (("Report", "path"), ("Replay", "")):
        with editor.context.expect_page() as opened:
            editor.page.locator(".run-links a", has_text=name).click()
        page = opened.value
        page.wait_for_load_state()
        assert words in page.content()
        assert page.evaluate("window.origin") == "null"
        page.close()
    # GPU messages of the replay are no faults of the editor.
    editor.complaints.clear()


def test_keys_alone_lead_from_a_template_to_the_table(open_with_worker):
    editor = open_with_worker()
    editor.tab_to('[data-template="corridor"]')
    editor.press("Enter")
    editor.wait(lambda it: len(it.data.get("humans", [])) == 2)
    editor.tab_to(".map")
    editor.press("Tab", "Delete")
    editor.wait(lambda it: len(it.data["humans"]) == 1)
    assert editor.session.faults == []
    editor.press("Control+Enter")
    # The table of an earlier test's runs is gone then.
    editor.page.get_by_role("button", name="Stop the runs").wait_for()
    _result(editor)
    # Tab leads through the map and out of it, forth and back.
    editor.tab_to(".run-head")
    editor.tab_to(".tool-bar button", back=True)
    editor.tab_to(".run-table-box")
    rows = editor.page.locator(".run-table [data-metric]")
    editor.wait(lambda _: rows.count() > 50)


def test_results_are_outdated_after_an_edit(open_with_worker):
    editor = open_with_worker(QUICK)
    _run(editor)
    _result(editor)
    outdated = editor.page.locator(".outdated")
    editor.expect(outdated).to_be_hidden()
    editor.click(-3, 2)
    editor.press("ArrowRight")
    editor.wait_for(["humans", 1, "pose"], [-2.95, 2.0, 0])
    outdated.wait_for()
    # Who edits looks at the scenario again.
    editor.page.locator(".ghost-body").first.wait_for(state="detached")


def test_an_edit_during_a_run_takes_it_from_the_map(open_with_worker):
    editor = open_with_worker(QUICK)
    _run(editor, speed="5")
    ghosts = editor.page.locator(".ghost-body")
    ghosts.last.wait_for(timeout=1000 * PATIENCE)
    editor.click(-3, 2)
    editor.press("ArrowRight")
    editor.wait_for(["humans", 1, "pose"], [-2.95, 2.0, 0])
    ghosts.first.wait_for(state="detached")
    editor.page.locator(".outdated").wait_for(timeout=1000 * PATIENCE)
    editor.expect(ghosts).to_have_count(0)
    # It can be looked at nevertheless.
    editor.page.get_by_label("on the map").check()
    ghosts.first.wait_for(state="attached")


def test_a_run_is_stopped_and_another_one_done(open_with_worker, worker):
    editor = open_with_worker(LONG)
    _run(editor, seeds="0-2", speed="1")
    editor.page.locator(".ghost-body").last.wait_for(timeout=1000 * PATIENCE)
    # They would go on for 900 s each.
    begin = time.monotonic()
    editor.page.get_by_role("button", name="Stop the runs").click()
    editor.page.locator(".run-side .primary").wait_for()
    print(f"stopped after {time.monotonic() - begin:.2f} s")
    cancelled = editor.page.locator(".run-end.is-cancelled")
    editor.expect(cancelled).to_have_count(3)
    # A process that dies is replaced.
    editor.page.get_by_label("Seeds").fill("7")
    editor.page.locator(".run-side .primary").click()
    editor.page.locator(".run-going").wait_for(timeout=1000 * PATIENCE)
    os.kill(worker._first.pid, signal.SIGKILL)
    editor.page.locator(".run-end.is-failed").wait_for()
    editor.page.get_by_label("Speed", exact=True).select_option("")
    editor.session.receive(
        {
            "do": "text",
            "id": "test",
            "base": editor.session.state.revision,
            "text": QUICK,
        }
    )
    editor.page.locator(".run-side .primary").click()
    editor.page.wait_for_selector(
        ".run-table [data-metric]", timeout=1000 * PATIENCE
    )


def test_seeds_and_planners_stand_side_by_side(open_with_worker):
    # (So that seeds draw something.)
    jitter = "{start_jitter: 0.05, duration"
    editor = open_with_worker(QUICK.replace("{duration", jitter))
    _run(editor, seeds="0, 1", planners=("pursuit", "sfm"))
    _result(editor, 4)
    _wait_text(editor, ".run-state", "4 runs are done")
    heads = editor.page.locator(".run-head .run-planner").all_inner_texts()
    assert heads == ["pursuit", "pursuit", "sfm", "sfm"]
    _wait_text(editor, '[data-metric="path_length"] td.mean', "\u2013")
    means = editor.page.locator('[data-metric="path_length"] td.mean')
    editor.expect(means).to_have_count(2)
    values = editor.page.locator(
        '[data-metric="path_length"] td:not(.mean)'
    ).all_inner_texts()
    mean = float(means.first.inner_text().split()[0])
    assert mean == pytest.approx(
        (float(values[0]) + float(values[1])) / 2, abs=0.01
    )


def test_the_planner_of_the_scenario_is_marked_and_told_without_option(
    open_with_worker,
):
    slow = "planner: {type: pursuit, cruise_speed: 0.4}"
    text = QUICK.replace("planner: pursuit", slow).replace("15.0", "1.0")
    editor = open_with_worker(text)
    editor.tab("runs")
    marked = editor.page.locator(".chip", has_text="(scenario)")
    editor.expect(marked).to_have_text("pursuit (scenario)")
    _run(editor, planners=("pursuit", "sfm"))
    _result(editor, 2)
    _wait_text(editor, ".run-state", "2 runs are done")
    command = editor.page.locator(".run-command")
    for planner, option in (("pursuit", ""), ("sfm", " --planner sfm")):
        editor.page.locator(".run-head", has_text=planner).click()
        editor.expect(command).to_have_text(
            re.compile(rf"^hunav run \S+/scene\.yaml{option}$")
        )


def test_seeds_that_cannot_be_read_are_told(open_with_worker):
    editor = open_with_worker(QUICK)
    editor.tab("runs")
    seeds = editor.page.get_by_label("Seeds")
    seeds.fill("1; 2")
    editor.page.locator(".run-side .primary").click()
    editor.wait(lambda _: seeds.get_attribute("aria-invalid") == "true")


STUCK = """\
world:
  walls: [{type: box, name: bar, center: [2, 0], size: [0.2, 30]}]
humans:
  - {name: ana, pose: [1, 1.6, 3], goals: [[-4, 1.6]], behavior: surprised}
robot: {start: [-2, 0, 0], goal: [4, 0, 0]}
planner: pursuit
simulation: {duration: 30.0, stuck_time: 3.0, start_jitter: 0.2}
"""


def test_a_run_tells_where_it_got_stuck_and_what_happened(open_with_worker):
    editor = open_with_worker(STUCK)
    _run(editor, "0-2")
    _result(editor, 3)
    # Why, and where: before the wall.
    reason = editor.page.locator(".run-reason")
    editor.expect(reason).to_contain_text(re.compile(r"stuck at \(1\.\d\d, "))
    editor.expect(reason).to_contain_text("no longer gets anywhere")
    mark = editor.page.locator(".ghost-ends:not(.overlaid) .end-mark")
    editor.expect(mark).to_have_count(1)
    box = mark.locator("path").bounding_box()
    x, _ = editor.world(box["x"] + box["width"] / 2, box["y"])
    assert 1 < x < 2
    # The time line has the reaction and the end; buttons go to them.
    events = editor.page.locator(".mark-of")
    kinds = events.evaluate_all("all => all.map(it => it.className)")
    assert {"mark-of is-reaction", "mark-of is-end"} <= set(kinds)
    note = editor.page.locator(".event-note")
    slider = editor.page.get_by_label("Time of the run in seconds")
    slider.focus()
    editor.press("Home")
    editor.page.locator(".event-after").click()
    editor.expect(note).to_contain_text("ana (surprised) reacts to the robot")
    slider.focus()
    editor.press("End")
    editor.expect(note).to_contain_text("the robot is stuck")
    # The other seeds are laid over it, in their colors.
    lines = editor.page.locator(".overlaid .ghost-way.of-robot")
    boxes = editor.page.locator(".run-over input")
    editor.expect(boxes).to_have_count(2)
    boxes.first.check()
    boxes.last.check()
    editor.expect(lines).to_have_count(2)
    colors = lines.evaluate_all(
        "all => all.map(it => getComputedStyle(it).stroke)"
    )
    assert len(set(colors)) == 2
    # Choosing one of them takes it out of those above.
    editor.page.locator(".run-head").nth(1).click()
    editor.expect(lines).to_have_count(1)
    boxes.first.check()
    editor.expect(lines).to_have_count(2)
    editor.page.get_by_label("on the map").uncheck()
    editor.expect(editor.page.locator(".ghost-way")).to_have_count(0)
    editor.page.get_by_label("on the map").check()
    editor.expect(lines).to_have_count(2)
