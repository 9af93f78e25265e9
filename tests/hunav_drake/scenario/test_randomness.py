"""What seeds draw, against what really differs between trials."""

import pytest

from hunav_drake import ListScenarios, LoadScenario, RunTrial
from hunav_drake.scenario.randomness import (
    drawn_by_seed,
    how_to_draw,
    same_for_all_seeds,
)
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS

COHORT = "cohorts: [{number: 3, start: [{rectangle: [3, 1, 6, 3]}]}]"
SOURCE = (
    "sources: [{name: in, start: [{point: [4, 3]}], rate: 2.0, max_present: 9,"
    " sinks: {out: 1}}], sinks: [{name: out, area: {point: [7, 3]}}]"
)
FEEL = "humans=[{pose: [2, 0.3, 3], goals: [[-4, 0]], forces_mode: %s}]"
NOISY = "sensors=[{type: lidar, num_rays: 60, noise: 0.2}]"
BY_LIDAR = "planner={type: sfm, sees: lidar}"
BARE = "robot: {goal: [6, 0, 0]}\n"


def assert_told_truly(scenario):
    """Holds that seeds differ if and only if something is drawn."""
    first, second = (RunTrial(scenario, seed).recording for seed in (0, 1))
    assert (first != second) == bool(drawn_by_seed(scenario))
    assert bool(same_for_all_seeds(scenario)) == (first == second)


@pytest.mark.slow
@pytest.mark.parametrize("name", ListScenarios())
def test_seeds_of_shipped_scenarios_differ_where_something_is_drawn(name):
    assert_told_truly(
        LoadScenario(filename=name, overrides=["simulation.duration=8.0"])
    )


@pytest.mark.parametrize(
    ("changes", "drawn"),
    [
        ([], ()),
        (["simulation.start_jitter=0.1"], ()),
        (["humans=[{pose: [3, 2, 0]}]"], ()),
        (
            ["humans=[{pose: [3, 2, 0]}]", "simulation.start_jitter=0.1"],
            ("start jitter",),
        ),
        ([FEEL % "default"], ()),
        ([FEEL % "random_normal"], ("weights of forces",)),
        (["crowd.decisions={}"], ()),
        (
            [f"population={{{SOURCE}, seed: 2}}", "crowd.decisions={}"],
            ("arrivals at sources", "decisions of people"),
        ),
        ([FEEL % "default", "crowd.decisions={}"], ("decisions of people",)),
        ([FEEL % "default", "crowd.decisions={sigma_heading: 0}"], ()),
        ([f"population={{{COHORT}}}"], ("population",)),
        ([f"population={{{COHORT}, seed: 2}}"], ()),
        (
            [f"population={{{COHORT}, seed: 2}}", "simulation.start_jitter=.1"],
            ("start jitter",),
        ),
        ([f"population={{{SOURCE}, seed: 2}}"], ("arrivals at sources",)),
        (
            [
                f"population={{{SOURCE}, seed: 2}}",
                "population.sources[0].rate=0",
                "simulation.start_jitter=0.1",
            ],
            (),
        ),
        ([f"population={{{SOURCE}}}"], ("population", "arrivals at sources")),
        ([NOISY], ()),
        ([NOISY, BY_LIDAR], ("noise of the lidar",)),
        ([NOISY, BY_LIDAR, "sensors[0].noise=0"], ()),
    ],
)
def test_what_is_drawn_differs_and_nothing_else(changes, drawn):
    short = ["simulation.duration=3.0", "planner=pursuit"]
    walls = "world={walls: [{type: box, center: [3, -1], size: [2, 1]}]}"
    scenario = LoadScenario(data=BARE, overrides=[*short, walls, *changes])
    assert drawn_by_seed(scenario) == drawn
    assert_told_truly(scenario)


ALONE = "[{pose: [2, 0.3, 3], goals: [[-4, 0]], forces_mode: random_normal%s}]"


@pytest.mark.parametrize(
    ("people", "feel"),
    [
        (f"humans={ALONE % ''}", {"all"}),
        (f"humans={ALONE % ', behavior: scared'}", {"all", "pushed"}),
        (
            "population={seed: 1, cohorts: [{number: 2, start: [{rectangle:"
            " [2, 1, 4, 3]}], goals: [{point: [-4, 0]}], group_sizes: [0, 1],"
            " forces_mode: random_uniform}]}",
            {"all", "pushed"},
        ),
    ],
)
@pytest.mark.parametrize("model", MOTION_MODELS)
def test_weights_count_as_drawn_where_a_motion_model_uses_them(
    model, people, feel
):
    scenario = LoadScenario(
        data=f"{BARE}crowd: {{model: {model}}}",
        overrides=["simulation.duration=3.0", "planner=pursuit", people],
    )
    assert_told_truly(scenario)
    assert bool(drawn_by_seed(scenario)) == (
        scenario.crowd.model.uses_weights in feel
    )


def test_what_draws_is_told_as_it_fits():
    assert how_to_draw(LoadScenario(data="{}")).startswith("add people")
    fixed = LoadScenario(data=f"population: {{seed: 1, {COHORT}}}")
    assert how_to_draw(fixed).endswith("or leave out population.seed")
    assert "all seeds give the same" in same_for_all_seeds(fixed)


@pytest.mark.parametrize("model", ["social_force", "headed_social_force"])
def test_weights_are_drawn_also_of_people_whose_behavior_has_ports(model):
    scenario = LoadScenario(
        filename="living_cafe",
        overrides=[
            f"crowd.model={{type: {model}}}",
            "humans[0].forces_mode=random_normal",
            "simulation.start_jitter=0",
        ],
    )
    assert "weights" in " ".join(drawn_by_seed(scenario))
