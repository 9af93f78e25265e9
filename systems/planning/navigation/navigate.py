"""One cycle of navigation: plan, check, control, recover."""

import math

from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.common.poses import is_at_goal
from hunav_drake.systems.planning.global_planner.navfn import (
    GlobalPath,
    plan_path,
)
from hunav_drake.systems.planning.navigation.memory import (
    Control,
    LocalPlan,
    NavigationMemory,
    Sight,
)
from hunav_drake.systems.planning.navigation.navigation_parameters import (
    NavigationParameters,
)
from hunav_drake.systems.planning.navigation.profiles import cycles
from hunav_drake.systems.planning.navigation.recovery import (
    Situation,
    begin_recovery,
    recover,
)
from hunav_drake.systems.planning.planner import (
    Plan,
    PlannerStatus,
    PlanningTask,
    View,
)
from hunav_drake.systems.world.maps.costs import INSCRIBED, NO_MAP, Costmap


def navigate(now: Situation, memory: NavigationMemory) -> Plan:
    """Returns the decision of a planner with costmaps in one cycle."""
    planner, task, view = now
    x, y, yaw = view.robot[: YAW + 1].tolist()
    goal = tuple(view.goal.tolist())
    if memory.goal != goal:
        memory = NavigationMemory(
            goal=goal, near=(x, y, 0), control=planner.initial_control
        )
    memory = memory._replace(cycle=memory.cycle + 1)
    if is_at_goal(
        (x, y, yaw),
        (goal[0], goal[1], goal[2]),
        tolerance=task.goal_tolerance,
        yaw_tolerance=task.goal_yaw_tolerance,
    ):
        # A robot that is pushed away starts again.
        memory = memory._replace(planned=-1, recovery=None, reason="")
        return _stop(memory, PlannerStatus.ARRIVED, "")
    if memory.failed:
        return _stop(memory, PlannerStatus.FAILED, memory.reason)
    memory = look(now, memory)
    if memory.recovery is not None:
        result, memory = recover(now, memory)
        if result is not None:
            return result
        memory = memory._replace(
            recovery=None,
            planned=-1,
            failing=-1,
            retried=False,
            near=(x, y, memory.cycle),
            control=planner.initial_control,
        )
    if memory.planned < 0 or memory.cycle - memory.planned >= cycles(
        planner.replanning_period, planner.period
    ):
        memory, fault = replan(now, memory)
        if memory.failed:
            return _stop(memory, PlannerStatus.FAILED, fault)
        if fault:
            return begin_recovery(now, memory, fault)
    if (waits := _waits(task, memory, x, y)) is not None:
        return waits
    return follow(now, memory)


def look(now: Situation, memory: NavigationMemory) -> NavigationMemory:
    """Returns a memory with an updated sight for the local map."""
    planner, task, view = now
    setup = planner.setup(task)
    last = memory.sight.cycle
    if last >= 0 and memory.cycle - last < cycles(
        setup.update_period, planner.period
    ):
        return memory
    # The arrays of a View may belong to a Context, which changes.
    robot, humans = view.robot.copy(), view.humans.copy()
    robot.setflags(write=False)
    humans.setflags(write=False)
    marks = None
    if view.scan is not None:
        marks = setup.maps.local_marks(memory.sight.marks, robot, view.scan)
    return memory._replace(sight=Sight(memory.cycle, robot, humans, marks))


def replan(
    now: Situation, memory: NavigationMemory
) -> tuple[NavigationMemory, str]:
    """Returns a memory with a new global plan, or the reason for none.

    The planner gives up if there is no plan without people either, unless the
    robot's own position is the cause.
    """
    planner, task, view = now
    maps = planner.setup(task).maps
    marks = memory.marks
    if view.scan is not None:
        marks = maps.global_marks(marks, view.robot, view.scan, view.goal)
    memory = memory._replace(planned=memory.cycle, marks=marks)
    found = _find(planner, planner.global_map(task, view, memory), view)
    if not found.fault and found.misses == 0:
        return _planned(memory, found), ""
    # Compare with a plan without people.
    still = maps.static_global_map(view.robot, view.goal)
    without = _find(planner, still, view)
    if found.fault:
        if not without.fault:
            return (
                memory,
                f"people or other moving obstacles block it: {found.fault}",
            )
        start_is_free = still.cost_at(*view.robot[:2]) < INSCRIBED
        return (
            memory._replace(failed=start_is_free, reason=found.fault),
            found.fault,
        )
    memory = _planned(memory, found, covered=without.misses == 0)
    return memory._replace(reason=_goal_words(memory)), ""


