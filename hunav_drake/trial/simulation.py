"""The run of a trial, and its result."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
import dataclasses
import math
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, EventStatus

from hunav_drake.scenario import SaveScenario
from hunav_drake.scenario.error import Fault, ScenarioError, shown
from hunav_drake.scenario.named_files import behavior_sha256, files_sha256
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.layout import STATE_SIZE, is_outside
from hunav_drake.systems.common.plain_errors import ConfigError
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.trial_monitor import TrialStatus
from hunav_drake.trial.diagram import CheckTrialDiagram, MakeTrialDiagram
from hunav_drake.trial.end import explain_end
from hunav_drake.trial.interrupts import interrupts_between_steps
from hunav_drake.trial.planner_failure import (
    CheckCommand,
    IsOwnSystem,
    PlannerErrorOf,
)
from hunav_drake.trial.provenance import MakeProvenance
from hunav_drake.trial.result import EndReason, MakeTrialResult, TrialResult
from hunav_drake.trial.seeds import DrawSeed, GetTrialSeed, SetTrialSeed

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


def MakeTrialSimulator(
    diagram: Diagram,
    context: Context | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Simulator:
    """Makes a simulator that ends a trial at the goal, or when it is stuck.

    It ends at a whole time step, wherever runs stop and others go on.
    Once it has ended a trial, each further `AdvanceTo` goes on by one step.
    A broken planner raises a PlannerError from there.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: Where to go on from: a clone of a Context of this diagram; by
            default, the start. The simulator keeps it.
        progress: Called after each step with the time, in seconds.
    """
    if context is None:
        simulator = Simulator(diagram)
    else:
        _skip_done_updates(diagram, context)
        simulator = Simulator(diagram, context)
    status = diagram.GetOutputPort("trial_status")
    trial = diagram.GetSubsystemByName("monitor")
    is_own = IsOwnSystem(diagram)

    def monitor(root_context: Context) -> EventStatus:
        if progress is not None:
            progress(root_context.get_time())
        if is_own:
            CheckCommand(diagram, root_context)
        if not trial.IsStep(trial.GetMyContextFromRoot(root_context)):
            return EventStatus.DidNothing()
        value = TrialStatus(int(status.Eval(root_context)[0]))
        if value == TrialStatus.RUNNING:
            return EventStatus.DidNothing()
        message = _MESSAGES[_REASONS[value]]
        return EventStatus.ReachedTermination(diagram, message)

    simulator.set_monitor(monitor)
    return simulator


def _skip_done_updates(diagram: Diagram, context: Context) -> None:
    """Keeps a new simulator from repeating the updates of an instant.

    A simulator begins with those of the present instant. Where they are done,
    as after a second `AdvanceTo` to one time, it may begin just after it.
    """
    monitor = diagram.GetSubsystemByName("monitor")
    if monitor.HasUpdated(monitor.GetMyContextFromRoot(context)):
        present = context.get_time()
        context.SetTime(max(math.nextafter(present, math.inf), 1e-15))


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

    Several seeds of one scenario can share a diagram, which takes far longer
    to make than to reset, unless its people are drawn by the seed; the results
    are the same, bit for bit:

        diagram = MakeTrialDiagram(scenario)
        results = [RunTrial(scenario, s, diagram=diagram) for s in range(100)]

    Args:
        scenario: What happens.
        seed: Stands in for the scenario's own seed.
        diagram: From `MakeTrialDiagram(scenario)`, with the same `meshcat`,
            for whatever seed, but of a population without a seed of its own
            for this one; by default it is made.
        meshcat: Where to show the trial, and to record it for a replay.
        realtime_rate: How many times as fast as real time it runs at most; 0
            for as fast as it can.
        progress: Called after each step with the time, in seconds.
        watch: Called after each step with the Context, again and again until
            it returns true: so it can pause the trial. With it, browsers show
            the trial while it runs.
        on_planner_error: What is done about a planner that is broken, which
            raises an exception, gives no finite command, or takes longer than
            its `cycle_limit`. "end" ends the trial, with the end reason
            "planner_failed" and what came up to then; "raise" raises.

    Returns:
        The metrics, the recording, and why the trial ended.

    Raises:
        PlannerError: If the planner is broken, and it is to raise.
        ScenarioError: If the scenario cannot be simulated.
        ValueError: If the diagram was made from another scenario, or of people
            whom another seed has drawn.
    """
    if seed is not None:
        scenario = _reseed(scenario, seed)
    if diagram is None:
        diagram = MakeTrialDiagram(scenario, meshcat)
    else:
        CheckTrialDiagram(scenario, diagram)
    if scenario.evaluator.start == "by_trigger":
        fault = Fault(
            "RunTrial",
            0,
            "evaluator.start",
            "by_trigger waits for the input port trigger, which RunTrial()"
            " leaves unconnected; use MakeTrialDiagram(), or another start",
        )
        raise ScenarioError("RunTrial", [fault])
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
            # It refers to the simulator, which would keep itself alive.
            simulator.clear_monitor()
        if meshcat is not None:
            # Frames come at their own times; the last instant is one too.
            diagram.ForcedPublish(simulator.get_context())
    if failure is None:
        return GetTrialResult(scenario, diagram, simulator.get_context())
    return _result(
        *(scenario, diagram, simulator.get_context()),
        *("planner_failed", str(failure)),
    )


