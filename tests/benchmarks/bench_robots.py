"""What a physical robot and people as bodies cost in a whole trial.

Times are those that the thread which simulates spends on the processor, so that
others on the machine count little; Meshcat sends from a thread of its own.
"""

import dataclasses
import time

from hunav_drake import HumanConfig, MakeTrialDiagram, MakeTrialSimulator
from hunav_drake.scenario import Scenario, World
from hunav_drake.systems.robot import ROBOTS

DURATION = 20.0

# How many times faster than real time a trial is to be at least.
WANTED = {5: 25.0, 20: 12.0}


def make_scenario(model: str, num_humans: int) -> Scenario:
    """Returns people who cross a room to and fro, with a robot among them."""
    humans = []
    for i in range(num_humans):
        # In two columns, a meter apart, each to the other side.
        side = 1 if i % 2 else -1
        y = 1.0 * (i // 2) - num_humans / 4
        humans.append(
            HumanConfig(
                pose=(4.0 * side, y, 0.0),
                goals=[(-4.0 * side, -y), (4.0 * side, y)],
                cyclic=True,
                behavior=("regular", "curious", "scared")[i % 3],
            )
        )
    walls = [
        {"type": "box", "center": [0, 9 * side], "size": [14, 0.2]}
        for side in (1, -1)
    ]
    scenario = Scenario(
        robot={
            "type": model,
            "start": (-5, 0, 0),
            "goal": (6, 0.5, 0),
            "goal_tolerance": 1e-6,
        },
        humans=humans,
        world=World(walls=walls),
    )
    simulation = dataclasses.replace(
        scenario.simulation, duration=DURATION + 2, stuck_time=1e4
    )
    return dataclasses.replace(scenario, simulation=simulation)


def seconds_per_second(scenario: Scenario, *, shown: bool = False) -> float:
    """Returns the processor's seconds for a second of a trial."""
    meshcat = None
    if shown:
        from pydrake.geometry import Meshcat, MeshcatParams

        meshcat = Meshcat(MeshcatParams(host="localhost"))
    simulator = MakeTrialSimulator(MakeTrialDiagram(scenario, meshcat))
    simulator.AdvanceTo(2.0)
    started = time.thread_time()
    simulator.AdvanceTo(2.0 + DURATION)
    return (time.thread_time() - started) / DURATION


def best(scenario: Scenario, *, shown: bool = False) -> float:
    """Returns the best of three."""
    return min(seconds_per_second(scenario, shown=shown) for _ in range(3))


def main() -> None:
    """Prints the table."""
    print(f"Trials of {DURATION:g} s: times faster than real time")
    print("people  kinematic   pmb2  wanted  ratio  with Meshcat, no client")
    for n, wanted in WANTED.items():
        kinematic, physical = (
            best(make_scenario(model, n))
            for model in ("differential_drive", "pmb2")
        )
        shown = best(make_scenario("pmb2", n), shown=True)
        print(
            f"{n:6} {1 / kinematic:10.0f} {1 / physical:6.1f} {wanted:7.0f}"
            f" {physical / kinematic:6.1f} {shown / physical:14.2f}"
        )
    print(f"(Robots: {', '.join(sorted(ROBOTS))}.)")


if __name__ == "__main__":
    main()
