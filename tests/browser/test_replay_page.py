"""The page of a replay: its views of several robots."""

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
