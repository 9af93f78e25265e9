"""The weights of the forces: as written, by default, and drawn."""

import dataclasses

import numpy as np
from pydrake.systems.framework import DiagramBuilder
import pytest
from scipy import stats

from hunav_drake import (
    AddHumans,
    HumanConfig,
    LoadScenario,
    MakeTrialDiagram,
    SaveScenario,
)
from hunav_drake.hunavsim.agents_yaml import ImportAgents
from hunav_drake.scenario import ScenarioError
from hunav_drake.systems.common.random_streams import Purpose, draw_normal
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.people.parameters import PARAMETERS
from hunav_drake.systems.people.profile import RECORDED, own_forces
from hunav_drake.systems.people.weights import (
    WEIGHTS,
    check_weights,
    draw_weights,
)

COLUMNS = [PARAMETERS.index(name) for name in WEIGHTS]
RANDOM_MODES = ("random_normal", "random_uniform")
AGENTS = """\
hunav_loader:
  ros__parameters:
    agents: [ana]
    ana:
      id: 7
      init_pose: {x: 0, y: 0, h: 0}
      behavior:
        type: 1
        configuration: CONFIGURATION
        goal_force_factor: 3.0
"""


def weighted_human(mode, human_id=None, **forces):
    return HumanConfig(
        pose=[0, 0, 0],
        id=human_id,
        forces=SocialForceParameters(**forces),
        forces_mode=mode,
    )


def factors(humans, seed=0):
    return draw_weights(humans, seed)[:, COLUMNS]


def as_written(*forces):
    """The rows of weights that are as written."""
    return [dataclasses.astuple(each) for each in forces]


@pytest.fixture(scope="module")
def many():
    """The factors of many people, by mode."""
    return {
        mode: factors([weighted_human(mode, i) for i in range(4000)])
        for mode in RANDOM_MODES
    }


def test_custom_weights_are_as_written():
    human = weighted_human("custom", social_factor=3.0, goal_factor=1.0)
    np.testing.assert_array_equal(
        draw_weights([human], seed=5), as_written(human.forces)
    )


def test_people_without_weights_have_those_of_the_profile():
    human = HumanConfig(pose=(0, 0, 0))
    recorded, old = (
        draw_weights([human], 5, profile).tolist()
        for profile in ("default", "hunav_drake_0.1")
    )
    assert old == [list(dataclasses.astuple(SocialForceParameters()))]
    assert recorded == [list(dataclasses.astuple(RECORDED))] != old


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_drawn_weights_stand_among_those_of_hunavsim(mode):
    human = HumanConfig(pose=(0, 0, 0), forces_mode=mode)
    (usual,) = as_written(SocialForceParameters())
    drawn = draw_weights([human], seed=5)
    np.testing.assert_array_equal(np.flatnonzero(drawn[0] != usual), COLUMNS)


def test_default_weights_are_those_of_hunavsim():
    human = weighted_human("default", social_factor=3.0, n=1.5)
    np.testing.assert_array_equal(
        draw_weights([human], seed=5), as_written(SocialForceParameters(n=1.5))
    )


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_drawn_weights_leave_the_rest_as_written(mode):
    human = weighted_human(mode, n=1.5, gamma=0.4)
    drawn = draw_weights([human], seed=5)
    (written,) = as_written(human.forces)
    changed = np.flatnonzero(drawn[0] != written)
    np.testing.assert_array_equal(changed, COLUMNS)


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_adding_a_person_changes_nobody_elses_weights(mode):
    people = [weighted_human(mode, i) for i in (4, 2, 9)]
    longer = [weighted_human(mode, 7), *people, weighted_human("default", 1)]
    np.testing.assert_array_equal(factors(longer)[1:4], factors(people))


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_weights_follow_from_seed_and_number(mode):
    people = [weighted_human(mode, i) for i in range(3)]
    np.testing.assert_array_equal(factors(people, 1), factors(people, 1))
    values = np.concatenate([factors(people, seed) for seed in (0, 1)])
    # Those of a normal distribution are the least ones now and then.
    assert len(np.unique(values[:, 1])) == 6


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_people_without_numbers_count_by_their_places(mode):
    unnamed = factors([weighted_human(mode), weighted_human(mode)])
    numbered = factors([weighted_human(mode, 1), weighted_human(mode, 2)])
    np.testing.assert_array_equal(unnamed, numbered)


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_weights_are_drawn_within_their_ranges(mode):
    people = [weighted_human(mode, i) for i in range(50)]
    weights = draw_weights(people, seed=1)
    np.testing.assert_array_equal(check_weights(weights, 50), weights)


@pytest.mark.parametrize("seed", [-1, 1.5, 2**63, True, None])
def test_a_wrong_seed_is_refused_though_nothing_is_drawn(seed):
    with pytest.raises(ValueError, match=r"seed must be a whole number in"):
        draw_weights([weighted_human("custom")], seed)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ((1, 0), -1.0, r"weights\[1\].goal_factor must be in \[0, 1000\], got"),
        ((0, 1), 0.0, r"weights\[0\].relaxation_time must be in \[0.001, "),
        ((1, 9), np.nan, r"weights\[1\].epsilon must be finite, got nan"),
        ((0, 2), np.inf, r"weights\[0\].obstacle_factor must be finite"),
    ],
)
def test_weights_out_of_range_are_refused(place, value, message):
    weights = draw_weights([weighted_human("custom")] * 2, 0)
    weights[place] = value
    with pytest.raises(ValueError, match=message):
        check_weights(weights, 2)


