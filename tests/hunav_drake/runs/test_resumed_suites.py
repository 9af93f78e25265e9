"""A suite that goes on gives what it would have given from the start."""

from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
import dataclasses
import json
import re
import threading

import numpy as np
import pandas as pd
import pytest

from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.cell_plan import CellPlan
from hunav_drake.runs.cells import Cell
from hunav_drake.runs.intervals import mean_interval, wilson_interval
from hunav_drake.runs.run_log import NAME, read_rows
from hunav_drake.runs.run_row import RunRow
from hunav_drake.runs.suite import Relation, Suite, Until
from hunav_drake.runs.tasks import do_task
from hunav_drake.runs.worker_pool import InlineExecutor
from hunav_drake.scenario import ScenarioError

SUITE = """
name: small
scenarios: [crossing]
planners: [pursuit]
overrides: [simulation.duration=1.0]
seeds: 4
"""

SLOW = {"type": "pursuit", "cruise_speed": 0.4, "label": "slow"}


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


@pytest.mark.slow
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
    lines = (tmp_path / NAME).read_text().splitlines()
    assert [json.loads(line)["seed"] for line in lines].count(3) == 3
    assert [row.seed for row in read_rows(tmp_path / NAME)].count(3) == 1


class Breaking(Executor):
    """Workers that all die when one of them does, with all they were given."""

    def __init__(self, *seeds):
        self.seeds, self.given, self.deaths = seeds, [], 0

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.given.append((future, fn, args))
        threading.Timer(0.01, self.work).start()
        return future

    def work(self):
        given, self.given = self.given, []
        tasks = [args[0] for _, fn, args in given if fn is do_task]
        is_dead = any(s in self.seeds for it in tasks for s, _ in it.runs)
        self.deaths += is_dead
        for future, fn, args in given:
            if is_dead:
                future.set_exception(BrokenProcessPool("it was killed"))
            else:
                future.set_result(fn(*args))


@pytest.mark.slow
def test_who_was_only_beside_a_dead_worker_is_not_lost(suite):
    deadly = (2, 3, 11)
    pool = Breaking(*deadly)
    suite = dataclasses.replace(suite, seeds=12)
    result = RunSuite(suite, executor=pool, workers=2)
    lost = [row for row in result.failures if row.end_reason == "worker_died"]
    assert [row.seed for row in lost] == list(deadly)
    assert all("died 3 times" in row.end_message for row in lost)
    assert len(result.rows) == 12
    # Once or more with others, then thrice alone.
    assert 3 * len(deadly) < pool.deaths <= 4 * len(deadly)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_crash_of_a_library_is_a_row(workers, tmp_path, hunav):
    """As a fault of Drake's, which ends its process without a word."""
    own = tmp_path / "crashing.py"
    own.write_text(
        "import os, signal\n"
        "from hunav_drake.systems.planning import Plan, PlannerStatus\n"
        "from hunav_drake.systems.planning import register_plan\n"
        "@register_plan('crashing')\n"
        "def crashing(task, view, memory):\n"
        "    os.kill(os.getpid(), signal.SIGSEGV)\n"
        "    return Plan(0.0, 0.0, PlannerStatus.DRIVING)\n"
    )
    file = tmp_path / "small.yaml"
    file.write_text(SUITE.replace("seeds: 4", "seeds: 1"))
    code, _, err = hunav(
        *("bench", file, "--import", own, "--out", tmp_path / "out"),
        *("--planner", "crashing", "pursuit", "--workers", workers, "--quiet"),
    )
    assert code == 1, err
    rows = {row.cell: row for row in read_rows(tmp_path / "out/small" / NAME)}
    assert rows["crossing/crashing"].end_reason == "worker_died"
    assert "died 3 times" in rows["crossing/crashing"].end_message
    assert rows["crossing/pursuit"].end_reason == "timeout"


def test_an_error_of_a_run_is_not_run_again(suite, tmp_path, monkeypatch):
    from hunav_drake.runs import tasks

    prepared = tasks._prepared
    monkeypatch.setattr(tasks, "_prepared", lambda *_: 1 / 0)
    first = RunSuite(suite, out=tmp_path, workers=1)
    assert {row.end_reason for row in first.failures} == {"error"}
    assert list(first.runs().completed) == [0, 0, 0, 0]
    monkeypatch.setattr(tasks, "_prepared", prepared)
    RunSuite(suite, out=tmp_path, workers=1, progress=lambda *_: 1 / 0)


@pytest.mark.slow
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


