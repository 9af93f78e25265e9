"""Recoveries: the actions when navigation fails.

"clear" clears the marks on the costmaps, "spin" turns in place, "wait" waits,
"back_up" drives straight back. Spinning and backing up end as soon as a
collision is predicted (nav2_recoveries, nav2_behaviors).
"""

import math
from typing import NamedTuple

from hunav_drake.systems.common.layout import YAW
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.planning.costmap.footprint import footprint_cost
from hunav_drake.systems.planning.navigation.memory import (
    NavigationMemory,
    Recovery,
    Sight,
)
from hunav_drake.systems.planning.navigation.navigation_parameters import (
    NavigationParameters,
)
from hunav_drake.systems.planning.planner import (
    Plan,
    PlannerStatus,
    PlanningTask,
    View,
)
from hunav_drake.systems.world.maps.costs import LETHAL, UNKNOWN


class Situation(NamedTuple):
    """What navigation works on in one cycle.

    Attributes:
        planner: The parameters and the local controller.
        task: The constant data.
        view: The planner's current observation.
    """

    planner: NavigationParameters
    task: PlanningTask
    view: View


def begin_recovery(
    now: Situation, memory: NavigationMemory, fault: str
) -> Plan:
    """Returns the first command of a recovery, or a stop if it gives up."""
    planner, task, view = now
    path = memory.path[memory.first :]
    if memory.rounds >= planner.recoveries.most:
        reason = f"{fault}; gave up after {memory.rounds} recoveries"
        memory = memory._replace(failed=True, reason=reason)
        return Plan(0.0, 0.0, PlannerStatus.FAILED, memory, path, reason)
    setup = planner.setup(task)
    queue = setup.recoveries
    if setup.one_at_a_time and queue:
        queue = (queue[memory.rounds % len(queue)],)
    x, y, yaw = view.robot[: YAW + 1].tolist()
    memory = memory._replace(
        recovery=Recovery(queue, memory.cycle, x, y, yaw),
        rounds=memory.rounds + 1,
        reason=fault,
        failing=-1,
        retried=False,
    )
    result, memory = recover(now, memory)
    if result is not None:
        return result
    # An empty recovery takes a cycle, too.
    memory = memory._replace(recovery=Recovery((), memory.cycle, x, y, yaw))
    return Plan(0.0, 0.0, PlannerStatus.RECOVERING, memory, path, fault)


def recover(
    now: Situation, memory: NavigationMemory
) -> tuple[Plan | None, NavigationMemory]:
    """Returns the command of a recovery (None at its end) and the memory."""
    view = now.view
    x, y, yaw = view.robot[: YAW + 1].tolist()
    recovery = memory.recovery
    assert recovery is not None
    turned = recovery.turned + wrap_angle(yaw - recovery.yaw)
    recovery = recovery._replace(yaw=yaw, turned=turned)
    while recovery.queue:
        kind = recovery.queue[0]
        if kind == "clear":
            memory = memory._replace(sight=Sight(), marks=None)
            command = None
        else:
            command = _command(kind, now, memory._replace(recovery=recovery))
        if command is not None:
            memory = memory._replace(recovery=recovery)
            words = f"recovers ({kind}): {memory.reason}"
            path = memory.path[memory.first :]
            status = PlannerStatus.RECOVERING
            return Plan(*command, status, memory, path, words), memory
        recovery = Recovery(recovery.queue[1:], memory.cycle, x, y, yaw)
    return None, memory


# Who is held takes no longer for a recovery than this, in seconds (Nav2's
# `time_allowance`), or twice as long as at the lowest speed.
_ALLOWANCE = 10.0


def _command(
    kind: str, now: Situation, memory: NavigationMemory
) -> tuple[float, float] | None:
    """Returns (v, omega) of one recovery; None at its end."""
    planner, task, view = now
    recovery, config = memory.recovery, planner.recoveries
    assert recovery is not None
    at = view.robot[0], view.robot[1]
    elapsed = (memory.cycle - recovery.since) * planner.period
    if kind == "wait":
        return (0.0, 0.0) if elapsed < config.wait_time - 1e-9 else None
    if memory.sight.cycle < 0:
        # The map was cleared; the next cycle rebuilds it.
        return 0.0, 0.0
    costmap = planner.setup(task).maps.local_map(view.robot, memory.sight)
    footprint = planner.setup(task).footprint

    def touches(x: float, y: float, yaw: float) -> bool:
        cost = footprint_cost(
            *(costmap.costs, *costmap.origin, costmap.resolution),
            *(x, y, yaw, footprint),
        )
        return cost < 0 or cost in (LETHAL, UNKNOWN)

    turn_rate = min(config.max_spin, task.limits.max_turn_rate)
    speed = min(config.back_up_speed, task.limits.max_reverse_speed)
    if kind == "spin":
        size, most, slows = config.spin_angle, turn_rate, config.min_spin
    else:
        size, most, slows = config.back_up_distance, speed, speed
    least = min(most, slows)
    if most <= 0 or elapsed > max(_ALLOWANCE, 2 * size / max(least, 1e-9)):
        return None
    if kind == "spin":
        remaining = config.spin_angle - abs(recovery.turned)
        if remaining <= 0 or touches(*at, recovery.yaw):
            return None
        rate = math.sqrt(2 * config.spin_acceleration * remaining)
        rate = min(max(rate, config.min_spin), config.max_spin)
        return 0.0, min(rate, turn_rate)
    done = math.hypot(at[0] - recovery.x, at[1] - recovery.y)
    if done >= config.back_up_distance:
        return None
    for part in (0.25, 0.5, 0.75, 1.0):
        back = part * speed * config.look_ahead
        x = at[0] - back * math.cos(recovery.yaw)
        y = at[1] - back * math.sin(recovery.yaw)
        if touches(x, y, recovery.yaw):
            return None
    return -speed, 0.0
