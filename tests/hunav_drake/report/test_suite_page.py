import dataclasses
import re
import shutil

import pandas as pd
import pytest

from hunav_drake.commands import cli
from hunav_drake.report.runs_tables import responsibility_table
from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs import LoadSuite, RunSuite, Suite
from hunav_drake.runs.comparison.relations import judge
from hunav_drake.runs.run_row import RunRow
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.views.suite_replays import WriteReplays
from tests.hunav_drake.report.pages import visible
from tests.hunav_drake.runs.made_runs import (
    make_cell,
    make_result,
    make_row,
    runs_of,
)

# (As long as labels may be.)
LONG = ("a_contender_of_a_rather_long_name_" * 2)[:64]
SUITE = f"""
name: small
scenarios: [crossing, combined]
planners: [pursuit, {{type: pursuit, cruise_speed: 0.4, label: {LONG}}}]
overrides: [simulation.duration=1.0]
seeds: 2
relations:
  - {{number: 3, scenarios: [crossing], metric: completed,
     holds: {LONG} <= pursuit, strength: strong}}
  - {{number: 4, scenarios: [crossing], metric: completed,
     holds: pursuit * 1.0 <= 0.5 * {LONG} - 1}}
  - {{number: 5, scenarios: [crossing], metric: path_length, holds: dwb > 1}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("suite")


@pytest.fixture(scope="module")
def result(folder):
    return RunSuite(LoadSuite(data=SUITE), workers=1, out=folder)


@pytest.fixture(scope="module")
def page(result, folder):
    WriteReplays(result, folder, workers=1)
    return WriteSuite(result, folder)


@pytest.mark.slow
def test_contents_lead_to_each_section(page):
    html = page.read_text()
    ids = re.findall(r'<h[23] id="([^"]+)"', html)
    assert len(set(ids)) == len(ids)
    nav = html[html.index("<nav") : html.index("</nav>")]
    parts = ("means", "pairs", "bars", "examples")
    assert re.findall(r'href="#([^"]+)"', nav) == [
        *("headline", "outcomes", "relations"),
        *("s0", *(f"s0-{it}" for it in parts)),
        *("s1", *(f"s1-{it}" for it in parts)),
        *("runs", "cost", "provenance"),
    ]
    assert "Means with curious people only" in html
    assert set(re.findall(r'href="#([^"]+)"', nav)) == set(ids)


def test_verdicts_are_told_by_word_and_color(page):
    html = page.read_text()
    verdicts = re.findall(
        r'<span class="(\w+)">(holds|fails|not tested)</span>', html
    )
    assert verdicts == [
        ("passes", "holds"),
        ("fails", "fails"),
        ("inapplicable", "not tested"),
    ]
    text = visible(html)
    assert (
        "Of 1 tested strong relations, 1 hold for the means (100 %), 1 also in"
        " nine of ten resamples" in text
    )
    assert f"pursuit 1.0 ≤ 0.5 {LONG}" in text


def test_what_each_run_cost_is_there(page, result):
    text = visible(page.read_text())
    assert "8 runs, 8.0 s of simulated time in total, took the workers" in text
    assert "planner cycle, median (ms) planner cycle, 95 % (ms)" in text
    assert "crossing pursuit 2 " in text[text.index("times real time") :]
    each = text[text.index(" Runs scenario planner") :].partition(" Cost ")[0]
    assert each.count(" timeout 1.00 ") == len(result.rows)
    assert each.index("run (ms)") < each.index("timeout")


def test_replays_open(page, result, folder):
    html = page.read_text()
    links = set(re.findall(r'href="(replays/[^"]+)"', html))
    assert len(links) == len(result.cells) == 4
    for link in links:
        replay = (folder / link).read_text()
        assert replay.lstrip().lower().startswith("<!doctype html")
        assert replay.rstrip().endswith("</html>")
    # What is there is not written again.
    assert WriteReplays(result, folder, workers=1) == []


@pytest.mark.slow
def test_the_page_is_made_again_from_the_folder(page, folder, capsys):
    before = page.read_text()
    assert cli.main(["report", str(folder), "--title", "Benchmark small"]) == 0
    assert "Wrote the report on 8 runs" in capsys.readouterr().out
    assert page.read_text() == before


@pytest.mark.slow
def test_metrics_of_several_robots_and_of_ones_own_are_in_the_page_again(
    tmp_path,
):
    # (Nobody registers `calmness` here.)
    facts = {"unit": "calms", "family": "mine", "direction": "higher"}
    cells = make_cell("hall", "a"), make_cell("hall", "b")
    rows = [
        make_row(
            cell,
            seed,
            {"anna.path_length": 7.0 + seed, "calmness": 2.0 + seed},
            facts={"calmness": facts},
        )
        for cell in cells
        for seed in range(2)
    ]
    suite = Suite(scenarios=["hall"], planners=["a", "b"], seeds=2)
    page = WriteSuite(SuiteResult(suite, cells, rows), tmp_path)
    before = visible(page.read_text())
    assert "anna.path length (m)" in before
    assert "calmness (calms)" in before
    title = ["--title", "Benchmark suite"]
    assert cli.main(["report", str(tmp_path), *title]) == 0
    assert visible(page.read_text()) == before


@pytest.mark.slow
def test_a_scenario_has_no_metrics_of_the_robots_of_others(tmp_path):
    names = {
        "hall": ("completed", "path_length"),
        "lobby": ("anna.completed", "anna.path_length"),
    }
    values = {
        (scenario, planner): [
            {completed: 1.0, length: 7.0 + 0.1 * seed + more}
            for seed in range(8)
        ]
        for scenario, (completed, length) in names.items()
        for planner, more in (("a", 0.0), ("b", 1.0))
    }
    page = WriteSuite(make_result(values), tmp_path).read_text()
    sections = re.split(r'<h2 id="s\d"', page)[1:]
    for section, own in zip(sections, names, strict=True):
        told = visible(section.partition("<h2")[0])
        metrics = re.findall(r"(?:anna\.)?\b(?:completed|path_length)\b", told)
        assert {*metrics} == {*names[own]}


@pytest.mark.slow
def test_a_suite_that_has_not_ended_has_a_page(page, folder, tmp_path):
    (tmp_path / "recordings").mkdir()
    shutil.copy(folder / "runs.jsonl", tmp_path)
    assert cli.main(["report", str(tmp_path)]) == 0
    text = visible((tmp_path / "report.html").read_text())
    assert "unfinished, 8 runs, 2 scenarios, 2 planners" in text
    assert "Relations" not in text


def test_a_trial_that_does_not_repeat_itself_has_no_replay(result, tmp_path):
    rows = [
        row._replace(metrics={**row.metrics, "path_length": 1.0})
        for row in result.rows[:1]
    ]
    other = SuiteResult(result.suite, result.cells, rows)
    with pytest.raises(RuntimeError, match="does not repeat itself"):
        WriteReplays(other, tmp_path, workers=1)


def test_failures_come_first(result, tmp_path):
    row = RunRow(
        *(result.cells[0].scenario, result.cells[0].planner, "", 0),
        *("error", "it broke <b>", float("nan"), {}, {}),
    )
    suite = dataclasses.replace(result.suite, relations=[])
    broken = SuiteResult(suite, result.cells, [row])
    html = WriteSuite(broken, tmp_path, judge(broken)).read_text()
    text = visible(html)
    assert "Failures 1 run failed: crossing, pursuit, seed 0: it broke" in text
    assert "it broke <b>" in text
    assert "<b>" not in html


@pytest.mark.parametrize(
    ("seed", "told"), [(3, "0.100 m, seed 3"), ("", "0.100 m")]
)
def test_encounters_of_which_nobody_is_charged(seed, told):
    """Of older runs, and of recordings, which have no seeds."""
    runs = pd.DataFrame(
        {
            "scenario": "crossing",
            "contender": "dwb",
            "seed": [seed, seed],
            "min_gap_exact": [0.2, 0.1],
        }
    )
    table = responsibility_table(runs, {})
    assert table.head == ["planner", "runs", "worst encounter: gap"]
    assert table.groups == {"crossing": [["dwb", "2", told]]}


@pytest.mark.slow
@pytest.mark.parametrize("width", [1440, 390])
def test_the_page_is_no_wider_than_the_window(page, width, browser):
    window = browser.new_page(viewport={"width": width, "height": 900})
    window.goto(page.as_uri())
    for summary in window.locator("summary").all():
        summary.click()
    widths = window.evaluate(
        "[document.documentElement.scrollWidth, window.innerWidth]"
    )
    assert widths[0] <= widths[1] == width
    # What is wider scrolls in its own box.
    boxes = window.evaluate(
        "[...document.querySelectorAll('table')].filter(t =>"
        " !t.closest('.wide')).map(t => t.getBoundingClientRect().right)"
    )
    assert all(right <= width for right in boxes)
    window.close()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 1920, 390])
def test_the_summary_is_read_first(page, width, scheme, browser):
    window = browser.new_page(
        viewport={"width": width, "height": 900}, color_scheme=scheme
    )
    window.goto(page.as_uri())
    bottom, section, right = window.evaluate(
        """() => {
          const box = (it) =>
            document.querySelector(it).getBoundingClientRect();
          const svg = [...document.querySelectorAll("figure svg")];
          const rights = svg.map(it => it.getBoundingClientRect().right);
          return [box(".summary").bottom, box("h2").top, Math.max(...rights)];
        }"""
    )
    assert bottom < min(section, 900)
    assert right <= width
    # Plots are dark on white, so the page is in each scheme.
    styles = window.evaluate(
        """["color", "backgroundColor"].map(it =>
          getComputedStyle(document.body)[it].match(/[0-9]+/g).map(Number))"""
    )
    assert max(styles[0]) < 60
    assert styles[1] == [255, 255, 255]
    window.close()


@pytest.mark.slow
def test_all_of_it_is_printed(page, browser):
    window = browser.new_page(viewport={"width": 688, "height": 1000})
    window.goto(page.as_uri())
    window.emulate_media(media="print")
    # On paper of A4, within its margins, nothing is folded or cut off.
    seen = window.evaluate(
        """["table", "figure svg", ".summary"].map(name =>
          [...document.querySelectorAll(name)].map(it => {
            const box = it.getBoundingClientRect();
            return it.checkVisibility({contentVisibilityAuto: true})
              && box.height > 0 && box.right <= 688;
          }))"""
    )
    assert [len(it) > 0 for it in seen] == [True, True, True]
    assert [it.count(False) for it in seen] == [0, 0, 0]
    assert window.pdf(format="A4").count(b"/Type /Page\n") >= 3
    window.close()


@pytest.mark.slow
def test_files_are_written_again_only_if_they_would_differ(tmp_path):
    result = make_result({("hall", "a"): runs_of([10.0])})
    folder = tmp_path / "written"
    report = WriteSuite(result, folder)
    stamps = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert WriteSuite(result, folder) == report
    assert stamps == {p: p.stat().st_mtime_ns for p in folder.iterdir()}
    # One is missing, or there is a replay more.
    (folder / "costs.csv").unlink()
    WriteSuite(result, folder)
    assert (folder / "costs.csv").exists()
    (folder / "replays").mkdir()
    (folder / "replays" / "one.html").touch()
    report.write_text("old")
    WriteSuite(result, folder)
    assert report.read_text() != "old"
    # Not all were written.
    (folder / "suite.json").write_text('{"suite": "small"')
    report.write_text("old")
    WriteSuite(result, folder)
    assert report.read_text() != "old"


@pytest.mark.slow
def test_what_a_suite_says_otherwise_is_written(tmp_path):
    runs = {("hall", "a"): runs_of([10.0, 10.0, 11.0, 11.0])}
    often = make_result(runs, repetitions=2)
    report = WriteSuite(often, tmp_path)

    def lines():
        return (tmp_path / "runs.csv").read_text().splitlines()

    assert len(lines()) == 1 + 4
    # The means are the same.
    suite = dataclasses.replace(often.suite, repetitions=1)
    WriteSuite(SuiteResult(suite, often.cells, often.rows), tmp_path)
    assert len(lines()) == 1 + 2
    suite = dataclasses.replace(suite, description="Of halls.")
    once = SuiteResult(suite, often.cells, often.rows)
    WriteSuite(once, tmp_path)
    assert "Of halls." in report.read_text()
    costly = [row._replace(cost={"wall": 9.5}) for row in once.rows]
    WriteSuite(SuiteResult(suite, once.cells, costly), tmp_path)
    assert "9.5" in (tmp_path / "costs.csv").read_text()
