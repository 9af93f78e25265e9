"""Runs a trial, and returns its result."""

from collections.abc import Callable, Collection, Sequence
from contextlib import AbstractContextManager, nullcontext
import dataclasses
import math
import re
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import Context, Diagram, EventStatus

from hunav_drake.scenario import SaveScenario
from hunav_drake.scenario.checks import check_begins_alone
from hunav_drake.scenario.error import Fault, ScenarioError, shown
from hunav_drake.scenario.fleet import RobotPart, planners_of, robot_parts
from hunav_drake.scenario.named_files import behavior_sha256, files_sha256
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.layout import STATE_SIZE, is_outside
from hunav_drake.systems.common.plain_errors import ConfigError
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.trial_monitor import TrialStatus
from hunav_drake.systems.people.furniture_places import doors_of
from hunav_drake.systems.planning.planner_error import PlannerError
from hunav_drake.trial.blocks import EACH_STEP
from hunav_drake.trial.diagram import CheckTrialDiagram, MakeTrialDiagram
from hunav_drake.trial.end import explain_end
from hunav_drake.trial.interrupts import interrupts_between_steps
from hunav_drake.trial.planner_failure import (
    CheckCommand,
    IsOwnSystem,
    PlannerErrorOf,
)
from hunav_drake.trial.provenance import MakeProvenance
from hunav_drake.trial.result import (
    EndReason,
    MakeTrialResult,
    TrialResult,
    with_encounters,
    with_situations,
)
from hunav_drake.trial.seeds import (
    CheckIsTrial,
    DrawSeed,
    GetTrialSeed,
    SetTrialSeed,
)

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


def MakeTrialSimulator(
    diagram: Diagram,
    context: Context | None = None,
    *,
    progress: Callable[[float], None] | None = None,
    ends: bool = True,
) -> Simulator:
    """Makes a simulator that ends a trial at the goal, or when it is stuck.

    The trial ends at a whole time step, also if a run was continued. After the
    end, each further `AdvanceTo` advances by one step. A failing planner
    raises a PlannerError from `AdvanceTo`.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: The Context to start from, kept by the simulator: a clone of
            a Context of this diagram; by default, the default Context.
        progress: Called after each step with the time, in seconds.
        ends: Whether the trial ends; otherwise it goes on after the end, for
            the sake of people who are still on their way.
    """
    CheckIsTrial(diagram)
    if context is None:
        simulator = Simulator(diagram)
    elif _skip_done_updates(diagram, context):
        simulator = _LaterSimulator(diagram, context)
    else:
        simulator = Simulator(diagram, context)
    status = diagram.GetOutputPort("trial_status")
    trial = diagram.GetSubsystemByName("monitor")
    is_own = IsOwnSystem(diagram)

    def monitor(root_context: Context) -> EventStatus:
        if progress is not None:
            progress(root_context.get_time())
        if is_own:
            CheckCommand(diagram, root_context)
        own = trial.GetMyContextFromRoot(root_context)
        if not ends or not trial.IsStep(own):
            return EventStatus.DidNothing()
        value = TrialStatus(
            int(status.EvalBasicVector(root_context).GetAtIndex(0))
        )
        if value == TrialStatus.RUNNING:
            return EventStatus.DidNothing()
        message = _MESSAGES[_REASONS[value]]
        return EventStatus.ReachedTermination(diagram, message)

    simulator.set_monitor(monitor)
    return simulator


def _skip_done_updates(diagram: Diagram, context: Context) -> bool:
    """Keeps a new simulator from repeating the updates of an instant.

    A simulator begins with the updates at the current time. If these are done,
    as after a second `AdvanceTo` to the same time, it must begin just after.
    Returns whether it does.
    """
    monitor = diagram.GetSubsystemByName("monitor")
    own = monitor.GetMyContextFromRoot(context)
    if not monitor.HasUpdated(own):
        return False
    # (That of an earlier fork at the instant is just after it already.)
    if monitor.IsStep(own):
        context.SetTime(_just_after(context.get_time()))
    return True


def _just_after(time: float) -> float:
    return max(math.nextafter(time, math.inf), 1e-15)


