"""What users write is known to the command, too."""

import sys

import pytest

from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.evaluation import METRICS
from hunav_drake.systems.planning import PLANNERS

CODE = """
import numpy as np
from pydantic.dataclasses import dataclass
from hunav_drake.systems.behavior import register_condition
from hunav_drake.systems.crowd import MotionModel, register_motion_model

@register_motion_model("statues of {name}")
@dataclass
class Statues(MotionModel):
    patience: float = 2.0

    def forces(self, snapshot):
        return np.zeros((len(snapshot.states), 16))

    def advance(self, snapshot, forces):
        return snapshot.states

@register_condition("IsFullMoonOf{name}")
def is_full_moon(context):
    return False
"""


@pytest.fixture(autouse=True)
def parts_of_the_package():
    """What a test makes known is forgotten after it."""
    # (Loaded: what comes later would be forgotten, too.)
    parts = (METRICS, MOTION_MODELS._loaded(), PLANNERS._loaded())
    before = [dict(part) for part in parts]
    yield
    for part, known in zip(parts, before, strict=True):
        part.clear()
        part.update(known)


@pytest.fixture
def hunav(hunav, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path.copy())
    return hunav


@pytest.mark.parametrize("option", ["mine_by_file.py", "mine_by_name"])
def test_a_model_and_a_leaf_of_ones_own(hunav, tmp_path, option):
    name = option.removesuffix(".py")
    (tmp_path / f"{name}.py").write_text(CODE.format(name=name))
    tree = tmp_path / "tree.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="T">'
        f"<IsFullMoonOf{name}/></BehaviorTree></root>"
    )
    code, out, _ = hunav("tree", "check", "--import", option, "tree.xml")
    assert (code, out[:13]) == (0, "tree.xml: ok ")
    arguments = ("--set", f"crowd.model=statues of {name}")
    code, _, err = hunav("check", "passing", *arguments, "--import", option)
    assert code == 0, err
    code, _, err = hunav(
        *("check", "passing", *arguments, "--import", option),
        *("--set", "crowd.model.patienec=1"),
    )
    assert code == 2
    assert "unknown key; did you mean 'patience'?" in err


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("x = 1 / 0", "bad.py:1: ZeroDivisionError: division by zero"),
        ("def f(:", "SyntaxError"),
        (None, "No such file or directory"),
    ],
)
def test_code_that_cannot_be_imported_is_bad_input(
    hunav, tmp_path, content, words
):
    if content is not None:
        (tmp_path / "bad.py").write_text(content)
    code, _, err = hunav("run", "passing", "--import", "bad.py")
    assert code == 2
    assert err.startswith("hunav: --import bad.py: ")
    assert words in err
    assert len(err.splitlines()) == 1


def test_an_unknown_module_is_bad_input(hunav):
    code, _, err = hunav("check", "passing", "--import", "no_such_module")
    assert code == 2
    assert "No module named 'no_such_module'" in err


PLANNER = """
from pydantic.dataclasses import dataclass
from hunav_drake.systems.evaluation import register_metric
from hunav_drake.systems.planning import Planner, register_planner

@register_planner("{name}")
@dataclass
class Broken(Planner):
    def plan(self, task, view, memory):
        return {body}

@register_metric(name="{name}", unit="m", family="path", source="me")
def broken(recording):
    raise KeyError("nothing")
"""


def test_an_error_in_ones_own_code_is_told_in_a_line(hunav, tmp_path):
    (tmp_path / "mine_1.py").write_text(
        PLANNER.format(name="mine_1", body="view.robot[99]")
    )
    arguments = ("run", "passing", "--quiet", "--planner", "mine_1")
    code, _, err = hunav(*arguments, "--import", "mine_1.py")
    assert code == 1
    told = "hunav: planner 'mine_1' failed at t = 0.000 s: IndexError: index 99"
    # (And the metric of that file fails, too.)
    warning, line = err.splitlines()
    assert "warning: no value: metric 'mine_1'" in warning
    assert line.startswith(told)
    assert f"({tmp_path}/mine_1.py:10)" in line


def test_a_wrong_result_of_ones_own_model_is_no_bug_of_the_package(
    hunav, tmp_path
):
    (tmp_path / "mine_3.py").write_text(
        """
from dataclasses import dataclass
import numpy as np
from hunav_drake.systems.crowd import MotionModel, register_motion_model

@register_motion_model("undefined")
@dataclass
class Undefined(MotionModel):
    def forces(self, snapshot):
        return np.full((len(snapshot.states), 16), np.nan)

    def advance(self, snapshot, forces):
        return snapshot.states
"""
    )
    code, _, err = hunav(
        *("run", "passing", "--import", "mine_3.py"),
        *("--set", "crowd.model=undefined"),
    )
    assert code == 2
    assert "'undefined' must give finite numbers by forces()" in err
    assert "bug in hunav_drake" not in err


def test_a_metric_of_ones_own_that_fails_is_a_warning(hunav, tmp_path):
    (tmp_path / "mine_2.py").write_text(PLANNER.format(name="mine_2", body="1"))
    code, _, err = hunav("run", "passing", "--quiet", "--import", "mine_2.py")
    assert code == 0
    assert "hunav: warning: no value: metric 'mine_2': KeyError" in err
    assert "site-packages" not in err
    assert "simulation.py" not in err


@pytest.mark.parametrize("change", ["planner.type=mine", "crowd.model=mine"])
def test_what_is_unknown_may_be_imported(hunav, change):
    code, _, err = hunav("check", "passing", "--set", change)
    assert code == 2
    assert "import your own parts with --import FILE" in err
    code, _, err = hunav("check", "passing", "--set", "robot.radus=1")
    assert "--import" not in err
