"""Metrics of recorded people, by hand."""

import numpy as np
import pytest

from hunav_drake.systems.evaluation import Recording, compute_metrics
from hunav_drake.systems.evaluation.metrics import METRICS

NAMES = [name for name, it in METRICS.items() if it.family == "replay"]


def recording(replay):
    samples, n = np.shape(replay)[:2]
    return Recording(
        times=np.arange(float(samples)),
        robot=np.zeros((samples, 7)),
        humans=np.zeros((samples, n, 7)) + 5.0,
        replay=replay,
    )


# One person who is handed over twice, and outlasts its recording; one who comes
# late; and one who is not recorded.
REPLAY = [
    [[1, 0, 0], [0, -1, -1], [0, -1, -1]],
    [[2, 0.2, 0.1], [0, -1, -1], [0, -1, -1]],
    [[1, 0.4, 0], [1, 0, 0], [0, -1, -1]],
    [[2, -1, 0.3], [1, 0, 0], [0, -1, -1]],
]


def test_values_by_hand():
    found = compute_metrics(recording(REPLAY), ["replay"])
    assert list(found.index) == NAMES
    assert found["replay_ade"] == pytest.approx(0.6 / 5)
    assert found["replay_fde"] == pytest.approx((0.4 + 0.0) / 2)
    assert found["replay_ade_at_phase"] == pytest.approx(0.4 / 6)
    assert found["replay_fde_at_phase"] == pytest.approx((0.3 + 0.0) / 2)
    assert found["hand_overs"] == 2
    assert found["reactive_share"] == pytest.approx(2 / 6)


def test_series_by_hand():
    dut = recording(REPLAY)
    _, errors = METRICS["replay_ade"].compute(dut)
    assert np.allclose(errors, [0, 0.2, 0.2, 0.0])
    _, switches = METRICS["hand_overs"].compute(dut)
    assert (switches == [0, 1, 1, 2]).all()
    _, share = METRICS["reactive_share"].compute(dut)
    assert np.allclose(share, [0, 1, 0, 0.5])


def test_nobody_recorded_is_here():
    found = compute_metrics(recording(np.array(REPLAY)[:, 2:]), NAMES)
    assert found["hand_overs"] == 0
    assert found.drop("hand_overs").isna().all()


def test_without_recorded_people_no_metric_has_a_value():
    dut = recording(REPLAY)
    plain = Recording(times=dut.times, robot=dut.robot, humans=dut.humans)
    assert not set(NAMES) & set(compute_metrics(plain).index)
    assert compute_metrics(plain, NAMES).isna().all()


def test_a_file_and_a_part_of_the_people_keep_them(tmp_path):
    dut = recording(REPLAY)
    dut.save(tmp_path / "one.npz")
    assert Recording.load(tmp_path / "one.npz") == dut
    assert (dut.only("regular").replay == dut.replay).all()
    longer = dut.with_stale_samples(2, 0.5)
    assert (longer.replay[-1] == dut.replay[-1]).all()
    with pytest.raises(ValueError, match=r"replay.*\(4, 3, 3\)"):
        recording_of_wrong_shape(dut)


def recording_of_wrong_shape(dut):
    return Recording(
        times=dut.times,
        robot=dut.robot,
        humans=dut.humans,
        replay=np.zeros((4, 2, 3)),
    )
