import functools
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import yaml

from hunav_drake.commands.cli import main
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_table import WriteTables
from hunav_drake.systems.evaluation.compute import (
    compute_by_behavior,
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.metric import (
    RESERVED,
    TABLE_I,
    register_metric,
)
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.result import MakeTrialResult

FAMILIES = {
    "path",
    "goal",
    "proxemics",
    "collisions",
    "contacts",
    "fleet",
    "speeds",
    "forces",
    "efficiency",
    "clearance",
    "comparison",
    "smoothness",
    "danger",
    "replay",
    "surprise",
}


@pytest.fixture
def recording():
    robot = np.zeros((4, 7))
    robot[:, 0] = np.arange(4)
    return Recording(
        times=np.arange(4.0),
        robot=robot,
        humans=np.full((4, 3, 7), 5.0),
        behaviors=("scared", "regular", "scared"),
    )


def test_the_papers_28_are_there_in_its_order():
    assert [m.name for m in select_metrics(["paper"])] == list(TABLE_I)
    assert len(set(TABLE_I)) == 28


@pytest.mark.parametrize("name", list(METRICS))
def test_each_metric_says_what_it_is(name):
    metric = METRICS[name]
    assert metric.name == name
    assert len(metric.definition) > 30
    assert metric.unit
    assert metric.source
    assert metric.family in FAMILIES
    assert metric.direction in ("lower", "higher", "none")


def test_names_of_the_original_configuration_are_known(reference):
    text = (reference / "hunav/metrics.yaml").read_text()
    settings = yaml.safe_load(text)["hunav_evaluator_node"]["ros__parameters"]
    assert len(select_metrics(settings["metrics"])) == 28


def test_selection_keeps_the_order_and_takes_each_once():
    names = ["path_length", "minimum_distance_to_people", "path", "duration"]
    assert [m.name for m in select_metrics(names)] == [
        "path_length",
        "min_dist_to_people",
        "cumulative_heading_changes",
        "duration",
    ]
    assert select_metrics([]) == []
    assert select_metrics("duration") == select_metrics(["duration"])
    assert len(select_metrics(["all"])) == len(METRICS)


@pytest.mark.parametrize(
    ("name", "near"),
    [("path_lenght", "path_length"), ("speed", "speeds"), ("al", "all")],
)
def test_an_unknown_name_gets_the_nearest(name, near):
    with pytest.raises(ValueError, match=f"'{name}'; did you mean '{near}'"):
        select_metrics(["duration", name])


def test_an_unknown_name_far_from_all_gets_the_families():
    with pytest.raises(ValueError, match="; families: goal, path, proxemics"):
        select_metrics(["xyzzy"])


@pytest.mark.usefixtures("restored_metrics")
def test_a_metric_of_the_users_own(recording):
    @register_metric(
        name="my_speed", unit="m/s", family="mine", source="me", aliases=["ms"]
    )
    def my_speed(recording: Recording) -> tuple[float, np.ndarray]:
        """The last of my speeds, whatever they are."""
        return 3.0, recording.times

    assert my_speed(recording)[0] == 3.0
    assert METRICS["my_speed"].definition.startswith("The last of")
    assert compute_metrics(recording, ["ms"])["my_speed"] == 3.0
    assert compute_steps(recording, ["mine"])["my_speed"].iloc[-1] == 3.0
    assert "my_speed" in compute_metrics(recording)


@pytest.mark.usefixtures("restored_metrics")
@pytest.mark.parametrize(
    "kwargs",
    [
        {"name": "path_length"},
        {"name": "minimum_distance_to_people"},
        {"name": "goal"},
        {"name": "all"},
        {"name": "new", "aliases": ["completed"]},
    ],
)
def test_a_taken_name_is_an_error(kwargs):
    register = register_metric(unit="m", family="path", source="me", **kwargs)
    with pytest.raises(ValueError, match="is taken"):
        register(lambda recording: 0.0)


@pytest.mark.usefixtures("restored_metrics")
def test_a_series_of_the_wrong_length_is_an_error(recording):
    register_metric(
        name="bad", unit="m", family="path", source="me", reduce=np.sum
    )(lambda recording: recording.times[1:])
    with pytest.raises(ValueError, match="'bad': its series must have"):
        compute_metrics(recording, ["bad"])


def test_tables_have_units_and_times(recording):
    steps = compute_steps(recording)
    assert steps.index.name == "time"
    assert steps.index.tolist() == [0, 1, 2, 3]
    assert set(steps.attrs["units"]) == set(steps.columns)
    values = compute_metrics(recording)
    assert values.attrs["units"]["avg_robot_jerk"] == "m/s^3"
    assert list(values.index) == list(values.attrs["units"])


def test_metrics_without_series_give_an_empty_table(recording):
    steps = compute_steps(recording, ["duration"])
    assert steps.shape == (4, 0)


def test_by_behavior_has_a_row_for_each_behavior(recording):
    table = compute_by_behavior(recording, ["path", "completed"])
    assert table.index.tolist() == ["scared", "regular"]
    assert (table["path_length"] == 3).all()
    assert table["completed"].isna().all()


def test_by_behavior_of_nobody_is_empty():
    recording = Recording(
        times=[0.0], robot=np.zeros((1, 7)), humans=np.zeros((1, 0, 7))
    )
    table = compute_by_behavior(recording)
    # All but those of recorded people.
    assert table.shape == (0, len(select_metrics("all", recording)))
    assert not any(name.startswith("replay") for name in table)
    assert "replay_ade" in compute_by_behavior(recording, ["replay_ade"])


@pytest.mark.parametrize(
    "command",
    [
        "import hunav_drake.systems.evaluation as e; e.select_metrics('all')",
        "from hunav_drake.commands.cli import main; main(['metrics'])",
        "from hunav_drake.commands.cli import main;"
        " main(['metrics', 'show', 'all'])",
    ],
)
def test_listing_metrics_needs_neither_drake_nor_pandas_nor_numba(command):
    code = (
        f"import sys; {command};"
        "late = {'pydrake', 'pandas', 'numba', 'scipy'} & set(sys.modules);"
        "assert not late, late"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# A cell of a notebook: run again, it defines its function anew.
CELL = """
@register_metric(name="my_speed", unit=unit, family="mine", source="me")
def my_speed(recording):
    'The last of my speeds, whatever they are.'
    return speed
"""


def run_metric_cell(cell=CELL, speed=3.0, unit="m/s"):
    names = {"register_metric": register_metric, "speed": speed, "unit": unit}
    exec(cell, names | {"__name__": "__main__"})


@pytest.mark.usefixtures("restored_metrics")
def test_a_cell_that_runs_again_replaces_its_metric(recording):
    run_metric_cell()
    order = list(METRICS)
    run_metric_cell(speed=5.0, unit="km/h")
    assert list(METRICS) == order
    assert METRICS["my_speed"].unit == "km/h"
    assert compute_metrics(recording, ["my_speed"])["my_speed"] == 5
    other = CELL.replace("def my_speed", "def another")
    with pytest.raises(ValueError, match="'my_speed' is taken, by metric"):
        run_metric_cell(other)
    assert METRICS["my_speed"].function.__name__ == "my_speed"
    # Its alias is its own, too, but not its name under another.
    with_alias = CELL.replace("unit=unit", "unit=unit, aliases=['ms']")
    run_metric_cell(with_alias)
    run_metric_cell(with_alias)
    with pytest.raises(ValueError, match="'ms' is taken, by metric 'my_sp"):
        run_metric_cell(CELL.replace('name="my_speed"', 'name="ms"'))


@pytest.mark.usefixtures("restored_metrics")
@pytest.mark.parametrize("name", RESERVED)
def test_a_column_of_the_tables_is_no_metric(name):
    for kwargs in ({"name": name}, {"name": "new", "aliases": [name]}):
        with pytest.raises(ValueError, match=f"have a column {name!r} already"):
            register(**kwargs)
    assert "new" not in METRICS


def test_all_other_columns_of_the_tables_are_reserved(tmp_path, recording):
    result = MakeTrialResult(recording, provenance={}, end_reason="end")
    WriteResult(result, tmp_path)
    WriteTables(LoadResults(tmp_path), tmp_path)
    paths = list(tmp_path.rglob("*.csv"))
    assert {"steps.csv", "runs.csv", "runs_by_behavior.csv"} <= {
        path.name for path in paths
    }
    for path in paths:
        columns = set(pd.read_csv(path).columns)
        assert columns - set(METRICS) <= set(RESERVED), path.name


def register(**kwargs):
    settings = {"name": "new", "unit": "m", "family": "mine", "source": "me"}
    register_metric(**(settings | kwargs))(lambda recording: 0.0)


@pytest.mark.usefixtures("restored_metrics")
@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"name": ""}, "a text without blanks.*got ''"),
        ({"name": "a b"}, "a text without blanks.*got 'a b'"),
        ({"name": "a,b"}, "a text without blanks.*got 'a,b'"),
        ({"name": "a\nb"}, "a text without blanks"),
        ({"name": 3}, "a text without blanks.*got 3"),
        ({"direction": "Lower"}, "direction must be one of.*'Lower'; did you"),
        ({"direction": None}, "direction must be one of.*None"),
        ({"unit": ""}, "unit, family and source must be texts"),
        ({"unit": 1}, "unit, family and source must be texts.*got 1"),
        ({"family": None}, "unit, family and source must be texts"),
        ({"family": "new"}, "family must not be the name of something"),
        ({"family": "path_length"}, "family must not be the name"),
        ({"family": "all"}, "family must not be the name"),
        ({"reduce": "mean"}, "reduce must be a function.*got 'mean'"),
    ],
)
def test_what_cannot_be_registered_is_told(kwargs, message):
    with pytest.raises(ValueError, match=f"(?s)metric .*{message}"):
        register(**kwargs)


