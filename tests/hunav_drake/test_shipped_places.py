"""In no shipped trial anybody stands in a wall, furniture or another body.

Those who sit are on furniture.
"""

import numpy as np
import pytest

from hunav_drake import ListScenarios, LoadScenario, RunTrial
from hunav_drake.scenario import draw_people
from hunav_drake.systems.world.obstacles import inside
from tests.walkers import seated

# Bodies may touch, in meters.
TOUCH = 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ListScenarios())
def test_nobody_is_in_furniture_or_in_another_body(name):
    scenario = LoadScenario(filename=name)
    recording = RunTrial(scenario).recording
    radii = np.array([h.contact_radius for h in draw_people(scenario)])
    step = max(round(0.1 / np.diff(recording.times).min()), 1)
    sits = seated(recording)
    for rows, sitting in zip(
        recording.humans[::step], sits[::step], strict=True
    ):
        here = np.isfinite(rows[:, 0])
        p, r = rows[here, :2], radii[here]
        walls = scenario.world.obstacles()
        assert not inside(walls, p[~sitting[here]]).any()
        gaps = np.hypot(*(p[:, None] - p).T) - r[:, None] - r
        np.fill_diagonal(gaps, np.inf)
        assert gaps.min(initial=np.inf) > -TOUCH
