"""How many times faster than real time a whole trial is, and why not more."""

from collections.abc import Callable
import cProfile
import dataclasses
from pathlib import Path
import pstats
import time
import timeit

import numpy as np

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SetTrialSeed,
    TransferContext,
)
from hunav_drake.scenario import Scenario
from hunav_drake.trial.simulation import GetTrialResult

DURATION = 60.0


# Scenarios, and how many people are in them, as many as they have and more.
TRIALS = (("passing", 2), ("cafe", 5), ("office", 12), ("cafe", 20))


def sixty_seconds(
    name: str, people: int | None = None, planner: str = "pursuit"
) -> Scenario:
    """Returns a shipped scenario with a goal that is not reached in time.

    People beyond its own start, and have goals, anywhere among these.
    """
    scenario = LoadScenario(filename=name)
    overrides = [f"planner.type={planner}"]
    more = (people or 0) - len(scenario.humans)
    if more > 0:
        places = np.array([human.pose[:2] for human in scenario.humans])
        area = [*places.min(axis=0).tolist(), *places.max(axis=0).tolist()]
        cohort = (
            f"{{name: more, number: {more}, start: [{{rectangle: {area}}}]}}"
        )
        overrides.append(f"population.cohorts=[{cohort}]")
    scenario = LoadScenario(filename=name, overrides=overrides)
    return dataclasses.replace(
        scenario,
        # Out of reach, but never out of sight: the planner works all along.
        robot=dataclasses.replace(
            scenario.robot, goal_tolerance=1e-6, goal_yaw_tolerance=1e-6
        ),
        simulation=dataclasses.replace(
            scenario.simulation, duration=DURATION, stuck_time=1e4
        ),
    )


def time_trial(scenario: Scenario) -> tuple[float, float, float]:
    """Returns the seconds that building, running and evaluating take."""
    started = time.perf_counter()
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.Initialize()
    built = time.perf_counter()
    simulator.AdvanceTo(DURATION)
    ran = time.perf_counter()
    GetTrialResult(scenario, diagram, simulator.get_context())
    return built - started, ran - built, time.perf_counter() - ran


def profile(scenario: Scenario) -> dict[str, float]:
    """Returns each block's share of the time of a run."""
    simulator = MakeTrialSimulator(MakeTrialDiagram(scenario))
    profiler = cProfile.Profile()
    profiler.runcall(simulator.AdvanceTo, DURATION)
    shares: dict[str, float] = {}
    # The types of the standard library leave `stats` out.
    for (file, _, _), row in pstats.Stats(profiler).stats.items():  # type: ignore[attr-defined]
        parts = Path(file).parts
        block = "Drake, and calls into it"
        if "systems" in parts and "hunav_drake" in parts:
            block = parts[parts.index("systems") + 1]
        elif "hunav_drake" in parts:
            block = "monitor of the simulator"
        shares[block] = shares.get(block, 0.0) + row[2]
    total = sum(shares.values())
    return {block: share / total for block, share in shares.items()}


def seconds(function: Callable[[], object], count: int) -> float:
    """Returns the time of a call: the best mean of five rounds of calls."""
    return min(timeit.repeat(function, number=count, repeat=5)) / count


def five_people() -> Scenario:
    """Returns a trial of five people with all that a seed can draw."""
    scenario = LoadScenario(filename="cafe")
    humans = [
        dataclasses.replace(human, forces_mode="random_normal", group_id=-1)
        for human in scenario.humans[:5]
    ]
    return dataclasses.replace(scenario, humans=humans)


def resets() -> None:
    """Prints how fast a trial is set to another seed."""
    scenario = five_people()
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    build = seconds(lambda: MakeTrialDiagram(scenario), 1)
    create = seconds(diagram.CreateDefaultContext, 20)
    reset = seconds(lambda: SetTrialSeed(diagram, context, 7), 200)
    print("\nAnother seed of a trial of 5 people")
    print(f"  another diagram  {1e3 * build:8.2f} ms  {build / reset:6.0f} x")
    print(f"  another Context  {1e3 * create:8.2f} ms  {create / reset:6.1f} x")
    print(f"  SetTrialSeed     {1e3 * reset:8.2f} ms")


def fork(name: str) -> None:
    """Prints what a fork of a trial takes of the branch that goes on."""
    scenario = LoadScenario(filename=name, overrides=["planner.type=dwb"])
    diagram, other = (MakeTrialDiagram(scenario) for _ in range(2))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(4.0)
    context = simulator.get_context()

    def go_on() -> None:
        copy = context.Clone()
        MakeTrialSimulator(diagram, copy, ends=False).AdvanceTo(24.0)

    branch = seconds(go_on, 1)
    clone = seconds(context.Clone, 50)
    transfer = seconds(lambda: TransferContext(diagram, context, other), 20)
    for what, time_taken in (("Clone", clone), ("TransferContext", transfer)):
        share = time_taken / branch
        print(f"  {name:9} {what:15} {1e3 * time_taken:5.2f} ms  {share:6.2%}")


def main() -> None:
    """Prints the table."""
    print(f"A whole trial of {DURATION:g} s, headless, one core")
    print("scenario  people  planner build s  run s  x real time  evaluation s")
    for name, people in TRIALS:
        for planner in ("pursuit", "dwb"):
            scenario = sixty_seconds(name, people, planner)
            time_trial(scenario)
            build, step, evaluate = min(
                (time_trial(scenario) for _ in range(3)), key=sum
            )
            print(
                f"{name:9} {people:6} {planner:8} {build:7.3f} {step:6.3f}"
                f" {DURATION / step:12.0f} {evaluate:13.3f}",
                flush=True,
            )
    resets()
    print("\nA fork of a trial with dwb, of a branch of 20 s (bar 2 %)")
    for name in ("crossing", "passing", "cafe"):
        fork(name)
    print("\nShare of the time, by block, in %")
    shares = {
        f"{name}, {people}": profile(sixty_seconds(name, people))
        for name, people in TRIALS
    }
    print(" " * 26 + "".join(f"{name:>12}" for name in shares))
    for block in sorted(set().union(*shares.values())):
        cells = [100 * share.get(block, 0.0) for share in shares.values()]
        print(f"  {block:24}" + "".join(f"{cell:12.1f}" for cell in cells))


if __name__ == "__main__":
    main()
