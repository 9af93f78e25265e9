"""The maps that a planner with maps gives on its ports."""

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator
from hunav_drake.systems.planning import PLANNERS, DwbPlanner, SclPlanner
from hunav_drake.systems.planning.navigation.navigation_system import (
    NavigationSystem,
)
from hunav_drake.systems.world.maps.costs import INSCRIBED, LETHAL
from tests.choices import fast
from tests.systems.planning.navigation.test_navigation import make_task, person

MAPS = ("local_costmap", "global_costmap")
ROBOT = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35]
STANDING = person(1.0, 0.5)


def advanced(planner, *, goal=(6.0, 0.0, 0.0), seconds=0.3):
    """Returns the maps of a robot that stands at the origin before somebody."""
    dut = NavigationSystem(planner, make_task(num_humans=1))
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("robot_state").FixValue(context, ROBOT)
    dut.GetInputPort("human_states").FixValue(context, STANDING)
    if goal is not None:
        dut.GetInputPort("goal").FixValue(context, goal)
    simulator.AdvanceTo(seconds)
    return [dut.GetOutputPort(name).Eval(context) for name in MAPS]


def test_the_local_map_is_around_the_robot_and_the_global_one_everywhere():
    local, whole = advanced(DwbPlanner())
    rows, columns = local.costs.shape
    middle = np.array(local.origin) + 0.5 * local.resolution * np.array(
        [columns, rows]
    )
    np.testing.assert_allclose(middle, [0.0, 0.0], atol=local.resolution)
    # Somebody stands there; at the robot nothing is.
    for costmap in (local, whole):
        assert costmap.cost_at(1.0, 0.5) == LETHAL
        assert costmap.cost_at(0.0, 0.0) < INSCRIBED
    # The walls are on the map of all.
    assert whole.cost_at(3.0, 2.0) == LETHAL
    assert whole.cost_at(6.0, 0.0) == 0


def test_maps_of_scl_have_costs_around_people():
    for plain, social in zip(
        advanced(DwbPlanner()), advanced(SclPlanner()), strict=True
    ):
        assert plain.cost_at(1.0, 1.4) < social.cost_at(1.0, 1.4) < INSCRIBED


@pytest.mark.parametrize("goal", [None, [np.nan] * 3])
def test_without_a_goal_maps_have_no_cells(goal):
    for costmap in advanced(DwbPlanner(), goal=goal):
        assert costmap.costs.size == 0


def test_before_anything_is_decided_maps_have_no_cells():
    diagram = MakeTrialDiagram(
        LoadScenario(filename="passing", overrides=["planner=dwb"])
    )
    context = diagram.CreateDefaultContext()
    for name in MAPS:
        assert diagram.GetOutputPort(name).Eval(context).costs.size == 0


def test_maps_are_not_to_be_written_to():
    for costmap in advanced(DwbPlanner()):
        with pytest.raises(ValueError, match="read-only"):
            costmap.costs[0, 0] = 1


@pytest.mark.parametrize(
    "name", fast(["dwb", "scl", "sfw", "sfm", "orca", "mppi"], "dwb", "sfm")
)
def test_all_planners_with_maps_give_them(name):
    local, whole = advanced(PLANNERS[name](), seconds=0.1)
    assert local.cost_at(1.0, 0.5) == whole.cost_at(1.0, 0.5) == LETHAL


def test_looking_at_maps_changes_nothing_and_a_clone_has_the_same():
    scenario = LoadScenario(
        filename="crossing", overrides=["planner={type: scl, sees: lidar}"]
    )
    diagram = MakeTrialDiagram(scenario)
    ends = []
    for looks in (False, True):
        simulator = MakeTrialSimulator(diagram)
        for k in range(1, 5):
            simulator.AdvanceTo(0.5 * k)
            context = simulator.get_context()
            clone = context.Clone()
            for name in MAPS if looks else ():
                port = diagram.GetOutputPort(name)
                there, here = port.Eval(clone), port.Eval(context)
                np.testing.assert_array_equal(there.costs, here.costs)
                assert there.origin == here.origin
        # What the lidar has met is on them.
        whole = diagram.GetOutputPort("global_costmap").Eval(context)
        assert np.count_nonzero(whole.costs == LETHAL) > 0
        port = diagram.GetOutputPort("robot_state")
        ends.append(port.Eval(simulator.get_context()))
    np.testing.assert_array_equal(*ends)


def test_a_planner_without_maps_has_no_such_ports():
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    assert not any(diagram.HasOutputPort(name) for name in MAPS)
