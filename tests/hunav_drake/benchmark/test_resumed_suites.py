"""A suite that goes on gives what it would have given from the start."""

from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
import dataclasses
import json
import re

import numpy as np
import pandas as pd
import pytest

from hunav_drake.benchmark import LoadSuite, RunSuite
from hunav_drake.benchmark.running.cell import Cell
from hunav_drake.benchmark.running.plan import CellPlan
from hunav_drake.benchmark.running.pool import InlineExecutor
from hunav_drake.benchmark.running.run_log import NAME, read_rows
from hunav_drake.benchmark.running.run_row import RunRow
from hunav_drake.benchmark.running.worker import do_task
from hunav_drake.benchmark.suite import Suite, Until
from hunav_drake.scenario import ScenarioError

SUITE = """
name: small
scenarios: [crossing]
planners: [pursuit]
overrides: [simulation.duration=1.0]
seeds: 4
"""

SLOW = {"name": "pursuit", "cruise_speed": 0.4, "label": "slow"}


@pytest.fixture
def suite():
    return LoadSuite(data=SUITE)


def assert_same(one, other):
    pd.testing.assert_frame_equal(one.runs(), other.runs(), check_exact=True)
    pd.testing.assert_frame_equal(
        one.summary(), other.summary(), check_exact=True
    )


class Dying(Executor):
    """A worker that dies in the runs of some seeds."""

    def __init__(self, *seeds):
        self.inner, self.seeds = InlineExecutor(), seeds

    def submit(self, fn, /, *args, **kwargs):
        seeds = {seed for seed, _ in args[0].runs} if fn is do_task else set()
        if seeds & set(self.seeds):
            future = Future()
            future.set_exception(BrokenProcessPool("it was killed"))
            return future
        return self.inner.submit(fn, *args, **kwargs)


def test_runs_of_dead_workers_are_run_again(suite, tmp_path):
    first = RunSuite(suite, out=tmp_path, executor=Dying(1, 3), workers=1)
    assert [row.seed for row in first.failures] == [1, 3]
    assert all("died 3 times" in row.end_message for row in first.failures)
    assert list(first.runs().completed) == [0, 0, 0, 0]
    # Until then they count as runs that have not arrived.
    path = first.summary().loc["crossing", "pursuit", ""]
    assert path.loc["path_length", "n"] == 2
    assert path.loc["completed", "n"] == 4
    # One dies again.
    again = RunSuite(suite, out=tmp_path, executor=Dying(3), workers=1)
    assert [row.seed for row in again.failures] == [3]
    seen = []
    whole = RunSuite(
        suite,
        out=tmp_path,
        workers=1,
        progress=lambda row, done, total: seen.append((row.seed, done, total)),
    )
    assert seen == [(3, 4, 4)]
    assert_same(whole, RunSuite(suite, workers=1))
    rows = list(read_rows(tmp_path / NAME))
    assert [row.seed for row in rows].count(3) == 3


def test_an_error_of_a_run_is_not_run_again(suite, tmp_path, monkeypatch):
    from hunav_drake.benchmark.running import worker

    prepared = worker._prepared
    monkeypatch.setattr(worker, "_prepared", lambda task: 1 / 0)
    first = RunSuite(suite, out=tmp_path, workers=1)
    assert {row.end_reason for row in first.failures} == {"error"}
    assert list(first.runs().completed) == [0, 0, 0, 0]
    monkeypatch.setattr(worker, "_prepared", prepared)
    RunSuite(suite, out=tmp_path, workers=1, progress=lambda *_: 1 / 0)


@pytest.mark.parametrize(
    ("before", "now"),
    [
        ({"repetitions": 3}, {"repetitions": 1}),
        ({"repetitions": 1}, {"repetitions": 2}),
        ({"seeds": 6}, {"seeds": 2}),
        ({"seeds": [5, 2]}, {"seeds": [2, 7]}),
        (
            {"seeds": 9},
            {
                "seeds": 9,
                "until": Until(metric="path_length", half_width=1.0, least=3),
            },
        ),
        ({"planners": ["pursuit", SLOW]}, {"planners": ["pursuit"]}),
        ({"settings": {"a": [], "b": []}}, {"settings": {"b": []}}),
    ],
)
def test_what_a_folder_has_besides_does_not_count(suite, tmp_path, before, now):
    RunSuite(dataclasses.replace(suite, **before), out=tmp_path, workers=1)
    changed = dataclasses.replace(suite, **now)
    resumed = RunSuite(changed, out=tmp_path, workers=1)
    assert_same(resumed, RunSuite(changed, workers=1))


def plan_of(**keys):
    suite = Suite(scenarios=["crossing"], **keys)
    cell = Cell(
        scenario="crossing", planner="a", setting="", text="", sha256=""
    )
    return CellPlan(cell, suite, ())


def take(plan, value):
    """Runs a plan to its end; returns how many seeds it has asked for."""
    seeds = set()
    while task := plan.next_task():
        for seed, repetition in task.runs:
            seeds.add(seed)
            metrics = {"path_length": value(seed, repetition)}
            plan.take(
                RunRow(
                    *(task.cell, "", "", seed, repetition, "goal", "", 1.0),
                    *(metrics, {}, {}, {}),
                )
            )
    assert plan.is_done
    return len(seeds)


UNTIL = Until(metric="path_length", half_width=0.5, least=4)


