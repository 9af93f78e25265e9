"""When the Evaluator begins and ends to record."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    MatrixGain,
    Multiplexer,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial
import pytest

from hunav_drake.systems.evaluation import (
    Evaluator,
    EvaluatorConfig,
    RunningMetric,
)
from hunav_drake.systems.evaluation.compute import compute_metrics
from hunav_drake.systems.people.human_config import HumanConfig

NOWHERE = [math.nan] * 3


def make_evaluator(*, goal_tolerance=0.25, goal_yaw_tolerance=0.25, **config):
    """Returns an Evaluator of nobody, and a Simulator of it alone."""
    dut = Evaluator(
        [],
        config=EvaluatorConfig(**config),
        time_step=0.1,
        goal_tolerance=goal_tolerance,
        goal_yaw_tolerance=goal_yaw_tolerance,
    )
    return dut, Simulator(dut)


def drive(dut, simulator, until, *, goal=None, trigger=None):
    """Drives at 1 m/s along x until a time, with these inputs."""
    context = simulator.get_mutable_context()
    if goal is not None:
        dut.get_goal_input_port().FixValue(context, goal)
    if trigger is not None:
        dut.get_trigger_input_port().FixValue(context, [trigger])
    # The instants of updates are these products.
    first = round(context.get_time() / 0.1)
    for k in range(first, round(until / 0.1)):
        robot = [k * 0.1, 0, 0, 1, 0, 0, 0.3]
        dut.get_robot_state_input_port().FixValue(context, robot)
        simulator.AdvanceTo((k + 1) * 0.1)
    # The present is that of the last input.
    robot = [context.get_time(), 0, 0, 1, 0, 0, 0.3]
    dut.get_robot_state_input_port().FixValue(context, robot)
    return context


def test_it_waits_for_the_goal():
    dut, simulator = make_evaluator(start="at_goal_command")
    context = drive(dut, simulator, 1.0)
    with pytest.raises(RuntimeError, match=r"t = 1 s; it waits.*'goal'"):
        dut.GetRecording(context)
    drive(dut, simulator, 1.5, goal=NOWHERE)
    with pytest.raises(RuntimeError, match="nothing has been recorded"):
        dut.GetRecording(context)
    drive(dut, simulator, 3.0, goal=[9, 0, 0])
    recording = dut.GetRecording(context)
    assert recording.times[0] == pytest.approx(1.5)
    assert recording.times[-1] == pytest.approx(3.0)
    assert recording.goal == (9, 0, 0)
    # It goes on when the goal is taken back.
    drive(dut, simulator, 4.0, goal=NOWHERE)
    assert dut.GetRecording(context).times[-1] == pytest.approx(4.0)


def test_it_records_from_the_rise_of_the_trigger_to_its_fall():
    dut, simulator = make_evaluator(start="by_trigger")
    context = drive(dut, simulator, 1.0, trigger=0.5)
    with pytest.raises(RuntimeError, match="waits for its port 'trigger'"):
        dut.GetRecording(context)
    drive(dut, simulator, 2.0, trigger=0.6)
    assert dut.GetRecording(context).times[-1] == pytest.approx(2.0)
    drive(dut, simulator, 3.0, trigger=0.0)
    expected = dut.GetRecording(context)
    assert expected.times[0] == pytest.approx(1.0)
    assert expected.times[-1] == pytest.approx(1.9)
    # A second rise begins nothing anew.
    drive(dut, simulator, 4.0, trigger=1.0)
    assert dut.GetRecording(context) == expected
    values = dut.get_metrics_output_port().Eval(context)
    assert values[RunningMetric.DURATION] == pytest.approx(0.9)


@pytest.mark.parametrize("start", ["at_once", "at_goal_command"])
def test_a_falling_trigger_ends_any_recording(start):
    dut, simulator = make_evaluator(start=start)
    # One that has not been high does not fall.
    drive(dut, simulator, 1.0, goal=[9, 0, 0], trigger=0.0)
    drive(dut, simulator, 2.0, trigger=1.0)
    context = drive(dut, simulator, 3.0)
    assert dut.GetRecording(context).times[0] == 0
    assert dut.GetRecording(context).times[-1] == pytest.approx(3.0)
    high = context.Clone()
    # It has fallen at the present instant already, before any update.
    dut.get_trigger_input_port().FixValue(context, [0.5])
    assert dut.GetRecording(context).times[-1] == pytest.approx(2.9)
    drive(dut, simulator, 4.0)
    expected = dut.GetRecording(context)
    assert expected.times[-1] == pytest.approx(2.9)
    # A second rise begins nothing anew.
    drive(dut, simulator, 5.0, goal=[7, 0, 0], trigger=1.0)
    assert dut.GetRecording(context) == expected
    drive(dut, Simulator(dut, high), 4.0)
    assert dut.GetRecording(high).times[-1] == pytest.approx(4.0)


def test_a_trigger_that_falls_before_the_start_ends_nothing():
    dut, simulator = make_evaluator(start="at_goal_command")
    drive(dut, simulator, 1.0, trigger=1.0)
    drive(dut, simulator, 2.0, trigger=0.0)
    context = drive(dut, simulator, 3.0, goal=[9, 0, 0])
    assert dut.GetRecording(context).times[0] == pytest.approx(2.0)
    assert dut.GetRecording(context).times[-1] == pytest.approx(3.0)


def test_an_unconnected_trigger_is_an_error_that_names_it():
    dut, simulator = make_evaluator(start="by_trigger")
    with pytest.raises(RuntimeError, match="trigger"):
        drive(dut, simulator, 0.3)


def test_it_stops_at_the_goal_and_keeps_it():
    dut, simulator = make_evaluator(stop_at_goal=True, goal_tolerance=0.25)
    context = drive(dut, simulator, 3.0, goal=[2, 0, 0.1])
    expected = dut.GetRecording(context)
    assert expected.times[-1] == pytest.approx(1.8)
    assert compute_metrics(expected)["completed"] == 1
    drive(dut, simulator, 5.0, goal=[7, 0, 0])
    assert dut.GetRecording(context) == expected
    assert expected.goal == (2, 0, 0.1)
    values = dut.get_metrics_output_port().Eval(context)
    assert values[RunningMetric.GOAL_DISTANCE] == pytest.approx(0.2)


def test_the_heading_counts_at_the_goal():
    dut, simulator = make_evaluator(stop_at_goal=True, goal_yaw_tolerance=0.2)
    context = drive(dut, simulator, 3.0, goal=[2, 0, 0.3])
    assert dut.GetRecording(context).times[-1] == pytest.approx(3.0)


def test_it_stops_at_the_timeout_since_its_start():
    dut, simulator = make_evaluator(start="at_goal_command", timeout=1.2)
    drive(dut, simulator, 1.0)
    context = drive(dut, simulator, 4.0, goal=[9, 0, 0])
    recording = dut.GetRecording(context)
    assert recording.times[0] == pytest.approx(1.0)
    assert recording.times[-1] == pytest.approx(2.2)
    assert recording.goal == (9, 0, 0)


def test_without_settings_it_goes_on_for_ever():
    dut, simulator = make_evaluator()
    context = drive(dut, simulator, 5.0, goal=[2, 0, 0])
    assert dut.GetRecording(context).times[-1] == pytest.approx(5.0)


def test_where_it_stands_is_in_the_context():
    dut, simulator = make_evaluator(start="at_goal_command", stop_at_goal=True)
    context = drive(dut, simulator, 1.0)
    waiting = context.Clone()
    drive(dut, simulator, 3.0, goal=[2, 0, 0])
    ended = context.Clone()
    drive(dut, simulator, 4.0)
    assert dut.GetRecording(ended) == dut.GetRecording(context)
    other = Simulator(dut, waiting)
    drive(dut, other, 2.0, goal=[9, 0, 0])
    assert dut.GetRecording(waiting).goal == (9, 0, 0)
    assert len(dut.GetRecording(waiting)) == 11
    assert dut.GetRecording(context).goal == (2, 0, 0)


@pytest.mark.parametrize(
    ("field", "value"), [("start", "later"), ("stop_at_goal", 1)]
)
def test_impossible_windows_are_errors(field, value):
    with pytest.raises(ValueError, match=field):
        make_evaluator(**{field: value})


def test_it_stands_alone_beside_any_robot_and_moving_bodies():
    """No part of a trial is needed: a robot and bodies of Drake's own."""
    builder = DiagramBuilder()
    times = [0.0, 10.0]

    def body(start, end, radius):
        v = (np.array(end) - start) / 10.0
        a = [*start, math.atan2(v[1], v[0]), *v, 0, radius]
        b = [*end, math.atan2(v[1], v[0]), *v, 0, radius]
        return builder.AddSystem(
            TrajectorySource(
                PiecewisePolynomial.FirstOrderHold(times, np.array([a, b]).T)
            )
        )

    robot = body((0, 0), (5, 0), 0.3)
    bodies = [body((5, 1), (0, 1), 0.2), body((5, -2), (0, -2), 0.2)]
    mux = builder.AddSystem(Multiplexer([7, 7]))
    goal = builder.AddSystem(ConstantVectorSource([5, 0, 0]))
    same = builder.AddSystem(MatrixGain(D=np.eye(3)))
    dut = builder.AddSystem(
        Evaluator(
            [HumanConfig(pose=(0, 0, 0))] * 2,
            config=EvaluatorConfig(start="at_goal_command", stop_at_goal=True),
        )
    )
    for i, source in enumerate(bodies):
        builder.Connect(source.get_output_port(), mux.get_input_port(i))
    for source, port in (
        (robot, dut.get_robot_state_input_port()),
        (mux, dut.get_human_states_input_port()),
        (goal, same.get_input_port()),
        (same, dut.get_goal_input_port()),
    ):
        builder.Connect(source.get_output_port(), port)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(10.0)
    context = dut.GetMyContextFromRoot(simulator.get_context())
    v = compute_metrics(dut.GetRecording(context))
    assert v["completed"] == 1
    assert v["time_to_reach_goal"] == pytest.approx(9.6)
    assert v["path_length"] == pytest.approx(4.8)
    assert v["min_dist_to_people"] == pytest.approx(1 - 0.5)
    assert v["avg_pedestrian_velocity"] == pytest.approx(0.5)
