"""Names from files are never ways to another folder."""

import dataclasses
import os

import pytest
import yaml

from hunav_drake.commands.cli import main
from hunav_drake.hunavsim.result_files import hunav_texts
from hunav_drake.runs import LoadSuite
from hunav_drake.runs.cells import make_cells
from hunav_drake.runs.result_files import WriteResult
from hunav_drake.runs.run_folders import RECORDINGS, recording_path, replay_path
from hunav_drake.scenario import LoadScenario, ScenarioError
from hunav_drake.systems.common.files import as_file_name, is_file_name
from hunav_drake.trial.result import MetricTables
from tests.hunav_drake.passing_trials import make_recording, make_result
from tests.reliability.names import FIT, UNFIT

SUITE = {"scenarios": ["free_run"], "planners": ["pursuit"], "seeds": 1}
SHORT = ("--set", "simulation.duration=0.1")


def faults_of(load, data, **kwargs):
    with pytest.raises(ScenarioError) as caught:
        load(data=yaml.dump(data, allow_unicode=False), **kwargs)
    return [fault.path for fault in caught.value.faults]


@pytest.mark.parametrize("name", UNFIT)
def test_an_unfit_name_is_refused_at_its_place(name):
    assert faults_of(LoadSuite, {**SUITE, "name": name}) == ["name"]
    assert faults_of(LoadScenario, {"name": name}) == ["name"]
    with pytest.raises(ScenarioError, match="name: must"):
        LoadScenario(filename="free_run", overrides={"name": yaml.dump(name)})
    assert is_file_name(as_file_name(name))


@pytest.mark.parametrize("name", FIT)
def test_other_names_are_taken(name):
    assert LoadSuite(data=yaml.dump({**SUITE, "name": name})).name == name
    assert LoadScenario(data=yaml.dump({"name": name})).name == name
    assert as_file_name(name) == name


@pytest.mark.parametrize("label", ["a\nb", "x" * 65, "", 3, ["a"]])
def test_a_label_is_a_name(label):
    planner = {"type": "pursuit", "label": label}
    (path,) = faults_of(LoadSuite, {**SUITE, "planners": [planner]})
    assert path.startswith("planners[0]")


@pytest.mark.parametrize("name", UNFIT)
def test_files_of_cells_are_in_their_folder(name, tmp_path):
    for cell in (f"a/{name}", f"a/b/{name}", f"{name}/dwb", name):
        path = recording_path(tmp_path, cell, 2**63)
        assert path.parent.resolve() == tmp_path / RECORDINGS
        if cell.startswith("a/"):
            assert is_file_name(path.name)
            assert is_file_name(replay_path(tmp_path, cell, 0).name)


@pytest.mark.slow
def test_results_of_any_names_are_in_their_folder(tmp_path):
    """Of trials in memory, whose names nobody has checked."""
    out = tmp_path / "out"
    plain = make_result(make_recording(), metric_names=["path"])
    found = plain.tables.evaluation
    for name in UNFIT:
        result = dataclasses.replace(
            plain,
            scenario_name=name,
            provenance={"planner": name, "seed": 0},
            tables=MetricTables(found, {name: found}, plain.tables.attrs),
        )
        folder = WriteResult(result, out, format="hunav")
        assert folder.parent == out / "runs"
        assert all(is_file_name(it) for it in os.listdir(folder))
        assert folder.name in "".join(hunav_texts(result, folder.name))
        with pytest.raises(ValueError, match="the tag must be fit"):
            WriteResult(plain, out, tag=name)
    assert len(os.listdir(out / "runs")) == len(UNFIT)
    assert os.listdir(tmp_path) == ["out"]


def test_cells_whose_files_would_be_one_are_refused():
    planners = [
        {"type": "pursuit", "label": "a b"},
        {"type": "pursuit", "cruise_speed": 0.4, "label": "a_B"},
    ]
    suite = LoadSuite(data=yaml.dump({**SUITE, "planners": planners}))
    with pytest.raises(ScenarioError, match="too similar"):
        make_cells(suite)


def test_a_file_of_any_name_is_a_scenario(tmp_path, capsys):
    """Its name is what is left of that of the file."""
    for name in ("-x.yaml", "a:b.yaml", " .yaml", "con.yaml", "x" * 200):
        path = tmp_path / name
        path.write_text("{}")
        assert is_file_name(LoadScenario(filename=path).name)
        path.write_text(yaml.dump(SUITE))
        assert is_file_name(LoadSuite(filename=path).name)


@pytest.mark.slow
def test_commands_write_only_into_their_folder(tmp_path, monkeypatch, capsys):
    work = tmp_path / "a/b/c"
    work.mkdir(parents=True)
    monkeypatch.chdir(work)
    scenario = yaml.safe_load(open_text("free_run"))
    for i, name in enumerate((*UNFIT[:12], *FIT)):
        (work / "s.yaml").write_text(yaml.dump({**scenario, "name": name}))
        suite = {**SUITE, "scenarios": ["s.yaml"], "name": name}
        (work / "suite.yaml").write_text(yaml.dump(suite))
        out = f"out{i}"
        bench = ["bench", "suite.yaml", "--quiet", "--workers", "1"]
        codes = {
            main(["run", "s.yaml", "--out", out, "--no-replay", *SHORT]),
            main([*bench, "--out", out, *SHORT]),
        }
        assert codes <= ({0, 1} if name in FIT else {2}), name
        if name in FIT:
            assert (work / out / name / "suite.json").is_file()
        assert "Traceback" not in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["a"]
    assert os.listdir(tmp_path / "a") == ["b"]
    assert os.listdir(tmp_path / "a/b") == ["c"]
    assert {it[:3] for it in os.listdir(work)} == {"s.y", "sui", "out"}


def open_text(name):
    from hunav_drake.scenarios import shipped_text

    return shipped_text(name)