class _LaterSimulator(Simulator):
    """A simulator that begins just after an instant, and takes it for done."""

    def AdvanceTo(
        self, boundary_time: float, interruptible: bool = True
    ) -> SimulatorStatus:
        """Advances to a time; nothing happens if it is that instant."""
        present = self.get_context().get_time()
        if _just_after(boundary_time) == present:
            boundary_time = present
        return super().AdvanceTo(boundary_time, interruptible)


# The text of a PlannerError.
_FAILED = re.compile(r"failed at t = ([\d.]+) s: (.*)", re.DOTALL)


def RunTrial(
    scenario: Scenario,
    seed: int | None = None,
    *,
    diagram: Diagram | None = None,
    meshcat: "Meshcat | None" = None,
    realtime_rate: float = 0.0,
    progress: Callable[[float], None] | None = None,
    watch: Callable[[Context], bool] | None = None,
    on_planner_error: Literal["end", "raise"] = "end",
) -> TrialResult:
    """Runs a trial to its end.

    Several seeds of one scenario can share a diagram, unless the seed draws the
    people. This is faster, since a reset takes less time than a new diagram,
    and the results are the same, bit for bit:

        diagram = MakeTrialDiagram(scenario)
        results = [RunTrial(scenario, s, diagram=diagram) for s in range(100)]

    Args:
        scenario: The scenario.
        seed: Replaces the seed of the scenario.
        diagram: From `MakeTrialDiagram(scenario)`, with the same `meshcat`, for
            any seed, or for this seed if it draws the people; by default, a
            new one.
        meshcat: The Meshcat that shows the trial and records it for a replay.
        realtime_rate: The largest ratio of simulated to real time; 0 for no
            limit.
        progress: Called after each step with the time, in seconds.
        watch: Called after each step with the Context, repeatedly until it
            returns true, so that it can pause the trial. If given, browsers
            show the trial while it runs.
        on_planner_error: The response to a planner that raises an exception,
            gives a command that is not finite, or exceeds its `cycle_limit`.
            "end" ends the trial, with the end reason "planner_failed" and the
            results so far; "raise" raises.

    Returns:
        The metrics, the recording, and why the trial ended.

    Raises:
        PlannerError: If the planner fails and `on_planner_error` is "raise".
        ScenarioError: If the scenario cannot be simulated.
        ValueError: If the diagram was made from another scenario, or another
            seed drew its people.
    """
    check_choice("on_planner_error", on_planner_error, ("end", "raise"))
    if seed is not None:
        scenario = _reseed(scenario, seed)
    if diagram is None:
        diagram = MakeTrialDiagram(scenario, meshcat, drawn=False)
    else:
        CheckTrialDiagram(scenario, diagram)
    check_begins_alone(scenario)
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, scenario.simulation.seed)
    with (
        interrupts_between_steps() as check_interrupt,
        _recording(
            diagram, meshcat, live=realtime_rate > 0 or watch is not None
        ),
    ):

        def step(seconds: float) -> None:
            check_interrupt()
            if progress is not None:
                progress(seconds)
            while watch is not None and not watch(simulator.get_context()):
                check_interrupt()

        simulator = MakeTrialSimulator(diagram, context, progress=step)
        simulator.set_target_realtime_rate(realtime_rate)
        failure = None
        try:
            simulator.AdvanceTo(scenario.simulation.duration)
        except Exception as error:
            context = simulator.get_context()
            failure = PlannerErrorOf(error, diagram, context)
            if failure is None:
                raise
            if on_planner_error == "raise":
                raise failure from failure.__cause__
        finally:
            # The monitor refers to the simulator: a cycle of references.
            simulator.clear_monitor()
        if meshcat is not None:
            # Frames have their own period; the end needs one, too.
            diagram.ForcedPublish(simulator.get_context())
    context = simulator.get_context()
    if failure is not None:
        parts = robot_parts(scenario)
        ends = [
            _end_at_failure(part, diagram, context, failure) for part in parts
        ]
        return _result(scenario, diagram, context, parts, ends, failure)
    if on_planner_error == "raise":
        _raise_failure(scenario, diagram, context)
    return GetTrialResult(scenario, diagram, context)


