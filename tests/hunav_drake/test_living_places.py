"""The shipped places where people sit, queue, talk, look and leave."""

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
)
from hunav_drake.systems.common.layout import Activity, Posture, Signal
from hunav_drake.systems.world.obstacles import inside
from tests.walkers import seated

pytestmark = pytest.mark.slow

PLACES = {
    "supermarket": {Activity.USE, Activity.QUEUE},
    "museum": {Activity.WATCH, Activity.SIT, Activity.CONVERSATION},
    "lecture_hall_exit": {Activity.SIT},
    "living_cafe": {Activity.QUEUE, Activity.SIT, Activity.CONVERSATION},
    "living_house": {Activity.USE, Activity.SIT, Activity.WATCH},
    "office": {Activity.USE, Activity.QUEUE, Activity.SIT}
    | {Activity.CONVERSATION},
    "hospital": {Activity.WATCH, Activity.QUEUE, Activity.SIT},
    "station": {Activity.QUEUE, Activity.SIT},
}
PLANNERS = ("pursuit", "dwb", "scl", "sfw", "orca", "mppi", "sfm")


@pytest.fixture(scope="module", params=PLACES)
def run(request):
    trial = LoadScenario(filename=request.param)
    return trial, RunTrial(trial)


def test_people_do_what_the_place_is_for(run):
    trial, result = run
    shown = result.recording.social_signals
    activities = set(shown[:, :, Signal.ACTIVITY].ravel().tolist())
    assert activities >= PLACES[trial.name]
    assert result.end_reason == "goal"


def test_nobody_is_in_a_wall_but_on_a_seat(run):
    trial, result = run
    recording = result.recording
    within = inside(trial.world.obstacles(), recording.humans[:, :, :2])
    assert not (within.any(axis=2) & ~seated(recording)).any()


def test_nobody_jumps_or_turns_for_ever(run):
    _, result = run
    humans = result.recording.humans
    period = np.diff(result.recording.times)[:, None]
    steps = np.hypot(*np.moveaxis(np.diff(humans[:, :, :2], axis=0), 2, 0))
    # (Some come and go.)
    assert (np.nan_to_num(steps) <= 2.0 * period + 1e-9).all()
    # Half of a turn to and fro in the end: nobody spins where they stand.
    tail = humans[-100:]
    turned = np.abs(np.diff(np.unwrap(tail[:, :, 2], axis=0), axis=0)).sum(0)
    still = np.hypot(tail[:, :, 3], tail[:, :, 4]).max(axis=0) < 0.05
    assert (turned[still] < np.pi + 0.3).all()


def test_the_lecture_begins_seated_and_ends_empty():
    trial = LoadScenario(
        filename="lecture_hall_exit", overrides=["robot.goal=null"]
    )
    recording = RunTrial(trial).recording
    posture = recording.social_signals[:, :, Signal.POSTURE]
    assert (posture[2] == Posture.SEATED).sum() == 60
    assert (posture[-1] == Posture.SEATED).sum() == 0
    # All are out of the hall.
    assert (recording.humans[-1, :, 1] > 10.4).all()


@pytest.mark.parametrize("name", PLACES)
def test_a_fork_goes_on_bit_for_bit(name, tmp_path):
    diagram = MakeTrialDiagram(LoadScenario(filename=name))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(6.0)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    forked = Simulator(diagram, LoadContext(diagram, file))
    for it in (simulator, forked):
        it.AdvanceTo(9.0)
    for port in ("human_states", "social_signals", "robot_state"):
        one, other = (
            diagram.GetOutputPort(port).Eval(it.get_context())
            for it in (simulator, forked)
        )
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", PLACES)
def test_planners_drive_through(name, planner):
    """Robots arrive, or are stuck among people: nothing else ends a trial."""
    trial = LoadScenario(filename=name, overrides=[f"planner.type={planner}"])
    result = RunTrial(trial, 1)
    assert np.isfinite(result.recording.robot).all()
    assert result.end_reason in ("goal", "timeout", "stuck")
