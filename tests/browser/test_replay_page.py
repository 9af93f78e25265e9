"""The page of a replay: its views, tags, timeline and links."""

import pytest

from hunav_drake.scenario import LoadScenario
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.trial.simulation import RunTrial
from hunav_drake.views.replay import SaveReplay, SetView, StartMeshcatLocal

TEXT = """
robots:
  - {name: r10, robot: {start: [-2, 0, 0], goal: [2, 0, 0]}}
  - {name: r9, robot: {start: [-2, 3, 0], goal: [2, 3, 0]}}
simulation: {duration: 1.0}
"""


def test_each_robot_can_be_followed(browser, tmp_path):
    scenario = LoadScenario(data=TEXT)
    meshcat = StartMeshcatLocal()
    SetView(meshcat, scenario.world, robot=robots_of(scenario))
    RunTrial(scenario, meshcat=meshcat)
    path = SaveReplay(meshcat, tmp_path / "replay.html")
    page = browser.new_page()
    page.goto(path.as_uri())
    views = page.locator("#hunav-views button")
    views.nth(3).wait_for(timeout=60_000)
    assert views.all_inner_texts() == [
        *("Overview", "From above"),
        *("Follow r9", "Follow r10"),
    ]
    for name, y in (("r9", 3.0), ("r10", 0.0)):
        page.get_by_text(f"Follow {name}", exact=True).click()
        # The page has y up, so y of the world is -z.
        z = page.evaluate("viewer.controls.target.z")
        assert -z == pytest.approx(y, abs=0.1)
    is_shown = "viewer.scene.getObjectByName('r9_goal').visible"
    for visible in (False, True):
        page.locator("#hunav-overlays label", has_text="goals").click()
        assert page.evaluate(is_shown) == visible
    page.close()


CORRIDOR = """
world:
  walls:
    - {type: box, center: [0, 2.6], size: [18, 0.2]}
    - {type: box, center: [0, -2.6], size: [18, 0.2]}
humans:
  - {name: ana, pose: [4, 0.2, 3.14], goals: [[-7, 0]]}
  - {name: bo, pose: [4.5, 0.5, 3.14], goals: [[-7, 0.6]]}
  - {name: far, pose: [-7, -1, 0], goals: [[-6, -1]]}
robot: {start: [-7, 0, 0], goal: [7, 0, 0]}
simulation: {duration: 8.0}
"""

# The pixels of a place in the world, from the corner of the window.
PIXELS = """
  (x, y, z) => {
    viewer.camera.updateMatrixWorld();
    const p = new MeshCat.THREE.Vector3(x, z, -y).project(viewer.camera);
    return [(p.x + 1) / 2 * innerWidth, (1 - p.y) / 2 * innerHeight];
  }
"""

# The boxes of visible tags, and the middles of heads, in pixels.
TAGS = """
  () => {
    const pixels = HERE, at = new MeshCat.THREE.Vector3(), found = [];
    viewer.scene.traverse((tag) => {
      if (tag.name !== "overlay_names") return;
      const drawn = tag.children.find((it) => it.visible);
      let mesh = null;
      if (drawn) drawn.traverse((it) => { if (it.geometry) mesh = it; });
      tag.updateWorldMatrix(true, true);
      const ends = [-1, 1].map((k) => {
        const box = mesh.geometry.boundingBox;
        at.set(k * box.max.x, k * box.max.y, 0).applyMatrix4(mesh.matrixWorld);
        return pixels(at.x, -at.z, at.y);
      });
      tag.parent.getWorldPosition(at);
      found.push({ shown: mesh.visible && mesh.material.opacity > 0,
        opacity: mesh.material.opacity, person: tag.parent.name === "base",
        box: [ends[0][0], ends[1][1], ends[1][0], ends[0][1]],
        head: pixels(at.x, -at.z, 1.6) });
    });
    return found;
  }
""".replace("HERE", PIXELS)


def write_replay(text, folder, **options):
    from hunav_drake.scenario.population import draw_people
    from hunav_drake.views.events import events_of

    scenario = LoadScenario(data=text)
    meshcat = StartMeshcatLocal()
    SetView(
        *(meshcat, scenario.world, draw_people(scenario)), robots_of(scenario)
    )
    recording = RunTrial(scenario, meshcat=meshcat).recording
    name = options.pop("name", "replay.html")
    return SaveReplay(meshcat, folder / name, events=events_of(recording))


