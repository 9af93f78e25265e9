"""The editor as a whole: by keys alone, for everybody, and how fast."""

import pytest

from tests.browser.driver import SMALL, at, near

PEOPLE, WALLS = 100, 500


def big_text():
    """Returns a scenario of 100 people with 300 goals and 500 walls."""
    walls = "\n".join(
        f"    - {{type: box, center: [{3 * (i % 25)}, {3 * (i // 25)}],"
        " size: [1.2, 0.2]}"
        for i in range(WALLS)
    )
    people = "\n".join(
        f"  - name: p{i}\n    pose: [{7 * (i % 10) + 1.5},"
        f" {6 * (i // 10) + 1.5}, 0]\n    goals: [[{7 * (i % 10) + 1.5},"
        f" {6 * (i // 10) + 4.5}], [{7 * (i % 10) + 4.5},"
        f" {6 * (i // 10) + 4.5}], [{7 * (i % 10) + 4.5},"
        f" {6 * (i // 10) + 1.5}]]"
        for i in range(PEOPLE)
    )
    return f"world:\n  walls:\n{walls}\nhumans:\n{people}\n"


FRAMES = """(milliseconds) => new Promise((done) => {
  let frames = 0;
  const start = performance.now();
  const next = () => {
    frames += 1;
    if (performance.now() - start < milliseconds) requestAnimationFrame(next);
    else done(frames / (performance.now() - start) * 1000);
  };
  requestAnimationFrame(next);
})"""

DRAG = """([key, milliseconds]) => new Promise((done) => {
  const map = document.querySelector(".map");
  const disc = document.querySelector(`[data-key="${key}"] .disc`);
  const box = disc.getBoundingClientRect();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const send = (kind, dx, dy) => {
    const options = {bubbles: true, pointerId: 1, button: 0, buttons: 1,
      clientX: x + dx, clientY: y + dy};
    (kind === "pointerdown" ? disc : map)
      .dispatchEvent(new PointerEvent(kind, options));
  };
  map.setPointerCapture = () => {};
  send("pointerdown", 0, 0);
  let frames = 0;
  const start = performance.now();
  const next = () => {
    frames += 1;
    const t = performance.now() - start;
    send("pointermove", 60 * Math.sin(t / 150), 60 * Math.cos(t / 210));
    if (t < milliseconds) return requestAnimationFrame(next);
    send("pointerup", 0, 3);
    done(frames / t * 1000);
  };
  requestAnimationFrame(next);
})"""


def test_a_hundred_people_are_dragged_as_smoothly_as_frames_come(open_editor):
    editor = open_editor(big_text(), view={"width": 1920, "height": 1080})
    page = editor.page
    editor.expect(page.locator(".map .person")).to_have_count(PEOPLE)
    editor.expect(page.locator(".map .goal")).to_have_count(3 * PEOPLE)
    editor.expect(page.locator(".map .fixture")).to_have_count(WALLS)
    page.wait_for_timeout(500)
    ratios = []
    for _ in range(3):
        bare = page.evaluate(FRAMES, 800)
        dragged = page.evaluate(DRAG, ["humans/55", 1500])
        ratios.append(dragged / bare)
        print(f"drag {dragged:.0f} frames/s, bare loop {bare:.0f}")
    # 30 of the 60 frames a second of an idle machine. Other work on it may
    # take the processor during one loop and not during the other, in either
    # direction; of several pairs the best one tells what the page can do.
    assert max(ratios) >= 0.5
    heap = page.evaluate("performance.memory.usedJSHeapSize")
    print(f"{heap / 1e6:.0f} MB of JavaScript's heap")
    assert heap < 50e6


def test_a_scenario_is_made_by_keys_alone(open_editor):
    editor = open_editor(None)
    editor.page.locator("dialog[open]").wait_for()
    # The first card is an empty floor; the next ones are templates.
    editor.tab_to(".card")
    editor.press("Enter")
    editor.tab_to(".map")
    editor.press("p", "Enter")
    editor.wait(lambda it: len(it.data.get("humans", [])) == 1)
    editor.press("Escape", "Escape", "Shift+G")
    editor.wait(lambda it: len(at(it.data, ["humans", 0, "goals"]) or []) == 1)
    editor.press("]", "Shift+ArrowRight")
    editor.wait(lambda it: abs(at(it.data, ["humans", 0, "pose", 2])) > 0.2)
    editor.wait(lambda it: abs(at(it.data, ["humans", 0, "pose", 0])) > 0.4)
    pose = at(editor.session.data, ["humans", 0, "pose"])
    editor.press("w")
    editor.press("Shift+ArrowUp", "Space", "Shift+ArrowRight", "Space", "Enter")
    editor.wait(lambda it: (it.data.get("world") or {}).get("walls"))
    (wall,) = editor.session.data["world"]["walls"]
    (x0, y0), (x1, y1) = wall["points"]
    assert near((x1 - x0, y1 - y0), (1, 0), 1e-6)
    editor.press("Escape", "r", "Shift+ArrowDown", "Shift+ArrowDown", "Enter")
    editor.wait(lambda it: at(it.data, ["robot", "start"]))
    editor.press("f")
    editor.page.keyboard.type("plant")
    editor.press("Enter")
    editor.wait(lambda it: it.data["world"].get("furniture"))
    assert editor.session.data["world"]["furniture"][0]["type"] == "plant"
    # Tab goes through the parts in the order of the outline.
    editor.press("Escape", "Escape")
    editor.focus_map()
    editor.press("Tab", "Delete")
    editor.wait(lambda it: not it.data["humans"])
    editor.press("Control+z")
    editor.wait(lambda it: near(at(it.data, ["humans", 0, "pose"]), pose, 1e-6))


