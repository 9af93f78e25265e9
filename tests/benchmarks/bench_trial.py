"""How many times faster than real time a whole trial is, and why not more."""

from collections.abc import Callable
import cProfile
import dataclasses
from pathlib import Path
import pstats
import time
import timeit

from hunav_drake import (
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SetTrialSeed,
)
from hunav_drake.scenario import Scenario
from hunav_drake.trial.simulation import GetTrialResult

DURATION = 60.0


def sixty_seconds(name: str) -> Scenario:
    """Returns a shipped scenario with a goal that is not reached in time."""
    scenario = LoadScenario(filename=name)
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


def main() -> None:
    """Prints the table."""
    print(f"A whole trial of {DURATION:g} s, headless, one core")
    print("scenario  people  build s  run s  x real time  evaluation s")
    for name in ("passing", "crossing", "cafe"):
        scenario = sixty_seconds(name)
        time_trial(scenario)
        build, step, evaluate = min(
            (time_trial(scenario) for _ in range(3)), key=sum
        )
        print(
            f"{name:9} {len(scenario.humans):6} {build:8.3f} {step:6.3f}"
            f" {DURATION / step:12.0f} {evaluate:13.3f}"
        )
    resets()
    print("\nShare of the time of passing, by block")
    shares = profile(sixty_seconds("passing"))
    for block, share in sorted(shares.items(), key=lambda item: -item[1]):
        print(f"  {block:26} {100 * share:5.1f} %")


if __name__ == "__main__":
    main()
