"""A live view of a trial: waiting for a browser, and controls in its page."""

from collections.abc import Callable
import math
import time

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario import draw_people
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.scene.bounds import port_of, view_axes
from hunav_drake.systems.scene.overlays.board import Board
from hunav_drake.systems.scene.scene import figure_names
from hunav_drake.systems.scene.scene_config import COSTMAPS, OVERLAYS
from hunav_drake.views.camera import FOLLOW_DISTANCE
from hunav_drake.views.replay import camera_pose, view_bounds

# The controls in the page.
PAUSE, RESTART, VIEW = "Pause / go on", "Restart", "Next view"
SPEED, CLOCK = "speed", "time [s]"
_SHOW = "Show / hide: "

_OVERVIEW, _TOP = -2, -1

# The period of checks for clicks, in seconds.
_POLL = 0.05

# The delay from which on the trial does not catch up with real time, and the
# period of the clock, in seconds.
_LATE, _CLOCK_STEP = 0.5, 0.5


class RestartRequest(Exception):
    """The user restarts the trial."""


class LiveControls:
    """Buttons and sliders in the page of a running trial.

    `Watch` must be called after each step of the trial until it returns true:
    see `RunTrial`. It keeps pace with real time at the speed of the slider,
    holds a paused trial, and handles the buttons.
    """

    def __init__(
        self, meshcat: Meshcat, scenario: Scenario, diagram: Diagram
    ) -> None:
        """Adds the controls to the page of a trial and its diagram."""
        self._meshcat = meshcat
        self._scenario = scenario
        self._robots = robots_of(scenario)
        ports = [port_of(it, "robot_state") for it in self._robots]
        self._robot_states = [diagram.GetOutputPort(it) for it in ports]
        self._humans = draw_people(scenario)
        names = figure_names(self._humans, self._robots)
        self._board = Board(
            meshcat, scenario.world, self._humans, names, self._robots
        )
        self._clicks: dict[str, int] = {}
        # The number of the robot that the view follows, or one of the above.
        self._view = _OVERVIEW
        self._speed = 1.0
        self._told = math.nan
        meshcat.AddButton(PAUSE, "Space")
        meshcat.AddButton(RESTART, "KeyR")
        meshcat.AddButton(VIEW, "KeyV")
        meshcat.AddSlider(SPEED, 0.25, 8.0, 0.25, self._speed)
        duration = scenario.simulation.duration
        meshcat.AddSlider(CLOCK, 0.0, duration, 0.1, 0.0)
        # The clock has a slider; a scan needs a lidar, a costmap a planner with
        # costmaps, and an estimate a localization.
        scene = diagram.GetSubsystemByName("scene")
        has = {
            "scan": scene.HasInputPort,
            **dict.fromkeys((*COSTMAPS, "estimate"), diagram.HasOutputPort),
        }
        port_names = {"estimate": "estimated_robot_state"}
        missing = {"clock"} | {
            overlay
            for overlay, has_port in has.items()
            if not any(
                has_port(port_of(it, port_names.get(overlay, overlay)))
                for it in self._robots
            )
        }
        self._switched = [it for it in OVERLAYS if it not in missing]
        for overlay in self._switched:
            meshcat.AddButton(_SHOW + overlay)
        self.Restart()

    def Restart(self) -> None:
        """Prepares for a start or restart of the trial."""
        # A restart shows the overlays of the scenario.
        shown = self._scenario.scene.overlays
        self._shown = {overlay: overlay in shown for overlay in OVERLAYS}
        self._paused = False
        self._Pace(0.0)

    def Watch(self, context: Context) -> bool:
        """Returns whether the trial may continue; waits a little if not.

        Raises:
            RestartRequest: If the user restarts the trial.
        """
        seconds = context.get_time()
        self._Obey(context)
        speed = self._meshcat.GetSliderValue(SPEED)
        if self._paused or speed != self._speed:
            self._speed = speed
            self._Pace(seconds)
        if self._paused:
            time.sleep(_POLL)
            return False
        begin, at = self._begin
        ahead = (seconds - begin) / speed - (time.monotonic() - at)
        if ahead > _POLL:
            time.sleep(_POLL)
            return False
        time.sleep(max(ahead, 0.0))
        if ahead < -_LATE:
            # Too slow for real time: do not catch up afterwards.
            self._Pace(seconds)
        if round(seconds / _CLOCK_STEP) * _CLOCK_STEP != self._told:
            self._told = round(seconds / _CLOCK_STEP) * _CLOCK_STEP
            self._meshcat.SetSliderValue(CLOCK, self._told)
        if self._view >= 0:
            self._SetView(context)
        return True

    def _Pace(self, seconds: float) -> None:
        """Keeps pace from now on, at a given time of the trial."""
        self._begin = (seconds, time.monotonic())

    def _Obey(self, context: Context) -> None:
        """Handles the buttons."""
        if self._Clicked(RESTART):
            raise RestartRequest
        if self._Clicked(PAUSE):
            self._paused = not self._paused
        if self._Clicked(VIEW):
            self._view += 1
            if self._view == len(self._robots):
                self._view = _OVERVIEW
            self._SetView(context)
        for overlay in self._switched:
            if self._Clicked(_SHOW + overlay):
                self._shown[overlay] = not self._shown[overlay]
                self._board.Show(overlay, self._shown[overlay])

    def _SetView(self, context: Context) -> None:
        scenario = self._scenario
        bounds = view_bounds(scenario.world, self._humans, self._robots)
        p_WC, p_WT = camera_pose(bounds)
        if self._view == _TOP:
            _, ahead = view_axes(bounds)
            p_WT = np.array([*bounds.center, 0.0])
            distance = float(np.linalg.norm(p_WC - p_WT))
            # Slightly to the side: straight down, "up" is undefined.
            p_WC = p_WT + distance * np.array([0.0, 0.0, 1.0]) - 0.02 * ahead
        elif self._view >= 0:
            robot = self._robot_states[self._view].Eval(context)
            away = (p_WC - p_WT) / np.linalg.norm(p_WC - p_WT)
            p_WT = np.array([robot[X], robot[Y], 0.4])
            p_WC = p_WT + FOLLOW_DISTANCE * away
        self._meshcat.SetCameraPose(p_WC, p_WT)

    def _Clicked(self, button: str) -> bool:
        """Returns whether a button was clicked since the last call."""
        clicks: int = self._meshcat.GetButtonClicks(button)
        before = self._clicks.get(button, 0)
        self._clicks[button] = clicks
        return clicks > before


def WaitForBrowser(
    meshcat: Meshcat, *, say: Callable[[str], None] = print
) -> None:
    """Waits until a browser shows a Meshcat."""
    if meshcat.GetNumActiveConnections():
        return
    say(
        "Waiting for a browser to open this page (Ctrl-C ends, --no-wait"
        " starts at once) ..."
    )
    while not meshcat.GetNumActiveConnections():
        time.sleep(_POLL)