CHECK = """() => {
  const faults = [];
  const named = (it) => (it.getAttribute("aria-label") || it.title
    || it.textContent.trim() || it.labels?.[0]?.textContent || "").trim();
  for (const it of document.querySelectorAll(
      "button, input, select, textarea, [role=tab], [data-key]")) {
    if (it.closest("[hidden]") || it.tagName === "path") continue;
    if (!named(it)) faults.push(`no name: ${it.outerHTML.slice(0, 90)}`);
  }
  const ids = [...document.querySelectorAll("[id]")].map((it) => it.id);
  if (new Set(ids).size !== ids.length) faults.push("an id is there twice");
  for (const it of document.querySelectorAll("[aria-describedby]")) {
    for (const id of it.getAttribute("aria-describedby").split(" ")) {
      if (!document.getElementById(id)) faults.push(`no element ${id}`);
    }
  }
  const pixel = document.createElement("canvas").getContext("2d",
    {willReadFrequently: true});
  const rgb = (color) => {
    pixel.clearRect(0, 0, 1, 1);
    pixel.fillStyle = color;
    pixel.fillRect(0, 0, 1, 1);
    return [...pixel.getImageData(0, 0, 1, 1).data];
  };
  const light = ([r, g, b]) => [r, g, b].map((it) => it / 255)
    .map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const floor = (it) => {
    for (; it; it = it.parentElement) {
      const color = rgb(getComputedStyle(it).backgroundColor);
      if (color[3] > 250) return color;
    }
    return [255, 255, 255];
  };
  const walker = document.createTreeWalker(document.body, 4);
  while (walker.nextNode()) {
    const it = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || it.closest("svg, :disabled, title"))
      continue;
    if (!it.checkVisibility() || it.tagName === "OPTION") continue;
    const [a, b] = [light(rgb(getComputedStyle(it).color)), light(floor(it))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) faults.push(
      `contrast ${contrast.toFixed(2)}: ${it.className} "${it.textContent}"`);
    const button = it.closest("button");
    const box = button?.getBoundingClientRect();
    if (box?.width && (box.width < 24 || box.height < 24)) faults.push(
      `small: ${button.className} ${box.width} x ${box.height}`);
  }
  return [...new Set(faults)];
}"""


def test_everything_has_a_name_and_can_be_read(open_editor):
    for scheme in ("light", "dark"):
        editor = open_editor(SMALL, view={"color_scheme": scheme})
        editor.drag((-3, 0), (3, 1.5))
        editor.wait(lambda it: it.faults)
        for tab in ("properties", "behavior", "metrics", "trial"):
            editor.tab(tab)
            assert editor.page.evaluate(CHECK) == []
        for tab in ("problems", "yaml", "runs"):
            editor.tab(tab)
            assert editor.page.evaluate(CHECK) == []


def test_axe_finds_nothing_against_accessibility(open_editor):
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe-core is not here"
    ).Axe()

    def check(editor):
        found = axe.run(editor.page, options={"resultTypes": ["violations"]})
        assert found.violations_count == 0, found.generate_report()

    for scheme in ("light", "dark"):
        editor = open_editor(SMALL, view={"color_scheme": scheme})
        editor.drag((-3, 0), (3, 1.5))
        editor.page.locator("[data-key='humans/0'].faulty").wait_for()
        editor.tool("furniture")
        for right, below in (
            ("properties", "problems"),
            ("behavior", "yaml"),
            ("trial", "runs"),
        ):
            editor.tab(right)
            editor.tab(below)
            check(editor)
        editor.focus_map()
        editor.press("?")
        check(editor)


def test_parts_say_what_they_are(open_editor):
    editor = open_editor(SMALL)
    person = editor.part("humans/0")
    editor.expect(person).to_have_attribute(
        "aria-label", "alba, regular, 2 goals"
    )
    goal = editor.part("humans/0/goals/1")
    editor.expect(goal).to_have_attribute("aria-label", "alba, goal 2 of 2")


def test_below_1100_pixels_the_outline_is_a_tab(open_editor):
    editor = open_editor(SMALL, view={"width": 1000, "height": 760})
    editor.tab("outline")
    editor.page.locator(".outline .row-item").first.click()
    editor.page.locator("[data-key='humans/0'].selected").wait_for()
    editor.page.set_viewport_size({"width": 1400, "height": 760})
    editor.page.locator(".left .outline").wait_for()
