"""Damaged recordings and results: an error that says so, or finite metrics.

Mutations are drawn from a fixed seed, so that a failure comes again.
"""

import json
import warnings

import numpy as np
import pytest

from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.systems.evaluation.compute import (
    evaluate,
    evaluate_by_behavior,
)
from hunav_drake.systems.evaluation.metrics import select_metrics
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.recording_checks import LARGEST
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.result import MakeTrialResult
from tests.reliability.mutations import (
    mutate_array,
    mutate_bytes,
    mutate_json,
    mutate_table,
    pick,
)
from tests.reliability.recordings import hunavsim_messages, table_rows

# How often each kind of file is changed; more find more, and take longer.
ROUNDS = 60
NAMES = [metric.name for metric in select_metrics("all")]


def whole_recording(samples=6, **kwargs):
    rng = np.random.default_rng(1)
    humans = rng.normal(size=(samples, 2, 7)) * 2
    humans[..., 6] = 0.3
    humans[2, 0] = np.nan
    robot = rng.normal(size=(samples, 7))
    robot[:, 6] = 0.35
    settings = {
        "times": np.arange(samples) * 0.1,
        "robot": robot,
        "humans": humans,
        "behavior_status": rng.integers(0, 3, (samples, 2)),
        "behaviors": ("regular", "scared"),
        "group_ids": (1, 1),
        "goal": (1.0, 2.0, 0.5),
        "obstacles": Obstacles.from_shapes(
            [[[-3, -3], [-3, 3], [-4, 3]], [[5, 5]]], solid=[True, False]
        ),
        "nearest_walls": rng.normal(size=(samples, 3, 2, 2)),
        "reference_path": np.column_stack(
            [np.arange(3.0), rng.normal(size=(3, 2))]
        ),
    }
    return Recording(**(settings | kwargs))


def assert_finite(recording):
    """Computes all metrics, none of which may be infinite or raise."""
    with warnings.catch_warnings():
        # An overflow on the way to a finite value is no fault.
        warnings.simplefilter("ignore", RuntimeWarning)
        found = evaluate(recording, NAMES)
        metrics, steps = found.table(), found.steps()
        by_behavior = evaluate_by_behavior(recording, NAMES)
        tables = [steps, *(it.steps() for it in by_behavior.values())]
    assert not np.isinf(metrics).any(), metrics[np.isinf(metrics)]
    for table in tables:
        bad = np.isinf(table).any()
        assert not bad.any(), list(table.columns[bad])


def is_sound(path, read=ReadRecording):
    """Tells whether a file can be read; if so, its metrics are finite."""
    fault = ""
    try:
        recording = read(path)
    except ValueError as error:
        fault = str(error)
    if not fault:
        assert_finite(recording)
    assert not fault or str(path) in fault
    return not fault


def test_a_changed_npz(tmp_path):
    rng = np.random.default_rng(2)
    path = tmp_path / "a.npz"
    whole_recording().save(path)
    with np.load(path) as archive:
        whole = dict(archive)
    outcomes = []
    for _ in range(ROUNDS):
        arrays = dict(whole)
        for _ in range(rng.integers(1, 3)):
            name = pick(rng, list(whole))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    arrays[name] = mutate_array(rng, arrays[name])
                except (ValueError, TypeError):
                    del arrays[name]
                    break
        np.savez(path, **arrays)
        outcomes.append(is_sound(path))
    assert 0.1 < np.mean(outcomes) < 0.9


@pytest.mark.slow
def test_the_smallest_numbers():
    """What is next to nothing does not make what is divided by it infinite."""
    least = 5e-324
    moving = whole_recording()
    for scale in (0.0, least, 1e-160, 1e-20, 1e9):
        for radius in (0.0, 0.3, 1e9):
            robot, humans = moving.robot.copy(), moving.humans.copy()
            robot[:, :2] *= scale
            humans[..., :2] *= scale
            robot[:, 6] = radius
            humans[..., 6][~np.isnan(humans[..., 6])] = radius
            assert_finite(whole_recording(robot=robot, humans=humans))
    # Points that pass each other at the smallest distance there is.
    robot, humans = np.zeros((6, 7)), np.zeros((6, 2, 7))
    robot[:, 3] = 1.0
    humans[..., 0], humans[..., 1] = 1.0, least
    assert_finite(whole_recording(robot=robot, humans=humans))


