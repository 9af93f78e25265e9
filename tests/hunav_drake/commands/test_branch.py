"""The commands `hunav branch` and `hunav who`."""

import re

import pandas as pd
import pytest

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
)
from hunav_drake.report.tables import signed


@pytest.mark.slow
def test_branch_writes_all_files(hunav, tmp_path):
    code, out, err = hunav(
        *("branch", "crossing", "--at", "2", "--until", "14"),
        *("--planner", "orca", "--robot", "gone", "--robot", "stands"),
        *("--without", "ana", "--with", "crowd.robot_gap=0.3"),
        *("--out", tmp_path),
    )
    assert (code, err) == (0, "")
    names = [
        *("same", "orca", "robot gone", "robot stands", "without ana"),
        "crowd.robot_gap=0.3",
    ]
    for name in names:
        assert f"\n{name}" in out
    table = pd.read_csv(tmp_path / "branches.csv")
    assert list(dict.fromkeys(table["branch"])) == names
    assert set(table["person"]) == {"ana", "luis", "marta", "pablo"}
    # Each branch with a robot has its run.
    runs = list((tmp_path / "runs").glob("*/recording.npz"))
    assert len(runs) == len(names) - 1
    page = (tmp_path / "branches.html").read_text()
    assert page.count("<svg") == 2
    assert "social work until the arrival (m\N{SUPERSCRIPT TWO}/s" in page
    for name in names:
        assert name in page
    # The summary has the sums and the largest of the table.
    late = table[(table["quantity"] == "time") & (table["censored"] == 0)]
    late = late[late["branch"] != "robot gone"]
    for name, own in late.groupby("branch"):
        delays = own["difference"]
        told = signed(round(delays.sum(), 3), "s")
        assert f"{told} s in {name} ({len(delays)} arrive in both)" in page
    worst = late.loc[late["difference"].idxmax()]
    told = f"that of {worst['person']} in {worst['branch']}:"
    assert f"{told} {signed(round(worst['difference'], 3), 's')} s." in page


def test_differences_by_rounding_have_no_sign():
    assert [signed(it, "m") for it in (1e-9, -1e-9, 0.0)] == ["0"] * 3


def test_branch_goes_on_from_a_file(hunav, tmp_path):
    diagram = MakeTrialDiagram(LoadScenario(filename="crossing"))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(2.0)
    path = tmp_path / "at_2.npz"
    SaveContext(diagram, simulator.get_context(), path)
    outs = [
        hunav("branch", "crossing", *instant, "--until", "8")
        for instant in (("--at", "2"), ("--from", path))
    ]
    assert outs[0] == outs[1]
    assert outs[0][0] == 0
    assert "robot stands" in outs[0][1]


def test_branch_tells_how_small_differences_grow(hunav):
    command = ("branch", "passing", "--at", "2", "--until", "6")
    outs = [hunav(*command, *more) for more in ((), ("--growth",))]
    (first, plain, _), (second, told, _) = outs
    assert first == second == 0
    assert told.startswith(plain)
    assert re.fullmatch(
        r"\nA robot that is 1 um aside moves people by 0\.\d+ um later, at"
        r" most\.\n",
        told.removeprefix(plain),
    )


def test_who_prints_the_matrix(hunav, tmp_path):
    code, out, err = hunav(
        *("who", "passing", "--until", "20", "--out", tmp_path)
    )
    assert (code, err) == (0, "")
    table = pd.read_csv(tmp_path / "who.csv", index_col="cause")
    assert list(table.index) == [*table.columns, "robot"]
    for name in table.index:
        assert f"\n{name}" in out
    code, out, _ = hunav(
        "who", "passing", "--at", "3", "--until", "15", "--shapley", "4"
    )
    assert code == 0
    assert "adds up" in out


def test_who_has_no_values_for_goals_that_nobody_has(hunav):
    code, out, _ = hunav("who", "passing", "--until", "0.1", "--goal", "1")
    assert code == 0
    assert "No value: the person has no such goal (--goal), or does" in out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("branch", "crossing", "--at", "50"), "the trial ends before, at"),
        (("branch", "crossing", "--at", "0.33"), "a multiple of"),
        (("branch", "crossing", "--without", "bob"), "no person 'bob'"),
        (
            ("branch", "crossing", "--planner", "dwbb"),
            "hunav: there is no planner 'dwbb'; did you mean 'dwb'?\n",
        ),
        (("branch", "crossing", "--of", "b"), "no robot 'b'"),
        (("branch", "crossing", "--reference", "x"), "name of a branch"),
        (("branch", "crossing", "--until", "0"), "until must be a time"),
        (("who", "crossing", "--from", "no.npz"), "no.npz"),
        (
            ("branch", "crossing", "--from", "no.npz", "--seed", "3"),
            "--seed does not go with --from",
        ),
    ],
)
def test_mistakes_are_told_in_a_line(hunav, words, told):
    code, _, err = hunav(*words)
    assert code == 2
    assert told in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("branch", "crossing", "--at", "-1"), "not negative"),
        (("branch", "crossing", "--robot", "flies"), "must be one of"),
        (("who", "crossing", "--shapley", "0"), "whole number"),
    ],
)
def test_words_are_checked(hunav, words, told, capsys):
    with pytest.raises(SystemExit) as caught:
        hunav(*words)
    assert caught.value.code == 2
    assert told in capsys.readouterr().err


def test_nobody_is_there(hunav, tmp_path):
    code, out, _ = hunav(
        *("branch", "free_run", "--at", "1", "--until", "4"),
        *("--robot", "stands", "--out", tmp_path),
    )
    assert code == 0
    assert "Extra time" not in out
    assert "robot stands: ended after 4.00 s" in out
    assert (tmp_path / "branches.html").read_text().count("<svg") == 1
    code, _, err = hunav("who", "free_run")
    assert code == 2
    assert "has no people" in err


def test_values_of_encounters_are_no_headline(hunav):
    code, out, _ = hunav(
        "run", "crossing", "--set", "evaluator.encounters=true"
    )
    assert code == 0
    assert "path_length" in out
    assert "time_in_personal" not in out
    code, out, _ = hunav(
        "run", "crossing", "--set", "evaluator.encounters=true", "--all"
    )
    assert "time_in_personal" in out
