"""Reports on runs with settings, repeats, and metrics of one's own."""

import dataclasses
import re

import numpy as np
import pytest

from hunav_drake.commands import cli
from hunav_drake.report.trial_page import is_about_robot_alone
from hunav_drake.report.writing import WriteReport
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.systems.evaluation.metrics import METRICS, register_metric
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.result import MakeTrialResult
from tests.choices import COMMON_METRICS
from tests.hunav_drake.passing_trials import make_recording, make_result
from tests.hunav_drake.report.pages import visible


@pytest.fixture
def own_metrics(restored_metrics):
    """Registers metrics, which the test may forget."""
    for name in ("my_x", "my-y(%)"):
        register_metric(name=name, unit="m", family="mine", source="me")(
            lambda recording: float(recording.robot[-1, 0])
        )


def report(results, folder):
    html = WriteReport(results, folder / "r.html").read_text()
    # The contents have the same titles as the sections.
    before, _, rest = html.partition("<nav")
    return visible(before + rest.partition("</nav>")[2]), html


def section(text, start, end):
    return text[text.index(start) :].partition(end)[0]


@pytest.mark.slow
def test_settings_of_one_planner_have_columns_of_their_own(tmp_path):
    trials = [
        make_result(seed=seed, setting=f"planner.cruise_speed={v}", speed=v)
        for v in (0.3, 0.5)
        for seed in range(3)
    ]
    text, html = report(trials, tmp_path)
    assert "6 runs, scenario passing, planner pursuit, 2 settings" in text
    slow, fast = (f"pursuit, cruise_speed={v}" for v in (0.3, 0.5))
    assert f"metric {slow} {fast} unit" in text
    assert f"passing {slow} 3 3" in text
    # The mean over seeds of speed + 0.01 seed, in one second.
    assert re.search(r"path_length ↓ 0.310 \[.*?\] 0.510 \[", text)
    assert f"{fast} \N{MINUS SIGN} {slow}" in text
    assert "Comparison" in text
    # The list of runs has them in full.
    assert "pursuit planner.cruise_speed=0.3 0 goal" in text
    # In pictures the setting stands below the planner.
    assert re.search(r">cruise_speed=0.3</(text|tspan)>", html)


@pytest.mark.slow
def test_of_many_pairs_and_runs_one_line_each_is_seen_at_first(tmp_path):
    batch = []
    for i, planner in enumerate(("pursuit", "dwb", "sfw", "mppi")):
        for seed in range(8):
            trial = make_result(planner=planner, seed=seed)
            trial.metrics["path_length"] = 10.0 + i + 0.01 * seed
            batch.append(trial)
    html = WriteReport(batch, tmp_path / "r.html").read_text()
    summaries = re.findall(r"<details><summary>(.*?)</summary>", html)
    pairs = [it for it in summaries if ": " in it]
    assert len(pairs) == 6
    assert pairs[0].startswith("pursuit and dwb: pursuit is better in 1 of ")
    assert "The headline metrics of all 32 runs" in summaries
    # No panel of a plot is empty: what is zero everywhere is a line of text.
    assert "Zero or without a value in all runs: " in html
    # The robot moves alike in all: one run is drawn, in colors.
    assert "Trajectories of the robot and of the people (seed 0)." in html
    few = WriteReport(batch[:24], tmp_path / "few.html").read_text()
    summaries = re.findall(r"<details><summary>(.*?)</summary>", few)
    assert not [it for it in summaries if ": " in it or "runs" in it]


@pytest.mark.slow
def test_without_settings_there_is_no_column_of_them(tmp_path):
    text, _ = report([make_result(seed=s) for s in range(2)], tmp_path)
    assert "scenario planner seed outcome" in text
    assert "setting" not in text


@pytest.mark.slow
def test_the_same_run_counts_once(tmp_path):
    trials = [
        make_result(seed=seed, planner=planner)
        for planner in ("a", "b")
        for seed in range(6)
    ]
    expected = section(report(trials, tmp_path)[0], "Outcomes", "Proven")
    tagged = [dataclasses.replace(t, tag=f"t{i}") for i, t in enumerate(trials)]
    # (An earlier version did not tell what is drawn.)
    again = dataclasses.replace(
        trials[0],
        tag="again",
        provenance={**trials[0].provenance, "drawn": "start jitter"},
    )
    text, _ = report([*tagged, again], tmp_path)
    assert section(text, "Outcomes", "Proven") == expected
    assert "12 runs" in text
    assert "Left out: 1 duplicate run" in text
    assert "again duplicates t0" in text
    # With nothing else left it is a report on a single run.
    assert "Plots" in report([tagged[0], again], tmp_path)[0]


@pytest.mark.slow
def test_runs_that_differ_in_anything_are_no_duplicates(tmp_path):
    trials = [
        make_result(),
        make_result(seed=1),
        make_result(setting="x"),
        make_result(speed=1.1),
        make_result(scenario_text="b"),
        *(make_result(planner="unknown") for _ in range(2)),
    ]
    # Nobody knows what they are made from.
    for trial in trials[-2:]:
        del trial.provenance["scenario_sha256"]
    text, _ = report(trials, tmp_path)
    assert "7 runs" in text
    assert "duplicate" not in text


