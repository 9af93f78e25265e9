"""What is raised when a planner is broken."""

import traceback
from types import CodeType


class PlannerError(RuntimeError):
    """A planner could not decide, or decided something that cannot be.

    Attributes:
        planner: The name of the planner.
        time: When it happened, in seconds of simulated time.
        reason: What happened, in words.
    """

    def __init__(self, planner: str, time: float, reason: str) -> None:
        """Constructs a PlannerError.

        Args:
            planner: The name of the planner.
            time: When it happened, in seconds of simulated time.
            reason: What happened, in words.
        """
        # All of them, so that it goes from one process to another.
        super().__init__(planner, time, reason)
        self.planner = planner
        self.time = time
        self.reason = reason

    def __str__(self) -> str:
        return (
            f"planner {self.planner!r} failed at t = {self.time:.3f} s:"
            f" {self.reason}"
        )


def told(error: BaseException, code: CodeType | None = None) -> str:
    """Returns an exception in one line: its type, its text and its place.

    Args:
        error: The exception.
        code: Of the file of which the last line is told; by default that where
            the exception was raised.
    """
    frames = traceback.extract_tb(error.__traceback__)
    if code is not None:
        own = [it for it in frames if it.filename == code.co_filename]
        frames = traceback.StackSummary.from_list(own) if own else frames
    words = " ".join(str(error).split())
    text = f"{type(error).__name__}: {words}" if words else type(error).__name__
    if not frames:
        return text
    return f"{text} ({frames[-1].filename}:{frames[-1].lineno})"
