"""The kernels of a trial are compiled in several processes."""

import dataclasses
import importlib
import subprocess
import time

import pytest

from hunav_drake import LoadScenario
from hunav_drake.runs import compiling_ahead as dut
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.planning import PLANNERS
from tests.choices import shipped

# A small kernel.
DISCS = "robot.discs.touch_discs"


@pytest.fixture
def started(monkeypatch):
    """Returns the processes that are started in the test."""
    processes = []

    class Popen(subprocess.Popen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            processes.append(self)

    monkeypatch.setattr(dut.subprocess, "Popen", Popen)
    monkeypatch.setattr(dut, "_num_processors", lambda: 3)
    return processes


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


@pytest.mark.parametrize("model", shipped(MOTION_MODELS))
def test_so_it_is_for_each_motion_model(model):
    robot = "robot: {start: [0, 0, 0]}"
    scenario = LoadScenario(data=robot, overrides=[f"crowd.model={model}"])
    scene = dataclasses.replace(scenario, sensors=LoadScenario("cafe").sensors)
    for it in dut.kernels_of(scene):
        module, _, kernel = f"hunav_drake.systems.{it}".rpartition(".")
        found = getattr(importlib.import_module(module), kernel)
        assert callable(found.compile_once), it


@pytest.mark.slow
def test_other_processes_compile_and_end_with_the_block(
    tmp_path, monkeypatch, started
):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(dut, "kernels_of", lambda *_: [DISCS])
    with dut.compiling_ahead(LoadScenario("passing")):
        end = time.monotonic() + 100
        while not any(tmp_path.rglob("discs.touch_discs*.nbc")):
            assert time.monotonic() < end
            time.sleep(0.1)
    assert len(started) == 2
    assert all(it.poll() is not None for it in started)


def test_a_block_that_fails_leaves_no_process(started):
    def interrupted():
        with dut.compiling_ahead(LoadScenario("passing")):
            assert [it.poll() for it in started] == [None, None]
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert all(it.poll() is not None for it in started)


@pytest.mark.parametrize(
    ("name", "value"), [("_num_processors", 1), ("keeps_code", False)]
)
def test_where_they_cannot_help_there_are_no_other_processes(
    monkeypatch, started, name, value
):
    monkeypatch.setattr(dut, name, lambda: value)
    with dut.compiling_ahead(LoadScenario("passing")):
        assert not started


def test_a_process_that_cannot_be_started_is_done_without(monkeypatch):
    def refuse(*_, **__):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(dut.subprocess, "Popen", refuse)
    monkeypatch.setattr(dut, "_num_processors", lambda: 3)
    ran = []
    with dut.compiling_ahead(LoadScenario("passing")):
        ran.append(True)
    assert ran
