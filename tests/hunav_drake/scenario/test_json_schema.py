"""The JSON schema tells what a scenario file may hold."""

from importlib import resources
import json

import jsonschema
from pydantic.dataclasses import dataclass
import pytest
import yaml

from hunav_drake import ListScenarios, LoadScenario, SaveScenario
from hunav_drake.commands import cli
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.systems.planning import PLANNERS, Planner, register_planner


@pytest.fixture(scope="module")
def schema():
    return scenario_json_schema()


@pytest.fixture(scope="module")
def dut(schema):
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", ListScenarios())
def test_every_shipped_scenario_fits(dut, name):
    file = resources.files("hunav_drake.scenarios") / f"{name}.yaml"
    dut.validate(yaml.safe_load(file.read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", ["cafe", "house", "passing", "station"])
def test_a_saved_scenario_fits(dut, name):
    saved = SaveScenario(LoadScenario(filename=name))
    dut.validate(yaml.safe_load(saved))


def test_only_a_recorded_person_needs_no_pose(dut):
    track = {"file": "people.csv", "id": 1}
    dut.validate({"humans": [{"track": track}, {"pose": [0, 0, 0]}]})
    for human in ({}, {"track": None}):
        with pytest.raises(jsonschema.ValidationError, match="'pose' is a req"):
            dut.validate({"humans": [human]})


WALL = "type: box, center: [5, 5], size: [1, 1]"
PERSON = "pose: [5, 5, 0]"
COHORT = "number: 3, start: [{rectangle: [0, 0, 9, 9]}]"


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("planner: pursuit", "planner: persuit"),
        ("planner: {type: pursuit}", "planner: {type: persuit}"),
        ("planner: {cruise_speed: 1}", "planner: {cruise_sped: 1}"),
        ("planner: {cruise_speed: 1}", "planner: {cruise_speed: -1}"),
        ("planner: {period: 0.1}", "planner: {period: 0}"),
        ("crowd: {model: orca}", "crowd: {model: orka}"),
        (
            "crowd: {model: {type: orca, time_horizon: 2}}",
            "crowd: {model: {time_horizon: 2}}",
        ),
        ("crowd: {model: {kernel: numpy}}", "crowd: {model: {kernel: gpu}}"),
        ("robot: {radius: 0.3}", "robot: {radius: 6}"),
        ("robot: differential_drive", "robot: {type: tank}"),
        (
            f"world: {{walls: [{{{WALL}}}]}}",
            "world: {walls: [{center: [5, 5], size: [1, 1]}]}",
        ),
        (f"world: {{walls: [{{{WALL}}}]}}", "world: {walls: [box]}"),
        (f"humans: [{{{PERSON}}}]", "humans: [{}]"),
        (
            f"population: {{cohorts: [{{{COHORT}}}]}}",
            "population: {cohorts: [{number: 3}]}",
        ),
        (
            f"population: {{seed: 3, cohorts: [{{{COHORT}, radius: 0.4}}]}}",
            f"population: {{cohorts: [{{{COHORT}, radius: 9.0}}]}}",
        ),
        (f"humans: [{{{PERSON}}}]", "humans: [{pose: [5, 5]}]"),
        (
            f"humans: [{{{PERSON}, behavior: {{type: curious, duration: 3}}}}]",
            f"humans: [{{{PERSON}, behavior: {{duration: 3}}}}]",
        ),
        ("simulation: {seed: 1}", "simulation: {sed: 1}"),
    ],
)
def test_what_a_scenario_may_hold_fits_and_nothing_else(dut, right, wrong):
    """The schema and the loader agree."""
    assert dut.is_valid(yaml.safe_load(right))
    LoadScenario(data=right)
    assert not dut.is_valid(yaml.safe_load(wrong))
    with pytest.raises(ValueError, match="fault"):
        LoadScenario(data=wrong)


def test_fields_are_described(schema):
    # (Old versions of pydantic keep each form among the definitions.)
    forms = [
        schema["$defs"][form["$ref"].rpartition("/")[2]]
        if "$ref" in form
        else form
        for form in schema["properties"]["robot"]["oneOf"]
    ]
    fields = next(form for form in forms if "properties" in form)["properties"]
    assert fields["type"] == {"const": "differential_drive"}
    assert fields["goal"]["description"] == (
        "Goal pose (x, y, yaw) in W, in meters and radians. None: the robot"
        " does not move."
    )
    human = schema["$defs"]["HumanConfig"]["properties"]
    assert human["desired_speed"]["description"].startswith(
        "Desired speed, in m/s"
    )
    assert human["desired_speed"]["maximum"] == 10


@pytest.mark.slow
def test_the_command_writes_it_with_what_users_add(
    capsys, tmp_path, monkeypatch
):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))

    @register_planner("of my own")
    @dataclass
    class Mine(Planner):
        boldness: float = 1.0

        def plan(self, task, view, memory): ...

    file = tmp_path / "schema.json"
    assert cli.main(["schema", "-o", str(file)]) == 0
    capsys.readouterr()
    assert cli.main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert json.loads(file.read_text()) == schema
    jsonschema.validate(
        {"planner": {"type": "of my own", "boldness": 2}}, schema
    )
    # Without --force, nothing is written over.
    assert cli.main(["schema", "-o", str(file)]) == 2
    assert cli.main(["schema", "-o", str(file), "--force"]) == 0
