"""Stopping, waiting and changing the group: StopMovement, SetGroupId, ..."""

from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import stand
from hunav_drake.systems.behavior.leaves.social_ports import Seconds
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import social_memory
from hunav_drake.systems.behavior.nodes.status import (
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import Tick
from hunav_drake.systems.behavior.nodes.tick_context import GROUP, STOPPED
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.human_config import MAX_GROUP_ID


@register_action("StopMovement", ignored=IGNORED, social=True)
@jit
def stop_movement(tick: Tick) -> NodeStatus:
    """Stands, whatever else the tree does, until ResumeMovement."""
    social_memory(tick)[STOPPED] = 1.0
    return SUCCESS


@register_action("ResumeMovement", ignored=IGNORED, social=True)
@jit
def resume_movement(tick: Tick) -> NodeStatus:
    """Ends what StopMovement has begun."""
    social_memory(tick)[STOPPED] = 0.0
    return SUCCESS


@register_action(
    "StopAndWaitTimerAction", memory={"ticks": 0.0}, ignored=IGNORED
)
@jit
def stop_and_wait(
    tick: Tick, own: Array, wait_duration: Seconds = 5.0
) -> NodeStatus:
    """Stands for some time."""
    stand(tick)
    tick.behavior_status = 1
    own[0] += 1
    if steps_reach(own[0], tick.time_step, wait_duration):
        own[0] = 0.0
        return SUCCESS
    return RUNNING


@register_action("SetGroupId", ignored=IGNORED, social=True)
@jit
def set_group_id(
    tick: Tick, group_id: Annotated[int, within(-1, MAX_GROUP_ID)]
) -> NodeStatus:
    """Joins a group from now on; -1 is alone."""
    social_memory(tick)[GROUP] = group_id
    tick.group_id = group_id
    return SUCCESS
