"""What a cycle of MPPI costs.

All figures are of one run on one machine: compare the ratios.
"""

import time

import numpy as np

from hunav_drake.systems.planning import PlanningTask, View
from hunav_drake.systems.planning.mppi import MppiMemory, MppiPlanner
from hunav_drake.systems.planning.mppi.mppi import CriticWeights
from hunav_drake.systems.planning.navigation.memory import LocalPlan, Sight
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles

CYCLES = 60
GOAL = (9.0, 0.0, 0.0)


def people(count: int) -> np.ndarray:
    """Returns people who come towards the robot, shape (count, 7)."""
    rng = np.random.default_rng(1)
    rows = np.zeros((count, 7))
    rows[:, 0] = rng.uniform(1.0, 4.0, count)
    rows[:, 1] = rng.uniform(-2.0, 2.0, count)
    rows[:, 3] = -1.0
    rows[:, 6] = 0.3
    return rows


def cycle_times(planner: MppiPlanner, humans: np.ndarray) -> np.ndarray:
    """Returns the seconds of the processor that cycles take."""
    task = PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.35,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=Obstacles.from_shapes([], solid=[]),
        num_humans=len(humans),
    )
    robot = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.35])
    xs = 0.025 * np.arange(77)
    plan = np.column_stack([xs, np.zeros_like(xs), np.zeros_like(xs)])
    costmap = planner.setup(task).maps.local_map(robot, Sight(0, robot, humans))
    view = View(robot, humans, np.array(GOAL))
    memory, times = MppiMemory(), []
    for _ in range(CYCLES):
        started = time.process_time()
        control = planner.control(
            *(task, view, LocalPlan(plan, GOAL, False)), *(costmap, memory)
        )
        times.append(time.process_time() - started)
        memory = control.memory if not control.fault else memory
    return np.array(times[5:])


def main() -> None:
    """Prints the table."""
    print("A cycle of MPPI, 56 steps ahead, in ms of the processor")
    still = CriticWeights(social=0.0)
    for name, planner, count in (
        ("1000 rollouts, nobody", MppiPlanner(), 0),
        ("1000 rollouts, 4 people", MppiPlanner(), 4),
        ("... without critic Social", MppiPlanner(weights=still), 4),
        ("... with one noise", MppiPlanner(regenerate_noises=False), 4),
        ("1000 rollouts, 20 people", MppiPlanner(), 20),
        ("2000 rollouts, 4 people", MppiPlanner(batch_size=2000), 4),
    ):
        times = 1e3 * cycle_times(planner, people(count))
        median, p95 = np.percentile(times, [50, 95])
        print(f"{name:28} median {median:6.2f}   p95 {p95:6.2f}", flush=True)


if __name__ == "__main__":
    main()
