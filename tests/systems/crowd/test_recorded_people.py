"""People who follow a recording, and are handed over to the crowd."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OUTSIDE,
    STATE_SIZE,
    Command,
    is_outside,
)
from hunav_drake.systems.crowd import OpenCrowd, RecordedPeople
from hunav_drake.systems.crowd.replay import MEMORY_SIZE, TRACK_SIZE
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.track_config import TrackConfig
from hunav_drake.systems.people.tracks import Track, motion_at

STEP = 0.05
TIMES = np.arange(0.0, 12.1, 0.4)
CURVE = Track(
    1, TIMES, np.column_stack([1.2 * TIMES - 6, 0.3 * np.sin(0.7 * TIMES)])
)
LATE = Track(2, TIMES[5:20], CURVE.positions[5:20] + np.array([0.0, 3.0]))
STILL = Track(
    3, TIMES, np.column_stack([np.maximum(TIMES - 6.0, 0.0), 0.0 * TIMES])
)
FAR = (500.0, 500.0)


def human(track, mode="hand_over", **options):
    config = TrackConfig(file="none", id=track.id, mode=mode, **options)
    return HumanConfig(pose=[0, 0, 0], track=config)


def make(tracks, mode="hand_over", listed=(), **options):
    """Returns the diagram of recorded people, and others who stand."""
    humans = [human(it, mode, **options) for it in tracks] + [*listed]
    given = [*tracks, *(None for _ in listed)]
    builder = DiagramBuilder()
    dut = builder.AddNamedSystem(
        "recorded", RecordedPeople(given, humans, time_step=STEP)
    )
    crowd = builder.AddNamedSystem(
        "crowd", OpenCrowd(humans, tracks=dut.StartRows(), time_step=STEP)
    )
    builder.Connect(
        crowd.get_human_states_output_port(), dut.GetInputPort("human_states")
    )
    builder.Connect(
        dut.GetOutputPort("commands"), crowd.get_commands_input_port()
    )
    builder.Connect(dut.GetOutputPort("tracks"), crowd.get_tracks_input_port())
    builder.ExportInput(dut.GetInputPort("robot_states"), "robot")
    builder.ConnectInput("robot", crowd.get_robot_states_input_port())
    builder.ExportInput(dut.GetInputPort("commands"), "commands")
    builder.ExportOutput(crowd.get_human_states_output_port(), "humans")
    builder.ExportOutput(dut.GetOutputPort("replay"), "replay")
    return builder.Build()


def fix(diagram, context, robot):
    """Fixes the robot's place, and commands to go nowhere."""
    row = [*robot, 0.0, 0.0, 0.0, 0.0, 0.3]
    diagram.GetInputPort("robot").FixValue(context, row)
    port = diagram.GetInputPort("commands")
    if not port.HasValue(context):
        port.FixValue(context, np.zeros(port.size()))


def run(diagram, robot_at, steps=260, context=None, start=0):
    """Returns the people (t, n, 7) and replay (t, n, 3) at each step.

    The context is that before the updates of the first step, and becomes that
    before those of the last one.
    """
    context = context or diagram.CreateDefaultContext()
    fix(diagram, context, robot_at(start))
    simulator = None
    humans, replay = [], []
    for k in range(start, steps + 1):
        if k > start:
            # (A new simulator makes the updates of its first instant.)
            simulator = simulator or Simulator(diagram, context)
            simulator.AdvanceTo(k * STEP)
        fix(diagram, context, robot_at(k))
        for port, rows, size in (
            ("humans", humans, STATE_SIZE),
            ("replay", replay, 3),
        ):
            values = diagram.GetOutputPort(port).Eval(context)
            rows.append(values.reshape(-1, size))
    return np.array(humans), np.array(replay)


def with_robot_in_the_middle(k):
    """The place of a robot that people meet, and that then goes away."""
    return (-1.0, 0.1) if k < 150 else FAR


@pytest.mark.parametrize("robot", [FAR, (0.0, 0.0), (-6.0, 0.0)])
def test_blind_people_are_on_the_spline_whatever_the_robot_does(robot):
    humans, replay = run(make([CURVE, LATE], "blind"), lambda k: robot)
    times = np.arange(len(humans)) * STEP
    for i, track in enumerate([CURVE, LATE]):
        first, last = track.times[[0, -1]]
        here = (times >= first - 1e-9) & (times <= last + 1e-9)
        assert (is_outside(humans[:, i]) == ~here).all()
        motion = motion_at(track, times[here])
        rows = humans[here, i]
        assert abs(rows[:, :2] - motion.positions).max() < 1e-12
        inner = slice(0, -1)  # (After its last row a track is at rest.)
        speeds = abs(rows[:, 3:5] - motion.velocities)[inner]
        assert speeds.max() < 1e-12
        assert abs(np.unwrap(rows[:, 2]) - np.unwrap(motion.yaws)).max() < 1e-9
        assert (replay[here, i, 0] == 1).all()
        assert replay[here, i, 1:].max() < 1e-12
        assert (humans[~here, i] == [OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0]).all()
        assert (replay[~here, i] == [0, -1, -1]).all()


