"""How large the replay of a whole trial is."""

import base64
import re

import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.scenario import draw_people
from hunav_drake.views.replay import SaveReplay, SetView, StartMeshcatLocal
from tests.screenshot import unpacked

DURATION = 60.0
PEOPLE = 10

ROOM = f"""
world:
  walls:
    - {{type: box, center: [0, 8.1], size: [24, 0.2]}}
    - {{type: box, center: [0, -8.1], size: [24, 0.2]}}
population:
  cohorts:
    - name: guest
      number: {PEOPLE}
      start: [{{rectangle: [-11, -7, 11, 7]}}]
      goals: [{{rectangle: [-11, -7, -6, 7]}}, {{rectangle: [6, -7, 11, 7]}}]
      cyclic: true
robot: {{start: [-10, 0, 0], goal: [10, 0, 0], goal_tolerance: 1.0e-6}}
simulation: {{duration: {DURATION}, stuck_time: 10000}}
"""


@pytest.mark.slow
def test_a_minute_with_ten_people_is_below_nine_megabytes(tmp_path):
    scenario = LoadScenario(data=ROOM)
    meshcat = StartMeshcatLocal()
    SetView(meshcat, scenario.world, draw_people(scenario), scenario.robot)
    recording = RunTrial(scenario, meshcat=meshcat).recording
    # All of it is there: people who walk to the end.
    assert recording.times[-1] == pytest.approx(DURATION)
    assert recording.humans.shape[1] == PEOPLE
    moved = abs(recording.humans[-20:, :, :2] - recording.humans[-1, :, :2])
    assert (moved.max(axis=(0, 2)) > 0.3).sum() >= PEOPLE - 3
    page = SaveReplay(meshcat, tmp_path / "replay.html")
    size = page.stat().st_size
    print(f"{size / 1e6:.2f} MB")
    assert size < 9e6
    html = unpacked(page.read_text())
    blobs = re.findall(r"base64,([A-Za-z0-9+/=]+)", html)
    said = b"".join(map(base64.b64decode, blobs))
    assert b"set_animation" in said
    for i in range(PEOPLE):
        assert f"guest_{i + 1}/left_shin".encode() in said
