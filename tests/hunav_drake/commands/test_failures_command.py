"""The command `hunav falsify`."""

import json

import pytest

from tests.hunav_drake.runs.failures.scenes import SPACE, write_space


@pytest.mark.slow
def test_a_search_prints_and_writes_its_scenes(hunav, tmp_path):
    space, out = write_space(tmp_path), tmp_path / "out"
    words = ["falsify", space, "--budget", 14, "--out", out, "--workers", 1]
    code, told, err = hunav(*words, "--quiet", "--replays")
    assert code == 0
    assert "of 14 scenes failed, the first at run" in told
    assert "ana" in told
    assert str(out) in err
    names = {path.name for path in out.iterdir()}
    assert {"001.yaml", "001.npz", "001.html", "rank.csv", "tried.csv"} <= names
    code, told, _ = hunav(*words, "--quiet", "--json")
    assert json.loads(told)["scenes"][0]["person"] == "ana"
    code, _, err = hunav(*words, "--seed", 1)
    assert code == 2
    assert "another search" in err
    assert "--fresh" in err


def test_without_a_valid_scene_it_says_why(hunav, tmp_path):
    space = write_space(tmp_path, SPACE.replace("0.5}", "50.0}"))
    out = tmp_path / "out"
    code, told, _ = hunav(
        *("falsify", space, "--budget", 3, "--out", out, "--workers", 1)
    )
    assert code == 0
    assert "start_gap" in told
    assert "The nearest" not in told


def test_faults_have_file_and_line(hunav, tmp_path):
    space = write_space(tmp_path, SPACE.replace("[0.6, 1.6]", "[0.6]"))
    code, _, err = hunav("falsify", space, "--out", tmp_path / "out")
    assert code == 2
    assert "space.yaml:7: space" in err
    assert "must be a range" in err


def test_the_fault_of_scenes_that_cannot_run_is_told(hunav, tmp_path):
    """A duration that is drawn is hardly ever a multiple of the time step."""
    space = write_space(
        tmp_path,
        "scenario: scene.yaml\nrobustness: timeout\n"
        "space: {simulation.duration: [3, 5]}\n",
    )
    words = ["falsify", space, "--budget", 3, "--method", "random"]
    code, told, _ = hunav(*words, "--out", tmp_path / "out", "--workers", 1)
    assert code == 0
    assert "the first because: simulation.duration: must be a multiple" in told
