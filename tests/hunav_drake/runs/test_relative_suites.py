"""Suites whose runs are compared with those without people, or robot."""

from dataclasses import dataclass
import math
import re

import pytest

from hunav_drake import CompareAlone, LoadScenario, MakeTrialDiagram
from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.scenario import ScenarioError
from hunav_drake.systems.common.layout import X
from hunav_drake.systems.planning import (
    Plan,
    Planner,
    PlannerStatus,
    register_planner,
)
from hunav_drake.trial.branches.relative import PAIRED_METRICS
from hunav_drake.views.suite_replays import WriteReplays
from tests.hunav_drake.report.pages import visible

CHANGES = ["simulation.start_jitter=0.3", "simulation.duration=16.0"]
SUITE = f"""
name: paired
scenarios: [crossing]
planners: [pursuit]
overrides: [{", ".join(CHANGES)}, evaluator.encounters=true]
seeds: [4, 5, 6]
relative: true
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("paired")


@pytest.fixture(scope="module")
def result(folder):
    return RunSuite(LoadSuite(data=SUITE), workers=1, out=folder)


@pytest.mark.slow
def test_values_are_those_of_single_trials(result):
    runs = result.runs()
    assert runs["aggregated_time"].nunique() == 3
    for _, row in runs.iterrows():
        scenario = LoadScenario(
            filename="crossing",
            overrides=[
                *CHANGES,
                "planner=pursuit",
                f"simulation.seed={row.seed}",
            ],
        )
        diagram = MakeTrialDiagram(scenario)
        alone = CompareAlone(
            scenario, diagram, diagram.CreateDefaultContext()
        ).values
        found = {name: row[name] for name in PAIRED_METRICS}
        assert found == pytest.approx(dict(alone), rel=0, abs=0, nan_ok=True)


@pytest.mark.slow
def test_the_cost_is_that_of_the_trial_alone(result):
    plain = LoadSuite(data=SUITE.replace("relative: true", ""))
    alone = RunSuite(plain, workers=1).costs()["cpu"]
    # With the comparison it is seven times as much.
    assert result.costs()["cpu"].min() < 3 * alone.min()


@pytest.mark.slow
def test_a_finished_suite_is_not_run_again(result, folder):
    log = (folder / "runs.jsonl").read_bytes()
    again = RunSuite(LoadSuite(data=SUITE), workers=1, out=folder)
    assert (folder / "runs.jsonl").read_bytes() == log
    assert again.runs().equals(result.runs())
    plain = LoadSuite(data=SUITE.replace("relative: true", ""))
    other = RunSuite(plain, workers=1)
    assert other.cells[0].sha256 != result.cells[0].sha256
    assert not set(PAIRED_METRICS) & set(other.runs())


@pytest.mark.slow
def test_the_page_tells_of_delays_and_of_the_worst_encounter(result, folder):
    WriteReplays(result, folder, workers=1)
    assert WriteReplays(result, folder, workers=1) == []
    html = WriteSuite(result, folder).read_text()
    assert 'href="#responsibility"' in html
    runs = result.runs()
    worst = runs.loc[runs["min_gap_exact"].idxmin()]
    link = re.search(
        rf'href="(replays/crossing_pursuit_{worst.seed}\.html)">([^<]+)</a>',
        html[html.index('<h2 id="responsibility"') :],
    )
    assert link.group(2).endswith(f"m, seed {worst.seed}")
    assert math.isclose(
        float(link.group(2).split()[0]), worst.min_gap_exact, abs_tol=1e-3
    )
    assert (folder / link.group(1)).is_file()
    text = visible(html)
    assert f"{runs['aggregated_time'].mean():.2f}" in text


@register_planner("sociable")
@dataclass(kw_only=True)
class Sociable(Planner):
    """Drives straight on; fails alone, or beyond its goal."""

    beyond: float = 100.0

    def plan(self, task, view, memory):
        if view.robot[X] > self.beyond or (view.humans[:, X] > 1e5).all():
            raise ValueError("what now?")
        return Plan(0.5, 0.0, PlannerStatus.DRIVING)


@pytest.mark.parametrize("beyond", [100.0, 2.5])
def test_a_planner_that_fails_only_in_the_comparison_has_not_failed(
    beyond, tmp_path
):
    (tmp_path / "mine.yaml").write_text(
        "robot: {start: [0, 0, 0], goal: [2, 0, 0]}\n"
        "humans: [{pose: [0, 3, 0], goals: [[5, 3]]}]\n"
        "simulation: {duration: 6}"
    )
    data = f"""
scenarios: [mine.yaml]
planners: [{{type: sociable, beyond: {beyond}}}]
seeds: 1
"""
    alone, relative = (
        RunSuite(LoadSuite(data=data + it), workers=1, folder=tmp_path).runs()
        for it in ("", "relative: true")
    )
    assert relative["end_reason"].tolist() == ["goal"]
    assert relative[list(PAIRED_METRICS)].isna().all(axis=None)
    assert relative[list(alone)].equals(alone)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ("robot.type=pmb2", "is physical"),
        ("population={tracks: {file: FOLDER/tracks.csv}}", "recorded people"),
    ],
)
def test_trials_in_which_nobody_can_be_left_out(changes, words, tmp_path):
    (tmp_path / "tracks.csv").write_text(
        "time,id,x,y\n" + "".join(f"{t},1,{t},2\n" for t in range(9))
    )
    scenario = tmp_path / "mine.yaml"
    scenario.write_text(
        "robot: {start: [-3, 0, 0], goal: [3, 0, 0], type: differential_drive}"
    )
    changes = changes.replace("FOLDER", str(tmp_path))
    suite = LoadSuite(
        data=f"scenarios: [mine.yaml]\nrelative: true\noverrides: ['{changes}']"
    )
    with pytest.raises(ScenarioError, match=words):
        RunSuite(suite, workers=1, folder=tmp_path)


@pytest.mark.slow
def test_the_command_asks_for_what_planners_cost_people(hunav, tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "scenarios: [passing]\nplanners: [pursuit]\nseeds: 1\n"
        "overrides: [simulation.duration=12]\n"
    )
    page = tmp_path / "page.md"
    words = ["bench", tmp_path / "mine.yaml", "--out", tmp_path, "--quiet"]
    words += ["--relative", "--workers", 1, "--markdown", page]
    code, _, _ = hunav(*words)
    assert code == 0
    text = page.read_text()
    assert " --relative --markdown " in text
    assert "## Responsibility" in text
    assert "| pursuit | 0 | 0." in text
