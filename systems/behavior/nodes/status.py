"""The result of ticking a node."""

from enum import IntEnum


class Status(IntEnum):
    """What a node says when it is ticked.

    The values are those of BehaviorTree.CPP. Compare with `is`: it is faster
    than `==`, and each status is one object.
    """

    # Not ticked.
    IDLE = 0
    # Needs more ticks.
    RUNNING = 1
    SUCCESS = 2
    FAILURE = 3
    # Asked not to be ticked: its parent goes on as if it were not there.
    SKIPPED = 4
