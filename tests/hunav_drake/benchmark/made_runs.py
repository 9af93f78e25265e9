"""Suites whose runs are made up, so that what follows is known."""

from hunav_drake.benchmark import Suite, SuiteResult
from hunav_drake.benchmark.running.cell import Cell
from hunav_drake.benchmark.running.run_row import RunRow


def make_result(values, repetitions=1, **suite):
    """Returns the result of a suite with these metrics.

    Args:
        values: By (scenario, planner): the metrics of each run, seed by seed,
            of each seed its repetitions; None for a run without a result.
        repetitions: How many runs a seed has.
        suite: Further keys of the suite.
    """
    cells, rows = [], []
    for (scenario, planner), runs in values.items():
        name = f"{scenario}/{planner}"
        cells.append(
            Cell(
                scenario=scenario,
                planner=planner,
                setting="",
                text="",
                sha256=name,
            )
        )
        for i, metrics in enumerate(runs):
            rows.append(
                RunRow(
                    cell=name,
                    sha256=name,
                    code_sha256="",
                    seed=i // repetitions,
                    repetition=i % repetitions,
                    end_reason="worker_died" if metrics is None else "goal",
                    end_message="",
                    end_time=10.0,
                    metrics=dict(metrics or {}),
                    by_behavior={},
                    cost={},
                    extras={},
                )
            )
    scenarios = list(dict.fromkeys(scenario for scenario, _ in values))
    seeds = max(len(it) for it in values.values()) // repetitions
    made = Suite(
        scenarios=scenarios, seeds=seeds, repetitions=repetitions, **suite
    )
    return SuiteResult(made, cells, rows)


def runs_of(times, arrived=None):
    """Returns runs that take these times; who does not arrive has none."""
    arrived = [1.0] * len(times) if arrived is None else arrived
    return [
        {
            "completed": done,
            "time_to_reach_goal": time if done else float("nan"),
            "path_length": time / 2 if done else 1.0,
        }
        for time, done in zip(times, arrived, strict=True)
    ]