@pytest.fixture(scope="module")
def corridor(tmp_path_factory):
    return write_replay(CORRIDOR, tmp_path_factory.mktemp("corridor"))


def opened(browser, path, link="", width=1280, height=800, scheme="light"):
    page = browser.new_page(
        viewport={"width": width, "height": height}, color_scheme=scheme
    )
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(path.as_uri() + link)
    page.locator("#hunav-overview").wait_for(timeout=60_000)
    page.wait_for_timeout(700)
    assert faults == []
    return page


def at_time(page, time):
    page.evaluate(
        f"viewer.animator.pause(); viewer.animator.seek({time});"
        "viewer.set_dirty(); viewer.render()"
    )


@pytest.mark.parametrize("size", [(1280, 800), (1920, 1080), (390, 844)])
def test_the_overview_fills_the_window_and_has_the_robot(
    browser, corridor, size
):
    width, height = size
    page = opened(browser, corridor, width=width, height=height)
    seen = []
    for time in (0.5, 4.0, 7.5):
        at_time(page, time)
        robot = "viewer.scene.getObjectByName('overlay_robot')"
        x, z = page.evaluate(
            f"(() => {{ const p = {robot}.position; return [p.x, p.y] }})()"
        )
        foot, head = (
            page.evaluate(f"({PIXELS})({x}, {z}, {it})") for it in (0, 1.7)
        )
        assert 0 < foot[0] < width
        panel = page.locator("#hunav").bounding_box()["y"]
        assert 0 < foot[1] < panel
        # So large is a person beside the robot (80 pixels before).
        assert foot[1] - head[1] > 90
        seen.append(foot[0])
    page.close()


def test_what_is_turned_by_hand_stays(browser, corridor):
    page = opened(browser, corridor)
    at_time(page, 1.0)
    page.mouse.move(700, 300)
    page.mouse.down()
    page.mouse.move(760, 330, steps=3)
    page.mouse.up()
    target = "viewer.controls.target.toArray()"
    before = page.evaluate(target)
    at_time(page, 6.0)
    assert page.evaluate(target) == before
    page.locator("#hunav-overview").click()
    assert page.evaluate(target) != before
    page.close()


def overlap(a, b, slack=1.0):
    return (
        a[0] < b[2] - slack
        and b[0] < a[2] - slack
        and a[1] < b[3] - slack
        and b[1] < a[3] - slack
    )


def test_tags_cover_neither_each_other_nor_heads(browser, corridor):
    page = opened(browser, corridor)
    for time in (0.5, 3.0, 4.5, 6.0):
        at_time(page, time)
        tags = [it for it in page.evaluate(TAGS) if it["shown"]]
        # The robot has one, too.
        assert any(not it["person"] for it in tags)
        assert sum(it["person"] for it in tags) >= 2
        for i, tag in enumerate(tags):
            for k, other in enumerate(tags):
                if i == k:
                    continue
                assert not overlap(tag["box"], other["box"])
                if other["person"]:
                    x, y = other["head"]
                    head = [x - 3, y - 3, x + 3, y + 3]
                    assert not overlap(tag["box"], head)
    page.close()


CROWD = """
population:
  cohorts:
    - name: guest
      number: 14
      start: [{rectangle: [-4, -3, 4, 3]}]
      goals: [{rectangle: [-4, -3, 4, 3]}]
robot: {start: [-6, 0, 0], goal: [6, 0, 0]}
simulation: {duration: 1.0}
"""


def test_in_a_crowd_only_who_is_pointed_at_has_a_tag(browser, tmp_path):
    page = opened(browser, write_replay(CROWD, tmp_path))
    at_time(page, 0.5)
    tags = page.evaluate(TAGS)
    assert sum(it["person"] for it in tags) == 14
    assert [it["person"] for it in tags if it["shown"]] == [False]
    inside = [it["head"] for it in tags if it["person"]]
    x, y = next(it for it in inside if 50 < it[0] < 1230 and 50 < it[1] < 600)
    page.mouse.move(x, y)
    page.wait_for_timeout(600)
    at_time(page, 0.5)
    tags = page.evaluate(TAGS)
    assert sum(it["shown"] for it in tags if it["person"]) == 1
    page.close()


