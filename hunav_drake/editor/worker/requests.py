"""What is asked of the worker, and the runs that come of it."""

from collections.abc import Mapping
import dataclasses
import os
from pathlib import Path
import shlex
from typing import Any

# More runs at once are a matter of `hunav bench`.
MAX_RUNS = 1000


class RequestError(ValueError):
    """A request that cannot be done; the text says why in one line."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunRequest:
    """Runs of one scenario.

    Attributes:
        text: The scenario's YAML.
        folder: Where its paths start; None for the present folder.
        filename: The file that it was read from; None if there is none.
        name: Which one of the file's scenarios it is; None if there is one.
        revision: Which state of the editor it is.
        seeds: One run for each of these; None is the scenario's own seed.
        planners: ... and for each of these; None is the scenario's own.
        speed: How many times as fast as real time runs go at most; 0 for as
            fast as they can.
        workers: How many processes run at a time, at most.
    """

    text: str
    folder: str | None = None
    filename: str | None = None
    name: str | None = None
    revision: int = 0
    seeds: tuple[int | None, ...] = (None,)
    planners: tuple[str | None, ...] = (None,)
    speed: float = 0.0
    workers: int = 1


@dataclasses.dataclass(kw_only=True)
class Run:
    """One run, as far as it has come.

    Attributes:
        number: What tells it from all others.
        request: What it is of.
        seed: Its seed; None for the scenario's own.
        planner: Its planner; None for the scenario's own.
        result: The message about its result, once there is one.
        folder: The folder of its files, once they are there.
    """

    number: int
    request: RunRequest
    seed: int | None
    planner: str | None
    result: dict[str, Any] | None = None
    folder: Path | None = None

    def command(self, out: Path | None) -> str:
        """Returns the line for a terminal that does the same."""
        request = self.request
        words = ["hunav", "run", request.filename or "SCENARIO.yaml"]
        if request.name is not None:
            words += ["--name", request.name]
        if self.seed is not None:
            words += ["--seed", str(self.seed)]
        if self.planner is not None:
            words += ["--planner", self.planner]
        if out is not None:
            words += ["--out", str(out)]
        return shlex.join(words)


def read_request(message: Mapping[str, Any]) -> RunRequest:
    """Returns the runs that a message asks for.

    Raises:
        RequestError: If it cannot be done.
    """
    seeds = _listed(message.get("seeds"))
    for seed in seeds:
        is_whole = isinstance(seed, int) and not isinstance(seed, bool)
        if seed is not None and not (is_whole and 0 <= seed < 2**63):
            raise RequestError(
                f"a seed must be a whole number in [0, 2^63), got {seed!r:.40};"
                " write them as in 0-4 or 1, 5, 9"
            )
    planners = _listed(message.get("planners"))
    for planner in planners:
        if planner is not None and not isinstance(planner, str):
            raise RequestError(f"a planner is a name, got {planner!r:.40}")
    count = len(seeds) * len(planners)
    if count > MAX_RUNS:
        raise RequestError(
            f"at most {MAX_RUNS} runs are done at once, got {count}; choose"
            " fewer seeds or planners, or make a suite for `hunav bench`"
        )
    speed = message.get("speed") or 0.0
    if not isinstance(speed, int | float) or not 0 <= speed <= 1000:
        raise RequestError(
            f"the speed must be in [0, 1000] times real time, got {speed!r:.40}"
        )
    workers = message.get("workers") or 1
    if not isinstance(workers, int) or workers < 1:
        raise RequestError(
            f"workers must be a whole number of at least 1, got {workers!r:.40}"
        )
    return RunRequest(
        text=str(message["text"]),
        folder=_path(message.get("folder")),
        filename=_path(message.get("filename")),
        name=message.get("name"),
        revision=int(message.get("revision") or 0),
        seeds=tuple(seeds),
        planners=tuple(planners),
        speed=float(speed),
        workers=min(workers, os.cpu_count() or 1, count),
    )


def _listed(value: Any) -> list[Any]:
    """Returns what a list holds, each once; [None] for nothing."""
    values = value if isinstance(value, list | tuple) else []
    # 1 equals True, and a list has no hash.
    unique = {repr(member): member for member in values}
    return list(unique.values()) or [None]


def _path(value: Any) -> str | None:
    return None if value is None else str(value)
