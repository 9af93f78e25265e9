"""The state of one trial is taken over into the diagram of another."""

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    TransferContext,
)


def scenario(name, *overrides):
    return LoadScenario(filename=name, overrides=list(overrides))


def at(diagram, time):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    return simulator


def ports(diagram, context):
    return [
        diagram.GetOutputPort(name).Eval(context)
        for name in ("human_states", "robot_state")
    ]


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("passing", ()),
        ("cafe", ("planner=dwb",)),
        ("combined", ("planner=mppi",)),
        ("station", ()),
        ("crossing", ("robot.model=pmb2",)),
    ],
)
def test_another_diagram_of_the_scenario_goes_on_alike(name, overrides):
    mine = scenario(name, *overrides)
    diagram, other = MakeTrialDiagram(mine), MakeTrialDiagram(mine)
    simulator = at(diagram, 3.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    fork = MakeTrialSimulator(other, taken)
    for each in (simulator, fork):
        each.AdvanceTo(6.0)
    np.testing.assert_equal(
        ports(diagram, simulator.get_context()),
        ports(other, fork.get_context()),
    )


def test_another_planner_begins_at_the_same_instant():
    mine = scenario("cafe", "planner=dwb")
    diagram = MakeTrialDiagram(mine)
    simulator = at(diagram, 4.0)
    before = ports(diagram, simulator.get_context())
    changed = scenario("cafe", "planner=sfw")
    other = MakeTrialDiagram(changed)
    taken = TransferContext(diagram, simulator.get_context(), other)
    assert taken.get_time() == 4.0
    np.testing.assert_equal(ports(other, taken), before)
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(8.0)
    simulator.AdvanceTo(8.0)
    robots = [
        diagram_.GetOutputPort("robot_state").Eval(it.get_context())
        for diagram_, it in ((diagram, simulator), (other, fork))
    ]
    assert not np.array_equal(*robots)
    # The recording is of the whole trial.
    result = GetTrialResult(changed, other, fork.get_context())
    assert result.recording.times[0] == 0.0


def test_the_command_is_taken_over_and_the_memory_is_not():
    diagram = MakeTrialDiagram(scenario("passing", "planner=dwb"))
    simulator = at(diagram, 5.0)
    other = MakeTrialDiagram(scenario("passing", "planner=pursuit"))
    taken = TransferContext(diagram, simulator.get_context(), other)
    commands = [
        it.GetSubsystemByName("planner")
        .GetOutputPort("velocity_command")
        .Eval(it.GetSubsystemByName("planner").GetMyContextFromRoot(context))
        for it, context in ((diagram, simulator.get_context()), (other, taken))
    ]
    assert commands[0][0] > 0.3
    np.testing.assert_array_equal(*commands)


def test_the_first_context_is_not_changed():
    diagram = MakeTrialDiagram(scenario("passing"))
    simulator = at(diagram, 3.0)
    run_through = at(diagram, 6.0)
    other = MakeTrialDiagram(scenario("passing", "planner=orca"))
    taken = TransferContext(diagram, simulator.get_context(), other)
    MakeTrialSimulator(other, taken).AdvanceTo(6.0)
    simulator.AdvanceTo(6.0)
    np.testing.assert_equal(
        ports(diagram, simulator.get_context()),
        ports(diagram, run_through.get_context()),
    )


def test_other_people_are_refused():
    diagram = MakeTrialDiagram(scenario("cafe"))
    context = diagram.CreateDefaultContext()
    other = MakeTrialDiagram(scenario("passing"))
    with pytest.raises(ValueError, match="humans/crowd cannot be taken over"):
        TransferContext(diagram, context, other)


def test_another_behavior_is_refused():
    diagram = MakeTrialDiagram(scenario("cafe"))
    context = diagram.CreateDefaultContext()
    changed = scenario("cafe")
    changed.humans[0].behavior = "threatening"
    other = MakeTrialDiagram(changed)
    with pytest.raises(ValueError, match="humans/behavior"):
        TransferContext(diagram, context, other)
