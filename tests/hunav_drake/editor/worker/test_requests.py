from pathlib import Path
import shlex

from hunav_drake.editor.worker.requests import Run, RunRequest


def test_nothing_chosen_is_one_run_as_the_scenario_says():
    (run,) = RunRequest(text="{}").runs()
    assert (run.number, run.seed, run.planner) == (1, None, None)


def test_what_is_given_twice_counts_once():
    runs = RunRequest(text="", seeds=[3, 1, 3], planners=["a", "b"]).runs(7)
    assert [(it.planner, it.seed) for it in runs] == [
        *(("a", 3), ("a", 1), ("b", 3), ("b", 1))
    ]
    assert [it.number for it in runs] == [7, 8, 9, 10]


def test_the_command_does_the_same_in_a_terminal():
    request = RunRequest(text="", filename="my cafe.yaml", name="two")
    run = Run(number=1, request=request, seed=4, planner="dwb")
    assert shlex.split(run.command(Path("out"))) == [
        *("hunav", "run", "my cafe.yaml", "--name", "two"),
        *("--seed", "4", "--planner", "dwb", "--out", "out"),
    ]
    # (The option would replace the parameters of the scenario's own one.)
    command = run.command(None, own_planner=True, imports=["my own.py"])
    assert shlex.split(command) == [
        *("hunav", "run", "my cafe.yaml", "--name", "two"),
        *("--seed", "4", "--import", "my own.py"),
    ]
    (plain,) = RunRequest(text="").runs()
    assert plain.command(None) == "hunav run SCENARIO.yaml"