def take(plan, value, metric="path_length"):
    """Runs a plan to its end; returns how many seeds it has asked for.

    Runs without a value have failed.
    """
    seeds = set()
    while task := plan.next_task():
        for seed, repetition in task.runs:
            seeds.add(seed)
            told = value(seed, repetition)
            reason = "error" if told is None else "goal"
            metrics = {} if told is None else {metric: told}
            plan.take(
                RunRow(
                    *(task.cell.scenario, task.cell.planner, "", seed),
                    *(reason, "", 1.0, metrics, {}, repetition),
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


@pytest.mark.parametrize("missed", [0.0, None])
def test_a_rate_is_known_by_its_own_interval(missed):
    """The first six arrive, then every second; who fails does not."""
    until = Until(metric="completed", half_width=0.1, least=6)

    def value(seed, repetition):
        return 1.0 if seed < 6 or seed % 2 else missed

    n = take(plan_of(seeds=1000, until=until), value, "completed")
    assert n < 1000
    for count, is_known in ((n, True), (n - 5, False)):
        arrived = [value(seed, 0) or 0.0 for seed in range(count)]
        low, high = wilson_interval(sum(arrived), count)
        assert ((high - low) / 2 <= 0.1) == is_known


def test_a_mean_is_known_by_the_interval_that_tables_tell():
    times = np.random.default_rng(0).exponential(1, 400)
    for width in (0.3, 0.35, 0.4):
        until = Until(metric="path_length", half_width=width, least=4)
        n = take(plan_of(seeds=400, until=until), lambda s, r: times[s])
        low, high = mean_interval(times[:n])
        assert n < 400
        assert (high - low) / 2 <= width


@pytest.mark.slow
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
            *("relations[0].holds", "dwb_reglar", "dwb_regular"),
        ),
        (
            relation(by="both", holds="dbw_regular > 1"),
            *("relations[0].holds", "dbw_regular", "dwb_regular"),
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


@pytest.mark.parametrize("name", ["dbw", "dbw_regular", "dwb_reglar"])
def test_names_in_suites_of_python_are_checked_too(suite, name):
    by = "both" if "_" in name else "planner"
    wrong = Relation(**CROSSING | {"by": by, "holds": f"{name} < 1"})
    suite = dataclasses.replace(suite, relations=[wrong])
    with pytest.raises(
        ScenarioError, match=rf"relations\[0\]\.holds: .*{name}"
    ):
        RunSuite(suite, workers=1, progress=lambda *_: 1 / 0)


def test_the_people_of_all_scenarios_are_looked_at(suite):
    wrong = Relation(
        scenarios=["combined", "crossing"],
        metric="min_dist_to_people",
        by="behavior",
        holds="reglar < 1",
    )
    suite = dataclasses.replace(
        suite, scenarios=["combined", "crossing"], relations=[wrong]
    )
    with pytest.raises(ScenarioError, match="no behavior 'reglar'"):
        RunSuite(suite, workers=1, progress=lambda *_: 1 / 0)


@pytest.mark.parametrize(
    ("labels", "scenarios", "holds", "told"),
    [
        (["dwb 1", "dwb-1"], ["crossing"], "dwb_1 < 9", "'dwb 1' and 'dwb-1'"),
        (["a", "a_b"], ["b_c", "c"], "a_b_c < 9", "'a/b_c' and 'a_b/c'"),
    ],
)
def test_a_name_of_two_is_told_where_a_formula_has_it(
    labels, scenarios, holds, told
):
    def load(formula):
        relation = CROSSING | {"scenarios": scenarios, "holds": formula}
        planners = [{"type": "dwb", "label": it} for it in labels]
        data = {"scenarios": ["crossing"], "planners": planners}
        return LoadSuite(data=json.dumps(data | {"relations": [relation]}))

    with pytest.raises(ScenarioError, match=f"name in formulas of {told}"):
        load(holds)
    # The others are clear, whatever is registered.
    load("dwb < 9" if len(scenarios) == 1 else "a_c < 9")


def test_a_metric_that_a_scenario_does_not_compute_is_told(suite):
    suite = dataclasses.replace(
        suite,
        overrides=["evaluator.metrics=[path_length]"],
        until=Until(metric="completed", half_width=0.1),
    )
    with pytest.raises(ScenarioError, match="is not computed in crossing"):
        RunSuite(suite, workers=1)


def test_metrics_of_recorded_people_are_told_where_there_are_none(suite):
    until = Until(metric="hand_overs", half_width=0.1)
    suite = dataclasses.replace(suite, until=until)
    with pytest.raises(ScenarioError, match="is not computed in crossing"):
        RunSuite(suite, workers=1)


def test_the_metric_of_the_progress_bar_is_one(hunav, tmp_path):
    code, _, err = hunav(
        *("bench", "paper", "--out", tmp_path, "--show", "path_lenght")
    )
    assert code == 2
    assert "did you mean 'path_length'" in err


def test_until_without_enough_seeds_is_told(hunav, tmp_path):
    words = ("bench", "paper", "--out", tmp_path / "out", "--seeds", "6")
    code, _, err = hunav(*words, "--until", "path_length=1.5")
    assert code == 2
    assert err == (
        "hunav: --until path_length=1.5: has an effect from 7 seeds on, and"
        " there are 6; give more, as with --seeds 100, or leave it out\n"
    )
    assert not (tmp_path / "out").exists()
    # Its own least number of seeds stays.
    file = tmp_path / "suite.yaml"
    file.write_text(
        "name: mine\nscenarios: [passing]\nseeds: 20\n"
        "until: {metric: path_length, half_width: 1.0, least: 20}\n"
    )
    words = ("bench", file, "--out", tmp_path / "out")
    code, _, err = hunav(*words, "--until", "path_length=1.5")
    assert code == 2
    assert "has an effect from 21 seeds on, and there are 20" in err


@pytest.mark.parametrize("page", ["", "file/page.md"])
def test_a_page_that_cannot_be_written_is_told_at_once(hunav, tmp_path, page):
    (tmp_path / "file").touch()
    page, out = tmp_path / page, tmp_path / "out"
    code, _, err = hunav("bench", "paper", "--markdown", page, "--out", out)
    assert code == 2
    assert err.startswith("hunav: --markdown ")
    assert not out.exists()


@pytest.mark.slow
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
