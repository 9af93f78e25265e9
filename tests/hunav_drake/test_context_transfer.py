"""The state of one trial is taken over into the diagram of another."""

from importlib.resources import files

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    TransferContext,
)
from hunav_drake.systems import robot
from hunav_drake.systems.robot.drives import DifferentialWheels
from hunav_drake.systems.robot.physical_robots import UrdfRobot


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


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ("robot.model=pmb2", "robot cannot be .* was a DifferentialDrive, and"),
        (
            "robot.goal=null",
            "goal cannot be .* ConstantVectorSource, and is no more",
        ),
    ],
)
def test_state_without_a_counterpart_is_refused(changes, words):
    """Neither may a robot stay at its start, nor a goal go away."""
    diagram = MakeTrialDiagram(scenario("passing"))
    other = MakeTrialDiagram(scenario("passing", changes))
    context = diagram.CreateDefaultContext()
    with pytest.raises(ValueError, match=words):
        TransferContext(diagram, context, other)
    with pytest.raises(ValueError, match="cannot be taken over: it"):
        TransferContext(other, other.CreateDefaultContext(), diagram)


def test_another_physical_robot_is_refused(tmp_path):
    """Even where it has as many joints."""
    text = (files(robot) / "models" / "pmb2.sdf").read_text()
    diagrams = []
    for name in ("wheel", "roller"):
        file = tmp_path / f"{name}.sdf"
        file.write_text(text.replace("wheel_joint", f"{name}_joint"))
        changed = scenario("passing")
        changed.robot = UrdfRobot(
            file=str(file),
            base="base",
            drive=DifferentialWheels(
                left_wheel=f"left_{name}_joint",
                right_wheel=f"right_{name}_joint",
                wheel_separation=0.4044,
                wheel_radius=0.0985,
                max_torque=6.0,
            ),
        )
        diagrams.append(MakeTrialDiagram(changed))
    context = diagrams[0].CreateDefaultContext()
    with pytest.raises(ValueError, match=r"plant cannot .* by other joints"):
        TransferContext(diagrams[0], context, diagrams[1])


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (("planner.sees=visible",), ("planner.sees=lidar",)),
        ((), ("planner.sees=visible",)),
        (("planner.sees=lidar",), ()),
        (
            ("sensors=[{type: lidar, num_rays: 9}]",),
            ("sensors=[{type: lidar, num_rays: 11}]",),
        ),
    ],
)
def test_a_planner_may_see_by_other_means(before, after):
    diagram, other = (
        MakeTrialDiagram(scenario("passing", "planner=dwb", *changes))
        for changes in (before, after)
    )
    simulator = at(diagram, 3.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    np.testing.assert_equal(
        ports(other, taken), ports(diagram, simulator.get_context())
    )
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(4.0)
    ahead = ports(other, fork.get_context())[1]
    assert ahead[0] != ports(diagram, simulator.get_context())[1][0]


def test_fixed_inputs_are_taken_over():
    mine = scenario("passing", "evaluator.start=by_trigger")
    diagram = MakeTrialDiagram(mine)
    changed = scenario("passing", "evaluator.start=by_trigger", "planner=orca")
    other = MakeTrialDiagram(changed)
    simulator = MakeTrialSimulator(diagram)
    trigger = diagram.GetInputPort("trigger")
    trigger.FixValue(simulator.get_mutable_context(), 1.0)
    simulator.AdvanceTo(1.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(2.0)
    result = GetTrialResult(changed, other, fork.get_context())
    assert result.recording.times[[0, -1]].tolist() == [0.0, 2.0]
    without = MakeTrialDiagram(scenario("passing"))
    with pytest.raises(ValueError, match="the input trigger has a fixed value"):
        TransferContext(diagram, simulator.get_context(), without)
