"""What planners cost: a cycle, a global plan, and whole trials.

CPU time of one process, on one core; compare the ratios.
"""

from collections.abc import Callable
import statistics
import time

import numpy as np

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial
from hunav_drake.systems.planning import (
    PLANNERS,
    NavigationPlanner,
    PlanningTask,
    View,
)
from hunav_drake.systems.planning.global_planner import plan_path
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.maps.costs import Costmap
from hunav_drake.systems.world.obstacles import Obstacles

ROOM = [(-3, -5), (22, -5), (22, 5), (-3, 5), (-3, -5)]
CYCLES = 400


def median(run: Callable[[], object], count: int = 60) -> float:
    """Returns the median CPU time of a call, in seconds."""
    run()
    times = []
    for _ in range(count):
        started = time.process_time()
        run()
        times.append(time.process_time() - started)
    return statistics.median(times)


def people(k: int, count: int) -> np.ndarray:
    """Returns people who walk across the way of the robot."""
    rows = np.zeros((count, 7))
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False) + 0.01 * k
    rows[:, 0] = 0.03 * k + 1.6 * np.cos(angles)
    rows[:, 1] = 1.6 * np.sin(angles)
    rows[:, 3] = -0.8 * np.sin(angles)
    rows[:, 4] = 0.8 * np.cos(angles)
    rows[:, 6] = 0.4
    return rows


def cycle_times(planner: NavigationPlanner, count: int) -> dict[str, float]:
    """Returns the times of a cycle amid people, in seconds.

    "cycle" is the median, "p95" the 95th percentile, and "replan" the median
    of the cycles that make a global plan.
    """
    task = PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.35,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=Obstacles.from_shapes([ROOM], solid=[False]),
        num_humans=count,
    )
    goal = np.array([19.5, 0.0, 0.0])
    memory = planner.initial_memory
    times: list[float] = []
    replans: list[float] = []
    for k in range(CYCLES):
        robot = np.array([0.03 * k, 0.0, 0.0, 0.6, 0.0, 0.0, 0.35])
        view = View(robot, people(k, count), goal)
        started = time.process_time()
        plan = planner.plan(task, view, memory)
        taken = time.process_time() - started
        if k > 20:
            is_replan = plan.memory.planned == plan.memory.cycle
            (replans if is_replan else times).append(taken)
        # Whatever stops it, it goes on.
        memory = plan.memory._replace(recovery=None, failed=False)
    return {
        "cycle": statistics.median(times),
        "p95": float(np.quantile(times, 0.95)),
        "replan": statistics.median(replans),
    }


def main() -> None:
    """Prints the tables."""
    print("A cycle at 20 Hz, in ms, foxy's local map of 160 x 160 cells")
    for name in ("dwb", "scl", "sfw", "sfm", "orca", "mppi"):
        planner = PLANNERS[name]()
        for count in (0, 4, 10):
            t = cycle_times(planner, count)
            print(
                f"{name:5} {count:3} people: median {1e3 * t['cycle']:6.3f}"
                f"  p95 {1e3 * t['p95']:6.3f}"
                f"  with a global plan {1e3 * t['replan']:6.2f}",
                flush=True,
            )

    costs = np.zeros((200, 500), np.uint8)
    costs[60:140, 250] = 254
    costmap = Costmap(costs, (0.0, 0.0), 0.05)
    seconds = median(lambda: plan_path(costmap, (1, 5), (24, 5, 0)))
    print(f"\nA global plan on 500 x 200 cells: {1e3 * seconds:.2f} ms")

    print("\nWhole trials, simulated seconds per second of CPU")
    for trial in ("passing", "crossing", "cafe"):
        for name in ("pursuit", "dwb", "scl", "sfw", "sfm", "orca", "mppi"):
            scenario = LoadScenario(
                filename=f"scenarios/{trial}.yaml",
                overrides=[f"planner.type={name}"],
            )
            diagram = MakeTrialDiagram(scenario)
            RunTrial(scenario, 0, diagram=diagram)
            started = time.process_time()
            result = RunTrial(scenario, 1, diagram=diagram)
            taken = time.process_time() - started
            simulated = result.recording.times[-1]
            print(f"{trial:9} {name:8} {simulated / taken:6.0f}", flush=True)


if __name__ == "__main__":
    main()
