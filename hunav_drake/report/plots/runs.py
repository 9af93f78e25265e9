"""The input of plots: runs and their names."""

from collections.abc import Iterable, Mapping, Sequence, Sized
from typing import Any

from hunav_drake.runs.settings import short_settings
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.result import TrialResult

Run = Recording | TrialResult

# One run, several runs, or several runs by name.
Runs = Run | Iterable[TrialResult] | Mapping[str, Run]


def recordings(data: Runs) -> dict[str, Recording]:
    """Returns the recordings of runs by name.

    The name of a single run is empty. For several results see `run_names`.

    Raises:
        TypeError: If the data are not of type `Runs`.
        ValueError: If there is no run.
    """
    if isinstance(data, Recording | TrialResult):
        return {"": _recording(data)}
    runs = data if isinstance(data, Mapping) else list(data)
    check_any(runs)
    if isinstance(runs, Mapping):
        return {str(name): _recording(run) for name, run in runs.items()}
    results = runs
    for result in results:
        if not isinstance(result, TrialResult):
            raise TypeError(
                "needs a recording, a result, several results, or a dict of"
                f" either by name; got {type(result).__name__} in a list"
            )
    return {
        name: result.recording
        for name, result in zip(run_names(results), results, strict=True)
    }


def check_any(runs: Sized) -> None:
    """Checks that there is a run to draw.

    Raises:
        ValueError: If there is none.
    """
    if not len(runs):
        raise ValueError("there are no runs to draw; give at least one")


def robots_apart(runs: Mapping[str, Recording]) -> dict[str, Recording]:
    """Returns runs with an entry for each robot until its end, by its name.

    The name of a run is before those of its robots; a run with a single robot
    is as it was.
    """
    return {
        ", ".join(filter(None, (name, it.robot_name))): it.until_end()
        for name, run in runs.items()
        for it in run.robots
    }


def run_names(results: list[TrialResult]) -> list[str]:
    """Returns a short name for each result; no two are equal.

    A name consists of the properties that differ between the results:
    scenario, planner, setting, seed. Names that are still equal get a number.
    """
    short = short_settings(dict.fromkeys(r.setting for r in results))
    return telling_names(
        [
            (
                r.scenario_name,
                _told(r, "planner"),
                short[r.setting],
                _told(r, "seed", "seed "),
            )
            for r in results
        ]
    )


def telling_names(parts: Sequence[Sequence[str]]) -> list[str]:
    """Returns a name for each run, from the parts that differ.

    Names that are equal get a number; a single run has none.
    """
    if len(parts) == 1:
        return [""]
    differs = [len(set(column)) > 1 for column in zip(*parts, strict=True)]
    names: list[str] = []
    for row in parts:
        chosen = [p for p, d in zip(row, differs, strict=True) if d and p]
        base = ", ".join(chosen) or "run"
        name, count = base, 1
        while name in names:
            count += 1
            name = f"{base} ({count})"
        names.append(name)
    return names


def _told(result: TrialResult, key: str, prefix: str = "") -> str:
    value = result.provenance.get(key, "")
    return f"{prefix}{value}" if value != "" else ""


def _recording(run: Any) -> Recording:
    if isinstance(run, TrialResult):
        return run.recording
    if isinstance(run, Recording):
        return run
    raise TypeError(
        f"needs a recording or a result of a trial, got {type(run).__name__}"
    )
