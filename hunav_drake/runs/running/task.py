"""What is given to a worker: some runs of one cell."""

from dataclasses import dataclass, replace
from typing import Self

from hunav_drake.runs.running.code_hash import CodeHashes


@dataclass(frozen=True, kw_only=True)
class Task:
    """Some runs of one cell.

    Attributes:
        cell: The name of the cell.
        sha256: The hash of the cell.
        text: Its scenario.
        runs: Pairs of a seed and a repetition.
        keep: The seed of which the recording comes with the row, if any.
        code: The hashes of the code that is to run them.
        imports: Modules and files of the user that the worker imports first.
    """

    cell: str
    sha256: str
    text: str
    code: CodeHashes
    runs: tuple[tuple[int, int], ...]
    keep: int | None = None
    imports: tuple[str, ...] = ()

    def one(self, seed: int, repetition: int) -> Self:
        """Returns the task of one of its runs."""
        return replace(self, runs=((seed, repetition),))
