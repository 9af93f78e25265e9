"""What the documentation shows is what there is."""

from pathlib import Path
import re
import textwrap

import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial
from hunav_drake.commands import cli
from hunav_drake.runs import LoadSuite
from hunav_drake.runs.comparison.paper import (
    PLANNERS as PAPER_PLANNERS,
    PUBLISHED,
    PUBLISHED_BY_BEHAVIOR,
)
from hunav_drake.scenario import draw_people
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.evaluation import METRICS, select_metrics
from hunav_drake.systems.evaluation.metric import TABLE_I
from hunav_drake.systems.planning import PLANNERS
from hunav_drake.systems.robot import ROBOTS
from hunav_drake.trial.metric_facts import is_built_in
from hunav_drake.validation.cases import CASES
from tests import architecture

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def run_python(page):
    """Runs the Python of a page in one go; returns what it makes."""
    text = (DOCS / f"{page}.md").read_text()
    made = {"__name__": page}
    for block in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S):
        exec(compile(block, f"{page}.md", "exec"), made)
    return made


def test_the_robot_of_the_page_drives(monkeypatch):
    """And the page tells of all robots, contacts and their metrics."""
    monkeypatch.setattr(ROBOTS, "_choices", dict(ROBOTS))
    text = (DOCS / "robots.md").read_text()
    run_python("robots")
    scenario = LoadScenario(data="robot: {type: gantry, goal: [2, 0, 0]}")
    assert RunTrial(scenario).end_reason == "goal"
    metrics = [m.name for m in select_metrics(["contacts"])]
    for name in [*set(ROBOTS) - {"gantry"}, *metrics, *Contact.__members__]:
        assert f"`{name}`" in text, name


def test_the_population_of_the_docs_can_be_drawn():
    text = (DOCS / "population.md").read_text()
    (block,) = re.findall(r"^population:\n(?: .*\n)+", text, re.M)
    scenario = LoadScenario(data=textwrap.dedent(block))
    assert len(draw_people(scenario)) == 20


def test_the_sources_of_the_docs_can_be_drawn():
    text = (DOCS / "population.md").read_text()
    (block,) = re.findall(r"^  sources:\n(?:   .*\n|  s.*\n)+", text, re.M)
    data = "population:\n" + textwrap.indent(textwrap.dedent(block), "  ")
    assert len(draw_people(LoadScenario(data=data))) == 12


def test_the_sensors_of_the_docs_are_there():
    text = (DOCS / "sensors.md").read_text()
    (block,) = re.findall(r"^sensors:\n(?:  .*\n)+", text, re.M)
    assert len(LoadScenario(data=block).sensors) == 4
    made = run_python("sensors")
    assert made["scan"].shape == (360,)
    context = made["diagram"].CreateDefaultContext()
    lidar = made["lidar"]
    own = lidar.GetMyContextFromRoot(context)
    assert lidar.get_scan_output_port().Eval(own).min() < 3
    for picture in re.findall(r"!\[.*\]\((.*)\)", text):
        assert (DOCS / picture).stat().st_size < 150_000


def test_the_suite_of_the_docs_is_one():
    text = (DOCS / "benchmark.md").read_text()
    (block,) = re.findall(r"^# mine.yaml\n(?:.+\n)+?(?=```)", text, re.M)
    suite = LoadSuite(data=block)
    assert suite.name == "mine"
    assert len(suite.planners) == len(suite.settings) == 2
    assert [it.metric for it in suite.relations] == ["min_dist_to_people"]


def test_the_standard_suite_is_in_the_docs():
    """The page and the picture are made by the commands that they tell."""
    suite = LoadSuite(filename="standard")
    text = (DOCS / "benchmark.md").read_text()
    for target in re.findall(r"\]\((standard\w*\.\w+)\)", text):
        assert (DOCS / target).stat().st_size < 80_000
    page = (DOCS / "standard_results.md").read_text()
    assert f"version {suite.version}" in page
    (command,) = re.findall(r"^    (hunav bench standard.*)$", page, re.M)
    assert f"\n{command}\n" in text
    assert re.findall(r"^## (\w+)$", page, re.M) == suite.scenarios
    rows = re.findall(r"^\| (\w+) .*`\w{12}` \|$", page, re.M)
    assert rows == suite.planners * len(suite.scenarios)


def test_every_shipped_planner_is_in_the_docs():
    rows = re.findall(r"^\| `(\w+)`", (DOCS / "planners.md").read_text(), re.M)
    assert set(rows) >= {"pursuit", "dwb", "scl", "sfw", "mppi", "sfm", "orca"}


def test_the_drawing_of_the_diagram_is_up_to_date():
    """`python docs/draw_diagram.py` draws it anew."""
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    drawing = (DOCS / "diagram.svg").read_text()
    drawn = set(re.findall(r">([^<]+)</text>", drawing))
    for system in diagram.GetSystems():
        assert f"name={system.get_name()}" in drawn
    exported = {
        diagram.get_output_port(i).get_name()
        for i in range(diagram.num_output_ports())
    }
    assert exported <= drawn