def test_far_from_the_robot_hand_over_is_blind():
    humans, replay = run(make([CURVE, LATE]), lambda k: FAR)
    blind, _ = run(make([CURVE, LATE], "blind"), lambda k: FAR)
    assert (humans == blind).all()
    assert replay[..., 1].max() < 1e-12


def test_people_are_handed_over_near_the_robot_and_come_back_late():
    humans, replay = run(make([CURVE]), with_robot_in_the_middle)
    mode = replay[:, 0, 0]
    away = np.hypot(*(humans[:, 0, :2] - [-1.0, 0.1]).T)
    first, last = np.flatnonzero(mode == 2)[[0, -1]]
    # The state after the switch is the first of the motion model.
    assert away[first - 1] < 2.0 <= away[first - 2]
    assert (mode[first : last + 1] == 2).all()
    assert last == 150 or away[last] > 3.0
    # It is back on its path after the offset has decayed, and still late.
    after = last + 1 + round(2.0 / STEP)
    here = mode > 0
    at_time, at_phase = replay[:, 0, 1], replay[:, 0, 2]
    assert at_phase[after:][here[after:]].max() < 1e-9
    assert at_time[after : after + 10].min() > 0.02
    assert at_time[:first].max() == 0.0 or at_time[:first].max() < 1e-12


def test_no_hand_over_changes_a_velocity_by_a_jump():
    humans, replay = run(make([CURVE]), with_robot_in_the_middle)
    mode = replay[:, 0, 0]
    change = np.hypot(*np.diff(humans[:, 0, 3:5], axis=0).T)
    switches = (mode[1:] != mode[:-1]) & (mode[1:] > 0) & (mode[:-1] > 0)
    assert switches.sum() >= 2
    assert change[switches].max() < 0.15
    assert change[(mode[1:] == 1) & (mode[:-1] == 1)].max() < 0.15


def test_the_place_is_that_of_the_velocity_while_an_offset_decays():
    humans, replay = run(make([CURVE]), with_robot_in_the_middle)
    mode = replay[:, 0, 0]
    back = np.flatnonzero((mode[1:] == 1) & (mode[:-1] == 2))[0] + 1
    rows = humans[back : back + 16, 0]
    between = (rows[1:, 3:5] + rows[:-1, 3:5]) / 2
    assert np.allclose(np.diff(rows[:, :2], axis=0) / STEP, between, atol=0.01)


def test_reactive_people_enter_as_recorded_and_leave_at_the_end():
    humans, replay = run(make([LATE], "reactive"), lambda k: FAR, 320)
    here = np.flatnonzero(~is_outside(humans[:, 0]))
    assert here[0] == round(LATE.times[0] / STEP)
    assert np.allclose(humans[here[0], 0, :2], LATE.positions[0])
    assert (np.diff(here) == 1).all()
    assert here[-1] < 320
    assert (replay[here[1:], 0, 0] == 2).all()
    assert np.hypot(*(humans[here[-1], 0, :2] - LATE.positions[-1])) < 0.3


def test_time_passes_for_reactive_people_who_stood():
    humans, _ = run(make([STILL], "reactive"), lambda k: FAR, 300)
    here = ~is_outside(humans[:, 0])
    assert np.hypot(*humans[100, 0, :2]) < 0.2
    assert humans[here, 0, 0].max() > 5.5
    assert not here[-1]


def test_others_make_way_for_people_whose_states_are_given():
    listed = HumanConfig(pose=[0.0, 0.05, 0.0])
    humans, _ = run(make([CURVE], "blind", [listed]), lambda k: FAR, 200)
    apart = np.hypot(*(humans[:, 0, :2] - humans[:, 1, :2]).T)
    both = human(CURVE).contact_radius + listed.contact_radius
    assert apart.min() < both + 0.1
    assert apart.min() > both - 0.02
    assert np.hypot(*(humans[:, 1, :2] - [0.0, 0.05]).T).max() > 0.1


@pytest.mark.parametrize("step", [70, 110, 150, 151, 160])
def test_a_clone_has_the_same_future(step):
    diagram = make([CURVE, LATE, STILL])
    expected, _ = run(diagram, with_robot_in_the_middle)
    context = diagram.CreateDefaultContext()
    run(diagram, with_robot_in_the_middle, step, context)
    clone = context.Clone()
    for each in (clone, context):
        humans, _ = run(
            diagram, with_robot_in_the_middle, context=each, start=step
        )
        assert (humans == expected[step:]).all()


