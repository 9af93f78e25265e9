"""An argument that is one of some texts is checked before anything runs."""

import re

import numpy as np
import pytest

from hunav_drake import (
    FitForces,
    LoadScenario,
    RunTrial,
    WriteResult,
    register_paired_metric,
)
from hunav_drake.systems.behavior import LoadBehavior, ParseTree
from hunav_drake.systems.people import HumanConfig, draw_weights
from hunav_drake.validation.recorded import judge_recorded

PERSON = HumanConfig(pose=[0, 0, 0], goals=[[1, 0]])


def paired(direction, left_out):
    return register_paired_metric("own", "m", direction, "here", left_out)


CALLS = {
    "on_planner_error: there is no 'rise'; did you mean 'raise'": lambda path: (
        RunTrial(LoadScenario("passing"), on_planner_error="rise")
    ),
    "format: there is no 'hunavsm'; did you mean 'hunav'": lambda path: (
        WriteResult(None, path, format="hunavsm")
    ),
    "goal: there is no 'trew'; did you mean 'true'": lambda path: FitForces(
        [np.zeros((1, 20, 2))], goal="trew"
    ),
    "goals: there is no 3; valid: ahead, true": lambda path: judge_recorded(
        "hall", [np.zeros((1, 20, 2))], {}, goals=[3]
    ),
    "profile: there is no 'hunvsim'; did you mean 'hunavsim'": lambda path: (
        LoadBehavior("regular", profile="hunvsim")
    ),
    "profile: there is no 'old'; valid: default, hunav_drake_0.1, hunavsim": (
        lambda path: ParseTree("<root/>", profile="old")
    ),
    "profile: there is no ['hunavsim']; valid: default": lambda path: (
        draw_weights([PERSON], 0, profile=["hunavsim"])
    ),
    "direction: there is no 'highr'; did you mean 'higher'": lambda path: (
        paired("highr", "people")
    ),
    "left_out: there is no 'all'; valid: people, robot": lambda path: paired(
        "lower", "all"
    ),
}


@pytest.mark.parametrize("told", CALLS)
def test_what_is_no_choice_is_refused(told, tmp_path):
    with pytest.raises(ValueError, match=f"^{re.escape(told)}"):
        CALLS[told](tmp_path)
    assert not [*tmp_path.iterdir()]
