"""Trials that MPPI drives: it arrives, smoothly, and touches nobody."""

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial


def mppi_in(name):
    return LoadScenario(filename=name, overrides=["planner=mppi"])


def gaps(recording):
    """Returns the free distances to people, shape (samples, people)."""
    robot, humans = recording.robot, recording.humans
    away = humans[:, :, :2] - robot[:, None, :2]
    free = np.hypot(away[..., 0], away[..., 1])
    return free - humans[:, :, 6] - robot[:, None, 6]


def jitter(values, samples=5):
    """Returns the deviation from a mean over some 0.1 s of samples each."""
    mean = np.convolve(values, np.full(samples, 1 / samples), mode="valid")
    half = samples // 2
    return float(np.std(values[half:-half] - mean))


@pytest.mark.slow
def test_a_fork_in_the_middle_goes_on_alike():
    """Between people, where controls and noise matter."""
    diagram = MakeTrialDiagram(mppi_in("crossing"))
    simulator = Simulator(diagram)
    simulator.AdvanceTo(4.02)
    fork = Simulator(diagram, simulator.get_context().Clone())
    states = []
    for it in (simulator, fork):
        it.AdvanceTo(6.0)
        context = it.get_context()
        states.append(
            np.concatenate(
                [
                    diagram.GetOutputPort(name).Eval(context)
                    for name in ("robot_state", "velocity_command")
                ]
            )
        )
    np.testing.assert_array_equal(*states)
    assert abs(states[0][-1]) > 0.05


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seeds"),
    [("passing", 2), ("crossing", 4), ("combined", 2), ("cafe", 2)],
)
def test_it_arrives(name, seeds):
    scenario = mppi_in(name)
    diagram = MakeTrialDiagram(scenario)
    for seed in range(seeds):
        result = RunTrial(scenario, seed, diagram=diagram)
        assert result.end_reason == "goal", seed
        recording = result.recording
        if name in ("passing", "crossing"):
            assert gaps(recording).min() > 0.1
        # No jitter: little is left over of half a second's mean.
        speed = np.hypot(*recording.robot[:, 3:5].T)
        assert jitter(speed) < 0.02
        assert jitter(recording.robot[:, 5]) < 0.04
