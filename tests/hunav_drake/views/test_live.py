import time

import pytest

from hunav_drake.scenario import LoadScenario
from hunav_drake.systems.scene.scene_config import COSTMAPS
from hunav_drake.trial.diagram import MakeTrialDiagram
from hunav_drake.trial.simulation import MakeTrialSimulator, RunTrial
from hunav_drake.views import live as mut
from hunav_drake.views.replay import StartMeshcatLocal


def text(value):
    """A short text in the form of MessagePack."""
    data = value.encode()
    return bytes([0xD9, len(data)]) + data


def click(meshcat, button):
    """Does what the page does when a button is clicked."""
    fields = {"type": "button", "name": button}
    message = bytes([0x80 + len(fields)])
    for key, value in fields.items():
        message += text(key) + text(value)
    before = meshcat.GetButtonClicks(button)
    meshcat._InjectWebsocketMessage(message)
    for _ in range(200):
        if meshcat.GetButtonClicks(button) > before:
            return
        time.sleep(0.005)
    raise AssertionError(f"{button} was not clicked")


class Trial:
    def __init__(self, meshcat, **given):
        self.meshcat = meshcat
        meshcat.DeleteAddedControls()
        self.scenario = LoadScenario(
            **(given or {"filename": "crossing"}),
            overrides=["simulation.duration=0.5"],
        )
        self.diagram = MakeTrialDiagram(self.scenario, meshcat)
        self.controls = mut.LiveControls(meshcat, self.scenario, self.diagram)
        self.context = self.diagram.CreateDefaultContext()

    def watch(self):
        return self.controls.Watch(self.context)


@pytest.fixture(scope="module")
def meshcat():
    return StartMeshcatLocal()


@pytest.fixture
def trial(meshcat):
    return Trial(meshcat)


def test_a_trial_keeps_pace_with_real_time(trial):
    started = time.monotonic()
    trial.controls.Restart()
    result = RunTrial(
        trial.scenario,
        diagram=trial.diagram,
        meshcat=trial.meshcat,
        watch=trial.controls.Watch,
    )
    assert time.monotonic() - started > 0.45
    assert result.end_time == 0.5


def test_a_trial_is_the_same_when_it_is_watched(trial):
    trial.meshcat.SetSliderValue(mut.SPEED, 8.0)
    watched = RunTrial(
        trial.scenario,
        diagram=trial.diagram,
        meshcat=trial.meshcat,
        watch=trial.controls.Watch,
    )
    assert watched.recording == RunTrial(trial.scenario).recording


def test_the_button_pauses_and_goes_on(trial):
    assert trial.watch()
    click(trial.meshcat, mut.PAUSE)
    assert not trial.watch()
    assert not trial.watch()
    click(trial.meshcat, mut.PAUSE)
    assert trial.watch()


def test_the_button_restarts_also_from_a_pause(trial):
    click(trial.meshcat, mut.PAUSE)
    assert not trial.watch()
    click(trial.meshcat, mut.RESTART)
    with pytest.raises(mut.RestartRequest):
        trial.watch()
    trial.controls.Restart()
    assert trial.watch()


def test_a_button_hides_and_shows_an_overlay(trial, monkeypatch):
    told = []
    monkeypatch.setattr(
        mut.Board, "Show", lambda self, name, on: told.append((name, on))
    )
    for _ in range(2):
        click(trial.meshcat, "Show / hide: walked")
        trial.watch()
    click(trial.meshcat, "Show / hide: rings")
    trial.watch()
    assert told == [("walked", False), ("walked", True), ("rings", True)]


def test_the_camera_follows_the_robot_if_that_is_the_view(trial, monkeypatch):
    targets = []
    monkeypatch.setattr(
        type(trial.meshcat),
        "SetCameraPose",
        lambda self, p_WC, p_WT: targets.append((p_WC, p_WT)),
    )
    for _ in range(2):
        click(trial.meshcat, mut.VIEW)
        trial.watch()
    (above, middle), *_ = targets
    # From above: nearly straight down.
    assert abs(above - middle)[:2].max() < 0.1
    simulator = MakeTrialSimulator(trial.diagram)
    simulator.AdvanceTo(0.4)
    robot = trial.diagram.GetOutputPort("robot_state")
    for context in (trial.context, simulator.get_context()):
        while not trial.controls.Watch(context):
            pass
        assert targets[-1][1][:2] == pytest.approx(robot.Eval(context)[:2])


def test_the_camera_follows_one_robot_after_the_other(meshcat, monkeypatch):
    trial = Trial(
        meshcat,
        data="{robots: [{name: anna, robot: {start: [0, 1, 0]}},"
        " {name: bob, robot: {start: [0, 3, 0]}, sensors: [{type: lidar}]}]}",
    )
    assert "Show / hide: scan" in meshcat.GetButtonNames()
    targets = []
    monkeypatch.setattr(
        type(meshcat),
        "SetCameraPose",
        lambda self, p_WC, p_WT: targets.append(p_WT[1]),
    )
    for y in (None, 1.0, 3.0):
        click(meshcat, mut.VIEW)
        trial.watch()
        assert y is None or targets[-1] == pytest.approx(y)
    for _ in range(2):
        count = len(targets)
        click(meshcat, mut.VIEW)
        trial.watch()
    # Not of a robot, so it stays.
    trial.watch()
    assert len(targets) == count + 1


def test_it_waits_for_a_browser():
    class Meshcat:
        polls = 0

        def GetNumActiveConnections(self):
            self.polls += 1
            return int(self.polls > 3)

    said = []
    dut = Meshcat()
    mut.WaitForBrowser(dut, say=said.append)
    assert dut.polls == 4
    assert "--no-wait" in said[0]


def test_a_trial_tells_its_scene_what_overlays_show(trial):
    scene = trial.diagram.GetSubsystemByName("scene")
    context = scene.GetMyContextFromRoot(trial.context)
    for name in ("behavior_status", "forces", "planner_path"):
        assert scene.GetInputPort(name).HasValue(context)
    forces = scene.GetInputPort("forces").Eval(context)
    assert forces == pytest.approx(
        trial.diagram.GetOutputPort("forces").Eval(trial.context)
    )


def test_costmaps_have_buttons_if_the_planner_has_them(meshcat, monkeypatch):
    added = []
    monkeypatch.setattr(
        type(meshcat), "AddButton", lambda self, name, *_: added.append(name)
    )
    for planner in ("pursuit", "dwb"):
        scenario = LoadScenario(
            filename="passing", overrides=[f"planner={planner}"]
        )
        diagram = MakeTrialDiagram(scenario, meshcat)
        added.clear()
        meshcat.DeleteAddedControls()
        mut.LiveControls(meshcat, scenario, diagram)
        shown = [f"Show / hide: {name}" in added for name in COSTMAPS]
        assert shown == [planner == "dwb"] * 2