@pytest.mark.slow
def test_different_runs_of_one_seed_are_told_of(tmp_path):
    trials = [
        make_result(seed=seed, planner=planner)
        for planner in ("a", "b")
        for seed in range(3)
    ]
    other = make_result(seed=1, planner="b", speed=2)
    other = dataclasses.replace(other, tag="<c>")
    text, html = report([*trials, other], tmp_path)
    assert "b has several different runs of seed 1 : , <c>. All of" in text
    assert "<c>" not in html
    assert "pair" not in section(text, "b has several", "Paired comparison")
    # The other seeds are compared all the same.
    equal = section(text, "Paired comparison", "All metrics")
    assert re.search(r"path_length ↓ 1.01 1.01 0 \[0, 0\] 2 m", equal)


@pytest.mark.slow
def test_metrics_of_ones_own_are_never_left_out(tmp_path, own_metrics):
    trials = [
        make_result(seed=seed, planner=planner, metric_names=["paper", "mine"])
        for planner in ("a", "b")
        for seed in range(2)
    ]
    for trial in trials:
        WriteResult(trial, tmp_path)
    METRICS.pop("my_x")
    METRICS.pop("my-y(%)")
    text, html = report(LoadResults(tmp_path), tmp_path)
    for name in ("my_x", "my-y(%)"):
        assert name in section(text, "Paired comparison", "All metrics")
        assert f'aria-label="{name}: means' in html
        runs = section(text, " Runs ", "Provenance")
        assert f"{name.replace('_', ' ')} (m)" in runs
    assert " mine " in text
    # Of many metrics of this package some are chosen.
    chosen = section(text, "Paired comparison", "All metrics")
    assert "cumulative_heading_changes" not in chosen
    assert "cumulative_heading_changes" in text


@pytest.mark.slow
def test_of_few_metrics_all_are_shown(tmp_path):
    trials = [
        make_result(planner=planner, metric_names="goal") for planner in "ab"
    ]
    text, html = report(trials, tmp_path)
    for name in trials[0].metrics.index:
        assert name in section(text, "Paired comparison", "All metrics")
    assert 'aria-label="completed: means' not in html


def moving_recording():
    """A robot and people that move differently, among walls."""
    rng = np.random.default_rng(0)
    times = np.arange(60) * 0.1
    robot = np.zeros((60, 7))
    robot[:, 0] = np.where(times < 5, times, 5) - 2
    robot[:, 1] = 0.1 * np.sin(times)
    robot[:, 3] = np.where(times < 5, 1.0, 0.0)
    robot[:, 6] = 0.3
    humans = np.zeros((60, 3, 7))
    humans[:, :, 0] = [0, 1, 2] + 0.2 * times[:, None] * [-1, 1, -3]
    humans[:, :, 1] = [0.3, 1.0, -1.5] + 0.1 * rng.normal(size=(60, 3))
    humans[:, :, 3] = [-0.2, 0.2, -0.6]
    humans[:, :, 6] = 0.25
    return Recording(
        times=times,
        robot=robot,
        humans=humans,
        behaviors=("regular", "scared", "curious"),
        goal=(3.0, 0.0, 0.0),
        obstacles=Obstacles.from_shapes([[[-5, 3], [5, 3]]], solid=[False]),
    )


def test_nobody_changes_what_is_about_the_robot_alone():
    result = MakeTrialResult(
        moving_recording(), provenance={}, end_reason="end"
    )
    same = {
        name
        for name in COMMON_METRICS
        if np.array_equal(
            result.by_behavior[name],
            np.full(3, result.metrics[name]),
            equal_nan=True,
        )
    }
    alone = {name for name in COMMON_METRICS if is_about_robot_alone(name)}
    assert alone <= same
    assert "min_dist_to_people" not in alone
    # People could make a difference to the rest; to most of it these do.
    assert len(same - alone) < 12, same - alone


@pytest.mark.slow
def test_what_happens_to_be_equal_is_shown_by_behavior(tmp_path):
    result = make_result(make_recording(behaviors=("regular", "scared")))
    assert result.by_behavior["min_dist_to_people"].nunique() == 1
    text, _ = report(result, tmp_path)
    part = section(text, "Metrics by behavior", "Provenance")
    assert re.search(r"min_dist_to_people ↑ 0.900 0.900 0.900 m", part)
    for name in ("path_length", "completed", "avg_robot_jerk"):
        assert name not in part


@pytest.mark.slow
def test_the_command_names_a_few_of_many_missing_runs(tmp_path, capsys):
    for seed in range(16):
        WriteResult(make_result(seed=seed, metric_names="goal"), tmp_path)
    for path in sorted(tmp_path.glob("runs/*/recording.npz"))[:14]:
        path.unlink()
    assert cli.main(["report", str(tmp_path)]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 6
    assert lines[-1] == "hunav: ... and 9 more: see the report"
    assert (tmp_path / "report.html").read_text().count("Left out: ") == 14


@pytest.mark.slow
def test_the_command_tells_settings_apart(tmp_path):
    change = "simulation.duration=0.5"
    for more in (
        ["--set", change],
        ["--set", change, "--label", "short one"],
        ["--set", change, "--label", ""],
    ):
        cli.main(
            [
                *("run", "passing", "--quiet", "--no-replay"),
                *(*more, "--out", str(tmp_path)),
            ]
        )
    assert list(ReadRuns(tmp_path)["setting"]) == [change, "short one", ""]
    page = (tmp_path / "runs/passing_pursuit_0_run2/report.html").read_text()
    assert "setting short one" in page
