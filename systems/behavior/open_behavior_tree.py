"""The BehaviorTree of people who come and go."""

from hunav_drake.systems.behavior.behavior_tree import BehaviorTree


class OpenBehaviorTree(BehaviorTree):
    """A `BehaviorTree` that does not tick the trees of people outside.

    .. pydrake_system::

        name: OpenBehaviorTree
        input_ports:
        - human_states
        - robot_states
        - social_signals (only with social leaves)
        - robot_signals (only with social leaves)
        output_ports:
        - commands
        - behavior_status
        - node_status
        - signals (only with social leaves)

    It differs from a `BehaviorTree` for people who are outside (see
    `layout.OUTSIDE`): their commands are to go nowhere, their other outputs
    are 0, and their memories are as at the start, so that people who come in
    begin anew.
    """

    _CAN_BE_OUTSIDE = True
