"""Trials with a robot that is a body and a lidar that is noisy."""

import hashlib

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    HumanConfig,
    MakeTrialDiagram,
    MakeTrialSimulator,
    Scenario,
)
from hunav_drake.scenario import LidarConfig, SimulationConfig, World
from hunav_drake.systems.crowd import CrowdConfig
from tests.hunav_drake.test_physical_trials import PORTS, seen
from tests.processes import run_python

ALL = (*PORTS, "visible", "scan")
STEP = 0.05
STEPS = 120


def collision(noise=0.03) -> Scenario:
    """Somebody runs into the robot, which sees it by a noisy lidar."""
    return Scenario(
        robot={"type": "pmb2", "start": (0, 0, 0.1), "goal": (6, 0, 0)},
        humans=[
            HumanConfig(
                pose=(2.2, 0.05, 3.1), goals=[(-4, 0)], desired_speed=1.3
            ),
            HumanConfig(pose=(4, -0.2, 3), desired_speed=0.0),
        ],
        crowd=CrowdConfig(robot_gap=0.0),
        world=World(
            walls=[{"type": "box", "center": [2, 2.2], "size": [9, 0.2]}]
        ),
        sensors=[
            LidarConfig(num_rays=180, noise=noise, period=0.1),
            {"type": "visible_people"},
        ],
        simulation=SimulationConfig(
            duration=STEPS * STEP, stuck_time=60, seed=11
        ),
    )


def rows_of(diagram):
    """All that is seen of a trial, at each step."""
    simulator = MakeTrialSimulator(diagram)
    rows = []
    for k in range(STEPS + 1):
        simulator.AdvanceTo(k * STEP)
        rows.append(seen(diagram, simulator.get_context(), ALL))
    return np.array(rows)


@pytest.fixture(scope="module")
def trial():
    diagram = MakeTrialDiagram(collision())
    return diagram, rows_of(diagram)


@pytest.mark.slow
def test_there_is_noise_and_a_contact(trial):
    _, rows = trial
    exact = MakeTrialDiagram(collision(noise=0.0))
    scan = seen(exact, exact.CreateDefaultContext(), ALL)[-180:]
    met = scan < 8
    assert met.sum() > 30
    assert 0.02 < (rows[0, -180:] - scan)[met].std() < 0.04
    contacts = rows[:, 21:37].reshape(-1, 2, 8)
    assert contacts[-1, :, 3].max() > 100
    assert np.isfinite(rows).all()


@pytest.mark.slow
def test_clones_go_on_alike_at_twenty_instants(trial):
    diagram, expected = trial
    rng = np.random.default_rng(5)
    simulator = MakeTrialSimulator(diagram)
    for time in np.sort(rng.uniform(0, (STEPS - 12) * STEP, 20)):
        simulator.AdvanceTo(time)
        clone = Simulator(diagram, simulator.get_context().Clone())
        last = int(time / STEP) + 12
        for k in range(int(time / STEP) + 1, last + 1):
            clone.AdvanceTo(k * STEP)
            np.testing.assert_array_equal(
                seen(diagram, clone.get_context(), ALL), expected[k]
            )


def digest(rows=None) -> str:
    if rows is None:
        rows = rows_of(MakeTrialDiagram(collision()))
    return hashlib.sha256(rows.tobytes()).hexdigest()


@pytest.mark.slow
def test_another_process_gives_the_same_bits(trial):
    script = "from tests.hunav_drake import test_physical_sensors as t"
    result = run_python(f"{script}; print(t.digest())")
    assert result.stdout.strip() == digest(trial[1])
