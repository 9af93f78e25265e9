"""The LeafSystem that records a trial."""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import count_steps
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    REPLAY_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
    YAW,
    Contact,
    is_outside,
)
from hunav_drake.systems.common.ports import CopyOf, GoalOf, weakly
from hunav_drake.systems.common.poses import is_at_goal
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.evaluation.recording import Recording, describe_people
from hunav_drake.systems.evaluation.running_metrics import (
    RunningMetric,
    running_values,
)
from hunav_drake.systems.evaluation.samples import Sample, recorded
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

# Time differences from rounding alone, as a fraction of the time step.
_SAME_INSTANT = 1e-6

# Elements of the discrete state; the goal is between them.
_HAS_ENDED = 0
_TRIGGER_WAS_HIGH = 4
_NO_GOAL = (np.nan, np.nan, np.nan)


class Evaluator(LeafSystem):
    """Records robot and people for the computation of metrics.

    .. pydrake_system::

        name: Evaluator
        input_ports:
        - robot_state
        - human_states (optional without people)
        - behavior_status (optional)
        - contacts (optional)
        - wall_contact (optional)
        - goal (optional)
        - replay (optional)
        - trigger (optional)
        - social_signals (optional)
        output_ports:
        - metrics
        - recording

    Port ``robot_state`` takes the robot's row (x, y, yaw, vx, vy, omega,
    radius) in W, in SI units and radians, and ``human_states`` the rows of the
    ``n`` people, one after the other; a row of NaN is a missing person, and so
    is one of `layout.OUTSIDE`, which is recorded as a row of NaN. Port
    ``behavior_status`` takes ``n`` numbers that are 0 where a person's behavior
    does not react to the robot, ``contacts`` ``n`` rows of `layout.Contact`,
    and ``wall_contact`` one such row of the walls. Port ``replay`` takes n rows
    of `layout.REPLAY_SIZE`, and ``social_signals`` n rows of `layout.Signal`.
    Port ``goal`` takes the goal pose (x, y, yaw); if it is not connected or not
    finite, there is no goal.

    The recording begins as `EvaluatorConfig.start` says: "at_once";
    "at_goal_command", when ``goal`` is first finite; or "by_trigger", when port
    ``trigger`` first exceeds 0.5. It ends for good with the first sample at the
    goal, if ``stop_at_goal``; with the first sample at least ``timeout`` after
    the first one; and in each case when ``trigger``, if connected, falls from
    above 0.5 to at most 0.5.

    Port ``metrics`` gives running values at the last sample, in the order of
    `RunningMetric`, NaN for none; ``recording`` gives the result of
    `GetRecording`.

    The abstract state is the list of samples so far. The discrete state is 1
    once the recording has ended, the goal (x, y, yaw) at that instant, or NaN,
    and 1 if ``trigger`` was high at the last sample. They are updated at the
    multiples of ``period``, before any other change at that instant, and only
    once per instant, even if its events are repeated. Further groups hold the
    time of the last time step whose updates are done, and the peak forces until
    then, if forces are computed. Multiples of a period do not always fall on
    the same floating-point instants. So the update runs at the common time step
    and counts, except where ``period`` is the step times a power of two, which
    is exact.
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        *,
        config: EvaluatorConfig | None = None,
        time_step: float = 0.05,
        goal_tolerance: float = 0.25,
        goal_yaw_tolerance: float = 0.25,
        robot_max_speed: float | None = None,
        obstacles: Obstacles | None = None,
        feels_forces: bool = False,
    ) -> None:
        """Constructs an Evaluator.

        Args:
            humans: The people, in the order of ``human_states``; may be empty.
                People without a name or a number get those of `people_names`
                and `people_ids`.
            config: The part of the trial to record, and how often.
            time_step: The common time step of all systems, in seconds.
            goal_tolerance: The distance at which the goal counts as reached, in
                meters.
            goal_yaw_tolerance: The same for the heading, in radians.
            robot_max_speed: The maximum speed of the robot, in m/s, if it is
                known.
            obstacles: The walls, for the metrics of forces.
            feels_forces: Whether the forces of ``contacts`` are computed.

        Raises:
            ValueError: If the period is not a multiple of ``time_step``, a
                number is not positive, or two people have the same number.
        """
        super().__init__()
        self._config = config or EvaluatorConfig()
        self._every = count_steps(self._config.period, time_step)
        self._time_step = time_step
        self._static: dict[str, Any] = {
            **describe_people(humans),
            "goal_tolerance": goal_tolerance,
            "goal_yaw_tolerance": goal_yaw_tolerance,
            "robot_max_speed": robot_max_speed,
            "obstacles": obstacles or Obstacles.from_points([]),
        }
        self._feels_forces = feels_forces
        self._n = len(humans)
        declare = self.DeclareVectorInputPort
        self._robot_state = declare("robot_state", STATE_SIZE)
        self._human_states = declare("human_states", STATE_SIZE * self._n)
        self._behavior_status = declare("behavior_status", self._n)
        self._contacts = declare("contacts", CONTACT_SIZE * self._n)
        self._wall_contact = declare("wall_contact", CONTACT_SIZE)
        self._goal = declare("goal", 3)
        self._replay = declare("replay", REPLAY_SIZE * self._n)
        self._trigger = declare("trigger", 1)
        self._signals = declare("social_signals", SIGNAL_SIZE * self._n)
        self._samples = self.DeclareAbstractState(
            AbstractValue.Make(Sample.start(self._n))
        )
        # (Numbers are found faster by an integer than by a typed index.)
        self._window = int(self.DeclareDiscreteState([0.0, *_NO_GOAL, 0.0]))
        self._updated = int(self.DeclareDiscreteState([-math.inf]))
        if feels_forces:
            self._peaks = int(self.DeclareDiscreteState(self._n))
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._Update)
        self._DeclareOutputs()
        exact = self._every & (self._every - 1) == 0
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            time_step * (self._every if exact else 1), 0.0, self._TakeSample
        )

    def _DeclareOutputs(self) -> None:
        # Invalid settings raise here, not at the end of a trial.
        nothing = Recording(
            times=np.zeros(1),
            robot=np.zeros((1, STATE_SIZE)),
            humans=np.zeros((1, self._n, STATE_SIZE)),
            **self._static,
        )
        self._metrics = self.DeclareVectorOutputPort(
            "metrics",
            len(RunningMetric),
            self._CalcMetrics,
            prerequisites_of_calc={
                self.abstract_state_ticket(self._samples),
                self.discrete_state_ticket(DiscreteStateIndex(self._window)),
                self.input_port_ticket(self._goal.get_index()),
            },
        )
        self._recording = self.DeclareAbstractOutputPort(
            "recording",
            alloc=lambda: AbstractValue.Make(nothing),
            calc=weakly(self._CalcRecording),
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port that takes the robot's row."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port that takes the rows of people."""
        return self._human_states

    def get_behavior_status_input_port(self) -> InputPort:
        """Returns the port that takes the status of each behavior."""
        return self._behavior_status

    def get_contacts_input_port(self) -> InputPort:
        """Returns the port that takes the contacts of robot and people."""
        return self._contacts

    def get_wall_contact_input_port(self) -> InputPort:
        """Returns the port that takes the contact of robot and walls."""
        return self._wall_contact

    def get_goal_input_port(self) -> InputPort:
        """Returns the port that takes the goal pose."""
        return self._goal

    def get_replay_input_port(self) -> InputPort:
        """Returns the port that takes the rows of recorded people."""
        return self._replay

    def get_trigger_input_port(self) -> InputPort:
        """Returns the port that ends the recording, and may begin it."""
        return self._trigger

    def get_metrics_output_port(self) -> OutputPort:
        """Returns the port with the running values."""
        return self._metrics

    def get_recording_output_port(self) -> OutputPort:
        """Returns the port with the recording until now."""
        return self._recording

    def GetRecording(self, context: Context) -> Recording:
        """Returns the recording until now.

        If the context's time is a multiple of the time step and later than the
        last sample, and the recording has not ended, the current instant is
        added as the last sample, so that the end of a trial is always recorded.
        (Between two steps, and after the updates of an instant, states belong
        to the next step.) The goal is that of the current instant, or of the
        end of the recording.

        Raises:
            RuntimeError: If ``robot_state`` is not connected, ``human_states``
                is not connected although there are people, or the recording has
                not begun.
            ValueError: If a state is not finite.
        """
        self.ValidateContext(context)
        last = context.get_abstract_state(self._samples).get_value()
        window = context.get_discrete_state(self._window).value()
        if self._IsPresent(context) and self._IsOn(context, last, window):
            last = self._Sample(context, last)
        if not last.count:
            waits = self._config.start == "at_goal_command"
            port = "goal" if waits else "trigger"
            raise RuntimeError(
                f"{self.GetSystemPathname()}: nothing has been recorded by t ="
                f" {context.get_time():g} s; it waits for its port {port!r}"
            )
        arrays = last.to_arrays()
        return Recording(
            **recorded(arrays, self._n),
            contact_forces_known=self._feels_forces and "contacts" in arrays,
            goal=self._GetGoal(context),
            **self._static,
        )

    def CheckGoesOn(self, context: Context) -> None:
        """Checks that there is a recording from this instant on.

        Raises:
            ValueError: If it has ended before, or not begun.
        """
        self.ValidateContext(context)
        last = context.get_abstract_state(self._samples).get_value()
        window = context.get_discrete_state(self._window).value()
        told = f"nothing is recorded from {context.get_time():g} s on"
        if window[_HAS_ENDED] and self._IsLater(context, last):
            raise ValueError(
                f"{told}: the recording ended at {last.time:g} s; take an"
                " earlier instant, a longer evaluator.timeout, or"
                " evaluator.stop_at_goal=false"
            )
        waits = self._config.start == "by_trigger" and not last.count
        if waits and not (
            self._trigger.HasValue(context) and self._IsTriggerHigh(context)
        ):
            raise ValueError(
                f"{told}: the input port trigger is not high; set it, or take"
                " another evaluator.start"
            )

    def _Sample(self, context: Context, last: Sample) -> Sample:
        # (New arrays, so that the sample can keep them.)
        status, replay, signals = (
            CopyOf(it, context) if it.HasValue(context) else None
            for it in (self._behavior_status, self._replay, self._signals)
        )
        return Sample(
            previous=last,
            time=context.get_time(),
            robot=CopyOf(self._robot_state, context),
            humans=self._EvalHumans(context) if self._n else np.zeros(0),
            status=status,
            contacts=self._EvalContacts(context),
            replay=replay,
            social_signals=signals,
        )

    def _EvalContacts(self, context: Context) -> Array | None:
        """Returns the rows of contacts, with the peak forces until now."""
        if not self._contacts.HasValue(context):
            return None
        contacts: Array = CopyOf(self._contacts, context)
        if self._feels_forces:
            rows = contacts.reshape(-1, CONTACT_SIZE)
            # (A contact that ended before the recording began does not count.)
            rows[:, Contact.PEAK_FORCE] = np.maximum(
                rows[:, Contact.PEAK_FORCE] * (rows[:, Contact.LASTS] > 0),
                context.get_discrete_state(self._peaks).value(),
            )
        if self._wall_contact.HasValue(context):
            wall = self._wall_contact.EvalBasicVector(context).value()
            contacts = np.concatenate([contacts, wall])
        return contacts

    def _Update(self, context: Context, state: DiscreteValues) -> None:
        now = context.get_time()
        state.get_mutable_vector(self._updated).SetAtIndex(0, now)
        if not self._feels_forces:
            return
        last = context.get_abstract_state(self._samples).get_value()
        window = context.get_discrete_state(self._window).value()
        if last.count and not window[_HAS_ENDED]:
            contacts = self._EvalContacts(context)
            if contacts is not None:
                peaks = contacts[Contact.PEAK_FORCE :: CONTACT_SIZE]
                state.set_value(self._peaks, peaks[: self._n])

    def _EvalHumans(self, context: Context) -> Array:
        """Returns the rows of people, NaN for people outside."""
        humans: Array = CopyOf(self._human_states, context)
        rows = humans.reshape(-1, STATE_SIZE)
        outside = is_outside(rows)
        if outside.any():
            rows[outside] = np.nan
        return humans

    def _TakeSample(self, context: Context, state: State) -> None:
        if round(context.get_time() / self._time_step) % self._every:
            return
        last = context.get_abstract_state(self._samples).get_value()
        window = context.get_discrete_state(self._window).value()
        if window[_HAS_ENDED] or not self._IsLater(context, last):
            return
        was_high = 0.0
        if self._IsOn(context, last, window):
            last = self._Sample(context, last)
            state.get_mutable_abstract_state(self._samples).set_value(last)
            ends = self._IsLast(context, last)
            if self._trigger.HasValue(context):
                was_high = float(self._IsTriggerHigh(context))
        else:
            ends = last.count > 0
        if ends:
            goal = self._EvalGoal(context) or _NO_GOAL
            state.get_mutable_discrete_state(self._window).set_value(
                [1.0, *goal, 0.0]
            )
        elif was_high != window[_TRIGGER_WAS_HIGH]:
            changed = state.get_mutable_discrete_state(self._window)
            changed[_TRIGGER_WAS_HIGH] = was_high

    def _IsLater(self, context: Context, last: Sample) -> bool:
        """Returns whether the current instant is later than a sample."""
        now = context.get_time()
        return bool(now > last.time + _SAME_INSTANT * self._time_step)

    def _IsPresent(self, context: Context) -> bool:
        """Returns whether states belong to the current step, not the next."""
        now, same = context.get_time(), _SAME_INSTANT * self._time_step
        (updated,) = context.get_discrete_state(self._updated).value()
        is_step = abs(math.remainder(now, self._time_step)) <= same
        return is_step and not 0 <= now - updated <= same

    def _IsTriggerHigh(self, context: Context) -> bool:
        return bool(self._trigger.Eval(context) > 0.5)

    def _IsOn(self, context: Context, last: Sample, window: Array) -> bool:
        """Returns whether the current instant must be recorded."""
        if window[_HAS_ENDED] or not self._IsLater(context, last):
            return False
        if self._config.start == "by_trigger":
            return self._IsTriggerHigh(context)
        was_high = window[_TRIGGER_WAS_HIGH] and self._trigger.HasValue(context)
        if was_high and not self._IsTriggerHigh(context):
            return False
        if self._config.start == "at_goal_command" and not last.count:
            return self._EvalGoal(context) is not None
        return True

    def _IsLast(self, context: Context, sample: Sample) -> bool:
        """Returns whether the recording ends with a sample of this instant."""
        elapsed = sample.time - sample.first_time
        timeout = self._config.timeout or math.inf
        if elapsed >= timeout - _SAME_INSTANT * self._time_step:
            return True
        goal = self._EvalGoal(context) if self._config.stop_at_goal else None
        return goal is not None and bool(
            is_at_goal(
                tuple(sample.robot[: YAW + 1].tolist()),
                goal,
                tolerance=self._static["goal_tolerance"],
                yaw_tolerance=self._static["goal_yaw_tolerance"],
            )
        )

    def _GetGoal(self, context: Context) -> tuple[float, float, float] | None:
        """Returns the goal of the recording."""
        window = context.get_discrete_state(self._window).value()
        if not window[_HAS_ENDED]:
            return self._EvalGoal(context)
        _, x, y, yaw, _ = window.tolist()
        return (x, y, yaw) if math.isfinite(x) else None

    def _EvalGoal(self, context: Context) -> tuple[float, float, float] | None:
        return GoalOf(self._goal, context)

    def _CalcMetrics(self, context: Context, output: BasicVector) -> None:
        last = context.get_abstract_state(self._samples).get_value()
        output.SetFromVector(running_values(last, self._GetGoal(context)))

    def _CalcRecording(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self.GetRecording(context))