def _raise_failure(
    scenario: Scenario, diagram: Diagram, context: Context
) -> None:
    """Raises a PlannerError if planners of several robots failed: the first."""
    failed = []
    for part in robot_parts(scenario):
        end = _end_of(part, diagram, context)
        if end.reason == "planner_failed":
            assert end.time is not None
            # The text of an error, which has the time of the failure.
            found = _FAILED.search(end.message)
            time, reason = found.groups() if found else (end.time, end.message)
            planner = name_of(part.scenario.planner)
            failed.append(PlannerError(planner, float(time), reason, part.name))
    if failed:
        raise min(failed, key=lambda it: it.time)


def MakeRandomSimulator(
    scenario: Scenario,
) -> Callable[[RandomGenerator], Simulator]:
    """Makes the simulator factory for Drake's `MonteCarloSimulation`.

    Each simulator has its own diagram, with a seed drawn from the generator,
    and ends its trial as `MakeTrialSimulator` does:

        results = MonteCarloSimulation(
            MakeRandomSimulator(scenario), output, final_time=60.0,
            num_samples=4, generator=RandomGenerator(1),
        )

    where `output(diagram, context)` returns a number. `GetTrialSeed` returns
    the seed there, with which `RunTrial` repeats the trial. `RunTrial` over
    several seeds of one diagram is faster.

    Args:
        scenario: The scenario, whose seed does not matter.

    Returns:
        A function that makes the Simulator of a trial from a RandomGenerator.
    """
    check_begins_alone(scenario)

    def make(generator: RandomGenerator) -> Simulator:
        seeded = _reseed(scenario, DrawSeed(generator))
        return MakeTrialSimulator(MakeTrialDiagram(seeded))

    return make


def _reseed(scenario: Scenario, seed: int) -> Scenario:
    try:
        simulation = dataclasses.replace(scenario.simulation, seed=seed)
    except ConfigError as error:
        rule = f"must be a whole number in [0, 2^63), got {shown(seed)}"
        fault = Fault("RunTrial", 0, "seed", rule)
        raise ScenarioError("RunTrial", [fault]) from error
    return dataclasses.replace(scenario, simulation=simulation)


def GetTrialResult(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    since: float = -math.inf,
    robots: Collection[str] | None = None,
) -> TrialResult:
    """Returns the result of a trial up to the time of its Context.

    Args:
        scenario: The scenario, with the metrics to compute.
        diagram: From `MakeTrialDiagram(scenario)`.
        context: A Context of that diagram; its seed counts, not that of the
            scenario.
        since: The time from which on the trial counts, in seconds; by
            default, all of it.
        robots: The names of those of several robots that are there; by
            default, all of them. The result of one is that of a single robot.

    Raises:
        ValueError: If the diagram was made from another scenario, or nothing
            was recorded since that time.
    """
    scenario = _reseed(scenario, GetTrialSeed(diagram, context))
    CheckTrialDiagram(scenario, diagram)
    parts = robot_parts(scenario)
    if robots is not None:
        known = [it.name for it in parts]
        if not robots or {*robots} - {*known}:
            raise ValueError(f"robots must be some of {known}, got {robots}")
        parts = [it for it in parts if it.name in robots]
    ends = [_end_of(part, diagram, context) for part in parts]
    return _result(scenario, diagram, context, parts, ends, since=since)


class _End(NamedTuple):
    """The end of a robot: its reason, in words, and the time in seconds."""

    reason: EndReason
    message: str
    time: float | None = None


def _end_of(part: RobotPart, diagram: Diagram, context: Context) -> _End:
    """Returns the end of a robot by the time of a Context."""
    time = None
    if part.name:
        rows = diagram.GetOutputPort("robot_ends").Eval(context).reshape(-1, 2)
        status, when = rows[[*diagram.prefixes].index(part.name)].tolist()
        time = when if when >= 0 else None
    else:
        (status,) = diagram.GetOutputPort("trial_status").Eval(context)
    reason = _REASONS[TrialStatus(int(status))]
    duration = part.scenario.simulation.duration
    if reason == "running" and context.get_time() >= duration * (1 - 1e-9):
        reason = "timeout"
    (over,) = diagram.GetOutputPort("trial_status").Eval(context)
    if reason == "running" and over != TrialStatus.RUNNING:
        reason = "end"
    return _End(reason, _end_message(reason, part, diagram, context), time)