@pytest.mark.parametrize("value", [1e9, 1e155, -1e308])
@pytest.mark.parametrize("name", ["robot", "humans", "goal"])
def test_the_largest_numbers(name, value):
    """Each is refused where it stands, or gives finite metrics."""
    whole = getattr(whole_recording(), name)
    for column in range(np.shape(whole)[-1]):
        array = np.array(whole)
        array[(-1,) * (array.ndim - 1) + (column,)] = value
        if abs(value) <= LARGEST:
            assert_finite(whole_recording(**{name: array}))
        else:
            with pytest.raises(ValueError, match=f"recording.{name}: "):
                whole_recording(**{name: array})


@pytest.mark.slow
def test_a_changed_csv(tmp_path):
    rng = np.random.default_rng(3)
    path = tmp_path / "a.csv"
    whole = table_rows(whole_recording(), 1)
    # A table without velocities has them worked out.
    bare = [row[:4] for row in whole]
    outcomes = []
    for i in range(ROUNDS):
        rows = mutate_table(rng, bare if i % 2 else whole)
        path.write_text("\n".join(map(",".join, rows)), encoding="utf-8")
        outcomes.append(is_sound(path))
    assert 0.1 < np.mean(outcomes) < 0.9


@pytest.mark.parametrize("name", ["a.npz", "a.csv", "a.csv.gz", "a.json"])
def test_changed_bytes(tmp_path, name):
    rng = np.random.default_rng(4)
    path = tmp_path / name
    recording = whole_recording()
    if name == "a.npz":
        recording.save(path)
        whole = path.read_bytes()
    elif name == "a.json":
        whole = json.dumps(hunavsim_messages(recording, 1)).encode()
    else:
        whole = "\n".join(map(",".join, table_rows(recording, 1))).encode()
    for _ in range(ROUNDS):
        path.write_bytes(mutate_bytes(rng, whole))
        is_sound(path)


def test_changed_messages(tmp_path):
    rng = np.random.default_rng(5)
    path = tmp_path / "a.json"
    whole = json.dumps(hunavsim_messages(whole_recording(), 1))
    outcomes = []
    for _ in range(ROUNDS):
        document = json.loads(whole)
        mutate_json(rng, document)
        path.write_text(json.dumps(document))
        outcomes.append(is_sound(path))
    assert 0.1 < np.mean(outcomes) < 0.9


def test_changed_folders_of_results(tmp_path):
    rng = np.random.default_rng(6)
    result = MakeTrialResult(
        whole_recording(),
        metric_names="path",
        provenance={"seed": 0, "planner": "pursuit"},
        end_reason="end",
    )
    path = WriteResult(result, tmp_path, tag="a") / "result.json"
    # A row of the log would stand for the file.
    (tmp_path / "runs.jsonl").unlink()
    whole = path.read_bytes()
    outcomes = []
    for i in range(ROUNDS):
        if i % 3:
            document = json.loads(whole)
            mutate_json(rng, document)
            path.write_text(json.dumps(document))
        else:
            path.write_bytes(mutate_bytes(rng, whole))
        damaged = {}
        results = LoadResults(tmp_path, damaged=damaged)
        outcomes.append(bool(results))
        if damaged:
            assert str(path) in damaged["a"]
            with pytest.raises(ValueError, match="Delete the damaged run"):
                ReadRuns(tmp_path)
        else:
            assert len(ReadRuns(tmp_path)) == 1
            ReadRuns(tmp_path, by_behavior=True)
            assert not np.isinf(results[0].metrics).any()
    assert 0.1 < np.mean(outcomes) < 0.9