def test_trails_are_lines_along_the_way(browser, corridor):
    page = opened(browser, corridor)
    at_time(page, 6.0)
    found = page.evaluate(
        """() => {
          const group = viewer.scene.getObjectByName("overlay_walked");
          return group.children.map((it) => {
            const at = it.geometry.attributes.position;
            const fades = it.material.vertexColors;
            return [at.getX(0), at.getX(at.count - 1), fades];
          });
        }"""
    )
    assert len(found) == 4
    *_, (now, before, faded) = found
    # The robot came from the left, at up to 0.6 m/s.
    assert 1.5 < now - before < 4.0
    assert faded
    page.close()


def test_no_mark_is_seen_that_marks_nothing(browser, corridor):
    """Dots that are not used lie in the floor, under its middle."""
    page = opened(browser, corridor)
    heights = page.evaluate(
        """() => {
          const found = [];
          for (const name of ["overlay_plan", "overlay_scan"]) {
            const group = viewer.scene.getObjectByName(name);
            if (group) group.traverse((it) => {
              if (/^\\d+$/.test(it.name)) found.push(it.position.z);
            });
          }
          return found;
        }"""
    )
    assert len(heights) == 24
    assert all(-0.06 < it < -0.01 for it in heights)
    page.close()


def test_events_are_jumped_to(browser, corridor):
    page = opened(browser, corridor)
    events = page.locator("#hunav-events button")
    titles = [
        events.nth(k).get_attribute("title") for k in range(events.count())
    ]
    assert any("personal space of ana entered" in it for it in titles)
    k = next(i for i, it in enumerate(titles) if "personal space" in it)
    events.nth(k).dispatch_event("click")
    time = float(titles[k].split(" s:")[0])
    now = page.evaluate("viewer.animator.actions[0].time")
    assert now == pytest.approx(time, abs=0.06)
    assert page.evaluate("viewer.animator.playing") is False
    page.close()


def test_a_link_leads_to_a_moment_and_a_view(browser, corridor):
    page = opened(browser, corridor, "#t=3.5&view=robot")
    time = "viewer.animator.actions[0].time"
    assert page.evaluate(time) == pytest.approx(3.5)
    assert "on" in page.locator("#hunav-follow").get_attribute("class")
    page.locator("#hunav-link").click()
    assert page.url.endswith("#t=3.5&view=robot")
    for link, rule in (
        ("#t=99", "must be a time in [0, "),
        ("#t=abc&view=top", "#t=abc: t must be a time"),
        ("#view=roof", "view must be one of overview, top, robot"),
        ("#u=3", "may have t, view and with"),
    ):
        page.goto(corridor.as_uri() + link)
        told = page.locator("#hunav-told")
        told.wait_for()
        assert rule in told.inner_text()
        assert "as in #t=12.3&view=robot" in told.inner_text()
    page.goto(corridor.as_uri() + "#t=2&view=top")
    page.wait_for_timeout(300)
    assert not page.locator("#hunav-told").is_visible()
    page.close()


def test_two_runs_play_side_by_side_in_step(browser, corridor):
    longer = CORRIDOR.replace("8.0", "9.0").replace("-7, 0, 0]", "-7.5, 0, 0]")
    write_replay(longer, corridor.parent, name="other.html")
    page = opened(browser, corridor, "#t=2.5&with=other.html&view=top")
    frame = page.frame_locator("#hunav-beside")
    frame.locator("#hunav-clock").wait_for(timeout=60_000)
    inner = page.frames[-1]
    time = "viewer.animator.actions[0].time"
    inner.wait_for_function(f"{time} > 2.4", timeout=60_000)
    assert inner.evaluate(time) == pytest.approx(2.5, abs=0.02)
    # The longer one plays to its end.
    assert page.evaluate("+document.getElementById('hunav-time').max") > 8.5
    for now in (5.0, 8.6):
        at_time(page, now)
        inner.wait_for_function(f"Math.abs({time} - {now}) < 0.05")
    # Each has its half, and only one has controls.
    width = page.locator("#hunav-beside").bounding_box()["width"]
    assert width == pytest.approx(640, abs=4)
    assert page.evaluate("viewer.dom_element.offsetWidth") == 640
    assert not inner.locator("#hunav").is_visible()
    page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_panel_can_be_read(browser, corridor, scheme):
    page = opened(browser, corridor, width=390, height=844, scheme=scheme)
    light = page.evaluate(
        """() => ["color", "backgroundColor"].map((it) => {
          const style = getComputedStyle(document.getElementById("hunav"));
          const [r, g, b] = style[it].match(/[\\d.]+/g).map(Number);
          return (r + g + b) / 3;
        })"""
    )
    assert abs(light[0] - light[1]) > 150
    box = page.locator("#hunav").bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 390
    page.close()