def test_a_mean_is_known_by_seeds_not_by_repetitions():
    noise = np.random.default_rng(0).standard_normal(1000).tolist()

    def value(seed, repetition):
        return 10 + noise[seed]

    once = take(plan_of(seeds=1000, until=UNTIL), value)
    often = take(plan_of(seeds=1000, until=UNTIL, repetitions=7), value)
    assert 10 < once == often < 50
    # However often a seed is run, its equal runs are one value.
    assert take(plan_of(seeds=2, until=UNTIL, repetitions=9), value) == 2


def test_repetitions_of_a_seed_count_by_their_mean():
    def value(seed, repetition):
        if repetition == 0:
            return float("nan")
        return 10 + (1000 if repetition == 1 else -1000)

    assert take(plan_of(seeds=9, until=UNTIL, repetitions=3), value) == 4


def test_repetitions_are_one_value_in_tables(suite):
    often = dataclasses.replace(suite, repetitions=3)
    assert_frame = pd.testing.assert_frame_equal
    result = RunSuite(often, workers=1)
    assert len(result.runs()) == 12
    assert_frame(result.summary(), RunSuite(suite, workers=1).summary())
    one = dataclasses.replace(suite, repetitions=6, seeds=1)
    summary = RunSuite(one, workers=1).summary()
    assert (summary["n"].dropna() <= 1).all()
    assert summary.drop(index="completed", level="metric")["low"].isna().all()


CROSSING = {
    "scenarios": ["crossing"],
    "metric": "completed",
    "holds": "dwb > 1",
}


def relation(**keys):
    return {"relations": [CROSSING | keys]}


@pytest.mark.parametrize(
    ("changes", "place", "wrong", "right"),
    [
        ({"seeds_of": {"crosing": 2}}, "seeds_of", "crosing", "crossing"),
        (
            {"until": {"metric": "path_lenght", "half_width": 1.0}},
            *("until.metric", "path_lenght", "path_length"),
        ),
        (
            relation(scenarios=["crosing"]),
            *("relations[0].scenarios", "crosing", "crossing"),
        ),
        (
            relation(metric="complete"),
            *("relations[0].metric", "complete", "completed"),
        ),
        (
            relation(metric="jerk"),
            *("relations[0].metric", "jerk", "avg_robot_jerk"),
        ),
        (
            relation(holds="dbw > 1"),
            *("data:7: relations[0].holds", "dbw", "dwb"),
        ),
        (
            relation(scenarios=["crossing", "passing"], holds="dwb_pasing > 1"),
            *("relations[0].holds", "dwb_pasing", "dwb_passing"),
        ),
        (
            relation(by="behavior", holds="reglar > 1"),
            *("relations[0].holds", "reglar", "regular"),
        ),
        (
            relation(by="both", holds="dwb_reglar > 1"),
            *("relations[0].holds", "reglar", "regular"),
        ),
    ],
)
def test_names_that_nothing_has_are_told_before_anything_runs(
    changes, place, wrong, right
):
    def run():
        suite = LoadSuite(data=SUITE + json.dumps(changes)[1:-1])
        RunSuite(suite, workers=1, progress=lambda *_: 1 / 0)

    with pytest.raises(ScenarioError) as caught:
        run()
    told = f"{wrong!r}; did you mean {right!r}?"
    assert re.search(
        f"{re.escape(place)}: .*{re.escape(told)}", str(caught.value)
    )


def test_a_metric_that_a_scenario_does_not_compute_is_told(suite):
    suite = dataclasses.replace(
        suite,
        overrides=["evaluator.metrics=[path_length]"],
        until=Until(metric="completed", half_width=0.1),
    )
    with pytest.raises(ScenarioError, match="is not computed in crossing"):
        RunSuite(suite, workers=1)


def test_the_metric_of_the_progress_bar_is_one(hunav, tmp_path):
    code, _, err = hunav(
        *("bench", "paper", "--out", tmp_path, "--show", "path_lenght")
    )
    assert code == 2
    assert "did you mean 'path_length'" in err


def test_the_page_of_markdown_tells_its_command(hunav, tmp_path):
    file, page = tmp_path / "small.yaml", tmp_path / "page.md"
    file.write_text(SUITE)
    own = tmp_path / "own.py"
    own.write_text("")
    words = [
        *("bench", str(file), "--seeds", "7", "--planner", "pursuit"),
        *("--set", "robot.radius=0.3", "--until", "path_length=1.5"),
        *("--import", str(own), "--markdown", str(page)),
    ]
    code, _, err = hunav(
        *words, "--out", tmp_path / "out", "--workers", 1, "--quiet"
    )
    assert code == 0, err
    text = page.read_text()
    assert f"    {' '.join(['hunav', *words])}\n" in text
    # As many as the mean needs, not as it may take.
    assert "with 6 seeds for each cell (" in text


def test_a_metric_of_ones_own_may_be_named(suite, tmp_path, restored_metrics):
    own = tmp_path / "own_metric_of_suite.py"
    own.write_text(
        "from hunav_drake.systems.evaluation.metrics import register_metric\n"
        "@register_metric(unit='m', family='path', source='me')\n"
        "def way_of_mine(recording):\n"
        "    '''The x at the end.'''\n"
        "    return float(recording.robot[-1, 0])\n"
    )
    suite = dataclasses.replace(
        suite, until=Until(metric="way_of_mine", half_width=1.0, least=3)
    )
    result = RunSuite(suite, workers=1, imports=[str(own)])
    assert np.isfinite(result.runs().way_of_mine).all()
