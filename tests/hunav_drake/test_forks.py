"""A trial that goes on from a clone ends as the one that ran through."""

import math

import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
)


@pytest.fixture(scope="module")
def trial():
    """Returns a diagram, and how its trial ends."""
    scenario = LoadScenario(filename="crossing")
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(scenario.simulation.duration)
    end = simulator.get_context()
    return (
        scenario,
        diagram,
        end.get_time(),
        GetTrialResult(scenario, diagram, end),
    )


# Of the last step, which ends at 10.55 s, and of the start.
STEPS = [0.0, 0.05, 5.0, 10.45, 10.5, 10.55]
TIMES = [
    *(0.001, 0.026, 5.021, 10.4999, 10.501, 10.506, 10.525, 10.5499),
    *STEPS,
    *(math.nextafter(t, math.inf) for t in STEPS),
    *(math.nextafter(t, 0) for t in STEPS[1:]),
]


@pytest.mark.parametrize("time", TIMES)
def test_a_fork_ends_when_and_as_the_original_does(trial, time):
    scenario, diagram, end, expected = trial
    first = MakeTrialSimulator(diagram)
    first.AdvanceTo(time)
    fork = MakeTrialSimulator(diagram, first.get_context().Clone())
    fork.AdvanceTo(scenario.simulation.duration)
    assert fork.get_context().get_time() == end
    result = GetTrialResult(scenario, diagram, fork.get_context())
    assert result.recording == expected.recording
    assert result.end_reason == expected.end_reason
    assert result.metrics.equals(expected.metrics)
