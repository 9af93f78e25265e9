"""The status of a node."""

from enum import IntEnum

from hunav_drake.systems.common.field_docs import explain


@explain
class NodeStatus(IntEnum):
    """The status that a node returns when it is ticked.

    The values are those of BehaviorTree.CPP. Compare with `is`: it is faster
    than `==`, and each status is one object.
    """

    IDLE = 0
    """Not ticked."""

    RUNNING = 1
    """Needs more ticks."""

    SUCCESS = 2
    """Completed with success."""

    FAILURE = 3
    """Completed without success, or could not be done."""

    SKIPPED = 4
    """Skipped: its parent goes on as if the node were not there."""


IDLE = NodeStatus.IDLE
RUNNING = NodeStatus.RUNNING
SUCCESS = NodeStatus.SUCCESS
FAILURE = NodeStatus.FAILURE
SKIPPED = NodeStatus.SKIPPED
