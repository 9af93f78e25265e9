from pathlib import Path
import shlex

import pytest

from hunav_drake.editor.worker.requests import (
    MAX_RUNS,
    RequestError,
    Run,
    read_request,
)


def test_nothing_chosen_is_one_run_as_the_scenario_says():
    request = read_request({"text": "{}", "seeds": [], "planners": None})
    assert request.seeds == (None,)
    assert request.planners == (None,)
    assert request.speed == 0.0
    assert request.workers == 1


def test_what_is_given_twice_counts_once():
    request = read_request({"text": "", "seeds": [3, 1, 3], "planners": ["a"]})
    assert request.seeds == (3, 1)


def test_there_are_no_more_workers_than_runs():
    assert read_request({"text": "", "seeds": [1], "workers": 8}).workers == 1


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"seeds": [-1]}, "seed"),
        ({"seeds": [True]}, "seed"),
        ({"seeds": [1.5]}, "seed"),
        ({"seeds": [2**63]}, "seed"),
        ({"seeds": [[1]]}, "seed"),
        ({"planners": [3]}, "planner"),
        ({"seeds": list(range(MAX_RUNS + 1))}, "at most"),
        ({"speed": -1}, "speed"),
        ({"speed": "fast"}, "speed"),
        ({"workers": -2}, "workers"),
    ],
)
def test_a_wrong_request_is_told_in_a_line(wrong, words):
    with pytest.raises(RequestError, match=words) as caught:
        read_request({"text": "", **wrong})
    assert "\n" not in str(caught.value)


def test_the_command_does_the_same_in_a_terminal():
    request = read_request(
        {"text": "", "filename": "my cafe.yaml", "name": "two"}
    )
    run = Run(number=1, request=request, seed=4, planner="dwb")
    assert shlex.split(run.command(Path("out"))) == [
        *("hunav", "run", "my cafe.yaml", "--name", "two"),
        *("--seed", "4", "--planner", "dwb", "--out", "out"),
    ]
    plain = Run(
        number=1, request=read_request({"text": ""}), seed=None, planner=None
    )
    assert plain.command(None) == "hunav run SCENARIO.yaml"
