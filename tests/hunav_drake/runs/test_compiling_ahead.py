"""The kernels of a trial are compiled in several processes."""

import importlib
import multiprocessing
import time

import pytest

from hunav_drake import LoadScenario
from hunav_drake.runs import compiling_ahead as dut
from hunav_drake.systems.planning import PLANNERS
from tests.choices import shipped

# A small kernel.
DISCS = "robot.discs.touch_discs"


@pytest.fixture
def started():
    """Returns the processes that were started in the test."""
    before = {*multiprocessing.active_children()}
    return lambda: {*multiprocessing.active_children()} - before


@pytest.mark.parametrize("name", ["passing", "cafe", "fleet"])
@pytest.mark.parametrize("planner", shipped(PLANNERS))
def test_each_name_is_that_of_a_kernel(name, planner):
    scenario = LoadScenario(name, overrides=[f"planner.type={planner}"])
    names = dut.kernels_of(scenario)
    assert len(set(names)) == len(names) >= 10
    for it in names:
        module, _, kernel = f"hunav_drake.systems.{it}".rpartition(".")
        found = getattr(importlib.import_module(module), kernel)
        assert callable(found.compile_once), it


def test_a_trial_has_the_kernels_of_its_choices():
    passing = dut.kernels_of(LoadScenario("passing"))
    cafe = dut.kernels_of(LoadScenario("cafe", overrides=["planner.type=dwb"]))
    assert passing[0].endswith("hunavsim_step")
    assert cafe[0].endswith("whole_step")
    only_cafe = {
        "world.waypoints.guided",
        "planning.dwb.weighing.weigh_samples",
    }
    assert only_cafe <= {*cafe} - {*passing}
    # A map has walls, too.
    assert "world.waypoints.guided" in dut.kernels_of(LoadScenario("house"))


@pytest.mark.slow
def test_another_process_compiles_and_ends_with_the_block(
    tmp_path, monkeypatch, started
):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(dut, "kernels_of", lambda _: [DISCS])
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    with dut.compiling_ahead(LoadScenario("passing")):
        (worker,) = started()
        end = time.monotonic() + 100
        while not any(tmp_path.rglob("discs.touch_discs*.nbc")):
            assert time.monotonic() < end
            time.sleep(0.1)
    worker.join(20)
    assert not worker.is_alive()


@pytest.mark.slow
def test_a_block_that_fails_leaves_no_process(monkeypatch, started):
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    workers = []

    def interrupted():
        with dut.compiling_ahead(LoadScenario("passing")):
            workers.extend(started())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert workers
    for worker in workers:
        worker.join(20)
        assert not worker.is_alive()


def test_with_one_processor_there_is_no_other_process(monkeypatch, started):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(dut, "WorkerPool", None)
    with dut.compiling_ahead(LoadScenario("passing")):
        assert not started()
