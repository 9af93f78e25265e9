"""A lidar meets the legs of a table, and people are seen over it."""

import numpy as np
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator

BEHIND_A_TABLE = """
world: {furniture: [{type: table, center: [2, 0]}]}
humans: [{pose: [3.5, 0, 3.14]}]
sensors:
- {type: lidar, height: 0.3, num_rays: 720}
- {type: lidar, name: high, height: 0.72, num_rays: 720, people: discs}
- {type: visible_people}
"""


@pytest.fixture(scope="module")
def output():
    diagram = MakeTrialDiagram(LoadScenario(data=BEHIND_A_TABLE))
    context = diagram.CreateDefaultContext()
    return lambda name: diagram.GetOutputPort(name).Eval(context)


def test_a_low_plane_meets_its_legs_and_who_is_behind(output):
    scan = output("scan")
    ahead = scan[355:366]
    assert 3.3 < ahead.min() < 3.5
    # Thin legs beside, and much free space between them.
    legs = scan[(scan > 1.2) & (scan < 3.0)]
    assert 2 <= len(legs) < 80


def test_a_plane_through_its_top_ends_there(output):
    ahead = output("high_scan")[340:381]
    assert np.ptp(ahead) < 0.1
    assert ahead.max() < 2.0


def test_who_is_behind_it_is_seen(output):
    assert output("visible").tolist() == [1]


BETWEEN = """
world: {furniture: [{type: %s, center: [1.5, 0]}]}
humans: [{pose: [3, 0, 3.14], behavior: scared, radius: 0.3}]
robot: {start: [0, 0, 0]}
sensors:
- {type: lidar, height: 0.3, num_rays: 720, people: discs}
- {type: visible_people}
"""


@pytest.mark.parametrize(("kind", "sees"), [("table", True), ("shelf", False)])
def test_robot_and_people_see_each_other_over_what_is_low(kind, sees):
    """By lidar, detector and behavior tree alike."""
    diagram = MakeTrialDiagram(LoadScenario(data=BETWEEN % kind))
    simulator = MakeTrialSimulator(diagram)
    context = simulator.get_context()

    def output(name):
        return diagram.GetOutputPort(name).Eval(context)

    assert output("visible").tolist() == [sees]
    # Beside the legs of the table, below its top.
    ahead = output("scan")[350:371]
    assert (ahead > 2.6).any() == sees
    simulator.AdvanceTo(0.5)
    assert (output("behavior_status")[0] > 0) == sees
