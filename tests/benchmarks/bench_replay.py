"""How many times real time recorded people of a dense corridor run.

All figures are of one run on one machine: compare the ratios.
"""

from pathlib import Path
import tempfile
import time

import numpy as np

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    Tracks,
    WriteTracks,
)
from hunav_drake.systems.people.tracks import Track

PEOPLE = 400
LENGTH, WIDTH = 80.0, 8.0
SCENARIO = """
world:
  walls:
    - {type: box, center: [0, 6], size: [100, 1]}
    - {type: box, center: [0, -6], size: [100, 1]}
population: {tracks: {file: FILE, mode: MODE}}
robot: {start: [-30, 0, 0], goal: [30, 0, 0]}
simulation: {duration: 60}
"""
# The least times real time to aim at, mostly blind.
TARGET = 20


def corridor() -> Tracks:
    """Returns people who walk along a corridor, both ways, for a minute."""
    random = np.random.default_rng(0)
    times = np.arange(0.0, 60.01, 0.2)
    people = []
    for i in range(PEOPLE):
        way = 1.0 if i % 2 else -1.0
        x = random.uniform(-LENGTH / 2, LENGTH / 2)
        y = random.uniform(-WIDTH / 2, WIDTH / 2)
        xs = x + way * random.uniform(0.8, 1.4) * times
        ys = y + 0.2 * np.sin(0.5 * times + i)
        inside = abs(xs) <= LENGTH / 2
        rows = np.column_stack([xs, ys])[inside]
        people.append(Track(i + 1, times[inside], rows))
    return Tracks(tuple(people))


def main() -> None:
    """Prints the table."""
    print(f"{PEOPLE} people; target: {TARGET} times real time, mostly blind")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "corridor.csv"
        WriteTracks(corridor(), file)
        for mode in ("blind", "hand_over", "reactive"):
            text = SCENARIO.replace("FILE", str(file)).replace("MODE", mode)
            simulator = MakeTrialSimulator(
                MakeTrialDiagram(LoadScenario(data=text))
            )
            simulator.AdvanceTo(1.0)
            start = time.process_time()
            simulator.AdvanceTo(6.0)
            spent = time.process_time() - start
            print(f"{mode:10} {5 / spent:6.1f} times real time")


if __name__ == "__main__":
    main()
