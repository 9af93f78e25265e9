"""Requests to the worker, and the runs that they start."""

from collections.abc import Sequence
import dataclasses
from pathlib import Path
import shlex
from typing import Any


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunRequest:
    """A request to run a scenario.

    Attributes:
        text: The scenario's YAML.
        folder: The folder of its relative paths; None for the current one.
        filename: The file of the scenario; None if there is none.
        name: Its name, if the file has several scenarios.
        revision: The revision of the editor's document.
        seeds: One run for each seed; by default only the scenario's own.
        planners: One run for each planner; by default only the scenario's own.
        speed: The speed limit relative to real time; 0 for none.
        workers: The maximum number of processes.
    """

    text: str
    folder: str | None = None
    filename: str | None = None
    name: str | None = None
    revision: int = 0
    seeds: Sequence[int] = ()
    planners: Sequence[str] = ()
    speed: float = 0.0
    workers: int = 1

    def runs(self, first: int = 1) -> list["Run"]:
        """Returns a run for each planner and seed, numbered from `first`."""
        pairs = [
            (planner, seed)
            for planner in dict.fromkeys(self.planners) or (None,)
            for seed in dict.fromkeys(self.seeds) or (None,)
        ]
        return [
            Run(number=number, request=self, seed=seed, planner=planner)
            for number, (planner, seed) in enumerate(pairs, first)
        ]


@dataclasses.dataclass(kw_only=True)
class Run:
    """The progress of one run.

    Attributes:
        number: Its unique number.
        request: The request that started it.
        seed: Its seed; None for the scenario's own.
        planner: Its planner; None for the scenario's own.
        result: The message with its result, once there is one.
        folder: The folder of its files, once they are written.
    """

    number: int
    request: RunRequest
    seed: int | None
    planner: str | None
    result: dict[str, Any] | None = None
    folder: Path | None = None

    def command(
        self,
        out: Path | None,
        *,
        own_planner: bool = False,
        imports: Sequence[str] = (),
    ) -> str:
        """Returns the command that does the same in a terminal.

        Args:
            out: The folder of its results; None for none.
            own_planner: Whether its planner is that of the scenario, with its
                parameters.
            imports: Modules of users.
        """
        request = self.request
        words = ["hunav", "run", request.filename or "SCENARIO.yaml"]
        for option, value in (
            ("--name", request.name),
            ("--seed", self.seed),
            ("--planner", None if own_planner else self.planner),
            ("--out", out),
            *(("--import", it) for it in imports),
        ):
            if value is not None:
                words += [option, str(value)]
        return shlex.join(words)
