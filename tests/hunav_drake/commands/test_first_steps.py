"""A newcomer's first steps: a scenario of one's own, examples, completion."""

import shlex
import shutil
import subprocess
import sys
import time

import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.commands.cli import _all_commands, _make_parser, main
from hunav_drake.commands.options import AFTER_INTERRUPT, EXAMPLES
from hunav_drake.scenario.templates import list_templates, template_text
from tests.processes import press_ctrl_c, start_hunav


@pytest.mark.parametrize("name", list_templates())
def test_a_template_is_sound_and_says_what_it_is(name, hunav, tmp_path):
    path = tmp_path / "mine"
    code, out, _ = hunav("new", path, "--template", name)
    assert code == 0
    assert f"hunav run {path}.yaml" in out
    text = path.with_suffix(".yaml").read_text()
    assert text.count("#") >= 8
    assert "FILE" not in text
    code, out, err = hunav("check", f"{path}.yaml")
    assert (code, err) == (0, "")
    for line in text.splitlines():
        assert len(line) <= 80


@pytest.mark.parametrize("name", ["corridor", "crossing"])
def test_a_robot_arrives_in_it(name):
    scenario = LoadScenario(data=template_text(name))
    assert RunTrial(scenario).end_reason == "goal"


def test_a_file_is_not_lost_by_a_new_one(hunav, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("own: work")
    code, _, err = hunav("new", path)
    assert code == 2
    assert "--force" in err
    assert path.read_text() == "own: work"
    assert hunav("new", path, "--force")[0] == 0
    code, _, err = hunav("new", tmp_path / "b", "--template", "corridr")
    assert code == 2
    assert "did you mean 'corridor'" in err
    for name in (".", "..", tmp_path / "no" / "folder"):
        code, _, err = hunav("new", name)
        assert code == 2
        assert len(err.splitlines()) == 1
        assert "name, such as" in err or "make it first" in err


def test_each_command_has_an_example_that_can_be_parsed():
    parser = _make_parser()
    commands = {
        it.prog.removeprefix("hunav").strip() for it in _all_commands(parser)
    } - {""}
    assert commands == set(EXAMPLES)
    assert set(AFTER_INTERRUPT) <= commands
    for words, example in EXAMPLES.items():
        line = example.replace('eval "$(', "").replace(')"', "")
        command, *arguments = shlex.split(line)
        assert command == "hunav"
        assert callable(parser.parse_args(arguments).function), words
    helps = {it.prog: it.format_help() for it in _all_commands(parser)}
    for prog, text in helps.items():
        assert prog == "hunav" or "Example: " in text
        assert "--debug" in text


def test_words_of_a_command_that_are_wrong_are_told_in_a_line(capsys):
    for line, words in (
        ("", "hunav: name a command: run, list, check"),
        ("tree", "hunav tree: name a command: show, check, convert; see"),
        ("rn", "there is no command 'rn'; did you mean 'run'?; valid: run"),
        (
            "metrics jerk",
            "there is no command 'jerk'; write show before it to show it;",
        ),
        ("tree shwo", "there is no command 'shwo'; did you mean 'show'?"),
        ("run", "the following arguments are required: scenario"),
        (
            "render x -o y.png --view tp",
            "--view: must be one of perspective, top, follow, plot, got 'tp';"
            " did you mean 'top'?",
        ),
    ):
        with pytest.raises(SystemExit) as info:
            main(line.split())
        assert info.value.code == 2
        (told,) = capsys.readouterr().err.splitlines()
        assert words in told


def test_completion_needs_shtab_and_says_so(hunav, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    code, _, err = hunav("completion", "bash")
    assert code == 2
    assert "pip install 'hunav_drake[completion]'" in err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_knows_commands_and_options(hunav, shell):
    pytest.importorskip("shtab", reason="the extra `completion` is not here")
    code, out, _ = hunav("completion", shell)
    assert code == 0
    for word in ("run", "doctor", "planner"):
        assert word in out


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_a_shell_completes_commands_options_and_names(hunav, tmp_path):
    pytest.importorskip("shtab", reason="the extra `completion` is not here")
    (tmp_path / "script").write_text(hunav("completion", "bash")[1])
    for line, wanted in (
        ("hunav re", "report render"),
        ("hunav run passing --pl", "--planner"),
        ("hunav run passing --planner d", "dwb"),
        ("hunav run corr", "corridor_dense"),
        ("hunav run my_own", ""),
        ("hunav bench pa", "paper"),
        ("hunav new mine --template corr", "corridor"),
        ("hunav validate --model or", "orca"),
        ("hunav metrics show path_l", "path_length"),
    ):
        words = shlex.split(line)
        done = subprocess.run(
            [
                *("bash", "-c"),
                f"source {tmp_path}/script; COMP_WORDS=({line});"
                f" COMP_CWORD={len(words) - 1}; _shtab_hunav;"
                ' echo "${COMPREPLY[*]}"',
            ],
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.strip() == wanted
    # To parse, there are more names: those of users.
    options = _make_parser().parse_args(["run", "x", "--planner", "mine:Own"])
    assert options.planner == "mine:Own"


@pytest.mark.slow
def test_after_ctrl_c_it_says_how_to_go_on(tmp_path):
    process = start_hunav(
        *("run", "passing", "--out", tmp_path, "--no-replay"),
        *("--set", "simulation.duration=80000", "--set", "robot.goal=null"),
        *("--set", "simulation.stuck_time=80000"),
    )
    while process.poll() is None and not (tmp_path / "runs").exists():
        time.sleep(0.1)
    time.sleep(2.0)
    code, err = press_ctrl_c(process)
    assert code == 130
    assert "hunav: interrupted: nothing was written of this run" in err
    assert "Traceback" not in err
    assert not list((tmp_path / "runs").iterdir())