@pytest.mark.usefixtures("restored_metrics")
def test_what_is_no_function_or_has_no_name_is_no_metric():
    for thing in (5, functools.partial(register, name="new")):
        decorate = register_metric(unit="m", family="mine", source="me")
        with pytest.raises(ValueError, match="a metric is a function of a rec"):
            decorate(thing)


@pytest.mark.usefixtures("restored_metrics")
def test_an_alias_may_be_one_text():
    register(aliases="newer")
    assert select_metrics("newer")[0].aliases == ("newer",)


@pytest.mark.usefixtures("restored_metrics")
def test_a_metric_without_a_definition_can_be_listed(capsys):
    register()
    assert main(["metrics"]) == 0
    assert main(["metrics", "show", "new"]) == 0
    assert capsys.readouterr().out.count("(no description)") == 2


@pytest.mark.usefixtures("restored_metrics")
@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda r: 1 / 0, "ZeroDivisionError: division by zero"),
        (lambda r: r.nothing, "AttributeError"),
        (lambda r: None, "its value must be a number.*got None"),
        (lambda r: "3", "its value must be a number.*got '3'"),
        (lambda r: 1j, "its value must be a number"),
        (lambda r: r.times, "registered with `reduce`; got array"),
        (lambda r: [1.0] * 4, "registered with `reduce`; got "),
        (lambda r: (1.0, r.times, 2), "got 3 things"),
        (lambda r: (r.times, 1.0), "its value must be a number"),
        (lambda r: (1.0, r.times[1:]), r"each of 4 samples, got the shape"),
        (lambda r: (1.0, None), r"each of 4 samples, got the shape \(\)"),
        (lambda r: (1.0, ["a"] * 4), "series must be of numbers"),
        (lambda r: (1.0, r.times * 1j), "series must be of numbers"),
    ],
)
def test_what_a_metric_does_wrong_names_it(recording, function, message):
    register_metric(name="bad", unit="m", family="mine", source="me")(function)
    with pytest.raises(ValueError, match=f"(?s)metric 'bad': .*{message}"):
        compute_metrics(recording, ["bad"])


