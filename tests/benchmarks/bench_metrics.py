"""How long the metrics of a minute take, and a sample of the Evaluator.

Run it as a program: ``python tests/benchmarks/bench_metrics.py``.
"""

from collections.abc import Callable
import time

import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake.systems.evaluation import Evaluator, EvaluatorConfig, Recording
from hunav_drake.systems.evaluation.compute import (
    evaluate,
    evaluate_by_behavior,
)
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

# What HuNavSim's evaluator takes for the same on one core of a 2-core EPYC,
# in ms: all metrics, and those of all behaviors with their files.
HUNAVSIM_ALL, HUNAVSIM_BEHAVIORS = 1700.0, 4000.0


def record_room(people: int = 20, *, walls: bool = True) -> Recording:
    """Returns a minute at 20 Hz of a robot and people in a walled room."""
    rng = np.random.default_rng(0)
    samples = 1201
    states = rng.uniform(-5, 5, (samples, people + 1, 7))
    states[..., 6] = 0.35
    box = np.array([[-6, -5.1], [6, -5.1], [6, -5.0], [-6, -5.0]])
    turned = box @ [[0, 1], [-1, 0]]
    boxes = [box, -box, turned, -turned] if walls else []
    return Recording(
        times=np.arange(samples) * 0.05,
        robot=states[:, 0],
        humans=states[:, 1:],
        behaviors=tuple(f"behavior_{i % 6}" for i in range(people)),
        group_ids=tuple(i // 3 if i < 9 else -1 for i in range(people)),
        goal=(4.0, 4.0, 0.0),
        obstacles=Obstacles.from_shapes(boxes, solid=[True] * len(boxes)),
    )


def best_of(
    function: Callable[[Recording], object], make: Callable[[], Recording]
) -> float:
    """Returns the shortest time of 15, in ms, each with a fresh recording."""
    durations = []
    for _ in range(15):
        recording = make()
        start = time.perf_counter()
        function(recording)
        durations.append(time.perf_counter() - start)
    return 1e3 * min(durations)


def evaluate_paper(recording: Recording) -> object:
    """Computes the 28 metrics of HuNavSim's paper."""
    return evaluate(recording, ["paper"])


def bench_metrics() -> dict[str, float]:
    """Prints and returns the times of all metrics, in ms."""
    results = {}
    for walls in (False, True):
        where = "4 walls" if walls else "no walls"

        def make(walls: bool = walls) -> Recording:
            return record_room(walls=walls)

        for what, function, original in (
            ("the paper's 28", evaluate_paper, HUNAVSIM_ALL),
            ("all metrics", evaluate, HUNAVSIM_ALL),
            ("all behaviors", evaluate_by_behavior, HUNAVSIM_BEHAVIORS),
        ):
            duration = best_of(function, make)
            results[f"{what}, {where}"] = duration
            print(
                f"{what + ', ' + where:<26} {duration:7.1f} ms"
                f"  (HuNavSim {original:5.0f} ms: {original / duration:4.0f}"
                " times as long)"
            )
    return results


def bench_evaluator(people: int = 20) -> dict[str, float]:
    """Prints and returns the cost of the Evaluator, in us."""
    humans = [HumanConfig(pose=(0.0, 0.0, 0.0)) for _ in range(people)]
    results = {}
    for what, period in (("sample", 0.05), ("tick, 1 of 1000", 50.0)):
        dut = Evaluator(humans, config=EvaluatorConfig(period=period))
        simulator = Simulator(dut)
        context = simulator.get_mutable_context()
        dut.get_robot_state_input_port().FixValue(context, np.ones(7))
        dut.get_human_states_input_port().FixValue(
            context, np.zeros(7 * people)
        )
        dut.get_behavior_status_input_port().FixValue(context, np.ones(people))
        simulator.AdvanceTo(10.0)
        start = time.perf_counter()
        simulator.AdvanceTo(1010.0)
        results[what] = 1e6 * (time.perf_counter() - start) / 20_000
        print(f"evaluator, {what:<15} {results[what]:7.1f} us")
    context_recording = best_of(
        lambda _: dut.GetRecording(context), lambda: record_room(1)
    )
    print(f"evaluator, GetRecording of 21 samples {context_recording:.2f} ms")
    return results


def main() -> None:
    """Prints both."""
    bench_metrics()
    bench_evaluator()


if __name__ == "__main__":
    main()
