"""Scenarios with a population, from the file to the result."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial, SaveScenario
from hunav_drake.commands import cli
from hunav_drake.scenario import CheckScenario, PopulationConfig, draw_people
from tests.hunav_drake.scenario.loading_failure import failure

TEXT = """\
name: hall
world: {walls: [{type: box, center: [5, 5], size: [2, 2]}]}
robot: {start: [0, 0, 0], goal: [9, 0, 0]}
simulation: {duration: 1.0, start_jitter: 0.05}
humans:
  - {name: ana, pose: [1, 3, 0], goals: [[8, 3]], group_id: 4}
population:
  seed: 3
  cohorts:
    - name: guest
      number: 6
      start: [{rectangle: [-2, -4, 10, 10]}]
      goals: [{polygon: [[0, 0], [8, 0], [4, 4]]}, {point: [9, 9]}]
      behaviors: {regular: 1, curious: 1}
      group_sizes: [1, 1]
      forces_mode: random_normal
    - number: 2
      start: [{rectangle: [-2, -4, 10, 0]}]
"""


@pytest.fixture(scope="module")
def scenario():
    return LoadScenario(data=TEXT)


@pytest.fixture(scope="module")
def diagram(scenario):
    return MakeTrialDiagram(scenario)


def same(first, second):
    return first.recording.humans.tobytes() == second.recording.humans.tobytes()


def test_listed_people_come_first_and_all_have_names(scenario):
    people = draw_people(scenario)
    guests = [f"guest_{k}" for k in range(1, 7)]
    names = ["ana", *guests, "human_1", "human_2"]
    assert [human.name for human in people] == names
    assert [human.id for human in people] == list(range(1, 10))
    # Groups of those listed are theirs.
    drawn = {human.group_id for human in people[1:]} - {-1}
    assert drawn
    assert min(drawn) == 5


def test_a_scenario_keeps_the_short_form(scenario):
    assert len(scenario.humans) == 1
    text = SaveScenario(scenario)
    assert "guest_1" not in text
    assert LoadScenario(data=text) == scenario
    assert CheckScenario(scenario) == scenario


def test_people_of_a_population_are_of_the_profile():
    text = TEXT + "crowd: {profile: hunavsim}\n"
    result = RunTrial(LoadScenario(data=text))
    # Single precision, as all of HuNavSim.
    radii = result.recording.humans[0, :, 6]
    assert (radii == np.float32(0.35)).all()


def test_one_without_a_population_is_written_as_ever():
    assert "population" not in SaveScenario(LoadScenario(filename="passing"))


def test_drawn_people_are_as_listed_ones(scenario, diagram):
    """Bit for bit: what follows sees plain people."""
    listed = dataclasses.replace(
        scenario, humans=draw_people(scenario), population=PopulationConfig()
    )
    result = RunTrial(scenario, diagram=diagram)
    expected = RunTrial(listed)
    assert same(result, expected)
    pd.testing.assert_series_equal(result.metrics, expected.metrics)
    assert result.recording.behaviors == expected.recording.behaviors


def test_one_diagram_serves_all_seeds_of_the_trial(scenario, diagram):
    first, second = (RunTrial(scenario, s, diagram=diagram) for s in (1, 2))
    assert same(first, RunTrial(scenario, 1))
    assert not same(first, second)
    # The people are the same ones, at the start within the jitter.
    starts = [it.recording.humans[0, :, :2] for it in (first, second)]
    expected = [human.pose[:2] for human in draw_people(scenario)]
    for start in starts:
        assert 0 < abs(start - expected).max() < 0.11


def test_a_diagram_is_of_one_seed_of_the_population(diagram):
    other = LoadScenario(data=TEXT, overrides=["population.seed=4"])
    with pytest.raises(ValueError, match="scenario with other population"):
        RunTrial(other, diagram=diagram)


def test_the_seed_of_the_population_draws_other_people(scenario):
    other = LoadScenario(data=TEXT, overrides=["population.seed=4"])
    first, second = (
        np.array([human.pose for human in draw_people(it)[1:]])
        for it in (scenario, other)
    )
    assert not np.isclose(first, second).any()


def test_the_seed_of_the_trial_draws_the_same_people(scenario):
    other = LoadScenario(data=TEXT, overrides=["simulation.seed=4"])
    assert draw_people(other) == draw_people(scenario)


def test_people_may_be_taken_out_on_the_command_line():
    none = LoadScenario(data=TEXT, overrides=["population={}"])
    assert len(draw_people(none)) == 1


@pytest.mark.parametrize(
    ("setting", "fault"),
    [
        ("number=2000", "('guest').start: has room for "),
        (
            "start=[{rectangle: [4.2, 4.2, 5, 5]}]",
            "('guest').start: has room for 0 of 6 people who are 0.35 m from"
            " walls and 0.1 m apart, as they were drawn; enlarge the areas, or"
            " lower number, radius or spacing",
        ),
        (
            "goals=[{point: [9, 9]}, {point: [5, 5]}]",
            "('guest').goals[1]: is inside a wall; move it",
        ),
        (
            "behaviors={sacred: 1}",
            "('guest').behaviors.sacred: there is no behavior 'sacred'; did"
            " you mean 'scared'?",
        ),
        (
            "behaviors={regular: 0}",
            "('guest').behaviors: must have a weight above 0",
        ),
        (
            "body_radius=[0.3, 0.2]",
            "('guest').body_radius: must be a least and a largest radius, got"
            " 0.3 and 0.2 m",
        ),
        (
            "start=[{}]",
            "('guest').start[0]: must have one of rectangle, polygon and point",
        ),
        (
            "start=[{point: [3, 3]}]",
            "('guest').start[0]: must be a rectangle or a polygon, got a"
            " point; list a person of a known place under humans",
        ),
        (
            "start=[{rectangle: [99000, 0, 100000, 1]}]",
            "('guest').start[0]: must be within 99999.95 m of the origin",
        ),
        ("numbr=3", "('guest').numbr: unknown key; did you mean 'number'?"),
        ("number=-1", "('guest').number: must be at least 0, got -1"),
    ],
)
def test_faults_name_place_rule_value_and_remedy(setting, fault):
    error = failure(data=TEXT, overrides=[f"population.cohorts[0].{setting}"])
    (found,) = error.faults
    assert f"population.cohorts[0] {fault}" in str(found)
    assert found.source.startswith("--set population.cohorts[0].")


def test_a_name_that_somebody_has_is_refused():
    error = failure(data=TEXT.replace("name: ana", "name: guest_2"))
    (found,) = error.faults
    assert found.line == 10
    assert found.path == "population.cohorts[0] ('guest').name"
    assert "'guest_2' is humans[0] ('guest_2'); rename one" in found.message


def test_names_of_each_cohort_are_compared_also_after_a_clash():
    text = """