@pytest.mark.usefixtures("restored_metrics")
def test_a_reduction_that_gives_no_number_names_its_metric(recording):
    register_metric(
        name="bad", unit="m", family="mine", source="me", reduce=np.diff
    )(lambda recording: recording.times)
    with pytest.raises(ValueError, match="metric 'bad': its value must be"):
        compute_metrics(recording, ["bad"])


@pytest.mark.usefixtures("restored_metrics")
@pytest.mark.parametrize(
    ("result", "expected"),
    [(True, 1), (np.int64(3), 3), (np.array(2.5), 2.5), (np.float32(1), 1)],
)
def test_any_real_number_is_a_value(recording, result, expected):
    register_metric(name="good", unit="m", family="mine", source="me")(
        lambda recording: (result, [True, False, True, 2])
    )
    value, series = METRICS["good"].compute(recording)
    assert value == expected
    assert type(value) is float
    assert series.dtype == float
    assert series.tolist() == [1, 0, 1, 2]


def test_the_first_line_of_each_definition_tells_it_from_others():
    firsts = {}
    for metric in METRICS.values():
        first = metric.definition.splitlines()[0]
        assert len(first) <= 72
        assert first.endswith(".")
        assert first not in firsts, (metric.name, firsts[first])
        firsts[first] = metric.name
