"""The error of a broken planner."""

import traceback
from types import CodeType


class PlannerError(RuntimeError):
    """A planner failed, or its decision is not valid.

    Attributes:
        planner: The name of the planner.
        time: The simulated time of the failure, in seconds.
        reason: The description of the failure.
        robot: The name of its robot; empty if there is one only.
    """

    def __init__(
        self, planner: str, time: float, reason: str, robot: str = ""
    ) -> None:
        """Constructs a PlannerError: see its attributes."""
        # All of them, so that it can be pickled.
        super().__init__(planner, time, reason, robot)
        self.planner = planner
        self.time = time
        self.reason = reason
        self.robot = robot

    def __str__(self) -> str:
        owner = f" of {self.robot!r}" if self.robot else ""
        return (
            f"planner {self.planner!r}{owner} failed at t = {self.time:.3f} s:"
            f" {self.reason}"
        )


def told(error: BaseException, code: CodeType | None = None) -> str:
    """Returns an exception as one line: its type, text and location.

    Args:
        error: The exception.
        code: Code in the file whose last line in the traceback is given; by
            default, the file that raised the exception.
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
