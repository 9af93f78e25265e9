import copy
import math

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
import pytest

from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation import (
    Evaluator,
    EvaluatorConfig,
    RunningMetric,
)
from hunav_drake.systems.evaluation.compute import compute_metrics
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.samples import Sample
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

HUMANS = [
    HumanConfig(pose=(0, 1, 0), behavior="scared", group_id=4),
    HumanConfig(name="Bo", id=9, pose=(0, 2, 0)),
]


def robot_state(x, v=1.0):
    return np.array([x, 0, 0, v, 0, 0, 0.35])


def standing_people(n=2):
    rows = np.zeros((n, 7))
    rows[:, 0] = 2.0
    rows[:, 1] = np.arange(n) * 2.0
    rows[:, 6] = 0.3
    return rows.ravel()


def fix_evaluator_inputs(dut, context, x=0.0, n=2):
    dut.get_robot_state_input_port().FixValue(context, robot_state(x))
    dut.get_human_states_input_port().FixValue(context, standing_people(n))


def running(dut, context):
    values = dut.get_metrics_output_port().Eval(context)
    return {metric: values[metric] for metric in RunningMetric}


class Walk(LeafSystem):
    """A robot that moves 1 m/s along x in steps, with the people."""

    def __init__(self, time_step):
        super().__init__()
        self._time_step = time_step
        self.DeclareDiscreteState(1)
        state = {self.xd_ticket()}
        self.DeclareVectorOutputPort(
            "robot_state", 7, self._CalcRobot, prerequisites_of_calc=state
        )
        self.DeclareVectorOutputPort(
            "human_states",
            14,
            lambda _, output: output.SetFromVector(standing_people()),
            prerequisites_of_calc=state,
        )
        self.DeclareVectorOutputPort(
            "behavior_status", 2, self._CalcStatus, prerequisites_of_calc=state
        )
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._Update)

    def _Update(self, context, state):
        # The number of steps is exact where their sum would not be.
        state[0] = context.get_discrete_state(0)[0] + 1

    def _CalcRobot(self, context, output):
        steps = context.get_discrete_state(0)[0]
        output.SetFromVector(robot_state(steps * self._time_step))

    def _CalcStatus(self, context, output):
        steps = context.get_discrete_state(0)[0]
        output.SetFromVector([steps * self._time_step > 0.5, 0])


def make_walk(time_step=0.05, period=0.1):
    builder = DiagramBuilder()
    walk = builder.AddNamedSystem("walk", Walk(time_step))
    evaluator = builder.AddNamedSystem(
        "evaluator",
        Evaluator(
            HUMANS, time_step=time_step, config=EvaluatorConfig(period=period)
        ),
    )
    for name in ("robot_state", "human_states", "behavior_status"):
        builder.Connect(walk.GetOutputPort(name), evaluator.GetInputPort(name))
    return builder.Build(), evaluator


def recording_of(evaluator, context):
    return evaluator.GetRecording(evaluator.GetMyContextFromRoot(context))


def test_ports_and_their_sizes():
    dut = Evaluator(HUMANS)
    sizes = {
        dut.get_input_port(i).get_name(): dut.get_input_port(i).size()
        for i in range(dut.num_input_ports())
    }
    assert sizes == {
        "robot_state": 7,
        "human_states": 14,
        "behavior_status": 2,
        "contacts": 16,
        "wall_contact": 8,
        "goal": 3,
        "replay": 6,
        "trigger": 1,
        "social_signals": 44,
    }
    assert dut.get_behavior_status_input_port().size() == 2
    assert dut.get_goal_input_port().size() == 3
    assert dut.get_metrics_output_port().size() == len(RunningMetric)
    assert dut.get_recording_output_port().get_name() == "recording"


def test_running_values_follow_at_once_from_the_goal_alone():
    dut = Evaluator(HUMANS)
    metrics = dut.get_metrics_output_port().get_index()
    direct = {
        dut.get_input_port(i).get_name()
        for i in range(dut.num_input_ports())
        if dut.HasDirectFeedthrough(i, metrics)
    }
    assert direct == {"goal"}


