import pandas as pd
import pytest

from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_table import ReadRuns, tabulate_runs
from hunav_drake.runs.settings import contenders, setting_text, short_settings
from hunav_drake.runs.statistics import compare, summarize
from hunav_drake.systems.evaluation.metrics import METRICS, register_metric
from hunav_drake.trial.metric_facts import (
    direction_of,
    family_of,
    is_built_in,
    unit_of,
)
from hunav_drake.trial.result import FormatMetricsTable
from tests.hunav_drake.passing_trials import make_result

SLOW = "planner.cruise_speed=0.3"
FAST = "planner.cruise_speed=0.7"


@pytest.fixture
def own_metric(restored_metrics):
    """Registers a metric, which the test may forget."""

    @register_metric(
        name="my_speed",
        unit="m/s",
        family="mine",
        source="me",
        direction="higher",
    )
    def my_speed(recording):
        """Returns how far the robot gets in a second."""
        return float(recording.robot[-1, 0] / recording.times[-1])

    return "my_speed"


# --- settings ---


def test_a_setting_is_what_was_changed_in_any_order():
    a, b = "robot.radius=0.3", "planner.cruise_speed = 0.5"
    told = "planner.cruise_speed=0.5; robot.radius=0.3"
    assert setting_text([a, b]) == setting_text([b, a]) == told
    # The last one counts, and other columns tell planner and seed.
    assert setting_text(["x=1", "x=2"]) == "x=2"
    assert setting_text(["planner.type=dwb", "simulation.seed=3"]) == ""
    assert setting_text([]) == ""


def test_a_setting_is_short_if_it_still_tells():
    assert short_settings([SLOW, FAST, ""]) == {
        SLOW: "cruise_speed=0.3",
        FAST: "cruise_speed=0.7",
        "": "",
    }
    assert short_settings(["humans[0].goals[1]=a.b; c.d=2", "v1.2"]) == {
        "humans[0].goals[1]=a.b; c.d=2": "goals[1]=a.b; d=2",
        "v1.2": "v1.2",
    }
    both = ["robot.radius=0.3", "planner.radius=0.3"]
    assert short_settings(both) == {text: text for text in both}


def test_contenders_have_one_name_each():
    runs = pd.DataFrame(
        {
            "planner": ["a", "a", "a", "a, b", "a"],
            "setting": ["", "x.b=1", "b", "", ""],
        }
    )
    names = list(contenders(runs))
    assert names == ["a", "a, b=1", "a, b", "a, b'", "a"]
    assert list(contenders(runs[["planner"]])) == list(runs["planner"])


def test_settings_are_kept_apart(tmp_path):
    for setting, speed in ((SLOW, 0.3), (FAST, 0.7)):
        for seed in range(6):
            result = make_result(seed=seed, setting=setting, speed=speed)
            WriteResult(result, tmp_path)
    runs = ReadRuns(tmp_path)
    assert list(runs["setting"].unique()) == [SLOW, FAST]
    table = summarize(runs).loc["passing", "pursuit"]
    assert table.loc[(SLOW, "path_length"), "n"] == 6
    # The mean over seeds 0 to 5 of speed + 0.01 seed, in one second.
    for setting, speed in ((SLOW, 0.3), (FAST, 0.7)):
        mean = table.loc[(setting, "path_length"), "mean"]
        assert mean == pytest.approx(speed + 0.025)
    row = compare(runs, SLOW, FAST, on="setting").loc["passing", "path_length"]
    assert row["difference"] == pytest.approx(0.4)
    assert row["better"] == SLOW
    with pytest.raises(ValueError, match="more than one run with"):
        compare(runs.assign(planner=["a"] * 11 + ["b"]), "a", "b")


def test_a_label_is_a_setting(tmp_path):
    WriteResult(make_result(setting="x"), tmp_path, tag="a")
    WriteResult(make_result(setting="x"), tmp_path, tag="b", label="mine")
    WriteResult(make_result(), tmp_path, tag="c")
    assert [r.setting for r in LoadResults(tmp_path)] == ["x", "mine", ""]
    assert list(ReadRuns(tmp_path)["setting"]) == ["x", "mine", ""]
    assert "setting mine" in FormatMetricsTable(LoadResults(tmp_path)[1])


def test_runs_without_settings_can_be_read_beside_others(tmp_path):
    old = WriteResult(make_result(), tmp_path, tag="old") / "result.json"
    text = old.read_text()
    old.write_text(text.replace('"setting": "",', ""))
    assert old.read_text() != text
    assert [result.setting for result in LoadResults(tmp_path)] == [""]
    table = summarize(ReadRuns(tmp_path))
    assert table.index.names == ["scenario", "planner", "metric"]
    WriteResult(make_result(seed=1, setting=SLOW), tmp_path, tag="slow")
    runs = ReadRuns(tmp_path)
    assert list(runs["setting"]) == ["", SLOW]
    assert "setting" in summarize(runs).index.names
    assert len(LoadResults(tmp_path)) == 2


# --- what is known of metrics ---


def test_all_of_this_package_are_built_in(own_metric):
    assert [n for n in METRICS if not is_built_in(n)] == [own_metric]
    assert not is_built_in("nothing")


def test_a_metric_of_ones_own_is_known_without_its_code(tmp_path, own_metric):
    names = ["path_length", own_metric]
    for seed in range(6):
        for label, speed in (("a", 0.5), ("b", 0.7)):
            WriteResult(
                make_result(seed=seed, metric_names=names, speed=speed),
                tmp_path,
                label=label,
            )
    del METRICS[own_metric]
    results = LoadResults(tmp_path)
    runs = tabulate_runs(results)
    for table in (results[0].metrics, runs):
        assert unit_of(table, own_metric) == "m/s"
        assert family_of(table, own_metric) == "mine"
        assert direction_of(table, own_metric) == "higher"
        # The registry knows better.
        table.attrs["units"]["path_length"] = "km"
        assert unit_of(table, "path_length") == "m"
    compared = compare(runs, "a", "b", on="setting").loc["passing"]
    assert compared.loc[own_metric, "better"] == "b"
    assert compared.attrs["units"][own_metric] == "m/s"
    assert "mine" in FormatMetricsTable(results[0]).splitlines()