@pytest.mark.parametrize("shape", [(13,), (1, 13), (2, 12), (3, 13)])
def test_weights_of_another_shape_are_refused(shape):
    with pytest.raises(ValueError, match=r"must have shape \(2, 13\), a row"):
        check_weights(np.ones(shape), 2)


def test_uniform_weights_fill_their_ranges_evenly(many):
    for values, weight in zip(
        many["random_uniform"].T, WEIGHTS.values(), strict=True
    ):
        unit = (values - weight.low) / (weight.high - weight.low)
        assert stats.kstest(unit, "uniform").pvalue > 0.01


def test_normal_weights_are_normal_above_the_least(many):
    for values, weight in zip(
        many["random_normal"].T, WEIGHTS.values(), strict=True
    ):
        assert values.min() == weight.least
        normal = stats.norm(weight.mean, weight.deviation)
        expected = normal.cdf(weight.least)
        share = np.mean(values == weight.least)
        assert share == pytest.approx(expected, abs=0.03)
        above = values[values > weight.least]
        unit = (normal.cdf(above) - expected) / (1 - expected)
        assert stats.kstest(unit, "uniform").pvalue > 0.01


def test_weights_of_one_person_do_not_hang_together(many):
    for values in many.values():
        correlation = np.corrcoef(values.T) - np.eye(len(WEIGHTS))
        assert abs(correlation).max() < 0.06


def test_normal_draws_have_mean_0_and_deviation_1():
    draws, other = draw_normal(3, [4, 5], Purpose.WEIGHTS_NORMAL, 20000)
    assert stats.kstest(draws, "norm").pvalue > 0.01
    assert abs(np.corrcoef(draws, other)[0, 1]) < 0.06


def test_an_unknown_mode_is_refused():
    with pytest.raises(ValueError, match="random_normal"):
        weighted_human("random")


def make_weighted_scenario(mode, seed):
    return LoadScenario(
        filename="passing",
        overrides=[
            f"humans[0].forces_mode={mode}",
            f"simulation.seed={seed}",
            "simulation.start_jitter=0.0",
        ],
    )


def first_forces(scenario):
    """The forces on everybody as the trial starts."""
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    return diagram.GetOutputPort("forces").Eval(context).reshape(-1, 16)


@pytest.mark.parametrize("mode", RANDOM_MODES)
def test_a_trial_draws_by_its_seed(mode):
    goal = [
        first_forces(make_weighted_scenario(mode, seed))[:, :2]
        for seed in (1, 2)
    ]
    written = first_forces(make_weighted_scenario("custom", 1))[:, :2]
    assert (goal[0][0] != goal[1][0]).any()
    # The other person's weights stay as written.
    np.testing.assert_array_equal(goal[0][1:], written[1:])
    scenario = make_weighted_scenario(mode, 1)
    assert LoadScenario(data=SaveScenario(scenario)) == scenario


def test_people_in_a_diagram_of_ones_own_draw_by_a_seed():
    def goal_force(seed):
        builder = DiagramBuilder()
        human = dataclasses.replace(
            weighted_human("random_uniform"), goals=[[5, 0]]
        )
        ports = AddHumans(builder, [human], num_robots=0, seed=seed)
        builder.ExportOutput(ports.forces, "forces")
        diagram = builder.Build()
        context = diagram.CreateDefaultContext()
        return diagram.GetOutputPort("forces").Eval(context)[0]

    assert goal_force(1) == goal_force(1)
    assert goal_force(1) != goal_force(2)


@pytest.mark.parametrize(
    ("configuration", "mode", "goal_factor"),
    [
        (0, "default", 2.0),
        (1, "custom", 3.0),
        (2, "random_normal", 2.0),
        (3, "random_uniform", 2.0),
    ],
)
def test_the_configurations_of_hunavsim_are_the_modes(
    tmp_path, configuration, mode, goal_factor
):
    file = tmp_path / "agents.yaml"
    file.write_text(AGENTS.replace("CONFIGURATION", str(configuration)))
    (human,) = ImportAgents(file).humans
    assert human.forces_mode == mode
    forces = own_forces(human, "default")
    assert forces.goal_factor == goal_factor
    assert forces.gamma == 0.35


def test_an_unknown_configuration_is_refused(tmp_path):
    file = tmp_path / "agents.yaml"
    file.write_text(AGENTS.replace("CONFIGURATION", "4"))
    with pytest.raises(ScenarioError) as info:
        ImportAgents(file)
    assert str(info.value).endswith(
        ":9: ana.behavior.configuration: must be one of 0 default, 1 custom,"
        " 2 random_normal, 3 random_uniform; got 4"
    )