def _end_at_failure(
    part: RobotPart, diagram: Diagram, context: Context, failure: PlannerError
) -> _End:
    """Returns the end of a robot when a planner has ended the trial.

    (Planners of several robots fail one by one, unless they are own systems.)
    """
    if not part.name:
        return _End("planner_failed", str(failure))
    # The ports may depend on the broken planner, the state does not.
    monitor = diagram.GetSubsystemByName("monitor")
    rows = monitor.GetEnds(monitor.GetMyContextFromRoot(context))
    status, when = rows[[*diagram.prefixes].index(part.name)].tolist()
    reason = _REASONS[TrialStatus(int(status))]
    if reason != "running":
        return _End(reason, _MESSAGES[reason], when)
    if part.name == failure.robot:
        return _End("planner_failed", str(failure), context.get_time())
    return _End("end", _MESSAGES["end"])


def _result(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    parts: Sequence[RobotPart],
    ends: Sequence[_End],
    failure: PlannerError | None = None,
    since: float = -math.inf,
) -> TrialResult:
    """Returns the result of a trial with the ends of its robots.

    It has failed if a planner has ended it, even one that was at its goal.
    """
    config = scenario.evaluator

    def recorded(system: str) -> Recording:
        first, *others = (
            dataclasses.replace(
                _recording_of(part, diagram, context, system).since(since),
                hunavsim_forces=config.forces == "hunavsim",
                doors=doors_of(scenario.places, scenario.world),
                robot_name=part.name,
                end_time=end.time,
            )
            for part, end in zip(parts, ends, strict=True)
        )
        return dataclasses.replace(first, others=tuple(others))

    recording = recorded("evaluator")
    has_steps = diagram.HasSubsystemNamed(f"{parts[0].prefix}{EACH_STEP}")
    steps = recorded(EACH_STEP) if has_steps else recording
    # (What is recorded begins and ends with the samples.)
    steps = steps.since(recording.times[0]).until(recording.times[-1])
    end_time = _time_of(context, recording)
    if len(parts) < len(robot_parts(scenario)):
        # (The trial goes on after the end of those that are left.)
        times = (end_time if it.time is None else it.time for it in ends)
        end_time = max(since, *times)
        recording, steps = recording.until(end_time), steps.until(end_time)
    told = [_told(part, end) for part, end in zip(parts, ends, strict=True)]
    if failure is not None and str(failure) not in (it.message for it in ends):
        told.append(str(failure))
    result = MakeTrialResult(
        recording.with_stale_samples(config.stale_samples, config.period),
        scenario_name=scenario.name,
        metric_names=scenario.evaluator.metrics,
        provenance=MakeProvenance(
            SaveScenario(scenario),
            seed=scenario.simulation.seed,
            planner=planners_of(scenario),
            behavior_sha256=behavior_sha256(scenario),
            files_sha256=files_sha256(scenario),
            drawn=drawn_by_seed(scenario),
        ),
        end_reason=max((it.reason for it in ends), key=_WORST.index)
        if failure is None
        else "planner_failed",
        end_message=ends[0].message if len(ends) == 1 else "; ".join(told),
        end_time=end_time,
        robot_ends={
            part.name: end.reason
            for part, end in zip(parts, ends, strict=True)
            if part.name
        },
    )
    if config.situations:
        result = with_situations(result)
    return with_encounters(result, steps) if config.encounters else result


def _told(part: RobotPart, end: _End) -> str:
    when = "" if end.time is None else f" after {end.time:.2f} s"
    return f"{part.name}: {end.reason}{when} ({end.message})"