@pytest.mark.parametrize(
    ("time_step", "period"),
    [
        (0.01, 0.01),
        (0.01, 0.05),
        (0.01, 0.1),
        (0.05, 0.05),
        (0.05, 0.1),
        (0.05, 1.0),
        (0.01, 1.0),
        (1 / 60, 1 / 20),
        (0.05, 0.15),
    ],
)
def test_samples_come_at_the_multiples_of_the_period(time_step, period):
    """Each sees the state before the step of that instant, for 60 s."""
    diagram, evaluator = make_walk(time_step, period)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(60.0)
    dut = recording_of(evaluator, simulator.get_context())
    every = round(period / time_step)
    count = round(60.0 / period)
    assert len(dut) == count + 1
    steps = np.arange(count + 1) * every
    assert dut.times == pytest.approx(steps * time_step, abs=1e-9)
    # One step late or early would be off by a whole time step.
    assert np.array_equal(dut.robot[:, 0], steps * time_step)


def test_the_recording_ends_at_the_present_instant():
    diagram, evaluator = make_walk(0.05, 0.2)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.35)
    dut = recording_of(evaluator, simulator.get_context())
    assert dut.times.tolist() == pytest.approx([0, 0.2, 0.35])
    assert dut.robot[:, 0].tolist() == pytest.approx([0, 0.2, 0.35])
    # To ask twice adds nothing, and does not shift later samples.
    assert recording_of(evaluator, simulator.get_context()) == dut
    simulator.AdvanceTo(0.5)
    dut = recording_of(evaluator, simulator.get_context())
    assert dut.times.tolist() == pytest.approx([0, 0.2, 0.4, 0.5])


def test_a_recording_at_the_start_has_one_sample():
    dut = Evaluator(HUMANS)
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context, x=3.0)
    recording = dut.GetRecording(context)
    assert recording.times.tolist() == [0.0]
    assert recording.robot[0, 0] == 3.0


def test_a_rounding_error_of_time_is_no_sample():
    dut = Evaluator(HUMANS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(dut, context)
    simulator.AdvanceTo(0.5)
    simulator.AdvancePendingEvents()
    context.SetTime(math.nextafter(0.5, 1))
    assert dut.GetRecording(context).times[-1] == 0.5
    assert len(dut.GetRecording(context)) == 6


def test_who_people_are_comes_along():
    walls = Obstacles.from_points([[1, 2]])
    dut = Evaluator(
        HUMANS, goal_tolerance=0.4, goal_yaw_tolerance=3.5, obstacles=walls
    )
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context)
    recording = dut.GetRecording(context)
    assert recording.human_names == ("human_1", "Bo")
    assert recording.human_ids == (1, 9)
    assert recording.behaviors == ("scared", "regular")
    assert recording.group_ids == (4, -1)
    assert recording.goal_tolerance == 0.4
    assert recording.goal_yaw_tolerance == 3.5
    assert recording.obstacles is walls
    assert recording.humans[0, 1].tolist() == [2, 2, 0, 0, 0, 0, 0.3]


def test_behavior_status_is_recorded():
    diagram, evaluator = make_walk(0.05, 0.25)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.0)
    dut = recording_of(evaluator, simulator.get_context())
    assert dut.behavior_status.T.tolist() == [[0, 0, 0, 1, 1], [0] * 5]


@pytest.mark.parametrize("value", [None, [math.nan, 0, 0], [0, math.inf, 0]])
def test_there_may_be_no_goal(value):
    dut = Evaluator(HUMANS)
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context)
    if value is not None:
        dut.get_goal_input_port().FixValue(context, value)
    assert dut.GetRecording(context).goal is None
    assert math.isnan(running(dut, context)[RunningMetric.GOAL_DISTANCE])


