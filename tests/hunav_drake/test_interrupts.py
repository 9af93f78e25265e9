import os
import signal
import threading

import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.trial.interrupts import interrupts_between_steps


@pytest.fixture(autouse=True)
def interrupts_are_heard():
    """Also where the tests were started with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupt_waits_for_the_end_of_a_step():
    steps = []

    def work():
        with interrupts_between_steps() as check:
            interrupt()
            steps.append("done")
            check()
            steps.append("not done")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert steps == ["done"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_in_the_last_step_is_not_lost():
    with pytest.raises(KeyboardInterrupt), interrupts_between_steps():
        interrupt()


def test_a_second_interrupt_does_not_wait():
    def work():
        with interrupts_between_steps():
            interrupt()
            interrupt()
            pytest.fail("still here")

    with pytest.raises(KeyboardInterrupt):
        work()


def test_without_an_interrupt_nothing_happens():
    with interrupts_between_steps() as check:
        check()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_another_handler_is_left_alone(monkeypatch):
    calls = []
    old = signal.signal(signal.SIGINT, lambda *_: calls.append(1))
    try:
        with interrupts_between_steps() as check:
            interrupt()
            check()
    finally:
        signal.signal(signal.SIGINT, old)
    assert calls == [1]


def test_a_thread_may_run_a_trial():
    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=1"]
    )
    results = []
    thread = threading.Thread(target=lambda: results.append(RunTrial(scenario)))
    thread.start()
    thread.join()
    assert results[0].end_reason == "timeout"


def test_a_trial_is_interrupted_between_steps():
    """Also when the signal comes while Drake is at work."""
    scenario = LoadScenario(
        filename="passing",
        overrides=["simulation.duration=86400", "robot.goal=null"],
    )
    timer = threading.Timer(0.3, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        RunTrial(scenario)
    timer.join()
