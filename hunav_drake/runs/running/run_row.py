"""One run of a suite: a row of its log, and of its tables."""

from collections.abc import Sequence
import json
import math
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np
from pydantic import TypeAdapter, ValidationError

from hunav_drake.runs.running.code_hash import hash_of_all
from hunav_drake.runs.running.extras import extra_values
from hunav_drake.systems.common.plain_errors import message_of

if TYPE_CHECKING:
    from hunav_drake.runs.running.task import Task
    from hunav_drake.systems.evaluation.recording import Recording
    from hunav_drake.trial.result import TrialResult

# The reason of a run that raised an error.
ERROR = "error"

# That of a run whose worker has died: it is run again when its suite is.
LOST = "worker_died"

# The reasons of runs that have no metrics.
NO_RESULT = (ERROR, LOST)

# The reasons of runs that say nothing of a planner, but that it is broken.
FAILED = (*NO_RESULT, "planner_failed")


class RunRow(NamedTuple):
    """What is kept of a run.

    Attributes:
        cell: The name of the cell.
        sha256: The hash of the cell.
        code_sha256: The hash of the code that has run it: see `hash_of_all`.
        seed: Its seed.
        repetition: Which of the runs of that seed it is, from 0.
        end_reason: As in `TrialResult`, or "error", or "worker_died".
        end_message: The same in words.
        end_time: In seconds of simulated time.
        metrics: The values by name.
        by_behavior: The values by behavior, then by name.
        cost: Seconds by name: "wall" and "cpu" of the whole run, and of the
            planner's cycles "cycle_median" and "cycle_p95", where they are
            known. They alone differ between equal runs.
        extras: Further numbers by name: see `extra_values`.
        recording: What happened, if it was asked for.
    """

    cell: str
    sha256: str
    code_sha256: str
    seed: int
    repetition: int
    end_reason: str
    end_message: str
    end_time: float
    metrics: dict[str, float]
    by_behavior: dict[str, dict[str, float]]
    cost: dict[str, float]
    extras: dict[str, float]
    recording: "Recording | None" = None

    @property
    def key(self) -> tuple[str, int, int]:
        """What no two rows of a log share."""
        return self.sha256, self.seed, self.repetition


# Its types, which what is read from a file is checked by. (mypy takes names of
# fields that are written out only.)
_FIELDS: TypeAdapter[Any] = TypeAdapter(
    TypedDict(  # type: ignore[operator]
        "_Fields",
        {
            name: kind
            for name, kind in RunRow.__annotations__.items()
            if name != "recording"
        },
    )
)


def make_row(
    result: "TrialResult",
    task: "Task",
    seed: int,
    repetition: int,
    cost: dict[str, float],
) -> RunRow:
    """Returns the row of a trial that has ended."""
    is_kept = task.keep == seed and repetition == 0
    return RunRow(
        cell=task.cell,
        sha256=task.sha256,
        code_sha256=hash_of_all(task.code),
        seed=seed,
        repetition=repetition,
        end_reason=result.end_reason,
        end_message=result.end_message,
        end_time=result.end_time,
        metrics={str(k): float(v) for k, v in result.metrics.items()},
        by_behavior={
            str(behavior): {str(k): float(v) for k, v in values.items()}
            for behavior, values in result.by_behavior.iterrows()
        },
        cost=cost,
        extras=extra_values(result.recording),
        recording=result.recording if is_kept else None,
    )


def cycle_cost(cycles: Sequence[float]) -> dict[str, float]:
    """Returns the median and the 95th percentile of cycles, in seconds."""
    if not cycles:
        return {}
    median, p95 = np.quantile(cycles, (0.5, 0.95)).tolist()
    return {"cycle_median": median, "cycle_p95": p95}


def failed_row(
    task: "Task",
    seed: int,
    repetition: int,
    reason: str,
    end_reason: str = ERROR,
) -> RunRow:
    """Returns the row of a run that has given no result."""
    return RunRow(
        cell=task.cell,
        sha256=task.sha256,
        code_sha256=hash_of_all(task.code),
        seed=seed,
        repetition=repetition,
        end_reason=end_reason,
        end_message=" ".join(reason.split()),
        end_time=math.nan,
        metrics={},
        by_behavior={},
        cost={},
        extras={},
    )


def row_to_json(row: RunRow) -> str:
    """Returns a row as one line, without its recording.

    Numbers are written so that they are read back to the last bit; what is not
    finite is written as NaN, Infinity and -Infinity.
    """
    return json.dumps(row._replace(recording=None)._asdict())


def row_from_json(line: str | bytes) -> RunRow:
    """Returns the row of a line.

    Raises:
        ValueError: If it is not a row.
    """
    data: Any = json.loads(line)
    try:
        # Rows of before there was a hash of the code are of other code.
        row = RunRow(**{"code_sha256": "", **data})
        _FIELDS.validate_python(row._asdict(), strict=True)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        place = ".".join(map(str, fault["loc"]))
        raise ValueError(
            f"is not a run: {place}: {message_of(fault['type'], fault)}"
        ) from error
    except TypeError as error:
        raise ValueError(f"is not a run: {error}") from error
    return row