def MakeRandomSimulator(
    scenario: Scenario,
) -> Callable[[RandomGenerator], Simulator]:
    """Makes what draws trials for Drake's `MonteCarloSimulation`.

    Each simulator has a diagram of its own, of a seed that it draws from the
    generator, and ends its trial as `MakeTrialSimulator` does:

        results = MonteCarloSimulation(
            MakeRandomSimulator(scenario), output, final_time=60.0,
            num_samples=4, generator=RandomGenerator(1),
        )

    where `output(diagram, context)` gives a number; `GetTrialSeed` tells the
    seed there, with which `RunTrial` repeats the trial. `RunTrial` over several
    seeds of one diagram is faster.

    Args:
        scenario: What happens, but for its seed.

    Returns:
        A function that makes a Simulator of a trial, by a RandomGenerator.
    """

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
    scenario: Scenario, diagram: Diagram, context: Context
) -> TrialResult:
    """Returns what a trial has given up to the present of its Context.

    Args:
        scenario: What happens; its metrics are computed.
        diagram: From `MakeTrialDiagram(scenario)`.
        context: A Context of that diagram; its seed counts, not that of the
            scenario.

    Raises:
        ValueError: If the diagram was made from another scenario.
    """
    scenario = _reseed(scenario, GetTrialSeed(diagram, context))
    CheckTrialDiagram(scenario, diagram)
    (status,) = diagram.GetOutputPort("trial_status").Eval(context)
    reason = _REASONS[TrialStatus(int(status))]
    duration = scenario.simulation.duration
    if reason == "running" and context.get_time() >= duration * (1 - 1e-9):
        reason = "timeout"
    message = _end_message(reason, scenario, diagram, context)
    return _result(scenario, diagram, context, reason, message)


def _result(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    reason: EndReason,
    message: str,
) -> TrialResult:
    """Returns what a trial has given that ended for some reason."""
    recording = _recording_of(diagram, context)
    config = scenario.evaluator
    recording = dataclasses.replace(
        recording, hunavsim_forces=config.forces == "hunavsim"
    )
    return MakeTrialResult(
        recording.with_stale_samples(config.stale_samples, config.period),
        scenario_name=scenario.name,
        metric_names=scenario.evaluator.metrics,
        provenance=MakeProvenance(
            SaveScenario(scenario),
            seed=scenario.simulation.seed,
            planner=name_of(scenario.planner),
            behavior_sha256=behavior_sha256(scenario),
            files_sha256=files_sha256(scenario),
            drawn=drawn_by_seed(scenario),
        ),
        end_reason=reason,
        end_message=message,
        end_time=_time_of(context, recording),
    )


def _end_message(
    reason: EndReason, scenario: Scenario, diagram: Diagram, context: Context
) -> str:
    """Returns in words why a trial ended, with those of its planner."""
    parts = [_MESSAGES[reason]]
    if reason not in ("stuck", "timeout"):
        return parts[0]
    planner = diagram.GetSubsystemByName("planner")
    if hasattr(planner, "GetReason"):
        words = planner.GetReason(planner.GetMyContextFromRoot(context))
        parts += [f"the planner: {words}"] if words else []
    why = explain_end(_recording_until_now(diagram, context), scenario)
    return "; ".join([*parts, why] if why else parts)


def _recording_of(diagram: Diagram, context: Context) -> Recording:
    evaluator = diagram.GetSubsystemByName("evaluator")
    recording: Recording = evaluator.GetRecording(
        evaluator.GetMyContextFromRoot(context)
    )
    return recording


def _recording_until_now(diagram: Diagram, context: Context) -> Recording:
    """Returns a trial's recording, with the present also if it has ended."""
    recording = _recording_of(diagram, context)
    now = _time_of(context, recording)
    if recording.times[-1] == now:
        return recording
    rows = np.concatenate(
        [
            diagram.GetOutputPort(name).Eval(context)
            for name in ("robot_state", "human_states")
        ]
    ).reshape(-1, STATE_SIZE)
    rows[is_outside(rows)] = np.nan
    return dataclasses.replace(
        recording,
        times=np.append(recording.times, now),
        robot=np.vstack([recording.robot, rows[:1]]),
        humans=np.concatenate([recording.humans, rows[None, 1:]]),
        # How one ends has nothing to do with these.
        behavior_status=None,
        contacts=None,
        wall_contact=None,
        contact_forces_known=False,
    )


def _time_of(context: Context, recording: Recording) -> float:
    """Returns the present, that of the last sample to the bit if it is it.

    A simulator may begin just after an instant: see `_skip_done_updates`.
    """
    last, now = float(recording.times[-1]), context.get_time()
    return (
        last if math.isclose(last, now, rel_tol=1e-12, abs_tol=1e-12) else now
    )


def _recording(
    diagram: Diagram, meshcat: "Meshcat | None", *, live: bool
) -> AbstractContextManager[None]:
    """Returns what records a trial for a replay, if it is shown at all."""
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
}

_MESSAGES: dict[EndReason, str] = {
    "running": "the trial is not over",
    "timeout": "the time is over",
    "goal": "the robot has reached its goal",
    "stuck": "the robot no longer gets anywhere",
}