humans: [{name: a_1, pose: [0, 4, 0]}, {name: b_2, pose: [0, 6, 0]}]
population:
  cohorts:
    - {name: a, number: 3, start: [{rectangle: [2, -4, 8, -1]}]}
    - {name: c, number: 2, start: [{rectangle: [2, -4, 8, -1]}]}
    - {name: b, number: 2, start: [{rectangle: [2, -4, 8, -1]}]}
robot: {start: [-5, 0, 0]}
"""
    places = [it.path for it in failure(data=text).faults]
    assert places == [
        "population.cohorts[0] ('a').name",
        "population.cohorts[2] ('b').name",
    ]


def test_people_whose_walls_are_faulty_are_not_judged():
    text = TEXT.replace("size: [2, 2]", "size: [2]")
    (found,) = failure(data=text).faults
    assert found.path == "world.walls[0].size"


def test_trees_are_looked_for_beside_the_file(tmp_path):
    shown = "<root><BehaviorTree ID='A'><AlwaysSuccess/></BehaviorTree></root>"
    (tmp_path / "still.xml").write_text(shown)
    file = tmp_path / "hall.yaml"
    file.write_text(TEXT.replace("curious: 1", "still.xml: 1"))
    people = draw_people(LoadScenario(filename=file))
    trees = {human.behavior for human in people}
    assert trees == {"regular", str(tmp_path / "still.xml")}


def test_check_counts_all_people(tmp_path, capsys):
    file = tmp_path / "hall.yaml"
    file.write_text(TEXT)
    assert cli.main(["check", str(file)]) == 0
    assert "ok (9 people, 1 wall, planner pursuit)" in capsys.readouterr().out


@pytest.mark.parametrize("taken", [[5], [2**31 - 1], [2**31 - 1, 2, 0]])
def test_groups_get_numbers_beside_any_other(taken):
    humans = "".join(
        f"- {{pose: [{5 + 2 * i}, 0, 0], group_id: {number}}}\n"
        for i, number in enumerate(taken)
    )
    area = "{rectangle: [-8, -8, -2, 8]}"
    cohort = f"{{number: 8, group_sizes: [0, 1], start: [{area}]}}"
    text = f"humans:\n{humans}population: {{cohorts: [{cohort}]}}\n"
    drawn = draw_people(LoadScenario(data=text))[len(taken) :]
    first = max(taken) + 1
    if first > 6:
        first = {1: 0, 3: 3}[len(taken)]
    pairs = [number for k in range(4) for number in (first + k, first + k)]
    assert [human.group_id for human in drawn] == pairs