def test_two_contexts_do_not_disturb_each_other():
    diagram = make([CURVE, STILL])
    near, far = (diagram.CreateDefaultContext() for _ in range(2))
    for k in range(0, 200, 20):
        run(diagram, with_robot_in_the_middle, k + 20, near, k)
        run(diagram, lambda _: FAR, k + 20, far, k)
    alone, _ = run(diagram, lambda _: FAR, 200)
    states = diagram.GetOutputPort("humans").Eval(far)
    assert (states.reshape(-1, STATE_SIZE) == alone[-1]).all()


def test_the_rest_of_a_command_passes():
    diagram = make([CURVE], "reactive")
    context = diagram.CreateDefaultContext()
    commands = np.arange(1.0, 1.0 + COMMAND_SIZE)
    diagram.GetInputPort("commands").FixValue(context, commands)
    fix(diagram, context, FAR)
    dut = diagram.GetSubsystemByName("recorded")
    own = dut.GetMyContextFromRoot(context)
    passed = dut.GetOutputPort("commands").Eval(own)
    changed = [
        *(Command.GOAL_X, Command.GOAL_Y, Command.GOAL_RADIUS),
        *(Command.HAS_GOAL, Command.DESIRED_SPEED, Command.MAX_SPEED),
    ]
    kept = np.setdiff1d(np.arange(COMMAND_SIZE), changed)
    assert (passed[kept] == commands[kept]).all()
    ahead = motion_at(CURVE, [1.5])
    assert np.allclose(passed[[0, 1]], ahead.positions[0], atol=1e-12)
    speed = np.hypot(*motion_at(CURVE, [0.0]).velocities[0])
    assert passed[Command.DESIRED_SPEED] == pytest.approx(speed)


def test_ports():
    dut = RecordedPeople(
        [CURVE, None], [human(CURVE), HumanConfig(pose=[0, 0, 0])]
    )
    sizes = {
        dut.get_output_port(i).get_name(): dut.get_output_port(i).size()
        for i in range(dut.num_output_ports())
    }
    assert sizes == {
        "commands": 2 * COMMAND_SIZE,
        "tracks": 2 * TRACK_SIZE,
        "replay": 6,
    }
    assert dut.GetInputPort("robot_states").size() == STATE_SIZE
    alone = RecordedPeople([CURVE], [human(CURVE)], num_robots=0)
    assert not alone.HasInputPort("robot_states")
    assert dut.HasDirectFeedthrough(0, 2) or dut.HasAnyDirectFeedthrough()


@pytest.mark.parametrize(
    ("tracks", "humans", "message"),
    [
        ([], [human(CURVE)], "for each of 1 people, got 0"),
        ([None], [human(CURVE)], r"humans\[0\]: .* go together"),
        (
            [CURVE],
            [HumanConfig(pose=[0, 0, 0])],
            r"humans\[0\]: .* a recording alone",
        ),
        (
            [CURVE._replace(times=TIMES[::-1])],
            [human(CURVE)],
            "at ascending times",
        ),
        (
            [CURVE._replace(positions=np.full((31, 2), np.nan))],
            [human(CURVE)],
            "finite rows",
        ),
    ],
)
def test_faults_are_told(tracks, humans, message):
    with pytest.raises(ValueError, match=message):
        RecordedPeople(tracks, humans)


def test_faults_of_the_crowds_rows_are_told():
    with pytest.raises(ValueError, match=r"tracks must have shape \(1, 7\)"):
        OpenCrowd([human(CURVE)], tracks=np.zeros((2, 7)))
    crowd = OpenCrowd([human(CURVE)])
    with pytest.raises(ValueError, match="has no port tracks"):
        crowd.get_tracks_input_port()


def test_a_memory_that_nobody_can_have_is_told():
    dut = RecordedPeople([CURVE], [human(CURVE)])
    context = dut.CreateDefaultContext()
    dut.CheckContext(context)
    wrong = np.zeros(MEMORY_SIZE)
    wrong[0] = 0.5
    context.SetDiscreteState(1, wrong)
    with pytest.raises(ValueError, match=r"memory of humans\[0\]"):
        dut.CheckContext(context)


def test_nobody_is_handed_over_at_the_end_of_a_recording():
    once = Track(1, np.zeros(1), np.zeros((1, 2)))
    for mode in ("hand_over", "reactive"):
        dut = RecordedPeople([once], [human(once, mode)], time_step=STEP)
        context = dut.CreateDefaultContext()
        at_origin = np.zeros(STATE_SIZE)
        dut.get_input_port(0).FixValue(context, at_origin)
        dut.GetInputPort("robot_states").FixValue(context, at_origin)
        dut.GetInputPort("commands").FixValue(context, np.zeros(COMMAND_SIZE))
        mask, x, *_ = dut.GetOutputPort("tracks").Eval(context)
        assert (mask, x) == (1.0, OUTSIDE)


def test_who_would_come_back_by_a_recording_is_not_taken_out():
    crowd = make([CURVE]).GetSubsystemByName("crowd")
    with pytest.raises(ValueError, match=r"humans\[0\] follows a recording"):
        crowd.TakeOut(crowd.CreateDefaultContext(), [0])