def _end_message(
    reason: EndReason, part: RobotPart, diagram: Diagram, context: Context
) -> str:
    """Returns why a trial ended, with the reason of its planner."""
    parts = [_MESSAGES[reason]]
    if reason not in ("stuck", "timeout", "planner_failed"):
        return parts[0]
    planner = diagram.GetSubsystemByName(f"{part.prefix}planner")
    words = ""
    if hasattr(planner, "GetReason"):
        words = planner.GetReason(planner.GetMyContextFromRoot(context))
    if reason == "planner_failed":
        return words or parts[0]
    if words:
        parts.append(f"the planner: {words}")
    estimate = f"{part.prefix}estimated_robot_state"
    if diagram.HasOutputPort(estimate):
        x, y, yaw = (
            diagram.GetOutputPort(estimate).Eval(context)
            - diagram.GetOutputPort(f"{part.prefix}robot_state").Eval(context)
        )[:3].tolist()
        parts.append(
            f"the pose that the planner has is off by {math.hypot(x, y):.2f} m"
            f" and {abs(yaw):.2f} rad"
        )
    recording = _recording_until_now(part, diagram, context)
    for other in robot_parts(diagram.scenario):
        # (Other robots may be in the way, as people.)
        if other.name != part.name:
            robot = _recording_until_now(other, diagram, context).robot
            recording = dataclasses.replace(
                recording,
                humans=np.append(recording.humans, robot[:, None], axis=1),
                human_names=(*recording.human_names, f"robot {other.name}"),
                human_ids=(),
                behaviors=(),
                group_ids=(),
                # The explanation does not need these.
                behavior_status=None,
                contacts=None,
                wall_contact=None,
                replay=None,
                social_signals=None,
            )
    why = explain_end(recording, part.scenario)
    return "; ".join([*parts, why] if why else parts)


def _recording_of(
    part: RobotPart,
    diagram: Diagram,
    context: Context,
    system: str = "evaluator",
) -> Recording:
    evaluator = diagram.GetSubsystemByName(f"{part.prefix}{system}")
    recording: Recording = evaluator.GetRecording(
        evaluator.GetMyContextFromRoot(context)
    )
    return recording


def _recording_until_now(
    part: RobotPart, diagram: Diagram, context: Context
) -> Recording:
    """Returns the recording of a robot, with a sample of the current time."""
    recording = _recording_of(part, diagram, context)
    now = _time_of(context, recording)
    if recording.times[-1] == now:
        return recording
    rows = np.concatenate(
        [
            diagram.GetOutputPort(name).Eval(context)
            for name in (f"{part.prefix}robot_state", "human_states")
        ]
    ).reshape(-1, STATE_SIZE)
    rows[is_outside(rows)] = np.nan
    return dataclasses.replace(
        recording,
        times=np.append(recording.times, now),
        robot=np.vstack([recording.robot, rows[:1]]),
        humans=np.concatenate([recording.humans, rows[None, 1:]]),
        # The explanation of the end does not need these.
        behavior_status=None,
        contacts=None,
        wall_contact=None,
        contact_forces_known=False,
    )


def _time_of(context: Context, recording: Recording) -> float:
    """Returns the current time, or that of the last sample if equal.

    A simulator may begin just after an instant: see `_skip_done_updates`.
    """
    last, now = float(recording.times[-1]), context.get_time()
    return (
        last if math.isclose(last, now, rel_tol=1e-12, abs_tol=1e-12) else now
    )


def _recording(
    diagram: Diagram, meshcat: "Meshcat | None", *, live: bool
) -> AbstractContextManager[None]:
    """Returns a context manager that records a trial in Meshcat, if any."""
    if meshcat is None:
        return nullcontext()
    from hunav_drake.systems.scene.overlays.viewer import RecordReplay

    scene = diagram.GetSubsystemByName("scene")
    visualizer = scene.GetSubsystemByName("meshcat_visualizer")
    return RecordReplay(visualizer, live=live)


_REASONS: dict[TrialStatus, EndReason] = {
    TrialStatus.RUNNING: "running",
    TrialStatus.GOAL: "goal",
    TrialStatus.STUCK: "stuck",
    TrialStatus.PLANNER_FAILED: "planner_failed",
}

# From the best to the worst. (A robot without a goal has no other end than
# that of the trial.)
_WORST: tuple[EndReason, ...] = (
    *("end", "goal", "running", "timeout", "stuck", "planner_failed"),
)

_MESSAGES: dict[EndReason, str] = {
    "running": "the trial is not over",
    "end": "the trial is over",
    "timeout": "the time is over",
    "goal": "the robot has reached its goal",
    "stuck": "the robot no longer gets anywhere",
    "planner_failed": "the planner has failed",
}
