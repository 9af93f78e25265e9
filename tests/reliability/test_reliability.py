"""Short forms of the tools beside; HUNAV_RELIABILITY=N makes them N times long.

With 100, that is some hours: 6000 mutated inputs, forks of all scenarios with
all planners and robots, and 200 kills of each command.
"""

import itertools
import os

import numpy as np
import pytest

from hunav_drake.scenarios import shipped_names
from tests.planners import NAMES
from tests.reliability import inputs, mutations
from tests.reliability.forks import ROBOTS, differing_forks, load_trial
from tests.reliability.inputs import KINDS
from tests.reliability.kills import COMMANDS, kill_at, prepare, run_through
from tests.reliability.mutated_inputs import Outcome, try_inputs, verdict
from tests.reliability.mutations import mutate_lines, mutate_text

LONG = int(os.environ.get("HUNAV_RELIABILITY", "1"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_inputs_that_nothing_is_wrong_with_are_accepted(
    kind, tmp_path, monkeypatch
):
    """Else their mutations would try nothing but the first check."""
    for name in dir(mutations):
        if name.startswith("mutate_"):
            monkeypatch.setattr(inputs, name, lambda rng, whole: whole)
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        folder = tmp_path / str(seed)
        folder.mkdir()
        steps = KINDS[kind](np.random.default_rng(seed), folder)
        assert verdict(steps, str(folder)) == ("accepted", "")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_mutated_inputs_end_cleanly(kind):
    outcomes = list(try_inputs(kind, range(7 * LONG)))
    assert len(outcomes) == 7 * LONG
    assert [it for it in outcomes if it.state == "unclean"] == []


def trials():
    """Returns which trials are forked: in the short form, each part once."""
    names, planners = shipped_names(), NAMES
    every = list(itertools.product(names, planners, ROBOTS))
    if LONG >= 100:
        return every
    few = [
        (names[i * 5 % len(names)], planner, ROBOTS[i % len(ROBOTS)])
        for i, planner in enumerate(planners)
    ]
    return few + every[:: max(1, len(every) // LONG)][1:]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*robot.radius")
@pytest.mark.parametrize("trial", trials(), ids="-".join)
def test_forks_end_as_the_trial_does(trial):
    scenario = load_trial(*trial, duration=0.5 if LONG == 1 else 10.0)
    if scenario is None:
        pytest.skip("these parts do not go together")
    assert list(differing_forks(scenario)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_what_is_saved_stays_whatever_kills_the_command(name, tmp_path):
    command = COMMANDS[name]
    whole = tmp_path / "whole"
    whole.mkdir()
    usual = run_through(command, prepare(whole))
    rng = np.random.default_rng(len(name))
    for i, part in enumerate(rng.uniform(0.1, 1.0, 2 * LONG)):
        folder = tmp_path / str(i)
        folder.mkdir()
        assert kill_at(command, prepare(folder), part * usual) == ""
        run_through(command, folder)


# The judge of the above: what it must find.


def interpreter_ends():
    raise SystemExit(1)


def accepted_only_first(*_):
    raise ValueError("no")


@pytest.mark.parametrize(
    ("steps", "state"),
    [
        ([["list"]], "accepted"),
        ([["check", "/nowhere.yaml"]], "refused"),
        ([["list"], ["run", "/nowhere.yaml"]], "unclean"),
        ([interpreter_ends], "unclean"),
        ([lambda: {}["a"]], "unclean"),
        ([accepted_only_first], "refused"),
    ],
)
def test_verdicts(steps, state):
    assert verdict(steps, "PLACE")[0] == state


@pytest.mark.slow
def test_crashes_and_hangs_are_found(monkeypatch):
    """Each is told of, and the inputs after it are still tried."""
    monkeypatch.setenv("PYTHONPATH", os.getcwd())
    monkeypatch.setattr("tests.reliability.mutated_inputs._HANG", 20.0)
    monkeypatch.setattr(
        "tests.reliability.mutated_inputs._MODULE",
        "tests.reliability.made_faults",
    )
    outcomes = list(try_inputs("crash", [1])) + list(try_inputs("hang", [2]))
    assert outcomes == [
        Outcome("crash", 1, "unclean", "a crash (-6)"),
        Outcome("hang", 2, "unclean", "a hang"),
    ]


def test_mutations_come_again():
    text = "humans:\n- {pose: [1, 2, 0]}\n- {pose: [3, 2, 0]}\n"
    for change in (mutate_text, mutate_lines):
        drawn = {change(np.random.default_rng(i), text) for i in range(40)}
        again = {change(np.random.default_rng(i), text) for i in range(40)}
        assert drawn == again
        assert len(drawn) > 10