def _goal_words(memory: NavigationMemory) -> str:
    """Returns the reason why a plan does not end at the goal."""
    what = "people stand on"
    if not memory.covered:
        what = "an obstacle is on, or near,"
    return (
        f"{what} the goal: the nearest reachable place is"
        f" {memory.misses:.2f} m from it"
    )


def _planned(
    memory: NavigationMemory, found: GlobalPath, *, covered: bool = False
) -> NavigationMemory:
    """Returns a memory with a new global plan."""
    found.poses.setflags(write=False)
    return memory._replace(
        path=found.poses,
        first=0,
        misses=found.misses,
        covered=covered,
        is_new=True,
        reason="",
    )


def _find(
    planner: NavigationParameters, costmap: Costmap, view: View
) -> GlobalPath:
    return plan_path(
        costmap,
        view.robot[:2],
        view.goal,
        tolerance=planner.plan_tolerance,
        smoothing="gaussian" if planner.smooth_plan else "none",
    )


def _waits(
    task: PlanningTask, memory: NavigationMemory, x: float, y: float
) -> Plan | None:
    """Returns a stop at the end of a plan that does not reach the goal."""
    if memory.misses == 0.0:
        return None
    end = memory.path[-1]
    if math.hypot(end[X] - x, end[Y] - y) > task.goal_tolerance:
        return None
    if not memory.covered:
        memory = memory._replace(failed=True)
        return _stop(memory, PlannerStatus.FAILED, memory.reason)
    # It waits without limit; that does not count as a lack of progress.
    memory = memory._replace(near=(x, y, memory.cycle))
    return _stop(memory, PlannerStatus.BLOCKED, memory.reason)


def follow(now: Situation, memory: NavigationMemory) -> Plan:
    """Returns the command of the local controller, or a stop or a recovery."""
    planner, task, view = now
    x, y = view.robot[X], view.robot[Y]
    checker = planner.progress_checker
    near_x, near_y, since = memory.near
    if math.hypot(x - near_x, y - near_y) > checker.required_movement_radius:
        memory = memory._replace(near=(float(x), float(y), memory.cycle))
    elif memory.cycle - since > cycles(
        checker.movement_time_allowance, planner.period
    ):
        return begin_recovery(
            now,
            memory,
            f"it has moved less than {checker.required_movement_radius:g} m in"
            f" {checker.movement_time_allowance:g} s"
            + (f"; {_goal_words(memory)}" if memory.misses else ""),
        )
    path = memory.path
    begin, end = planner.local_span(task, view, path, memory.first)
    if begin == end:
        fault = "it is too far from its path"
        return _failing(now, memory, fault)
    local = LocalPlan(path[begin:end], tuple(path[-1].tolist()), memory.is_new)
    costmap = NO_MAP
    if planner.uses_local_map:
        costmap = planner.local_map(task, view, memory)
    command = planner.control(task, view, local, costmap, memory.control)
    if not isinstance(command, Control):
        raise TypeError(
            f"{type(planner).__name__}.control() must give a Control, got"
            f" {command!r:.80}"
        )
    if command.fault:
        return _failing(now, memory, command.fault)
    memory = memory._replace(
        first=begin,
        is_new=False,
        failing=-1,
        retried=False,
        control=command.memory,
    )
    return Plan(
        command.v,
        command.omega,
        PlannerStatus.DRIVING,
        memory,
        path[begin:],
        memory.reason,
    )


def _failing(now: Situation, memory: NavigationMemory, fault: str) -> Plan:
    """Returns a stop, or a recovery after too long without a command.

    Before the recovery, the local map is cleared for one retry.
    """
    planner, task = now.planner, now.task
    if memory.failing < 0:
        memory = memory._replace(failing=memory.cycle)
    elapsed = (memory.cycle - memory.failing + 1) * planner.period
    if elapsed <= planner.setup(task).failure_tolerance + 1e-9:
        return _stop(memory, PlannerStatus.BLOCKED, fault)
    if not memory.retried:
        memory = memory._replace(retried=True, failing=-1, sight=Sight())
        return _stop(memory, PlannerStatus.BLOCKED, fault)
    return begin_recovery(now, memory, fault)


def _stop(memory: NavigationMemory, status: PlannerStatus, reason: str) -> Plan:
    return Plan(0.0, 0.0, status, memory, memory.path[memory.first :], reason)