def test_there_may_be_nobody():
    dut = Evaluator([])
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    # A port of no elements may stay unconnected.
    dut.get_robot_state_input_port().FixValue(context, robot_state(0))
    simulator.AdvanceTo(1.0)
    recording = dut.GetRecording(context)
    assert recording.humans.shape == (11, 0, 7)
    dut.get_human_states_input_port().FixValue(context, [])
    assert dut.GetRecording(context) == recording
    values = running(dut, context)
    assert math.isnan(values[RunningMetric.MIN_GAP])
    assert values[RunningMetric.COLLISIONS] == 0


def test_running_values_before_the_first_sample():
    dut = Evaluator(HUMANS)
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context)
    dut.get_goal_input_port().FixValue(context, [1, 1, 0])
    values = list(running(dut, context).values())
    assert values == pytest.approx(
        [0, 0, math.nan, math.nan, math.nan, 0], nan_ok=True
    )


def test_running_values_are_those_of_the_recording():
    diagram, evaluator = make_walk(0.05, 0.1)
    simulator = Simulator(diagram)
    context = evaluator.GetMyMutableContextFromRoot(
        simulator.get_mutable_context()
    )
    evaluator.get_goal_input_port().FixValue(context, [4, 3, 0])
    # Multiples of the period without a rounding error.
    for end in (0.5, 1.6, 3.0):
        simulator.AdvanceTo(end)
        simulator.AdvancePendingEvents()
        values = running(evaluator, context)
        metrics = compute_metrics(evaluator.GetRecording(context))
        for running_metric, name in (
            (RunningMetric.DURATION, "duration"),
            (RunningMetric.PATH_LENGTH, "path_length"),
            (RunningMetric.MIN_GAP, "min_dist_to_people"),
            (RunningMetric.GOAL_DISTANCE, "final_dist_to_target"),
            (RunningMetric.COLLISIONS, "robot_on_person_collisions"),
        ):
            assert values[running_metric] == pytest.approx(metrics[name]), name
    # It went over the first person, who stands at (2, 0).
    assert values[RunningMetric.COLLISIONS] == 1
    assert values[RunningMetric.MIN_GAP] == 0
    assert values[RunningMetric.CLOSEST_GAP] == pytest.approx(1 - 0.65)


