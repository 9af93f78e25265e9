"""What users write is known to the command, too."""

import sys

import pytest

from hunav_drake import cli

CODE = """
import numpy as np
from pydantic.dataclasses import dataclass
from hunav_drake.systems.behavior import register_condition
from hunav_drake.systems.crowd import register_motion_model

@register_motion_model("statues of {name}")
@dataclass
class Statues:
    patience: float = 2.0

    def forces(self, snapshot):
        return np.zeros((len(snapshot.states), 16))

    def advance(self, snapshot, forces):
        return snapshot.states

@register_condition("IsFullMoonOf{name}")
def is_full_moon(moment):
    return False
"""


@pytest.fixture
def hunav(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path.copy())

    def run(*arguments):
        code = cli.main(arguments)
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


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
        *("--set", "crowd.parameters={patienec: 1}"),
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
