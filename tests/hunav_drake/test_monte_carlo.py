"""Drake's own ways to draw trials, and people whom each seed draws anew."""

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.systems.analysis import MonteCarloSimulation
import pytest

from hunav_drake import (
    GetTrialResult,
    GetTrialSeed,
    LoadContext,
    LoadScenario,
    MakeRandomSimulator,
    MakeTrialDiagram,
    RunTrial,
    SaveContext,
    SetTrialSeed,
    TransferContext,
)

HALL = """\
robot: {goal: [9, 0, 0]}
planner: {type: pursuit}
simulation: {duration: 1.0}
population:
  cohorts:
    - name: guest
      number: 4
      start: [{rectangle: [1, 1, 9, 6]}]
      goals: [{rectangle: [1, -6, 9, -1]}]
      behaviors: {regular: 1, curious: 1}
"""


@pytest.fixture(scope="module")
def hall():
    return LoadScenario(data=HALL)


@pytest.fixture(scope="module")
def jittered():
    change = "population.seed=1", "simulation.start_jitter=0.1"
    return LoadScenario(data=HALL, overrides=change)


def sample(scenario, number):
    """Four seeds, outputs and recordings of Drake's simulation."""
    seeds, recordings = [], []

    def output(diagram, context):
        seeds.append(GetTrialSeed(diagram, context))
        result = GetTrialResult(scenario, diagram, context)
        recordings.append(result.recording)
        return result.recording.humans[-1, 0, 0]

    results = MonteCarloSimulation(
        MakeRandomSimulator(scenario), output, 1.0, 4, RandomGenerator(number)
    )
    return seeds, [it.output for it in results], recordings


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hall", "jittered"])
def test_monte_carlo_simulation_draws_trials(name, request):
    scenario = request.getfixturevalue(name)
    seeds, outputs, recordings = sample(scenario, 1)
    assert len(set(seeds)) == len(set(outputs)) == 4
    assert sample(scenario, 1)[:2] == (seeds, outputs)
    assert sample(scenario, 2)[0] != seeds
    for seed, recording in zip(seeds, recordings, strict=True):
        assert RunTrial(scenario, seed).recording == recording


def test_a_random_context_is_that_of_a_drawn_seed(jittered):
    diagram = MakeTrialDiagram(jittered)
    context = diagram.CreateDefaultContext()
    generator = RandomGenerator(3)
    states = {}
    for _ in range(2):
        diagram.SetRandomContext(context, generator)
        seed = GetTrialSeed(diagram, context)
        states[seed] = diagram.GetOutputPort("human_states").Eval(context)
        expected = diagram.CreateDefaultContext()
        SetTrialSeed(diagram, expected, seed)
        np.testing.assert_array_equal(
            states[seed], diagram.GetOutputPort("human_states").Eval(expected)
        )
    assert len(states) == 2
    again = RandomGenerator(3)
    diagram.SetRandomContext(context, again)
    assert GetTrialSeed(diagram, context) == next(iter(states))


def test_each_seed_draws_other_people_without_a_seed_of_their_own(hall):
    first, second = (RunTrial(hall, seed).recording for seed in (0, 1))
    gaps = abs(first.humans[0, :, :2] - second.humans[0, :, :2])
    assert gaps.max() > 0.5
    assert first == RunTrial(hall).recording
    # Those of seed 0 are those of the number 0.
    fixed = LoadScenario(data=HALL, overrides=["population.seed=0"])
    assert first == RunTrial(fixed, 7).recording


def test_a_diagram_does_not_serve_people_of_another_seed(tmp_path):
    alike = "population.cohorts[0].behaviors={regular: 1}"
    hall = LoadScenario(data=HALL, overrides=[alike])
    diagram = MakeTrialDiagram(hall)
    told = "drawn by seed 0, so it does not serve seed 1: make a diagram"
    context = diagram.CreateDefaultContext()
    with pytest.raises(ValueError, match=told):
        RunTrial(hall, 1, diagram=diagram)
    with pytest.raises(ValueError, match=told):
        SetTrialSeed(diagram, context, 1)
    SetTrialSeed(diagram, context, 0)
    other = MakeTrialDiagram(
        LoadScenario(data=HALL, overrides=[alike, "simulation.seed=1"])
    )
    path = SaveContext(diagram, context, tmp_path / "start.npz")
    with pytest.raises(ValueError, match="drawn by seed 0 in the file"):
        LoadContext(other, path)
    with pytest.raises(ValueError, match="list the people under humans"):
        TransferContext(diagram, context, other)
    LoadContext(diagram, path)