def test_the_goal_may_change_without_a_sample():
    dut = Evaluator(HUMANS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(dut, context)
    simulator.AdvanceTo(0.1)
    for x in (1.0, 5.0):
        dut.get_goal_input_port().FixValue(context, [x, 0, 0])
        distance = running(dut, context)[RunningMetric.GOAL_DISTANCE]
        assert distance == x
        assert dut.GetRecording(context).goal == (x, 0, 0)


def test_the_recording_port_gives_the_recording():
    dut = Evaluator(HUMANS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(dut, context)
    port = dut.get_recording_output_port()
    assert isinstance(port.Allocate(), AbstractValue)
    for end in (0.0, 0.35, 0.7):
        simulator.AdvanceTo(end)
        assert port.Eval(context) == dut.GetRecording(context)
    fix_evaluator_inputs(dut, context, x=2.0)
    assert port.Eval(context).robot[-1, 0] == 2.0


def test_two_contexts_do_not_disturb_each_other():
    dut = Evaluator(HUMANS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(dut, context)
    simulator.AdvanceTo(0.5)
    before = context.Clone()
    expected = dut.GetRecording(before)
    fix_evaluator_inputs(dut, context, x=9.0)
    simulator.AdvanceTo(1.0)
    assert dut.GetRecording(before) == expected
    assert len(dut.GetRecording(context)) == 11
    fix_evaluator_inputs(dut, before, x=-5.0)
    Simulator(dut, before).AdvanceTo(1.0)
    assert dut.GetRecording(before).robot[-1, 0] == -5
    assert dut.GetRecording(context).robot[-1, 0] == 9
    for other in (before, context):
        past = dut.GetRecording(other)
        assert np.array_equal(past.robot[:5], expected.robot[:5])


@pytest.mark.parametrize("pause", [0.3, 0.35, 0.5])
def test_a_clone_continues_as_if_nothing_had_been(pause):
    diagram, evaluator = make_walk()
    straight = Simulator(diagram)
    straight.AdvanceTo(2.0)
    paused = Simulator(diagram)
    paused.AdvanceTo(pause)
    clone = Simulator(diagram, paused.get_context().Clone())
    clone.AdvanceTo(2.0)
    assert recording_of(evaluator, clone.get_context()) == recording_of(
        evaluator, straight.get_context()
    )


def make_drive(period):
    """Returns a robot that is a function of time, and its Evaluator."""
    builder = DiagramBuilder()
    ends = np.array([robot_state(0.0), robot_state(9.0)]).T
    robot = builder.AddSystem(
        TrajectorySource(PiecewisePolynomial.FirstOrderHold([0, 9], ends))
    )
    evaluator = builder.AddSystem(
        Evaluator([], time_step=0.05, config=EvaluatorConfig(period=period))
    )
    builder.Connect(
        robot.get_output_port(), evaluator.get_robot_state_input_port()
    )
    return builder.Build(), evaluator


@pytest.mark.parametrize("period", [0.05, 0.1, 0.25])
def test_events_that_are_repeated_at_an_instant_add_no_sample(period):
    diagram, evaluator = make_drive(period)
    straight = Simulator(diagram)
    straight.AdvanceTo(4.0)
    expected = recording_of(evaluator, straight.get_context())
    paused = Simulator(diagram)
    # The second time does the updates of the instant that the first reached.
    paused.AdvanceTo(2.0)
    paused.AdvanceTo(2.0)
    clone = paused.get_context().Clone()
    at_pause = recording_of(evaluator, clone)
    other = Simulator(diagram, clone)
    other.AdvanceTo(2.0)
    other.AdvanceTo(2.0)
    assert recording_of(evaluator, clone) == at_pause
    other.AdvanceTo(4.0)
    assert recording_of(evaluator, clone) == expected


@pytest.mark.parametrize("period", [0.1, 0.15, 0.5])
def test_states_of_the_next_step_are_never_those_of_the_present(period):
    """Once its updates are done, an instant has the states of the next."""
    diagram, evaluator = make_walk(period=period)
    simulator = Simulator(diagram)
    context = simulator.get_context()
    port = evaluator.get_recording_output_port()
    own = evaluator.GetMyContextFromRoot(context)
    for end in (0.0, 3.25, 3.25, 3.25, 3.3, 3.3, 3.35):
        simulator.AdvanceTo(end)
        recording = evaluator.GetRecording(own)
        assert port.Eval(own) == recording
        np.testing.assert_allclose(recording.robot[:, 0], recording.times)
        clone = context.Clone()
        assert recording_of(evaluator, clone) == recording
        # A simulator may begin just after an instant.
        clone.SetTime(np.nextafter(end, np.inf))
        assert np.allclose(
            recording_of(evaluator, clone).robot[:, 0], recording.times
        )
    assert recording.times[-1] == 3.35


def test_forks_share_their_past():
    dut = Evaluator(HUMANS)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(dut, context)
    simulator.AdvanceTo(0.5)
    fork = context.Clone()
    node = context.get_abstract_state(0).get_value()
    assert node.count == 5
    assert fork.get_abstract_state(0).get_value() is node


def test_an_unconnected_robot_is_an_error_that_names_the_port():
    dut = Evaluator(HUMANS)
    with pytest.raises(RuntimeError, match="robot_state"):
        dut.GetRecording(dut.CreateDefaultContext())


def test_a_state_that_is_not_finite_is_an_error_in_the_recording():
    dut = Evaluator(HUMANS)
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context, x=math.nan)
    with pytest.raises(ValueError, match=r"robot: .* x must be finite"):
        dut.GetRecording(context)


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"config": EvaluatorConfig(period=0.12)}, "multiple of time_step"),
        ({"config": EvaluatorConfig(period=0.02)}, "nearest: 0.05"),
        ({"time_step": -0.1}, "must be positive"),
        ({"goal_tolerance": 0.0}, "goal_tolerance: must be positive"),
    ],
)
def test_impossible_settings_are_errors(kwargs, message):
    with pytest.raises(ValueError, match=message):
        Evaluator(HUMANS, **kwargs)


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
@pytest.mark.parametrize("field", ["period", "timeout"])
def test_impossible_times_are_errors(field, value):
    with pytest.raises(ValueError, match=field):
        EvaluatorConfig(**{field: value})


