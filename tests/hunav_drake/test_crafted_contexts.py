"""A Context file that is made up is refused in one line, or does no harm."""

import numpy as np
import pytest

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
)
from hunav_drake.systems.planning.planner_error import PlannerError
from tests.hunav_drake.crafted_contexts import crafted, is_refused


def check_crafted(scenario, count, folder):
    """Loads made-up files; returns how many were refused."""
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(1.0)
    path = SaveContext(diagram, simulator.get_context(), folder / "c.npz")
    with np.load(path) as file:
        whole = dict(file)
    refused = 0
    for arrays in crafted(whole, count):
        np.savez(path, **arrays)
        try:
            refused += is_refused(scenario, diagram, path, 0.2)
        except PlannerError as error:
            # A world of 10^9 m, say: what it needs is told.
            if "take a coarser one" not in str(error):
                raise
    return refused


@pytest.mark.parametrize(
    ("name", "planner", "count"),
    [
        ("passing", "sfw", 20),
        pytest.param("passing", "sfw", 500, marks=pytest.mark.slow),
        pytest.param("reaction_scared", "dwb", 250, marks=pytest.mark.slow),
        pytest.param("passing", "mppi", 250, marks=pytest.mark.slow),
    ],
)
def test_what_is_made_up_is_refused_or_does_no_harm(
    tmp_path, name, planner, count
):
    scenario = LoadScenario(name, overrides=[f"planner={planner}"])
    refused = check_crafted(scenario, count, tmp_path)
    # The rest are numbers that might be, or entries that nothing reads.
    assert refused > 0.5 * count
