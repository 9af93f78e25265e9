"""How the pages of reports on trials are laid out."""

import re

import numpy as np
import pytest

from hunav_drake.report.plots.style import (
    PALETTE,
    PEOPLE,
    ROBOT,
    behavior_styles,
)
from hunav_drake.report.writing import WriteReport
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.runs.statistics import summarize
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.scene.plan_walls import WALL
from hunav_drake.trial.metric_facts import bounds_of
from tests.hunav_drake.passing_trials import (
    make_recording,
    make_result,
    make_results,
)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    run = make_recording(behaviors=("regular", "threatening"))
    batch = make_results(planners=("pursuit", "dwb", "sfw"), gain=0.1)
    return {
        "trial": WriteReport(make_result(run), folder / "trial.html"),
        "batch": WriteReport(batch, folder / "batch.html"),
    }


def rgb(color):
    return np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)])


def test_each_behavior_has_a_color_of_its_own():
    styles = behavior_styles(BEHAVIORS)
    colors = [style["color"] for style in styles.values()]
    assert list(styles) == list(BEHAVIORS)
    for i, color in enumerate(colors):
        for other in (*colors[:i], ROBOT, WALL, PEOPLE):
            assert np.linalg.norm(rgb(color) - rgb(other)) > 60


def test_a_behavior_keeps_its_color_among_others():
    few = behavior_styles(["my_own", "threatening"])
    assert few["threatening"] == behavior_styles(BEHAVIORS)["threatening"]
    assert few["my_own"]["color"] != few["threatening"]["color"]
    many = behavior_styles([*BEHAVIORS, *map(str, range(2 * len(PALETTE)))])
    looks = [tuple(style.items()) for style in many.values()]
    assert len(set(looks)) == len(looks)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["trial", "batch"])
def test_what_matters_comes_first_and_the_rest_is_listed(pages, kind):
    html = pages[kind].read_text()
    assert re.findall(r"<h2[^>]*>(.*?)</h2>", html)[0] == "Headline"
    first = html[html.index("<table") : html.index("</table>")]
    assert "min_<wbr>dist_" in first or "min dist to people" in first
    assert 'title="' in first
    nav = html[html.index("<nav") : html.index("</nav>")]
    linked = re.findall(r'href="#([^"]*)"', nav)
    sections = re.findall(r'<h2 id="([^"]*)"', html)
    assert len(sections) == html.count("<h2")
    assert [name for name in linked if name in sections] == sections


def test_intervals_end_where_values_do():
    runs = tabulate_runs(
        [
            make_result(make_recording(speed=speed), seed=i)
            for i, speed in enumerate((0.2, 1.0, 1.4))
        ]
    )
    runs["social_work"] = [0.0, 0.0, 3.0]
    names = ["social_work"]
    free = summarize(runs, metrics=names).iloc[0]
    bounded = summarize(runs, metrics=names, bounded=True).iloc[0]
    assert free["low"] < 0 == bounded["low"]
    assert free["high"] == bounded["high"]
    assert bounds_of("avg_robot_linear_speed")[0] < 0
    # (Negative where discs overlap.)
    assert bounds_of("min_dist_between_robots") == (-np.inf, np.inf)
    assert bounds_of("space_compliance") == (0, 100)
    assert bounds_of("reactive_share") == (0, 1)
    assert bounds_of("of_somebody") == (-np.inf, np.inf)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["trial", "batch"])
@pytest.mark.parametrize("width", [1440, 390])
def test_the_page_is_no_wider_than_the_window(pages, kind, width, browser):
    window = browser.new_page(viewport={"width": width, "height": 900})
    window.goto(pages[kind].as_uri())
    # In print what is folded is seen.
    folded = (
        "[...document.querySelectorAll('details table')].filter(t =>"
        " t.checkVisibility({contentVisibilityAuto: true})).length"
    )
    assert window.evaluate(folded) == 0
    window.emulate_media(media="print")
    count = window.locator("details table").count()
    assert window.evaluate(folded) == count > 0
    # On paper of A4, within its margins, nothing is cut off.
    window.set_viewport_size({"width": 688, "height": 1000})
    assert window.evaluate("document.documentElement.scrollWidth") <= 688
    window.set_viewport_size({"width": width, "height": 900})
    window.emulate_media(media="screen")
    for summary in window.locator("summary").all():
        summary.click()
    seen = window.evaluate("document.documentElement.scrollWidth")
    assert seen <= width
    window.close()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["trial", "batch"])
def test_axe_finds_nothing_against_accessibility(pages, kind, browser):
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe-core is not here"
    ).Axe()
    window = browser.new_page(viewport={"width": 390, "height": 900})
    window.goto(pages[kind].as_uri())
    for summary in window.locator("summary").all():
        summary.click()
    found = axe.run(window, options={"resultTypes": ["violations"]})
    assert found.violations_count == 0, found.generate_report()
    window.close()