def test_the_validation_page_tells_of_all_cases_and_models():
    """`hunav validate --markdown docs/validation.md` writes it anew."""
    text = (DOCS / "validation.md").read_text()
    head = re.search(r"^\| case \| standard \| (.*) \|$", text, re.M)
    models = [
        name
        for name, model in MOTION_MODELS.items()
        # Those of the package, whatever other tests have registered.
        if model.__module__.startswith("hunav_drake.")
    ]
    assert head[1].split(" | ") == sorted(models)
    rows = re.findall(r"^\| \[(\w+)\]\(#\1\) \| ([^|]*) \|", text, re.M)
    assert dict(rows) == {name: case.standards for name, case in CASES.items()}
    assert re.findall(r"^### (\w+)$", text, re.M) == list(CASES)
    for case in CASES.values():
        assert case.question in text
        assert f"Expected: {case.expected}." in text
    for picture in re.findall(r"!\[.*\]\((.*)\)", text):
        assert (DOCS / picture).exists()


def test_ports_are_listed_one_a_line():
    """As Drake's docs need them to draw a system."""
    blocks = [
        textwrap.dedent(block)
        for path in architecture.modules().values()
        for block in re.findall(
            r"pydrake_system::\n\n((?: +\S.*\n)+)", path.read_text()
        )
    ]
    assert len(blocks) > 15
    for block in blocks:
        assert re.fullmatch(
            r"name: \w+\n"
            r"(input_ports:\n(- \S.*\n)+)?(output_ports:\n(- \S.*\n)+)?",
            block,
        ), block


@pytest.mark.slow
def test_every_room_is_described():
    text = (DOCS / "architecture.md").read_text()
    for room in architecture.rooms():
        parent, _, name = room.rpartition("/")
        folder = Path(parent or "hunav_drake", name)
        if (ROOT / folder).is_dir():
            assert f"{folder}/" in text or f"`{name}/`" in text, room


README = (ROOT / "README.md").read_text()


PAPER_ROWS = r"^\| [^|]* ((?:\| \S+ \| \*\S+\* ){3})\|$"


def test_the_page_and_the_readme_print_what_the_paper_does():
    page = (DOCS / "paper_results.md").read_text()
    rows = re.findall(PAPER_ROWS, page, re.M)
    assert len(rows) == 9
    some = re.findall(PAPER_ROWS, README, re.M)
    assert len(some) == 3
    assert set(some) <= set(rows)
    passing, crossing = PUBLISHED["passing"], PUBLISHED["crossing"]
    curious = PUBLISHED_BY_BEHAVIOR["curious"]
    threatening = PUBLISHED_BY_BEHAVIOR["threatening"]
    metrics = [
        (passing, "time_to_reach_goal"),
        (passing, "min_dist_to_people"),
        (passing, "personal_space_intrusions"),
        (crossing, "time_to_reach_goal"),
        (crossing, "cumulative_heading_changes"),
        (crossing, "social_work"),
        (curious, "min_dist_to_people"),
        (threatening, "min_dist_to_people"),
        (threatening, "intimate_space_intrusions"),
    ]
    printed = [float(it) for it in re.findall(r" \*([\d.]+)\* ", page)]
    assert printed == pytest.approx(
        [table[p][name] for table, name in metrics for p in PAPER_PLANNERS],
        abs=0.051,
    )


def test_the_readme_tells_how_to_begin():
    for words in (
        "source .venv/bin/activate",
        "`make notebook`",
        "`make docs`",
    ):
        assert words in README
    assert len(README.split()) < 2000


def test_the_readme_counts_what_there_is():
    own = [name for name in METRICS if is_built_in(name)]
    told = f"| {len(own)}, among them the {len(TABLE_I)} of the paper |"
    assert told in README
    planners = [
        p for p in PLANNERS.values() if p.__module__.startswith("hunav_drake.")
    ]
    # (Three do not plan: stand, external, and bridge, which asks others.)
    assert f"| {len(planners) - 3}, among them DWB" in README
    folder = ROOT / "systems" / "behavior" / "trees"
    trees = {path.stem for path in folder.glob("*.xml")}
    # What trees have in common, and what editors know of nodes.
    trees -= {"let_pass", "node_models"}
    own = {"distracted", "cooperative"}
    assert own <= trees
    told = f"| HuNavSim's {len(trees - own)}, distracted, cooperative |"
    assert told in README
    # Social forces, ORCA, the headed social force, and two by their speeds; not
    # those that other tests have registered.
    models = [
        name
        for name, model in MOTION_MODELS.items()
        if model.__module__.startswith("hunav_drake.")
    ]
    assert sum("speed" in it or "velocity" in it for it in models) == 2
    assert "ORCA, headed social force, two speed models" in README
    assert len(models) == 5


@pytest.mark.slow
def test_the_readme_shows_how_a_run_ends(capsys, tmp_path, monkeypatch):
    """But for how long it takes."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["run", "passing", "--out", "out/demo"]) == 0
    out = capsys.readouterr().out
    (block,) = re.findall(r"^```text\n(passing,.*?)^```", README, re.M | re.S)
    begin, end = block.split("  ...\n")
    times = r"Simulated in [\d.]+ s, \d+ times"
    assert out.startswith(begin)
    assert re.sub(times, "", out).endswith("\n" + re.sub(times, "", end))


@pytest.mark.slow
def test_the_code_about_planners_runs(capsys, monkeypatch):
    """All of the page in one go, as someone who reads it types it."""
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))
    text = (DOCS / "own_planner.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    shared: dict[str, object] = {"__name__": "own_planner"}
    printed = []
    for block in blocks:
        exec(compile(block, "own_planner.md", "exec"), shared)
        printed.append(capsys.readouterr().out)
    assert len(blocks) == 5
    assert printed[0].startswith("goal ")
    (shown,) = re.findall(r"^(planner 'lost' .*)\(", text, re.M)
    assert printed[3].startswith(shown)
    assert re.fullmatch(r"\d+\.\d{3} ms per cycle\n", printed[4])
