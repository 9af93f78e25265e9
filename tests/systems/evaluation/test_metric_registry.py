import subprocess
import sys

import numpy as np
import pytest
import yaml

from hunav_drake.systems.evaluation.compute import (
    compute_by_behavior,
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.evaluation.names import TABLE_I
from hunav_drake.systems.evaluation.recording import Recording

FAMILIES = {
    "path",
    "goal",
    "proxemics",
    "collisions",
    "speeds",
    "forces",
    "efficiency",
    "clearance",
    "comparison",
    "danger",
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


@pytest.fixture
def clean_registry():
    before = dict(METRICS)
    yield
    METRICS.clear()
    METRICS.update(before)


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
    with pytest.raises(ValueError, match="Families: goal, path, proxemics"):
        select_metrics(["xyzzy"])


@pytest.mark.usefixtures("clean_registry")
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


@pytest.mark.usefixtures("clean_registry")
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


@pytest.mark.usefixtures("clean_registry")
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
    assert table.shape == (0, len(METRICS))


def test_listing_metrics_needs_neither_drake_nor_pandas():
    code = (
        "import sys; import hunav_drake.systems.evaluation as e;"
        "assert len(e.METRICS) >= 28;"
        "late = {'pandas', 'hunav_drake.systems.evaluation.evaluator'};"
        "assert not late & set(sys.modules), late & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
