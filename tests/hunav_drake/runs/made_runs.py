"""Suites whose runs are made up, so that what follows is known."""

from hunav_drake.runs import Suite, SuiteResult
from hunav_drake.runs.cells import Cell
from hunav_drake.runs.run_row import RunRow


def make_cell(scenario, planner):
    """Returns a cell of a suite, which is known by its name alone."""
    name = f"{scenario}/{planner}"
    return Cell(
        scenario=scenario, planner=planner, setting="", text="", sha256=name
    )


def make_row(cell, seed, metrics, **others):
    """Returns a run of a cell that ended at the goal after 10 s.

    `others` are further fields of `RunRow`, or others than these.
    """
    fields = {
        "scenario": cell.scenario,
        "planner": cell.planner,
        "setting": cell.setting,
        "drawn": cell.drawn,
        "sha256": cell.sha256,
        "seed": seed,
        "end_reason": "goal",
        "end_message": "",
        "end_time": 10.0,
        "metrics": metrics,
        "by_behavior": {},
    }
    return RunRow(**fields | others)


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
        cells.append(make_cell(scenario, planner))
        rows += [
            make_row(
                cells[-1],
                i // repetitions,
                dict(metrics or {}),
                repetition=i % repetitions,
                **_end(metrics),
            )
            for i, metrics in enumerate(runs)
        ]
    scenarios = list(dict.fromkeys(scenario for scenario, _ in values))
    seeds = max(len(it) for it in values.values()) // repetitions
    made = Suite(
        scenarios=scenarios, seeds=seeds, repetitions=repetitions, **suite
    )
    return SuiteResult(made, cells, rows)


def _end(metrics):
    """Returns why a run ended, by its metrics."""
    if metrics is None:
        return {"end_reason": "worker_died"}
    if metrics.get("completed") != 0:
        return {"end_reason": "goal"}
    # No two stand at the same place.
    away = metrics.get("path_length", 1.0)
    return {"end_reason": "stuck", "end_message": f"a wall, {away:.2f} m off"}


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
