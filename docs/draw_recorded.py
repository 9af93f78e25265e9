"""Draws `recorded_people.gif`: a robot that crosses recorded people.

python docs/draw_recorded.py zara01.txt

It also prints the numbers of `calibration.md`.
"""

from pathlib import Path
import sys

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hunav_drake import LoadScenario, RunTrial, TrialResult
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.population import draw_people
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.views.film_files import write_film
from hunav_drake.views.plan_view import PlanView
from hunav_drake.views.recorded_trial import RecordedTrial

OUTPUT = Path(__file__).with_name("recorded_people.gif")
MODES = ("blind", "hand_over", "reactive")
SCENARIO = """
population: {tracks: {file: FILE, mode: MODE, end: 40.0}}
robot: {start: [8, -0.5, 1.57], goal: [8, 11, 1.57]}
evaluator: {period: 0.05}
simulation: {duration: 40}
"""
SIZE = (320, 264)
PERIOD = 0.2


def load(file: str, mode: str):
    """Returns the scenario of a mode."""
    text = SCENARIO.replace("FILE", file).replace("MODE", mode)
    return LoadScenario(data=text)


def row(mode: str, result: TrialResult) -> str:
    """Returns the row of the table of a mode."""
    recording, values = result.recording, result.metrics
    apart = recording.humans[..., [X, Y]] - recording.robot[:, None, [X, Y]]
    bodies = np.array(
        [it.contact_radius for it in draw_people(load(FILE, mode))]
    )
    gaps = np.hypot(*np.moveaxis(apart, -1, 0)) - bodies
    gap = np.nanmin(gaps - recording.robot[:, None, 6])
    who = recording.replay[..., 0]
    switches = (who[1:] != who[:-1]) & (who[1:] > 0) & (who[:-1] > 0)
    velocities = np.moveaxis(recording.humans[..., 3:5], -1, 0)
    change = np.hypot(*np.diff(velocities, axis=1))
    at_switch = change[switches].max(initial=0.0)
    numbers = [
        f"{gap:.2f} m",
        f"{values.replay_ade:.2f} / {values.replay_fde:.2f} m",
        f"{values.replay_ade_at_phase:.2f} m",
        f"{switches.sum()}",
        f"{100 * values.reactive_share:.0f} %",
        f"{np.nanmax(change):.2f} m/s",
        f"{at_switch:.2f} m/s" if switches.any() else "",
    ]
    return f"| `{mode}` | {' | '.join(numbers)} |"


def pictures(results: list[TrialResult]):
    """Yields the frames: the modes side by side."""
    views = []
    for mode, result in zip(MODES, results, strict=True):
        scenario = load(FILE, mode)
        trial = RecordedTrial(
            recording=result.recording,
            world=scenario.world,
            humans=draw_people(scenario),
            robots=robots_of(scenario),
            scene=scenario.scene,
        )
        views.append(PlanView(trial, ["walked", "reactions"], SIZE))
    font = ImageFont.load_default(18)
    end = max(it.recording.times[-1] for it in results)
    for time in np.arange(0.0, end, PERIOD):
        frame = Image.new("RGB", (3 * SIZE[0], SIZE[1]), "white")
        for k, (mode, view, result) in enumerate(
            zip(MODES, views, results, strict=True)
        ):
            last = result.recording.times[-1]
            picture = view.Draw(min(float(time), float(last)))
            ImageDraw.Draw(picture).text((12, 8), mode, "black", font)
            frame.paste(picture, (k * SIZE[0], 0))
        yield frame


if __name__ == "__main__":
    FILE = str(Path(sys.argv[1]).resolve())
    found = [RunTrial(load(FILE, mode)) for mode in MODES]
    for name, one in zip(MODES, found, strict=True):
        print(row(name, one))
    write_film(OUTPUT, pictures(found), 1 / PERIOD)