def test_equal_ids_are_an_error_at_once():
    with pytest.raises(ValueError, match="human_ids: must differ"):
        Evaluator([HumanConfig(pose=(0, 0, 0), id=3)] * 2)


def test_a_very_long_list_of_samples_is_no_deeper_than_a_short_one():
    node = Sample.start(1)
    row = np.zeros(7)
    for k in range(200_000):
        node = Sample(node, k * 0.1, row, row, None)
    assert copy.deepcopy(node) is node
    assert AbstractValue.Make(node).Clone().get_value() is node
    assert len(node.nodes()) == 200_000
    del node


def test_running_values_of_a_long_list_come_without_recursion():
    node = Sample.start(0)
    nobody = np.zeros(0)
    for k in range(5000):
        node = Sample(node, k * 0.1, robot_state(k * 0.1), nobody, None)
    assert node.running.path_length == pytest.approx(499.9)
    assert node.running is node.running


def test_a_recording_outlives_its_context():
    dut = Evaluator(HUMANS)
    context = dut.CreateDefaultContext()
    fix_evaluator_inputs(dut, context)
    recording = dut.GetRecording(context)
    fix_evaluator_inputs(dut, context, x=7.0)
    del context
    assert isinstance(recording, Recording)
    assert recording.robot[0, 0] == 0


class Knocks(LeafSystem):
    """Two people: one is hit three times, the other once, before all that."""

    def __init__(self, time_step):
        super().__init__()
        self._time_step = time_step
        self.DeclareVectorOutputPort("contacts", 16, self._Calc)

    def _Calc(self, context, output):
        step = round(context.get_time() / self._time_step)
        rows = np.zeros((2, 8))
        # First step, end step, force and person.
        for begin, end, force, who in (
            *((2, 8, 900.0, 1), (41, 46, 100.0, 0)),
            *((50, 55, 5.0, 0), (90, 95, 20.0, 0)),
        ):
            if step >= begin:
                rows[who, Contact.LASTS] = step < end
                rows[who, Contact.PEAK_FORCE] = force
                rows[who, Contact.IMPULSE] += 1
        output.SetFromVector(rows.ravel())


@pytest.mark.parametrize("period", [0.05, 0.1, 1.0, 2.05])
@pytest.mark.parametrize("pause", [0.0, 2.4])
def test_peaks_of_contacts_between_samples_count(period, pause):
    """Whatever the period; but not those from before the recording."""
    builder = DiagramBuilder()
    knocks = builder.AddSystem(Knocks(0.05))
    evaluator = builder.AddSystem(
        Evaluator(
            HUMANS,
            config=EvaluatorConfig(period=period, start="at_goal_command"),
            feels_forces=True,
        )
    )
    builder.Connect(
        knocks.get_output_port(), evaluator.get_contacts_input_port()
    )
    builder.ExportInput(evaluator.get_goal_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    fix_evaluator_inputs(
        evaluator, evaluator.GetMyMutableContextFromRoot(context)
    )
    goal = diagram.get_input_port()
    goal.FixValue(context, np.full(3, np.nan))
    simulator.AdvanceTo(1.99)
    goal.FixValue(context, np.zeros(3))
    simulator.AdvanceTo(1.99 + pause)
    fork = Simulator(diagram, context.Clone())
    for run in (simulator, fork):
        run.AdvanceTo(5.0)
    recording = recording_of(evaluator, context)
    assert compute_metrics(recording)["max_contact_force"] == 100.0
    peaks = recording.contacts[..., Contact.PEAK_FORCE]
    np.testing.assert_array_equal(peaks[-1], [100.0, 0.0])
    assert (np.diff(peaks, axis=0) >= 0).all()
    assert recording == recording_of(evaluator, fork.get_context())
