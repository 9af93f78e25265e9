"""Planners of one's own: what is checked, limited and measured."""

import contextlib
import pickle
import signal
import sys
import threading
import time

from pydantic.dataclasses import dataclass
import pytest

from hunav_drake.systems.planning import (
    PLANNERS,
    LocalPlanner,
    Plan,
    Planner,
    PlannerError,
    PlannerStatus,
    PursuitPlanner,
    register_plan,
    register_planner,
    time_cycles,
)
from tests.systems.planning.test_local_planner import (
    make_planner_simulator,
    make_task,
    velocity_command,
)

STOP = Plan(0.0, 0.0, PlannerStatus.DRIVING)


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


def run(planner, until=0.1):
    dut = LocalPlanner(planner, make_task())
    simulator = make_planner_simulator(dut)
    simulator.AdvanceTo(until)
    return velocity_command(dut, simulator.get_context())


# A module-level function, as pickle needs it.
def turn(task, view, memory):
    """Turns on the spot, faster and faster."""
    return Plan(0.0, 0.1 * memory, PlannerStatus.DRIVING, memory + 1)


def test_a_function_is_a_planner():
    assert register_plan("turn", initial_memory=1)(turn) is turn
    planner = PLANNERS.make({"type": "turn", "period": 0.1})
    assert run(planner, 0.31) == [0.0, 0.4]
    assert pickle.loads(pickle.dumps(planner)) == planner
    # Again, as in a notebook.
    register_plan("turn", initial_memory=1)(turn)


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (
            lambda task, view: STOP,
            r"\(task, view, memory\), got \(task, view\)",
        ),
        (lambda: STOP, r"must take \(task, view, memory\), got \(\)"),
        (17, r"must be a function .*got 17"),
    ],
)
def test_a_function_takes_what_planners_take(function, words):
    with pytest.raises(TypeError, match=words):
        register_plan("wrong")(function)
    assert "wrong" not in PLANNERS


def test_a_method_takes_what_planners_take():
    with pytest.raises(
        TypeError, match=r"Wrong.plan\(\) must take \(self, task"
    ):

        class Wrong(Planner):
            def plan(self, view):
                return STOP

    with pytest.raises(TypeError, match=r"plain method .*got a staticmethod"):

        class Static(Planner):
            @staticmethod
            def plan(task, view, memory):
                return STOP

    class Free(Planner):
        def plan(self, *whatever, **more):
            return STOP

    assert run(Free()) == [0, 0]


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        ({"initial_memory": [1]}, r"initial_memory: it must .*got \[1\]"),
        ({"scan_size": 2.5}, "scan_size must be a whole number.*got 2.5"),
        ({"scan_size": -1}, "scan_size must be a whole number.*got -1"),
    ],
)
def test_what_a_class_declares_is_checked(declared, words):
    def plan(self, task, view, memory):
        return STOP

    wrong = type("Wrong", (Planner,), {"plan": plan, **declared})
    with pytest.raises(TypeError, match=rf"planner 'Wrong': {words}"):
        LocalPlanner(wrong(), make_task())


def test_an_error_tells_planner_time_and_place():
    @register_planner("dividing")
    @dataclass
    class Dividing(Planner):
        def plan(self, task, view, memory):
            return 1 / 0

    with pytest.raises(PlannerError) as info:
        run(Dividing())
    error = info.value
    assert (error.planner, error.time) == ("dividing", 0.0)
    assert error.reason.startswith("ZeroDivisionError: division by zero (")
    assert __file__ in error.reason
    assert isinstance(error.__cause__, ZeroDivisionError)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


class Endless(Planner):
    """Never decides."""

    def plan(self, task, view, memory):
        while True:
            pass


class Sleepy(Planner):
    """Takes 30 ms, whatever is raised meanwhile."""

    def plan(self, task, view, memory):
        done = time.monotonic() + 0.03
        while time.monotonic() < done:
            with contextlib.suppress(Exception):
                time.sleep(0.001)
        return STOP


def test_a_cycle_that_hangs_is_ended():
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(PlannerError, match=r"longer than cycle_limit = 0.05 s"):
        run(Endless(cycle_limit=0.05))
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    with pytest.raises(PlannerError, match=r"cycle_limit = 0.01 s"):
        run(Sleepy(cycle_limit=0.01))
    assert run(Sleepy(cycle_limit=30.0)) == [0, 0]


def test_another_thread_is_told_afterwards():
    told = []

    def work():
        try:
            run(Sleepy(cycle_limit=0.01))
        except PlannerError as error:
            told.append(error.reason)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert told == ["a cycle took longer than cycle_limit = 0.01 s"]


def test_a_limit_that_is_kept_changes_nothing():
    signal.setitimer(signal.ITIMER_REAL, 1000.0)
    try:
        assert run(PursuitPlanner(cycle_limit=100.0)) == run(PursuitPlanner())
        # Somebody else's alarm is still set.
        assert 900 < signal.getitimer(signal.ITIMER_REAL)[0] <= 1000
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    with pytest.raises(ValueError, match="cycle_limit"):
        PursuitPlanner(cycle_limit=0.0)


def test_cycles_are_timed():
    with time_cycles() as times:
        run(Sleepy(), 0.01)
        assert len(times) == 1
        with time_cycles() as more:
            run(Sleepy(period=0.1), 0.25)
    assert len(more) == 3
    assert len(times) == 4
    assert times[1:] == more
    assert all(0.03 <= seconds < 10 for seconds in times)
    run(Sleepy(), 0.01)
    assert len(times) == 4


MODULE = """
from pydantic.dataclasses import dataclass
from hunav_drake.systems.planning import Plan, Planner, PlannerStatus

@dataclass
class Steady(Planner):
    speed: float = 0.3

    def plan(self, task, view, memory):
        return Plan(self.speed, 0.0, PlannerStatus.DRIVING)

class NoPlanner:
    pass
"""


@pytest.fixture
def own_module(tmp_path, monkeypatch):
    (tmp_path / "own_planner_module.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield "own_planner_module"
    sys.modules.pop("own_planner_module", None)


def test_a_class_is_named_by_its_place(own_module):
    name = f"{own_module}:Steady"
    planner = PLANNERS.make({"type": name, "speed": 0.4})
    assert run(planner) == [0.4, 0.0]
    assert PLANNERS.find(name) is type(planner)
    assert PLANNERS.make(name).speed == 0.3
    with pytest.raises(ValueError, match="speed"):
        PLANNERS.make({"type": name, "speed": "fast"})


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("Nothing", "AttributeError: module .* has no attribute 'Nothing'"),
        ("NoPlanner", "a planner is a dataclass"),
    ],
)
def test_a_place_without_a_planner_is_told(own_module, place, words):
    with pytest.raises(ValueError, match=words):
        PLANNERS.make(f"{own_module}:{place}")
    with pytest.raises(ValueError, match="No module named 'no_such_module'"):
        PLANNERS.make("no_such_module:Steady")
    assert PLANNERS.find(f"{own_module}:{place}") is None
