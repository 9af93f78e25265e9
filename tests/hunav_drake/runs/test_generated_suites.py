"""Suites of generated scenarios: each seed has a world of its own."""

import argparse

import pytest

from hunav_drake import LoadSuite, RunSuite, ScenarioError
from hunav_drake.commands.bench import _suite, add_bench_options
from hunav_drake.runs.cells import make_cells
from tests.hunav_drake.runs.suite_texts import texts_of

SMALL = """
scenarios:
  - {type: field, people: 2, difficulty: [0, 1]}
  - {type: field, name: crowded, people: 4}
planners: [pursuit, {type: pursuit, cruise_speed: 0.5, label: slow}]
overrides: [simulation.duration=2.0]
seeds: 2
"""


def test_seeds_have_worlds_of_their_own_and_planners_the_same():
    fast, slow, crowded, _ = make_cells(LoadSuite(data=SMALL))
    assert [fast.name, slow.name] == ["field/pursuit", "field/slow"]
    assert crowded.name == "crowded/pursuit"
    assert fast.load(0).world != fast.load(1).world
    assert fast.load(0).world == slow.load(0).world
    assert fast.load(1).simulation.seed == 1
    assert fast.load(1).simulation.duration == 2.0
    assert slow.load(0).planner.cruise_speed == 0.5
    assert len(crowded.load(0).humans) == 4
    assert len({it.sha256 for it in (fast, slow, crowded)}) == 3


@pytest.mark.slow
def test_a_cell_does_not_depend_on_how_many_seeds_there_are():
    few, many = (
        make_cells(LoadSuite(data=SMALL.replace("seeds: 2", f"seeds: {n}")))
        for n in ("[1]", "[0, 1, 2]")
    )
    assert [it.sha256 for it in few] == [it.sha256 for it in many]


@pytest.mark.slow
def test_results_are_the_same_in_other_processes(tmp_path):
    suite = LoadSuite(data=SMALL)
    alone = RunSuite(suite, workers=1)
    others = RunSuite(suite, out=tmp_path, workers=2)
    assert texts_of(alone) == texts_of(others)
    assert len(alone.rows) == 8
    ends = {row.end_reason for row in alone.rows}
    assert ends == {"timeout"}
    # The two planners meet the same people.
    by_cell = alone.runs().set_index(["scenario", "planner", "seed"])
    assert by_cell.loc["field"].drawn.eq("world").all()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("people: 2", "people: -2", "people"),
        ("type: field, people: 2", "type: filed", "did you mean 'field'"),
        ("people: 4", "fill: 0.95", "no ways for the robot"),
        ("name: crowded, ", "", "two cells are called"),
    ],
)
def test_a_bad_kind_is_told_before_anything_runs(old, new, told):
    with pytest.raises(ScenarioError, match=told):
        RunSuite(LoadSuite(data=SMALL.replace(old, new)), workers=1)


@pytest.mark.parametrize("name", ["barn", "generalize"])
def test_shipped_suites_have_all_planners(name):
    suite = LoadSuite(filename=name)
    assert len(suite.planners) == 7
    if name == "barn":
        with pytest.raises(ScenarioError, match="--worlds FOLDER"):
            RunSuite(suite, workers=1)
    else:
        assert len(suite.scenarios) * suite.seeds == 100


def test_settings_and_overrides_hold_for_listed_planners():
    suite = LoadSuite(
        data="{scenarios: [passing, {type: field}], planners: [pursuit],"
        " seeds: 1, settings: {usual: [], slow: [planner.cruise_speed=0.3]}}"
    )
    cells = make_cells(suite)
    speeds = [it.load(0).planner.cruise_speed for it in cells]
    assert speeds == [speeds[0], 0.3, speeds[0], 0.3]
    assert len({it.sha256 for it in cells}) == 4


def test_a_setting_beside_keeps_those_of_the_suite(tmp_path):
    file = tmp_path / "own.yaml"
    file.write_text(
        "{scenarios: [passing], planners: [pursuit], seeds: 1,"
        " settings: {usual: [], slow: [planner.cruise_speed=0.3]}}"
    )
    change = "crowd.radius_factor=1.1"
    parser = argparse.ArgumentParser()
    add_bench_options(parser)
    options = parser.parse_args([str(file), "--beside", change])
    assert dict(_suite(options).settings) == {
        "usual": [],
        "slow": ["planner.cruise_speed=0.3"],
        f"usual, {change}": [change],
        f"slow, {change}": ["planner.cruise_speed=0.3", change],
    }


@pytest.mark.parametrize("change", ["planner=orca", "planner.type=orca"])
def test_a_change_of_the_planner_is_refused_beside_listed_planners(change):
    suite = LoadSuite(
        data="{scenarios: [passing], planners: [dwb, mppi], seeds: 1,"
        f" settings: {{usual: [], other: ['{change}']}}}}"
    )
    with pytest.raises(ScenarioError, match="leave out one of both"):
        make_cells(suite)


def test_drawn_scenarios_that_wait_for_a_trigger_are_refused():
    suite = LoadSuite(
        data="{scenarios: [{type: field, people: 1}], seeds: 2,"
        " overrides: ['evaluator.start=by_trigger']}"
    )
    with pytest.raises(ScenarioError, match="by_trigger waits"):
        make_cells(suite)


@pytest.mark.parametrize(
    "change", ["simulation.seed=5", " simulation={seed: 5}"]
)
def test_a_change_of_the_seed_is_refused_beside_seeds(change):
    suite = LoadSuite(
        data="{scenarios: [passing], seeds: 2, settings: {usual: [], other:"
        f" ['{change}']}}}}"
    )
    with pytest.raises(ScenarioError, match=r"`seeds` has the seeds of all"):
        make_cells(suite)


def test_an_overriding_tree_counts_for_the_hash(tmp_path):
    tree = tmp_path / "own.xml"
    hashes = []
    for wait in (1.0, 2.0):
        tree.write_text(
            '<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree'
            ' ID="T"><Sequence><RegularNav agent_id="{id}" dt="{dt}"/>'
            f'<TimeExpiredCondition seconds="{wait}"/>'
            "</Sequence></BehaviorTree></root>"
        )
        text = SMALL.replace(
            "simulation.duration=2.0", f"'humans[0].behavior={tree}'"
        )
        hashes.append([it.sha256 for it in make_cells(LoadSuite(data=text))])
    assert not set(hashes[0]) & set(hashes[1])
